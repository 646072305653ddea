"""Shapes and animated meshes solved to controls of their rig; in_blender.py runs it."""

import json
import pathlib
import shutil
import struct
import tempfile
import time
import types
import unittest
from unittest import mock

import bpy
import numpy as np
from addon_support import BakingTest, add_action, found, scene_state
from blender_scenes import chain_scene

import facebaker
import facebaker_blender
from facebaker_blender import window_errors, window_solve
from facebaker_blender.bake_job import BakeJob
from facebaker_blender.bake_settings import BakeOptions, BakeSettings
from facebaker_blender.face_preview import add_preview
from facebaker_blender.scene_channels import SceneChannels
from facebaker_blender.scene_evaluator import mesh_points
from facebaker_blender.tool_command import find_tool

CLOSE = 0.05  # of a control's range


def baked(folder, settings, budget):
    """The archive of settings, baked from the open file by linear blendshapes."""
    bake = BakeOptions("linear", rig_budget=budget, workers=1)
    settings = BakeSettings("face", settings.meshes, settings.controls, settings.reference, bake=bake)
    job = BakeJob(folder / "solved.fbk")
    job.start(settings, find_tool())
    assert job.process.wait(300) and job.process.document is not None, job.process.log.read_text()
    return settings, facebaker.load(job.archive)


def copy_of(name, positions=None):
    """A copy of a mesh object as it is shown, with nothing that moves it, five units beside; of these positions, if any."""
    source = bpy.data.objects[name]
    shown = source.evaluated_get(bpy.context.evaluated_depsgraph_get())
    copy = bpy.data.objects.new(name, bpy.data.meshes.new_from_object(shown))
    bpy.context.collection.objects.link(copy)
    copy.location.x = 5
    if positions is not None:
        copy.data.vertices.foreach_set("co", np.asarray(positions, np.float32).ravel())
        copy.data.update()
    return copy


def choose(*objects):
    """Selects objects alone, the first of which is active."""
    for other in bpy.context.view_layer.objects:
        other.select_set(other in objects)
    bpy.context.view_layer.objects.active = objects[0]


class SolvingTest(unittest.TestCase):
    """With the add-on's buttons on a copy of self.scene, which was baked as self.settings into solved.fbk beside it."""

    def setUp(self):
        facebaker_blender.register()
        bpy.ops.wm.open_mainfile(filepath=str(self.scene))
        bpy.context.scene.facebaker.out = "//solved.fbk"
        self.chosen = bpy.context.scene.facebaker.solve
        self.chosen.noise = 0.1
        self.controls = self.settings.controls
        self.names = [control.name for control in self.controls]

    def tearDown(self):
        window_errors.set_problem("solve", "")
        facebaker_blender.unregister()

    def pose(self, **values):
        pose = np.array([control.rest for control in self.controls], np.float32)
        for name, value in values.items():
            pose[self.names.index(name.replace("__", "."))] = value
        return pose

    def solve(self):
        self.assertEqual(bpy.ops.facebaker.solve(), {"FINISHED"})
        return self.chosen.found.splitlines()

    def refused(self, message):
        """Solving fails with this message, in the panel too, and leaves the scene as it was."""
        bpy.context.view_layer.update()
        before, actions = scene_state(), set(bpy.data.actions)
        with self.assertRaisesRegex(RuntimeError, message):
            bpy.ops.facebaker.solve()
        self.assertRegex(window_errors.problem_of("solve"), message)
        self.assertIsNone(window_solve.running_solve())
        self.assertEqual((scene_state(), set(bpy.data.actions)), (before, actions))

    def expect(self, pose):
        spans = np.array([control.span for control in self.controls])
        away = np.abs(SceneChannels(self.controls).read() - pose) / spans
        self.assertLess(float(away.max()), CLOSE, self.names[int(away.argmax())])


class ShapeSolveTest(SolvingTest, BakingTest):
    """On shape_key_scene()."""

    @classmethod
    def setUpClass(cls):
        BakingTest.setUpClass.__func__(cls)
        settings, _ = found(reference="rig")
        cls.settings, cls.face = baked(cls.folder, settings, 300)

    def test_a_shape_of_the_rig(self):
        """Of the rig itself in a known pose, which linear blendshapes can take."""
        pose = self.pose(smile__L=0.6, head__rot_z=0.2)
        SceneChannels(self.controls).write(pose)
        bpy.context.view_layer.update()
        copy = copy_of("face")
        SceneChannels(self.controls).write(self.pose())
        bpy.context.view_layer.update()
        bpy.context.scene.frame_set(7)
        choose(copy)
        lines = self.solve()
        self.assertRegex(lines[0], r"^Off by [\d.]+ mm in the root mean square, by [\d.]+ mm at most$")
        self.assertEqual(lines[1], "2 controls move")
        self.expect(pose)
        for block in bpy.data.objects["rig"], bpy.data.objects["face"].data.shape_keys:
            self.assertTrue(block.animation_data.action.name.startswith("face solved"))
            self.assertIn(f'"{block.animation_data.action.name}"', lines[-1])
        SceneChannels(self.controls).write(self.pose())
        bpy.context.scene.frame_set(7)
        self.expect(pose)  # by the keys

    def animated(self):
        """A mesh that goes by shape keys through the baked face's poses of frames 1, 11 and 21; and those poses."""
        poses = [self.pose(), self.pose(smile__L=0.9, jaw_open=0.5), self.pose(smile__R=0.7, head__rot_z=-0.2)]
        copy = copy_of("face", self.face.evaluate(poses[0]))
        copy.shape_key_add(name="Basis")
        for index, pose in enumerate(poses[1:]):
            key = copy.shape_key_add(name=f"pose {index}")
            key.data.foreach_set("co", self.face.evaluate(pose).ravel())
            for frame in 1, 11, 21:
                key.value = float(frame == 11 + 10 * index)
                key.keyframe_insert("value", frame=frame)
        scene = bpy.context.scene
        scene.frame_start, scene.frame_end = 1, 21
        choose(copy)
        return copy, poses

    def test_an_animated_mesh(self):
        _, poses = self.animated()
        scene = bpy.context.scene
        scene.frame_set(4)
        self.chosen.frames = "frames"
        lines = self.solve()
        self.assertRegex(lines[0], r"^21 frames: off by .* at most, in frame \d+$")
        self.assertEqual(scene.frame_current, 4)
        for frame, pose in zip((1, 11, 21), poses):
            scene.frame_set(frame)
            self.expect(pose)
        scene.frame_set(16)  # between two keys of the mesh
        middle = mesh_points(bpy.context.active_object.evaluated_get(bpy.context.evaluated_depsgraph_get()))
        solved = self.face.evaluate(SceneChannels(self.controls).read())
        self.assertLess(float(np.abs(solved - middle).max()), 0.02)

    def test_a_range_of_frames_in_the_current_action(self):
        _, poses = self.animated()
        rig = bpy.data.objects["rig"]
        action = add_action(rig, "nod again", "head", "rotation_euler", [(0, 0, 0.1)] * 4)  # 1 to 31
        scene = bpy.context.scene
        scene.use_preview_range, scene.frame_preview_start, scene.frame_preview_end = True, 11, 21
        self.chosen.frames, self.chosen.action = "frames", "current"
        self.solve()
        self.assertEqual(rig.animation_data.action, action)
        for frame, pose in ((11, poses[1]), (21, poses[2])):
            scene.frame_set(frame)
            self.expect(pose)
        for frame in 1, 31:
            scene.frame_set(frame)
            self.assertAlmostEqual(rig.pose.bones["head"].rotation_euler[2], 0.1, 5)

    def test_a_mesh_cache(self):
        poses = [self.pose(), self.pose(smile__L=0.3), self.pose(smile__L=0.6, jaw_open=0.5)]
        copy, path = copy_of("face"), self.folder / "cache.pc2"
        header = b"POINTCACHE2\0" + struct.pack("<iiffi", 1, 64, 1.0, 1.0, len(poses))
        path.write_bytes(header + b"".join(self.face.evaluate(pose).astype("<f4").tobytes() for pose in poses))
        cache = copy.modifiers.new("Cache", "MESH_CACHE")
        cache.cache_format, cache.filepath, cache.frame_start = "PC2", str(path), 5
        scene = bpy.context.scene
        scene.frame_start, scene.frame_end, self.chosen.frames = 5, 7, "frames"
        choose(copy)
        self.solve()
        for frame, pose in zip((5, 6, 7), poses):
            scene.frame_set(frame)
            self.expect(pose)

    def test_the_own_mesh_of_the_rig(self):
        pose = self.pose(smile__L=0.7, head__rot_z=-0.15)
        SceneChannels(self.controls).write(pose)
        choose(bpy.data.objects["face"])
        self.solve()
        self.expect(pose)

    def test_modifiers_that_the_bake_switched_off(self):
        path = self.folder / "solved.blender" / "settings.json"
        before = path.read_text()
        self.addCleanup(path.write_text, before)
        path.write_text(json.dumps({**json.loads(before), "modifiers": "off"}))
        pose = self.pose(smile__R=0.7)
        copy = copy_of("face", self.face.evaluate(pose))
        copy.modifiers.new("Finer", "SUBSURF")
        choose(copy)
        self.solve()
        self.expect(pose)
        self.assertTrue(copy.modifiers["Finer"].show_viewport)

    def test_locked_and_only(self):
        pose = self.pose(smile__L=0.6, smile__R=0.5)
        choose(copy_of("face", self.face.evaluate(pose)))
        keys = bpy.data.objects["face"].data.shape_keys.key_blocks
        keys["smile.R"].value = 0.3
        self.chosen.locked, self.chosen.action = "smile.R, jaw", "current"
        lines = self.solve()
        self.assertIn('Locked at rest: "smile.R", "jaw_open"', lines)
        self.assertAlmostEqual(keys["smile.R"].value, 0.3, 6)  # nobody has touched it
        self.assertIn('Not at rest in this frame, though the others were found as if they were: "smile.R"', lines)
        self.chosen.locked, self.chosen.only, self.chosen.action = "", "mouth", "new"
        self.solve()
        self.expect(pose)
        self.chosen.only = "moth"
        self.refused('there is no control or group "moth"; there are "mouth"')

    def test_the_baked_face_is_a_shape_too(self):
        bpy.data.objects["rig"].location.z = 1  # another space than that of the rig's mesh
        pose = self.pose(smile__L=0.8, jaw_open=0.4)
        SceneChannels(self.controls).write(pose)
        preview = add_preview(bpy.context, str(self.folder / "solved.fbk"), self.settings)
        choose(preview)
        preview.hide_set(True)
        self.solve()
        self.expect(pose)
        self.assertTrue(preview.hide_get())

    def test_undo(self):
        choose(copy_of("face", self.face.evaluate(self.pose(smile__L=0.6))))
        bpy.ops.ed.undo_push(message="before")
        self.solve()
        bpy.ops.ed.undo_push(message="Solve to controls")  # as Blender does behind a button
        rig = bpy.data.objects["rig"]
        self.assertIsNotNone(rig.animation_data.action)
        bpy.ops.ed.undo()
        self.assertEqual([action.name for action in bpy.data.actions], ["nod"])
        self.assertAlmostEqual(bpy.data.objects["face"].data.shape_keys.key_blocks["smile.L"].value, 0)
        animation = bpy.data.objects["rig"].animation_data
        self.assertIsNone(animation and animation.action)

    def test_what_cannot_be_solved(self):
        self.assertIn("UNDO", window_solve.FACEBAKER_OT_solve.bl_options)
        bpy.context.view_layer.objects.active = bpy.data.objects["rig"]
        self.refused("no mesh is active")
        copy = copy_of("face")
        choose(copy)
        copy.modifiers.new("Finer", "SUBSURF")
        self.refused(r'"face.001": modifiers make 225 vertices of its 64, .*"Finer" \(SUBSURF\); switch them off')
        copy.modifiers.clear()
        other = bpy.data.objects.new("other", bpy.data.meshes.new("other"))
        other.data.from_pydata([(0, 0, 0), (1, 0, 0), (0, 0, 1)], [], [(0, 1, 2)])
        bpy.context.collection.objects.link(other)
        choose(other)
        self.refused('"other" has 3 vertices, the face 64; a shape has the topology of the face')
        choose(copy)
        del bpy.data.objects["face"]["jaw_open"]
        self.refused('"face" has no custom property "jaw_open"')
        bpy.context.scene.facebaker.out = "//other.fbk"
        self.refused("there is no such archive yet")
        shutil.copy(self.folder / "solved.fbk", self.folder / "other.fbk")
        self.refused(r"other.blender/settings.json: is not there, so nobody knows which channels")

    def test_other_settings(self):
        shutil.copy(self.folder / "solved.fbk", self.folder / "changed.fbk")
        document = json.loads((self.folder / "solved.blender" / "settings.json").read_text())
        document["controls"] = [one for one in document["controls"] if one["name"] not in ("smile.L", "smile.R")]
        (self.folder / "changed.blender").mkdir()
        (self.folder / "changed.blender" / "settings.json").write_text(json.dumps(document))
        bpy.context.scene.facebaker.out = "//changed.fbk"
        choose(copy_of("face"))
        self.refused('changed.fbk: has other controls than its settings: "smile.L" is not in both')

    def test_a_mesh_that_changes_its_count(self):
        copy, _ = self.animated()
        copy.modifiers.new("Build", "BUILD").frame_duration = 20
        self.chosen.frames = "frames"
        bpy.context.scene.frame_set(30)
        self.refused(r'"face.001" has [\d,]+ vertices in frame 1, and had 64 before')
        self.assertEqual(bpy.context.scene.frame_current, 30)

    def test_the_tool_fails(self):
        choose(copy_of("face"))
        with mock.patch.object(window_solve, "find_tool", return_value="/bin/false"):
            self.refused("the solve ended without a result; its log is empty$")

    def window(self):
        """In place of a window with the operator in it: gives events one after the other."""
        manager = mock.Mock()
        context = types.SimpleNamespace(
            scene=bpy.context.scene, view_layer=bpy.context.view_layer, mode="OBJECT", window=None, window_manager=manager,
            screen=None, area=None, preferences=bpy.context.preferences, selected_objects=bpy.context.selected_objects,
            evaluated_depsgraph_get=bpy.context.evaluated_depsgraph_get,
        )  # fmt: skip
        kind = window_solve.FACEBAKER_OT_solve
        operator = types.SimpleNamespace(part="solve", report=lambda *_: None, _timer=1)
        operator._ended = lambda *words: kind._ended(operator, *words)
        app = types.SimpleNamespace(app=types.SimpleNamespace(background=False))
        with mock.patch.object(window_solve, "bpy", app):
            self.assertEqual(kind.invoke(operator, context, None), {"RUNNING_MODAL"})
        return lambda event: kind.modal(operator, context, types.SimpleNamespace(type=event))

    def ended(self, send):
        """What the operator ended with, given nothing but the timer's events."""
        end = time.monotonic() + 60
        while time.monotonic() < end:
            result = send("TIMER")
            if result & {"FINISHED", "CANCELLED"}:
                return result
            time.sleep(0.05)
        raise AssertionError("it does not end")

    def test_the_window_stays_alive(self):
        _, poses = self.animated()
        self.chosen.frames = "frames"
        send = self.window()
        with self.assertRaisesRegex(RuntimeError, "a solve is running"):
            bpy.ops.facebaker.solve()
        job = window_solve.running_solve()
        self.assertEqual(send("MOUSEMOVE"), {"RUNNING_MODAL"})  # nothing is edited while frames are read
        self.assertEqual(job.lines, ["Reading frames: 0 of 21", "Esc stops"])
        folder = job.process.folder
        self.assertTrue(folder.is_dir())
        self.assertEqual(self.ended(send), {"FINISHED"})
        self.assertFalse(folder.exists())
        bpy.context.scene.frame_set(21)
        self.expect(poses[2])

    def test_stopping(self):
        self.animated()
        bpy.context.scene.frame_set(9)
        self.chosen.frames = "frames"
        before = scene_state()
        send = self.window()
        window_solve.running_solve().advance(0)
        self.assertNotEqual(bpy.context.scene.frame_current, 9)
        self.assertEqual(send("ESC"), {"CANCELLED"})
        self.assertEqual((scene_state(), bpy.context.scene.frame_current), (before, 9))
        bpy.context.scene.frame_end = 400  # so that the tool works for a while
        send = self.window()
        while window_solve.running_solve().reading:
            send("TIMER")
        self.assertEqual(send("MOUSEMOVE"), {"PASS_THROUGH"})
        self.assertEqual(bpy.ops.facebaker.stop_solve(), {"FINISHED"})
        self.assertEqual(self.ended(send), {"CANCELLED"})
        self.assertEqual((scene_state(), window_errors.problem_of("solve")), (before, ""))
        self.assertEqual([action.name for action in bpy.data.actions if "solved" in action.name], [])


class SeveralMeshesTest(SolvingTest):
    """On chain_scene(): a mesh that bones bend, and one that hangs on a bone."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="facebaker-blender-"))
        chain_scene()
        bpy.data.objects["rig"].pose.bones["base"].rotation_mode = "QUATERNION"
        cls.scene = cls.folder / "scene.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(cls.scene))
        settings, _ = found(reference="rig")
        wanted = {"base.rot_x", "tip.rot_y", "lead.rot_x", "puff"}
        settings = settings.without([c.name for c in settings.controls if c.name not in wanted])
        cls.settings, cls.face = baked(cls.folder, settings, 200)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def copies(self, pose):
        """Copies of both meshes where the rig has them at rest, with the shape of the baked face in a pose."""
        copies, points = [], self.face.evaluate(pose)
        for name, count in zip(self.settings.meshes, (mesh.vertices for mesh in self.face.meshes)):
            copies.append(copy_of(name))
            copies[-1].matrix_world = matrix = bpy.data.objects[name].matrix_world
            own = np.c_[points[:count], np.ones(count)] @ np.linalg.inv(np.array(matrix)).T
            copies[-1].data.vertices.foreach_set("co", own[:, :3].astype(np.float32).ravel())
            points = points[count:]
        return copies

    def test_two_meshes(self):
        pose = self.pose(base__rot_x=0.1, tip__rot_y=-0.08, lead__rot_x=0.12, puff=0.5)
        face, ball = self.copies(pose)
        self.assertGreater(float(np.abs(np.array(ball.matrix_world) - np.eye(4)).max()), 0.4)  # it hangs on a bone
        choose(ball, face)
        self.chosen.place = "world"
        self.assertFalse(any("Without a shape" in line for line in self.solve()))
        self.expect(pose)
        SceneChannels(self.controls).write(self.pose())
        face.location.x += 3
        ball.location.z += 1
        self.chosen.place = "own"
        self.solve()
        self.expect(pose)
        self.chosen.place = "world"
        self.solve()
        with self.assertRaises(AssertionError):
            self.expect(pose)
        face.location.x -= 2
        ball.location = ball.location.x + 1, ball.location.y, ball.location.z - 1  # both moved alike now
        self.chosen.head_motion = True
        self.solve()
        self.expect(pose)

    def test_one_mesh_of_two(self):
        pose = self.pose(base__rot_x=0.1, tip__rot_y=-0.08, lead__rot_x=0.12, puff=0.5)
        face, _ = self.copies(pose)
        choose(face)
        self.assertIn('Without a shape: "ball"', self.solve())
        # What nothing is told of stays at rest.
        self.expect(np.where([name.startswith("lead") for name in self.names], self.pose(), pose))
