"""The lines that `facebaker bake` writes to standard error while it works, taken apart. Without Blender."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import List

_SHARE = re.compile(r"^(?P<stage>[^:]+): +(?P<percent>\d+) %(?:, (?P<left>(?:about |less than )?[\d:]+(?: s)?) left)?$")
_DONE = re.compile(r"^(?P<stage>[^:]+): +(?P<time>\d+ s|\d+(?::\d\d)+)$")
_FAILED = re.compile(r"^facebaker(?: [a-z-]+)?: (?P<text>.+)$")
_LAST_OF_RIG = "Blender quit"  # of the processes that evaluate, which end later than the tool tells


@dataclass
class BakeProgress:
    """How far a bake has come: what its lines said so far.

    stage: what is worked on, "" before the first. percent: 0 to 100, of the whole bake, or of the stage once it is over.
    left: how long the bake still takes, as the tool writes it ("about 2:07", "9 s"), "" if it does not say. finished: stages
    that are done, with the time each took. notes: sentences about what was found. error: why it failed, all of its
    lines, "" if it did not."""

    stage: str = ""
    percent: int = 0
    left: str = ""
    finished: List[str] = field(default_factory=list)
    notes: List[str] = field(default_factory=list)
    error: str = ""

    def read(self, line: str) -> None:
        """Takes one line; what is no progress (such as what the rig prints) is passed over."""
        line = line.rstrip()
        if self.error and not _FAILED.match(line):  # the last that the tool writes; it may have several lines
            self.error += f"\n{line}" if line and line != _LAST_OF_RIG else ""
        elif line.startswith("note: "):
            self.notes.append(line[len("note: ") :])
        elif share := _SHARE.match(line):
            self.stage, self.percent, self.left = share["stage"], int(share["percent"]), share["left"] or ""
        elif done := _DONE.match(line):
            self.finished.append(f"{done['stage']}: {done['time']}")
            self.stage, self.percent, self.left = done["stage"], 100, ""
        elif failed := _FAILED.match(line):
            self.error = failed["text"]

    @property
    def lines(self) -> List[str]:
        """For people who look at a window: the stage and how far the bake is, and how long it still takes."""
        if not self.stage:
            return ["Starting"]
        stage = self.stage[:1].upper() + self.stage[1:]
        return [f"{stage}: {self.percent} %", *([f"{spoken_time(self.left)} left"] if self.left else [])]

    @property
    def text(self) -> str:
        """For a status line."""
        if self.error:
            return self.error
        if not self.stage:
            return "starting"
        return f"{self.stage}: {self.percent} %" + (f", {self.left} left" if self.left else "")


def spoken_time(text: str) -> str:
    """"about 2:07" -> "About 2 minutes", "1:30:10" -> "1 hour 30 minutes", "less than 2:07" -> "Less than 3 minutes"."""
    start, numbers = re.split(r"\d", text)[0], [int(number) for number in re.findall(r"\d+", text)]
    seconds = sum(number * 60**place for place, number in enumerate(reversed(numbers)))
    if seconds < 60:
        return (start + _counted(seconds, "second")).capitalize()
    rounding = 59 if start.startswith("less") else 30
    hours, minutes = divmod((seconds + rounding) // 60, 60)
    parts = [_counted(count, what) for count, what in ((hours, "hour"), (minutes, "minute")) if count]
    return (start + " ".join(parts)).capitalize()


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" + ("" if count == 1 else "s")
