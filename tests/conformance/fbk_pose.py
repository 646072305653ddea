#!/usr/bin/env python3
"""Poses a face with the independent reader, fbk_read.py, and writes it as a Wavefront OBJ file.

    fbk_pose.py FACE.fbk                                         lists the controls
    fbk_pose.py FACE.fbk [--set NAME=VALUE]... --out FILE.obj    writes a pose; controls that are not set rest
    fbk_pose.py FACE.fbk --proof N [--out FILE.obj]              a pose of the archive's proof, counted from 0, whose
                                                                 positions are compared with the archived ones, bit for bit

Exit code 0 on success, 1 if the archive is corrupt or poses otherwise than archived, 2 on wrong use.

Needs Python 3.8 and NumPy.
"""
import argparse
import sys
import zlib

import numpy as np

import fbk_evaluate
from fbk_bytes import Corrupt
from fbk_read import Face


def read_face(path):
    with open(path, "rb") as file:
        return Face(file.read())


def list_controls(face):
    print(f"{face.name}: {face.vertices} vertices, in {face.units or 'unknown units'}, {face.up} is up")
    print(f"{len(face.proof['controls'])} poses in the proof; controls:")
    for name, low, high, rest in face.controls:
        print(f"  {name}  from {low:g} to {high:g}, at rest {rest:g}")


def controls_of(face, settings):
    numbers = {control[0]: i for i, control in enumerate(face.controls)}
    controls = face.rest_controls.copy()
    for setting in settings:
        name, separator, value = setting.rpartition("=")
        if not separator or name not in numbers:
            raise ValueError(f"--set {setting}: give NAME=VALUE with the name of a control")
        controls[numbers[name]] = float(value)
    return controls


def compared_with_proof(face, number):
    """The controls of a pose of the proof, once it evaluates as archived."""
    poses = face.proof["controls"]
    if not 0 <= number < len(poses):
        raise ValueError(f"--proof {number}: there are {len(poses)} poses")
    for name, found in face.evaluated(poses[number]):
        if found.tobytes() != face.proof[name][number].tobytes():
            raise Corrupt(f"pose {number}: {name}: not as archived")
    print(f"pose {number} of the proof evaluates as archived, bit for bit")
    return poses[number]


def write_obj(path, face, positions):
    """Nine digits, which give each number back."""
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"# {len(positions)} vertices, in {face.units or 'unknown units'}\n")
        file.writelines("v %.9g %.9g %.9g\n" % tuple(point) for point in positions)
        for polygon in face.polygons:
            file.write("f " + " ".join(str(vertex + 1) for vertex in polygon) + "\n")


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("face")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--proof", type=int, metavar="N")
    parser.add_argument("--out", metavar="FILE.obj")
    given = parser.parse_args(arguments)
    if given.set and given.proof is not None:
        parser.error("--set and --proof: give one of them")
    try:
        with np.errstate(all="ignore"):
            face = read_face(given.face)
            if given.proof is None and given.out is None:
                list_controls(face)
                return 0
            controls = controls_of(face, given.set) if given.proof is None else compared_with_proof(face, given.proof)
            if given.out:
                write_obj(given.out, face, fbk_evaluate.evaluate(face, controls)[0][: 3 * face.vertices].reshape(-1, 3))
                print(given.out)
    except (Corrupt, ValueError, zlib.error) as error:
        print(f"{given.face}: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
