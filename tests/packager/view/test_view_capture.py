"""`facebaker view --capture` as programs for facial capture meet it: packets of UDP that move the face of the page.

test_view_capture.py FACEBAKER
"""

from __future__ import annotations

import json
import math
import pathlib
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from typing import Any, Callable

from viewing import Viewing, write_dataset, write_page

TOOL = sys.argv[1]
JAW_OPEN, HEAD_YAW = 17, 52  # of 61
DEADLINE = 20  # seconds, on a machine that others use
HERE = "127.0.0.1"


def live_link(jaw: float, yaw: float = 0, face: bool = True, subject: bytes = b"Kim's phone") -> bytes:
    """A packet of Live Link Face, field by field."""
    device = b"01234567-89AB-CDEF-0123-456789ABCDEF"
    head = struct.pack(">Bi", 6, len(device)) + device + struct.pack(">i", len(subject)) + subject
    head += struct.pack(">ifii", 1234, 0.25, 60, 1)
    values = [0.0] * 61
    values[JAW_OPEN], values[HEAD_YAW] = jaw, yaw
    return head + (struct.pack(">B61f", 61, *values) if face else b"")


def osc_text(text: str) -> bytes:
    data = text.encode() + b"\0"
    return data + bytes(-len(data) % 4)


def blend(name: str, value: float) -> bytes:
    return osc_text("/VMC/Ext/Blend/Val") + osc_text(",sf") + osc_text(name) + struct.pack(">f", value)


APPLY = osc_text("/VMC/Ext/Blend/Apply") + osc_text(",")


def bundle(*messages: bytes) -> bytes:
    return b"#bundle\0" + struct.pack(">Q", 1) + b"".join(struct.pack(">i", len(m)) + m for m in messages)


class TestCapture(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        write_page(cls.folder)
        cls.page = str(cls.folder / "page")
        cls.face = cls.bake("face", ("jawOpen", "happy"))

    @classmethod
    def bake(cls, name: str, controls: tuple[str, str]) -> str:
        data, face = cls.folder / name, str(cls.folder / f"{name}.fbk")
        write_dataset(data, controls)
        subprocess.run([TOOL, "bake", str(data), "--recipe", "linear", "--out", face], check=True, capture_output=True)
        return face

    def setUp(self) -> None:
        self.sender = self.make_sender()

    def make_sender(self, address: str = HERE) -> socket.socket:
        sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(sender.close)
        sender.bind((address, 0))
        return sender

    def view(self, capture: str, *arguments: str) -> Viewing:
        viewing = Viewing(TOOL, "--page", self.page, self.face, "--capture", capture, *arguments)
        self.addCleanup(viewing.close)
        self.port = json.loads(viewing.ask("/view.json")[1])["capture"]["port"]
        return viewing

    def send(self, *packets: bytes) -> None:
        for packet in packets:
            self.sender.sendto(packet, (HERE, self.port))

    def news(self, viewing: Viewing) -> dict[str, Any]:
        status, data = viewing.ask("/capture.json", **viewing.bearer)
        self.assertEqual(status, 200)
        return json.loads(data)

    def wait(self, viewing: Viewing, holds: Callable[[dict[str, Any]], bool], *packets: bytes) -> dict[str, Any]:
        """What the page is told once that holds; packets are sent until then."""
        end = time.monotonic() + DEADLINE
        while True:
            self.send(*packets)
            news = self.news(viewing)
            if holds(news):
                return news
            self.assertLess(time.monotonic(), end, news)
            time.sleep(0.01)

    def quiet(self, viewing: Viewing) -> dict[str, Any]:
        """What the page is told once all that was sent is taken."""
        before = self.news(viewing)
        while True:
            time.sleep(0.2)
            news = self.news(viewing)
            if news["frames"] == before["frames"]:
                return news
            before = news

    def end(self, viewing: Viewing) -> str:
        """Ctrl-C; what stands on standard error."""
        viewing.process.send_signal(2)
        errors = viewing.process.communicate(timeout=20)[1]
        self.assertEqual(viewing.process.returncode, 0, errors)
        return errors

    def controls(self, news: dict[str, Any]) -> dict[str, float]:
        return dict(zip(news["controls"], news["values"], strict=True))

    def test_live_link_face_moves_controls_of_its_names(self) -> None:
        viewing = self.view("livelink:0")
        news = self.news(viewing)
        self.assertEqual((news["source"], news["frames"], news["frame_age"], news["controls"]),
                         ("Live Link Face", 0, None, []))  # fmt: skip
        news = self.wait(viewing, lambda news: news["frames"] > 0, live_link(0.625))
        self.assertEqual(self.controls(news), {"jawOpen": 0.625})
        self.assertEqual((news["subject"], news["names"], news["unmatched_count"]), ("Kim's phone", 61, 60))
        self.assertIn("eyeBlinkLeft", news["unmatched"])
        self.assertLess(news["frame_age"], DEADLINE)
        news = self.wait(viewing, lambda news: news["values"] == [1], live_link(7))  # to its range
        news = self.wait(viewing, lambda news: news["values"] == [0], live_link(-7))
        time.sleep(1.1)
        self.wait(viewing, lambda news: news["fps"] >= 2, live_link(0.25))
        errors = self.end(viewing)
        self.assertIn(f"Live Link Face: waits for packets on 127.0.0.1, UDP port {self.port}", errors)
        self.assertIn('Live Link Face: 1 of 61 captured names move 1 of 2 controls; no controls have the names "eyeBlinkLeft"',
                      errors)  # fmt: skip
        self.assertNotIn("whoever", errors)

    def test_what_is_no_packet_is_left_out_and_told_once(self) -> None:
        viewing = self.view("livelink:0")
        self.wait(viewing, lambda news: news["values"] == [0.5], live_link(0.5))
        before = self.quiet(viewing)["frames"]
        whole = live_link(0.75)
        bad = [whole[:-1], whole + b"\0", live_link(math.nan), live_link(math.inf), live_link(0, math.nan), b"", b"\x05"]
        self.send(*bad)
        news = self.wait(viewing, lambda news: news["refused"] == len(bad))
        self.assertEqual((news["values"], news["frames"]), ([0.5], before))
        errors = self.end(viewing)
        self.assertEqual(errors.count("is left out, as are others like it"), 1, errors)

    def test_without_a_face_the_last_pose_stays(self) -> None:
        viewing = self.view("livelink:0")
        self.wait(viewing, lambda news: news["values"] == [0.5], live_link(0.5))
        frames = self.quiet(viewing)["frames"]
        news = self.wait(viewing, lambda news: news["frame_age"] > 1, live_link(0, face=False))
        self.assertEqual((news["values"], news["frames"]), ([0.5], frames))
        self.assertLess(news["packet_age"], 1)
        self.end(viewing)

    def test_one_sender_at_a_time(self) -> None:
        viewing = self.view("livelink:0")
        other = self.make_sender("127.0.0.2")
        self.wait(viewing, lambda news: news["values"] == [0.5], live_link(0.5))
        for _ in range(20):
            self.send(live_link(0.5))
            other.sendto(live_link(1), (HERE, self.port))
            self.assertEqual(self.news(viewing)["values"], [0.5])
        self.sender = other
        self.wait(viewing, lambda news: news["values"] == [1], live_link(1))
        self.sender = self.make_sender("127.0.0.2")  # another port of the same machine
        self.wait(viewing, lambda news: news["values"] == [0.25], live_link(0.25))
        self.assertIn("second machine", self.end(viewing))

    def test_vmc_moves_controls_by_names_of_vrm_and_arkit(self) -> None:
        viewing = self.view("vmc:0")
        pose = osc_text("/VMC/Ext/Bone/Pos") + osc_text(",sfffffff") + osc_text("Head") + bytes(28)
        frame = bundle(pose, blend("Joy", 0.25), bundle(blend("JawOpen", 0.5), blend("Blink_L", 1)), APPLY)
        news = self.wait(viewing, lambda news: news["frames"] > 0, frame)
        self.assertEqual(self.controls(news), {"happy": 0.25, "jawOpen": 0.5})
        self.assertEqual((news["source"], news["unmatched"]), ("VMC", ["Blink_L"]))
        self.wait(viewing, lambda news: news["values"] == [0.75, 0.5], blend("Joy", 0.75), APPLY)  # messages of their own
        frames = self.quiet(viewing)["frames"]
        self.send(blend("Joy", 0.125))  # not applied
        self.send(bundle(blend("Joy", math.nan), APPLY))
        self.wait(viewing, lambda news: news["refused"] == 1)
        self.assertEqual((self.news(viewing)["values"], self.news(viewing)["frames"]), ([0.75, 0.5], frames))
        self.wait(viewing, lambda news: news["frame_age"] > 1)
        self.assertIn('VMC: 2 of 3 captured names move 2 of 2 controls; no controls have the names "Blink_L"',
                      self.end(viewing))  # fmt: skip

    def test_a_calibration_is_made_kept_and_used_again(self) -> None:
        file = self.folder / "kim.json"
        viewing = self.view("livelink:0", "--calibration", str(file), "--calibrate", "3")
        self.wait(viewing, lambda news: "make every expression" in news["calibrating"], live_link(0.2, 0.1))
        for _ in range(3):
            self.send(live_link(0.6, 0.5))
        self.wait(viewing, lambda news: news["calibrating"] == "", live_link(0.2, 0.1))
        names = json.loads(file.read_text())["names"]
        self.assertEqual(len(names), 61)
        self.assertAlmostEqual(names["jawOpen"]["neutral"], 0.2, 6)
        self.assertAlmostEqual(names["jawOpen"]["range"], 0.6, 6)
        self.assertAlmostEqual(names["headYaw"]["range"] - names["headYaw"]["neutral"], 1, 6)
        self.assertEqual(names["eyeBlinkLeft"], {"neutral": 0, "range": 1})
        for raw, value in ((0.2, 0), (0.4, 0.5), (0.6, 1), (0.9, 1), (0.1, 0)):
            self.wait(viewing, lambda news, value=value: abs(news["values"][0] - value) < 1e-6, live_link(raw))
        errors = self.end(viewing)
        self.assertIn(f"calibration of 61 names: {file}", errors)
        self.assertIn("hardly moved", errors)
        again = self.view("livelink:0", "--calibration", str(file))
        self.wait(again, lambda news: news["values"] and abs(news["values"][0] - 0.5) < 1e-6, live_link(0.4))
        self.end(again)

    def test_packets_by_the_thousand_keep_nothing_from_ending(self) -> None:
        viewing = self.view("vmc:0")
        stop = threading.Event()

        def flood() -> None:
            count = 0
            while not stop.is_set():
                count += 1
                self.send(bundle(blend(f"name {count}", 1), APPLY), bundle(blend("Joy", 1), APPLY))

        flooding = threading.Thread(target=flood)
        flooding.start()
        self.addCleanup(flooding.join)
        self.addCleanup(stop.set)
        self.wait(viewing, lambda news: news["names"] == 1024 and news["refused"] > 1000)
        start = time.monotonic()
        news = self.news(viewing)
        self.assertLess(len(json.dumps(news)), 20000)
        self.assertLessEqual(news["fps"], 1000)
        viewing.process.send_signal(2)
        self.assertEqual(viewing.process.wait(DEADLINE), 0)
        self.assertLess(time.monotonic() - start, DEADLINE)

    def test_the_page_alone_is_told(self) -> None:
        viewing = self.view("livelink:0")
        self.assertEqual(viewing.ask("/capture.json")[0], 401)
        self.assertEqual(viewing.ask("/capture.json", Authorization="Bearer " + "0" * 32)[0], 401)
        self.assertEqual(viewing.ask("/capture.json", Origin="http://example.org", **viewing.bearer)[0], 403)
        self.assertEqual(viewing.ask("/capture.json", "POST", b"", **viewing.bearer)[0], 404)
        self.assertEqual(viewing.ask("/capture.json", **viewing.bearer)[0], 200)
        self.assertEqual(viewing.type, "application/json")
        self.end(viewing)

    def test_other_addresses_are_told(self) -> None:
        viewing = self.view("livelink:0", "--capture-address", "0.0.0.0")
        self.wait(viewing, lambda news: news["values"] == [0.5], live_link(0.5))
        self.assertIn(f"whoever reaches UDP port {self.port} can move the face", self.end(viewing))

    def fails(self, code: int, *arguments: str, face: str = "") -> str:
        run = subprocess.run([TOOL, "view", "--no-open", "--port", "0", "--page", self.page, face or self.face, *arguments],
                             capture_output=True, text=True, timeout=DEADLINE)  # fmt: skip
        self.assertEqual(run.returncode, code, run.stderr)
        return run.stderr

    def test_says_what_is_wrong(self) -> None:
        for word in ("phone", "livelink:", "livelink:65536", "vmc:-1", "vmc:1e3", ":1"):
            self.assertIn(word, self.fails(2, "--capture", word))
        self.assertIn("--capture", self.fails(2, "--capture-address", "0.0.0.0"))
        self.assertIn("--calibration", self.fails(2, "--capture", "vmc", "--calibrate", "5"))
        self.assertIn("example.org", self.fails(1, "--capture", "vmc:0", "--capture-address", "example.org"))
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
            taken.bind((HERE, 0))
            port = taken.getsockname()[1]
            self.assertIn(f"UDP port {port}", self.fails(1, "--capture", f"vmc:{port}"))
        self.assertIn("jawOpen", self.fails(1, "--capture", "livelink:0", face=self.bake("other", ("up", "out"))))
        file = self.folder / "bad.json"
        name = '{"format": "facebaker-capture-calibration", "version": 1, "names": {"jawOpen": %s}}'
        for text, fault in ((name % '{"neutral": 0.2, "range": 0.21}', "names.jawOpen.range"),
                            (name % '{"neutral": "a", "range": 1}', "names.jawOpen.neutral"),
                            (name % '{"neutral": 0, "range": 1, "gain": 2}', "names.jawOpen.gain"),
                            ("[]", "object"), ("{}", "format")):  # fmt: skip
            file.write_text(text)
            errors = self.fails(1, "--capture", "vmc:0", "--calibration", str(file))
            self.assertIn(fault, errors)
            self.assertIn("bad.json", errors)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
