"""Working memory of evaluations: a pool, so that threads evaluate one face at once."""

from __future__ import annotations

import contextlib
import threading
import weakref
from ctypes import byref, c_void_p
from typing import Iterator, List, Optional

from ._library import check, library


class _Scratch:
    """Freed with this object; the model lives as long."""

    def __init__(self, model: c_void_p, workers: int, several: bool) -> None:
        self.workers, self.several = workers, several
        self.handle = c_void_p()
        create = library.fb_scratch_create if several else library.fb_scratch_create_single
        check(create(model, workers, byref(self.handle)))
        weakref.finalize(self, library.fb_scratch_destroy, self.handle)

    def serves(self, workers: int, several: bool) -> bool:
        return self.workers >= workers and (self.several or not several)


class ScratchPool:
    """Scratches of a model, which it keeps until it is gone: as many as there were calls at once, of the kinds that these
    asked for. Thread-safe, without a lock, which a fork could leave taken."""

    def __init__(self, model: c_void_p) -> None:
        self._model = model
        self._free: List[_Scratch] = []
        self._last = threading.local()

    @contextlib.contextmanager
    def borrow(self, workers: int = 1, several: bool = False) -> Iterator[c_void_p]:
        """A scratch for so many workers at least, the caller's within the context. several: with room to evaluate several
        poses together, in four times the memory."""
        free = self._free
        scratch = self._take(workers, several)
        if scratch is None:
            for other in tuple(free):  # in their place the new one serves
                if workers >= other.workers and several >= other.several:
                    self._removed(other)
            scratch = _Scratch(self._model, workers, several)
        try:
            yield scratch.handle
            self._last.clamped = library.fb_clamped_count(scratch.handle)
        finally:
            free.append(scratch)

    def _take(self, workers: int, several: bool) -> Optional[_Scratch]:
        for scratch in tuple(self._free):
            if scratch.serves(workers, several) and self._removed(scratch):
                return scratch
        return None

    def _removed(self, scratch: _Scratch) -> bool:
        """Whether it was still free."""
        try:
            self._free.remove(scratch)
        except ValueError:
            return False
        return True

    def close(self) -> None:
        """Frees all scratches but those that calls are using, which are freed after these."""
        self._free = []

    @property
    def clamped_count(self) -> int:
        """Control values that this thread's last successful evaluation clamped."""
        count: int = getattr(self._last, "clamped", 0)
        return count
