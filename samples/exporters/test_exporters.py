#!/usr/bin/env python3
"""Tests plan_evaluation.py and npy_files.py with a host made up here. The programs' own files are only compiled.

    test_exporters.py FACEBAKER
"""
import array
import json
import os
import py_compile
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from npy_files import NpyError, read_npy, read_shape, write_npy
from plan_evaluation import PlanError, evaluate_plan, write_schema

try:
    import numpy
except ImportError:
    numpy = None

FACEBAKER = sys.argv.pop(1) if len(sys.argv) > 1 else "facebaker"
CONTROLS = [{"name": "jaw.ty", "min": -1, "max": 0, "default": 0, "group": "jaw"},
            {"name": "smile", "min": 0, "max": 2, "default": 0},
            {"name": "squint", "min": 0, "max": 1, "default": 0.25}]
REST = [0, 0, 0, 4, 0, 0, 4, 3, 0, 0, 3, 0, 2, 1, 5]


class Crash(Exception):
    pass


class FakeHost:
    """Five vertices; counts its evaluations, and breaks off before one of them."""

    def __init__(self, crash_after=None, vertices=5, broken_vertex=None):
        self.values, self.evaluations = None, 0
        self.crash_after, self.vertices, self.broken_vertex = crash_after, vertices, broken_vertex

    def set_controls(self, values):
        assert list(values) == [control["name"] for control in CONTROLS]
        self.values = dict(values)

    def points(self):
        if self.evaluations == self.crash_after:
            raise Crash()
        self.evaluations += 1
        jaw, smile, squint = (self.values[control["name"]] for control in CONTROLS)
        points = list(REST)
        points[14] += jaw * jaw + jaw * smile
        points[10] += 0.5 * smile
        points[7] -= 0.3 * (squint - 0.25)
        if self.broken_vertex is not None and self.evaluations > 3:
            points[3 * self.broken_vertex] = float("nan")
        return points[: 3 * self.vertices]

    def polygons(self):
        return [(0, 1, 2, 3), (0, 1, 4)]


def run(*arguments, fails=False):
    result = subprocess.run([FACEBAKER, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if (result.returncode != 0) != fails:
        raise AssertionError("facebaker %s: %d\n%s%s" % (" ".join(arguments), result.returncode, result.stdout, result.stderr))
    return result.stdout + result.stderr


class InFolder(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, *names):
        return os.path.join(self.folder.name, *names)

    def make_plan(self, poses=60):
        write_schema(self.path("face.json"), "face", "cm", "y", CONTROLS)
        run("plan", self.path("face.json"), "--poses", str(poses), "--out", self.path("plan"))
        return self.path("plan")


class NpyFiles(InFolder):
    def test_what_is_written_is_read(self):
        for shape, values in (((2, 3), array.array("f", [0.5, -1, 2, 3, 4, 1e30])), ((4,), array.array("i", [1, -1, 7, 0]))):
            write_npy(self.path("a.npy"), shape, values)
            self.assertEqual(read_npy(self.path("a.npy")), (shape, values))
            self.assertEqual(read_shape(self.path("a.npy")), shape)
            self.assertEqual(os.listdir(self.folder.name), ["a.npy"])
            self.assertEqual(os.path.getsize(self.path("a.npy")) % 64, (4 * len(values)) % 64)

    @unittest.skipIf(numpy is None, "there is no NumPy")
    def test_numpy_agrees(self):
        written = numpy.arange(24, dtype="<f4").reshape(2, 3, 4) / 7
        numpy.save(self.path("numpy.npy"), written)
        shape, values = read_npy(self.path("numpy.npy"))
        self.assertEqual(shape, (2, 3, 4))
        write_npy(self.path("ours.npy"), shape, values)
        numpy.testing.assert_array_equal(numpy.load(self.path("ours.npy")), written)

    def test_damaged_files_are_refused(self):
        write_npy(self.path("a.npy"), (2, 3), [1, 2, 3, 4, 5, 6])
        with open(self.path("a.npy"), "rb") as file:
            whole = file.read()
        for damaged in (b"", whole[:5], whole[:60], whole[:-1], whole + b"x", whole.replace(b"<f4", b">f4"),
                        whole.replace(b"False", b"True "), whole.replace(b"(2, 3, )", b"(2, -3,)")):
            with open(self.path("a.npy"), "wb") as file:
                file.write(damaged)
            with self.assertRaises(NpyError):
                read_npy(self.path("a.npy"))
        with self.assertRaises(NpyError):
            write_npy(self.path("b.npy"), (2, 2), [1, 2, 3])


class Plans(InFolder):
    def test_a_plan_is_evaluated_and_bakes(self):
        plan = self.make_plan()
        self.assertIn("rest.npy: no such file", run("check", plan, fails=True))
        host = FakeHost()
        evaluated = evaluate_plan(plan, host, poses_per_file=16, report=lambda text: None)
        self.assertEqual(host.evaluations, evaluated + 1)  # the rest mesh
        self.assertEqual(host.values, {control["name"]: control["default"] for control in CONTROLS})
        self.assertIn("The folder can be baked", run("check", plan))
        run("bake", plan, "--recipe", "linear", "--out", self.path("face.fbk"))
        self.assertEqual(evaluate_plan(plan, FakeHost(), report=lambda text: None), 0)

    def test_evaluation_goes_on_after_an_interruption(self):
        whole, broken = self.make_plan(), self.path("broken")
        run("plan", self.path("face.json"), "--poses", "60", "--out", broken)
        all_poses = evaluate_plan(whole, FakeHost(), poses_per_file=8, report=lambda text: None)
        with self.assertRaises(Crash):
            evaluate_plan(broken, FakeHost(crash_after=30), poses_per_file=8, report=lambda text: None)
        self.assertIn("poses have no points yet", run("check", broken, fails=False))
        rest = evaluate_plan(broken, FakeHost(), poses_per_file=8, report=lambda text: None)
        self.assertLess(rest, all_poses - 15)
        self.assertGreater(rest, all_poses - 31)
        self.assertEqual(sorted(os.listdir(whole)), sorted(os.listdir(broken)))
        for name in os.listdir(whole):
            with open(os.path.join(whole, name), "rb") as one, open(os.path.join(broken, name), "rb") as other:
                self.assertEqual(one.read(), other.read(), name)

    def test_a_file_that_is_not_whole_is_written_again(self):
        plan = self.make_plan()
        evaluate_plan(plan, FakeHost(), poses_per_file=8, report=lambda text: None)
        part = os.path.join(plan, "regional.001.points.npy")
        with open(part, "rb") as file:
            whole = file.read()
        with open(part, "wb") as file:
            file.write(whole[:-4])
        self.assertGreaterEqual(evaluate_plan(plan, FakeHost(), poses_per_file=8, report=lambda text: None), 1)
        with open(part, "rb") as file:
            self.assertEqual(file.read(), whole)

    def test_programs_share_a_plan_by_clips(self):
        plan = self.make_plan()
        with open(os.path.join(plan, "dataset.json"), encoding="utf-8") as file:
            names = [clip["name"] for clip in json.load(file)["clips"]]
        total = sum(evaluate_plan(plan, FakeHost(), clips=[name], report=lambda text: None) for name in names)
        self.assertEqual(evaluate_plan(plan, FakeHost(), report=lambda text: None), 0)
        self.assertGreater(total, 60)
        with self.assertRaisesRegex(PlanError, "no clip \"dance\""):
            evaluate_plan(plan, FakeHost(), clips=["dance"])

    def test_what_a_host_does_wrong_is_said(self):
        plan = self.make_plan()
        with self.assertRaisesRegex(PlanError, "frame .*vertex 3 is not finite"):
            evaluate_plan(plan, FakeHost(broken_vertex=3), report=lambda text: None)
        with self.assertRaisesRegex(PlanError, "12 coordinates where 15 are needed"):
            evaluate_plan(plan, FakeHost(vertices=4), report=lambda text: None)

    def test_other_folders_are_refused(self):
        with self.assertRaisesRegex(PlanError, "dataset.json"):
            evaluate_plan(self.folder.name, FakeHost())
        with open(self.path("dataset.json"), "w", encoding="utf-8") as file:
            json.dump({"format": "facebaker-dataset"}, file)
        with self.assertRaisesRegex(PlanError, "is no plan"):
            evaluate_plan(self.folder.name, FakeHost())


class OtherPrograms(InFolder):
    def test_their_files_compile(self):
        here = os.path.dirname(os.path.abspath(__file__))
        for name in ("maya_exporter.py", "houdini_exporter.py", "unreal_exporter.py"):
            py_compile.compile(os.path.join(here, name), cfile=self.path(name + "c"), doraise=True)


if __name__ == "__main__":
    unittest.main()
