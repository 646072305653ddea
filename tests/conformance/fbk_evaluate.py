"""EVALUATION.md. For fbk_read.py, whose Face is used."""
import functools
import itertools
import math
import operator

import numpy as np

import fbk_joints
from fbk_basis import HAT, IDENTITY, MINIMUM, PRODUCT
from fbk_bytes import F, added, require

LIMIT = 32512
TANH_MOST = F(7.90531110763549805)
TANH_P = [F(x) for x in (-2.76076847742355e-16, 2.00018790482477e-13, -8.60467152213735e-11, 5.12229709037114e-08,
                         1.48572235717979e-05, 6.37261928875436e-04, 4.89352455891786e-03)]
TANH_Q = [F(x) for x in (1.19825839466702e-06, 1.18534705686654e-04, 2.26843463243900e-03, 4.89352518554385e-03)]


def digits(q, bits, base=256):
    """Of quantised values: the high and the low digits, or the values themselves."""
    if bits == 8:
        return [q]
    low = (q + base // 2) % base - base // 2
    return [(q - low) // base, low]


def limit_of(summands):
    """The limit for sums over the last axis of these digits."""
    largest = max(int(np.abs(summands).sum(-1).max()), 1)
    return min(LIMIT, (2**31 - 1) // largest)


def quantise(x, limit):
    magnitudes = np.abs(x)
    magnitudes[~(magnitudes <= F(2.0**100))] = F(2.0**100)
    m = magnitudes.max(initial=F(0))
    if m < F(2.0**-100):
        return np.zeros(len(x), np.int64), F(0)
    q = np.rint(x * (F(limit) / m))
    q[np.isnan(q)] = 0
    return np.clip(q, -limit, limit).astype(np.int64), m / F(limit)


def horner(coefficients, s):
    return functools.reduce(lambda value, coefficient: value * s + coefficient, coefficients)


def tanh(y):
    y = np.clip(y, -TANH_MOST, TANH_MOST)  # NaN stays
    s = y * y
    return y * horner(TANH_P, s) / horner(TANH_Q, s)


ACTIVATIONS = [  # linear, relu, tanh, silu
    lambda y: y,
    lambda y: np.where(y > 0, y, F(0)),
    tanh,
    lambda y: y * (F(0.5) + F(0.5) * tanh(F(0.5) * y)),
]


def prepare(face):
    """Computes what is the same in every pose."""
    for region in face.regions:
        for layer in region.layers:
            layer.digits = np.stack(digits(layer.weights, layer.bits))
            layer.limit = limit_of(layer.digits)
        region.rest = run_layers(region, np.zeros(len(region.features), F))
        require(np.isfinite(region.rest).all(), "network: not finite at rest")
    order = np.array(face.order)
    for block in face.row_blocks:
        summands = []
        for segment in block.segments:
            largest = np.abs(segment.values).max()
            segment.base = next(base for base in (2, 4, 8, 16, 32, 64, 128, 256) if largest <= 127 * base)
            summands += digits(segment.values, segment.bits, segment.base)
        block.matrix = np.array(summands, np.int64).reshape(-1, block.rows).T
        block.limit = limit_of(block.matrix)
        rows = np.arange(block.first, block.end)
        block.coordinates = 3 * order[rows // 3] + rows % 3
    require(not any(exact_weights(face, face.rest_controls)), "exact-poses: a pose reaches the rest pose")


def feature_values(face, controls):
    values = []
    for feature in face.features:
        if feature.kind in (PRODUCT, MINIMUM):
            a, b = values[feature.first], values[feature.second]
            if feature.kind == PRODUCT:
                values.append(F(0) if a == 0 or b == 0 else a * b)
            else:
                values.append(a if a < b else b)
        else:
            control, rest = controls[feature.control], face.rest_controls[feature.control]
            u = F(0) if control == rest else (control - rest) * feature.scale
            t = u - feature.threshold
            if feature.kind == HAT:
                falling = F(1) + (F(1) - t) * feature.fall
                t = t if t < falling else falling
            values.append(u if feature.kind == IDENTITY else t if t > 0 else F(0))
    return np.array(values, F)


def run_layers(region, x):
    for layer in region.layers:
        q, step = quantise(x, layer.limit)
        *high, low = (layer.digits @ q).astype(F)
        sums = F(256) * high[0] + low if high else low
        y = ACTIVATIONS[layer.activation](layer.scales * step * sums + layer.bias)
        x = y + x if layer.skip else y
    return x


def gate_value(region, features):
    if not region.gate:
        return F(1)
    sizes = np.abs(features[region.gate])
    gate = region.slope * (added(sizes) - max(F(0), *sizes))
    gate = gate if gate > 0 else F(0)
    return gate if gate < 1 else F(1)


def coefficients_of(face, features):
    parts = [features[face.direct]]
    for region in face.regions:
        x, gate = features[region.features], gate_value(region, features)
        if x.any() and gate != 0:
            parts.append((run_layers(region, x) - region.rest) * gate)
        else:
            parts.append(np.zeros(len(region.rest), F))
    return np.concatenate(parts)


def places_of(face, controls):
    return (controls - face.low) / (face.high - face.low)


def exact_weights(face, controls):
    """The weight of each exact pose."""
    places, weights = places_of(face, controls), []
    for pose in face.exact:
        differences = places - places_of(face, pose.controls)
        near = F(1) - added(differences * differences) * pose.falloff
        weights.append(near * near if near > 0 else F(0))
    total = added(weights)
    return [weight / total for weight in weights] if total > 1 else weights


def displaced(face, controls, factors=F(1)):
    """All points of a pose, before joints move them; factors: of coefficients, at a level of detail."""
    require(not np.isnan(controls).any(), "a control is not a number")
    controls = np.clip(controls, face.low, face.high)
    weights = exact_weights(face, controls)
    coefficients = coefficients_of(face, feature_values(face, controls))
    coefficients = np.where(factors == 0, F(0), coefficients * factors)
    rest = np.append(face.rest, np.zeros(3 * (face.points - face.vertices), F))
    positions = rest.copy()
    for block in face.row_blocks:
        summands = []
        for segment in block.segments:
            coefficient = coefficients[segment.column]
            if segment.bits == 16:
                summands.append(coefficient * (segment.scale * F(segment.base)))
            summands.append(coefficient * segment.scale)
        q, step = quantise(np.array(summands, F), block.limit)
        at = block.coordinates
        if step != 0:
            positions[at] = rest[at] + step * (block.matrix @ q).astype(F)
        for weight, pose in zip(weights, face.exact):
            corrections = pose.corrections[block.first : block.end]
            if weight > 0 and corrections.any():
                positions[at] = positions[at] + weight * corrections
    return positions


def evaluate(face, controls):
    """Positions, channels and frames of driven joints of a pose."""
    points, channels = displaced(face, controls), []
    for (_, low, high, at_rest, scale), x in zip(face.channels, points[3 * face.vertices :]):
        value = at_rest + scale * x
        channels.append((value if value < high else high) if value > low else low)
    positions, joints = fbk_joints.skinned(face, points)
    return positions, np.array(channels, F), joints


def positions_at(face, controls, lod):
    """The positions of all vertices at a level of detail."""
    lod = min(lod, len(face.levels))
    number = int(lod)
    share = F(lod - number)
    factors = np.ones(face.coefficients, F)
    if number > 0:
        factors[~face.levels[number - 1].used] = 0
    if share > 0:
        factors[(factors != 0) & ~face.levels[number].used] = F(1) - share
    points = displaced(face, controls, factors).reshape(-1, 3)

    def on_surface(corners, weights):
        a, b, c = (weight * points[v] for weight, v in zip(weights, corners))
        return (a + b) + c

    if share > 0:
        for v, corners, weights in face.levels[number].points:
            points[v] = points[v] + share * (on_surface(corners, weights) - points[v])
    for level in reversed(face.levels[:number]):
        for v, corners, weights in level.points:
            points[v] = on_surface(corners, weights)
    return fbk_joints.skinned(face, points.ravel())[0]


def product(a, b):
    """Of matrices; the sums are taken from left to right."""
    return functools.reduce(operator.add, [np.outer(a[:, k], b[k]) for k in range(len(b))])


def best_rotation(s):
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = s
    d = 2 * math.sqrt(added((s * s).ravel(), 0.0))
    m = np.array([
        [xx + yy + zz + d, yz - zy, zx - xz, xy - yx],
        [yz - zy, xx - yy - zz + d, xy + yx, zx + xz],
        [zx - xz, xy + yx, yy - xx - zz + d, yz + zy],
        [xy - yx, zx + xz, yz + zy, zz - xx - yy + d],
    ])
    for step in range(25):
        trace = m[0, 0] + m[1, 1] + m[2, 2] + m[3, 3]
        if not trace > 0:
            return np.eye(3)
        m = m / trace
        if step < 24:
            m = product(m, m)
    row = m[np.argmax(m.diagonal())]
    w, x, y, z = row / math.sqrt(added(row * row, 0.0))
    return np.array([
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ])


def posed_frame(face, socket, positions):
    p, q = (points.reshape(-1, 3)[socket.vertices].astype(float) for points in (face.rest, positions))
    w = socket.weights.astype(float)[:, np.newaxis]
    p_centre, q_centre = added(w * p, 0.0) / added(w, 0.0), added(w * q, 0.0) / added(w, 0.0)
    s = added(map(np.outer, w * (p - p_centre), q - q_centre), 0.0)
    frame = socket.frame.reshape(3, 4).astype(float)
    frame[:, 3] -= p_centre
    frame = product(best_rotation(s), frame)
    frame[:, 3] += q_centre
    frame = frame.astype(F).ravel()
    return frame if np.isfinite(frame).all() else socket.frame


def expected_errors(face, controls):
    """The errors of the face and of its regions, and the number of controls outside of what was trained."""
    errors, sums, low, high, rest = face.errors, face.errors.constants, face.low, face.high, face.rest_controls
    values = np.clip(controls, low, high)
    moved = values != rest
    reached = np.minimum(np.abs(values - rest) / np.maximum(high - rest, rest - low), F(1))
    effects = reached * np.sqrt(reached)
    for control in np.flatnonzero(moved):
        sums = sums + effects[control] * errors.weights[control]
    mean = added(F(size) / F(face.vertices) * region for size, region in zip(errors.sizes, sums))
    places = (values - low) * (F(255) / (high - low))
    outside = moved & ((places < errors.lowest) | (places > errors.highest))
    far = np.flatnonzero(moved & (reached >= 0.25))
    for a, b in itertools.combinations(far, 2):
        if errors.pairs[b * (b - 1) // 2 + a]:
            outside[[a, b]] = True
    return errors.unit * np.sqrt(np.array([mean, *sums])), outside.sum()
