#!/usr/bin/env python3
"""write_poses.py FACEBAKER FACE.fbk FOLDER: exports a face as face.onnx, and as poses.npy and poses.mdd the controls and
positions of poses at rest, at the ends of all ranges and in between (test_onnx.py)."""
import pathlib
import sys

from test_onnx import write_poses

if __name__ == "__main__":
    folder = pathlib.Path(sys.argv[3])
    write_poses(sys.argv[2], folder / "face.onnx", folder)
