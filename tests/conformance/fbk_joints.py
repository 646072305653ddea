"""Driven joints: section driven-joints of FORMAT.md, and what EVALUATION.md says of them. For fbk_read.py."""
from types import SimpleNamespace

import numpy as np

from fbk_bytes import F, added

NONE = 2**32 - 1  # no parent
ROTATION, TRANSLATION, SCALE, PIVOT = range(0, 3), range(3, 6), range(6, 9), range(9, 12)
SINE = [F(x) for x in (1, -0.16666667, 0.00833333, -0.00019841081, 2.7553501e-06, -2.5014108e-08, 1.5851925e-10,
                       -7.011425e-13, 1.7545592e-15)]
COSINE = [F(x) for x in (0.5, -0.041666668, 0.0013888887, -2.480149e-05, 2.7555345e-07, -2.0857125e-09, 1.1363965e-11,
                         -4.4529386e-14, 1.02308114e-16)]


def read_driven_joints(c, face):
    face.driven, depths = [], []
    for j in range(c.u32(1, 65536)):
        joint = SimpleNamespace(name=c.new_name(), parent=c.u32(), numbers=int(c.array("u2", 1)[0]), scales={})
        c.check(joint.parent < j or joint.parent == NONE, f"parent of {joint.name}")
        c.check(joint.numbers < 4096, f"unknown numbers of {joint.name}")
        rotations = c.take(c.take(1)[0])
        c.check(len(rotations) <= 15, f"outer rotations of {joint.name}")
        c.check(all(bits > 0 for bits in rotations), f"an outer rotation of {joint.name} without numbers")
        c.check(all(bits < 8 for bits in rotations), f"unknown numbers of an outer rotation of {joint.name}")
        joint.outer = [range(12 + 3 * i, 15 + 3 * i) for i in range(len(rotations))]
        for outer, bits in zip(joint.outer, rotations):
            joint.numbers |= bits << outer[0]
        joint.rest = c.floats(12).reshape(3, 4)
        depths.append(1 if joint.parent == NONE else depths[joint.parent] + 1)
        c.check(depths[-1] <= 256, f"{joint.name} has too many joints above it")
        face.driven.append(joint)
    for joint in face.driven:
        for number in range(joint.numbers.bit_length()):
            if joint.numbers >> number & 1:
                joint.scales[number] = c.f32()
                c.check(joint.scales[number] > 0, f"a scale of {joint.name}")
    numbers = sum(len(joint.scales) for joint in face.driven)
    face.first_number = 3 * face.points
    face.points += (numbers + 2) // 3  # those behind the vertices carry numbers
    most, counts = c.u32(1, 32), list(c.take(face.vertices))
    c.check(max(counts) <= most, "influences of a vertex")
    joints, weights = c.array("u2", sum(counts)).tolist(), c.array("u2", sum(counts)).tolist()
    c.check(all(j < len(face.driven) for j in joints) and all(w > 0 for w in weights), "a joint or a weight")
    face.influences, at = [], 0
    for v, count in enumerate(counts):
        c.check(sum(weights[at : at + count]) <= 32768, f"weights of vertex {v}")
        face.influences.append([(j, F(w) / F(32768)) for j, w in zip(joints[at : at + count], weights[at : at + count])])
        at += count


def polynomial(coefficients, x):
    value = coefficients[-1]
    for coefficient in coefficients[-2::-1]:
        value = value * x + coefficient
    return value


def times(a, b):
    """The product of the first three columns of a with the three rows of b."""
    return (a[:, 0:1] * b[0] + a[:, 1:2] * b[1]) + a[:, 2:3] * b[2]


def rotation(v):
    """Less the identity."""
    x, y, z = v
    square = (x * x + y * y) + z * z
    square = square if square < F(40) else F(40)
    s, c = polynomial(SINE, square), polynomial(COSINE, square)
    xy, xz, yz = c * (x * y), c * (x * z), c * (y * z)
    return np.array([[-c * (y * y + z * z), xy - s * z, xz + s * y],
                     [xy + s * z, -c * (x * x + z * z), yz - s * x],
                     [xz - s * y, yz + s * x, -c * (x * x + y * y)]], F)


def own_change(joint, numbers):
    axes, origin = joint.rest[:, :3], joint.rest[:, 3:]

    def along_axes(which):
        return times(axes, np.array([[numbers.get(n, F(0))] for n in which], F))

    linear = rotation(along_axes(ROTATION).ravel())
    for outer in joint.outer:
        if any(numbers.get(n, F(0)) != 0 for n in outer):
            further = rotation(along_axes(outer).ravel())
            linear = (further + linear) + times(further, linear)
    moved = along_axes(TRANSLATION)
    if any(n in joint.scales for n in PIVOT):
        moved = moved - times(linear, along_axes(PIVOT))
    if any(n in joint.scales for n in SCALE):
        sizes = [numbers.get(n, F(0)) for n in SCALE]
        parts = [size * np.outer(axis, axis) for size, axis in zip(sizes, axes.T)]
        lengths = (parts[0] + parts[1]) + parts[2]
        linear = (linear + lengths) + times(linear, lengths)
    return np.hstack([linear, moved - times(linear, origin)])


def changes(face, points):
    """Of each driven joint, what is added to the axes and the origin of space; None where it is still."""
    found, at = [], face.first_number
    for joint in face.driven:
        coordinates = points[at : at + len(joint.scales)]
        at += len(joint.scales)
        above = None if joint.parent == NONE else found[joint.parent]
        if not coordinates.any():
            found.append(above)
            continue
        own = own_change(joint, {n: scale * x for (n, scale), x in zip(joint.scales.items(), coordinates)})
        found.append(own if above is None else (above + own) + times(above, own))
    return found


def skinned(face, points):
    """Positions of the vertices, and frames of the driven joints."""
    moved = changes(face, points)
    positions = points[: 3 * face.vertices].reshape(-1, 3).copy()
    for v, influences in enumerate(face.influences):
        blend = added([weight * moved[j] for j, weight in influences if moved[j] is not None], np.zeros((3, 4), F))
        x, y, z = positions[v]
        offset = (blend[:, 0] * x + blend[:, 1] * y) + (blend[:, 2] * z + blend[:, 3])
        moves = (offset < 0) | (offset > 0)
        positions[v][moves] += offset[moves]
    frames = []
    for joint, change in zip(face.driven, moved):
        frame = joint.rest.copy()
        if change is not None:
            follow = times(change, joint.rest)
            follow[:, 3] += change[:, 3]
            frame += follow
        frames.append(frame.ravel())
    return positions.ravel(), np.array(frames, F).ravel()
