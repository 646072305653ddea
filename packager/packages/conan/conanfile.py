"""The recipe of the libraries for Conan 2: conan create packager/packages/conan [-o "&:bake=True"] in a clone or in the unpacked archive
of the source. Not run where this project is developed."""

import os

from conan import ConanFile
from conan.errors import ConanInvalidConfiguration
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load

required_conan_version = ">=2.0"


class FaceBakerRecipe(ConanFile):
    name = "facebaker"
    description = "Poses baked facial rigs (.fbk) in microseconds, with the same bits on every machine; and bakes them"
    license = "Apache-2.0"
    topics = ("animation", "face", "facial-rig", "blendshapes")
    package_type = "library"
    settings = "os", "arch", "compiler", "build_type"
    # bake: libfacebaker_bake as well, which makes archives, on Linux. openmp: batches and baking in parallel.
    options = {"shared": [True, False], "fPIC": [True, False], "bake": [True, False], "openmp": [True, False]}
    default_options = {"shared": True, "fPIC": True, "bake": False, "openmp": False}
    implements = ["auto_shared_fpic"]

    def set_version(self):
        self.version = load(self, os.path.join(self.recipe_folder, "..", "..", "..", "VERSION")).strip()

    def export_sources(self):
        root = os.path.abspath(os.path.join(self.recipe_folder, "..", "..", ".."))
        for pattern in ("CMakeLists.txt", "VERSION", "LICENSE", "core/*", "capi/*", "packager/packages/*",
                        "tests/conformance/fbk_*.py"):  # the reader, which is in bags
            copy(self, pattern, src=root, dst=self.export_sources_folder)

    def requirements(self):
        self.requires("zlib/[>=1.2.11 <2]")
        self.requires("xxhash/[>=0.8 <1]")
        if self.options.bake:
            self.requires("draco/[>=1.5 <2]")
            self.requires("eigen/[>=3.4 <6]")
            self.requires("meshoptimizer/[>=0.18 <2]")
            self.requires("nlohmann_json/[>=3.11 <4]")
            self.requires("openssl/[>=3.0 <4]")
            self.requires("tinygltf/[>=2.7 <3]")
            self.requires("utf8proc/[>=2.5 <3]")

    def validate(self):
        check_min_cppstd(self, 20)
        if self.options.bake and self.settings.os != "Linux":
            raise ConanInvalidConfiguration("baking is for Linux: leave the option bake out")
        if self.settings.compiler == "msvc":
            raise ConanInvalidConfiguration("cl has no vector types: use clang-cl, compiler=clang in the profile")

    def layout(self):
        cmake_layout(self)

    def generate(self):
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables["FB_RUNTIME_ONLY"] = not self.options.bake
        toolchain.cache_variables["FB_OPENMP"] = bool(self.options.openmp)
        for option in ("FB_TOOL", "FB_SAMPLES", "FB_TESTS"):
            toolchain.cache_variables[option] = False
        if self.options.bake:  # which has headers alone, and no package that CMake looks for
            folder = self.dependencies["tinygltf"].cpp_info.includedirs[0]
            toolchain.extra_cxxflags.append(f"-isystem{folder}")
        toolchain.generate()
        CMakeDeps(self).generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, "LICENSE", src=self.source_folder, dst=os.path.join(self.package_folder, "licenses"))
        CMake(self).install()

    def package_info(self):
        self.cpp_info.set_property("cmake_file_name", "FaceBaker")
        names = ["facebaker", "facebaker_bake"] if self.options.bake else ["facebaker"]
        for name in names:
            component = self.cpp_info.components[name]
            component.set_property("cmake_target_name", f"FaceBaker::{name}")
            component.set_property("pkg_config_name", name)
            component.libs = [name]
            component.requires = ["zlib::zlib", "xxhash::xxhash"]
            if name == "facebaker_bake":
                component.requires += ["draco::draco", "eigen::eigen", "meshoptimizer::meshoptimizer",
                                       "nlohmann_json::nlohmann_json", "openssl::crypto", "tinygltf::tinygltf",
                                       "utf8proc::utf8proc"]
            if not self.options.shared:
                component.defines = ["FB_STATIC"]
            if self.settings.os in ("Linux", "FreeBSD"):
                component.system_libs = ["m", "pthread", "dl"]
