"""Tests of the add-on that need Blender; test.sh runs them:

    blender -b --factory-startup -P in_blender.py -- [TEST...]"""

import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE)]

import bpy  # noqa: E402
import numpy as np  # noqa: E402
from blender_scenes import constraint_scene, shape_key_positions, shape_key_scene  # noqa: E402

from facebaker_blender.tool_command import add_package_path, find_tool  # noqa: E402

add_package_path()

import facebaker  # noqa: E402

from facebaker_blender import action_shots, face_preview, find_controls, scene_rig  # noqa: E402
from facebaker_blender.bake_job import BakeJob, this_blender  # noqa: E402
from facebaker_blender.bake_settings import BakeOptions, BakeSettings, Shot, load_settings, save_settings  # noqa: E402
from facebaker_blender.channels import Channel, SceneControl, SettingsError  # noqa: E402
from facebaker_blender.find_controls import FindOptions  # noqa: E402
from facebaker_blender.scene_channels import SceneChannels  # noqa: E402
from facebaker_blender.scene_choice import chosen_armatures, chosen_meshes  # noqa: E402
from facebaker_blender.scene_evaluator import SceneEvaluator  # noqa: E402

HEADLESS = HERE.parent / "facebaker_blender" / "headless.py"


def found(options=FindOptions(), reference=""):
    meshes = chosen_meshes(bpy.context, [])
    controls, notes = find_controls.find_controls(chosen_armatures(meshes, []), meshes, options)
    return BakeSettings("face", tuple(mesh.name for mesh in meshes), tuple(controls), reference), notes


def scene_state():
    """Everything about a scene that evaluating it might change."""
    state = {}
    for scene_object in bpy.data.objects:
        shown = [(m.name, m.show_viewport) for m in scene_object.modifiers]
        state[scene_object.name] = (
            scene_object.hide_viewport, scene_object.hide_get(), shown, [list(row) for row in scene_object.matrix_world],
            {key: scene_object[key] for key in scene_object.keys() if not hasattr(scene_object[key], "keys")},
        )  # fmt: skip
        if scene_object.pose:
            state[scene_object.name] += (scene_object.data.pose_position, [
                (b.name, b.rotation_mode, tuple(b.location), tuple(b.rotation_quaternion), tuple(b.rotation_euler),
                 tuple(b.rotation_axis_angle), tuple(b.scale), [tuple(row) for row in b.matrix])
                for b in scene_object.pose.bones
            ])  # fmt: skip
        keys = getattr(scene_object.data, "shape_keys", None)
        if keys:
            state[scene_object.name] += ([(block.name, block.value) for block in keys.key_blocks],)
        animation = scene_object.animation_data
        if animation:
            state[scene_object.name] += (animation.action, [t.mute for t in animation.nla_tracks])
    return state


class RotationTest(unittest.TestCase):
    def test_channels_are_what_blender_turns_by(self):
        _, _, rig = constraint_scene()
        bone = rig.pose.bones["free"]
        import mathutils

        vector = np.array([0.3, -0.5, 0.2], np.float32)
        controls = [SceneControl(str(a), Channel("rotation", "rig", "free", a), -1, 1, 0) for a in range(3)]
        for mode in "QUATERNION", "AXIS_ANGLE", "XYZ", "ZXY":
            bone.rotation_mode = mode
            channels = SceneChannels(controls)
            channels.write(vector)
            np.testing.assert_allclose(channels.read(), vector, atol=1e-6)
            length = float(np.linalg.norm(vector))
            if mode in ("QUATERNION", "AXIS_ANGLE"):
                truth = mathutils.Quaternion(vector / length, length).to_matrix()
            else:
                truth = mathutils.Euler(vector, mode).to_matrix()
            np.testing.assert_allclose(np.array(bone.matrix_basis.to_3x3()), np.array(truth), atol=1e-6)

    def test_other_axes_keep_their_values(self):
        _, _, rig = constraint_scene()
        bone = rig.pose.bones["lead"]
        bone.rotation_mode, bone.rotation_euler = "XYZ", (0.1, 0.2, 0.3)
        SceneChannels([SceneControl("y", Channel("rotation", "rig", "lead", 1), -1, 1, 0)]).write(np.array([0.5], "f4"))
        np.testing.assert_allclose(bone.rotation_euler, (0.1, 0.5, 0.3), atol=1e-7)


class FindTest(unittest.TestCase):
    def test_bones(self):
        constraint_scene()
        settings, _ = found()
        ranges = {c.name: (round(c.minimum, 4), round(c.maximum, 4), c.rest) for c in settings.controls}
        self.assertEqual(ranges["jaw.rot_x"], (-0.1, 0.5, 0))
        self.assertEqual(ranges["jaw.loc_z"], (-0.2, 0.3, 0))
        self.assertEqual(ranges["jaw.loc_x"], (-0.1237, 0.1237, 0))  # 3 % of the meshes' diagonal
        self.assertEqual(ranges["free.scale_x"], (0.5, 2, 1))
        self.assertEqual(ranges["free.loc_x"], (-0.1237, 0.1237, 0))
        for name, why in {
            "jaw.loc_y": "locked", "lead.loc_x": "locked", "free.loc_z": "driven", "free.loc_y": "held by its limits",
            "jaw.scale_x": "scale without limits", "jaw.rot_w": "no such channel",
        }.items():  # fmt: skip
            self.assertNotIn(name, ranges, why)

    def test_still_controls(self):
        constraint_scene()
        settings, _ = found()
        with SceneEvaluator(settings) as evaluator:
            still = find_controls.still_controls(evaluator)
        self.assertIn("tip.rot_x", still)
        self.assertNotIn("lead.rot_x", still)  # moves the jaw
        self.assertNotIn("free.scale_x", still)

    def test_shape_keys_and_properties(self):
        face, rig = shape_key_scene()
        face["teeth"], face["mode"], face["visible"] = 0.5, 1, True
        face.id_properties_ui("mode").update(min=0, max=3)
        settings, notes = found()
        controls = {c.name: c for c in settings.controls}
        self.assertEqual((controls["smile.L"].maximum, controls["smile.L"].mirror), (1.5, "smile.R"))
        self.assertEqual((controls["smile.L"].group, controls["smile.R"].mirror), ("mouth", "smile.L"))
        self.assertEqual((controls["jaw_open"].maximum, controls["jaw_open"].group), (1, "jaw"))
        self.assertTrue({"crease", "jaw", "turn"}.isdisjoint(controls))
        self.assertIn("head.rot_z", controls)
        self.assertTrue(controls["mode"].channel.whole)
        self.assertTrue(any('"teeth" has no range' in note for note in notes), notes)

    def test_patterns_and_selection(self):
        _, _, rig = constraint_scene()
        settings, _ = found(FindOptions(bones=("l*", "j?w")))
        self.assertEqual({c.channel.bone for c in settings.controls}, {"lead", "jaw"})
        rig.data.bones["free"].select = True
        settings, _ = found(FindOptions(selected=True))
        self.assertEqual({c.channel.bone for c in settings.controls}, {"free"})

    def test_animation_widens_ranges(self):
        _, _, rig = constraint_scene()
        add_action(rig, "open", "jaw", "location", [(0, 0, 0), (2, 0, 9)])
        settings, _ = found()
        ranges = {c.name: (c.minimum, c.maximum) for c in settings.controls}
        self.assertAlmostEqual(ranges["jaw.loc_x"][1], 2.2)
        self.assertAlmostEqual(ranges["jaw.loc_x"][0], -0.1237, 3)
        self.assertAlmostEqual(ranges["jaw.loc_z"][1], 0.3)  # a limit stays one


def add_action(rig, name, bone, attribute, values, step=10):
    rig.animation_data_create()
    rig.animation_data.action = action = bpy.data.actions.new(name)
    for index, value in enumerate(values):
        setattr(rig.pose.bones[bone], attribute, value)
        rig.pose.bones[bone].keyframe_insert(attribute, frame=1 + step * index)
    return action


class EvaluateTest(unittest.TestCase):
    def test_driven_shape_keys_are_where_they_should_be(self):
        shape_key_scene()
        settings, _ = found(FindOptions(bones=("head",)), "face")
        names = [c.name for c in settings.controls]
        random = np.random.default_rng(1)
        low = np.array([c.minimum for c in settings.controls])
        high = np.array([c.maximum for c in settings.controls])
        poses = random.uniform(low, high, (30, len(names))).astype(np.float32)
        with SceneEvaluator(settings) as evaluator:
            positions = evaluator.evaluate(poses)
            for pose, points in zip(poses, positions):
                value = dict(zip(names, pose))
                truth = shape_key_positions(
                    evaluator.rest_positions, value["smile.L"], value["smile.R"], value["jaw_open"], value["head.rot_z"]
                )
                np.testing.assert_allclose(points, truth, atol=2e-6)
            again = evaluator.evaluate(poses[::-1])[::-1]
        np.testing.assert_array_equal(positions, again)  # whatever was before

    def test_constraints_and_lattice_are_what_blender_shows(self):
        face, brow, rig = constraint_scene()
        settings, _ = found(reference="rig")
        names = [c.name for c in settings.controls]
        pose = {"jaw.rot_x": 0.4, "lead.rot_x": 0.3, "free.loc_x": 0.1, "free.rot_y": 0.1, "free.scale_x": 1.5}
        values = np.array([[pose.get(c.name, c.rest) for c in settings.controls]], np.float32)
        self.assertLessEqual(set(pose), set(names))
        with SceneEvaluator(settings) as evaluator:
            positions = evaluator.evaluate(values)[0]
            counts = evaluator.vertex_counts
        rig.pose.bones["jaw"].rotation_euler.x = 0.4
        import mathutils

        rig.pose.bones["lead"].rotation_quaternion = mathutils.Quaternion((1, 0, 0), 0.3)
        rig.pose.bones["free"].location.x = 0.1
        rig.pose.bones["free"].rotation_axis_angle = (0.1, 0, 1, 0)
        rig.pose.bones["free"].scale.x = 1.5
        bpy.context.view_layer.update()
        graph = bpy.context.evaluated_depsgraph_get()
        shown = {}
        for mesh in (face, brow):
            evaluated = mesh.evaluated_get(graph)
            shown[mesh.name] = np.array([evaluated.matrix_world @ vertex.co for vertex in evaluated.data.vertices])
        truth = np.concatenate([shown[name] for name in settings.meshes])
        self.assertEqual(counts, [len(shown[name]) for name in settings.meshes])
        np.testing.assert_allclose(positions, truth, atol=2e-6)
        self.assertGreater(np.abs(positions - evaluator.rest_positions).max(), 0.3)

    def test_the_scene_is_restored_exactly(self):
        _, _, rig = constraint_scene()
        add_action(rig, "open", "jaw", "rotation_euler", [(0, 0, 0), (0.5, 0, 0)])
        track = rig.animation_data.nla_tracks.new()
        track.strips.new("below", 1, rig.animation_data.action)
        bpy.context.scene.frame_set(5)
        rig.pose.bones["jaw"].rotation_euler.y = 0.123  # edits without a key, one of them of an animated channel
        rig.pose.bones["jaw"].rotation_euler.x = 0.321
        rig.pose.bones["free"].rotation_axis_angle = (0.3, 1, 2, 3)
        rig.pose.bones["free"].location = (0.1, 0.2, 0.3)
        bpy.context.view_layer.update()
        bpy.data.objects["face"].hide_set(True)
        bpy.data.objects["brow"].hide_viewport = True
        bpy.data.objects["brow"].modifiers.new("Subdivision", "SUBSURF")
        rig.data.pose_position = "REST"
        bpy.context.view_layer.update()
        meshes = [bpy.data.objects["face"], bpy.data.objects["brow"]]
        controls, _ = find_controls.find_controls([rig], meshes, FindOptions())
        settings = BakeSettings("face", ("face", "brow"), tuple(controls), "rig", modifiers="off")
        before = scene_state()
        values = np.array([[c.maximum for c in controls]], np.float32)
        with SceneEvaluator(settings) as evaluator:
            self.assertGreater(np.abs(evaluator.evaluate(values)[0] - evaluator.rest_positions).max(), 0.1)
            self.assertNotEqual(scene_state(), before)
        self.assertEqual(scene_state(), before)
        with self.assertRaises(KeyError):
            with SceneEvaluator(settings) as evaluator:
                evaluator.evaluate(values)
                raise KeyError("within")
        self.assertEqual(scene_state(), before)
        with self.assertRaisesRegex(SettingsError, "Subdivision"):
            with SceneEvaluator(BakeSettings("face", ("face", "brow"), tuple(controls), "rig")):
                pass
        self.assertEqual(scene_state(), before)
        self.assertEqual(bpy.context.scene.frame_current, 5)

    def test_animation_does_not_interfere(self):
        _, _, rig = constraint_scene()
        settings, _ = found(reference="rig")
        pose = np.array([[c.maximum for c in settings.controls]], np.float32)
        with SceneEvaluator(settings) as evaluator:
            truth = evaluator.evaluate(pose)
        add_action(rig, "open", "jaw", "rotation_euler", [(0, 0, 0), (0.5, 0, 0)])
        bpy.context.scene.frame_set(7)
        with SceneEvaluator(settings) as evaluator:
            np.testing.assert_array_equal(evaluator.evaluate(pose), truth)

    def test_modifiers_that_change_the_count(self):
        shape_key_scene()
        face = bpy.data.objects["face"]
        face.modifiers.new("Smooth surface", "SUBSURF")
        face.modifiers.new("Harmless", "SMOOTH")
        settings, _ = found()
        with self.assertRaisesRegex(SettingsError, r'"face".*64 without.*"Smooth surface" \(SUBSURF\)\.') as caught:
            with SceneEvaluator(settings):
                pass
        self.assertNotIn("Harmless", str(caught.exception))
        counts = {}
        for policy in "apply", "off":
            with SceneEvaluator(BakeSettings("face", ("face",), settings.controls, modifiers=policy)) as evaluator:
                counts[policy] = evaluator.vertex_counts
                rig = scene_rig.scene_rig(evaluator)
                self.assertEqual(len(rig.rest_positions), evaluator.vertex_counts[0])
                self.assertEqual(rig.polygon_corners.max() + 1, evaluator.vertex_counts[0])
        self.assertEqual(counts, {"apply": [225], "off": [64]})
        face.modifiers.new("Rags", "CLOTH")
        with self.assertRaisesRegex(SettingsError, "Rags.*frames before"):
            with SceneEvaluator(BakeSettings("face", ("face",), settings.controls, modifiers="off")):
                pass

    def test_what_is_not_there_is_named(self):
        shape_key_scene()
        cases = {
            'no object "nobody"': Channel("location", "nobody", "b", 0),
            'no bone "tail"': Channel("location", "rig", "tail", 0),
            'no shape key "frown"': Channel("shape_key", "face", key="frown"),
            'no custom property "size"': Channel("property", "face", key="size"),
        }
        for message, channel in cases.items():
            with self.assertRaisesRegex(SettingsError, message):
                SceneChannels([SceneControl("x", channel, 0, 1, 0)])
        bpy.data.objects["face"].select_set(True)
        bpy.context.view_layer.objects.active = bpy.data.objects["face"]
        bpy.ops.object.mode_set(mode="EDIT")
        settings, _ = found()
        with self.assertRaisesRegex(SettingsError, "edit_mesh mode"):
            with SceneEvaluator(settings):
                pass
        bpy.ops.object.mode_set(mode="OBJECT")


class ShotTest(unittest.TestCase):
    def test_shots_are_what_playing_gives(self):
        _, _, rig = constraint_scene()
        import mathutils

        turns = [mathutils.Euler((0.1 * i, 0.2, -0.1 * i)).to_quaternion() for i in range(3)]
        add_action(rig, "lead turns", "lead", "rotation_quaternion", turns)
        settings, _ = found()
        self.assertEqual(action_shots.find_shots(settings.controls), [Shot("lead turns", 1, 21)])
        values, animated = action_shots.animated_values(bpy.data.actions["lead turns"], settings.controls, 1, 21)
        self.assertEqual([settings.controls[i].name for i in animated], ["lead.rot_x", "lead.rot_y", "lead.rot_z"])
        for frame in 1, 6, 13, 21:
            bpy.context.scene.frame_set(frame)
            played = SceneChannels(settings.controls).read()
            np.testing.assert_allclose(played[animated], values[frame - 1, animated], atol=1e-6)

    def test_shape_keys_and_properties(self):
        face, _ = shape_key_scene()
        keys = face.data.shape_keys
        for frame, value in ((1, 0.0), (11, 1.0)):
            keys.key_blocks["smile.L"].value = value
            keys.key_blocks["smile.L"].keyframe_insert("value", frame=frame)
            face["jaw_open"] = value
            face.keyframe_insert('["jaw_open"]', frame=frame)
        settings, _ = found()
        shots = action_shots.find_shots(settings.controls)
        self.assertEqual(len(shots), 2)
        peaks = {}
        for shot in shots:
            values = action_shots.shot_values(settings, shot)
            peaks.update({c.name: values[-1, i] for i, c in enumerate(settings.controls) if values[-1, i] != c.rest})
        self.assertEqual(peaks, {"smile.L": 1, "jaw_open": 1})


class BakeTest(unittest.TestCase):
    """Through the tool, in processes of their own."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="facebaker-blender-"))
        shape_key_scene()
        face, rig = bpy.data.objects["face"], bpy.data.objects["rig"]
        add_action(rig, "nod", "head", "rotation_euler", [(0, 0, 0), (0, 0, 0.3), (0, 0, -0.3)])
        rig.animation_data.action = None
        rig.pose.bones["head"].rotation_euler = (0, 0, 0)
        bpy.data.actions["nod"].use_fake_user = True
        cls.scene = cls.folder / "scene.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(cls.scene))

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def headless(self, *words, scene=None, ends=0):
        blender = this_blender().program
        command = [blender, "-b", str(scene or self.scene), "--factory-startup", "-P", str(HEADLESS), "--", *map(str, words)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=500)
        self.assertEqual(done.returncode, ends, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def test_one_command_bakes_measures_and_shows(self):
        out = self.folder / "face.fbk"
        printed = self.headless(
            "bake", "--out", out, "--armature", "rig", "--recipe", "linear", "--rig-budget", 200, "--workers", 2,
            "--json", self.folder / "measure.json", "--preview", self.folder / "preview.blend",
        )  # fmt: skip
        self.assertIn("controls: ", printed)
        measure = json.loads((self.folder / "measure.json").read_text())
        self.assertEqual([errors["name"] for errors in measure["errors"]], ["nod", "drawn poses"])
        self.assertGreater(measure["times_faster"], 1)
        # The recipe is linear blendshapes, so its error is that of those which are measured beside it.
        drawn = measure["errors"][1]
        self.assertLess(abs(drawn["mse"] - drawn["linear_mse"]), 0.05 * drawn["linear_mse"])
        face = facebaker.load(out)
        settings = load_settings(self.folder / "face.blender" / "settings.json")
        self.assertEqual([c.name for c in face.controls], [c.name for c in settings.controls])
        self.assertEqual((face.units, face.up_axis, len(face.uvs)), ("m", "z", 64))
        self.check_preview(face, settings)
        self.check_window(settings)

    def check_preview(self, face, settings):
        """In a new file of the same scene: the baked face follows the rig, by the window's handlers, with its errors."""
        bpy.ops.wm.open_mainfile(filepath=str(self.folder / "preview.blend"))
        face_preview.add_handlers()
        previews = [o for o in bpy.context.scene.objects if face_preview.ARCHIVE in o.keys()]
        self.assertEqual(len(previews), 2)
        self.assertEqual([mesh.name for mesh in chosen_meshes(bpy.context, [])], ["face"])
        keys = bpy.data.objects["face"].data.shape_keys.key_blocks
        keys["smile.L"].value, keys["smile.R"].value = 1.0, 0.5
        bpy.context.view_layer.update()
        pose = SceneChannels(settings.controls).read()
        for preview in previews:
            shown = np.array([vertex.co for vertex in preview.data.vertices])
            np.testing.assert_allclose(shown, face.evaluate(pose), atol=1e-6)
        state = face_preview.preview_of(previews[1])
        with SceneEvaluator(settings) as evaluator:
            truth = evaluator.evaluate(pose[None])[0]
        error = np.linalg.norm(face.evaluate(pose) - truth, axis=1).max() / face.diagonal
        self.assertAlmostEqual(state.max_error, error, delta=1e-3 * error)
        self.assertGreater(error, 0.01)  # linear blendshapes have no crease
        colours = np.empty(4 * face.vertex_count, np.float32)
        previews[1].data.color_attributes[face_preview.ATTRIBUTE].data.foreach_get("color", colours)
        self.assertGreater(len(np.unique(colours.reshape(-1, 4), axis=0)), 5)
        bpy.data.objects["rig"].animation_data.action = bpy.data.actions["nod"]
        for frame in 11, 17:
            bpy.context.scene.frame_set(frame)
            shown = np.array([vertex.co for vertex in previews[0].data.vertices])
            played = face.evaluate(SceneChannels(settings.controls).read())
            np.testing.assert_allclose(shown, played, atol=1e-6)
        face_preview.remove_handlers()

    def check_window(self, settings):
        """The buttons, without a window to press them in."""
        import facebaker_blender

        bpy.ops.wm.open_mainfile(filepath=str(self.scene))
        facebaker_blender.register()
        try:
            chosen = bpy.context.scene.facebaker
            for scene_object in bpy.context.scene.objects:
                scene_object.select_set(True)
            self.assertEqual(bpy.ops.facebaker.choose(), {"FINISHED"})
            self.assertEqual(bpy.ops.facebaker.find(), {"FINISHED"})
            self.assertEqual([item.name for item in chosen.controls], [c.name for c in settings.controls])
            chosen.out, chosen.recipe, chosen.rig_budget, chosen.workers = "//window.fbk", "linear", 100, 1
            self.assertEqual(bpy.ops.facebaker.bake(), {"FINISHED"})
            from facebaker_blender import window_operators

            job = window_operators.job_of(bpy.context)
            with self.assertRaisesRegex(RuntimeError, "is running"):
                bpy.ops.facebaker.bake()
            self.assertTrue(job.process.wait(200))
            self.assertIsNone(window_operators.watch())
            self.assertIsNotNone(job.process.document, job.process.log.read_text())
            self.assertTrue(job.process.progress.finished)
            chosen.colours = True
            self.assertEqual(bpy.ops.facebaker.show(), {"FINISHED"})
            self.assertIn("times faster", chosen.measured)
            self.assertEqual(bpy.ops.facebaker.colours(), {"FINISHED"})
        finally:
            facebaker_blender.unregister()

    def test_a_killed_bake_goes_on(self):
        out = self.folder / "killed.fbk"
        bpy.ops.wm.open_mainfile(filepath=str(self.scene))
        settings, _ = found()
        options = BakeOptions("compact", rig_budget=1000, workers=1, epochs=20)
        settings = BakeSettings("face", settings.meshes, settings.controls, "rig", bake=options)
        job = BakeJob(out)
        job.start(settings, find_tool())
        while job.process.poll() and not job.process.progress.finished:
            time.sleep(0.02)
        self.assertTrue(job.process.running, job.process.log.read_text())
        os.killpg(json.loads((job.folder / "process.json").read_text())["process"], signal.SIGKILL)
        job.process.wait(20)
        later = BakeJob(out)  # another session of Blender
        self.assertTrue(later.process.unfinished)
        later.go_on()
        self.assertTrue(later.process.wait(300))
        self.assertIsNotNone(later.process.document, later.process.log.read_text())
        self.assertFalse(later.process.unfinished)
        self.assertTrue(out.is_file())

    def test_ctrl_c_ends_the_bake_too(self):
        out = self.folder / "stopped.fbk"
        words = ["bake", "--out", str(out), "--recipe", "linear", "--rig-budget", "2000"]
        command = [this_blender().program, "-b", self.scene, "--factory-startup", "-P", HEADLESS, "--", *words]
        started = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        state = self.folder / "stopped.blender" / "process.json"
        while started.poll() is None and not state.is_file():
            time.sleep(0.1)
        time.sleep(0.5)
        started.send_signal(signal.SIGINT)
        printed = started.communicate(timeout=60)[1]
        self.assertEqual(started.returncode, 1, printed)
        self.assertIn("run the same command to go on", printed)
        self.assertTrue(BakeJob(out).process.unfinished)
        copied = BakeJob(out).scene.stat().st_mtime_ns
        self.headless(*words)
        self.assertTrue(out.is_file())
        self.assertEqual(BakeJob(out).scene.stat().st_mtime_ns, copied)  # went on with the same copy

    def test_failures_are_told(self):
        printed = self.headless("bake", "--out", self.folder / "x.fbk", "--mesh", "nobody", ends=1)
        self.assertIn('no object "nobody"', printed)
        self.assertIn("ends in .fbk", self.headless("bake", "--out", self.folder / "x.txt", ends=1))
        broken = self.folder / "broken.json"
        settings, _ = found()
        save_settings(settings, broken)
        broken.write_text(broken.read_text().replace('"smile.L"', '"frown.L"'))
        printed = self.headless("bake", "--settings", broken, "--out", self.folder / "x.fbk", ends=1)
        self.assertIn('no shape key "frown.L"', printed)
        self.assertFalse((self.folder / "x.fbk").exists())


class AddonTest(unittest.TestCase):
    def test_the_zip_installs_and_finds_what_it_carries(self):
        build = pathlib.Path(find_tool()).parents[1]
        with tempfile.TemporaryDirectory() as folder:
            packed = os.path.join(folder, "facebaker_blender.zip")
            subprocess.run(["/usr/bin/python3", HERE.parent / "make_addon.py", build, packed], check=True, stdout=subprocess.DEVNULL)
            kept = {key: value for key, value in os.environ.items() if not key.startswith(("FACEBAKER", "PYTHON"))}
            environment = {**kept, "BLENDER_USER_SCRIPTS": folder, "PATH": "/nowhere"}
            script = pathlib.Path(folder, "install.py")
            script.write_text(
                "import bpy, subprocess\n"
                f"bpy.ops.preferences.addon_install(filepath={packed!r})\n"
                "bpy.ops.preferences.addon_enable(module='facebaker_blender')\n"
                "import facebaker, facebaker_blender.tool_command as found\n"
                "tool = found.find_tool()\n"
                "print(facebaker.__file__, facebaker.__version__)\n"
                "print(tool, subprocess.check_output([tool, '--version'], env=found.tool_environment(tool)).decode())\n"
                "print(bpy.context.scene.facebaker.bl_rna.identifier)\n"
            )
            command = [this_blender().program, "-b", "--factory-startup", "--python-exit-code", "1", "-P", script]
            done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=100)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            carried = os.path.join(folder, "addons", "facebaker_blender", "carried")
            version = (HERE.parents[2] / "VERSION").read_text().strip()
            self.assertIn(f"{carried}/facebaker/__init__.py {version}", done.stdout)
            self.assertIn(f"{carried}/bin/facebaker facebaker {version}", done.stdout)
            self.assertIn("FACEBAKER_PG_scene", done.stdout)


class RigifyTest(unittest.TestCase):
    """Rigify's human with the sample face; FACEBAKER_SAMPLE names a dataset folder of it."""

    def test_the_face_is_found_and_evaluated(self):
        sample = os.environ.get("FACEBAKER_SAMPLE")
        if not sample:
            self.skipTest("FACEBAKER_SAMPLE is not set")
        from rigify_face import make_scene

        rig, meshes = make_scene(sample)
        controls, _ = find_controls.find_controls([rig], meshes, FindOptions(collections=("0", "1", "2")))
        settings = BakeSettings("face", tuple(m.name for m in meshes), tuple(controls), rig.name)
        self.assertEqual(len({c.channel.bone for c in controls}), 88)
        by_name = {c.name: c for c in controls}
        self.assertEqual(by_name["lip.T.L.001.loc_z"].mirror, "lip.T.R.001.loc_z")
        self.assertEqual(by_name["jaw_master.mouth_lock"].maximum, 1)
        self.assertEqual({c.group for c in controls} - {"brows", "eyes", "nose", "cheeks", "tongue", "jaw", "mouth", "ears"}, set())
        shots = action_shots.find_shots(controls)
        self.assertEqual([shot.action for shot in shots], ["play", "talk"])
        before = scene_state()
        values = action_shots.shot_values(settings, shots[1])[::40]
        with SceneEvaluator(settings) as evaluator:
            positions = evaluator.evaluate(values)
            again = evaluator.evaluate(values[::-1])[::-1]
        self.assertEqual(scene_state(), before)
        np.testing.assert_array_equal(positions, again)
        rig.animation_data.action = bpy.data.actions["talk"]
        for index, frame in enumerate(range(1, 116, 40)):
            bpy.context.scene.frame_set(frame)
            graph = bpy.context.evaluated_depsgraph_get()
            played = [m.evaluated_get(graph) for m in meshes]
            shown = np.concatenate([[m.matrix_world @ v.co for v in m.data.vertices] for m in played])
            np.testing.assert_allclose(positions[index], shown, atol=3e-6)


if __name__ == "__main__":
    words = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    program = unittest.main(argv=["in_blender.py", *words], exit=False, verbosity=2)
    sys.exit(not program.result.wasSuccessful())
