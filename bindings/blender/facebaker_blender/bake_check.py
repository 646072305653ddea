"""What a bake needs when it is over, looked at before it begins: no hour of work is lost for a folder or a library. Without
Blender."""

from __future__ import annotations

import pathlib
import subprocess
import tempfile

from .channels import SettingsError
from .tool_command import tool_environment

_ANSWER_SECONDS = 60  # for a program to say its version


def check_before_bake(archive: pathlib.Path, work: pathlib.Path, tool: str) -> None:
    """Raises SettingsError if the tool does not run, the Python package's library is missing or older than the tool, or the
    archive or its work folder could not be written."""
    program, library = _tool_version(tool), _library_version()
    if _numbers(library) < _numbers(program):
        raise SettingsError(
            f"the program {tool} is version {program}, the library of the Python package facebaker {library}: it may not read "
            "what the program bakes; name those of one version in the add-on's preferences"
        )
    if archive.is_dir():
        raise SettingsError(f"{archive}: is a folder")
    for folder in archive.parent, work:
        _check_writable(folder)


def _tool_version(tool: str) -> str:
    try:
        done = subprocess.run(
            [tool, "--version"], capture_output=True, text=True, errors="replace", timeout=_ANSWER_SECONDS, env=tool_environment(tool)
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise SettingsError(f"the program {tool} does not run: {error}") from None
    words = done.stdout.split()
    if done.returncode != 0 or len(words) < 2 or words[0] != "facebaker":
        said = (done.stderr or done.stdout).strip() or f"it ended with {done.returncode}"
        raise SettingsError(f"the program {tool} does not run as facebaker: {said}")
    return words[1]


def _library_version() -> str:
    """The package has been made importable."""
    try:
        import facebaker

        return str(facebaker.__version__)  # opens the library
    except ImportError as error:
        raise SettingsError(f"the baked face could not be shown: {error}") from None


def _numbers(version: str) -> "list[int]":
    return [int(part) for part in version.split(".") if part.isdigit()]


def _check_writable(folder: pathlib.Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".facebaker-"):
            pass
    except OSError as error:
        raise SettingsError(f"{folder}: nothing can be written there: {error.strerror or error}") from None
