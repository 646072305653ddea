"""What the add-on finds in scenes, and how it evaluates them; in_blender.py runs it."""

import os
import unittest

import bpy
import numpy as np
from addon_support import add_action, found, scene_state
from blender_scenes import constraint_scene, select_bone, shape_key_positions, shape_key_scene

from facebaker_blender import action_shots, find_controls, scene_rig
from facebaker_blender.action_curves import is_layered
from facebaker_blender.bake_settings import BakeSettings, Shot
from facebaker_blender.bone_choice import FindOptions
from facebaker_blender.channels import Channel, SceneControl, SettingsError
from facebaker_blender.scene_channels import SceneChannels
from facebaker_blender.scene_evaluator import SceneEvaluator


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
        select_bone(rig, "free")
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
        values, animated = action_shots.Animation(settings.controls).values(bpy.data.actions["lead turns"], 1, 21)
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
        # From Blender 4.4 on the object and its shape keys are slots of one action.
        self.assertEqual(len(shots), 1 if is_layered(bpy.data.actions[0]) else 2)
        peaks = {}
        for shot in shots:
            values = action_shots.shot_values(settings, shot)
            peaks.update({c.name: values[-1, i] for i, c in enumerate(settings.controls) if values[-1, i] != c.rest})
        self.assertEqual(peaks, {"smile.L": 1, "jaw_open": 1})


class RigifyTest(unittest.TestCase):
    """Rigify's human with the sample face; FACEBAKER_SAMPLE names a dataset folder of it."""

    def test_the_face_is_found_and_evaluated(self):
        sample = os.environ.get("FACEBAKER_SAMPLE")
        if not sample:
            self.skipTest("FACEBAKER_SAMPLE is not set")
        from rigify_face import face_collections, make_scene

        rig, meshes = make_scene(sample)
        controls, _ = find_controls.find_controls([rig], meshes, FindOptions(collections=face_collections(rig)))
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
