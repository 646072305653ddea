"""The two libraries: finding them, their functions and their errors."""

from __future__ import annotations

import ctypes
import ctypes.util
import os
import pathlib
import sys
from typing import Any, Iterable, List, Type, TypeVar

from ._errors import STATUS_ERRORS, Error
from ._interop import FB_OK, FUNCTIONS

AnyStruct = TypeVar("AnyStruct", bound=ctypes.Structure)


class Library:
    """A shared library whose functions are attributes; opened when the first is used. Thread-safe."""

    def __init__(self, name: str, variable: str) -> None:
        self._name, self._variable = name, variable

    def __getattr__(self, name: str) -> Any:
        if name not in FUNCTIONS:
            raise AttributeError(name)
        if "_opened" not in self.__dict__:
            self._opened = self._open()
        function = getattr(self._opened, name)
        function.restype, function.argtypes = FUNCTIONS[name]
        setattr(self, name, function)
        return function

    def check(self, status: int) -> None:
        """Raises Error unless status is FB_OK. To be called on the thread whose call gave the status."""
        if status != FB_OK:
            name = self.fb_status_name(status).decode()
            message = self.fb_last_error().decode("utf-8", "replace")
            raise STATUS_ERRORS.get(status, Error)(status, name, message)

    def filled(self, struct: Type[AnyStruct]) -> AnyStruct:
        """A struct with the library's defaults, by its fb_..._fill."""
        made = struct()
        getattr(self, struct.__name__ + "_fill")(made, ctypes.sizeof(made))
        return made

    def _candidates(self) -> List[str]:
        named = os.environ.get(self._variable)
        if named:
            return [named]
        file = _file_of(self._name)
        places = [pathlib.Path(__file__).with_name(file)]
        if os.environ.get("FACEBAKER_LIBRARY"):
            places.insert(0, pathlib.Path(os.environ["FACEBAKER_LIBRARY"]).with_name(file))
        found = ctypes.util.find_library(self._name)
        return [str(place) for place in places if place.exists()] + ([found] if found else [])

    def _open(self) -> ctypes.CDLL:
        candidates = self._candidates()
        if not candidates:
            raise ImportError(
                f"{_file_of(self._name)} was not found; name it in the environment variable {self._variable}"
                + (". Packages for other systems than Linux on x86-64 pose only" if self._name == "facebaker_bake" else "")
            )
        try:
            return ctypes.CDLL(candidates[0])
        except OSError as error:
            # What a wheel carries for systems without it; once loaded, it is found by its name.
            if not _load_all(pathlib.Path(__file__).parent.glob("carried/*")):
                raise ImportError(str(error)) from error
        return ctypes.CDLL(candidates[0])


def _file_of(name: str) -> str:
    """How this system calls a shared library."""
    if sys.platform == "win32":
        return f"{name}.dll"
    return f"lib{name}.dylib" if sys.platform == "darwin" else f"lib{name}.so"


def assign(struct: ctypes.Structure, **values: "int | float") -> None:
    """Sets numbers of a struct. Raises ValueError on one that the field cannot hold, which ctypes would cut."""
    for name, value in values.items():
        setattr(struct, name, value)
        if getattr(struct, name) != value:
            raise ValueError(f"{name} is {value}")


def _load_all(paths: Iterable[pathlib.Path]) -> int:
    """Loads libraries, of which some may need others; how many there are."""
    left = list(paths)
    count = len(left)
    while left:
        failed = [path for path in left if not _loads(path)]
        if len(failed) == len(left):
            break
        left = failed
    return count


def _loads(path: pathlib.Path) -> bool:
    try:
        ctypes.CDLL(str(path))
    except OSError:
        return False
    return True


library = Library("facebaker", "FACEBAKER_LIBRARY")
bake_library = Library("facebaker_bake", "FACEBAKER_BAKE_LIBRARY")
check = library.check
