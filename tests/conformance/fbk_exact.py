"""Exact poses: FORMAT.md, "exact-poses", and EVALUATION.md, "Exact poses". For fbk_read.py and fbk_evaluate.py."""
import numpy as np

from fbk_bytes import require

F = np.float32


def read_exact_poses(c, face):
    names, low, high = [], [control[2] for control in face.controls], [control[3] for control in face.controls]
    for _ in range(c.u32()):
        name, controls, numbers = c.string(), c.array("f4", len(face.controls)), c.array("f4", 2)
        require(name and name not in names, f"exact-poses: name {name!r}")
        require((controls >= low).all() and (controls <= high).all(), f"exact-poses: controls of {name}")
        require(np.isfinite(numbers).all() and (numbers > 0).all(), f"exact-poses: numbers of {name}")
        names.append(name)
        face.exact.append((places_of(face, controls), *numbers))
    require(1 <= len(names) <= 1024, "exact-poses: number of poses")
    rest = places_of(face, [control[4] for control in face.controls])
    for i, (places, falloff, step) in enumerate(face.exact):
        require(weight_of(rest, places, falloff) == 0, f"exact-poses: {names[i]} reaches the rest pose")
        axes = [np.array(c.deltas(face.points), np.uint32).astype(np.int32) for _ in range(3)]
        require(max(np.abs(axis.astype(np.int64)).max() for axis in axes) <= 0xFFFFFF, f"exact-poses: values of {names[i]}")
        face.exact[i] = places, falloff, step * np.stack(axes, 1).reshape(-1).astype(F)
    c.end()


def places_of(face, controls):
    return [(F(value) - low) / (high - low) for value, (_, _, low, high, _) in zip(controls, face.controls)]


def weight_of(places, exact_places, falloff):
    total = F(0)
    for a, b in zip(places, exact_places):
        total = total + (a - b) * (a - b)
    near = F(1) - total * falloff
    return near * near if near > 0 else F(0)


def weights_of(face, controls):
    """The weight of each exact pose, of clamped controls."""
    places = places_of(face, controls)
    weights = [weight_of(places, exact_places, falloff) for exact_places, falloff, _ in face.exact]
    total = F(0)
    for weight in weights:
        total = total + weight
    return [weight / total for weight in weights] if total > 1 else weights


def correct(face, weights, block, positions):
    """Adds the corrections of a row block."""
    rows = slice(block["first"], block["first"] + block["rows"])
    for weight, (_, _, corrections) in zip(weights, face.exact):
        if weight > 0 and corrections[rows].any():
            at = block["coordinates"]
            positions[at] = positions[at] + weight * corrections[rows]
