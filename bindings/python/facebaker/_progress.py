"""Progress for people, on standard error: by tqdm if it is installed, else in words."""

from __future__ import annotations

import importlib
import sys
from typing import Any, Callable, Optional, Union

ProgressFunction = Callable[[str, int, int], Any]
Progress = Union[None, bool, ProgressFunction]


class _Bars:
    """A bar of tqdm for each stage."""

    def __init__(self, tqdm: Any) -> None:
        self._tqdm, self._stage = tqdm, ""
        self._bar: Any = None

    def __call__(self, stage: str, done: int, total: int) -> None:
        if self._bar is None or stage != self._stage:
            self.close()
            self._bar, self._stage = self._tqdm(desc=stage, total=total), stage
        self._bar.total = total
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()
        self._bar = None


class _Words:
    """A line for each stage; on a terminal it counts."""

    def __init__(self) -> None:
        self._stage = ""
        self._counts = sys.stderr.isatty()

    def __call__(self, stage: str, done: int, total: int) -> None:
        if stage != self._stage:
            self.close()
            self._stage = stage
            if not self._counts:
                print(stage, file=sys.stderr, flush=True)
        if self._counts:
            print(f"\r{stage} {done}/{total}\033[K", end="", file=sys.stderr, flush=True)

    def close(self) -> None:
        if self._counts and self._stage:
            print(file=sys.stderr)


def shown_progress(progress: Progress) -> Optional[ProgressFunction]:
    """What is called with stage, steps done and steps in all; None if nothing is."""
    if progress is None or progress is False:
        return None
    if progress is not True:
        return progress
    try:
        return _Bars(importlib.import_module("tqdm").tqdm)
    except ImportError:
        return _Words()


def close_progress(progress: Optional[ProgressFunction]) -> None:
    """Ends the last line of what is shown."""
    if isinstance(progress, (_Bars, _Words)):
        progress.close()
