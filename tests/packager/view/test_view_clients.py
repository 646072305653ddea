"""What clients cannot do to `facebaker view`: hold it up, keep others from it, or keep it from ending.

test_view_clients.py FACEBAKER GOLDEN_FOLDER RIG
"""

from __future__ import annotations

import pathlib
import resource
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from typing import Callable

from viewing import Viewing, write_page

TOOL, GOLDEN, RIG = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
IDLE = 1000  # connections
SECOND = 1.0
TRIES = 3  # of what is timed, on a machine that others use
DEADLINE = 5  # seconds that a client has for the head of a request


def memory_of(process: int) -> int:
    """Resident bytes."""
    status = pathlib.Path(f"/proc/{process}/status").read_text()
    return 1024 * int(status.split("VmRSS:")[1].split()[0])


class TestClients(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        write_page(cls.folder)
        (cls.folder / "page" / "large.bin").write_bytes(bytes(32 << 20))
        cls.face = str(cls.folder / "face.fbk")
        subprocess.run([TOOL, "bake", RIG, "--recipe", "linear", "--out", cls.face], check=True, capture_output=True)
        limits = resource.getrlimit(resource.RLIMIT_NOFILE)
        cls.addClassCleanup(resource.setrlimit, resource.RLIMIT_NOFILE, limits)
        most = limits[1] if limits[1] != resource.RLIM_INFINITY else 4096
        resource.setrlimit(resource.RLIMIT_NOFILE, (min(max(IDLE + 200, limits[0]), most), limits[1]))

    def view(self) -> Viewing:
        viewing = Viewing(
            TOOL, "--page", str(self.folder / "page"), self.face, "--beside", RIG, FB_FAULT="stuck on a pose")
        self.addCleanup(viewing.close)
        return viewing

    def connect(self, viewing: Viewing, data: bytes = b"") -> socket.socket:
        client = socket.create_connection(("127.0.0.1", viewing.port), timeout=10)
        self.addCleanup(client.close)
        client.sendall(data)
        return client

    def post(self, viewing: Viewing, length: int, body: bytes) -> socket.socket:
        """Begins a pose of the rig."""
        head = f"POST /beside/pose HTTP/1.1\r\nHost: 127.0.0.1:{viewing.port}\r\nContent-Length: {length}\r\n"
        return self.connect(viewing, (head + f"Authorization: Bearer {viewing.token}\r\n\r\n").encode() + body)

    def check_end(self, behave: Callable[[Viewing], object]) -> None:
        """Ctrl-C ends the program within a second, whatever its clients are doing."""
        times = []
        for _ in range(TRIES):
            viewing = self.view()
            behave(viewing)
            times.append(viewing.seconds_to_stop())
            if times[-1] < SECOND:
                return
        self.fail(f"took {times} seconds to end")

    def test_ends_while_a_client_sends_a_header_a_second(self) -> None:
        stop = threading.Event()
        self.addCleanup(stop.set)

        def behave(viewing: Viewing) -> None:
            client = self.connect(viewing, b"GET / HTTP/1.1\r\n")

            def send_on() -> None:
                try:
                    while not stop.wait(1):
                        client.sendall(b"X: y\r\n")
                except OSError:
                    pass

            threading.Thread(target=send_on, daemon=True).start()
            time.sleep(0.2)

        self.check_end(behave)

    def test_ends_while_a_body_is_half_sent(self) -> None:
        self.check_end(lambda viewing: (self.post(viewing, 24, b"0" * 12), time.sleep(0.2)))

    def test_ends_while_a_client_does_not_read(self) -> None:
        get = b"GET /large.bin HTTP/1.1\r\nHost: 127.0.0.1:%d\r\n\r\n"
        self.check_end(lambda viewing: (self.connect(viewing, get % viewing.port), time.sleep(0.2)))

    def test_ends_while_the_rig_is_stuck(self) -> None:
        stuck = struct.pack("<6f", 0, -0.5, 0, 0, 0, 0)

        def behave(viewing: Viewing) -> None:
            for _ in range(20):  # more than are taken
                self.post(viewing, 24, stuck)
            time.sleep(0.3)
            self.assertEqual(viewing.ask("/")[0], 200)  # which needs no rig
            self.assertEqual(viewing.ask("/beside/pose", "POST", stuck, **viewing.bearer)[0], 503)

        self.check_end(behave)

    def test_a_thousand_idle_connections_keep_nobody_out(self) -> None:
        viewing = self.view()
        for _ in range(IDLE):
            self.connect(viewing)
            time.sleep(0.002)  # for a server that takes few at once
        times = []
        for _ in range(TRIES):
            start = time.monotonic()
            self.assertEqual(viewing.ask("/")[0], 200)
            times.append(time.monotonic() - start)
        self.assertLess(min(times), SECOND)
        descriptors = len(list(pathlib.Path(f"/proc/{viewing.process.pid}/fd").iterdir()))
        self.assertLess(descriptors, 400)
        self.assertLess(viewing.seconds_to_stop(), TRIES * SECOND)

    def test_a_head_has_a_deadline_and_others_do_not_wait_for_it(self) -> None:
        viewing = self.view()
        slow = [self.connect(viewing, b"GET / HTTP/1.1\r\n") for _ in range(20)]
        start = time.monotonic()
        closed = 0
        while closed < len(slow) and time.monotonic() - start < 3 * DEADLINE:
            for client in slow:
                try:
                    client.sendall(b"X: y\r\n")
                except OSError:
                    pass
            self.assertEqual(viewing.ask("/")[0], 200)
            time.sleep(1)
            closed = sum(self.is_closed(client) for client in slow)
        self.assertEqual(closed, len(slow))
        self.assertGreater(time.monotonic() - start, DEADLINE - 2)

    def is_closed(self, client: socket.socket) -> bool:
        client.settimeout(0.001)
        try:
            return client.recv(1) == b""
        except TimeoutError:
            return False
        except OSError:
            return True

    def test_bodies_take_no_more_than_their_budget(self) -> None:
        viewing = self.view()
        before = memory_of(viewing.process.pid)
        most = 16 << 20
        post = self.post(viewing, most, bytes(most - 1))
        time.sleep(0.2)
        self.assertEqual(viewing.ask("/beside/pose", "POST", bytes(24), **viewing.bearer)[0], 503)
        self.assertLess(memory_of(viewing.process.pid) - before, 3 * most)
        post.close()
        time.sleep(0.2)
        self.assertEqual(viewing.ask("/beside/pose", "POST", bytes(24), **viewing.bearer)[0], 200)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
