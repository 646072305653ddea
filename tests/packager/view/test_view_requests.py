"""What `facebaker view` answers to requests that other pages and programs of the machine can send: ranges, who asks, the
token, encoded and long bodies.

test_view_requests.py FACEBAKER GOLDEN_FOLDER RIG
"""

from __future__ import annotations

import errno
import gzip
import json
import pathlib
import socket
import struct
import subprocess
import sys
import tempfile
import unittest

from viewing import Viewing, write_page

TOOL, GOLDEN, RIG = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
CONTROLS = 6  # of the rig


def send(port: int, data: bytes) -> bytes:
    """All that comes back for these bytes."""
    with socket.create_connection(("127.0.0.1", port), timeout=10) as client:
        client.sendall(data)
        try:
            client.shutdown(socket.SHUT_WR)
        except OSError as error:
            if error.errno != errno.ENOTCONN:  # that is, unless it is answered and closed already
                raise
        answer = b""
        while piece := client.recv(1 << 16):
            answer += piece
        return answer


class TestRequests(unittest.TestCase):
    viewing: Viewing
    page: str
    points: str
    controls: str
    pose: bytes

    @classmethod
    def setUpClass(cls) -> None:
        folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        write_page(folder)
        face = str(folder / "face.fbk")
        subprocess.run([TOOL, "bake", RIG, "--recipe", "linear", "--out", face], check=True, capture_output=True)
        (folder / "page" / "empty.txt").write_bytes(b"")
        cls.page = str(folder / "page")
        cls.viewing = Viewing(TOOL, "--page", cls.page, face, "--beside", RIG)
        cls.addClassCleanup(cls.viewing.close)
        beside = json.loads(cls.viewing.ask("/view.json")[1])["beside"]
        cls.points, cls.controls = "/" + beside["clips"][0]["points"], "/" + beside["clips"][0]["controls"]
        cls.pose = struct.pack(f"<{CONTROLS}f", *[0.25] * CONTROLS)

    def ask(self, *arguments: object, **headers: str) -> tuple[int, bytes]:
        return self.viewing.ask(*arguments, **headers)  # type: ignore[arg-type]

    def check_ranges(self, path: str, **headers: str) -> None:
        """Whatever is asked for is of the file, and no more than it has."""
        whole = self.ask(path, **headers)[1]
        size = len(whole)
        for text, status, first, end in [
            ("bytes=0-200000", 206, 0, size), ("bytes=0-", 206, 0, size), (f"bytes=5-{10**30}", 206, 5, size),
            ("bytes=3-7", 206, 3, 8), (f"bytes={size - 1}-{size}", 206, size - 1, size), ("bytes=0-0", 206, 0, 1),
            ("bytes=-4", 206, size - 4, size), (f"bytes=-{2**64 + 5}", 206, 0, size), ("BYTES=1-2", 206, 1, 3),
            (f"bytes={size}-", 416, 0, 0), (f"bytes={size}-{size + 9}", 416, 0, 0), ("bytes=-0", 416, 0, 0),
            (f"bytes={2**64 + 1}-", 416, 0, 0), ("bytes=7-3", 200, 0, size), ("bytes=0-1,4-5", 200, 0, size),
            ("bytes=-", 200, 0, size), ("bytes=a-b", 200, 0, size), ("bytes=-1-5", 200, 0, size), ("bytes=+1-5", 200, 0, size),
            ("bytes=", 200, 0, size), ("lines=0-5", 200, 0, size), ("bytes 0-5", 200, 0, size), ("0-5", 200, 0, size),
        ]:  # fmt: skip
            got = self.ask(path, Range=text, **headers)
            self.assertEqual(got[0], status, text)
            where = self.viewing.headers.get("Content-Range")
            if status == 416:
                self.assertEqual(where, f"bytes */{size}", text)
                continue
            self.assertEqual(got[1], whole[first:end], text)
            self.assertEqual(where, f"bytes {first}-{end - 1}/{size}" if status == 206 else None, text)

    def test_ranges_hold_bytes_of_the_file_alone(self) -> None:
        self.check_ranges("/index.html")
        self.check_ranges("/faces/0.fbk")
        self.check_ranges(self.controls)
        self.check_ranges(self.points, **self.viewing.bearer)
        self.assertEqual(self.ask("/empty.txt", Range="bytes=0-200000"), (416, b"the file does not have these bytes\n"))
        self.assertEqual(self.ask("/index.html", Range="bytes=0-3", If_Range='"x"')[0], 200)
        self.assertEqual(self.ask("/index.html", "HEAD", Range="bytes=0-200000"), (200, b""))
        self.assertEqual(self.viewing.headers["Content-Length"], "31")

    def test_pages_of_elsewhere_get_nothing(self) -> None:
        paths = ["/", "/index.html", "/view.json", "/faces/0.fbk", "/assets/face.wasm", self.controls, self.points]
        bearer = self.viewing.bearer
        for path in paths:
            for method in ("GET", "HEAD"):
                for site in ("cross-site", "same-site", "else"):
                    self.assertEqual(self.ask(path, method, Sec_Fetch_Site=site, **bearer)[0], 403, (path, site))
                for site in ("same-origin", "none"):
                    self.assertEqual(self.ask(path, method, Sec_Fetch_Site=site, **bearer)[0], 200, (path, site))
            self.assertEqual(self.ask(path, Origin="null", **bearer)[0], 403, path)
            self.assertEqual(self.ask(path, Host="example.org", **bearer)[0], 403, path)
        for site in ("cross-site", "same-site", "none"):
            self.assertEqual(self.ask("/beside/pose", "POST", self.pose, Sec_Fetch_Site=site, **bearer)[0], 403, site)
        # A link to the page, followed in a window of its own, and in no frame.
        followed = {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "navigate"}
        self.assertEqual(self.ask("/", Sec_Fetch_Dest="document", **followed)[0], 200)
        self.assertEqual(self.ask("/", Sec_Fetch_Dest="iframe", **followed)[0], 403)
        self.assertEqual(self.ask("/faces/0.fbk", Sec_Fetch_Dest="document", **followed)[0], 403)
        self.assertEqual(self.ask("/", "POST", b"", Sec_Fetch_Dest="document", **followed)[0], 403)

    def test_every_answer_keeps_to_its_own_page(self) -> None:
        for status, arguments, headers in [
            (200, ("/",), {}), (206, ("/", "GET"), {"Range": "bytes=0-1"}), (416, ("/", "GET"), {"Range": "bytes=99-"}),
            (404, ("/secret",), {}), (401, (self.points,), {}), (403, ("/",), {"Host": "x"}), (405, ("/", "PUT"), {}),
            (200, ("/beside/pose", "POST", self.pose), self.viewing.bearer),
            (500, ("/beside/pose", "POST", b"short"), self.viewing.bearer),
        ]:  # fmt: skip
            self.assertEqual(self.ask(*arguments, **headers)[0], status, (arguments, headers))
            self.assertEqual(self.viewing.headers["Cross-Origin-Resource-Policy"], "same-origin", status)
            self.assertEqual(self.viewing.headers["Referrer-Policy"], "no-referrer", status)

    def test_the_rig_runs_for_those_with_the_token(self) -> None:
        self.assertRegex(self.viewing.token, "^[0-9a-f]{32}$")
        for arguments in [(self.points,), (self.points, "HEAD"), ("/beside/pose", "POST", self.pose)]:
            self.assertEqual(self.ask(*arguments, **self.viewing.bearer)[0], 200)
            for wrong in ["Bearer", "Bearer ", f"Bearer {self.viewing.token[:-1]}", f"Bearer {self.viewing.token}0",
                          f"Basic {self.viewing.token}", self.viewing.token, "Bearer " + "0" * 32]:  # fmt: skip
                self.assertEqual(self.ask(*arguments, Authorization=wrong)[0], 401, wrong)
            self.assertEqual(self.ask(*arguments)[0], 401)
            self.assertEqual(self.viewing.headers["WWW-Authenticate"], "Bearer")
        self.assertEqual(self.ask(f"{self.points}?token={self.viewing.token}")[0], 401)  # which histories would keep
        self.assertEqual(len(self.ask("/beside/pose", "POST", self.pose, **self.viewing.bearer)[1]) % 12, 0)
        other = Viewing(TOOL, "--page", self.page, str(GOLDEN / "tiny.fbk"))
        self.addCleanup(other.close)
        self.assertNotEqual(other.token, self.viewing.token)

    def test_bodies_are_as_long_as_they_say_and_not_encoded(self) -> None:
        bearer = self.viewing.bearer
        bomb = gzip.compress(bytes(1 << 20))
        for encoding in ("gzip", "deflate", "br", "GZIP", "x", "identity, gzip"):
            for path, method in (("/beside/pose", "POST"), ("/", "GET")):
                answer = self.ask(path, method, bomb, Content_Encoding=encoding, **bearer)
                self.assertEqual(answer[0], 415, encoding)
        self.assertEqual(self.ask("/beside/pose", "POST", self.pose, Content_Encoding="identity", **bearer)[0], 200)
        post = f"POST /beside/pose HTTP/1.1\r\nHost: 127.0.0.1:{self.viewing.port}\r\nAuthorization: Bearer {self.viewing.token}\r\n"
        for fields, status in [
            (f"Content-Length: {(16 << 20) + 1}\r\n\r\n", 413), ("Content-Length: 99999999999999999\r\n\r\n", 413),
            ("Transfer-Encoding: chunked\r\n\r\n18\r\n" + "0" * 24 + "\r\n0\r\n\r\n", 411),
            ("Content-Length: 1\r\nContent-Length: 24\r\n\r\n", 400), ("Host: x\r\nContent-Length: 0\r\n\r\n", 400),
            ("Content-Length: 23\r\n\r\n" + "0" * 23, 500), ("Content-Length: 24\r\n\r\n" + "\0" * 24, 200),
            ("\r\n", 500), ("X: " + "x" * 40000 + "\r\n\r\n", 431),
        ]:  # fmt: skip
            answer = send(self.viewing.port, (post + fields).encode())
            self.assertEqual(answer[:12].decode(), f"HTTP/1.1 {status}", fields[:60])
        self.assertEqual(send(self.viewing.port, b"GET /" + b"x" * 40000)[:12], b"HTTP/1.1 414")
        self.assertEqual(self.ask("/", "GET", b"body")[0], 400)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
