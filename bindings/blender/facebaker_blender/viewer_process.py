"""`facebaker view` in the background, which ends with Blender. Without Blender."""

from __future__ import annotations

import atexit
import ctypes
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
from typing import IO, Any, Optional

from .tool_command import HERE, tool_environment

_ADDRESS = re.compile(r"^(https?://\S+)$", re.MULTILINE)
_FAILED = re.compile(r"^facebaker(?:-view)?(?: view)?: ", re.MULTILINE)
# What the tool says where it was built or packed without the viewer.
_MISSING = ("no built viewer", "no program facebaker-view")
_MOST_OUTPUT = 1 << 16  # bytes
_SET_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of prctl
_LIBC: Any = ctypes.CDLL(None) if sys.platform.startswith("linux") else None


class ViewerProcess:
    """The viewer of one face at a time. Attributes: archive, the face that was shown last; None before."""

    def __init__(self) -> None:
        self.archive: Optional[pathlib.Path] = None
        self._process: Optional[subprocess.Popen[bytes]] = None
        self._output: Optional[IO[bytes]] = None
        self._carried = False

    def start(self, tool: str, archive: pathlib.Path) -> None:
        """Shows a face in the browser, in place of the one that is shown: an archive may have been baked anew. Raises
        OSError."""
        self.stop()
        self.archive, self._carried = archive, HERE / "carried" in pathlib.Path(tool).parents
        self._output = tempfile.TemporaryFile()
        self._process = subprocess.Popen(
            [tool, "view", str(archive), "--port", "0"],
            stdin=subprocess.DEVNULL, stdout=self._output, stderr=subprocess.STDOUT, env=tool_environment(tool),
            preexec_fn=_end_with_parent,
        )  # fmt: skip
        atexit.register(self.stop)

    @property
    def running(self) -> bool:
        return self._process is not None and self._process.poll() is None

    @property
    def address(self) -> str:
        """Where the browser finds the face, "" until it can or after the viewer has ended."""
        found = _ADDRESS.search(self._said()) if self.running else None
        return found[1] if found else ""

    @property
    def failure(self) -> str:
        """Why the viewer ended by itself, "" if it did not."""
        if self._process is None or self.running:
            return ""
        said = _FAILED.sub("", self._said()).strip() or f"the viewer ended with {self._process.returncode}"
        if not any(missing in said for missing in _MISSING):
            return said
        whose = "the add-on's zip was packed without the viewer" if self._carried else "this FaceBaker has no viewer"
        return f"{whose}: name a program facebaker that has it in the add-on's preferences. The program says: {said}"

    def stop(self) -> None:
        """Ends the viewer, if one is there."""
        atexit.unregister(self.stop)
        if self._process is not None and self.running:
            self._process.terminate()
            try:
                self._process.wait(5)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        if self._output is not None:
            self._output.close()
        self._process = self._output = None

    def _said(self) -> str:
        if self._output is None:
            return ""
        # At its own place: the child writes at that of the file.
        return os.pread(self._output.fileno(), _MOST_OUTPUT, 0).decode("utf-8", "replace")


def _end_with_parent() -> None:
    """In the child: it ends even where Blender is killed."""
    if _LIBC is not None:
        _LIBC.prctl(_SET_DEATH_SIGNAL, signal.SIGTERM)
