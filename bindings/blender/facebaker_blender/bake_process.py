"""A bake, or another command of the tool, in the background: a process of its own that outlives this one, whose log tells how
far it has come. Without Blender."""

from __future__ import annotations

import json
import os
import pathlib
import signal
import subprocess
from typing import Any, Dict, List, Optional, Sequence

from .progress_lines import BakeProgress

LAST_LINES = 8  # of a log that are shown where a bake ended without saying why

class BakeProcess:
    """A bake whose log, result and process number lie in a folder, so that another session of Blender finds it again.

    Attributes: progress, as of the last call of poll(); what, the command of the tool, for messages."""

    def __init__(self, folder: pathlib.Path, what: str = "bake") -> None:
        self.folder, self.what = folder, what
        self.log, self.result = folder / f"{what}.log", folder / "result.json"
        self._state = folder / "process.json"
        self.progress = BakeProgress()
        self._read = 0
        self._process: Optional[subprocess.Popen[bytes]] = None

    def start(self, words: Sequence[str], environment: Optional[Dict[str, str]] = None) -> None:
        """Starts the command line in a session of its own, where neither Ctrl-C nor the end of this process reaches it.
        environment: None: that of this process. Raises OSError; RuntimeError if the folder's bake is running."""
        if self.running:
            raise RuntimeError(f"a {self.what} is running in {self.folder}")
        self.progress, self._read = BakeProgress(), 0
        with open(self.log, "wb") as log, open(self.result, "wb") as result:
            self._process = subprocess.Popen(
                list(words), stdin=subprocess.DEVNULL, stdout=result, stderr=log, env=environment, start_new_session=True
            )
        state = {"process": self._process.pid, "began": _began(self._process.pid), "command": list(words)}
        self._state.write_text(json.dumps(state))

    @property
    def running(self) -> bool:
        if self._process is not None:
            return self._process.poll() is None
        began = self._stated("began")  # "" of one that had ended before that was asked
        return bool(began) and _began(self._number()) == began

    @property
    def unfinished(self) -> bool:
        """Whether a bake began here, is not running and did not complete: start() with command() goes on with it."""
        return bool(self.command) and not self.running and self.document is None

    @property
    def command(self) -> List[str]:
        """The command line of the last start, empty if there was none."""
        words = self._stated("command")
        return [str(word) for word in words] if isinstance(words, list) else []

    def poll(self) -> bool:
        """Reads what is new in the log. Whether the bake is still running."""
        running = self.running  # first: what is written before the end is read below
        try:
            with open(self.log, "rb") as log:
                log.seek(self._read)
                text = log.read()
        except OSError:
            return running
        end = len(text) if not running else text.rfind(b"\n") + 1
        self._read += end
        for line in text[:end].decode("utf-8", "replace").splitlines():
            self.progress.read(line.rpartition("\r")[2])
        return running

    @property
    def document(self) -> Optional[Dict[str, Any]]:
        """What the bake printed when it was complete, None before."""
        try:
            document = json.loads(self.result.read_bytes())
        except (OSError, ValueError):
            return None
        return document if isinstance(document, dict) else None

    @property
    def failure(self) -> str:
        """Why the last bake ended without a result, all that the tool said of it; "" if none did."""
        if not self.unfinished:
            return ""
        self.poll()
        if self.progress.error:
            return self.progress.error
        last = "\n".join(_text(self.log).splitlines()[-LAST_LINES:]).strip()
        return f"the {self.what} ended without a result; {self.log} " + (f"ends with:\n{last}" if last else "is empty")

    def stop(self) -> None:
        """Interrupts the bake, which keeps what is done. It ends within seconds; poll() tells when."""
        number = self._number()
        if self.running and number > 0:
            os.kill(number, signal.SIGINT)

    def wait(self, seconds: float) -> bool:
        """Waits for the end of a bake that this object started, for so long. Whether it has ended."""
        try:
            if self._process is not None:
                self._process.wait(seconds)
        except subprocess.TimeoutExpired:
            pass
        return not self.running

    def _number(self) -> int:
        number = self._stated("process")
        return number if isinstance(number, int) else 0

    def _stated(self, key: str) -> Any:
        try:
            return json.loads(self._state.read_text()).get(key)
        except (OSError, ValueError, AttributeError):
            return None


def _text(path: pathlib.Path) -> str:
    try:
        return path.read_bytes().decode("utf-8", "replace")
    except OSError:
        return ""


def _began(process: int) -> str:
    """When a process began, by the system's clock, so that another one that has got its number is not taken for it. "" if
    there is none, or it has ended."""
    try:
        fields = pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return ""
    return "" if fields[0] == "Z" else fields[19]
