"""Batches and bakes by multiprocessing, after batches, bakes and other loops of OpenMP in the parent."""

import ctypes
import multiprocessing
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

try:
    import numpy
except ImportError:
    raise unittest.SkipTest("NumPy is not installed")

import facebaker
import toy_rig

HERE = pathlib.Path(__file__)
LIMIT = 60  # seconds, within which a child of these must be done


def batch(_=None):
    face = facebaker.load(os.environ["FB_FIXTURE"])
    return face.evaluate_batch(numpy.tile(face.rest_controls, (512, 1)), threads=4)


def bake(_=None):
    with tempfile.TemporaryDirectory() as folder:
        face = facebaker.bake(
            toy_rig.make(), pathlib.Path(folder) / "toy.fbk", recipe="linear", poses=200, threads=4, progress=None
        ).load()
        return face.rest_positions


def numpy_loop():
    """Which runs on OpenMP's threads where NumPy's BLAS does."""
    square = numpy.ones((512, 512), numpy.float32)
    return square @ square


def host_loop():
    """A parallel region of OpenMP's runtime, as compilers call it."""
    try:
        runtime = ctypes.CDLL("libgomp.so.1")
    except OSError:
        return
    region = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(lambda _: None)
    runtime.GOMP_parallel(region, None, ctypes.c_uint(4), ctypes.c_uint(0))


PARENTS = {"batch": batch, "bake": bake, "NumPy": numpy_loop, "host": host_loop}


def be_parent(name, method):
    """What a program does that works in the parent first, then in a pool."""
    PARENTS[name]()
    with multiprocessing.get_context(method).Pool(2) as pool:
        waiting = {child.__name__: pool.apply_async(child) for child in (batch, bake)}
        for child, result in waiting.items():
            try:
                assert numpy.isfinite(result.get(LIMIT)).all()
            except multiprocessing.TimeoutError:
                sys.exit(f"{name} in the parent: {child} in a child of {method} has not ended after {LIMIT} s")


class ProcessesTest(unittest.TestCase):
    def check(self, method):
        for name in PARENTS:
            with self.subTest(parent=name):
                ended = subprocess.run([sys.executable, "-B", HERE, name, method], timeout=4 * LIMIT, capture_output=True)
                self.assertEqual(ended.returncode, 0, ended.stderr.decode())

    @unittest.skipUnless("fork" in multiprocessing.get_all_start_methods(), "the system has no fork()")
    def test_forked_children(self):
        self.check("fork")

    def test_new_programs(self):
        self.check("spawn")


if __name__ == "__main__":
    be_parent(*sys.argv[1:])
