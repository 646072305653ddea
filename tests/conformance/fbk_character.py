"""The sections of an .fbk archive that no pose changes: meshes, materials, images, joints and texts about it."""
import struct

import numpy as np

from fbk_bytes import require

NO_MATERIAL = NO_CONTROL = NO_JOINT = 2**32 - 1
SLOTS, WRAPS, ALPHA_MODES = 5, 3, 3


def read_labels(c, face):
    count = len(face.controls)
    labels = [(c.string(), c.string(), c.string(), c.u32()) for _ in range(count)]
    for which in (0, 1):
        names = [label[which] for label in labels if label[which]]
        require(len(names) == len(set(names)), "labels: two controls have one name")
    for i, (*_, mirror) in enumerate(labels):
        if mirror != NO_CONTROL:
            require(mirror < count and mirror != i and labels[mirror][3] == i, f"labels: mirror partner of {i}")
    face.labels = labels
    c.end()


def read_meshes(c, face):
    vertex = polygon = 0
    count = c.u32()
    require(count > 0, "meshes: none")
    for _ in range(count):
        name, vertices, polygons = c.string(), c.u32(), c.u32()
        runs = [(c.u32(), c.u32()) for _ in range(c.u32())]
        require(name and name not in (m[0] for m in face.meshes), f"meshes: name {name!r}")
        require(vertices > 0 and vertex + vertices <= face.vertices, f"meshes: vertices of {name}")
        require(polygon + polygons <= len(face.polygons), f"meshes: polygons of {name}")
        for corners in face.polygons[polygon : polygon + polygons]:
            require(all(vertex <= v < vertex + vertices for v in corners), f"meshes: {name} has a vertex of another")
        require(all(count > 0 for count, _ in runs), f"meshes: an empty run of {name}")
        require(sum(count for count, _ in runs) == polygons, f"meshes: runs of {name}")
        face.meshes.append((name, vertices, polygons, runs))
        vertex, polygon = vertex + vertices, polygon + polygons
    require(vertex == face.vertices and polygon == len(face.polygons), "meshes: not all of the mesh")
    c.end()


def read_materials(c, face):
    count = c.u32()
    require(count > 0, "materials: none")
    for _ in range(count):
        name, factors = c.string(), c.array("f4", 9)
        mode, cutoff, flags = c.number("B"), c.array("f4", 1), c.number("B")
        require(np.isfinite(factors).all() and np.isfinite(cutoff).all(), f"materials: {name}: not finite")
        require(mode < ALPHA_MODES, f"materials: unsupported alpha mode {mode}")
        require(flags < 2, f"materials: unsupported flags {flags}")
        textures = []
        for _ in range(c.u32()):
            slot, wrap_u, wrap_v, image, scale = *(c.number("B") for _ in range(3)), c.u32(), c.array("f4", 1)
            require(slot < SLOTS and wrap_u < WRAPS and wrap_v < WRAPS, "materials: unsupported slot or wrap")
            require(slot not in (t[0] for t in textures), f"materials: {name}: two textures in slot {slot}")
            require(np.isfinite(scale).all(), f"materials: {name}: not finite")
            textures.append((slot, image))
        face.materials.append((name, textures))
    c.end()


def read_images(c, face):
    count = c.u32()
    require(count > 0, "images: none")
    for _ in range(count):
        face.images.append((c.string(), c.string(), bytes(c.take(c.u32()))))
    c.end()


def read_about(c, face):
    text = bytes(c.take(len(c.data) - c.at))
    require(len(text) <= 65536, "about: too long")
    require(b"\0" not in text, "about: a zero byte")
    try:
        face.about = text.decode("utf-8")
    except UnicodeDecodeError:
        require(False, "about: no UTF-8")


def read_thumbnail(c, face):
    png = bytes(c.take(len(c.data) - c.at))
    require(24 <= len(png) <= 65536, "thumbnail: too short or too long")
    require(png[:16] == bytes.fromhex("89504e470d0a1a0a0000000d49484452"), "thumbnail: no PNG")
    width, height = struct.unpack_from(">II", png, 16)
    require(width == height and 1 <= width <= 512, f"thumbnail: {width} x {height} pixels")
    face.thumbnail = png


def read_joints(c, face):
    count = c.u32()
    require(1 <= count <= 65536, "joints: number")
    for j in range(count):
        name, parent, frames = c.string(), c.u32(), c.array("f4", 24)
        require(name and name not in (joint[0] for joint in face.joints), f"joints: name {name!r}")
        require(parent < j or parent == NO_JOINT, f"joints: parent of {name}")
        require(np.isfinite(frames).all(), f"joints: {name}: not finite")
        face.joints.append((name, parent, frames[:12], frames[12:]))
    c.end()


def read_skin(c, face):
    most = c.u32()
    require(1 <= most <= 32, "skin: influences")
    counts = list(c.take(face.vertices))
    require(max(counts) <= most, "skin: influences of a vertex")
    joints, planes = c.array("u2", sum(counts)), c.take(4 * sum(counts))
    weights = np.frombuffer(bytes(planes), "u1").reshape(4, -1).T.copy().view("<f4").ravel()
    require(all(j < len(face.joints) for j in joints), "skin: a joint that there is not")
    require(np.isfinite(weights).all() and (weights > 0).all(), "skin: a weight")
    at = 0
    for v, count in enumerate(counts):
        total = np.float32(0)
        for weight in weights[at : at + count]:
            total = total + weight
        require(count == 0 or abs(total - np.float32(1)) <= np.float32(0.001), f"skin: weights of vertex {v}")
        face.skin.append(list(zip(joints[at : at + count], weights[at : at + count])))
        at += count
    first = 0
    for vertices in [m[1] for m in face.meshes] or [face.vertices]:
        here = {count > 0 for count in counts[first : first + vertices]}
        require(len(here) == 1, "skin: a mesh that follows joints in part")
        first += vertices
    c.end()


def read_channels(c, face):
    count = c.u32()
    require(count > 0, "channels: none")
    for _ in range(count):
        name, _ = c.string(), c.string()
        low, high, rest, scale = c.array("f4", 4)
        require(name and name not in (channel[0] for channel in face.channels), f"channels: name {name!r}")
        require(np.isfinite([low, high, rest, scale]).all() and low < high, f"channels: range of {name}")
        require(low <= rest <= high and scale > 0, f"channels: rest or scale of {name}")
        face.channels.append((name, low, high, rest, scale))
    c.end()


def check(face):
    for name, textures in face.materials:
        require(all(image < len(face.images) for _, image in textures), f"materials: {name} names no image")
    for name, _, _, runs in face.meshes:
        known = range(len(face.materials))
        require(all(m in known or m == NO_MATERIAL for _, m in runs), f"meshes: {name} names no material")
    check_row_blocks(face)


def check_row_blocks(face):
    parts = [m[1] for m in face.meshes] or [face.vertices]
    parts.append(face.points - face.vertices)
    part = np.repeat(np.arange(len(parts)), parts)
    of_row = np.repeat(part[face.order], 3)
    for block in face.row_blocks:
        here = of_row[block["first"] : block["first"] + block["rows"]]
        require((here == here[0]).all(), "basis: a row block has vertices of two meshes, or channels beside them")
