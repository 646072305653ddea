"""What is looked at before a bake, and the viewer in the background; without Blender."""

import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import types
import unittest
from unittest import mock

from facebaker_blender import viewer_process
from facebaker_blender.bake_check import check_before_bake
from facebaker_blender.channels import SettingsError
from facebaker_blender.viewer_process import ViewerProcess

STARTS_VIEWER = """
import pathlib, sys, time
from facebaker_blender.viewer_process import ViewerProcess
viewer = ViewerProcess()
viewer.start(sys.argv[1], pathlib.Path("face.fbk"))
print(viewer._process.pid, flush=True)
time.sleep(float(sys.argv[2]))
"""


class FolderTest(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self._folder.name)

    def tearDown(self):
        self._folder.cleanup()

    def program(self, text, name="facebaker"):
        """A script of the shell in place of the tool."""
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"#!/bin/sh\n{text}\n")
        path.chmod(0o755)
        return str(path)


class CheckTest(FolderTest):
    def check(self, tool, archive="face.fbk", library="1.2.0"):
        package = types.ModuleType("facebaker")
        if library:
            package.__version__ = library
        else:

            def missing(name):
                raise ImportError("libfacebaker was not found")

            package.__getattr__ = missing
        with mock.patch.dict(sys.modules, {"facebaker": package}):
            check_before_bake(self.folder / archive, self.folder / "face.blender", tool)

    def refused(self, pattern, *arguments, **options):
        with self.assertRaisesRegex(SettingsError, pattern):
            self.check(*arguments, **options)

    def test_all_is_there(self):
        self.check(self.program("echo facebaker 1.2.0"))
        self.assertEqual(sorted(os.listdir(self.folder)), ["face.blender", "facebaker"])
        self.assertEqual(os.listdir(self.folder / "face.blender"), [])

    def test_the_tool(self):
        self.refused("does not run as facebaker: no libgomp$", self.program("echo no libgomp >&2; exit 127"))
        self.refused("does not run as facebaker: another 1.2", self.program("echo another 1.2"))
        self.refused("does not run: ", str(self.folder / "nothing"))

    def test_the_library(self):
        tool = self.program("echo facebaker 1.10.0")
        self.refused("could not be shown: libfacebaker was not found", tool, library="")
        self.refused("is version 1.10.0, the library of .* 1.2.0", tool)
        self.check(tool, library="1.10.1")

    def test_the_folder(self):
        tool = self.program("echo facebaker 1.2.0")
        (self.folder / "file").touch()
        self.refused("file: nothing can be written there: ", tool, archive="file/face.fbk")
        (self.folder / "taken.fbk").mkdir()
        self.refused("taken.fbk: is a folder", tool, archive="taken.fbk")
        self.refused("/proc/nowhere: nothing can be written there", tool, archive="/proc/nowhere/face.fbk")


class ViewerTest(FolderTest):
    SERVES = 'echo "$@" > "$0.words"; echo http://127.0.0.1:4711/token/; echo "Ctrl-C ends it" >&2; exec sleep 60'

    def wait_for(self, what):
        end = time.monotonic() + 20
        while not what() and time.monotonic() < end:
            time.sleep(0.02)
        return what()

    def test_it_serves_until_it_is_ended(self):
        viewer, tool = ViewerProcess(), self.program(self.SERVES)
        self.assertEqual((viewer.running, viewer.address, viewer.failure), (False, "", ""))
        viewer.start(tool, pathlib.Path("/a b/face.fbk"))
        self.assertEqual(self.wait_for(lambda: viewer.address), "http://127.0.0.1:4711/token/")
        self.assertEqual(pathlib.Path(f"{tool}.words").read_text(), "view /a b/face.fbk --port 0\n")
        first = viewer._process
        viewer.start(tool, pathlib.Path("other.fbk"))  # in its place
        self.assertIsNotNone(first.poll())
        self.assertEqual(self.wait_for(lambda: viewer.address), "http://127.0.0.1:4711/token/")
        viewer.stop()
        self.assertEqual((viewer.running, viewer.address, viewer.failure), (False, "", ""))

    def failure(self, tool):
        viewer = ViewerProcess()
        viewer.start(tool, pathlib.Path("face.fbk"))
        self.assertTrue(self.wait_for(lambda: viewer.failure))
        said = viewer.failure
        viewer.stop()
        return said

    def test_failures(self):
        said = self.failure(self.program("echo 'facebaker view: face.fbk: no archive' >&2; exit 1"))
        self.assertEqual(said, "face.fbk: no archive")
        missing = "echo 'facebaker view: there is no built viewer in /x; build it' >&2; exit 1"
        said = self.failure(self.program(missing))
        self.assertRegex(said, "^this FaceBaker has no viewer: name a program .*: there is no built viewer in /x; build it$")
        with mock.patch.object(viewer_process, "HERE", self.folder.resolve()):
            carried = self.program(missing, "carried/bin/facebaker")
            self.assertRegex(self.failure(str(pathlib.Path(carried).resolve())), "^the add-on's zip was packed without the viewer: ")

    def test_it_ends_with_its_parent(self):
        tool = self.program(self.SERVES)
        for seconds, kill in (("0.3", False), ("60", True)):
            words = [sys.executable, "-c", STARTS_VIEWER, tool, seconds]
            parent = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
            number = int(parent.stdout.readline())
            if kill:
                parent.send_signal(signal.SIGKILL)
            parent.wait(20)
            parent.stdout.close()
            self.assertTrue(self.wait_for(lambda: not is_running(number)))


def is_running(process):
    try:
        return pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


if __name__ == "__main__":
    unittest.main()
