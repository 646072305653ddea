"""Bones that the controls move as joints of the face; in_blender.py runs it."""

import json
import pathlib
import tempfile
import unittest
from dataclasses import replace

import bpy
import numpy as np
from addon_support import found, headless
from blender_scenes import chain_scene

import facebaker
from facebaker_blender.bake_settings import BakeSettings, load_settings
from facebaker_blender.bone_choice import FindOptions
from facebaker_blender.scene_evaluator import SceneEvaluator
from facebaker_blender.scene_joints import SceneJoints, drawn_poses
from facebaker_blender.scene_rig import scene_rig

TURNS = FindOptions(kinds=("rotation",))


def settings_of_scene(options=TURNS):
    settings, _ = found(options, "rig")
    return replace(settings, driven_joints="keep")


def joints_of_scene(settings):
    with SceneEvaluator(settings) as evaluator:
        found_joints = SceneJoints(evaluator)
        return found_joints, evaluator.rest_positions


def skinned(rig, frames):
    """What linear blend skinning by the joints of a rig makes of its rest positions."""
    rest = []
    for joint in rig.joints:
        local = np.vstack([joint.rest, (0, 0, 0, 1)])
        rest.append(local if joint.parent is None else rest[joint.parent] @ local)
    points = np.column_stack([rig.rest_positions, np.ones(len(rig.rest_positions))])
    result = np.repeat(rig.rest_positions[None].astype(float), len(frames), 0)
    for joint, place in enumerate(rest):
        weight = (rig.skin.weights * (rig.skin.joints == joint)).sum(1)
        moved = points @ (frames[:, joint] @ np.linalg.inv(place)).transpose(0, 2, 1)
        result += weight[None, :, None] * (moved - points[None, :, :3])
    return result


class JointsTest(unittest.TestCase):
    def test_a_chain_of_bones_is_a_chain_of_joints(self):
        chain_scene()
        settings = settings_of_scene()
        self.assertEqual({c.channel.bone for c in settings.controls if c.channel.of_bone}, {"base", "tip", "lead"})
        with SceneEvaluator(settings) as evaluator:
            rig = scene_rig(evaluator)
            poses = drawn_poses(settings.controls, 8, 3)
            poses[:, [c.name for c in settings.controls].index("puff")] = 0
            positions, frames = rig.evaluate(poses)
            np.testing.assert_array_equal(evaluator.evaluate(poses), positions)
        self.assertTrue(rig.skinned)
        # "copy" does as "lead" does; "still" is moved by nothing, and what follows it stays.
        parents = {joint.name: None if joint.parent is None else rig.joints[joint.parent].name for joint in rig.joints}
        self.assertEqual(parents, {"base": None, "tip": "base", "copy": None})
        numbers = {joint.name: joint.numbers for joint in rig.joints}
        self.assertEqual(numbers["base"], ("rotate_x", "rotate_y", "rotate_z"))
        self.assertEqual(numbers["tip"], numbers["base"])
        self.assertEqual(numbers["copy"], ("rotate_x",))
        self.assertGreater(np.abs(positions - rig.rest_positions).max(), 0.3)
        np.testing.assert_allclose(skinned(rig, frames), positions, atol=2e-6)

    def test_what_a_shape_key_does_comes_before_joints(self):
        chain_scene()
        settings = settings_of_scene()
        with SceneEvaluator(settings) as evaluator:
            rig = scene_rig(evaluator)
            poses = drawn_poses(settings.controls, 2, 4)
            puff = np.array([0.5, 1], np.float32)
            poses[:, [c.name for c in settings.controls].index("puff")] = puff
            positions, frames = rig.evaluate(poses)
            moved = skinned(rig, frames)
        self.assertGreater(np.abs(moved - positions).max(), 0.02)
        # Where a vertex follows one joint, the key's offset is turned by it.
        whole = np.flatnonzero((rig.skin.weights == 1).any(1) & (rig.skin.joints[:, 0] == 1))
        lengths = np.linalg.norm((positions - moved)[:, whole], axis=2)
        np.testing.assert_allclose(lengths, np.abs(puff)[:, None] * np.full(len(whole), 0.1), atol=2e-6)

    def test_what_is_no_linear_blend_is_told_and_left(self):
        for change, words in (
            (lambda m: setattr(m, "use_deform_preserve_volume", True), "preserves volume"),
            (lambda m: setattr(m, "use_bone_envelopes", True), "by their envelopes"),
            (lambda m: setattr(m, "use_vertex_groups", False), "does not use vertex groups"),
            (lambda m: setattr(m, "vertex_group", "base"), "blended with what was before"),
            (lambda m: setattr(m.id_data.modifiers.new("Two", "ARMATURE"), "object", m.object), "several armatures"),
            (lambda m: setattr(m.object.data.bones["tip"], "use_envelope_multiply", True), 'bone "tip" multiplies'),
        ):
            face, _ = chain_scene()
            change(face.modifiers["Armature"])
            joints, _ = joints_of_scene(settings_of_scene())
            self.assertEqual([joint.name for joint in joints.joints], ["copy"])  # of the mesh that hangs on it
            self.assertEqual(len(joints.notes), 1)
            self.assertRegex(joints.notes[0], f'"face" follows no joints: .*{words}')
        face, _ = chain_scene()
        face.modifiers["Armature"].show_viewport = False
        self.assertEqual([joint.name for joint in joints_of_scene(settings_of_scene())[0].joints], ["copy"])
        _, rig = chain_scene()
        rig.data.bones["tip"].bbone_segments = 4
        self.assertIn('bones "tip" bend', joints_of_scene(settings_of_scene())[0].notes[0])

    def test_bones_that_are_mirrored_or_not_bound_at_rest_are_told(self):
        chain_scene()
        settings = settings_of_scene(FindOptions(kinds=("rotation", "scale")))
        wide = tuple(
            type(c)(c.name, c.channel, -3, 1, 1, c.group) if c.name == "still.scale_x" else c for c in settings.controls
        )
        joints, _ = joints_of_scene(BakeSettings("face", settings.meshes, wide, "rig"))
        self.assertIn('bones "still" are mirrored or flat', joints.notes[0])
        self.assertNotIn("still", [joint.name for joint in joints.joints])
        _, rig = chain_scene()
        rig.pose.bones["still"].scale = (0, 0, 0)
        joints, _ = joints_of_scene(settings_of_scene())
        self.assertIn('bones "still" are mirrored or flat', joints.notes[0])
        self.assertEqual([joint.name for joint in joints.joints], ["base", "tip", "copy"])
        _, rig = chain_scene()
        rig.pose.bones["tip"].rotation_euler = (0, 0, 0.4)
        settings = settings_of_scene()
        settings = settings.without([c.name for c in settings.controls if c.name == "tip.rot_z"])
        self.assertRegex(joints_of_scene(settings)[0].notes[0], 'bones "tip" .* other than where they are bound')

    def test_vertices_that_a_modifier_makes_have_weights(self):
        face, _ = chain_scene()
        face.modifiers.new("Finer", "SUBSURF")
        settings, _ = found(TURNS, "rig")
        settings = BakeSettings("face", settings.meshes, settings.controls, "rig", modifiers="apply")
        joints, rest = joints_of_scene(settings)
        self.assertEqual(joints.skin.weights.shape[0], len(rest))
        self.assertGreater((joints.skin.weights[: len(rest) - 9].sum(1) > 0.99).sum(), 100)

    def test_a_bake_with_joints_is_nearer_to_its_rig(self):
        with tempfile.TemporaryDirectory(prefix="facebaker-joints-") as name:
            folder = pathlib.Path(name)
            chain_scene()
            bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"))
            errors = {}
            for policy in "keep", "none":
                printed = headless(
                    folder / "scene.blend", "bake", "--out", folder / f"{policy}.fbk", "--channels", "rotation",
                    "--recipe", "compact", "--rig-budget", 1500, "--workers", 1, "--driven-joints", policy,
                    "--json", folder / f"{policy}.json",
                )  # fmt: skip
                self.assertNotIn("Traceback", printed)
                errors[policy] = json.loads((folder / f"{policy}.json").read_text())["errors"][-1]
            face = facebaker.load(folder / "keep.fbk")
            self.assertEqual([joint.name for joint in face.driven_joints], ["base", "tip", "copy"])
            self.assertEqual(len(face.joints), 0)
            self.assertEqual(len(facebaker.load(folder / "none.fbk").driven_joints), 0)
            self.assertEqual(load_settings(folder / "none.blender" / "settings.json").driven_joints, "none")
            print(f"mse with joints {errors['keep']['mse']:.1e}, without {errors['none']['mse']:.1e}")
            self.assertLess(errors["keep"]["mse"], 0.1 * errors["none"]["mse"])
            self.assertLess(errors["keep"]["max"], 0.5 * errors["none"]["max"])
