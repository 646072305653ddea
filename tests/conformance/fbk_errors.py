"""Expected errors: FORMAT.md, "expected-errors", and EVALUATION.md, "Expected errors". For fbk_read.py."""
import numpy as np

from fbk_bytes import require

F = np.float32


def read_expected_errors(c, face):
    controls = len(face.controls)
    unit = c.array("f4", 1)[0]
    require(np.isfinite(unit) and unit > 0, "expected-errors: unit")
    names, constants = [], []
    for _ in range(c.u32()):
        name, constant = c.string(), c.array("f4", 1)[0]
        require(name and name not in names, f"expected-errors: name {name!r}")
        require(np.isfinite(constant) and constant >= 0, f"expected-errors: constant of {name}")
        names.append(name)
        constants.append(constant)
    require(1 <= len(names) <= 64, "expected-errors: number of regions")
    sizes = [0] * len(names)
    for _ in range(c.u32()):
        vertices, region = c.u32(), c.u32()
        require(vertices > 0 and region < len(names), "expected-errors: a run")
        sizes[region] += vertices
    require(sum(sizes) == face.vertices and min(sizes) > 0, "expected-errors: vertices of regions")
    weights = [decoded(code) for code in c.take(controls * len(names))]
    low, high = c.take(controls), c.take(controls)
    require(all(a <= b for a, b in zip(low, high)), "expected-errors: trained values")
    pairs = c.take((controls * (controls - 1) // 2 + 7) // 8)
    bits = int.from_bytes(pairs, "little")
    require(bits >> controls * (controls - 1) // 2 == 0, "expected-errors: pairs")
    face.errors = unit, names, constants, sizes, np.array(weights, F).reshape(controls, -1), low, high, bits
    c.end()


def decoded(code):
    return 0.0 if code == 0 else (8 + code % 8) * 2.0 ** ((code >> 3) - 35)


def expected_errors(face, controls):
    """The errors of the face and of its regions, and the number of controls outside of what was trained."""
    unit, _, sums, sizes, weights, low, high, pairs = face.errors
    beyond, together = set(), []
    for i, (value, (*_, minimum, maximum, rest)) in enumerate(zip(controls, face.controls)):
        value = min(max(value, minimum), maximum)
        if value == rest:
            continue
        reached = min(np.abs(value - rest) / max(maximum - rest, rest - minimum), F(1))
        effect = reached * np.sqrt(reached)
        sums = [s + effect * w for s, w in zip(sums, weights[i])]
        place = (value - minimum) * (F(255) / (maximum - minimum))
        if place < low[i] or place > high[i]:
            beyond.add(i)
        if reached >= 0.25:
            together.append(i)
    for n, b in enumerate(together):
        for a in together[:n]:
            if pairs >> b * (b - 1) // 2 + a & 1:
                beyond |= {a, b}
    mean = F(0)
    for size, s in zip(sizes, sums):
        mean = mean + F(size) / F(face.vertices) * s
    return np.array([unit * np.sqrt(s) for s in [mean, *sums]], F), len(beyond)
