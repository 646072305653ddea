"""How joints move within their parents, as the numbers that joints of a baked face have: turns, moves and lengths along
their own axes at rest. Without Blender."""

from __future__ import annotations

from typing import Any

import numpy as np

# In the order of the columns below: of a joint of facebaker.Joint.
NUMBERS = tuple(f"{kind}_{axis}" for kind in ("rotate", "move", "scale") for axis in "xyz")


def upright(frame: Any) -> Any:
    """(4, 4): the orthogonal, right-handed axes of length 1 that are nearest to those of a frame, at its origin."""
    result = frame.copy()
    result[:3, :3] = _rotations(frame[None, :3, :3])[0]
    return result


def _rotations(matrices: Any) -> Any:
    """(poses, 3, 3): the rotations of the polar decomposition; of mirrored matrices the last axis is turned round."""
    left, _, right = np.linalg.svd(matrices)
    left[..., -1] *= np.sign(np.linalg.det(left @ right))[:, None]
    return left @ right


def _rotation_vectors(rotations: Any) -> Any:
    """(poses, 3): axes times angles, of at most half a turn."""
    from .rotations import vector_of_quaternion

    return np.array([vector_of_quaternion(_quaternion(rotation)) for rotation in rotations]).reshape(-1, 3)


def _quaternion(r: Any) -> Any:
    """By the largest of its components, so that none is divided by a small one. Not of unit length."""
    rows = np.array([
        (1 + r[0, 0] + r[1, 1] + r[2, 2], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]),
        (r[2, 1] - r[1, 2], 1 + r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]),
        (r[0, 2] - r[2, 0], r[0, 1] + r[1, 0], 1 - r[0, 0] + r[1, 1] - r[2, 2], r[1, 2] + r[2, 1]),
        (r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], 1 - r[0, 0] - r[1, 1] + r[2, 2]),
    ])  # fmt: skip
    return rows[np.argmax(np.diag(rows))]


def joint_numbers(motions: Any, above: Any, rest: Any) -> Any:
    """(poses, 9): the numbers of a joint. motions, above: (poses, 4, 4), what took the joint and its parent from rest
    to where they are, in the space of positions. rest: (4, 4), its upright frame."""
    own = np.linalg.inv(rest) @ np.linalg.inv(above) @ motions @ rest
    rotations = _rotations(own[:, :3, :3])
    lengths = np.einsum("pij,pij->pj", rotations, own[:, :3, :3]) - 1
    return np.concatenate([_rotation_vectors(rotations), own[:, :3, 3], lengths], 1)


def number_reach(rest: Any, points: Any) -> Any:
    """(9,): how far a unit of each number of a joint with this upright frame moves the furthest of points (n, 3)."""
    local = np.abs((points - rest[:3, 3]) @ rest[:3, :3])
    turned = [np.hypot(local[:, (axis + 1) % 3], local[:, (axis + 2) % 3]).max() for axis in range(3)]
    return np.array([*turned, 1, 1, 1, *local.max(0)])


def can_be_followed(motions: Any) -> bool:
    """Whether none of these motions (poses, 4, 4) mirrors, or makes flat, what follows it."""
    determinants: Any = np.linalg.det(motions[:, :3, :3])
    return bool((determinants > 1e-6).all())
