"""A decoder of the Draco data of section `geometry`, written from core/archive/DRACO.md alone. For fbk_read.py.

Only Python's own library is used. Everything that the text refuses is refused, so that no input can be decoded in two
ways, and nothing is allocated that is not paid for by bytes of the data or by the counts that the caller expects.
"""
import struct
from typing import Dict, List, Optional, Sequence, Tuple, Union

from fbk_bytes import require, unzigzag

Triple = Tuple[int, int, int]
Position = Union[Triple, Tuple[float, float, float]]

HEADER = b"DRACO\x02\x02\x01\x01\x00\x00\x00"
INTEGERS = b"\x01\xff\x00\x00\x01\x00\x05\x03\x00\x00\x01\x01\x01\x01"
FLOATS = b"\x01\xff\x00\x00\x01\x00\x09\x03\x00\x00\x00"
MAX_SYMBOLS = 1 << 18
MAX_FACES = 1 << 29
MAX_COORDINATE = 16777215


class Bytes:
    """The bytes of the data, read from front to back."""

    def __init__(self, data: bytes) -> None:
        self.data, self.at = data, 0

    def take(self, count: int) -> bytes:
        require(0 <= count <= len(self.data) - self.at, "geometry: the Draco data is too short")
        self.at += count
        return self.data[self.at - count : self.at]

    def u8(self) -> int:
        return self.take(1)[0]

    def i32(self) -> int:
        return int(struct.unpack("<i", self.take(4))[0])

    def varint(self) -> int:
        value = 0
        for place in range(5):
            byte = self.u8()
            value |= (byte & 127) << 7 * place
            if byte < 128:
                require(value < 1 << 32, "geometry: a number of the Draco data is too large")
                return value
        require(False, "geometry: a number of the Draco data is too long")
        return 0

    def rest(self) -> bytes:
        return self.data[self.at :]


class Bits:
    """Bits of bytes, the lowest of each byte first."""

    def __init__(self, data: bytes) -> None:
        self.data, self.at = data, 0

    def take(self, count: int) -> int:
        require(count <= 8 * len(self.data) - self.at, "geometry: the Draco data has too few bits")
        value = 0
        for place in range(count):
            value |= (self.data[self.at >> 3] >> (self.at & 7) & 1) << place
            self.at += 1
        return value

    def end(self) -> int:
        """The number of bytes used; the last one's other bits are 0."""
        used = (self.at + 7) // 8
        require(self.at % 8 == 0 or self.data[used - 1] >> self.at % 8 == 0, "geometry: bits that mean nothing")
        return used


# ---- Entropy coding


class Rans:
    """The state of a rANS decoder with so many bits of precision, over bytes read from back to front."""

    def __init__(self, data: bytes, base: int) -> None:
        require(len(data) > 0, "geometry: an empty rANS stream")
        size = (data[-1] >> 6) + 1
        require(size <= len(data), "geometry: a rANS stream is too short for its state")
        self.data, self.at, self.base = data, len(data) - size, base
        self.state = base + (int.from_bytes(data[self.at :], "little") & (1 << 8 * size - 2) - 1)
        require(self.state < 256 * base, "geometry: the state of a rANS stream is too large")

    def renormalise(self) -> None:
        while self.state < self.base:
            require(self.at > 0, "geometry: a rANS stream is too short")
            self.at -= 1
            self.state = self.state << 8 | self.data[self.at]

    def end(self) -> None:
        self.renormalise()
        require(self.at == 0 and self.state == self.base, "geometry: a rANS stream does not end as it should")


class RansBits(Rans):
    """Bits of which a share, in 256ths, is 0."""

    def __init__(self, c: Bytes) -> None:
        self.zeros = c.u8()
        super().__init__(c.take(c.varint()), 4096)

    def bit(self) -> bool:
        self.renormalise()
        high, low = self.state >> 8, self.state & 255
        ones = 256 - self.zeros
        if low < ones:
            self.state = high * ones + low
            return True
        self.state = high * self.zeros + low - ones
        return False


class RansSymbols(Rans):
    """Symbols, with a table of frequencies that sum to 2^precision."""

    def __init__(self, c: Bytes, precision: int, limit: int) -> None:
        count = c.varint()
        require(1 <= count <= limit, "geometry: the number of Draco's symbols")
        self.precision = precision
        self.slots: List[Triple] = []  # symbol, frequency, start
        symbol = 0
        while symbol < count:
            byte = c.u8()
            if byte & 3 == 3:
                symbol += (byte >> 2) + 1
                continue
            frequency = byte >> 2
            for place in range(byte & 3):
                frequency |= c.u8() << 8 * place + 6
            start = len(self.slots)
            require(start + frequency <= 1 << precision, "geometry: frequencies of Draco's symbols")
            self.slots += [(symbol, frequency, start)] * frequency
            symbol += 1
        require(symbol == count and len(self.slots) == 1 << precision, "geometry: frequencies of Draco's symbols")
        super().__init__(c.take(c.varint()), 4 << precision)

    def symbol(self) -> int:
        self.renormalise()
        low = self.state & (1 << self.precision) - 1
        symbol, frequency, start = self.slots[low]
        self.state = frequency * (self.state >> self.precision) + low - start
        return symbol


def read_numbers(c: Bytes, points: int) -> List[Triple]:
    """Three unsigned numbers for each point."""
    scheme = c.u8()
    require(scheme <= 1, "geometry: an unknown coding of Draco's numbers")
    if scheme == 0:
        tags = RansSymbols(c, 12, 33)
        bits = Bits(c.rest())
        numbers = []
        for _ in range(points):
            length = tags.symbol()
            numbers.append((bits.take(length), bits.take(length), bits.take(length)))
        tags.end()
        c.take(bits.end())
        return numbers
    length = c.u8()
    require(1 <= length <= 18, "geometry: the precision of Draco's symbols")
    symbols = RansSymbols(c, min(max(3 * length // 2, 12), 20), MAX_SYMBOLS)
    numbers = [(symbols.symbol(), symbols.symbol(), symbols.symbol()) for _ in range(points)]
    symbols.end()
    return numbers


# ---- Connectivity


def following(corner: int) -> int:
    return corner - 2 if corner % 3 == 2 else corner + 1


def preceding(corner: int) -> int:
    return corner + 2 if corner % 3 == 0 else corner - 1


class Surface:
    """Faces as corners, three a face. Corner k of face f is number 3 f + k. The edge of a face that does not touch a
    corner is named by that corner; `opposite` is the corner that names the same edge in the other face, None at the
    boundary. The edges of the boundary form loops, in which `after` and `before` go from one to the next."""

    def __init__(self) -> None:
        self.vertex: List[int] = []
        self.opposite: List[Optional[int]] = []
        self.after: List[int] = []
        self.before: List[int] = []
        self.merged: List[int] = []  # for each vertex, the one that it has become
        self.inside: List[bool] = []  # for each vertex, whether it has left the boundary

    def add_vertex(self) -> int:
        self.merged.append(len(self.merged))
        self.inside.append(False)
        return len(self.merged) - 1

    def add_face(self, *vertices: int) -> int:
        self.vertex += vertices
        self.opposite += [None] * 3
        self.after += [-1] * 3
        self.before += [-1] * 3
        return len(self.vertex) - 3

    def on_boundary(self, corner: int) -> bool:
        return self.opposite[corner] is None

    def glue(self, a: int, b: int) -> None:
        self.opposite[a], self.opposite[b] = b, a

    def link(self, *edges: int) -> None:
        for a, b in zip(edges, edges[1:]):
            self.after[a], self.before[b] = b, a

    def ends(self, edge: int) -> Tuple[int, int]:
        """The vertices of an edge, in the direction of its loop."""
        return self.vertex[following(edge)], self.vertex[preceding(edge)]

    def close_corner(self, a: int) -> int:
        b = self.before[a]
        require(self.on_boundary(a) and self.before[b] != a, "geometry: symbol C without two edges")
        first, last = self.before[b], self.after[a]
        start, tip = self.ends(b)
        face = self.add_face(tip, start, self.ends(a)[1])
        self.glue(a, face + 1)
        self.glue(b, face + 2)
        self.link(first, face, last)
        self.inside[tip] = True
        return face

    def add_triangle(self, a: int, right: bool) -> int:
        require(self.on_boundary(a), "geometry: symbol L or R without an edge")
        first, last = self.before[a], self.after[a]
        start, end = self.ends(a)
        tip = self.add_vertex()
        face = self.add_face(end, start, tip) if right else self.add_face(start, tip, end)
        self.glue(a, face + 2 if right else face + 1)
        edges = (face, face + 1) if right else (face + 2, face)
        self.link(first, *edges, last)
        return face

    def join(self, a: int, b: int) -> int:
        require(self.on_boundary(a) and self.on_boundary(b), "geometry: symbol S without two edges")
        require(a != b and self.after[a] != b and self.after[b] != a, "geometry: symbol S with one edge after the other")
        a_first, a_last, b_first, b_last = self.before[a], self.after[a], self.before[b], self.after[b]
        require(a_last != b_first, "geometry: symbol S leaves a single edge")
        kept, gone = self.ends(a)[1], self.ends(b)[0]
        face = self.add_face(kept, self.ends(a)[0], self.ends(b)[1])
        self.glue(a, face + 2)
        self.glue(b, face + 1)
        self.link(a_first, face, b_last)
        self.link(b_first, a_last)
        self.merged[gone] = kept
        return face

    def new_island(self) -> int:
        face = self.add_face(self.add_vertex(), self.add_vertex(), self.add_vertex())
        self.link(face, face + 1, face + 2, face)
        return face

    def close_hole(self, a: int) -> None:
        b = self.before[a]
        c = self.before[b]
        require(self.before[c] == a, "geometry: a last face in a hole of other than three edges")
        vertices = (self.ends(b)[0], self.ends(c)[0], self.ends(a)[0])
        face = self.add_face(*vertices)
        for i, edge in enumerate((a, b, c)):
            self.glue(edge, face + i)
            self.inside[vertices[i]] = True

    def end(self) -> None:
        """Puts merged vertices together."""
        for v in range(len(self.merged)):
            root = v
            while self.merged[root] != root:
                root = self.merged[root]
            while self.merged[v] != root:
                self.merged[v], v = root, self.merged[v]
        self.vertex = [self.merged[v] for v in self.vertex]
        for f in range(0, len(self.vertex), 3):
            require(len(set(self.vertex[f : f + 3])) == 3, "geometry: a face of less than three vertices")


def read_split_events(c: Bytes, symbols: int) -> List[Triple]:
    """Source symbol, split symbol and side of each event."""
    count, source = c.varint(), 0
    events = []
    for _ in range(count):
        source += c.varint()
        split = source - c.varint()
        require(source < symbols and split >= 0, "geometry: a split of symbols that there are not")
        events.append((source, split))
    bits = Bits(c.rest())
    sides = [bits.take(1) for _ in range(count)]
    c.take(bits.end())
    return [(source, split, side) for (source, split), side in zip(events, sides)]


def read_connectivity(c: Bytes, points: int, faces: int) -> Surface:
    require(c.varint() == points and c.varint() == faces and c.u8() == 0, "geometry: counts of the Draco data")
    symbols, splits = c.varint(), c.varint()
    require(symbols <= faces, "geometry: symbols of the Draco data")
    events = read_split_events(c, symbols)
    bits = Bits(c.take(c.varint()))
    start_faces = RansBits(c)
    surface = Surface()
    active: List[int] = []
    waiting: Dict[int, int] = {}  # edges for symbols S to come
    joined = 0
    for number in range(symbols - 1, -1, -1):
        kind = "SLRE"[bits.take(2)] if bits.take(1) else "C"
        require(kind == "E" or len(active) > 0, "geometry: a symbol without an edge")
        if kind == "C":
            active[-1] = surface.close_corner(active[-1])
        elif kind == "S":
            b = active.pop()
            if number in waiting:
                active.append(waiting.pop(number))
            require(len(active) > 0, "geometry: symbol S without two edges")
            active[-1] = surface.join(active[-1], b)
            joined += 1
        elif kind == "E":
            active.append(surface.new_island())
        else:
            active[-1] = surface.add_triangle(active[-1], kind == "R")
        while kind in "LRE" and events and events[-1][0] == number:
            _, split, side = events.pop()
            edge = following(active[-1]) if side else preceding(active[-1])
            require(split < number and split not in waiting, "geometry: a split that is no split")
            waiting[split] = edge
    require(not events and not waiting and joined == splits, "geometry: splits that never come")
    require(bits.end() == len(bits.data), "geometry: too many symbols")
    while active:
        edge = active.pop()
        require(surface.on_boundary(edge), "geometry: a last edge that is gone")
        if start_faces.bit():
            surface.close_hole(edge)
    start_faces.end()
    require(len(surface.vertex) == 3 * faces, "geometry: the number of faces")
    surface.end()
    return surface


# ---- Positions


def order_corners(surface: Surface, points: int) -> List[int]:
    """A corner of each vertex, in the order in which the positions are coded."""
    seen_face = [False] * (len(surface.vertex) // 3)
    place: List[int] = [-1] * len(surface.merged)
    order: List[int] = []

    def visit(corner: int) -> bool:
        """Whether the corner's vertex is new."""
        vertex = surface.vertex[corner]
        if place[vertex] >= 0:
            return False
        place[vertex] = len(order)
        order.append(corner)
        return True

    def is_new(corner: Optional[int]) -> bool:
        return corner is not None and not seen_face[corner // 3]

    for first in range(0, len(surface.vertex), 3):
        if seen_face[first // 3]:
            continue
        visit(first + 1)
        visit(first + 2)
        stack: List[Optional[int]] = [first]
        while stack:
            corner = stack.pop()
            while corner is not None and is_new(corner):
                seen_face[corner // 3] = True
                right, left = surface.opposite[following(corner)], surface.opposite[preceding(corner)]
                if visit(corner) and surface.inside[surface.vertex[corner]]:
                    corner = right
                elif is_new(right) and is_new(left):
                    stack += [left, right]
                    break
                else:
                    corner = right if is_new(right) else left
    require(len(order) == points, "geometry: the number of points")
    surface.vertex = [place[v] for v in surface.vertex]
    return order


def read_positions(c: Bytes, surface: Surface, order: Sequence[int]) -> List[Triple]:
    numbers = read_numbers(c, len(order))
    least, most = c.i32(), c.i32()
    require(-MAX_COORDINATE <= least <= most <= MAX_COORDINATE, "geometry: the range of positions")
    size = most - least + 1
    positions: List[Triple] = []
    for number, (corner, residuals) in enumerate(zip(order, numbers)):
        predicted: Sequence[int] = positions[-1] if positions else (0, 0, 0)
        across = surface.opposite[corner]
        if across is not None:
            corners = surface.vertex[following(across)], surface.vertex[preceding(across)], surface.vertex[across]
            if max(corners) < number:
                a, b, d = (positions[v] for v in corners)
                predicted = [a[axis] + b[axis] - d[axis] for axis in range(3)]
        values = []
        for prediction, residual in zip(predicted, residuals):
            value = min(max(prediction, least), most) + unzigzag(residual)
            value += -size if value > most else size if value < least else 0
            require(least <= value <= most, "geometry: a position is out of range")
            values.append(value)
        positions.append((values[0], values[1], values[2]))
    return positions


def decode(data: bytes, points: int, faces: int, integers: bool) -> Tuple[List[Position], List[Triple]]:
    """The positions, and the faces as triples of their numbers. `data` must have so many of each, and nothing after."""
    require(faces <= MAX_FACES and points <= 3 * faces, "geometry: the number of triangles")
    c = Bytes(data)
    require(c.take(len(HEADER)) == HEADER, "geometry: the Draco data is of another kind")
    surface = read_connectivity(c, points, faces)
    order = order_corners(surface, points)
    kind = INTEGERS if integers else FLOATS
    require(c.take(len(kind)) == kind, "geometry: the attribute of the Draco data is of another kind")
    positions: List[Position] = []
    if integers:
        positions += read_positions(c, surface, order)
    else:
        positions += [(x, y, z) for x, y, z in struct.iter_unpack("<fff", c.take(12 * points))]
    require(c.at == len(data), "geometry: the Draco data should end earlier")
    triangles = [(v[0], v[1], v[2]) for v in (surface.vertex[f : f + 3] for f in range(0, 3 * faces, 3))]
    return positions, triangles
