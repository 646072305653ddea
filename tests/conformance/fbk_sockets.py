"""Frames that follow the surface: FORMAT.md, "sockets", and EVALUATION.md, "Frames". For fbk_read.py."""
import math

import numpy as np

from fbk_bytes import require


def read_sockets(c, face):
    count = c.u32()
    require(count > 0, "sockets: none")
    mesh = np.repeat(np.arange(len(face.meshes)), [m[1] for m in face.meshes])
    for _ in range(count):
        name, n = c.string(), c.u32()
        vertices, weights, frame = c.array("u4", n), c.array("f4", n), c.array("f4", 12)
        require(name and name not in (s[0] for s in face.sockets), f"sockets: name {name!r}")
        require(n >= 3 and (vertices < face.vertices).all(), f"sockets: vertices of {name}")
        require(len(mesh) == 0 or len(set(mesh[vertices])) == 1, f"sockets: {name} has vertices of two meshes")
        require(np.isfinite(weights).all() and (weights > 0).all(), f"sockets: weights of {name}")
        require(np.isfinite(frame).all(), f"sockets: frame of {name}")
        face.sockets.append((name, vertices.tolist(), [float(w) for w in weights], frame))
    c.end()


def centre(points, weights):
    sums = [0.0, 0.0, 0.0]
    for point, weight in zip(points, weights):
        sums = [s + weight * x for s, x in zip(sums, point)]
    total = 0.0
    for weight in weights:
        total += weight
    return [s / total for s in sums]


def root(values):
    squares = 0.0
    for value in values:
        squares += value * value
    return math.sqrt(squares)


def best_rotation(s):
    d = 2 * root([value for row in s for value in row])
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = s
    m = [
        [xx + yy + zz + d, yz - zy, zx - xz, xy - yx],
        [yz - zy, xx - yy - zz + d, xy + yx, zx + xz],
        [zx - xz, xy + yx, yy - xx - zz + d, yz + zy],
        [xy - yx, zx + xz, yz + zy, zz - xx - yy + d],
    ]
    for step in range(25):
        trace = m[0][0] + m[1][1] + m[2][2] + m[3][3]
        if not trace > 0:
            return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        m = [[value / trace for value in row] for row in m]
        if step < 24:
            m = [
                [m[i][0] * m[0][j] + m[i][1] * m[1][j] + m[i][2] * m[2][j] + m[i][3] * m[3][j] for j in range(4)]
                for i in range(4)
            ]
    row = m[max(range(4), key=lambda i: (m[i][i], -i))]
    length = root(row)
    w, x, y, z = (value / length for value in row)
    return [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]


def posed_frame(socket, rest, posed):
    _, vertices, weights, frame = socket
    p, q = rest[vertices].astype(float).tolist(), posed[vertices].astype(float).tolist()
    at_rest, now = centre(p, weights), centre(q, weights)
    s = [[0.0] * 3 for _ in range(3)]
    for pi, qi, w in zip(p, q, weights):
        for a in range(3):
            for b in range(3):
                s[a][b] += w * (pi[a] - at_rest[a]) * (qi[b] - now[b])
    r = best_rotation(s)
    matrix = frame.reshape(3, 4).astype(float)
    result = np.zeros((3, 4), np.float32)
    for column in range(4):
        axis = matrix[:, column].tolist()
        if column == 3:
            axis = [value - centre for value, centre in zip(axis, at_rest)]
        turned = [row[0] * axis[0] + row[1] * axis[1] + row[2] * axis[2] for row in r]
        result[:, column] = [t + n for t, n in zip(turned, now)] if column == 3 else turned
    return result.ravel() if np.isfinite(result).all() else frame


def posed_frames(face, positions):
    rest, posed = face.rest.reshape(-1, 3), positions.reshape(-1, 3)
    return np.array([posed_frame(socket, rest, posed) for socket in face.sockets], np.float32).reshape(-1)
