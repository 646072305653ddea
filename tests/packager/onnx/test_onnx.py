#!/usr/bin/env python3
"""test_onnx.py FACEBAKER FACE.fbk...: the ONNX model that is exported of a face, evaluated by NumPy, gives the positions
of the evaluator to the last bit, at rest, at the ends of all ranges, beyond them, and in between, and the frames of
driven joints that the independent reader of tests/conformance finds."""
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

sys.path.append(str(pathlib.Path(__file__).parents[2] / "conformance"))
import fbk_evaluate
from fbk_read import Face
from onnx_reading import Model, read_mdd


def tool(*arguments):
    done = subprocess.run([str(a) for a in arguments], capture_output=True, text=True)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, arguments))}: {done.stderr}")
    return done.stdout


def poses_of(controls, seed=1):
    """Rest; each control by itself at its ends; random poses with few, with half and with all controls; all at ends."""
    low, high, rest = (np.array([c[k] for c in controls], np.float32) for k in ("min", "max", "default"))
    singles = np.concatenate([np.where(np.eye(len(rest), dtype=bool), end, rest) for end in (low, high)])
    random = np.random.default_rng(seed)
    blocks = [rest[None], singles, low[None], high[None]]
    for share in (0.1, 0.5, 1.0):
        values = random.uniform(low, high, (40, len(rest)))
        blocks.append(np.where(random.random(values.shape) < share, values, rest))
    blocks.append(np.where(random.random((40, len(rest))) < 0.5, low, high))
    return np.concatenate(blocks).astype(np.float32)


def write_poses(face, onnx, folder):
    """Exports a face; gives its model, poses, and the evaluator's positions in these."""
    tool(sys.argv[1], "export", face, onnx)
    model = Model(onnx)
    poses = poses_of(json.loads(model.properties["facebaker.controls"]))
    np.save(folder / "poses.npy", poses)
    tool(sys.argv[1], "export", face, folder / "poses.mdd", "--clip", folder / "poses.npy")
    return model, poses, read_mdd(folder / "poses.mdd")


def check_joints(face, model, poses):
    """Gives whether there are driven joints."""
    archived = Face(face.read_bytes())
    names = [joint.name for joint in archived.driven]
    assert json.loads(model.properties.get("facebaker.joints", "[]")) == names
    if not names:
        assert "joints" not in model.outputs
        return False
    assert model.outputs["joints"] == ["n", len(names), 3, 4], model.outputs
    with np.errstate(all="ignore"):
        expected = np.array([fbk_evaluate.evaluate(archived, pose)[2] for pose in poses])
    found = model.run(poses)["joints"]
    assert found.shape == (len(poses), len(names), 3, 4)
    off = np.abs(found - expected.reshape(found.shape)).max()
    moved = np.abs(found - found[0]).max()
    print(f"{face.name}: {len(names)} joints, off by at most {off:.1e}")
    assert off == 0, f"{face.name}: joints are off by {off}"
    assert moved > 1e-3, f"{face.name}: no joint moves"
    return True


def check(face, folder):
    model, poses, expected = write_poses(face, folder / "face.onnx", folder)
    vertices = expected.shape[1]
    assert model.operator_set == 13
    assert model.inputs == {"controls": ["n", poses.shape[1]]}, model.inputs
    assert model.outputs["positions"] == ["n", vertices, 3], model.outputs
    found = model.run(poses)["positions"]
    assert found.dtype == np.float32 and found.shape == expected.shape
    rest = expected[0]
    diagonal = float(np.linalg.norm(rest.max(0) - rest.min(0)))
    moves = bool(np.abs(expected - rest).max() > 1e-3 * diagonal)
    off = float(np.linalg.norm(found - expected, axis=2).max()) / diagonal
    wild = model.run(np.where(poses > 0, poses + 1e6, poses - 1e6))["positions"]  # clamped to the ends
    assert np.abs(wild).max() <= np.abs(found).max() + 10 * diagonal, "controls are not clamped"
    print(f"{face.name}: {len(poses)} poses, off by at most {off:.1e} of the diagonal, {len(model.nodes)} nodes")
    assert off == 0, f"{face.name}: {off} of the diagonal"
    return moves, check_joints(face, model, poses[::7])


def main(faces):
    with tempfile.TemporaryDirectory() as folder:
        moving, driven = np.sum([check(pathlib.Path(face), pathlib.Path(folder)) for face in faces], axis=0)
    assert 2 * moving > len(faces), f"only {moving} of {len(faces)} faces move"
    assert driven > 0, "no face has driven joints"


if __name__ == "__main__":
    main(sys.argv[2:])
