"""The recipes for vcpkg and Conan, as far as they can be looked at without either: that what they take from packages is what
third_party.json says is in the libraries, and that they set options that the build has. The recipe for Conan runs over stubs."""

import importlib.util
import json
import pathlib
import re
import sys
import types
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGES = ROOT / "packager" / "packages"
# How other systems of packages call what third_party.json names, where it is not its name in small letters.
VCPKG = {"Eigen": "eigen3"}
CONAN = {"nlohmann-json": "nlohmann_json"}


def linked_into(library, names):
    components = json.loads((PACKAGES / "third_party.json").read_text(encoding="utf-8"))
    return {names.get(one["name"], one["name"].lower()) for one in components if library in one["in"]}


def options_of_the_build():
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    return set(re.findall(r"^option\((FB_\w+)", text, flags=re.M))


def stub_conan(records):
    """Modules that stand for Conan's; the variables that a recipe gives to CMake go into records."""

    class ConanFile:
        def requires(self, reference):
            self.required.add(reference.partition("/")[0])

    class Recorder:
        def __init__(self, recipe):
            self.cache_variables, self.extra_cxxflags = records, []

        def generate(self):
            pass

    def load(recipe, path):
        return pathlib.Path(path).read_text(encoding="utf-8")

    contents = {
        "conan": {"ConanFile": ConanFile}, "conan.errors": {"ConanInvalidConfiguration": RuntimeError}, "conan.tools": {},
        "conan.tools.build": {"check_min_cppstd": lambda recipe, least: None},
        "conan.tools.cmake": {"CMake": Recorder, "CMakeDeps": Recorder, "CMakeToolchain": Recorder, "cmake_layout": None},
        "conan.tools.files": {"copy": None, "load": load},
    }
    modules = {name: types.ModuleType(name) for name in contents}
    for name, module in modules.items():
        vars(module).update(contents[name])
    return modules


class RecipesTest(unittest.TestCase):
    def conan(self, bake, system="Linux"):
        """The recipe with its options set, and what it gives to CMake."""
        records = {}
        modules = stub_conan(records)
        sys.modules.update(modules)
        self.addCleanup(lambda: [sys.modules.pop(name, None) for name in modules])
        place = importlib.util.spec_from_file_location("conan_recipe", PACKAGES / "conan" / "conanfile.py")
        module = importlib.util.module_from_spec(place)
        place.loader.exec_module(module)
        recipe = module.FaceBakerRecipe()
        recipe.recipe_folder, recipe.required = str(PACKAGES / "conan"), set()
        recipe.options = types.SimpleNamespace(bake=bake, openmp=False, shared=True)
        recipe.settings = types.SimpleNamespace(os=system, compiler="gcc")
        headers = types.SimpleNamespace(cpp_info=types.SimpleNamespace(includedirs=["headers"]))
        recipe.dependencies = {"tinygltf": headers}
        return recipe, records

    def test_vcpkg_depends_on_what_is_linked(self):
        port = json.loads((PACKAGES / "vcpkg" / "vcpkg.json.in").read_text(encoding="utf-8").replace("@VERSION@", "1.2"))
        names = {one for one in port["dependencies"] if isinstance(one, str)}
        self.assertEqual(names, linked_into("facebaker", VCPKG))
        self.assertEqual(names | set(port["features"]["bake"]["dependencies"]), linked_into("facebaker_bake", VCPKG))
        self.assertEqual(port["version"], "1.2")

    def test_vcpkg_sets_options_that_there_are(self):
        text = (PACKAGES / "vcpkg" / "portfile.cmake").read_text(encoding="utf-8")
        options = set(re.findall(r"FB_\w+", text))
        self.assertEqual(options, {"FB_OPENMP", "FB_RUNTIME_ONLY", "FB_TOOL", "FB_SAMPLES", "FB_TESTS"})
        self.assertLessEqual(options, options_of_the_build())

    def test_conan_depends_on_what_is_linked(self):
        for bake, library in ((False, "facebaker"), (True, "facebaker_bake")):
            recipe, _ = self.conan(bake)
            recipe.requirements()
            self.assertEqual(recipe.required, linked_into(library, CONAN))

    def test_conan_sets_options_that_there_are(self):
        recipe, given = self.conan(bake=True)
        recipe.generate()
        self.assertLessEqual(set(given), options_of_the_build())
        self.assertEqual(given, {"FB_RUNTIME_ONLY": False, "FB_OPENMP": False, "FB_TOOL": False, "FB_SAMPLES": False, "FB_TESTS": False})

    def test_conan_knows_the_version_and_where_it_bakes(self):
        recipe, _ = self.conan(bake=True)
        recipe.set_version()
        self.assertEqual(recipe.version, (ROOT / "VERSION").read_text(encoding="utf-8").strip())
        recipe.validate()
        with self.assertRaisesRegex(RuntimeError, "baking is for Linux"):
            self.conan(bake=True, system="Windows")[0].validate()
        self.conan(bake=False, system="Windows")[0].validate()


if __name__ == "__main__":
    unittest.main()
