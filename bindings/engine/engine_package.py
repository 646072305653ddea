"""What the packers of packages for engines share: their options, and a folder that appears complete or not at all. Standard
library only."""

from __future__ import annotations

import argparse
import importlib.util
import os
import pathlib
import struct
import sys
import tempfile
from typing import Callable, Dict, Iterable, List, Optional, Tuple

ROOT = pathlib.Path(__file__).resolve().parents[2]
Libraries = List[Tuple[str, pathlib.Path]]


def version() -> str:
    return (ROOT / "VERSION").read_text(encoding="utf-8").strip()


def notices(libraries: Iterable[pathlib.Path]) -> Dict[str, str]:
    """What of others is in the libraries: THIRD-PARTY.txt and facebaker.spdx.json."""
    place = importlib.util.spec_from_file_location("notices", ROOT / "packager" / "packages" / "notices.py")
    assert place and place.loader
    module = importlib.util.module_from_spec(place)
    place.loader.exec_module(module)
    texts: Dict[str, str] = module.notices(version(), list(libraries))
    return texts


def write_notices(folder: pathlib.Path, libraries: Libraries) -> None:
    """Raises OSError."""
    for name, text in notices([file for _, file in libraries]).items():
        (folder / name).write_text(text, encoding="utf-8")


def soname(file: pathlib.Path) -> Optional[str]:
    """The name under which a 64-bit ELF library is looked for by what was linked with it; None if it has none, or is no
    such library."""
    data = file.read_bytes()
    if data[:6] != b"\x7fELF\x02\x01":
        return None
    offset, = struct.unpack_from("<Q", data, 32)
    size, count = struct.unpack_from("<HH", data, 54)
    headers = [struct.unpack_from("<IIQQQQ", data, offset + size * i) for i in range(count)]
    tags = {}
    for kind, _, start, _, _, length in headers:
        if kind == 2:  # PT_DYNAMIC
            tags = dict(reversed([struct.unpack_from("<QQ", data, at) for at in range(start, start + length, 16)]))
    if 14 not in tags:  # DT_SONAME
        return None
    table = tags[5]  # DT_STRTAB, an address
    for kind, _, start, address, _, length in headers:
        if kind == 1 and address <= table < address + length:  # PT_LOAD
            begin = start + table - address + tags[14]
            return data[begin:data.index(b"\0", begin)].decode()
    return None


def read_libraries(texts: Iterable[str], platforms: Iterable[str]) -> Libraries:
    """The platforms and files of --library. Raises ValueError on what is no PLATFORM=FILE, and on a library that programs
    would look for under another name than its own."""
    libraries = []
    for text in texts:
        platform, equals, file = text.partition("=")
        if not equals or platform not in platforms:
            raise ValueError(f"--library takes PLATFORM=FILE, with one of {', '.join(platforms)}, and not \"{text}\"")
        if not pathlib.Path(file).is_file():
            raise ValueError(f"there is no library {file}")
        wanted = soname(pathlib.Path(file))
        if wanted not in (None, pathlib.Path(file).name):
            raise ValueError(f"{file}: programs look for it as {wanted} (its SONAME); a build has one to pack in lib/engines")
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
