#!/usr/bin/env python3
"""An independent reader of .fbk archives, written from the documents in core/archive alone.

    fbk_read.py FILE...

reads every file, evaluates the poses of its proof and compares them with what was archived, bit for bit. Exit code 0
if all agree, 1 at the first difference or corrupt archive, 2 on wrong use. With --positions it prints the positions of the
proof's poses as hexadecimal bits instead of comparing them, for other programs to compare.

Needs Python 3.8 and NumPy. It is slow and meant to be read.
"""
import heapq
import struct
import sys
import zlib
from typing import Dict, Tuple

import numpy as np

import fbk_character
import fbk_draco
import fbk_errors
import fbk_evaluate
import fbk_exact
import fbk_levels
import fbk_sockets
from fbk_bytes import Contents, Corrupt, RansDecoder, require, unzigzag, xxh64

F = np.float32


NO_EDGE = 255  # the edge index of a polygon whose corners are coded as differences


# ---- File


def read_sections(data: bytes) -> Dict[str, Tuple[int, int, int, bytes]]:
    require(data[:8] == bytes.fromhex("8946424b0d0a1a0a"), "not an .fbk archive")
    require(len(data) >= 24, "truncated within the header")
    major, _, count, size = struct.unpack_from("<HHIQ", data, 8)
    require(major == 2, f"unsupported: major version {major}")
    require(count <= 64, "too many sections")
    table = 24 + 72 * count
    require(len(data) >= table + 16, "truncated within the section table")
    require(struct.unpack_from("<Q", data, table)[0] == xxh64(data[:table]), "header and section table are corrupt")
    require(len(data) == size, "truncated, or followed by other bytes")
    sections, end = {}, table + 8
    for row in range(count):
        name, flags, codec, offset, stored, raw, checksum = struct.unpack_from("<32sIIQQQQ", data, 24 + 72 * row)
        text = name.rstrip(b"\0")
        require(text and all(0x21 <= c <= 0x7E for c in text), "a section's name is not printable")
        text = text.decode()
        require(text not in sections, f"{text}: there already is a section of this name")
        require(flags in (0, 1), f"{text}: unsupported flags")
        require(offset == end and stored <= size - 8 - offset, f"{text}: does not follow the part before it")
        end = offset + stored
        sections[text] = (flags, codec, raw, data[offset:end])
        require(xxh64(data[offset:end]) == checksum, f"{text}: corrupt")
    require(end == size - 8, "the last section does not end at the file checksum")
    require(struct.unpack_from("<Q", data, end)[0] == xxh64(data[:end]), "the file is corrupt")
    return sections


def decompress(sections: Dict[str, Tuple[int, int, int, bytes]], name: str) -> Contents:
    require(name in sections, f"no section {name}")
    _, codec, raw, stored = sections[name]
    require(codec in (0, 1), f"{name}: unsupported codec {codec}")
    if codec == 1:
        stream = zlib.decompressobj()
        stored = stream.decompress(stored, raw + 1)
        require(stream.eof and not stream.unused_data, f"{name}: not exactly one zlib stream")
    require(len(stored) == raw, f"{name}: decompresses to another size")
    return Contents(name, stored)


REQUIRED = ("definition", "polygons", "geometry", "network", "weights", "basis", "basis-values")
OPTIONAL = ("provenance", "licence", "certificate", "proof", "uvs", "meshes", "materials", "images", "sockets", "labels",
            "about", "thumbnail", "channels", "expected-errors", "joints", "skin", "exact-poses", "levels")


# ---- Sections


def read_definition(c, face):
    face.name, face.units, face.up = c.string(), c.string(), c.string()
    require(face.up in ("y", "z"), "definition: up axis")
    face.vertices = c.u32()
    require(1 <= face.vertices <= 268435456, "definition: number of vertices")
    count = c.u32()
    require(count >= 1, "definition: no controls")
    face.controls = []
    for _ in range(count):
        name, group = c.string(), c.string()
        low, high, rest = c.array("f4", 3)
        require(np.isfinite([low, high, rest]).all() and low < high and low <= rest <= high, f"control {name}: range")
        face.controls.append((name, group, low, high, rest))
    names = [control[0] for control in face.controls]
    require(all(names) and len(set(names)) == len(names), "definition: control names")
    c.end()


def read_polygons(c, face):
    count, corners = c.u32(), c.u32()
    sizes = c.planes(count).tolist()
    require(all(size >= 3 for size in sizes) and sum(sizes) == corners, "polygons: sizes")
    edge_indices = c.take(count)
    others = [size for size, edge in zip(sizes, edge_indices) if edge == NO_EDGE]
    firsts = iter(c.deltas(count - len(others)).tolist())
    others = iter(read_corner_deltas(c, others, c.planes(sum(others)).tolist(), face.vertices))
    c.end()
    edges, previous = edges_from(face.triangles), None
    face.polygons = []
    for size, edge in zip(sizes, edge_indices):
        if edge == NO_EDGE:
            face.polygons.append(next(others))
        else:
            previous = polygon_along_triangles(face, edges, size, next(firsts), edge, previous)
            face.polygons.append(previous)


def read_corner_deltas(c, sizes, deltas, limit):
    polygons, corners, previous = [], [], 0
    for size in sizes:
        begin = len(corners)
        for k in range(size):
            prediction = corners[begin - previous + k] if k < previous else corners[-1] if corners else 0
            corners.append(prediction + unzigzag(deltas[len(corners)]) & 0xFFFFFFFF)
            require(corners[-1] < limit, f"{c.name}: a corner is not below {limit}")
        polygons.append(corners[begin:])
        previous = size
    return polygons


def edges_from(triangles):
    """For each vertex, the edges from it: the vertex each leads to, and the vertex opposite."""
    edges = {}
    for triangle in triangles:
        for k in range(3):
            v, to, opposite = (triangle[(k + i) % 3] for i in range(3))
            edges.setdefault(v, []).append((to, opposite))
    return edges


def polygon_along_triangles(face, edges, size, v, edge_index, previous):
    require(v < face.vertices, "polygons: no such vertex")
    require(size <= 66, "polygons: too many corners along triangles")
    prediction = v + previous[1] - previous[0] if previous else v
    from_v = edges.get(v, [])
    opposite = dict(from_v)
    require(len(from_v) <= 64 and len(opposite) == len(from_v), "polygons: not coded along these triangles")

    def zigzag_distance(w):
        d = (w - prediction) % 2**32
        return 2 * d if d < 2**31 else 2 * (2**32 - d) - 1

    require(edge_index < len(from_v), "polygons: no such edge")
    polygon = [v, sorted(opposite, key=zigzag_distance)[edge_index]]
    while len(polygon) < size:
        require(polygon[-1] in opposite, "polygons: no fan of triangles")
        polygon.append(opposite[polygon[-1]])
    return polygon


def read_geometry(c, face):
    points, triangles, grid_step = c.u32(), c.u32(), c.array("f4", 1)[0]
    power_of_two = grid_step > 0 and np.isfinite(grid_step) and np.frexp(grid_step)[0] == 0.5
    require(grid_step == 0 or power_of_two, "geometry: the grid step")
    vertices = c.deltas(points).tolist()
    require(set(vertices) == set(range(face.vertices)), "geometry: vertices of points")
    positions, faces = fbk_draco.decode(c.take(len(c.data) - c.at), points, triangles, bool(grid_step > 0))
    found = np.array(positions, np.int32 if grid_step > 0 else F).astype(F) * (grid_step if grid_step > 0 else F(1))
    require(np.isfinite(found).all(), "geometry: points")
    rest = np.empty((face.vertices, 3), F)
    rest[vertices] = found
    require(rest[vertices].tobytes() == found.tobytes(), "geometry: points of one vertex have different positions")
    require((rest.max(0) > rest.min(0)).any(), "geometry: the bounding box is a point")
    face.triangles = [[vertices[p] for p in f] for f in faces]
    face.rest = rest.ravel()


def read_uvs(c, face):
    pairs, coding = c.u32(), c.u32()
    require(pairs > 0, "uvs: no texture coordinates")
    require(coding in (0, 1), f"uvs: unsupported coding {coding}")
    face.uvs = np.stack([c.planes(pairs, "f4"), c.planes(pairs, "f4")], axis=1)
    require(np.isfinite(face.uvs).all(), "uvs: not finite")
    if coding == 0:
        sizes = [len(polygon) for polygon in face.polygons]
        face.uv_polygons = read_corner_deltas(c, sizes, c.planes(sum(sizes)).tolist(), pairs)
    else:
        require(pairs == face.vertices, "uvs: not one per vertex")
        face.uv_polygons = face.polygons
    c.end()


def read_network(c, face):
    def indices(below):
        numbers = c.array("u4", c.u32()).tolist()
        require(all(n < below for n in numbers), "network: an index is too large")
        return numbers

    face.features = []
    for f in range(c.u32()):
        kind = c.number("B")
        require(kind <= 4, f"network: unsupported feature kind {kind}")
        if kind >= 3:
            first, second = c.u32(), c.u32()
            require(max(first, second) < f, "network: a feature uses later ones")
            face.features.append((kind, first, second))
            continue
        control = c.u32()
        scale, threshold, fall = c.array("f4", 1)[0], F(0), F(0)
        if kind >= 1:
            threshold = c.array("f4", 1)[0]
        if kind == 2:
            fall = c.array("f4", 1)[0]
        require(control < len(face.controls), "network: no such control")
        require(np.isfinite([scale, threshold, fall]).all() and threshold >= 0 and fall >= 0, "network: a feature")
        face.features.append((kind, control, scale, threshold, fall))
    count = len(face.features)
    face.direct = indices(count)
    face.regions = []
    for _ in range(c.u32()):
        region = {"name": c.string(), "features": indices(count), "gate": indices(count)}
        region["slope"] = c.array("f4", 1)[0]
        require(np.isfinite(region["slope"]) and region["slope"] > 0, "network: a gate's slope")
        gate = [face.features[f] for f in region["gate"]]
        require(all(f[0] == 0 for f in gate), "network: a gate feature is no identity")
        require(all(a[1] < b[1] for a, b in zip(gate, gate[1:])), "network: gate features are not ascending by control")
        region["layers"], width = [], len(region["features"])
        for _ in range(c.u32()):
            inputs, outputs, activation, flags = c.u32(), c.u32(), c.number("B"), c.number("B")
            require(activation <= 3 and flags <= 3, "network: unsupported layer")
            require(inputs == width <= 16777215 and outputs >= 1, "network: widths")
            require(not flags & 1 or inputs == outputs, "network: skip")
            bias, scales = c.planes(outputs, F), c.planes(outputs, F)
            require(np.isfinite(bias).all() and np.isfinite(scales).all(), "network: not finite")
            region["layers"].append(
                {"shape": (outputs, inputs), "activation": activation, "skip": flags & 1, "is_16_bit": flags >> 1,
                 "bias": bias, "scales": scales})
            width = outputs
        require(region["layers"], "network: a region without layers")
        face.regions.append(region)
    face.coefficients = len(face.direct) + sum(r["layers"][-1]["shape"][0] for r in face.regions)
    c.end()


def read_weights(c, face):
    rans = RansDecoder(c, 9, 9, parts=1)
    for region in face.regions:
        last = len(region["layers"]) - 1
        for number, layer in enumerate(region["layers"]):
            t = 2 if number == last else 0 if number == 0 else 1
            weights = []
            for i in range(layer["shape"][0] * layer["shape"][1]):
                if layer["is_16_bit"]:
                    high = rans.symbol(t + 3, 0, i % 4) - 127
                    weights.append(256 * high + rans.symbol(t + 6, 0, i % 4) - 128)
                else:
                    weights.append(rans.symbol(t, 0, i % 4) - 127)
            largest = 32512 if layer["is_16_bit"] else 127
            require(all(-largest <= w <= largest for w in weights), "weights: out of range")
            layer["weights"] = np.array(weights, np.int64).reshape(layer["shape"])
    rans.end()


def read_basis(c, face):
    columns, ordered = c.u32(), c.u32()
    require(columns == face.coefficients, "basis: columns")
    require(ordered <= 1, "basis: order flag")
    face.order = list(range(face.points))
    if ordered:
        face.order = c.deltas(face.points).tolist()
        require(sorted(face.order) == list(range(face.points)), "basis: the order does not list every vertex once")
        behind = face.order[face.vertices :]
        require(behind == list(range(face.vertices, face.points)), "basis: the order lists vertices behind channels")
    rows = c.planes(c.u32()).tolist()
    require(all(rows) and sum(rows) == 3 * face.points, "basis: rows")
    face.row_blocks, first = [], 0
    for count in rows:
        face.row_blocks.append({"first": first, "rows": count, "segments": []})
        first += count
    read_segments(c, face, columns)
    for block in face.row_blocks:
        require(sum(2 if s["is_16_bit"] else 1 for s in block["segments"]) <= 16777215, "basis: too many summands")


def read_segments(c, face, columns):
    counts = c.planes(columns).tolist()
    deltas = c.planes(sum(counts)).tolist()
    flags = c.take(sum(counts))
    scales = iter(c.planes(c.u32(), F))
    c.end()
    face.segments, at, scale = [], 0, None
    for column in range(columns):
        block = 0
        for i in range(counts[column]):
            require(i == 0 or deltas[at] > 0, "basis: a column lies twice in a row block")
            block += deltas[at]
            require(block < len(face.row_blocks), "basis: a segment")
            if flags[at] & 2:
                scale = next(scales, None)
            require(scale is not None, "basis: a segment has no scale")
            is_16_bit = bool(flags[at] & 1)
            with np.errstate(over="ignore"):
                require(np.isfinite(scale * F(256) if is_16_bit else scale), "basis: a scale that is not finite")
            segment = {"column": column, "is_16_bit": is_16_bit, "scale": scale, "block": block, "table": flags[at] >> 2}
            face.row_blocks[block]["segments"].append(segment)
            face.segments.append(segment)
            at += 1
    require(next(scales, None) is None, "basis: too many scales")


def find_neighbours(face):
    neighbours = [[] for _ in range(face.points)]
    for polygon in face.polygons:
        for v, w in zip(polygon, polygon[1:] + polygon[:1]):
            if v != w and w not in neighbours[v] and len(neighbours[v]) < 16 and len(neighbours[w]) < 16:
                neighbours[v].append(w)
                neighbours[w].append(v)
    return neighbours


def candidates_of(v, coded, neighbours, time):
    """The candidate predictors of a vertex as triples (left, right, across) of vertices or None."""
    def last(vertices):
        return max(vertices, key=lambda w: time[w], default=None)

    candidates = []
    for i, j in ((i, j) for i in range(len(coded[:4])) for j in range(i + 1, len(coded[:4]))):
        across = last(w for w in neighbours[coded[i]]
                      if time[w] and w != v and w in neighbours[coded[j]] and w not in neighbours[v])
        if across is not None:
            candidates.append((coded[i], coded[j], across))
    candidates += [(k, None, None) for k in coded[:2]]
    for k in coded[:4]:
        across = last(w for w in neighbours[k] if time[w] and w != v and w not in neighbours[v]
                      and not any(w in neighbours[u] for u in neighbours[v] if u != k))
        if across is not None:
            candidates.append((k, k, across))
    return candidates or [(None, None, None)]


def read_coding_units(face, neighbours, rans):
    """The coding units of every row block in coding order, with their predictor pairs. A unit is: vertex, first row in
    the block, axes, the two predictors."""
    time = [0] * face.points  # when the last unit of a vertex was coded; 0: not yet
    now = pairs = 0
    for block in face.row_blocks:
        begin, end = block["first"], block["first"] + block["rows"]
        waiting = {}
        for i in range(begin // 3, (end + 2) // 3):
            low, high = max(begin, 3 * i), min(end, 3 * i + 3)
            waiting[face.order[i]] = (low - begin, range(low - 3 * i, high - 3 * i))
        count = {v: sum(time[w] > 0 for w in neighbours[v]) for v in waiting}
        heap = [(-count[v], waiting[v][0], v) for v in waiting]
        heapq.heapify(heap)
        block["units"] = []
        while waiting:
            _, row, v = heapq.heappop(heap)
            if v not in waiting:
                continue
            axes = waiting.pop(v)[1]
            coded = sorted((w for w in neighbours[v] if time[w]), key=lambda w: -time[w])
            candidates, pair = candidates_of(v, coded, neighbours, time), 0
            if len(candidates) > 1:
                pair = rans.symbol(0, 0, pairs % 4)
                pairs += 1
            j = 0
            while (j + 1) * (j + 2) // 2 <= pair:
                j += 1
            require(j < len(candidates), "basis-values: no such predictor")
            block["units"].append((v, row, axes, (candidates[pair - j * (j + 1) // 2], candidates[j])))
            first_time = time[v] == 0
            now += 1
            time[v] = now
            for w in neighbours[v] if first_time else []:
                if w in waiting:
                    count[w] += 1
                    heapq.heappush(heap, (-count[w], waiting[w][0], w))


def read_basis_values(c, face):
    rans = RansDecoder(c, 25, 89, parts=4)
    read_coding_units(face, find_neighbours(face), rans)
    rows = [face.row_blocks[segment["block"]]["rows"] for segment in face.segments]
    before, values_before = 0, {}  # of each column, the number of values in the columns before it
    for segment, count in zip(face.segments, rows):
        values_before.setdefault(segment["column"], before)
        before += count
    column, units = None, [0, 0, 0, 0]  # of each part
    for segment in face.segments:
        require(25 + segment["table"] < len(rans.tables), "basis-values: no such table")
        if segment["column"] != column:
            column, column_values = segment["column"], {}
            part = 4 * values_before[column] // before
        read_segment_values(rans, part, units, face.row_blocks[segment["block"]], segment, column_values)
    rans.end()


def read_residuals(rans, part, stream, axes, table):
    """The residuals of a unit by axis."""
    symbol = rans.symbol(table, part, stream)
    if symbol < 27:
        residuals = [(0, 1, -1)[symbol // 3**axis % 3] for axis in range(3)]
        require(all(residuals[axis] == 0 or axis in axes for axis in range(3)), "basis-values: no such axis")
        return residuals
    b = symbol - 25
    require(b <= 17, "basis-values: a class is too large")
    residuals, reached, f = [0, 0, 0], False, max(b - 6, 0)
    for axis in axes:
        table = 1 + 3 * (min(b, 9) - 2) + (1 if reached else 2 if axis == axes[-1] else 0)
        code = rans.symbol(table, part, stream) << f
        if f > 0:
            code += rans.bits(f, part, stream)
        residuals[axis] = code - ((1 << b) - 1)
        reached = reached or abs(residuals[axis]) >= 1 << b - 1
    return residuals


def read_segment_values(rans, part, units, block, segment, column_values):
    """Reads the values of a segment; `column_values` are those of its column by vertex."""
    segment_values, largest = [0] * block["rows"], 32512 if segment["is_16_bit"] else 127
    for v, row, axes, predictors in block["units"]:
        residuals = read_residuals(rans, part, units[part] % 4, axes, 25 + segment["table"])
        units[part] += 1
        first, second = (predicted(predictor, column_values) for predictor in predictors)
        values = column_values.setdefault(v, [0, 0, 0])
        for i, axis in enumerate(axes):
            value = (first[axis] + second[axis] + 1 >> 1) + residuals[axis]
            require(-largest <= value <= largest, "basis-values: out of range")
            values[axis] = segment_values[row + i] = value
    segment["values"] = np.array(segment_values, np.int64)


def predicted(predictor, values):
    left, right, across = (values.get(v, [0, 0, 0]) for v in predictor)
    return [left[axis] + right[axis] - across[axis] for axis in range(3)]


def read_text(c):
    require(b"\0" not in c.data, f"{c.name}: holds a zero byte")
    return c.data.decode("utf-8", "replace")


def read_proof(c, face):
    poses, controls = c.u32(), len(face.controls)
    face.proof_controls = c.array("f4", poses * controls).reshape(poses, controls)
    require(not np.isnan(face.proof_controls).any(), "proof: a control is NaN")
    face.proof_hashes = c.array("u8", poses).tolist()
    face.proof_vertices = c.array("u4", c.u32())
    require((face.proof_vertices < face.vertices).all(), "proof: no such vertex")
    count = len(face.proof_vertices)
    face.proof_positions = c.array("f4", poses * count * 3).reshape(poses, count, 3)
    face.proof_frames = c.array("f4", poses * len(face.sockets) * 12).reshape(poses, len(face.sockets) * 12)
    face.proof_channels = c.array("f4", poses * len(face.channels)).reshape(poses, len(face.channels))
    if face.errors:
        count = len(face.errors[1]) + 1
        face.proof_errors = c.array("f4", poses * count).reshape(poses, count)
        face.proof_outside = c.array("u4", poses).tolist()
    face.proof_levels = c.array("u8", poses * 2 * len(face.levels)).reshape(poses, 2 * len(face.levels)).tolist()
    c.end()


class Face:
    def __init__(self, data: bytes) -> None:
        sections = read_sections(data)
        for name, (flags, *_) in sections.items():
            require(name in REQUIRED + OPTIONAL or not flags & 1, f"{name}: required and unknown")
        read_definition(decompress(sections, "definition"), self)
        self.channels = []
        if "channels" in sections:
            fbk_character.read_channels(decompress(sections, "channels"), self)
        self.points = self.vertices + (len(self.channels) + 2) // 3  # those behind the vertices carry channels
        read_geometry(decompress(sections, "geometry"), self)
        read_polygons(decompress(sections, "polygons"), self)
        read_network(decompress(sections, "network"), self)
        read_weights(decompress(sections, "weights"), self)
        read_basis(decompress(sections, "basis"), self)
        read_basis_values(decompress(sections, "basis-values"), self)
        if "uvs" in sections:
            read_uvs(decompress(sections, "uvs"), self)
        self.meshes, self.materials, self.images, self.joints, self.skin = [], [], [], [], []
        for name in ("labels", "meshes", "materials", "images", "joints", "skin", "about", "thumbnail"):
            if name in sections:
                getattr(fbk_character, "read_" + name)(decompress(sections, name), self)
        fbk_character.check(self)
        self.sockets = []
        if "sockets" in sections:
            fbk_sockets.read_sockets(decompress(sections, "sockets"), self)
        self.levels = []
        if "levels" in sections:
            fbk_levels.read_levels(decompress(sections, "levels"), self)
            fbk_levels.check_sockets(self)
        self.errors = None
        if "expected-errors" in sections:
            fbk_errors.read_expected_errors(decompress(sections, "expected-errors"), self)
        self.exact = []
        if "exact-poses" in sections:
            fbk_exact.read_exact_poses(decompress(sections, "exact-poses"), self)
        self.text = {n: read_text(decompress(sections, n)) for n in OPTIONAL[:3] if n in sections}
        self.proof_controls = np.zeros((0, len(self.controls)), F)
        if "proof" in sections:
            read_proof(decompress(sections, "proof"), self)
        fbk_evaluate.prepare(self)

    def verify(self):
        for pose, controls in enumerate(self.proof_controls):
            positions, channels = fbk_evaluate.evaluate(self, controls)
            here = positions.reshape(-1, 3)[self.proof_vertices]
            for v, now, then in zip(self.proof_vertices, here, self.proof_positions[pose]):
                require(now.tobytes() == then.tobytes(), f"pose {pose}, vertex {v}: {now}, archived {then}")
            require(not np.isnan(positions).any(), f"pose {pose}: a position is NaN")
            found = xxh64(positions.astype("<f4").tobytes())
            require(found == self.proof_hashes[pose], f"pose {pose}: hash {found:016x}, not {self.proof_hashes[pose]:016x}")
            frames = fbk_sockets.posed_frames(self, positions)
            require(frames.tobytes() == self.proof_frames[pose].tobytes(), f"pose {pose}: the frames of sockets differ")
            require(channels.tobytes() == self.proof_channels[pose].tobytes(), f"pose {pose}: the channels differ")
            if self.errors:
                errors, outside = fbk_errors.expected_errors(self, controls)
                require(errors.tobytes() == self.proof_errors[pose].tobytes(), f"pose {pose}: expected errors differ")
                require(outside == self.proof_outside[pose], f"pose {pose}: {outside} controls are outside")
            for half, then in enumerate(self.proof_levels[pose], 1):
                positions = fbk_levels.positions_at(self, controls, half / 2).astype("<f4")
                require(not np.isnan(positions).any(), f"pose {pose}, level of detail {half / 2}: a position is NaN")
                found = xxh64(positions.tobytes())
                require(found == then, f"pose {pose}, level of detail {half / 2}: the positions differ")
        return len(self.proof_controls)


def main(arguments):
    show = "--positions" in arguments
    paths = [a for a in arguments if a != "--positions"]
    if not paths:
        print(__doc__, file=sys.stderr)
        return 2
    for path in paths:
        try:
            with np.errstate(all="ignore"):
                with open(path, "rb") as file:
                    face = Face(file.read())
                if show:
                    for controls in face.proof_controls:
                        print(fbk_evaluate.evaluate(face, controls)[0].astype(">f4").tobytes().hex())
                else:
                    print(f"{path}: {face.verify()} poses evaluate as archived")
        except (Corrupt, ValueError, zlib.error) as error:
            print(f"{path}: {error}", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
