"""EVALUATION.md, "Quantised values" and "What a reader computes". For fbk_read.py.

`face` is a Face of fbk_read.py: its features, direct, regions, row_blocks, order, rest and controls are used.
"""
import numpy as np

import fbk_exact

F = np.float32
LIMIT = 32512
TANH_MOST = F(7.90531110763549805)
TANH_P = [F(x) for x in (-2.76076847742355e-16, 2.00018790482477e-13, -8.60467152213735e-11, 5.12229709037114e-08,
                         1.48572235717979e-05, 6.37261928875436e-04, 4.89352455891786e-03)]
TANH_Q = [F(x) for x in (1.19825839466702e-06, 1.18534705686654e-04, 2.26843463243900e-03, 4.89352518554385e-03)]


def digits(q, base=256):
    low = (q + base // 2) % base - base // 2
    return (q - low) // base, low


def base_of(values):
    """Of the digits of a 16-bit segment."""
    largest, base = int(np.abs(values).max(initial=0)), 2
    while largest > 127 * base:
        base *= 2
    return base


def limit_of(matrix):
    """The limit of sums over the last axis of these digits."""
    largest = int(np.abs(matrix).sum(-1).max(initial=0)) if matrix.size else 0
    return min(LIMIT, (2**31 - 1) // largest) if largest else LIMIT


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
    value = np.full_like(s, coefficients[0])
    for c in coefficients[1:]:
        value = value * s + c
    return value


def tanh(y):
    y = np.where(y < -TANH_MOST, -TANH_MOST, np.where(y > TANH_MOST, TANH_MOST, y))  # NaN stays
    s = y * y
    return y * horner(TANH_P, s) / horner(TANH_Q, s)


def activate(kind, y):
    if kind == 1:
        return np.where(y > 0, y, F(0))
    if kind == 2:
        return tanh(y)
    if kind == 3:
        return y * (F(0.5) + F(0.5) * tanh(F(0.5) * y))
    return y


def prepare(face):
    for region in face.regions:
        for layer in region["layers"]:
            sums = np.stack(digits(layer["weights"])) if layer["is_16_bit"] else layer["weights"]
            layer["limit"] = limit_of(sums)
        region["rest"] = run_layers(region, np.zeros(len(region["features"]), F))
        if not np.isfinite(region["rest"]).all():
            raise ValueError("network: not finite at rest")
    order = np.array(face.order)
    for block in face.row_blocks:
        rows, summands = np.arange(block["first"], block["first"] + block["rows"]), []
        for segment in block["segments"]:
            if segment["is_16_bit"]:
                segment["base"] = base_of(segment["values"])
                summands += digits(segment["values"], segment["base"])
            else:
                summands.append(segment["values"])
        block["matrix"] = np.stack(summands, 1) if summands else np.zeros((block["rows"], 0), np.int64)
        block["limit"] = limit_of(block["matrix"])
        block["coordinates"] = 3 * order[rows // 3] + rows % 3


def feature_values(face, controls):
    rest = [control[4] for control in face.controls]
    values = []
    for kind, *f in face.features:
        if kind == 3:
            a, b = values[f[0]], values[f[1]]
            values.append(F(0) if a == 0 or b == 0 else a * b)
        elif kind == 4:
            a, b = values[f[0]], values[f[1]]
            values.append(a if a < b else b)
        else:
            control, scale, threshold, fall = f
            u = F(0) if controls[control] == rest[control] else (controls[control] - rest[control]) * scale
            t = u - threshold
            if kind == 2:
                falling = F(1) + (F(1) - t) * fall
                t = t if t < falling else falling
            values.append(u if kind == 0 else t if t > 0 else F(0))
    return np.array(values, F)


def run_layers(region, x):
    for layer in region["layers"]:
        q, step = quantise(x, layer["limit"])
        if layer["is_16_bit"]:
            high, low = (d @ q for d in digits(layer["weights"]))
            sums = F(256) * high.astype(F) + low.astype(F)
        else:
            sums = (layer["weights"] @ q).astype(F)
        y = activate(layer["activation"], layer["scales"] * step * sums + layer["bias"])
        x = y + x if layer["skip"] else y
    return x


def coefficients_of(face, features):
    parts = [features[face.direct]]
    for region in face.regions:
        x = features[region["features"]]
        gate = F(1)
        if region["gate"]:
            total = largest = F(0)
            for f in region["gate"]:
                size = np.abs(features[f])
                total = total + size
                largest = size if size > largest else largest
            gate = region["slope"] * (total - largest)
            gate = gate if gate > 0 else F(0)
            gate = gate if gate < 1 else F(1)
        if not x.any() or gate == 0:
            parts.append(np.zeros(len(region["rest"]), F))
            continue
        y = run_layers(region, x) - region["rest"]
        parts.append(y * gate if region["gate"] else y)
    return np.concatenate(parts).astype(F)


def channel_value(channel, coordinate):
    _, low, high, rest, scale = channel
    value = rest + scale * coordinate
    return (value if value < high else high) if value > low else low


def evaluate(face, controls, factors=None):
    """Positions and channels of a pose; factors: of coefficients, at a level of detail."""
    if np.isnan(controls).any():
        raise ValueError("a control is not a number")
    controls = [min(max(c, control[2]), control[3]) for c, control in zip(controls, face.controls)]
    weights = fbk_exact.weights_of(face, controls)
    coefficients = coefficients_of(face, feature_values(face, controls))
    if factors is not None:
        coefficients = np.where(factors == 0, F(0), np.where(factors == 1, coefficients, coefficients * factors))
    rest = np.concatenate([face.rest, np.zeros(3 * (face.points - face.vertices), F)])
    positions = rest.copy()
    for block in face.row_blocks:
        summands = []
        for segment in block["segments"]:
            coefficient = coefficients[segment["column"]]
            if segment["is_16_bit"]:
                summands.append(coefficient * (segment["scale"] * F(segment["base"])))
            summands.append(coefficient * segment["scale"])
        q, step = quantise(np.array(summands, F), block["limit"])
        if step != 0:
            at = block["coordinates"]
            positions[at] = rest[at] + step * (block["matrix"] @ q).astype(F)
        fbk_exact.correct(face, weights, block, positions)
    behind = 3 * face.vertices
    values = [channel_value(channel, x) for channel, x in zip(face.channels, positions[behind:])]
    return positions[:behind], np.array(values, F)
