"""The zip that is given to users: installed, baked with, previewed; in_blender.py runs it."""

import os
import pathlib
import runpy
import shutil
import subprocess
import tempfile
import tomllib
import unittest
import zipfile

import bpy
from addon_support import add_action
from blender_scenes import shape_key_scene

from facebaker_blender.bake_job import this_blender
from facebaker_blender.tool_command import find_tool

HERE = pathlib.Path(__file__).resolve().parent
VERSION = (HERE.parents[2] / "VERSION").read_text().strip()
EXTENSIONS = bpy.app.version >= (4, 2, 0)
# Without its window, in a Blender in which the add-on is enabled: the file's preview follows the rig.
FOLLOW = """
import bpy
import numpy as np
preview = next(o for o in bpy.context.scene.objects if "facebaker_archive" in o.keys())
def points():
    found = np.empty(3 * len(preview.data.vertices), np.float32)
    preview.data.vertices.foreach_get("co", found)
    return found
before = points()
bpy.data.objects["face"].data.shape_keys.key_blocks["smile.L"].value = 1
bpy.context.view_layer.update()
print("moved by", np.abs(points() - before).max())
"""


class PackedTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="facebaker-zip-"))
        cls.packed = cls.folder / "facebaker_blender.zip"
        build = pathlib.Path(find_tool()).parents[1]
        words = ["/usr/bin/python3", HERE.parent / "make_addon.py", build, cls.packed]
        subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
        # Nothing of this tree, nor of the system's FaceBaker, is to be found.
        kept = {key: value for key, value in os.environ.items() if not key.startswith(("FACEBAKER", "PYTHON", "LD_"))}
        cls.environment = {**kept, "PATH": "/nowhere", "BLENDER_USER_RESOURCES": str(cls.folder / "user")}
        (cls.folder / "user" / "config").mkdir(parents=True)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def blender(self, *words, **environment):
        command = [this_blender().program, *map(str, words)]
        environment = {**self.environment, **environment}
        done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=400)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def test_its_manifest_is_valid(self):
        with zipfile.ZipFile(self.packed) as packed:
            manifest = tomllib.loads(packed.read("facebaker_blender/blender_manifest.toml").decode())
            for name in "LICENSE", "THIRD-PARTY.txt", "facebaker.spdx.json":
                self.assertIn(f"facebaker_blender/{name}", packed.namelist())
        self.assertEqual((manifest["version"], manifest["license"]), (VERSION, ["SPDX:Apache-2.0"]))
        if not EXTENSIONS:
            self.skipTest("this Blender has no extensions, so it validates none")
        printed = self.blender("--command", "extension", "validate", self.packed)
        self.assertNotIn("rror", printed)
        self.assertNotIn("arning", printed)

    def test_the_viewer_is_packed_where_it_is_built(self):
        build = pathlib.Path(find_tool()).parents[1]
        if not (build / "bin" / "facebaker-view").is_file():
            self.skipTest("the tool was built without its web server")
        names = {}
        for folder in "without", "with":
            beside = self.folder / folder
            beside.mkdir()
            (beside / "build").symlink_to(build)
            if folder == "with":
                (beside / "viewer" / "assets").mkdir(parents=True)
                for name in "index.html", "assets/page.js":
                    (beside / "viewer" / name).write_text("FaceBaker viewer")
            files = runpy.run_path(str(HERE.parent / "make_addon.py"))["addon_files"](beside / "build")
            names[folder] = {name.partition("/carried/")[2] for name in files}
        self.assertLessEqual(
            {"bin/facebaker-view", "share/facebaker/viewer/index.html", "share/facebaker/viewer/assets/page.js"},
            names["with"] - names["without"],
        )
        self.assertIn("bin/facebaker", names["without"])
        self.assertFalse(any("view" in name for name in names["without"]))

    def test_it_installs_bakes_and_previews(self):
        if EXTENSIONS:
            # Where Blender is built with the system's Python it starts python3 of the PATH to install.
            words = "--command", "extension", "install-file", "-r", "user_default", "-e", self.packed
            self.blender(*words, PATH=os.environ["PATH"])
            installed = self.folder / "user" / "extensions" / "user_default" / "facebaker_blender"
            module = "bl_ext.user_default.facebaker_blender"
        else:
            install = f"import bpy; bpy.ops.preferences.addon_install(filepath={str(self.packed)!r})"
            self.blender("-b", "--factory-startup", "--python-exit-code", "1", "--python-expr", install)
            installed = self.folder / "user" / "scripts" / "addons" / "facebaker_blender"
            module = "facebaker_blender"
        self.assertTrue((installed / "headless.py").is_file(), list(self.folder.rglob("headless.py")))
        shape_key_scene()
        rig = bpy.data.objects["rig"]
        add_action(rig, "nod", "head", "rotation_euler", [(0, 0, 0), (0, 0, 0.3)])
        scene, out, preview = (self.folder / name for name in ("scene.blend", "face.fbk", "preview.blend"))
        bpy.ops.wm.save_as_mainfile(filepath=str(scene))
        words = "--recipe", "linear", "--rig-budget", 100, "--workers", 1, "--drawn", 10
        printed = self.blender(
            "-b", scene, "-P", installed / "headless.py", "--", "bake", "--out", out, *words, "--preview", preview
        )
        self.assertIn("times faster", printed)
        self.assertIn(f"{installed}/carried/bin/facebaker", (self.folder / "face.blender" / "process.json").read_text())
        where = (
            f"import {module} as addon, facebaker, bpy\n"
            "print(facebaker.__file__, facebaker.__version__, bpy.context.scene.facebaker.bl_rna.identifier)\n"
        )
        script = self.folder / "follow.py"
        script.write_text(where + FOLLOW)
        printed = self.blender("-b", preview, "--addons", module, "--python-exit-code", 1, "-P", script)
        self.assertIn(f"{installed}/carried/facebaker/__init__.py {VERSION} FACEBAKER_PG_scene", printed)
        moved = float(printed.split("moved by ")[1].split()[0])
        self.assertGreater(moved, 0.1, printed)
