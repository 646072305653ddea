#!/usr/bin/env python3
"""Draws face_colour.png, the base colours of the sample face.

    facebaker sample sample --poses 20 --no-shots --out FOLDER
    paint_colours.py FOLDER face_colour.png

What a pixel shows is decided by the place of the rest mesh that lies there, in centimetres as anatomy.h has them, so a
change of the layout of the texture coordinates needs no change here. NumPy."""

import json
import pathlib
import struct
import sys
import zlib

import numpy as np

SIZE = 512  # pixels along an edge
STEP = 2  # of colours: the file is smaller by a quarter, and nobody sees it
FINER = 2  # times as many are painted in each direction, and averaged
MARGIN = 16  # pixels that colours go on beyond the edge of a chart

SKIN, LIP, BROW, HAIR = (224, 174, 148), (190, 98, 94), (70, 47, 36), (78, 58, 48)
BLUSH, LASH, INSIDE, DEEP = (219, 122, 108), (58, 36, 30), (168, 74, 72), (84, 26, 28)
WHITE, RIM, IRIS, PUPIL = (238, 234, 228), (36, 52, 58), (84, 128, 138), (12, 12, 14)
ENAMEL, GUM, TONGUE = (236, 229, 214), (206, 118, 112), (204, 104, 102)

EYE, EYE_RADIUS = np.array([3.4, 0, 5.9]), 1.95
MOUTH_Y, MOUTH_HALF_WIDTH = -7.1, 2.75


def smoothstep(low, high, x):
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def bump(p, centre, radius):
    """1 at the centre, 0 from the radius on; on both sides of the face."""
    q = np.stack([np.abs(p[:, 0]), p[:, 1], p[:, 2]], 1)
    return 1 - smoothstep(0, 1, np.linalg.norm((q - centre) / radius, axis=1))


def mixed(colour, other, weight):
    return colour + (np.array(other) - colour) * np.clip(weight, 0, 1)[:, None]


def fibres(across, along):
    """Streaks from 0 to 1 that run along one coordinate, and waver."""
    waves = (1, 0, 1), (1.73, 2, 0.7), (2.61, 4, 1.3)
    wave = sum(np.sin(across * f + a + 1.7 * np.sin(along * g)) for f, a, g in waves)
    return 0.5 + wave / 6


# ---- Skin


def brow_weight(p):
    """As eyebrow() of head_shape.cpp, which the ridge is made by."""
    x, y = np.abs(p[:, 0]), p[:, 1]
    t = np.clip((x - 1.2) / 4.3, 0, 1)
    arc = 3.0 + 0.75 * np.sin(np.pi * t**0.85) - 0.15 * t
    across = (y - arc) / (0.55 + (0.38 - 0.55) * t)
    past = np.maximum(0, np.maximum(1.3 - x, x - 5.5)) / 0.6
    strand = fibres(16 * (x - 0.55 * (y - arc)), 2 * y)
    weight = np.exp(-(across**2) * 1.5 - past**2 * 3) * (p[:, 2] > 3)
    return smoothstep(0.25, 0.75, weight + 0.35 * (strand - 0.5) * (weight > 0.05)) * 0.92


def lip_position(p):
    """How far from the line between the lips, 1 at their border, and how near a corner of the mouth."""
    across = np.clip(np.abs(p[:, 0]) / MOUTH_HALF_WIDTH, 0, 1.4)
    a = np.minimum(across, 0.999)
    line = MOUTH_Y + 0.05 - 0.24 * a**2 + 0.44 * a**4
    bow = 1 + 0.22 * np.exp(-(((a - 0.24) / 0.16) ** 2)) - 0.10 * np.exp(-((a / 0.12) ** 2))
    upper, lower = 0.86 * (1 - a**3) * bow, 1.02 * (1 - a**2) ** 0.9
    off = p[:, 1] - line
    return off / np.maximum(np.where(off > 0, upper, lower), 0.04), across


def paint_mouth(colour, p):
    height, across = lip_position(p)
    front = smoothstep(5.8, 6.6, p[:, 2])
    lips = (1 - smoothstep(0.88, 1.06, np.abs(height))) * (1 - smoothstep(0.93, 1.02, across)) * front
    colour = mixed(colour, LIP, 0.9 * lips)
    shade = np.exp(-((height / 0.16) ** 2)) * front * (1 - smoothstep(0.95, 1.05, across))
    return mixed(colour, (126, 52, 52), 0.75 * shade)


def lid_position(p):
    """Of the nearer eye: distance off its sphere, and how far from the middle of the opening, 1 at its edge."""
    d = np.stack([np.abs(p[:, 0]), p[:, 1], p[:, 2]], 1) - EYE
    x, elevation = d[:, 0] / 1.76, np.degrees(np.arctan2(d[:, 1], np.maximum(d[:, 2], 0.01)))
    elevation -= 4 * np.clip(x, -1, 1)
    y = np.where(elevation > 0, elevation / 28, elevation / 23)
    return np.linalg.norm(d, axis=1) - EYE_RADIUS, np.hypot(x, y), elevation > 0


def paint_lids(colour, p):
    off, opening, upper = lid_position(p)
    near = (1 - smoothstep(0.3, 0.6, off)) * (p[:, 2] > 5)
    colour = mixed(colour, (196, 132, 118), 0.45 * near * (1 - smoothstep(1.2, 2.1, opening)))
    colour = mixed(colour, (214, 138, 128), near * (1 - smoothstep(0.08, 0.12, off)))
    lashes = np.exp(-(((opening - 1.09) / 0.075) ** 2)) * (off > 0.1) * near
    return mixed(colour, LASH, lashes * np.where(upper, 0.95, 0.5))


def hair_weight(p):
    """Cut short: above the forehead, behind the temples and the ears, down to the nape."""
    x, y, z = np.abs(p[:, 0]), p[:, 1], p[:, 2]
    line = 7.3 - 0.035 * x**2 + 0.5 * smoothstep(3, 5.5, x)  # over the forehead
    for height, behind, before in (1.5, 1.2, 4.2), (-1.0, -1.6, 0.8), (-7.2, -4.5, -2.2):  # temples, ears, nape
        line = height + (line - height) * smoothstep(behind, before, z)
    ragged = 0.4 * (fibres(14 * x + 8 * z, 3 * y) - 0.5)
    on_ear = bump(p, (7.9, -1.0, -1.3), (1.5, 3.9, 1.9)) > 0.02
    return smoothstep(-0.45, 0.55, y - line + ragged) * np.where(on_ear, 0, 1)


def nostril_weight(p):
    """Within the rim that add_nostril_loops() of ear_nostril_loops.cpp has, and what lies deeper."""
    z = p[:, 2] - 9.5
    rim = np.hypot((np.abs(p[:, 0]) - 0.66 + 0.32 * z) / 0.34, z / 0.46)
    under = 1 - smoothstep(-3.2, -2.9, p[:, 1])
    deep = smoothstep(0, 0.35, bump(p, (0.63, -3.5, 9.7), (0.52, 0.95, 0.62)))
    return np.maximum((1 - smoothstep(0.78, 0.98, rim)) * under, deep)


def paint_skin(p):
    colour = np.tile(np.array(SKIN, float), (len(p), 1))
    colour = mixed(colour, (206, 156, 130), 0.6 * (1 - smoothstep(-11.5, -8.5, p[:, 1])))  # throat
    for weight, centre, radius in (
        (0.50, (4.4, -3.6, 6.8), (3.2, 2.6, 3.5)),  # cheeks
        (0.42, (0.3, -3.6, 10.2), (1.9, 1.7, 2.2)),  # tip of the nose
        (0.35, (8.2, -1, -1.4), (2, 4, 3)),  # ears
        (0.18, (0, -10, 8.0), (2, 1.6, 2.5)),  # chin
    ):
        colour = mixed(colour, BLUSH, weight * bump(p, centre, radius))
    colour = mixed(colour, (186, 132, 124), 0.4 * bump(p, (2.6, -1.8, 7.6), (2.2, 1.3, 2)))  # under the eyes
    colour = mixed(colour, (238, 196, 172), 0.35 * bump(p, (0, 5.2, 8), (4.5, 2.6, 5)))
    colour = mixed(colour, (88, 38, 36), 0.95 * nostril_weight(p))
    colour = mixed(colour, HAIR, 0.86 * hair_weight(p))
    colour = paint_lids(paint_mouth(colour, p), p)
    return mixed(colour, BROW, brow_weight(p))


def paint_inside(p):
    depth = 1 - smoothstep(2, 7.6, p[:, 2])
    return mixed(np.tile(np.array(INSIDE, float), (len(p), 1)), DEEP, depth)


# ---- What is in it


def paint_eye(p):
    d = np.stack([np.abs(p[:, 0]), p[:, 1], p[:, 2]], 1) - EYE
    angle = np.degrees(np.arccos(np.clip(d[:, 2] / np.linalg.norm(d, axis=1), -1, 1)))
    turn = np.arctan2(d[:, 1], d[:, 0])
    colour = mixed(np.tile(np.array(WHITE, float), (len(p), 1)), (226, 184, 176), 0.6 * smoothstep(36, 75, angle))
    colour = mixed(colour, RIM, 1 - smoothstep(22.0, 25.5, angle))
    streak = fibres(14 * turn, 0.2 * angle)
    iris = np.tile(np.array(IRIS, float), (len(p), 1))
    iris = mixed(iris, (150, 176, 160), 0.7 * streak * (1 - smoothstep(10, 19, angle)))
    iris = mixed(iris, (44, 78, 92), 0.7 * (1 - streak) * smoothstep(12, 20, angle))
    colour = colour + (iris - colour) * (1 - smoothstep(18.5, 22.5, angle))[:, None]
    return mixed(colour, PUPIL, 1 - smoothstep(8.4, 9.6, angle))


def paint_teeth(p):
    upper = p[:, 1] > MOUTH_Y - 0.48
    height = np.where(upper, p[:, 1] - (MOUTH_Y - 0.55), MOUTH_Y - 0.42 - p[:, 1])  # from the edge that bites
    angle = np.arcsin(np.clip(p[:, 0] / np.where(upper, 2.4, 2.25), -1, 1))
    tooth = np.abs(((angle / np.radians(80) + 1) * 5) % 1 - 0.5) * 2  # 1 between two teeth
    colour = mixed(np.tile(np.array(ENAMEL, float), (len(p), 1)), (196, 176, 150), 0.55 * smoothstep(0.7, 1, tooth))
    return mixed(colour, GUM, smoothstep(0.92, 1.04, height + 0.22 * tooth**2))


def paint_tongue(p):
    colour = mixed(np.tile(np.array(TONGUE, float), (len(p), 1)), (142, 58, 60), 1 - smoothstep(1.8, 5, p[:, 2]))
    return mixed(colour, (168, 72, 74), 0.6 * np.exp(-((p[:, 0] / 0.16) ** 2)) * (p[:, 1] > -8))


# ---- The picture


def read_folder(folder):
    """Rest positions, texture coordinates, corners and material of each quad, and the colours of the materials."""
    about = json.loads((folder / "dataset.json").read_text())
    load = lambda name: np.load(folder / about["rest"][name])  # noqa: E731
    materials = np.concatenate([np.full(run["polygons"], run["material"]) for run in about["meshes"][0]["materials"]])
    colours = np.array([material["base_colour"][:3] for material in about["materials"]])
    return (load("points"), load("uvs"), load("faces"), load("uv_faces"), materials), colours


def rasterize(points, uvs, faces, uv_faces, materials, size):
    """By pixel: the place on the surface, and its material, -1 where there is none."""
    place, material = np.zeros((size, size, 3)), np.full((size, size), -1)
    for face, uv_face, kind in zip(faces, uv_faces, materials):
        for corners in ((0, 1, 2), (0, 2, 3)):
            at = uvs[uv_face[list(corners)]] * size - 0.5
            low, high = np.floor(at.min(0)).astype(int), np.ceil(at.max(0)).astype(int) + 1
            x, y = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]))
            (ax, ay), (bx, by) = at[1] - at[0], at[2] - at[0]
            area = ax * by - ay * bx
            b = ((x - at[0, 0]) * by - (y - at[0, 1]) * bx) / area
            c = ((y - at[0, 1]) * ax - (x - at[0, 0]) * ay) / area
            inside = (b >= -1e-4) & (c >= -1e-4) & (b + c <= 1 + 1e-4)
            p, q, r = points[face[list(corners)]]
            x, y, b, c = (array[inside] for array in (x, y, b, c))
            place[size - 1 - y, x] = p + b[:, None] * (q - p) + c[:, None] * (r - p)
            material[size - 1 - y, x] = kind
    return place, material


def without(colour, base):
    """What of an sRGB colour is left for a texture, where a material has a linear one by which it is multiplied."""
    s = colour / 255
    linear = np.where(s <= 0.04045, s / 12.92, ((s + 0.055) / 1.055) ** 2.4) / base
    return 255 * np.clip(np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055), 0, 1)


def paint(place, material, base):
    colour = np.zeros(place.shape)
    below = np.arange(place.shape[0])[:, None] >= place.shape[0] * (1 - 0.256)  # the skin is above
    for chosen, painter in (
        ((material == 0) & ~below, paint_skin), ((material == 0) & below, paint_inside), (material == 1, paint_eye),
        (material == 2, paint_teeth), (material == 3, paint_tongue),
    ):  # fmt: skip
        colour[chosen] = without(painter(place[chosen]), base[material[chosen]])
    return colour


def spread(colour, known, steps):
    """Colours beyond the edges of charts, from the mean of the neighbours that have one."""
    for _ in range(steps):
        seen = np.pad(np.where(known[..., None], colour, 0), ((1, 1), (1, 1), (0, 0)))
        there = np.pad(known.astype(float), 1)
        total = seen[:-2, 1:-1] + seen[2:, 1:-1] + seen[1:-1, :-2] + seen[1:-1, 2:]
        count = there[:-2, 1:-1] + there[2:, 1:-1] + there[1:-1, :-2] + there[1:-1, 2:]
        fresh = ~known & (count > 0)
        colour[fresh] = total[fresh] / count[fresh][:, None]
        known = known | fresh
    colour[~known] = 255
    return colour


def averaged(colour):
    side = colour.shape[0] // FINER
    return colour.reshape(side, FINER, side, FINER, 3).mean((1, 3))


def write_png(path, colour):
    """With the filter of each row that leaves the least to say, as the PNG specification suggests."""
    pixels = np.clip(np.rint(colour / STEP) * STEP, 0, 255).astype(np.int16)
    height, width, _ = pixels.shape
    above = np.vstack([np.zeros((1, width, 3), np.int16), pixels[:-1]])
    left, corner = (np.concatenate([np.zeros((height, 1, 3), np.int16), rows[:, :-1]], 1) for rows in (pixels, above))
    estimate = left + above - corner
    away = np.stack([np.abs(estimate - other) for other in (left, above, corner)])
    paeth = np.choose(away.argmin(0), [left, above, corner])
    filtered = [pixels - by for by in (0 * pixels, left, above, (left + above) // 2, paeth)]
    data = bytearray()
    for row in range(height):
        choices = [rows[row].astype(np.uint8) for rows in filtered]
        best = min(range(5), key=lambda f: int(np.abs(choices[f].astype(np.int8).astype(int)).sum()))
        data += bytes([best]) + choices[best].tobytes()
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = (b"IHDR", header), (b"IDAT", zlib.compress(bytes(data), 9)), (b"IEND", b"")
    packed = (struct.pack(">I", len(d)) + kind + d + struct.pack(">I", zlib.crc32(kind + d)) for kind, d in chunks)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(packed))


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    mesh, base = read_folder(pathlib.Path(sys.argv[1]))
    place, material = rasterize(*mesh, SIZE * FINER)
    colour = spread(paint(place, material, base), material >= 0, MARGIN * FINER)
    write_png(pathlib.Path(sys.argv[2]), averaged(colour))


if __name__ == "__main__":
    main()
