"""A running `facebaker view`, and what it shows, for its tests."""

from __future__ import annotations

import http.client
import json
import os
import pathlib
import signal
import struct
import subprocess
import time
import urllib.parse


def write_page(folder: pathlib.Path) -> None:
    """A stand-in for the built viewer, and a file beside it that is not to be served."""
    (folder / "page" / "assets").mkdir(parents=True)
    (folder / "page" / "index.html").write_text("<title>FaceBaker viewer</title>")
    (folder / "page" / "assets" / "face.wasm").write_bytes(b"\0asm")
    (folder / "page" / "out").symlink_to(folder / "secret")
    (folder / "secret").write_text("secret")


def write_dataset(folder: pathlib.Path, names: tuple[str, str] = ("up", "out")) -> None:
    """Two controls that move a square, and a shot of three frames to measure on."""
    folder.mkdir()

    def save(name: str, shape: tuple[int, ...], values: list[float], kind: str = "f") -> None:
        header = f"{{'descr': '<{kind}4', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
        data = struct.pack(f"<{len(values)}{kind}", *values)
        (folder / name).write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + data)

    rest = [0.0, 0, 0, 4, 0, 0, 4, 3, 0, 0, 3, 0]
    save("rest.npy", (4, 3), rest)
    save("faces.npy", (1, 4), [0, 1, 2, 3], "i")
    clips = {"train": [[a / 9, b / 9] for a in range(10) for b in range(10)], "shot": [[0, 0], [0.5, 0.25], [1, 1]]}
    for name, poses in clips.items():
        points = [list(rest) for _ in poses]
        for (up, out), point in zip(poses, points, strict=True):
            point[7] += up * up
            point[11] += out
        save(f"{name}.controls.npy", (len(poses), 2), [value for pose in poses for value in pose])
        save(f"{name}.points.npy", (len(poses), 4, 3), [value for point in points for value in point])
    document = {
        "format": "facebaker-dataset", "version": 1, "name": "square", "units": "cm", "up_axis": "y",
        "rest": {"points": "rest.npy", "faces": "faces.npy"},
        "controls": [{"name": name, "min": 0, "max": 1, "default": 0} for name in names],
        "clips": [{"name": name, "kind": "dense" if name == "train" else "shot", "fps": 24,
                   "split": "train" if name == "train" else "test",
                   "controls": f"{name}.controls.npy", "points": f"{name}.points.npy"} for name in clips],
    }  # fmt: skip
    (folder / "dataset.json").write_text(json.dumps(document))


class Viewing:
    """A running `facebaker view`; `stop` ends it."""

    def __init__(self, tool: str, *arguments: str, **environment: str) -> None:
        command = [tool, "view", "--no-open", "--port", "0", *arguments]
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ, **environment})
        assert self.process.stdout
        self.address = self.process.stdout.readline().strip()
        parts = urllib.parse.urlsplit(self.address)
        self.port = parts.port or 0
        self.token = urllib.parse.parse_qs(parts.query).get("token", [""])[0]
        self.headers: http.client.HTTPMessage = http.client.HTTPMessage()

    @property
    def bearer(self) -> dict[str, str]:
        return {"Authorization": f"Bearer {self.token}"}

    def ask(self, path: str, method: str = "GET", body: bytes | None = None, **headers: str) -> tuple[int, bytes]:
        """Header names have "_" for "-"."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=10)
        named = {name.replace("_", "-"): value for name, value in headers.items()}
        connection.request(method, path, body, {"Connection": "close", **named})
        answer = connection.getresponse()
        data = answer.read()
        self.headers = answer.headers
        connection.close()
        return answer.status, data

    @property
    def type(self) -> str:
        return self.headers.get("Content-Type", "")

    def stop(self) -> int:
        """Ctrl-C; the exit code."""
        self.process.send_signal(signal.SIGINT)
        self.process.communicate(timeout=20)
        return self.process.returncode

    def close(self) -> None:
        """Ends it at once, if it has not ended."""
        self.process.kill()
        self.process.communicate()

    def seconds_to_stop(self) -> float:
        start = time.monotonic()
        code = self.stop()
        assert code == 0, code
        return time.monotonic() - start
