#!/usr/bin/env python3
"""test_mutations.py PROGRAM FOLDER [COUNT [SEED]]: both readers accept the same of damaged archives, and refuse the same.

COUNT times (100 without it), the decompressed contents of a section of an archive in FOLDER of at most 8 KB are
damaged and all checksums made right. PROGRAM, which is read_archives.cpp, and fbk_read.py must agree on the result.
"""
import pathlib
import random
import struct
import subprocess
import sys
from typing import Dict, Tuple

import numpy as np

import fbk_read
from fbk_bytes import Corrupt, xxh64

MOST_BYTES = 8192
Sections = Dict[str, Tuple[int, bytes]]  # flags and contents


def open_archive(path: pathlib.Path) -> Sections:
    sections = fbk_read.read_sections(path.read_bytes())
    known = {name: s for name, s in sections.items() if s[1] <= 1}
    return {name: (s[0], fbk_read.decompress(known, name).data) for name, s in known.items()}


def assembled(sections: Sections) -> bytes:
    """An archive of these sections, uncompressed."""
    offset = 24 + 72 * len(sections) + 8
    rows, contents = b"", b""
    for name, (flags, data) in sections.items():
        rows += struct.pack("<32sIIQQQQ", name.encode(), flags, 0, offset + len(contents), len(data), len(data), xxh64(data))
        contents += data
    header = b"\x89FBK\r\n\x1a\n" + struct.pack("<HHIQ", 2, 0, len(sections), offset + len(contents) + 8)
    beginning = header + rows
    whole = beginning + struct.pack("<Q", xxh64(beginning)) + contents
    return whole + struct.pack("<Q", xxh64(whole))


def damaged(data: bytes, chance: random.Random) -> bytes:
    changed = bytearray(data)
    at = chance.randrange(len(data) + 1)
    kind = chance.randrange(7)
    if kind == 0 or not data:
        changed[at:at] = bytes(chance.choice((0, 1, 255, chance.randrange(256))) for _ in range(chance.randrange(1, 5)))
    elif kind == 1:
        del changed[at : at + chance.choice((1, 2, 4))]
    elif kind == 2:
        at = chance.randrange(len(data))
        changed[at] ^= 1 << chance.randrange(8)
    elif kind == 3:
        at = chance.randrange(len(data))
        changed[at] = chance.choice((0, 1, 2, 3, 127, 128, 254, 255))
    elif kind == 4 and len(data) >= 4:
        at = chance.randrange(len(data) - 3)
        number = chance.choice((0, 1, 0xFFFFFFFF, 0x7FFFFFFF, 0x80000000, 0x7F800000, 0x7FC00000, 0x3F800000))
        changed[at : at + 4] = struct.pack("<I", number)
    elif kind == 5 and len(data) >= 4:
        at = chance.randrange(len(data) - 3)
        number = struct.unpack_from("<I", data, at)[0] + chance.choice((-1, 1))
        changed[at : at + 4] = struct.pack("<I", number % 2**32)
    else:
        length = chance.randrange(1, 9)
        source = chance.randrange(len(data))
        changed[at : at + length] = data[source : source + length]
    return bytes(changed)


def mutated(sections: Sections, chance: random.Random) -> bytes:
    result = dict(sections)
    if chance.random() < 0.02:
        del result[chance.choice(sorted(result))]
    name = chance.choice(sorted(result))
    flags, data = result[name]
    result[name] = (flags, damaged(data, chance))
    return assembled(result)


def verdict(data: bytes) -> str:
    try:
        with np.errstate(all="ignore"):
            fbk_read.Face(data)
    except (Corrupt, ValueError) as error:
        return str(error)
    return "accepted"


def main(program: str, folder: str, count: str = "100", seed: str = "1") -> int:
    chance = random.Random(int(seed))
    paths = [path for path in sorted(pathlib.Path(folder).glob("*.fbk")) if path.stat().st_size <= MOST_BYTES]
    archives = [open_archive(path) for path in paths]
    accepted = differences = 0
    for first in range(0, int(count), 1000):
        cases = [mutated(chance.choice(archives), chance) for _ in range(min(1000, int(count) - first))]
        given = b"".join(struct.pack("<I", len(case)) + case for case in cases)
        answers = subprocess.run([program], input=given, stdout=subprocess.PIPE, check=True).stdout.decode(errors="replace")
        for number, (case, answer) in enumerate(zip(cases, answers.splitlines()), first):
            here = verdict(case)
            accepted += here == "accepted"
            if (here == "accepted") != (answer == "accepted"):
                differences += 1
                pathlib.Path(f"difference-{number}.fbk").write_bytes(case)
                print(f"difference-{number}.fbk: the library says: {answer}; fbk_read.py says: {here}")
    print(f"{count} archives, {accepted} accepted; the readers differ on {differences}")
    return 1 if differences else 0


if __name__ == "__main__":
    if not 3 <= len(sys.argv) <= 5:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
