"""Archives opened with everything in them, for measuring and inspecting."""

from __future__ import annotations

import os
import weakref
from ctypes import byref, c_void_p
from typing import TYPE_CHECKING, Union

from ._calls import path_bytes
from ._interop import fb_archive_info
from ._library import bake_library as library

if TYPE_CHECKING:
    from ._face import Face

AnyArchive = Union[str, "os.PathLike[str]", bytes, "Face"]


class Archive:
    """archive: a path, the bytes of an archive, or a Face, whose file or bytes are read again."""

    def __init__(self, archive: AnyArchive) -> None:
        source = getattr(archive, "source", archive)
        self.handle = c_void_p()
        if isinstance(source, bytes):
            library.check(library.fb_archive_open_memory(source, len(source), None, byref(self.handle)))
        else:
            library.check(library.fb_archive_open(path_bytes(source), byref(self.handle)))
        weakref.finalize(self, library.fb_archive_close, self.handle)

    def text(self, field: str) -> str:
        """A text of fb_archive_info."""
        info = library.filled(fb_archive_info)
        library.check(library.fb_archive_describe(self.handle, info))
        value: bytes = getattr(info, field)
        return value.decode()
