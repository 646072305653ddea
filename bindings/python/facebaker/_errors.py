"""What calls fail with: an exception for each status of facebaker.h."""

from __future__ import annotations

from typing import Dict, Type

from . import _interop as abi


class Error(Exception):
    """A call that failed; the text is the library's sentence, which names what is wrong and where.

    `status` is the number of facebaker.h, `status_name` its constant ("FB_ERROR_CORRUPT")."""

    def __init__(self, status: int, status_name: str, message: str) -> None:
        super().__init__(message)
        self.status = status
        self.status_name = status_name

    def __reduce__(self) -> "tuple[Type[Error], tuple[int, str, str]]":
        return type(self), (self.status, self.status_name, str(self))


class InvalidArgumentError(Error, ValueError):
    """An argument the library refuses: a number out of range, options that exclude each other."""


class NotFoundError(Error):
    """There is no such file, control, mesh, recipe, ..."""


class FileError(Error):
    """The system refused a read or a write, or another process has what is to be written (FB_ERROR_IO)."""


class NotAnArchiveError(Error):
    """The file is no .fbk archive."""


class CorruptError(Error):
    """The archive is truncated or damaged."""


class UnsupportedError(Error):
    """The archive has another format version, or needs parts that this library does not know."""


class LimitError(Error):
    """Something is larger than a limit allows, or a target of size or error cannot be met."""


class OutOfMemoryError(Error, MemoryError):
    """The library could not allocate memory."""


class NotFiniteError(Error):
    """There is a NaN or an infinity where a number is needed."""


class BadDataError(Error):
    """Data contradict each other."""


class RigError(Error):
    """A rig failed or broke its contract. If it is a Python one, what it raised is the `__cause__`."""


class StoppedError(Error):
    """The progress callback stopped the call (FB_ERROR_INTERRUPTED). Ctrl-C raises KeyboardInterrupt instead."""


class InternalError(Error):
    """An error of the library itself."""


STATUS_ERRORS: Dict[int, Type[Error]] = {
    abi.FB_ERROR_INVALID_ARGUMENT: InvalidArgumentError,
    abi.FB_ERROR_NOT_FOUND: NotFoundError,
    abi.FB_ERROR_IO: FileError,
    abi.FB_ERROR_NOT_AN_ARCHIVE: NotAnArchiveError,
    abi.FB_ERROR_CORRUPT: CorruptError,
    abi.FB_ERROR_UNSUPPORTED: UnsupportedError,
    abi.FB_ERROR_LIMIT: LimitError,
    abi.FB_ERROR_OUT_OF_MEMORY: OutOfMemoryError,
    abi.FB_ERROR_NOT_FINITE: NotFiniteError,
    abi.FB_ERROR_BAD_DATA: BadDataError,
    abi.FB_ERROR_RIG: RigError,
    abi.FB_ERROR_INTERRUPTED: StoppedError,
    abi.FB_ERROR_INTERNAL: InternalError,
}
