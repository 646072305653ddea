"""Rigs in Python whose joints the controls drive."""

import os
import pathlib
import shlex
import sys
import tempfile
import unittest

try:
    import numpy as np
except ImportError:
    raise unittest.SkipTest("NumPy is not installed")

import facebaker
from facebaker import Joint, Rig, Skin

sys.path.insert(0, str(pathlib.Path(__file__).parents[3] / "tests/rigs/joint_face"))
import joint_face

REST = np.array([(x, y, 0) for y in range(3) for x in range(3)], np.float32)
NUMBERS = ("rotate_z", "move_x")


def at(angle, shift):
    """A joint at (1, 1, 0) that turned and moved."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([(cosine, -sine, 0, 1 + shift), (sine, cosine, 0, 1), (0, 0, 1, 0)])


def evaluate(controls):
    """The joint takes the upper row along, and "wide" moves it before that."""
    positions = np.repeat(REST[None].astype(float), len(controls), 0)
    frames = np.array([[at(turn, shift)] for turn, shift, _ in controls.astype(float)])
    for pose, (_, _, wide) in enumerate(controls):
        local = positions[pose, 6:] * (1 + 0.1 * wide, 1, 1) - (1, 1, 0)
        positions[pose, 6:] = local @ frames[pose, 0, :, :3].T + frames[pose, 0, :, 3]
    return positions, frames


def rig(**options):
    given = {
        "joints": [Joint("head"), Joint("lid", 0, at(0, 0), None, NUMBERS)],
        "skin": Skin(np.repeat([[0], [0], [1]], 3, 0), np.ones((9, 1))),
        "skinned": True,
        **options,
    }
    return Rig(["turn", "shift", "wide"], lambda c: with_head(*evaluate(c)), polygons=[(0, 1, 4, 3)], **given)


def with_head(positions, frames):
    return positions, np.concatenate([np.repeat(np.eye(3, 4)[None, None], len(frames), 0), frames], 1)


def bake_of(source, out):
    return facebaker.bake(source, out, recipe="compact", poses=200, progress=None).load()


class TestJoints(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.out = pathlib.Path(folder.name) / "face.fbk"

    def test_a_joint_that_controls_drive(self):
        face = bake_of(rig(), self.out)
        self.assertEqual([(joint.name, joint.numbers) for joint in face.driven_joints], [("lid", NUMBERS)])
        self.assertEqual([joint.name for joint in face.joints], ["head"])
        poses = np.random.default_rng(1).uniform(0, 1, (20, 3)).astype(np.float32)
        frames = np.empty((20, 1, 3, 4), np.float32)
        seen = face.evaluate_batch(poses, joints=frames)
        positions, true = evaluate(poses)
        np.testing.assert_allclose(seen, positions, atol=2e-3)
        np.testing.assert_allclose(frames, true, atol=2e-3)

    def test_a_rig_in_another_process_is_the_same(self):
        here = bake_of(rig(), self.out)
        words = [sys.executable, "-B", "-m", "facebaker.serve", "test_joints:rig"]
        paths = [pathlib.Path(facebaker.__file__).parents[1], pathlib.Path(__file__).parent]
        path = os.pathsep.join(map(str, paths))
        there = bake_of(f"exec:PYTHONPATH={shlex.quote(path)} {shlex.join(words)}", self.out.with_name("served.fbk"))
        self.assertEqual(there.driven_joints[0].name, "lid")
        poses = np.random.default_rng(2).uniform(0, 1, (20, 3)).astype(np.float32)
        np.testing.assert_array_equal(there.evaluate_batch(poses), here.evaluate_batch(poses))

    def test_what_does_not_fit_is_told(self):
        for words, options in {
            '"lid" has numbers, and the rig is not skinned': {"skinned": False},
            "'turn' is none of rotate_x": {"joints": [Joint("head"), Joint("lid", numbers=("turn",))]},
            "'pivot_x' is none of rotate_x.* scale_z$": {"joints": [Joint("head"), Joint("lid", numbers=("pivot_x",))]},
        }.items():
            with self.assertRaisesRegex(ValueError, words):
                rig(**options)
        with self.assertRaisesRegex(ValueError, "not a tuple of positions and frames"):
            Rig(["a"], lambda controls: REST[None], joints=[Joint("head")], skinned=True)
        with self.assertRaisesRegex(ValueError, "frames that evaluate gave"):
            Rig(
                ["a"], lambda controls: (REST[None], np.zeros((1, 2, 3, 4))), joints=[Joint("head")], skinned=True
            ).evaluate_poses(np.zeros((1, 1), np.float32))
        with self.assertRaisesRegex(ValueError, "a recording is not skinned"):
            Rig(["a"], rest_positions=REST, skinned=True)

    def test_a_face_of_many_joints(self):
        source = joint_face.JointFace(0.04)
        face = facebaker.bake(source.rig(), self.out, recipe="compact", poses=300, progress=None).load()
        self.assertEqual(len(face.driven_joints), 36)
        self.assertEqual(len(face.meshes), 10)
        poses = joint_face.poses_of(source.controls, 20, 0.15, 3)
        off = np.linalg.norm(face.evaluate_batch(poses) - source.evaluate(poses)[0], axis=-1)
        self.assertLess(off.max(), 3e-5 * np.linalg.norm(np.ptp(source.rest, 0)))


if __name__ == "__main__":
    unittest.main()
