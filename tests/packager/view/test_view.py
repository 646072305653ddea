"""`facebaker view` as a browser meets it: what it serves, what it refuses, and how it ends.

test_view.py FACEBAKER GOLDEN_FOLDER
"""

import json
import pathlib
import socket
import subprocess
import sys
import tempfile
import unittest

from viewing import Viewing, write_dataset, write_page

TOOL, GOLDEN = sys.argv[1], pathlib.Path(sys.argv[2])


class TestView(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        write_page(self.folder)
        self.page = str(self.folder / "page")

    def view(self, *arguments: str) -> Viewing:
        viewing = Viewing(TOOL, "--page", self.page, *arguments)
        self.addCleanup(viewing.close)
        return viewing

    def fails_with(self, *arguments: str) -> str:
        run = subprocess.run([TOOL, "view", "--no-open", *arguments], capture_output=True, text=True, timeout=10)
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertEqual(run.stdout, "")
        return run.stderr

    def test_serves_the_page_and_the_faces_and_nothing_else(self) -> None:
        faces = [GOLDEN / "tiny.fbk", GOLDEN / "character.fbk"]
        viewing = self.view(*map(str, faces))
        self.assertEqual(viewing.ask("/"), (200, b"<title>FaceBaker viewer</title>"))
        self.assertTrue(viewing.type.startswith("text/html"))
        self.assertEqual(viewing.ask("/assets/face.wasm")[1], b"\0asm")
        self.assertEqual(viewing.type, "application/wasm")
        listed = json.loads(viewing.ask("/view.json")[1])["faces"]
        self.assertEqual([face["name"] for face in listed], [face.name for face in faces])
        for face, entry in zip(faces, listed, strict=True):
            self.assertEqual(viewing.ask("/" + entry["url"]), (200, face.read_bytes()))
        for path in ("/secret", "/out", "/../secret", "/assets/../../secret", "/%2e%2e/secret", "/..%2fsecret",
                     "//etc/passwd", "/etc/passwd", "/beside/0.points.npy", "/faces/", "/faces/2.fbk"):  # fmt: skip
            status, data = viewing.ask(path)
            self.assertIn(status, (400, 404), path)
            self.assertNotIn(b"secret", data)
        self.assertEqual(viewing.ask("/", Host="example.org")[0], 403)
        self.assertEqual(viewing.ask("/", Origin="http://example.org")[0], 403)
        self.assertEqual(viewing.ask("/beside/pose", "POST", b"")[0], 404)
        with socket.create_server(("127.0.0.1", 0)) as taken:
            port = str(taken.getsockname()[1])
            self.assertIn(f"port {port}", self.fails_with(str(faces[0]), "--page", self.page, "--port", port))
        self.assertIn("port", self.fails_with(str(faces[0]), "--page", self.page, "--port", str(viewing.port)))
        self.assertEqual(viewing.stop(), 0)

    def test_serves_what_is_beside(self) -> None:
        data, face = self.folder / "data", self.folder / "face.fbk"
        write_dataset(data)
        subprocess.run([TOOL, "bake", str(data), "--recipe", "linear", "--out", str(face)], check=True, capture_output=True)
        viewing = self.view(str(face), "--beside", str(data))
        beside = json.loads(viewing.ask("/view.json")[1])["beside"]
        self.assertEqual((beside["name"], beside["live"], len(beside["clips"])), ("square", False, 1))
        clip = beside["clips"][0]
        self.assertEqual((clip["name"], clip["frames"], clip["fps"], clip["kind"]), ("shot", 3, 24, "shot"))
        for what in ("controls", "points"):
            served = viewing.ask("/" + clip[what], **viewing.bearer)[1]
            stored = (data / f"shot.{what}.npy").read_bytes()
            self.assertEqual(served[128:], stored[128:], what)
            self.assertEqual(served[:8], b"\x93NUMPY\x01\x00")
        self.assertEqual(viewing.stop(), 0)

    def test_says_what_is_wrong(self) -> None:
        face = str(GOLDEN / "tiny.fbk")
        broken = self.folder / "broken.fbk"
        broken.write_bytes((GOLDEN / "tiny.fbk").read_bytes()[:-20])
        self.assertIn("broken.fbk", self.fails_with(str(broken), "--page", self.page))
        self.assertIn("missing.fbk", self.fails_with(str(self.folder / "missing.fbk"), "--page", self.page))
        self.assertIn("samples/viewer/build.sh", self.fails_with(face, "--page", str(self.folder / "data")))
        write_dataset(self.folder / "data")
        self.assertIn("beside", self.fails_with(face, "--page", self.page, "--beside", str(self.folder / "data")))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
