"""Rotation vectors (axis times angle, radians) and quaternions (w, x, y, z) of unit length. Without Blender.

Rodrigues' exponential map: q = (cos(a / 2), sin(a / 2) v / a) with a = |v|; see F. S. Grassia, Practical parameterization of
rotations using the exponential map, 1998."""

from __future__ import annotations

import math
from typing import Sequence, Tuple

Vector = Tuple[float, float, float]
Quaternion = Tuple[float, float, float, float]

_SMALL = 1e-8  # below, sin(a / 2) / a is 1 / 2 to the last digit


def quaternion_of_vector(vector: Sequence[float]) -> Quaternion:
    """A unit quaternion; the vector may be of any length."""
    x, y, z = vector
    angle = math.sqrt(x * x + y * y + z * z)
    factor = 0.5 if angle < _SMALL else math.sin(0.5 * angle) / angle
    return math.cos(0.5 * angle), factor * x, factor * y, factor * z


def vector_of_quaternion(quaternion: Sequence[float]) -> Vector:
    """A vector of at most pi; the quaternion need not be of unit length. Zero for a quaternion of zeros."""
    w, x, y, z = quaternion
    length = math.sqrt(x * x + y * y + z * z)
    if w < 0:  # the same rotation, the short way round
        w, x, y, z = -w, -x, -y, -z
    if length == 0:
        return 0.0, 0.0, 0.0
    factor = 2 * math.atan2(length, w) / length
    return factor * x, factor * y, factor * z
