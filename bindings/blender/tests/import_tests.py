"""Files of other programs: a scene that Blender wrote as FBX, and files that cannot be imported."""

import json
import math
import pathlib
import subprocess
import tempfile
import unittest

import addon_support
import bpy
import numpy as np
from addon_support import HEADLESS, add_action
from blender_scenes import armature, empty_scene, grid

from facebaker_blender.bake_job import this_blender
from facebaker_blender.bake_settings import load_settings


def write_fbx(path):
    """A grid with a shape key, skinned to two of three bones; its action turns one, and keys all of them."""
    empty_scene()
    face = grid()
    face.shape_key_add(name="Basis")
    smile = face.shape_key_add(name="smile")
    for point in smile.data:
        point.co.z += 0.2 * abs(point.co.x)
    rig = armature([
        ("head", (0, 0, -1), (0, 0, 0), None), ("jaw", (0, 0, 0), (0, 0, 1), "head"), ("hat", (0, 0, 1), (0, 0, 2), "head"),
    ])  # fmt: skip
    upper = [vertex.index for vertex in face.data.vertices if vertex.co.z > 0]
    face.vertex_groups.new(name="jaw").add(upper, 1.0, "REPLACE")
    face.vertex_groups.new(name="head").add([i for i in range(len(face.data.vertices)) if i not in upper], 1.0, "REPLACE")
    face.parent = rig
    face.modifiers.new("skin", "ARMATURE").object = rig
    for bone in rig.pose.bones:
        bone.rotation_mode = "XYZ"
    add_action(rig, "chew", "jaw", "rotation_euler", [(0, 0, 0), (math.radians(20), 0, 0), (0, 0, 0)])
    bpy.ops.export_scene.fbx(filepath=str(path), bake_anim_use_all_bones=True, add_leaf_bones=False)


class ImportTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.kept = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.kept.name)
        write_fbx(cls.folder / "face.fbx")

    @classmethod
    def tearDownClass(cls):
        cls.kept.cleanup()

    def headless(self, *words, ends=0):
        command = [this_blender().program, "-b", "--factory-startup", "-P", str(HEADLESS), "--", *map(str, words)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=500)
        self.assertEqual(done.returncode, ends, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def test_an_fbx_is_baked_with_the_controls_that_move(self):
        out = self.folder / "face.fbk"
        words = (
            "bake", "--import", self.folder / "face.fbx", "--out", out, "--recipe", "linear", "--rig-budget", 100,
            "--workers", 1, "--json", self.folder / "measure.json",
        )  # fmt: skip
        printed = self.headless(*words)
        settings = load_settings(self.folder / "face.blender" / "settings.json")
        names = [control.name for control in settings.controls]
        self.assertEqual(len(names), 2, printed)
        self.assertIn("smile", names)
        self.assertTrue(any(name.startswith("jaw.rot") for name in names), names)
        self.assertTrue(any("chew" in shot.action for shot in settings.shots), settings.shots)
        kept = list((self.folder / "face.blender").glob("imported.*.blend"))
        self.assertEqual(len(kept), 1)
        # The face moves by metres as the scene did, whatever units the file has.
        measure = json.loads((self.folder / "measure.json").read_text())
        self.assertLess(abs(measure["diagonal"] - 2 * np.sqrt(2)), 0.01)
        # The same command has the copy of the scene that an interrupted bake goes on with.
        copy = (self.folder / "face.blender" / "scene.blend").stat().st_mtime_ns
        self.headless(*words, "--only-prepare")
        self.assertEqual((self.folder / "face.blender" / "scene.blend").stat().st_mtime_ns, copy)
        self.headless("controls", "--import", self.folder / "face.fbx", "--out", self.folder / "face.json")
        self.assertEqual([c.name for c in load_settings(self.folder / "face.json").controls], names)

    def test_a_scaled_armature_has_its_own_unit(self):
        from facebaker_blender.scene_evaluator import scene_units

        scene = bpy.context.scene
        turned = np.array([[1, 0, 0, 5], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])
        for scale, unit, factor in ((1, "m", 1), (0.01, "cm", 1), (0.001, "mm", 1), (0.5, "m", 0.5), (-0.01, "cm", 1)):
            matrix = turned @ np.diag([scale, scale, scale, 1])
            named, found = scene_units(scene, np.float32(matrix).astype(float))
            self.assertEqual(named, unit)
            self.assertAlmostEqual(found, factor)
        scene.unit_settings.scale_length = 0.01
        self.addCleanup(setattr, scene.unit_settings, "scale_length", 1.0)
        self.assertEqual(scene_units(scene, np.eye(4)), ("cm", 1.0))
        self.assertEqual(scene_units(scene, np.diag([0.1, 0.1, 0.1, 1])), ("mm", 1.0))

    def test_what_cannot_be_imported_is_told(self):
        out = self.folder / "none.fbk"
        (self.folder / "broken.fbx").write_bytes(b"no such thing")
        for name, words in (
            ("none.fbx", "no such file"), ("broken.fbx", "importer fails"), ("face.max", "--import reads .abc, "),
            ("face.vrm", "has no importer of .vrm"),
        ):  # fmt: skip
            printed = self.headless("bake", "--import", self.folder / name, "--out", out, ends=1)
            self.assertIn(words, printed)
            self.assertNotIn("Traceback", printed.split("facebaker_blender bake:")[-1])
        self.assertFalse(out.exists())


assert addon_support
