"""A rig for the tests, which is small and not linear: a grid of 81 vertices with three controls."""

import numpy as np

import facebaker

SIDE = 9
REST = np.array(
    [(x, y, -0.3 * (x * x + y * y)) for y in np.linspace(-1, 1, SIDE) for x in np.linspace(-1, 1, SIDE)], np.float32
)
QUADS = [(i, i + 1, i + SIDE + 1, i + SIDE) for i in range(SIDE * (SIDE - 1)) if i % SIDE < SIDE - 1]
CONTROLS = [
    facebaker.Control("jaw_open", "mouth", arkit="jawOpen", facs="AU26"),
    facebaker.Control("smile_L", "mouth", -0.5, 1, 0.25, mirror="smile_R"),
    facebaker.Control("smile_R", "mouth", -0.5, 1, 0.25, mirror="smile_L"),
]


def positions(controls):
    """(poses, 3) -> (poses, 81, 3)."""
    jaw, left, right = (controls[:, i : i + 1].astype(np.float64) for i in range(3))
    points = np.repeat(REST[None].astype(np.float64), len(controls), 0)
    x, y = REST[:, 0], REST[:, 1]
    points[:, :, 1] -= jaw * np.exp(-3 * (y + 1) ** 2)
    points[:, :, 0] += 0.3 * ((left - 0.25) * np.maximum(x, 0) ** 2 - (right - 0.25) * np.minimum(x, 0) ** 2)
    points[:, :, 2] += 0.2 * jaw * (left - 0.25) ** 2 * x
    return points


def poses(count, seed=1):
    low, high = np.array([(control.minimum, control.maximum) for control in CONTROLS]).T
    return np.random.default_rng(seed).uniform(low, high, (count, len(CONTROLS))).astype(np.float32)


def make(evaluate=positions, **options):
    given = {"name": "toy", "polygons": QUADS, "rest_positions": REST, **options}
    return facebaker.Rig(CONTROLS, evaluate, **given)


def make_recording(frames=300):
    train, test = poses(frames), poses(40, 2)
    clips = [
        facebaker.Clip("train", train, "dense", positions=positions(train)),
        facebaker.Clip("test", test, split="test", positions=positions(test)),
    ]
    return make(None, clips=clips)
