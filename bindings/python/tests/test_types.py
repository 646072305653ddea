"""mypy --strict accepts the package, and programs that use it; it is skipped without mypy."""

import pathlib
import shutil
import subprocess
import tempfile
import textwrap
import unittest

MYPY = shutil.which("mypy")
PACKAGE = pathlib.Path(__file__).parents[1] / "facebaker"
USER = """
import numpy as np
import numpy.typing as npt
import facebaker
from facebaker.serve import serve

def evaluate(controls: "np.ndarray[tuple[int, int], np.dtype[np.float32]]") -> object:
    return controls

def evaluate_any(controls: "npt.NDArray[np.float32]") -> object:
    return controls

facebaker.Rig(["a"], evaluate_any)
rig = facebaker.Rig(["a", facebaker.Control("b", "mouth", -1, 1)], evaluate, polygons=[[0, 1, 2]])
with facebaker.Source(rig, workers=2) as source:
    result = facebaker.bake(source, "a.fbk", use="variant", progress=print)
size: int = len(result.method.archive)
face = facebaker.load(result.path)
worst: float = facebaker.evaluate(face, ["a", "b"]).method.unseen.max
face.evaluate({"a": 0.5})[0, 0] + face.evaluate_batch([[0, 1]]).sum()
solver = facebaker.Solver(face, [0, 1, 2], pairs=[(0, 1)])
found = solver.solve(face.rest_positions[:3], locked=["b"], start={"a": 0.5})
change: float = solver.jacobian(found.controls, ["a", 1])[0, 0] + solver.jacobian({}, sparse=True).data.sum()
solver.solve_clip([[[0.0] * 3] * 3], backwards=True, find_motion=True).controls.sum() + face.jacobian({})[0, 0]
serve(rig)
"""


class TypesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cache = tempfile.TemporaryDirectory()

    @classmethod
    def tearDownClass(cls):
        cls.cache.cleanup()

    def mypy(self, *words):
        command = [MYPY, "--strict", "--no-error-summary", "--cache-dir", self.cache.name, *words]
        return subprocess.run(command, capture_output=True, text=True, cwd=PACKAGE.parent).stdout

    @unittest.skipUnless(MYPY, "mypy is not installed")
    def test_the_package(self):
        self.assertEqual(self.mypy("facebaker"), "")

    @unittest.skipUnless(MYPY, "mypy is not installed")
    def test_a_program(self):
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder, "program.py")
            program.write_text(USER)
            self.assertEqual(self.mypy(str(program)), "")
            program.write_text(
                USER
                + textwrap.dedent(
                    """
                facebaker.bake(rig)
                facebaker.Control(7)
                face.polygons
            """
                )
            )
            found = self.mypy(str(program))
            self.assertEqual(found.count("error:"), 3, found)


if __name__ == "__main__":
    unittest.main()
