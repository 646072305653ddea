"""Working memory of evaluations: a pool, so that threads evaluate one face at once."""

from __future__ import annotations

import contextlib
import threading
import weakref
from ctypes import byref, c_void_p
from typing import Dict, Iterator, List

from ._library import check, library


class _Scratch:
    """Freed with this object; the model lives as long."""

    def __init__(self, model: c_void_p, workers: int) -> None:
        self.handle = c_void_p()
        check(library.fb_scratch_create(model, workers, byref(self.handle)))
        weakref.finalize(self, library.fb_scratch_destroy, self.handle)


class ScratchPool:
    """Scratches of a model, which it keeps until it is gone: as many as there were calls at once. Thread-safe."""

    def __init__(self, model: c_void_p) -> None:
        self._model = model
        self._free: Dict[int, List[_Scratch]] = {}  # by their workers
        self._last = threading.local()

    @contextlib.contextmanager
    def borrow(self, workers: int) -> Iterator[c_void_p]:
        """A scratch for so many workers, the caller's within the context."""
        free = self._free.setdefault(workers, [])
        try:
            scratch = free.pop()
        except IndexError:
            scratch = _Scratch(self._model, workers)
        try:
            yield scratch.handle
            self._last.clamped = library.fb_clamped_count(scratch.handle)
        finally:
            free.append(scratch)

    def close(self) -> None:
        """Frees all scratches but those that calls are using, which are freed after these."""
        self._free = {}

    @property
    def clamped_count(self) -> int:
        """Control values that this thread's last successful evaluation clamped."""
        count: int = getattr(self._last, "clamped", 0)
        return count
