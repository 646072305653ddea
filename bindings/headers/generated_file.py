"""What generators have in common: writing a file."""

from __future__ import annotations

import os
import pathlib
import sys
from typing import Callable, List

from read_headers import HeaderError


def generate(program: str, out: pathlib.Path, make_lines: Callable[[], List[str]]) -> int:
    """Writes a file, complete or not at all, and gives the program's exit code: 1 after a message on standard error if
    the headers cannot be read or the file cannot be written."""
    beside = out.with_name(out.name + ".part")
    try:
        beside.write_text("\n".join(make_lines()) + "\n", encoding="utf-8")
        os.replace(beside, out)
    except (HeaderError, OSError) as error:
        print(f"{program}: {error}", file=sys.stderr)
        return 1
    return 0
