"""The wheel: its contents, and a bake after it was installed offline into a virtual environment without a compiler."""

import base64
import csv
import hashlib
import io
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import zipfile

try:
    import numpy  # noqa: F401
    import pip  # noqa: F401
    import tomllib  # noqa: F401
    import venv  # noqa: F401
except ImportError as error:
    raise unittest.SkipTest(f"{error.name} is not installed")

PROJECT = pathlib.Path(__file__).parents[1]
ROOT = PROJECT.parents[1]
LIBRARIES = pathlib.Path(os.environ["FACEBAKER_LIBRARY"]).parent
BAKE = """
import sys
import numpy as np
import facebaker
assert facebaker.__file__.startswith(sys.prefix), facebaker.__file__
rest = np.random.default_rng(1).normal(size=(40, 3))
rig = facebaker.Rig(["lift"], lambda controls: rest + controls[:, :, None] * [0, 1, 0], rest_positions=rest)
print(facebaker.__version__, facebaker.bake(rig, "face.fbk", use="variant", poses=50).load().vertex_count)
"""

# Of the standard library, what takes more than a few milliseconds to import, and what serves or starts processes.
SLOW = set("asyncio concurrent email http logging multiprocessing socket ssl unittest urllib xml".split())


def clean_environment(**variables):
    """Without what points to this tree, and without programs."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith(("FACEBAKER", "PYTHON", "CC"))}
    return {**kept, "PATH": "/nowhere", "OMP_WAIT_POLICY": "PASSIVE", **variables}


class WheelTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        setting = f"libraries={LIBRARIES}"
        cls.pip("wheel", "--no-deps", "--config-settings", setting, "-w", cls.folder.name, str(PROJECT))
        (cls.wheel,) = pathlib.Path(cls.folder.name).glob("*.whl")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @staticmethod
    def pip(command, *words, python=sys.executable):
        quiet = ["--quiet", "--disable-pip-version-check", "--no-input", "--isolated"]
        line = [sys.executable, "-m", "pip", "--python", python, *quiet, command, "--no-index", *words]
        result = subprocess.run(line, capture_output=True, text=True)
        assert result.returncode == 0, result.stdout + result.stderr

    def test_its_name_says_where_it_runs(self):
        version = (ROOT / "VERSION").read_text().strip()
        self.assertRegex(
            self.wheel.name, rf"^facebaker-{re.escape(version)}-py3-none-(manylinux_2_\d+|linux)_\w+\.whl$"
        )

    def test_its_contents(self):
        with zipfile.ZipFile(self.wheel) as wheel:
            files = {name: wheel.read(name) for name in wheel.namelist()}
        information = next(name.split("/")[0] for name in files if ".dist-info/" in name)
        rows = {row[0]: row[1:] for row in csv.reader(io.StringIO(files[f"{information}/RECORD"].decode()))}
        self.assertEqual(set(rows), set(files))
        for name, (digest, size) in rows.items():
            if digest:
                sha = base64.urlsafe_b64encode(hashlib.sha256(files[name]).digest()).rstrip(b"=").decode()
                self.assertEqual((digest, size), (f"sha256={sha}", str(len(files[name]))))
        for name in "libfacebaker.so", "libfacebaker_bake.so":
            self.assertEqual(files[f"facebaker/{name}"], (LIBRARIES / name).read_bytes())
        sources = {f"facebaker/{path.name}" for path in (PROJECT / "facebaker").glob("*.py")}
        self.assertLessEqual(sources | {"facebaker/py.typed"}, set(files))
        self.assertEqual(files[f"{information}/LICENSE"], (ROOT / "LICENSE").read_bytes())
        self.assertIn("\nDraco ", files[f"{information}/licenses/THIRD-PARTY.txt"].decode())
        bill = json.loads(files[f"{information}/sboms/facebaker.spdx.json"])
        named = {package["name"] for package in bill["packages"]}
        self.assertLessEqual({"libfacebaker", "libfacebaker_bake", "zlib", "Draco", "Eigen"}, named)
        metadata = files[f"{information}/METADATA"].decode()
        self.assertIn("\nRequires-Dist: numpy>=", metadata)
        self.assertIn("# FaceBaker for Python", metadata)

    def test_it_bakes_where_there_is_no_compiler(self):
        with tempfile.TemporaryDirectory() as folder:
            # Without pip: that of the system installs into it.
            made = [sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", folder]
            subprocess.run(made, check=True)
            python = os.path.join(folder, "bin", "python3")
            self.pip("install", str(self.wheel), python=python)
            run = subprocess.run(
                [python, "-c", BAKE], cwd=folder, env=clean_environment(), capture_output=True, text=True
            )
            version = (ROOT / "VERSION").read_text().strip()
            self.assertEqual(run.stdout, f"{version} 40\n", run.stderr)

    def test_the_same_tree_gives_the_same_bytes(self):
        with tempfile.TemporaryDirectory() as folder:
            program = (
                f"import facebaker_wheel; facebaker_wheel.build_wheel({folder!r}, {{'libraries': {str(LIBRARIES)!r}}})"
            )
            environment = {**os.environ, "PYTHONPATH": str(PROJECT / "wheel"), "PYTHONDONTWRITEBYTECODE": "1"}
            subprocess.run([sys.executable, "-c", program], check=True, env=environment)
            self.assertEqual(pathlib.Path(folder, self.wheel.name).read_bytes(), self.wheel.read_bytes())

    def test_wheels_of_other_platforms_carry_the_runtime_alone(self):
        version = (ROOT / "VERSION").read_text().strip()
        for platform, file, tag in (
            ("linux-arm64", "libfacebaker.so", r"manylinux_2_34_aarch64"),
            ("windows-x64", "facebaker.dll", "win_amd64"),
            ("macos", "libfacebaker.dylib", "macosx_11_0_universal2"),
        ):
            with self.subTest(platform=platform), tempfile.TemporaryDirectory() as folder:
                library = pathlib.Path(folder, file)
                library.write_bytes(f"made up {platform}\0GLIBC_2.34\0{version}\0".encode())
                self.assertEqual(self.build(folder, platform, folder), (0, ""))
                (wheel,) = pathlib.Path(folder).glob("*.whl")
                self.assertEqual(wheel.name, f"facebaker-{version}-py3-none-{tag}.whl")
                with zipfile.ZipFile(wheel) as opened:
                    binaries = {name for name in opened.namelist() if not name.endswith(".py") and "dist-info" not in name}
                    self.assertEqual(binaries, {f"facebaker/{file}", "facebaker/py.typed"})
                    self.assertEqual(opened.read(f"facebaker/{file}"), library.read_bytes())
                    third = opened.read(f"facebaker-{version}.dist-info/licenses/THIRD-PARTY.txt").decode()
                    self.assertIn("\nzlib ", third)
                    self.assertNotIn("\nDraco ", third)
                library.write_bytes(b"made up\x001.0.0\0")
                self.assertIn(f"{file}: is not of version {version}", self.build(folder, platform, folder)[1])
        self.assertIn("platform is one of linux-arm64", self.build(self.folder.name, "amiga", self.folder.name)[1])
        self.assertIn("there is no ", self.build(self.folder.name, "macos", self.folder.name)[1])

    @staticmethod
    def build(libraries, platform, out):
        """The exit code of building the wheel of another platform, and what was said."""
        settings = {"libraries": libraries, "platform": platform}
        program = f"import facebaker_wheel; facebaker_wheel.build_wheel({out!r}, {settings!r})"
        environment = {**os.environ, "PYTHONPATH": str(PROJECT / "wheel"), "PYTHONDONTWRITEBYTECODE": "1"}
        run = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True)
        return run.returncode, run.stderr

    def test_libraries_that_are_not_there(self):
        program = "import facebaker_wheel; facebaker_wheel.build_wheel('.')"
        environment = {**os.environ, "PYTHONPATH": str(PROJECT / "wheel"), "PYTHONDONTWRITEBYTECODE": "1"}
        environment["FACEBAKER_LIBRARIES"] = self.folder.name
        run = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True)
        self.assertEqual(run.returncode, 1)
        self.assertIn("there is no libfacebaker.so", run.stderr)


class ImportTest(unittest.TestCase):
    def test_importing_opens_no_library_and_little_else(self):
        program = "import sys, facebaker, facebaker.serve; print('libfacebaker' in open('/proc/self/maps').read())"
        environment = {**os.environ, "FACEBAKER_LIBRARY": "/nowhere/libfacebaker.so"}
        result = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True)
        self.assertEqual(result.stdout, "False\n", result.stderr)
        program = "import sys, numpy.typing; known = set(sys.modules); import facebaker; print(*sys.modules.keys() - known)"
        result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
        others = {name.split(".")[0] for name in result.stdout.split()} - {"facebaker", "numpy"}
        self.assertLessEqual(others, sys.stdlib_module_names)
        self.assertEqual(others & SLOW, set())


if __name__ == "__main__":
    unittest.main()
