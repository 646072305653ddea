"""Calls of libfacebaker_bake that take long: their callbacks, Ctrl-C, and what they raise."""

from __future__ import annotations

import os
import signal
import threading
from ctypes import c_char_p
from typing import Any, Callable, List, Optional, Sequence, Tuple

from . import _interop as abi
from ._errors import RigError
from ._library import bake_library as library
from ._progress import Progress, close_progress, shown_progress

Note = Optional[Callable[[str], Any]]


class Call:
    """One call and its callbacks. A context: within it, Ctrl-C makes the call end at the next point where nothing is lost,
    and a second Ctrl-C is raised in what runs of Python then, such as a rig.

    progress: called with stage, steps done and steps in all, at least twice a second but for the time that a rig takes;
    True: shows it on standard error. note: called with sentences for the user, which are kept in `notes`, too. What
    either of them raises ends the call and is raised by run()."""

    def __init__(self, progress: Progress = None, note: Note = None) -> None:
        self._progress, self._note = shown_progress(progress), note
        self._interrupted = False
        self._raised: Optional[BaseException] = None
        self._handler: Any = None
        self.notes: List[str] = []
        self.callbacks = abi.fb_callbacks(
            None, abi.fb_callbacks_progress(self._on_progress), abi.fb_callbacks_note(self._on_note)
        )

    def __enter__(self) -> "Call":
        if threading.current_thread() is threading.main_thread():
            if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
                self._handler = signal.signal(signal.SIGINT, self._on_interrupt)
        return self

    def __exit__(self, *_: Any) -> None:
        if self._handler is not None:
            signal.signal(signal.SIGINT, self._handler)
        close_progress(self._progress)

    def run(self, function: Any, *arguments: Any, rig: Any = None) -> None:
        """Calls a function that returns a status. Raises what a callback raised, KeyboardInterrupt after Ctrl-C, or the
        status' exception, whose cause is what `rig`, a HostRig, raised last."""
        status = function(*arguments)
        raised = rig.take_raised() if rig is not None else None
        if self._interrupted or isinstance(raised, KeyboardInterrupt):
            raise KeyboardInterrupt
        if self._raised is not None:
            raise self._raised
        if raised is not None and not isinstance(raised, Exception):
            raise raised
        try:
            library.check(status)
        except RigError as error:
            raise error from raised

    def _on_interrupt(self, *_: Any) -> None:
        if self._interrupted:
            raise KeyboardInterrupt
        self._interrupted = True

    def _on_progress(self, _: Any, stage: bytes, done: int, total: int) -> int:
        try:
            if self._progress is not None and not self._stopping():
                self._progress(stage.decode(), done, total)
        except BaseException as error:
            self._raised = error
        return int(self._stopping())

    def _on_note(self, _: Any, sentence: bytes) -> None:
        try:
            self.notes.append(sentence.decode("utf-8", "replace"))
            if self._note is not None:
                self._note(self.notes[-1])
        except BaseException as error:
            self._raised = error

    def _stopping(self) -> bool:
        return self._interrupted or self._raised is not None


def path_bytes(path: Any) -> bytes:
    """A path or SOURCE as the library takes it. Raises ValueError on a zero byte, at which the library would stop."""
    encoded = os.fsencode(path)
    if b"\0" in encoded:
        raise ValueError(f"{path!r} has a zero byte")
    return encoded


def text_bytes(text: str) -> bytes:
    """The same of a text."""
    if "\0" in text:
        raise ValueError(f"{text!r} has a zero byte")
    return text.encode()


def c_strings(texts: Sequence[bytes]) -> Tuple[Any, int]:
    """An array of C strings and their number; None where there are none."""
    return ((c_char_p * len(texts))(*texts) if texts else None), len(texts)
