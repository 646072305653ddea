"""The rig protocol as facebaker.serve speaks it, asked by a parent that is written down here from docs/rig-protocol.md."""

import contextlib
import json
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import textwrap
import unittest

try:
    import numpy as np
except ImportError:
    raise unittest.SkipTest("NumPy is not installed")

from facebaker import Clip, Control, Image, Joint, Rig, Skin
from facebaker.serve import load_rig

RIGS = textwrap.dedent(
    """
    import os
    import subprocess
    import sys
    import numpy as np
    import facebaker

    print("printed while importing")
    rest = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)

    def blink(controls):
        print("printed while evaluating")
        os.write(1, b"written to descriptor 1")
        if (controls[:, 0] > 0.9).any():
            raise ArithmeticError("the brow is torn")
        points = np.repeat(rest[None], len(controls), 0)
        points[:, 2, 1] += 0.2 * controls[:, 0]
        return points, controls[:, 1:] ** 2

    def make(name="blink"):
        return facebaker.Rig(
            [facebaker.Control("raise", "brows", -1, 1, 0.25), "squint"], blink, name=name,
            polygons=[[0, 1, 2, 3]], uvs=rest[:, :2], channels=[facebaker.Channel("crease")], version="7",
            clips=[facebaker.Clip("shot", [[0, 0], [0.5, 1]], split="test", fps=24)], preferred_block=16)

    def leaves_a_child():
        subprocess.Popen(["sleep", "5"], close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return make()

    def wrong_shape():
        return facebaker.Rig(["a"], lambda controls: rest, rest_positions=rest)

    def only_together():
        def evaluate(controls):
            if len(controls) > 1:
                raise RuntimeError("one at a time")
            return rest[None]
        return facebaker.Rig(["a"], evaluate)

    def turned():
        joints = [facebaker.Joint("lid", rest=np.eye(3, 4), numbers=("rotate_z", "move_x"))]
        skin = facebaker.Skin(np.zeros((4, 1), int), [[0], [0], [1], [0.5]])
        frames = lambda controls: np.eye(3, 4) + controls[:, None, None] * np.eye(3, 4, 3)
        evaluate = lambda controls: (np.repeat(rest[None], len(controls), 0), frames(controls))
        return facebaker.Rig(["a"], evaluate, joints=joints, skin=skin, skinned=True)

    def no_rig():
        return 7

    def ends():
        return facebaker.Rig(["a"], lambda controls: sys.exit(3), rest_positions=rest)

    made = make("made")
    """
)


class Parent:
    """Starts a child as FaceBaker does and asks it."""

    def __init__(self, folder, *words):
        to_child, self._requests = os.pipe()
        self._answers, from_child = os.pipe()
        self._requests, self._answers = os.fdopen(self._requests, "wb"), os.fdopen(self._answers, "rb")
        variables = {"FACEBAKER_RIG_REQUESTS": str(to_child), "FACEBAKER_RIG_ANSWERS": str(from_child)}
        environment = {**os.environ, **variables, "FACEBAKER_LIBRARY": "/nowhere/libfacebaker.so"}  # it needs none
        self.process = subprocess.Popen(
            [sys.executable, "-B", "-m", "facebaker.serve", *words], cwd=folder, env=environment,
            pass_fds=(to_child, from_child), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip
        os.close(to_child)
        os.close(from_child)

    def send(self, fields, data=b""):
        text = json.dumps(fields).encode() + b"\n"
        self._requests.write(struct.pack("<4sIQ", b"FBR1", len(text), len(data)) + text + data)
        self._requests.flush()

    def receive(self):
        signature, text_size, data_size = struct.unpack("<4sIQ", self._answers.read(16))
        assert signature == b"FBR1", signature
        return json.loads(self._answers.read(text_size)), self._answers.read(data_size)

    def ask(self, fields, data=b""):
        self.send(fields, data)
        return self.receive()

    def evaluate(self, controls):
        controls = np.array(controls, "<f4")
        return self.ask({"type": "evaluate", "poses": len(controls)}, controls.tobytes())

    def close(self):
        """Ends the requests; what the child printed on standard output and on standard error."""
        for stream in self._requests, self._answers:
            with contextlib.suppress(BrokenPipeError):
                stream.close()
        printed = self.process.communicate(timeout=20)
        return tuple(text.decode() for text in printed)


class ServeTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        pathlib.Path(cls.folder.name, "rigs.py").write_text(RIGS)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @contextlib.contextmanager
    def parent(self, *words):
        parent = Parent(self.folder.name, *words)
        try:
            yield parent
        finally:
            if not parent.process.stdout.closed:
                parent.close()

    def test_hello_says_what_the_rig_is(self):
        with self.parent("rigs:make", "given") as parent:
            hello, data = parent.ask({"type": "hello", "version": 1})
            self.assertEqual((hello["type"], hello["version"], hello["name"]), ("hello", 1, "given"))
            self.assertEqual((hello["units"], hello["up_axis"], hello["rig_version"]), ("cm", "y", "7"))
            first = {"name": "raise", "group": "brows", "min": -1, "max": 1, "default": 0.25}
            self.assertEqual(hello["controls"], [first, {"name": "squint", "min": 0, "max": 1, "default": 0}])
            self.assertEqual((hello["vertices"], hello["polygons"], hello["uvs"]), (4, 1, 4))
            self.assertEqual(hello["channels"], [{"name": "crease", "min": 0, "max": 1, "default": 0}])
            self.assertEqual(hello["preferred_block"], 16)
            clip = {"name": "shot", "kind": "shot", "split": "test", "fps": 24, "frames": 2}
            self.assertEqual(hello["clips"], [clip])
            rest = [0, 0, 0, 1, 0, 0, 1, np.float32(1.05), 0, 0, 1, 0]
            uvs = [0, 0, 1, 0, 1, 1, 0, 1]
            corners = [0, 1, 2, 3]
            expected = struct.pack("<12f5I8f4I4f", *rest, 4, *corners, *uvs, *corners, 0, 0, 0.5, 1)
            self.assertEqual(data, expected)

    def test_poses_are_answered_whatever_the_rig_prints(self):
        with self.parent("rigs:made") as parent:
            parent.ask({"type": "hello", "version": 1})
            for _ in range(2):
                answer, data = parent.evaluate([[0.5, 0.5], [-1, 1], [0, 0]])
                self.assertEqual(answer, {"type": "points", "poses": 3})
                points, channels = np.split(np.frombuffer(data, "<f4"), [3 * 12])
                self.assertTrue(np.allclose(points.reshape(3, 4, 3)[:, 2, 1], [1.1, 0.8, 1]))
                self.assertEqual(channels.tolist(), [0.25, 1, 0])
            parent.send({"type": "bye"})
            self.assertEqual(parent.process.wait(20), 0)
            out, _ = parent.close()
            self.assertIn("printed while evaluating", out)

    def test_poses_after_skinning_have_frames_of_joints(self):
        with self.parent("rigs:turned") as parent:
            hello, data = parent.ask({"type": "hello", "version": 1})
            self.assertIs(hello["skinned"], True)
            self.assertEqual([joint["numbers"] for joint in hello["joints"]], [["rotate_z", "move_x"]])
            self.assertEqual(hello["skin_influences"], 1)
            self.assertEqual(data[-24:], struct.pack("<4H4f", 0, 0, 0, 0, 0, 0, 1, 0.5))
            answer, data = parent.evaluate([[0.5], [1]])
            self.assertEqual(answer, {"type": "points", "poses": 2})
            positions, frames = np.split(np.frombuffer(data, "<f4"), [2 * 12])
            self.assertEqual(positions.reshape(2, 4, 3)[1].tolist(), [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
            self.assertEqual(frames.reshape(2, 3, 4)[0, 0].tolist(), [1, 0, 0, 0.5])
        with self.parent("rigs:make") as parent:
            self.assertIs(parent.ask({"type": "hello", "version": 1})[0]["skinned"], False)

    def test_an_error_names_its_pose(self):
        with self.parent("rigs:made") as parent:
            parent.ask({"type": "hello", "version": 1})
            answer, data = parent.evaluate([[0, 0], [0, 1], [0.95, 0], [1, 0]])
            self.assertEqual((answer["type"], answer["pose"], data), ("error", 2, b""))
            self.assertRegex(answer["message"], r"^ArithmeticError: the brow is torn \(rigs.py, line \d+\)$")
            answer, _ = parent.evaluate([[0, 0]])
            self.assertEqual(answer, {"type": "points", "poses": 1})
            _, errors = parent.close()
            self.assertEqual(errors.count("Traceback"), 1)

    def test_contracts_that_are_broken(self):
        with self.parent("rigs:wrong_shape") as parent:
            answer, _ = parent.evaluate([[0.5], [0.7]])
            self.assertEqual((answer["type"], answer["pose"]), ("error", 0))
            self.assertIn("positions that evaluate gave: shape (4, 3), not (1, 4, 3)", answer["message"])
        with self.parent("rigs:only_together") as parent:
            answer, _ = parent.evaluate([[0.5], [0.7]])
            self.assertNotIn("pose", answer)
            self.assertIn("one at a time", answer["message"])
        with self.parent("rigs:ends") as parent:
            parent.send({"type": "evaluate", "poses": 1}, b"\0" * 4)
            self.assertEqual(parent.process.wait(20), 3)

    def test_no_rig_is_told_instead_of_hello(self):
        cases = {
            "nowhere:make": "No module named 'nowhere'",
            "rigs:nothing": "has no attribute 'nothing'",
            "rigs": '"rigs" is not module:function',
            "rigs:no_rig": "gave int, not a facebaker.Rig",
        }
        for word, sentence in cases.items():
            with self.parent(word) as parent:
                answer, _ = parent.receive()
                self.assertEqual(answer["type"], "error")
                self.assertIn(sentence, answer["message"])
                self.assertEqual(parent.process.wait(20), 1)
        with self.parent("rigs:make") as parent:
            answer, _ = parent.ask({"type": "hello", "version": 2})
            self.assertIn("version 2", answer["message"])

    def test_it_ends_with_its_requests(self):
        with self.parent("rigs:make") as parent:
            parent.ask({"type": "hello", "version": 1})
            parent.close()
            self.assertEqual(parent.process.returncode, 0)
        with self.parent("rigs:make") as parent:
            parent._requests.write(b"FBR1\1")
            _, errors = parent.close()
            self.assertIn("end within a message", errors)
        for garbage in b"GET / HTTP/1.1\r\n", struct.pack("<4sIQ", b"FBR1", 3, 0) + b"[]\n":
            with self.parent("rigs:make") as parent:
                parent._requests.write(garbage)
                _, errors = parent.close()
                self.assertRegex(errors, "where a message begins|a request without a type")

    def test_what_the_rig_starts_does_not_keep_the_pipes(self):
        with self.parent("rigs:leaves_a_child") as parent:
            parent.ask({"type": "hello", "version": 1})
            parent.send({"type": "bye"})
            self.assertEqual(parent._answers.read(), b"")  # ends now, and not with the child's child

    def test_nobody_asks(self):
        variables = {key: value for key, value in os.environ.items() if not key.startswith("FACEBAKER_RIG")}
        command = [sys.executable, "-B", "-m", "facebaker.serve"]
        result = subprocess.run([*command, "rigs:make"], cwd=self.folder.name, env=variables, capture_output=True)
        self.assertEqual(result.returncode, 2)
        self.assertIn(b"this is started by FaceBaker", result.stderr)
        self.assertEqual(subprocess.run(command, env=variables, capture_output=True).returncode, 2)


class RigTest(unittest.TestCase):
    rest = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]], np.float32)

    def still(self, controls):
        return np.repeat(self.rest[None], len(controls), 0)

    def test_polygons_in_every_form(self):
        quad_and_triangle = [[0, 1, 2, 3], [0, 1, 4]]
        padded = np.array([[0, 1, 2, 3], [0, 1, 4, -1]])
        for polygons in quad_and_triangle, padded, padded.astype("i2"):
            rig = Rig(["a"], self.still, polygons=polygons)
            self.assertEqual(rig.polygon_sizes.tolist(), [4, 3])
            self.assertEqual(rig.polygon_corners.tolist(), [0, 1, 2, 3, 0, 1, 4])
        self.assertEqual(len(Rig(["a"], self.still).polygon_sizes), 0)
        with self.assertRaisesRegex(ValueError, "polygon 1 goes on after a -1"):
            Rig(["a"], self.still, polygons=np.array([[0, 1, 2], [0, -1, 4]]))
        with self.assertRaisesRegex(ValueError, "polygons: "):
            Rig(["a"], self.still, polygons=np.array([[0, 1.5, 2]]))

    def test_what_does_not_fit_is_refused(self):
        cases = {
            "a recording needs rest_positions": {"evaluate": None},
            "preferred_block is 5000": {"preferred_block": 5000},
            "rest_positions: shape": {"rest_positions": [[0, 1]]},
            "6 uvs of 5 vertices": {"uvs": np.zeros((6, 2))},
            "uv_polygons: not as many": {"polygons": [[0, 1, 2]], "uvs": np.zeros((9, 2)), "uv_polygons": [[0, 1, 2, 3]]},
            "kind 'film' is none of shot": {"clips": [Clip("c", [[0]], kind="film")]},
            "split 'all' is none of train": {"clips": [Clip("c", [[0]], split="all")]},
            'clip "c": controls: shape \\(1, 2\\)': {"clips": [Clip("c", [[0, 0]])]},
            "which are for rigs without evaluate": {"clips": [Clip("c", [[0]], positions=self.rest[None])]},
            "joints of skin: 1, where there are 1": {
                "joints": [Joint("head")], "skin": Skin(np.ones((5, 1), int), np.ones((5, 1)))},
        }  # fmt: skip
        for sentence, options in cases.items():
            with self.assertRaisesRegex(ValueError, sentence):
                Rig(["a"], **{"evaluate": self.still, **options})
        with self.assertRaisesRegex(ValueError, 'clip "c": has no positions'):
            Rig(["a"], rest_positions=self.rest, clips=[Clip("c", [[0]])])

    def test_a_rig_in_this_process_is_found_by_name(self):
        sys.modules["rigs_here"] = type(sys)("rigs_here")
        sys.modules["rigs_here"].Group = type("Group", (), {"rig": Rig([Control("a")], self.still)})
        self.assertIn("1 controls, 5 vertices", repr(load_rig("rigs_here:Group.rig")))
        self.assertIn("3 bytes", repr(Image("skin", "image/png", b"abc")))


if __name__ == "__main__":
    unittest.main()
