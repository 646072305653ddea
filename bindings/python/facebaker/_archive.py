"""Archives opened with everything in them, for measuring and inspecting."""

from __future__ import annotations

import os
import weakref
from ctypes import byref, c_void_p
from typing import TYPE_CHECKING, Union

from ._bake_library import check, library
from ._bake_structs import ArchiveInfoStruct
from ._calls import path_bytes
from ._structs import filled

if TYPE_CHECKING:
    from ._face import Face

AnyArchive = Union[str, "os.PathLike[str]", bytes, "Face"]


class Archive:
    """archive: a path, the bytes of an archive, or a Face, whose file or bytes are read again."""

    def __init__(self, archive: AnyArchive) -> None:
        source = getattr(archive, "source", archive)
        self.handle = c_void_p()
        if isinstance(source, bytes):
            check(library.fb_archive_open_memory(source, len(source), None, byref(self.handle)))
        else:
            check(library.fb_archive_open(path_bytes(source), byref(self.handle)))
        weakref.finalize(self, library.fb_archive_close, self.handle)

    def text(self, field: str) -> str:
        """A text of fb_archive_info."""
        info = filled(ArchiveInfoStruct, library.fb_archive_info_fill)
        check(library.fb_archive_describe(self.handle, info))
        value: bytes = getattr(info, field)
        return value.decode()
