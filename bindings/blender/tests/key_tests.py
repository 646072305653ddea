"""Values of controls as keys of actions; in_blender.py runs it."""

import unittest

import bpy
import numpy as np
from addon_support import add_action, found
from blender_scenes import constraint_scene, shape_key_scene

from facebaker_blender.action_curves import ActionCurves
from facebaker_blender.action_shots import data_path
from facebaker_blender.control_keys import key_controls
from facebaker_blender.scene_channels import SceneChannels, channel_block

FIRST, FRAMES = 11, 6


def drawn_values(controls, seed=3):
    """(FRAMES, controls), within ranges; whole numbers where a control has such."""
    random = np.random.default_rng(seed)
    low, high = (np.array([getattr(c, end) for c in controls]) for end in ("minimum", "maximum"))
    values = random.uniform(low, high, (FRAMES, len(controls))).astype(np.float32)
    whole = [c.channel.whole for c in controls]
    values[:, whole] = np.round(values[:, whole])
    return values


def played(controls):
    """What the scene has in each of the frames."""
    result = []
    for frame in range(FIRST, FIRST + FRAMES):
        bpy.context.scene.frame_set(frame)
        result.append(SceneChannels(controls).read())
    return np.array(result)


def keys_of(controls, name):
    """The keys of a control's curve. Not of rotations."""
    control = next(c for c in controls if c.name == name)
    block = channel_block(control.channel)
    curves = ActionCurves().of(block.animation_data.action, block)
    return curves[data_path(control), max(control.channel.axis, 0)].keyframe_points


def key_frames(controls, name):
    return [int(point.co.x) for point in keys_of(controls, name)]


class KeyTest(unittest.TestCase):
    def test_bones_of_every_rotation_mode(self):
        _, _, rig = constraint_scene()
        settings, _ = found(reference="rig")
        values = drawn_values(settings.controls)
        modes = {bone.rotation_mode for bone in rig.pose.bones}
        self.assertLessEqual({"XYZ", "QUATERNION", "AXIS_ANGLE"}, modes)
        names = key_controls(bpy.context, settings.controls, values, FIRST, [], "solved")
        self.assertEqual(names, ["solved"])
        np.testing.assert_allclose(played(settings.controls), values, atol=2e-6)

    def test_numbers_of_a_rotation_do_not_jump(self):
        _, _, rig = constraint_scene()
        settings, _ = found(reference="rig")
        controls = settings.controls
        values = np.array([[c.rest for c in controls]] * FRAMES, np.float32)
        names = [c.name for c in controls]
        for name in "lead.rot_x", "free.rot_x":
            values[:, names.index(name)] = np.linspace(-0.2, 0.2, FRAMES)  # through no turn at all
        key_controls(bpy.context, controls, values, FIRST, [], "solved")
        bpy.context.scene.frame_set(FIRST + FRAMES // 2 - 1, subframe=0.5)  # between two frames
        pose = SceneChannels(controls).read()
        for name in "lead.rot_x", "free.rot_x":
            self.assertAlmostEqual(float(pose[names.index(name)]), 0, 5)

    def test_properties_and_shape_keys(self):
        face, rig = shape_key_scene()
        face["mode"] = 1
        face.id_properties_ui("mode").update(min=0, max=3)
        settings, _ = found()
        values = drawn_values(settings.controls)
        still = [c.name for c in settings.controls].index("smile.R")
        values[:, still] = 0.25
        bpy.context.scene.frame_set(FIRST + 2)
        key_controls(bpy.context, settings.controls, values, FIRST, [], "solved")
        np.testing.assert_allclose(SceneChannels(settings.controls).read(), values[2], atol=2e-6)  # shown at once
        np.testing.assert_allclose(played(settings.controls), values, atol=2e-6)
        self.assertIs(type(face["mode"]), int)
        self.assertEqual(key_frames(settings.controls, "smile.L"), list(range(FIRST, FIRST + FRAMES)))
        self.assertEqual(key_frames(settings.controls, "smile.R"), [FIRST, FIRST + FRAMES - 1])

    def test_a_new_action_leaves_the_former_one(self):
        _, rig = shape_key_scene()
        former = add_action(rig, "nod", "head", "rotation_euler", [(0, 0, 0), (0, 0, 0.3)])
        settings, _ = found()
        controls = settings.controls
        rig.pose.bones["head"].location.x = 0.05
        key_controls(bpy.context, controls, drawn_values(controls), FIRST, ["head.loc_x"], "solved")
        self.assertNotEqual(rig.animation_data.action, former)
        self.assertTrue(former.use_fake_user)
        curve = ActionCurves().of(former, rig)['pose.bones["head"].rotation_euler', 2]
        self.assertEqual([point.co.x for point in curve.keyframe_points], [1, 11])
        self.assertAlmostEqual(rig.pose.bones["head"].location.x, 0)  # locked: at rest, without keys
        with self.assertRaises(KeyError):
            key_frames(controls, "head.loc_x")

    def test_the_current_action_keeps_other_frames(self):
        _, rig = shape_key_scene()
        former = add_action(rig, "slide", "head", "location", [(0.02, 0, 0), (0.03, 0, 0), (0.04, 0, 0)])  # 1, 11, 21
        settings, _ = found()
        controls = settings.controls
        values = drawn_values(controls)
        key_controls(bpy.context, controls, values, FIRST, ["head.loc_y"], "")
        self.assertEqual(rig.animation_data.action, former)
        self.assertEqual(key_frames(controls, "head.loc_x"), [1, *range(FIRST, FIRST + FRAMES), 21])
        self.assertEqual(key_frames(controls, "head.loc_y"), [1, 11, 21])  # locked
        moving = [c.name != "head.loc_y" for c in controls]
        np.testing.assert_allclose(played(controls)[:, moving], values[:, moving], atol=2e-6)
        bpy.context.scene.frame_set(1)
        self.assertAlmostEqual(rig.pose.bones["head"].location.x, 0.02)
        joined = [point.interpolation for point in keys_of(controls, "head.loc_x")]
        self.assertEqual(joined, ["BEZIER", *["LINEAR"] * FRAMES, "BEZIER"])

    def test_keys_take_the_place_of_keys(self):
        face, _ = shape_key_scene()
        face["mode"] = 1
        face.id_properties_ui("mode").update(min=0, max=3)
        settings, _ = found()
        controls = settings.controls
        key_controls(bpy.context, controls, drawn_values(controls), FIRST, [], "solved")
        values = drawn_values(controls, seed=4)
        values[:, [c.name == "smile.L" for c in controls]] = 0.5  # which does not move now
        key_controls(bpy.context, controls, values, FIRST, [], "")
        np.testing.assert_allclose(played(controls), values, atol=2e-6)
        self.assertEqual(key_frames(controls, "smile.L"), [FIRST, FIRST + FRAMES - 1])
        self.assertEqual({point.interpolation for point in keys_of(controls, "mode")}, {"CONSTANT"})
        self.assertEqual({point.handle_left_type for point in keys_of(controls, "smile.R")}, {"AUTO_CLAMPED"})
