#!/usr/bin/env python3
"""An independent reader of .fbk archives, written from core/archive/FORMAT.md alone.

    fbk_read.py FILE...

reads every file, evaluates the poses of its proof and compares them with what was archived, bit for bit. Exit code 0
if all agree, 1 at the first difference or damage, 2 on wrong use. With --positions it prints the positions of the
proof's poses as hexadecimal bits instead of comparing them, for other programs to compare.

Needs Python 3.8, NumPy, and for the rest mesh a Draco decoder: the module DracoPy, or a program named by the variable
FB_DRACO_POINTS that reads Draco data from its standard input and writes, little-endian: u32 points, u32 faces, u32 0 or
1, x, y, z of each point as f32 (0) or i32 (1), and, if there are faces, the u32 index of each point and three points,
u32, of each face. It is slow and meant to be read.
"""
import heapq
import os
import struct
import subprocess
import sys
import zlib

import numpy as np

import fbk_evaluate
from fbk_bytes import Contents, Damaged, Symbols, require, xxh64

F = np.float32


# ---- File


def read_sections(data):
    require(data[:8] == bytes.fromhex("8946424b0d0a1a0a"), "not an .fbk archive")
    require(len(data) >= 24, "truncated within the header")
    major, _, count, size = struct.unpack_from("<HHIQ", data, 8)
    require(major == 1, f"unsupported: major version {major}")
    require(count <= 64, "too many sections")
    table = 24 + 56 * count
    require(len(data) >= table + 16, "truncated within the section table")
    require(struct.unpack_from("<Q", data, table)[0] == xxh64(data[:table]), "header and section table are damaged")
    require(len(data) == size, "truncated, or followed by other bytes")
    sections, end = {}, table + 8
    for row in range(count):
        name, flags, codec, offset, stored, raw, checksum = struct.unpack_from("<16sIIQQQQ", data, 24 + 56 * row)
        text = name.rstrip(b"\0")
        require(text and all(0x21 <= c <= 0x7E for c in text), "a section's name is not printable")
        text = text.decode()
        require(text not in sections, f"{text}: twice")
        require(flags in (0, 1), f"{text}: unsupported flags")
        require(offset == end and stored <= size - 8 - offset, f"{text}: not where it should be")
        end = offset + stored
        sections[text] = (flags, codec, raw, data[offset:end])
        require(xxh64(data[offset:end]) == checksum, f"{text}: damaged")
    require(end == size - 8, "the last section ends elsewhere")
    require(struct.unpack_from("<Q", data, end)[0] == xxh64(data[:end]), "damaged")
    return sections


def unpack(sections, name):
    require(name in sections, f"no section {name}")
    _, codec, raw, stored = sections[name]
    require(codec in (0, 2), f"{name}: unsupported codec {codec}")
    if codec == 2:
        stream = zlib.decompressobj()
        stored = stream.decompress(stored, raw + 1)
        require(stream.eof and not stream.unused_data, f"{name}: not one whole zlib stream")
    require(len(stored) == raw, f"{name}: unpacks to another size")
    return Contents(name, stored)


REQUIRED = ("definition", "polygons", "geometry", "network", "weights", "basis", "basis-values")
OPTIONAL = ("provenance", "licence", "certificate", "proof", "uvs")


# ---- Sections


def read_definition(c, face):
    face.name, face.units, face.up = c.string(), c.string(), c.string()
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
    coding = c.u32()
    require(coding in (0, 1), f"polygons: unsupported coding {coding}")
    face.polygons = []
    if coding == 0:
        face.polygons = read_corner_steps(c, sizes, c.planes(corners).tolist(), face.vertices)
    else:
        read_turns(c, face, sizes, c.steps(count).tolist(), c.take(count))
    c.end()


def read_corner_steps(c, sizes, steps, limit):
    polygons, flat, before = [], [], 0
    for size in sizes:
        begin = len(flat)
        for k in range(size):
            base = flat[begin - before + k] if k < before else flat[-1] if flat else 0
            step = steps[len(flat)]
            flat.append(base + (step >> 1 ^ -(step & 1)) & 0xFFFFFFFF)
            require(flat[-1] < limit, f"{c.name}: a corner beyond {limit}")
        polygons.append(flat[begin:])
        before = size
    return polygons


def read_turns(c, face, sizes, firsts, turns):
    edges = {}
    for triangle in face.triangles:
        for k in range(3):
            v, to, beyond = (triangle[(k + i) % 3] for i in range(3))
            edges.setdefault(v, []).append((to, beyond))
    before = None
    for size, v, turn in zip(sizes, firsts, turns):
        require(v < face.vertices, "polygons: no such vertex")
        prediction = v + before[1] - before[0] if before else v
        mine = edges.get(v, [])
        beyond = dict(mine)
        require(len(mine) <= 64 and len(beyond) == len(mine), "polygons: triangles that do not tell")

        def step(w):
            d = (w - prediction) % 2**32
            return 2 * d if d < 2**31 else 2 * (2**32 - d) - 1

        require(turn < len(mine), "polygons: no such turn")
        polygon = [v, sorted(beyond, key=step)[turn]]
        while len(polygon) < size:
            require(polygon[-1] in beyond, "polygons: no triangle goes on")
            polygon.append(beyond[polygon[-1]])
        face.polygons.append(polygon)
        before = polygon


def draco_points(data):
    """Points (n x 3, f32 or i32), indices (n) and faces (m x 3) of Draco data, by a stock decoder."""
    program = os.environ.get("FB_DRACO_POINTS")
    if program:
        done = subprocess.run([program], input=data, capture_output=True)
        require(done.returncode == 0, "geometry: the Draco data cannot be decoded")
        count, faces, whole = struct.unpack_from("<III", done.stdout)
        points = np.frombuffer(done.stdout, "<i4" if whole else "<f4", 3 * count, 12).reshape(count, 3)
        rest = np.frombuffer(done.stdout, "<u4", -1, 12 + 12 * count)
        return points, rest[:count], rest[count:].reshape(faces, 3)
    import DracoPy

    mesh = DracoPy.decode(data)
    attributes = {a["attribute_type"]: np.asarray(a["data"]) for a in getattr(mesh, "attributes", [])}
    points = attributes.get(0, np.asarray(mesh.points, F))
    faces = np.asarray(getattr(mesh, "faces", np.zeros((0, 3))), np.int64)
    return points, attributes.get(4, np.zeros(0, np.uint32)).ravel(), faces


def read_geometry(c, face):
    order, triangles, step = c.u32(), c.u32(), c.array("f4", 1)[0]
    require(order in (0, 1), f"geometry: unsupported order {order}")
    require(step == 0 or step > 0 and np.isfinite(step) and np.frexp(step)[0] == 0.5, "geometry: the grid's step")
    points, index, faces = draco_points(c.take(len(c.data) - c.at))
    require(len(points) == face.vertices and len(faces) == triangles, "geometry: points or triangles")
    require((points.dtype.kind == "f") == bool(step == 0), "geometry: a grid without whole numbers, or these without")
    if step > 0:
        require((abs(points.astype(np.int64)) <= 16777215).all(), "geometry: beyond the grid")
        points = points.astype(F) * step
    require(np.isfinite(points).all(), "geometry: points")
    if order == 1:
        require(sorted(index.tolist()) == list(range(face.vertices)), "geometry: indices")
        rest = np.empty_like(points)
        rest[index] = points
        points = rest
    else:
        require(triangles == 0, "geometry: triangles without a mesh")
    face.triangles = [[int(index[p]) for p in f] for f in faces]
    require((points.max(0) > points.min(0)).any(), "geometry: the bounding box is a point")
    face.rest = points.astype(F).ravel()


def read_uvs(c, face):
    pairs, coding = c.u32(), c.u32()
    require(pairs > 0, "uvs: there are none")
    require(coding in (0, 1), f"uvs: unsupported coding {coding}")
    face.uvs = np.stack([c.planes(pairs, "f4"), c.planes(pairs, "f4")], axis=1)
    require(np.isfinite(face.uvs).all(), "uvs: not finite")
    if coding == 0:
        sizes = [len(polygon) for polygon in face.polygons]
        face.uv_polygons = read_corner_steps(c, sizes, c.planes(sum(sizes)).tolist(), pairs)
    else:
        require(pairs == face.vertices, "uvs: not one a vertex")
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
            require(max(first, second) < f, "network: a feature is made of later ones")
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
        looked = [face.features[f] for f in region["gate"]]
        require(all(f[0] == 0 for f in looked), "network: a gate looks at what is no identity")
        require(all(a[1] < b[1] for a, b in zip(looked, looked[1:])), "network: a gate's controls do not ascend")
        region["layers"], width = [], len(region["features"])
        for _ in range(c.u32()):
            inputs, outputs, activation, flags = c.u32(), c.u32(), c.number("B"), c.number("B")
            require(activation <= 3 and flags <= 3, "network: unsupported layer")
            require(inputs == width <= 16777215 and outputs >= 1, "network: widths")
            require(not flags & 1 or inputs == outputs, "network: skip")
            bias, scales = c.planes(outputs, F), c.planes(outputs, F)
            require(np.isfinite(bias).all() and np.isfinite(scales).all(), "network: numbers that are not finite")
            region["layers"].append(
                {"shape": (outputs, inputs), "activation": activation, "skip": flags & 1, "wide": flags >> 1,
                 "bias": bias, "scales": scales})
            width = outputs
        require(region["layers"], "network: a region without layers")
        face.regions.append(region)
    face.coefficients = len(face.direct) + sum(r["layers"][-1]["shape"][0] for r in face.regions)
    c.end()


def read_weights(c, face):
    symbols = Symbols(c, 9)
    for region in face.regions:
        last = len(region["layers"]) - 1
        for number, layer in enumerate(region["layers"]):
            t = 2 if number == last else 0 if number == 0 else 1
            weights = []
            for i in range(layer["shape"][0] * layer["shape"][1]):
                if layer["wide"]:
                    high = symbols.symbol(t + 3, i % 4) - 127
                    weights.append(256 * high + symbols.symbol(t + 6, i % 4) - 128)
                else:
                    weights.append(symbols.symbol(t, i % 4) - 127)
            most = 32512 if layer["wide"] else 127
            require(all(-most <= w <= most for w in weights), "weights: beyond their range")
            layer["weights"] = np.array(weights, np.int64).reshape(layer["shape"])
    symbols.end()


def read_basis(c, face):
    columns, ordered = c.u32(), c.u32()
    require(columns == face.coefficients, "basis: columns")
    require(ordered <= 1, "basis: order flag")
    face.order = list(range(face.vertices))
    if ordered:
        face.order = c.steps(face.vertices).tolist()
        require(sorted(face.order) == list(range(face.vertices)), "basis: the order does not name every vertex once")
    rows = c.planes(c.u32()).tolist()
    require(all(rows) and sum(rows) == 3 * face.vertices, "basis: rows")
    face.groups, first = [], 0
    for count in rows:
        face.groups.append({"first": first, "rows": count, "columns": []})
        first += count
    places = c.planes(columns).tolist()
    steps = c.planes(sum(places)).tolist()
    flags = c.take(sum(places))
    scales = iter(c.planes(c.u32(), F))
    c.end()
    face.places, at, scale = [], 0, None
    for column in range(columns):
        group = 0
        for i in range(places[column]):
            require(i == 0 or steps[at] > 0, "basis: a column lies twice in a group")
            group += steps[at]
            require(group < len(face.groups) and flags[at] <= 3, "basis: a place")
            if flags[at] & 2:
                scale = next(scales, None)
            require(scale is not None, "basis: a place has no scale")
            wide = bool(flags[at] & 1)
            with np.errstate(over="ignore"):
                require(np.isfinite(scale * F(256) if wide else scale), "basis: a scale that is not finite")
            place = {"column": column, "wide": wide, "scale": scale, "group": group}
            face.groups[group]["columns"].append(place)
            face.places.append(place)
            at += 1
    require(next(scales, None) is None, "basis: scales are left")
    for group in face.groups:
        require(sum(2 if p["wide"] else 1 for p in group["columns"]) <= 16777215, "basis: too many summands")


def find_neighbours(face):
    near = [[] for _ in range(face.vertices)]
    for polygon in face.polygons:
        for v, w in zip(polygon, polygon[1:] + polygon[:1]):
            if v != w and w not in near[v] and len(near[v]) < 16 and len(near[w]) < 16:
                near[v].append(w)
                near[w].append(v)
    return near


def predictors_of(v, known, near, coded):
    """The predictors of a vertex as triples (left, right, across), None for nobody; and its surroundings."""
    def last(vertices):
        return max(vertices, key=lambda w: coded[w], default=None)

    predictors = []
    for i, j in ((i, j) for i in range(len(known[:4])) for j in range(i + 1, len(known[:4]))):
        across = last(w for w in near[known[i]]
                      if coded[w] and w != v and w in near[known[j]] and w not in near[v])
        if across is not None:
            predictors.append((known[i], known[j], across))
    surroundings = 0 if predictors else 1 if known else 2
    predictors += [(k, None, None) for k in known[:2]]
    for k in known[:4]:
        beyond = last(w for w in near[k] if coded[w] and w != v and w not in near[v]
                      and not any(w in near[u] for u in near[v] if u != k))
        if beyond is not None:
            predictors.append((k, k, beyond))
    return predictors or [(None, None, None)], surroundings


def find_pieces(face, near, symbols):
    """For every group its pieces in coding order: vertex, first row in the group, axes, predictors, surroundings, k1, k2."""
    coded = [0] * face.vertices  # the turn of a vertex's last piece
    turn = 0
    for group in face.groups:
        begin, end = group["first"], group["first"] + group["rows"]
        waiting = {}
        for i in range(begin // 3, (end + 2) // 3):
            low, high = max(begin, 3 * i), min(end, 3 * i + 3)
            waiting[face.order[i]] = (low - begin, range(low - 3 * i, high - 3 * i))
        count = {v: sum(coded[w] > 0 for w in near[v]) for v in waiting}
        heap = [(-count[v], waiting[v][0], v) for v in waiting]
        heapq.heapify(heap)
        group["pieces"] = []
        while waiting:
            _, row, v = heapq.heappop(heap)
            if v not in waiting:
                continue
            axes = waiting.pop(v)[1]
            known = sorted((w for w in near[v] if coded[w]), key=lambda w: -coded[w])
            predictors, surroundings = predictors_of(v, known, near, coded)
            choice = symbols.symbol(0 if surroundings == 0 else 1, 0) if len(predictors) > 1 else 0
            j = 0
            while (j + 1) * (j + 2) // 2 <= choice:
                j += 1
            require(j < len(predictors), "basis-values: a prediction that there is not")
            chosen = (predictors[choice - j * (j + 1) // 2], predictors[j])
            k1, k2 = (known + known)[:2] if known else (None, None)
            group["pieces"].append((v, row, axes, chosen, surroundings, k1, k2))
            new = coded[v] == 0
            turn += 1
            coded[v] = turn
            for w in near[v] if new else []:
                if w in waiting:
                    count[w] += 1
                    heapq.heappush(heap, (-count[w], waiting[w][0], w))


def read_basis_values(c, face):
    symbols = Symbols(c, 255)
    find_pieces(face, find_neighbours(face), symbols)
    rows = [face.groups[place["group"]]["rows"] for place in face.places]
    before, columns = 0, {}  # of each column, the numbers in those before it
    for place, count in zip(face.places, rows):
        columns.setdefault(place["column"], before)
        before += count
    column = None
    for place in face.places:
        if place["column"] != column:
            column, numbers, residuals, classes, magnitudes = place["column"], {}, {}, {}, {}
            stream = 4 * columns[column] // before
        place["values"] = np.array(read_place(symbols, stream, face.groups[place["group"]], 32512 if place["wide"] else 127,
                                              numbers, residuals, classes, magnitudes), np.int64)
    symbols.end()


def read_place(symbols, stream, group, m, numbers, residuals, classes, magnitudes):
    values, nothing = [0] * group["rows"], [0, 0, 0]
    for v, row, axes, (one, other), surroundings, k1, k2 in group["pieces"]:
        t = 0
        if k1 is not None:
            s = classes.get(k1, 0) + classes.get(k2, 0)
            g = magnitudes.get(k2, 0)
            if s == 0:
                t = 0 if g == 0 else 1
            else:
                t = 1 + min(s, 20) + (20 if g > (s + 1 >> 1) + 2 else 0)
        first = symbols.symbol(2 + 42 * surroundings + t, stream)
        left_over = [0, 0, 0]
        if first < 27:
            b = 1 if first > 0 else 0
            left_over = [(0, 1, -1)[first // 3**axis % 3] for axis in range(3)]
            require(all(left_over[axis] == 0 or axis in axes for axis in range(3)), "basis-values: an axis too many")
        else:
            b = first - 25
            require(b <= 17, "basis-values: a class is too large")
            r1, r2 = residuals.get(k1, nothing), residuals.get(k2, nothing)
            reached, f = False, max(b - 6, 0)
            for i, axis in enumerate(axes):
                n = abs(r1[axis]) + abs(r2[axis])
                e, last = min(n, 2 + (n >> 1), 6), i == len(axes) - 1
                context = 87 + 3 * (7 * (min(b, 9) - 2) + e) + (1 if reached else 2 if last else 0)
                code = symbols.symbol(context, stream) << f
                if f > 0:
                    code += symbols.bits(f, stream)
                left_over[axis] = code - ((1 << b) - 1)
                reached = reached or abs(left_over[axis]) >= 1 << b - 1
        mine = numbers.setdefault(v, [0, 0, 0])
        predicted = [(parallelogram(one, numbers, axis) + parallelogram(other, numbers, axis) + 1) >> 1 for axis in range(3)]
        for i, axis in enumerate(axes):
            number = predicted[axis] + left_over[axis]
            require(-m <= number <= m, "basis-values: beyond their range")
            mine[axis] = values[row + i] = number
        residuals[v], classes[v], magnitudes[v] = left_over, b, max(map(abs, mine)).bit_length()
    return values


def parallelogram(predictor, numbers, axis):
    left, right, across = (numbers[v][axis] if v in numbers else 0 for v in predictor)
    return left + right - across


def read_text(c):
    require(b"\0" not in c.data, f"{c.name}: holds a zero byte")
    return c.data.decode("utf-8", "replace")


def read_proof(c, face):
    poses, controls = c.u32(), len(face.controls)
    face.proof_controls = c.array("f4", poses * controls).reshape(poses, controls)
    face.proof_hashes = c.array("u8", poses).tolist()
    face.proof_vertices = c.array("u4", c.u32())
    require((face.proof_vertices < face.vertices).all(), "proof: no such vertex")
    count = len(face.proof_vertices)
    face.proof_positions = c.array("f4", poses * count * 3).reshape(poses, count, 3)
    c.end()


class Face:
    def __init__(self, path):
        with open(path, "rb") as file:
            sections = read_sections(file.read())
        for name, (flags, *_) in sections.items():
            require(name in REQUIRED + OPTIONAL or not flags & 1, f"{name}: required and unknown")
        read_definition(unpack(sections, "definition"), self)
        read_geometry(unpack(sections, "geometry"), self)
        read_polygons(unpack(sections, "polygons"), self)
        read_network(unpack(sections, "network"), self)
        read_weights(unpack(sections, "weights"), self)
        read_basis(unpack(sections, "basis"), self)
        read_basis_values(unpack(sections, "basis-values"), self)
        if "uvs" in sections:
            read_uvs(unpack(sections, "uvs"), self)
        self.text = {n: read_text(unpack(sections, n)) for n in OPTIONAL[:3] if n in sections}
        self.proof_controls = np.zeros((0, len(self.controls)), F)
        if "proof" in sections:
            read_proof(unpack(sections, "proof"), self)
        fbk_evaluate.prepare(self)

    def verify(self):
        for pose, controls in enumerate(self.proof_controls):
            positions = fbk_evaluate.evaluate(self, controls)
            here = positions.reshape(-1, 3)[self.proof_vertices]
            for v, now, then in zip(self.proof_vertices, here, self.proof_positions[pose]):
                require(now.tobytes() == then.tobytes(), f"pose {pose}, vertex {v}: {now}, archived {then}")
            found = xxh64(positions.astype("<f4").tobytes())
            require(found == self.proof_hashes[pose], f"pose {pose}: hash {found:016x}, not {self.proof_hashes[pose]:016x}")
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
                face = Face(path)
                if show:
                    for controls in face.proof_controls:
                        print(fbk_evaluate.evaluate(face, controls).astype(">f4").tobytes().hex())
                else:
                    print(f"{path}: {face.verify()} poses evaluate as archived")
        except (Damaged, ValueError) as damage:
            print(f"{path}: {damage}", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
