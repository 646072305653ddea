"""The conventions of FORMAT.md: numbers, checksums and coded symbols. For fbk_read.py."""
import struct
from typing import Any

import numpy as np


class Corrupt(Exception):
    pass


def require(condition: object, message: str) -> None:
    if not condition:
        raise Corrupt(message)


def xxh64(data: bytes) -> int:
    p = (11400714785074694791, 14029467366897019727, 1609587929392839161, 9650029242287828579, 2870177450012600261)
    mask = (1 << 64) - 1

    def rotate(x, bits):
        return ((x << bits) | (x >> (64 - bits))) & mask

    def mixed(state, word):
        return rotate((state + word * p[1]) & mask, 31) * p[0] & mask

    at, size = 0, len(data)
    if size >= 32:
        a, b, c, d = (p[0] + p[1]) & mask, p[1], 0, -p[0] & mask
        whole = size // 32 * 32
        for i, j, k, l in struct.iter_unpack("<QQQQ", data[:whole]):
            a, b, c, d = mixed(a, i), mixed(b, j), mixed(c, k), mixed(d, l)
        at = whole
        h = (rotate(a, 1) + rotate(b, 7) + rotate(c, 12) + rotate(d, 18)) & mask
        for state in (a, b, c, d):
            h = ((h ^ mixed(0, state)) * p[0] + p[3]) & mask
    else:
        h = p[4]
    h = (h + size) & mask
    for at in range(at, size - 7, 8):
        h = (rotate(h ^ mixed(0, struct.unpack_from("<Q", data, at)[0]), 27) * p[0] + p[3]) & mask
    at = size // 8 * 8
    if size - at >= 4:
        h = (rotate(h ^ (struct.unpack_from("<I", data, at)[0] * p[0] & mask), 23) * p[1] + p[2]) & mask
        at += 4
    for byte in data[at:]:
        h = rotate(h ^ (byte * p[4] & mask), 11) * p[0] & mask
    h = (h ^ h >> 33) * p[1] & mask
    h = (h ^ h >> 29) * p[2] & mask
    return h ^ h >> 32


def unzigzag(z: Any) -> Any:
    return z >> 1 ^ -(z & 1)


class Contents:
    """The decompressed bytes of one section, read from front to back."""

    def __init__(self, name: str, data: bytes) -> None:
        self.name, self.data, self.at = name, data, 0

    def take(self, count: int) -> bytes:
        require(0 <= count <= len(self.data) - self.at, f"{self.name}: too short")
        self.at += count
        return self.data[self.at - count : self.at]

    def number(self, kind: str) -> Any:
        return struct.unpack("<" + kind, self.take(struct.calcsize("<" + kind)))[0]

    def u32(self) -> int:
        return int(self.number("I"))

    def array(self, kind, count):
        kind = np.dtype(kind).newbyteorder("<")
        return np.frombuffer(self.take(count * kind.itemsize), kind).astype(kind.newbyteorder("="))

    def planes(self, count, kind=np.uint32):
        planes = np.frombuffer(self.take(4 * count), np.uint8).reshape(4, count).astype(np.uint32)
        return (planes[0] | planes[1] << 8 | planes[2] << 16 | planes[3] << 24).view(kind)

    def deltas(self, count):
        return np.cumsum(unzigzag(self.planes(count).astype(np.int64))) & 0xFFFFFFFF

    def string(self):
        length = self.u32()
        require(length <= 65535, f"{self.name}: a string is too long")
        text = self.take(length)
        require(b"\0" not in text, f"{self.name}: a string holds a zero byte")
        return text.decode("utf-8", "replace")

    def end(self):
        require(self.at == len(self.data), f"{self.name}: should end earlier")


# ---- Coded symbols


class RansDecoder:
    """Decodes the symbols and raw bits of a section; `contents` is at the number of tables."""

    def __init__(self, contents, fewest, most, parts):
        self.contents, self.tables = contents, []
        tables = contents.number("B")
        require(fewest <= tables <= most, f"{contents.name}: number of tables")
        for _ in range(tables):
            count = contents.number("H")
            frequencies, first = [1024], 0
            if count > 0:
                first = contents.number("B")
                require(first + count <= 256, f"{contents.name}: a symbol is too large")
                frequencies = [self.frequency() for _ in range(count)]
                require(sum(frequencies) == 1024, f"{contents.name}: frequencies do not sum to 1024")
            slots, start = [], 0
            for symbol, frequency in enumerate(frequencies, first):
                slots += [(symbol, frequency, start)] * frequency
                start += frequency
            self.tables.append(slots)
        counts, self.states = [], []  # of the streams of all parts
        for _ in range(parts):
            counts += [contents.u32() for _ in range(4)]
            self.states += [contents.u32() for _ in range(4)]
        require(min(self.states) >= 65536, f"{contents.name}: a state is too small")
        self.words = [iter(contents.array("u2", count).tolist()) for count in counts]
        contents.end()

    def frequency(self):
        low = self.contents.number("B")
        return low if low < 128 else low - 128 + 128 * self.contents.number("B")

    def renormalise(self, stream, x):
        if x < 65536:
            word = next(self.words[stream], None)
            require(word is not None, f"{self.contents.name}: too few words")
            x = 65536 * x + word
        self.states[stream] = x

    def symbol(self, table, part, stream):
        stream += 4 * part
        x = self.states[stream]
        slot = x & 1023
        symbol, frequency, start = self.tables[table][slot]
        self.renormalise(stream, frequency * (x >> 10) + slot - start)
        return symbol

    def bits(self, count, part, stream):
        stream += 4 * part
        x = self.states[stream]
        self.renormalise(stream, x >> count)
        return x & (1 << count) - 1

    def end(self):
        require(all(next(words, None) is None for words in self.words), f"{self.contents.name}: too many words")
        require(set(self.states) == {65536}, f"{self.contents.name}: a stream does not end in state 65536")
