"""Shaded pictures of a face, one colour a vertex, and PNG files. NumPy only."""
import struct
import zlib

import numpy as np

BACKGROUND = np.array([0.985, 0.985, 0.98])
SKIN = np.array([0.80, 0.81, 0.83])
# Of the report pages' plots, on a light ground.
PALETTE = np.array([[0xc2, 0x41, 0x0c], [0x25, 0x63, 0xa8], [0x15, 0x80, 0x3d], [0x93, 0x33, 0xa8], [0xd9, 0xa4, 0x1c],
                    [0x0e, 0xa4, 0xb0], [0xe0, 0x4f, 0x8f], [0x6a, 0x70, 0x7a], [0xf0, 0x8a, 0x4b], [0x7f, 0xb8, 0x5a]]) / 255


def triangles_of(sizes, corners):
    """Polygons as fans from their first corners: (triangles, 3)."""
    sizes = np.asarray(sizes, int)
    firsts = np.cumsum(sizes) - sizes
    fans = [(corners[f], corners[f + k], corners[f + k + 1]) for f, n in zip(firsts, sizes) for k in range(1, n - 1)]
    return np.array(fans)


def normals_of(points, triangles):
    a, b, c = (points[triangles[:, i]] for i in range(3))
    face = np.cross(b - a, c - a)
    normals = np.zeros_like(points)
    for i in range(3):
        np.add.at(normals, triangles[:, i], face)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)


def draw_head(points, triangles, colours, width, height, low, high):
    """The face from the front, orthographic: height x width x 3, 0 to 1. `low` and `high` are the y shown at the lower and
    upper edge; x is centred."""
    normals = normals_of(points.astype(float), triangles)
    light = np.array([0.35, 0.45, 0.82])
    shade = 0.45 + 0.55 * np.clip(normals @ (light / np.linalg.norm(light)), 0, 1)
    shaded = colours * shade[:, None]
    scale = height / (high - low)
    screen = np.stack([points[:, 0] * scale + width / 2, (high - points[:, 1]) * scale, points[:, 2]], axis=1)
    image, depth = np.tile(BACKGROUND, (height, width, 1)), np.full((height, width), -np.inf)
    for triangle in triangles:
        p = screen[triangle]
        area = (p[1, 0] - p[0, 0]) * (p[2, 1] - p[0, 1]) - (p[2, 0] - p[0, 0]) * (p[1, 1] - p[0, 1])
        if area >= 0:  # seen from behind
            continue
        x0, y0 = np.maximum(np.floor(p[:, :2].min(axis=0)).astype(int), 0)
        x1, y1 = np.minimum(np.ceil(p[:, :2].max(axis=0)).astype(int) + 1, (width, height))
        if x0 >= x1 or y0 >= y1:
            continue
        x, y = np.meshgrid(np.arange(x0, x1) + 0.5, np.arange(y0, y1) + 0.5)
        w = np.stack([((p[(i + 1) % 3, 0] - x) * (p[(i + 2) % 3, 1] - y) - (p[(i + 2) % 3, 0] - x) * (p[(i + 1) % 3, 1] - y)) / area
                      for i in range(3)])
        z = np.tensordot(p[:, 2], w, 1)
        seen = (w >= -1e-9).all(axis=0) & (z > depth[y0:y1, x0:x1])
        depth[y0:y1, x0:x1][seen] = z[seen]
        image[y0:y1, x0:x1][seen] = np.tensordot(shaded[triangle].T, w, 1).transpose(1, 2, 0)[seen]
    return image


def draw_smooth(points, triangles, colours, width, height, low, high):
    """draw_head without jagged edges: drawn twice as large and averaged."""
    large = draw_head(points, triangles, colours, 2 * width, 2 * height, low, high)
    return large.reshape(height, 2, width, 2, 3).mean(axis=(1, 3))


def heat(values, largest):
    """Skin where a value is 0, through orange to dark red at the largest."""
    share = np.clip(values / largest, 0, 1)[:, None]
    stops = np.array([SKIN, [0.98, 0.75, 0.30], [0.85, 0.25, 0.10], [0.40, 0.02, 0.15]])
    at = share * 3
    i = np.minimum(at.astype(int), 2)[:, 0]
    return stops[i] * (1 - (at - i[:, None])) + stops[i + 1] * (at - i[:, None])


def write_png(path, image):
    """8 bits a channel, 64 levels each, so that files stay small."""
    height, width, _ = image.shape
    pixels = np.clip(np.round(np.round(image * 63) * 255 / 63), 0, 255).astype(np.uint8)
    up = pixels.astype(np.int16)
    up[1:] -= pixels[:-1]
    rows = b"".join(b"\2" + (row % 256).astype(np.uint8).tobytes() for row in up)
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)) +
                   chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))
