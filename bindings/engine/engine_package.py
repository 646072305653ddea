"""What the packers of packages for engines share: their options, and a folder that appears complete or not at all. Standard
library only."""

from __future__ import annotations

import argparse
import os
import pathlib
import sys
import tempfile
from typing import Callable, Iterable, List, Optional, Tuple

Libraries = List[Tuple[str, pathlib.Path]]


def read_libraries(texts: Iterable[str], platforms: Iterable[str]) -> Libraries:
    """The platforms and files of --library. Raises ValueError on what is no PLATFORM=FILE."""
    libraries = []
    for text in texts:
        platform, equals, file = text.partition("=")
        if not equals or platform not in platforms:
            raise ValueError(f"--library takes PLATFORM=FILE, with one of {', '.join(platforms)}, and not \"{text}\"")
        if not pathlib.Path(file).is_file():
            raise ValueError(f"there is no library {file}")
        libraries.append((platform, pathlib.Path(file)))
    return libraries


def main(program: str, description: str, platforms: Iterable[str], pack: Callable[[pathlib.Path, Libraries], None],
         arguments: Optional[List[str]]) -> int:
    """A packer: pack fills an empty folder, and raises OSError or ValueError; then the folder gets its name. Returns the
    exit code."""
    parser = argparse.ArgumentParser(prog=program, description=description)
    parser.add_argument("--out", type=pathlib.Path, required=True, help="the folder to make")
    parser.add_argument("--library", action="append", default=[], metavar="PLATFORM=FILE", help="a native library to pack")
    options = parser.parse_args(arguments)
    try:
        libraries = read_libraries(options.library, platforms)
        if options.out.exists():
            raise ValueError(f"{options.out} exists already")
        options.out.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=options.out.parent) as folder:
            package = pathlib.Path(folder, "package")
            package.mkdir()
            pack(package, libraries)
            os.replace(package, options.out)
    except (ValueError, OSError) as error:
        print(f"{program}: {error}", file=sys.stderr)
        return 1
    return 0
