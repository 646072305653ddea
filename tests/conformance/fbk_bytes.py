"""FORMAT.md, "Conventions" and "Coded symbols". For fbk_read.py."""
import functools
import operator
import struct

import numpy as np

F = np.float32


class Corrupt(Exception):
    """What the text calls corrupt or unsupported."""


def require(condition: object, message: str) -> None:
    if not condition:
        raise Corrupt(message)


def added(numbers, start=F(0)):
    """The sum from left to right, each addition rounded."""
    return functools.reduce(operator.add, numbers, start)


def zigzag(d):
    d %= 2**32
    return 2 * d if d < 2**31 else 2 * (2**32 - d) - 1


def unzigzag(z):
    return z >> 1 ^ -(z & 1)


def xxh64(data: bytes) -> int:
    """Numbers are taken modulo 2^64 where it makes a difference."""
    p1, p2, p3, p4, p5 = (11400714785074694791, 14029467366897019727, 1609587929392839161, 9650029242287828579,
                          2870177450012600261)

    def rotated(x, bits):
        x %= 2**64
        return x << bits | x >> 64 - bits

    def mixed(state, word):
        return rotated(state + word * p2, 31) * p1

    h, end_of_stripes, end_of_words = p5, len(data) // 32 * 32, len(data) // 8 * 8
    if end_of_stripes > 0:
        states = [p1 + p2, p2, 0, -p1]
        for stripe in struct.iter_unpack("<4Q", data[:end_of_stripes]):
            states = [mixed(state, word) for state, word in zip(states, stripe)]
        h = sum(rotated(state, bits) for state, bits in zip(states, (1, 7, 12, 18)))
        for state in states:
            h = (h ^ mixed(0, state)) * p1 + p4
    h += len(data)
    for (word,) in struct.iter_unpack("<Q", data[end_of_stripes:end_of_words]):
        h = rotated(h ^ mixed(0, word), 27) * p1 + p4
    tail = data[end_of_words:]
    if len(tail) >= 4:
        h = rotated(h ^ int.from_bytes(tail[:4], "little") * p1, 23) * p2 + p3
        tail = tail[4:]
    for byte in tail:
        h = rotated(h ^ byte * p5, 11) * p1
    for bits, factor in ((33, p2), (29, p3), (32, 1)):
        h = (h % 2**64 ^ h % 2**64 >> bits) * factor
    return h


class Contents:
    """The decompressed bytes of one section, read from front to back."""

    def __init__(self, name, data):
        self.name, self.data, self.at, self.names = name, data, 0, set()

    def check(self, condition, what):
        require(condition, f"{self.name}: {what}")

    def take(self, count: int) -> bytes:
        self.check(0 <= count <= len(self.data) - self.at, "too short")
        self.at += count
        return self.data[self.at - count : self.at]

    def rest(self) -> bytes:
        return self.take(len(self.data) - self.at)

    def end(self):
        self.check(self.at == len(self.data), "should end earlier")

    def u8(self) -> int:
        return self.take(1)[0]

    def u32(self, least=0, most=2**32 - 1) -> int:
        number = int.from_bytes(self.take(4), "little")
        self.check(least <= number <= most, f"{number} where {least} to {most} may be")
        return number

    def u64(self):
        return int.from_bytes(self.take(8), "little")

    def f32(self):
        return self.floats(1)[0]

    def floats(self, count):
        """Numbers f32, which are finite everywhere but in a proof."""
        numbers = self.array("f4", count)
        self.check(np.isfinite(numbers).all(), "a number that is not finite")
        return numbers

    def array(self, kind, count):
        little = np.dtype("<" + kind)
        return np.frombuffer(self.take(count * little.itemsize), little).astype(kind)

    def planes(self, count, kind="u4"):
        rows = np.frombuffer(self.take(4 * count), "u1").reshape(4, count)
        numbers = rows.T.copy().view("<" + kind).ravel().astype(kind)
        self.check(np.isfinite(numbers).all(), "a number that is not finite")
        return numbers

    def deltas(self, count):
        return np.cumsum(unzigzag(self.planes(count).astype(np.int64))) % 2**32

    def bits(self, count):
        """The lowest of a byte first, then 0 to the end of the last byte."""
        bits = np.unpackbits(self.array("u1", (count + 7) // 8), bitorder="little")
        self.check(not bits[count:].any(), "a bit that means nothing")
        return bits[:count] == 1

    def string(self):
        text = self.take(self.u32(most=65535))
        self.check(b"\0" not in text, "a string holds a zero byte")
        return text.decode("utf-8", "replace")

    def new_name(self):
        """A string that is not empty, and that this has not read yet."""
        name = self.string()
        self.check(name and name not in self.names, f"name {name!r}")
        self.names.add(name)
        return name


class RansDecoder:
    """Decodes the symbols and raw bits of section c. The index of a symbol in its part tells its stream."""

    def __init__(self, c, fewest, most, parts):
        self.c, tables = c, c.u8()
        c.check(fewest <= tables <= most, "number of tables")
        self.tables = [self.read_table() for _ in range(tables)]
        heads = c.array("u4", 8 * parts).reshape(parts, 2, 4)  # word counts and states
        self.states = heads[:, 1].ravel().tolist()
        c.check(min(self.states) >= 65536, "a state is too small")
        self.words = [iter(c.array("u2", count).tolist()) for count in heads[:, 0].ravel().tolist()]

    def read_table(self):
        """For each of 1024 slots: symbol, frequency, start."""
        frequencies, first, slots = [1024], 0, []
        count = self.c.u8() + 256 * self.c.u8()
        if count > 0:
            first, frequencies = self.c.u8(), []
        for _ in range(count):
            low = self.c.u8()
            frequencies.append(low if low < 128 else low - 128 + 128 * self.c.u8())
        self.c.check(first + count <= 256 and sum(frequencies) == 1024, "a table of symbols")
        for symbol, frequency in enumerate(frequencies, first):
            slots += [(symbol, frequency, len(slots))] * frequency
        return slots

    def renormalise(self, stream, x):
        if x < 65536:
            word = next(self.words[stream], None)
            self.c.check(word is not None, "too few words")
            x = 65536 * x + word
        self.states[stream] = x

    def symbol(self, table, part, index):
        stream = 4 * part + index % 4
        x = self.states[stream]
        symbol, frequency, start = self.tables[table][x % 1024]
        self.renormalise(stream, frequency * (x >> 10) + x % 1024 - start)
        return symbol

    def bits(self, count, part, index):
        stream = 4 * part + index % 4
        x = self.states[stream]
        self.renormalise(stream, x >> count)
        return x % 2**count

    def end(self):
        self.c.check(all(next(words, None) is None for words in self.words), "too many words")
        self.c.check(set(self.states) == {65536}, "a stream does not end in state 65536")
