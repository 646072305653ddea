"""Levels of detail: FORMAT.md, "levels", and EVALUATION.md, "Levels of detail". For fbk_read.py."""
import numpy as np

import fbk_evaluate
from fbk_bytes import require, unzigzag

F = np.float32
NO_MATERIAL = 2**32 - 1


def corners_of(deltas, sizes):
    corners, previous = [], 0
    for size in sizes:
        begin = len(corners)
        for k in range(size):
            prediction = corners[begin - previous + k] if k < previous else corners[-1] if corners else 0
            corners.append(prediction + unzigzag(deltas[len(corners)]) & 0xFFFFFFFF)
        previous = size
    return corners


def read_level(c, face, number, before, baked):
    vertices, polygons, corner_count = c.u32(), c.u32(), c.u32()
    require(1 <= vertices <= before, f"levels: vertices of level {number}")
    require(any(b["first"] + b["rows"] == 3 * vertices for b in face.row_blocks), f"levels: rows of level {number}")
    sizes = c.planes(polygons).tolist()
    require(all(size >= 3 for size in sizes) and sum(sizes) == corner_count, f"levels: sizes of level {number}")
    corners = corners_of(c.planes(corner_count).tolist(), sizes)
    require(all(v < face.vertices and baked[v] < vertices for v in corners), f"levels: corners of level {number}")
    coding = c.u32()
    require(coding <= 2, f"levels: unsupported coding {coding}")
    require((coding == 0) == (not hasattr(face, "uvs") or corner_count == 0), "levels: texture coordinates")
    if coding > 0:
        uvs = corners_of(c.planes(corner_count).tolist(), sizes) if coding == 1 else corners
        require(all(uv < len(face.uvs) for uv in uvs), f"levels: texture coordinates of level {number}")
    part = read_parts(c, face, number, sizes, corners)
    triangles, at = [], 0
    for size in sizes:
        triangles += [(corners[at], corners[at + k], corners[at + k + 1]) for k in range(1, size - 1)]
        at += size
    points = read_points(c, face, number, vertices, before, triangles, part)
    count = c.u32()
    require(count == face.coefficients - len(face.direct), f"levels: coefficients of level {number}")
    bits = int.from_bytes(c.take((count + 7) // 8), "little")
    require(bits >> count == 0, f"levels: coefficients of level {number}")
    used = np.array([True] * len(face.direct) + [bool(bits >> i & 1) for i in range(count)], bool)
    return vertices, points, used


def read_parts(c, face, number, sizes, corners):
    count, polygon, corner = c.u32(), 0, 0
    require(count == len(face.meshes), f"levels: meshes of level {number}")
    part = np.repeat(np.arange(max(count, 1)), [m[1] for m in face.meshes] or [face.vertices])
    for mesh in range(count):
        polygons = c.u32()
        runs = [(c.u32(), c.u32()) for _ in range(c.u32())]
        require(all(n > 0 for n, _ in runs) and sum(n for n, _ in runs) == polygons, f"levels: runs of mesh {mesh}")
        known = range(len(face.materials))
        require(all(m in known or m == NO_MATERIAL for _, m in runs), f"levels: materials of mesh {mesh}")
        require(polygon + polygons <= len(sizes), f"levels: polygons of mesh {mesh}")
        own = sum(sizes[polygon : polygon + polygons])
        require(all(part[v] == mesh for v in corners[corner : corner + own]), f"levels: corners of mesh {mesh}")
        polygon, corner = polygon + polygons, corner + own
    require(count == 0 or polygon == len(sizes), f"levels: polygons of level {number}")
    return part


def read_points(c, face, number, vertices, before, triangles, part):
    count = c.u32()
    require(count == before - vertices, f"levels: points of level {number}")
    numbers, first, second = c.deltas(count).tolist(), c.take(count), c.take(count)
    points = []
    for i, (triangle, a, b) in enumerate(zip(numbers, first, second)):
        require(triangle < len(triangles) and a + b <= 256, f"levels: point {i} of level {number}")
        v = face.order[vertices + i]
        require(all(part[w] == part[v] for w in triangles[triangle]), f"levels: point {i} lies on another mesh")
        points.append((v, triangles[triangle], [F(w) / F(256) for w in (256 - a - b, a, b)]))
    return points


def read_levels(c, face):
    count = c.u32()
    require(1 <= count <= 15, "levels: number of levels")
    baked = {v: i for i, v in enumerate(face.order)}
    before, used = face.vertices, np.ones(face.coefficients, bool)
    for number in range(1, count + 1):
        level = read_level(c, face, number, before, baked)
        require(not (level[2] & ~used).any(), f"levels: level {number} uses more coefficients than the one before it")
        before, used = level[0], level[2]
        face.levels.append(level)
    c.end()


def check_sockets(face):
    kept = set(face.order[: face.levels[-1][0]])
    for name, vertices, *_ in face.sockets:
        require(kept.issuperset(vertices), f"sockets: {name} has a vertex that not every level has")


def positions_at(face, controls, lod):
    """The positions of all vertices at a level of detail."""
    lod = min(lod, len(face.levels))
    number = int(lod)
    share = F(lod - number)
    factors = np.ones(face.coefficients, F)
    if number > 0:
        factors[~face.levels[number - 1][2]] = 0
    if share > 0:
        factors[(factors != 0) & ~face.levels[number][2]] = F(1) - share
    points = fbk_evaluate.evaluate(face, controls, factors)[0].reshape(-1, 3)

    def on_surface(corners, weights):
        a, b, c = (w * points[v] for w, v in zip(weights, corners))
        return (a + b) + c

    if share > 0:
        for v, corners, weights in face.levels[number][1]:
            points[v] = points[v] + share * (on_surface(corners, weights) - points[v])
    for _, level, _ in reversed(face.levels[:number]):
        for v, corners, weights in level:
            points[v] = on_surface(corners, weights)
    return points.ravel()
