"""The lines that `facebaker bake` writes to standard error while it works, taken apart. Without Blender."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import List

_SHARE = re.compile(r"^(?P<stage>[^:]+): +(?P<percent>\d+) %(?:, (?P<left>(?:about |less than )?[\d:]+(?: s)?) left)?$")
_DONE = re.compile(r"^(?P<stage>[^:]+): +(?P<time>\d+ s|\d+(?::\d\d)+)$")
_FAILED = re.compile(r"^facebaker(?: [a-z-]+)?: (?P<text>.+)$")


@dataclass
class BakeProgress:
    """How far a bake has come: what its lines said so far.

    stage: what is worked on, "" before the first. percent: 0 to 100, of the whole bake, or of the stage once it
    is over. left: how long the bake still takes, as a text, "" if not known. finished: stages that are done, with the time each took. notes: sentences about what was found. error: why it
    failed, "" if it did not."""

    stage: str = ""
    percent: int = 0
    left: str = ""
    finished: List[str] = field(default_factory=list)
    notes: List[str] = field(default_factory=list)
    error: str = ""

    def read(self, line: str) -> None:
        """Takes one line; what is no progress (such as what the rig prints) is passed over."""
        line = line.rstrip()
        if line.startswith("note: "):
            self.notes.append(line[len("note: ") :])
        elif share := _SHARE.match(line):
            self.stage, self.percent, self.left = share["stage"], int(share["percent"]), share["left"] or ""
        elif done := _DONE.match(line):
            self.finished.append(f"{done['stage']}: {done['time']}")
            self.stage, self.percent, self.left = done["stage"], 100, ""
        elif failed := _FAILED.match(line):
            self.error = failed["text"]

    @property
    def text(self) -> str:
        """For a status line."""
        if self.error:
            return self.error
        if not self.stage:
            return "starting"
        return f"{self.stage}: {self.percent} %" + (f", {self.left} left" if self.left else "")
