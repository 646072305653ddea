#!/usr/bin/env python3
"""test_draco.py PROGRAM FOLDER [COUNT]: the readers of Draco data agree on damaged data.

The Draco data of every archive in FOLDER is damaged COUNT times (100 without it). PROGRAM, which is read_draco.cpp, and
fbk_draco.py must refuse the same, and decode the rest to the same positions and triangles.
"""
import pathlib
import random
import struct
import subprocess
import sys
from typing import Tuple

import fbk_draco
import fbk_read
from fbk_bytes import Corrupt, require

Case = Tuple[int, int, int, bytes]  # points, triangles, whether integers, data


def stored(path: pathlib.Path) -> Case:
    sections = fbk_read.read_sections(path.read_bytes())
    c = fbk_read.decompress(sections, "geometry")
    points, triangles, step = c.u32(), c.u32(), c.f32()
    c.take(4 * points)
    return points, triangles, int(step > 0), c.rest()


def damaged(case: Case, chance: random.Random) -> Case:
    points, triangles, integers, whole = case
    data = bytearray(whole)
    kind = chance.randrange(8)
    at = chance.randrange(12 if chance.random() < 0.95 else 0, len(data))
    if kind < 3:
        data[at] ^= 1 << chance.randrange(8)
    elif kind == 3:
        data[at] = chance.choice((0, 1, 127, 128, 255, chance.randrange(256)))
    elif kind == 4:
        data[at : at + 1] = bytes(chance.randrange(256) for _ in range(chance.randrange(3)))
    elif kind == 5:
        for _ in range(chance.randrange(2, 5)):
            data[chance.randrange(12, len(data))] = chance.randrange(256)
    elif kind == 6:
        # Other counts, which the data agrees with as long as they take a byte.
        where = chance.choice((12, 13))
        data[where] = max(data[where] + chance.choice((-1, 1)), 0)
        points, triangles = (data[12], triangles) if where == 12 else (points, data[13])
    else:
        length = chance.randrange(1, 9)
        source = chance.randrange(12, len(data))
        data[at : at + length] = data[source : source + length]
    return points, triangles, integers, bytes(data)


def decoded(case: Case) -> bytes:
    points, triangles, integers, data = case
    try:
        positions, faces = fbk_draco.decode(data, points, triangles, bool(integers))
    except Corrupt:
        return b"\0"
    kind = "<3i" if integers else "<3f"
    return b"\1" + b"".join([struct.pack(kind, *p) for p in positions] + [struct.pack("<3I", *f) for f in faces])


def main(program: str, folder: str, count: str = "100") -> int:
    chance = random.Random(21)
    cases, accepted, coded = [], 0, [0, 0]
    for path in sorted(pathlib.Path(folder).glob("*.fbk")):
        whole = stored(path)
        coded[whole[3][whole[3].find(fbk_draco.INTEGERS) + len(fbk_draco.INTEGERS)] if whole[2] else 0] += whole[2]
        cases += [whole] + [damaged(whole, chance) for _ in range(int(count))]
    data = b"".join(struct.pack("<4I", *case[:3], len(case[3])) + case[3] for case in cases)
    found = subprocess.run([program], input=data, stdout=subprocess.PIPE, check=True).stdout
    at = 0
    for number, case in enumerate(cases):
        expected = decoded(case)
        if number % (int(count) + 1) == 0:
            require(expected[0] == 1, f"undamaged data is refused: case {number}")
        accepted += expected[0]
        # Positions that are no numbers may lose bits in Python; the archive's reader refuses them anyway.
        size = 1 + 12 * (case[0] + case[1]) if expected[0] else 1
        same = found[at : at + size] == expected or (not case[2] and found[at] == 1 and has_nan(expected[1:], case[0]))
        require(found[at] == expected[0] and same, f"the readers differ: case {number}: {case}")
        at += size
    require(at == len(found) and min(coded) > 0, "too many answers, or a coding of numbers that no archive has")
    print(f"{len(cases)} data, {accepted} accepted, by both readers alike")
    return 0


def has_nan(data: bytes, points: int) -> bool:
    return any(x != x for x in struct.unpack_from(f"<{3 * points}f", data))


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
