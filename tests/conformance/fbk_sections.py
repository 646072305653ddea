"""The sections of FORMAT.md, without network and basis. For fbk_read.py."""
import struct
from types import SimpleNamespace

import numpy as np

import fbk_basis
import fbk_draco
import fbk_joints
from fbk_bytes import F, added, unzigzag, zigzag

NONE = 2**32 - 1  # no material, control or joint
NO_EDGE = 255  # the edge index of a polygon whose corners are coded as differences


def read_definition(c, face):
    face.name, face.units, face.up = c.string(), c.string(), c.string()
    c.check(face.up in ("y", "z"), "up axis")
    face.vertices = face.points = c.u32(1, 268435456)
    face.controls = [read_range(c) for _ in range(c.u32(1))]
    face.low, face.high, face.rest_controls = np.array([control[1:] for control in face.controls]).T


def read_range(c):
    """Name, minimum, maximum and rest of a control or channel."""
    name, _, (low, high, rest) = c.new_name(), c.string(), c.floats(3)
    c.check(low < high and low <= rest <= high, f"range of {name}")
    return name, low, high, rest


def read_labels(c, face):
    labels = [(c.string(), c.string(), c.string(), c.u32()) for _ in face.controls]
    for names in ([label[which] for label in labels if label[which]] for which in (0, 1)):
        c.check(len(names) == len(set(names)), "two controls have one name")
    for i, (*_, mirror) in enumerate(labels):
        mirrored = mirror < len(labels) and mirror != i and labels[mirror][3] == i
        c.check(mirrored or mirror == NONE, f"mirror partner of {i}")


def read_sizes(c, polygons, corners):
    sizes = c.planes(polygons).tolist()
    c.check(all(size >= 3 for size in sizes) and sum(sizes) == corners, "sizes of polygons")
    return sizes


def read_corners(c, sizes, limit):
    """Polygons whose corners are coded as differences, and below the limit."""
    differences = iter(c.planes(sum(sizes)).tolist())
    polygons, before = [], []
    for size in sizes:
        polygon = []
        for k in range(size):
            prediction = before[k] if k < len(before) else polygon[-1] if k > 0 else 0
            polygon.append((prediction + unzigzag(next(differences))) % 2**32)
        c.check(max(polygon) < limit, f"a corner is not below {limit}")
        polygons.append(polygon)
        before = polygon
    return polygons


def read_polygons(c, face):
    count, corners = c.u32(), c.u32()
    sizes, edge_indices = read_sizes(c, count, corners), c.take(count)
    firsts = iter(c.deltas(count - edge_indices.count(NO_EDGE)).tolist())
    others = iter(read_corners(c, [s for s, edge in zip(sizes, edge_indices) if edge == NO_EDGE], face.vertices))
    edges = {}  # for each vertex, those from it: the vertex each leads to, and the vertex opposite
    for u, v, w in face.triangles:
        for start, end, opposite in ((u, v, w), (v, w, u), (w, u, v)):
            edges.setdefault(start, []).append((end, opposite))
    face.polygons, before = [], [0, 0]
    for size, edge_index in zip(sizes, edge_indices):
        if edge_index == NO_EDGE:
            polygon = next(others)
        else:
            polygon = before = polygon_along_triangles(c, edges, size, next(firsts), edge_index, before)
        face.polygons.append(polygon)


def polygon_along_triangles(c, edges, size, first, edge_index, before):
    from_first = edges.get(first, [])
    opposite = dict(from_first)
    c.check(size <= 66, "too many corners along triangles")
    c.check(len(from_first) <= 64 and len(opposite) == len(from_first), "not coded along these triangles")
    c.check(edge_index < len(from_first), "no such edge")
    prediction = first + before[1] - before[0]
    polygon = [first, sorted(opposite, key=lambda w: zigzag(w - prediction))[edge_index]]
    while len(polygon) < size:
        c.check(polygon[-1] in opposite, "no fan of triangles")
        polygon.append(opposite[polygon[-1]])
    return polygon


def read_geometry(c, face):
    points, triangles, grid_step, grid = c.u32(), c.u32(), c.f32(), F(1)
    if grid_step != 0:
        c.check(grid_step > 0 and np.frexp(grid_step)[0] == 0.5, "the grid step")
        grid = grid_step
    vertices = c.deltas(points).tolist()
    c.check(set(vertices) == set(range(face.vertices)), "vertices of points")
    positions, faces = fbk_draco.decode(c.rest(), points, triangles, bool(grid_step > 0))
    positions = np.array(positions, F) * grid
    c.check(np.isfinite(positions).all(), "a position is not finite")
    rest = np.empty((face.vertices, 3), F)
    rest[vertices] = positions
    c.check(rest[vertices].tobytes() == positions.tobytes(), "points of one vertex have different positions")
    c.check((rest.max(0) > rest.min(0)).any(), "the bounding box is a point")
    face.rest, face.triangles = rest.ravel(), [[vertices[point] for point in triangle] for triangle in faces]


def read_uvs(c, face):
    pairs, coding = c.u32(1), c.u32()
    c.check(coding <= 1, f"unsupported coding {coding}")
    c.check(coding == 0 or pairs == face.vertices, "not one per vertex")
    face.uvs = np.stack([c.planes(pairs, "f4"), c.planes(pairs, "f4")], 1)
    sizes = [len(polygon) for polygon in face.polygons]
    face.uv_polygons = read_corners(c, sizes, pairs) if coding == 0 else face.polygons


def read_runs(c, face, polygons):
    """The materials of a mesh of so many polygons."""
    runs = [(c.u32(1), c.u32()) for _ in range(c.u32())]
    c.check(sum(count for count, _ in runs) == polygons, "runs of a mesh")
    c.check(all(material < len(face.materials) or material == NONE for _, material in runs), "no such material")
    return runs


def read_meshes(c, face):
    face.meshes = []
    for _ in range(c.u32(1)):
        mesh = SimpleNamespace(name=c.new_name(), vertices=c.u32(1), polygons=c.u32())
        mesh.runs = read_runs(c, face, mesh.polygons)
        face.meshes.append(mesh)
    c.check(sum(mesh.vertices for mesh in face.meshes) == face.vertices, "vertices of all meshes")
    check_polygons(c, face, [mesh.polygons for mesh in face.meshes], face.polygons)


def check_polygons(c, face, counts, polygons):
    """Whether so many polygons of each mesh are all, and have vertices of their own mesh only."""
    c.check(sum(counts) == len(polygons), "polygons of all meshes")
    mesh_of = face.mesh_of.tolist()
    for mesh, polygon in zip(np.repeat(np.arange(len(counts)), counts), polygons):
        c.check(all(mesh_of[v] == mesh for v in polygon), f"mesh {mesh} has a vertex of another")


def read_materials(c, face):
    face.materials = []
    for _ in range(c.u32(1)):
        material = SimpleNamespace(name=c.string(), base_colour=c.floats(4), metallic=c.f32(), roughness=c.f32(),
                                   emissive=c.floats(3), mode=c.u8(), cutoff=c.f32(), flags=c.u8(), textures={})
        c.check(material.mode <= 2 and material.flags <= 1, "unsupported alpha mode or flags")
        for _ in range(c.u32()):
            slot, wraps, image, scale = c.u8(), c.take(2), c.u32(most=len(face.images) - 1), c.f32()
            c.check(slot <= 4 and max(wraps) <= 2, "unsupported slot or wrap")
            c.check(slot not in material.textures, f"{material.name}: two textures in slot {slot}")
            material.textures[slot] = wraps, image, scale
        face.materials.append(material)


def read_images(c, face):
    face.images = [(c.string(), c.string(), c.take(c.u32())) for _ in range(c.u32(1))]


def read_sockets(c, face):
    face.sockets = []
    for _ in range(c.u32(1)):
        name, n = c.new_name(), c.u32(3)
        socket = SimpleNamespace(vertices=c.array("u4", n), weights=c.floats(n), frame=c.floats(12))
        c.check((socket.vertices < face.vertices).all(), f"vertices of {name}")
        c.check(len(set(face.mesh_of[socket.vertices])) == 1, f"{name} has vertices of two meshes")
        c.check((socket.weights > 0).all(), f"weights of {name}")
        face.sockets.append(socket)


def read_joints(c, face):
    face.joints = []
    for j in range(c.u32(1, 65536)):
        joint = SimpleNamespace(name=c.new_name(), parent=c.u32(), rest=c.floats(12), inverse_bind=c.floats(12))
        c.check(joint.parent < j or joint.parent == NONE, f"parent of {joint.name}")
        face.joints.append(joint)


def read_skin(c, face):
    most, counts = c.u32(1, 32), np.array(list(c.take(face.vertices)))
    c.check(max(counts) <= most, "influences of a vertex")
    joints, weights = c.array("u2", sum(counts)), c.planes(sum(counts), "f4")
    c.check((joints < len(face.joints)).all() and (weights > 0).all(), "a joint or a weight")
    mesh_of = face.mesh_of[: face.vertices]
    c.check(set(mesh_of[counts > 0]).isdisjoint(mesh_of[counts == 0]), "a mesh that follows joints in part")
    for v, end in enumerate(np.cumsum(counts)):
        total = added(weights[end - counts[v] : end])
        c.check(counts[v] == 0 or abs(total - F(1)) <= F(0.001), f"weights of vertex {v}")


def read_channels(c, face):
    face.channels = [(*read_range(c), c.f32()) for _ in range(c.u32(1))]
    c.check(all(scale > 0 for *_, scale in face.channels), "a scale")
    face.points += (len(face.channels) + 2) // 3  # those behind the vertices carry channels


def read_about(c, face):
    text = c.rest()
    c.check(len(text) <= 65536 and b"\0" not in text, "too long, or with a zero byte")
    text.decode("utf-8")  # an error is a ValueError


def read_thumbnail(c, face):
    png = c.rest()
    c.check(24 <= len(png) <= 65536, "too short or too long")
    beginning, width, height = struct.unpack_from(">16sII", png)
    c.check(beginning == b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "no PNG")
    c.check(width == height and 1 <= width <= 512, f"{width} x {height} pixels")


def read_expected_errors(c, face):
    controls, errors = len(face.controls), SimpleNamespace(unit=c.f32(), constants=[])
    regions = c.u32(1, 64)
    for _ in range(regions):
        c.new_name()
        errors.constants.append(c.f32())
    c.check(errors.unit > 0 and min(errors.constants) >= 0, "unit or a constant")
    errors.sizes = [0] * regions
    for _ in range(c.u32()):
        vertices, region = c.u32(1), c.u32(most=regions - 1)
        errors.sizes[region] += vertices
    c.check(sum(errors.sizes) == face.vertices and min(errors.sizes) > 0, "vertices of regions")
    weights = [(8 + w % 8) * 2.0 ** ((w >> 3) - 35) if w > 0 else 0 for w in c.take(controls * regions)]
    errors.weights = np.array(weights, F).reshape(controls, regions)
    errors.lowest, errors.highest = c.array("u1", controls), c.array("u1", controls)
    c.check((errors.lowest <= errors.highest).all(), "trained values")
    errors.pairs = c.bits(controls * (controls - 1) // 2)
    face.errors = errors


def read_exact_poses(c, face):
    face.exact = []
    for _ in range(c.u32(1, 1024)):
        pose = SimpleNamespace(name=c.new_name(), controls=c.floats(len(face.controls)), falloff=c.f32(), step=c.f32())
        c.check((face.low <= pose.controls).all() and (pose.controls <= face.high).all(), f"controls of {pose.name}")
        c.check(pose.falloff > 0 and pose.step > 0, f"falloff or step of {pose.name}")
        face.exact.append(pose)
    for pose in face.exact:
        numbers = np.stack([c.deltas(face.points) for _ in range(3)], 1).ravel()
        numbers = np.where(numbers < 2**31, numbers, numbers - 2**32)
        c.check((np.abs(numbers) < 2**24).all(), f"corrections of {pose.name}")
        pose.corrections = pose.step * numbers.astype(F)


def read_levels(c, face):
    face.levels = []
    before = SimpleNamespace(vertices=face.vertices, used=np.ones(face.coefficients, bool))
    for _ in range(c.u32(1, 15)):
        level = read_level(c, face, before.vertices)
        c.check((level.used <= before.used).all(), "a level uses more coefficients than the one before it")
        face.levels.append(level)
        before = level
    kept = set(face.order[: before.vertices])
    c.check(all(kept.issuperset(socket.vertices) for socket in face.sockets), "a socket has a vertex that is not kept")


def read_level(c, face, vertices_before):
    level = SimpleNamespace(vertices=c.u32(1, vertices_before))
    c.check(any(block.end == 3 * level.vertices for block in face.row_blocks), "a part of a row block")
    sizes = read_sizes(c, c.u32(), c.u32())
    polygons, vertices = read_corners(c, sizes, face.vertices), set(face.order[: level.vertices])
    c.check(all(vertices.issuperset(polygon) for polygon in polygons), "a corner that is not of the level")
    coding = c.u32()
    c.check(coding <= 2, f"unsupported coding {coding}")
    c.check((coding == 0) == (len(face.uvs) == 0 or len(polygons) == 0), "texture coordinates")
    if coding > 0:
        uv_polygons = read_corners(c, sizes, len(face.uvs)) if coding == 1 else polygons
        c.check(all(max(polygon) < len(face.uvs) for polygon in uv_polygons), "a corner without texture coordinates")
    c.check(c.u32() == len(face.meshes), "number of meshes")
    counts = []
    for _ in face.meshes:
        counts.append(c.u32())
        read_runs(c, face, counts[-1])
    if face.meshes:
        check_polygons(c, face, counts, polygons)
    triangles = [(polygon[0], v, w) for polygon in polygons for v, w in zip(polygon[1:], polygon[2:])]
    level.points = read_points(c, face, face.order[level.vertices : vertices_before], triangles)
    coefficients = c.u32()
    c.check(coefficients == face.coefficients - len(face.direct), "number of coefficients")
    level.used = np.append(np.ones(len(face.direct), bool), c.bits(coefficients))
    return level


def read_points(c, face, vertices, triangles):
    """For each of the vertices: its number, its triangle, and the weights of the triangle's corners."""
    count, points, mesh_of = c.u32(), [], face.mesh_of
    c.check(count == len(vertices), "number of points")
    for v, number, a, b in zip(vertices, c.deltas(count).tolist(), c.take(count), c.take(count)):
        c.check(number < len(triangles) and a + b <= 256, f"point {v}")
        c.check((mesh_of[list(triangles[number])] == mesh_of[v]).all(), f"point {v} lies on another mesh")
        points.append((v, triangles[number], [F(weight) / F(256) for weight in (256 - a - b, a, b)]))
    return points


def read_text(c, face):
    c.check(b"\0" not in c.rest(), "a zero byte")


def read_proof(c, face):
    poses, face.proof = c.u32(), {}

    def read(name, kind, count):
        face.proof[name] = c.array(kind, poses * count).reshape(poses, count)

    read("controls", "f4", len(face.controls))
    c.check(not np.isnan(face.proof["controls"]).any(), "a control is NaN")
    read("hash", "u8", 1)
    face.proof_vertices = c.array("u4", c.u32())
    c.check((face.proof_vertices < face.vertices).all(), "no such vertex")
    read("positions", "f4", 3 * len(face.proof_vertices))
    read("frames", "f4", 12 * len(face.sockets))
    read("channels", "f4", len(face.channels))
    if face.errors:
        read("expected errors", "f4", 1 + len(face.errors.constants))
        read("controls outside", "u4", 1)
    read("hashes at levels of detail", "u8", 2 * len(face.levels))
    if face.driven:
        read("hash of joints", "u8", 1)


REQUIRED = ("definition", "polygons", "geometry", "network", "weights", "basis", "basis-values")
READERS = {  # each after those of sections that it refers to
    "definition": read_definition, "channels": read_channels, "driven-joints": fbk_joints.read_driven_joints,
    "geometry": read_geometry, "polygons": read_polygons,
    "uvs": read_uvs, "images": read_images, "materials": read_materials, "meshes": read_meshes,
    "network": fbk_basis.read_network, "weights": fbk_basis.read_weights, "basis": fbk_basis.read_basis,
    "basis-values": fbk_basis.read_basis_values, "labels": read_labels, "joints": read_joints, "skin": read_skin,
    "sockets": read_sockets, "levels": read_levels, "expected-errors": read_expected_errors,
    "exact-poses": read_exact_poses, "about": read_about, "thumbnail": read_thumbnail, "provenance": read_text,
    "licence": read_text, "certificate": read_text, "proof": read_proof,
}
