"""Numbers of joints, without Blender."""

import unittest

try:
    import numpy as np
except ImportError:
    raise unittest.SkipTest("NumPy is not installed")

from facebaker_blender.joint_motion import NUMBERS, can_be_followed, joint_numbers, number_reach, upright


def turn(vector):
    """(4, 4): by Rodrigues' formula."""
    angle = np.linalg.norm(vector)
    x, y, z = np.array(vector) / angle if angle else (0, 0, 0)
    cross = np.array([(0, -z, y), (z, 0, -x), (-y, x, 0)])
    result = np.eye(4)
    result[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return result


def frame(numbers):
    """(4, 4): what the numbers of a joint do in its own axes."""
    result = turn(numbers[:3])
    result[:3, :3] *= 1 + np.array(numbers[6:])
    result[:3, 3] = numbers[3:6]
    return result


class JointMotionTest(unittest.TestCase):
    rest = turn((0.4, -1.1, 0.3)) + np.array([(0, 0, 0, 2), (0, 0, 0, -1), (0, 0, 0, 0.5), (0, 0, 0, 0)])

    def test_numbers_are_those_that_made_the_motion(self):
        random = np.random.default_rng(1)
        numbers = random.uniform(-1, 1, (40, 9)) * ([1.7] * 3 + [2] * 3 + [0.4] * 3)
        numbers[0], numbers[1, :3], numbers[2, :3] = 0, (3.1, 0, 0), (0, -3.1, 0.1)
        above = np.array([turn(v) for v in random.normal(size=(40, 3))])
        motions = above @ self.rest @ np.array([frame(n) for n in numbers]) @ np.linalg.inv(self.rest)
        np.testing.assert_allclose(joint_numbers(motions, above, self.rest), numbers, atol=1e-12)
        self.assertEqual(len(NUMBERS), 9)
        # Of a joint that moves as its parent does, none.
        np.testing.assert_allclose(joint_numbers(above, above, self.rest), np.zeros((40, 9)), atol=1e-12)

    def test_reach_is_how_far_a_unit_moves_a_point(self):
        points = np.array([(2, -1, 0.5), (2.5, 0, 1), (1, -1.5, 0)])
        reach, little = number_reach(self.rest, points), 1e-6
        for number in range(9):
            moved = self.rest @ frame(little * np.eye(9)[number]) @ np.linalg.inv(self.rest)
            by = points @ moved[:3, :3].T + moved[:3, 3] - points
            self.assertAlmostEqual(reach[number], np.linalg.norm(by, axis=1).max() / little, delta=1e-5)

    def test_axes_are_set_upright(self):
        stretched = self.rest @ np.diag([2, 0.5, 3, 1])
        np.testing.assert_allclose(upright(stretched), self.rest, atol=1e-12)
        mirrored = upright(self.rest @ np.diag([1, 1, -1, 1]))
        self.assertAlmostEqual(np.linalg.det(mirrored[:3, :3]), 1)

    def test_what_is_mirrored_or_flat_is_not_followed(self):
        self.assertTrue(can_be_followed(np.array([self.rest, np.diag([2, 1, 0.1, 1])])))
        for third in (-1, 0):
            self.assertFalse(can_be_followed(np.array([np.eye(4), np.diag([1, 1, third, 1])])))


if __name__ == "__main__":
    unittest.main()
