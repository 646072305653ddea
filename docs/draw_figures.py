#!/usr/bin/env python3
"""Draws the pictures of the pages.

    draw_figures.py [--diagrams] BUILD WORK [PICTURES]

BUILD is a build folder with the tool and libfacebaker. WORK keeps what is baked, so that a second run is quick: the face
of samples/quickstart.sh with its report (minutes), and poses of the sample rig. PICTURES is docs/pictures by default. With
--diagrams, only the pictures that need no face; BUILD and WORK are not looked at. Everything is seeded: the same build
draws the same pictures. Needs Python 3 and NumPy.
"""
import json
import os
import re
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.join(HERE, "figures"), os.path.join(HERE, "..", "bindings", "python")]

import diagrams  # noqa: E402
from svg import Axes, Svg  # noqa: E402


def tool(build, *arguments):
    command = [os.path.join(build, "bin", "facebaker"), *map(str, arguments)]
    return subprocess.run(command, check=True, text=True, stdout=subprocess.PIPE).stdout


# ---- From the report page


def training_curves(report, path):
    """The plot of the report page, as a picture of its own."""
    with open(os.path.join(report, "index.html"), encoding="utf-8") as file:
        page = file.read()
    section = page[page.index("Training curve</h3>"):]
    width, height, body = re.search(r'<svg viewBox="0 0 (\d+) (\d+)"[^>]*>(.*?)</svg>', section, re.S).groups()
    svg = Svg(int(width), int(height), "Training of the regions' networks")
    svg.add("<style>text { font-size: 12px; }</style>")
    body = re.sub(r'style="stroke:var\(--c(\d)\)(;[^"]*)?"',
                  lambda m: f'class="curve s{m[1]}"' + (' stroke-dasharray="2 4"' if m[2] and "dash" in m[2] else ""), body)
    body = re.sub(r'<text (.*?)font-weight="600"', r'<text \1class="ink bold"', body)
    body = re.sub(r'(<text (?:(?!class=)[^>])*)>', r'\1 class="ink">', body).replace('class="faint"', 'class="small"')
    svg.add(re.sub(r"<title>.*?</title>", "", body, flags=re.S))
    with open(path, "w", encoding="utf-8") as file:
        file.write(svg.page())


# ---- From the face


def random_poses(face, count):
    """Poses with a quarter of the controls anywhere in their ranges."""
    import numpy as np

    random = np.random.default_rng(1)
    low, high = face.ranges.T
    on = random.random((count, face.control_count)) < 0.25
    return np.where(on, random.uniform(low, high, on.shape), face.rest_controls).astype(np.float32)


def region_labels(face, outputs):
    """The region that moves each vertex most in some random poses, -1 where none does; and the region of each column.
    `outputs`: of each region's network."""
    import numpy as np

    first = face.coefficient_count - sum(outputs)
    of_column = np.concatenate([np.full(first, -1), np.repeat(np.arange(len(outputs)), outputs)])
    squares = np.mean([face.coefficients(pose) ** 2 for pose in random_poses(face, 64)], axis=0)
    moved = np.zeros((len(outputs), 3 * face.vertex_count))
    for rows, columns, values in face.basis():
        for column, displacement in zip(columns, values):
            if of_column[column] >= 0:
                moved[of_column[column], rows] += squares[column] * displacement ** 2
    moved = moved.reshape(len(outputs), -1, 3).sum(axis=2)
    labels = np.empty(face.vertex_count, int)
    labels[np.asarray(face.vertex_order)] = np.where(moved.max(axis=0) > 0, moved.argmax(axis=0), -1)
    return labels, of_column


def regions_picture(face, triangles, labels, path):
    import numpy as np
    import raster

    colours = np.where(labels[:, None] < 0, raster.SKIN, 0.25 * raster.SKIN + 0.75 * raster.PALETTE[labels % 10])
    raster.write_png(path, raster.draw_smooth(face.rest_positions, triangles, colours, 400, 440, *height_of(face)))


def height_of(face):
    """What of the head the pictures show."""
    y = face.rest_positions[:, 1]
    return y.min() + 0.2 * (y.max() - y.min()), y.max() + 0.03 * (y.max() - y.min())


def row_blocks_picture(face, of_column, path):
    """Row blocks down, columns of the basis across: where a column has values."""
    import numpy as np
    import raster

    blocks = list(face.basis())
    across, down = 4, max(1, 360 // len(blocks))  # columns of a pixel, pixels of a block
    image = np.ones((len(blocks) * down, -(-face.coefficient_count // across), 3)) * raster.BACKGROUND
    for b, (_, columns, _) in enumerate(blocks):
        for column in columns:
            region = of_column[column]
            image[b * down:(b + 1) * down, column // across] = (
                raster.PALETTE[7] if region < 0 else raster.PALETTE[region % 10])
    raster.write_png(path, image)


def correctives_picture(build, work, face, triangles, path):
    """Two controls alone, and what they do together beyond the sum, in the true rig."""
    import numpy as np
    import raster

    first, second = "jaw_open", "smile_L"
    poses = np.stack([face.pose(p) for p in ({first: 0.8}, {second: 1.0}, {first: 0.8, second: 1.0})])
    np.save(os.path.join(work, "pair.npy"), poses)
    folder = os.path.join(work, "pair")
    if not os.path.exists(folder):
        tool(build, "sample", "sample", "--out", folder, "--poses", 1, "--no-shots", "--clip",
             "pair=" + os.path.join(work, "pair.npy"))
    points = read_points(folder, "pair")
    alone = points - face.rest_positions
    panels = []
    for displacement in (alone[0], alone[1], alone[2] - alone[0] - alone[1]):
        distance = np.linalg.norm(displacement, axis=1)
        panels.append(raster.draw_smooth(face.rest_positions + displacement, triangles,
                                         raster.heat(distance, distance.max()), 230, 270, *height_of(face)))
    raster.write_png(path, np.concatenate(panels, axis=1))
    return [float(np.linalg.norm(d, axis=1).max() / face.diagonal) for d in (alone[0], alone[1], alone[2] - alone[0] - alone[1])]


# ---- From datasets


def clips_of(folder):
    with open(os.path.join(folder, "dataset.json"), encoding="utf-8") as file:
        return json.load(file)["clips"]


def read_points(folder, name):
    import glob
    import numpy as np

    clip = next(c for c in clips_of(folder) if c["name"] == name)
    path = os.path.join(folder, clip["points"])
    shards = [path] if os.path.exists(path) else sorted(glob.glob(path.replace(".points.npy", ".*.points.npy")))
    return np.concatenate([np.load(shard) for shard in shards])


def moved_counts(folder, rest):
    """Of each new pose, how many controls are away from rest."""
    import numpy as np

    poses = [np.load(os.path.join(folder, clip["controls"])) for clip in clips_of(folder) if clip.get("split") == "train"]
    return np.sort((np.concatenate(poses) != rest).sum(axis=1))


def poses_plot(build, work, face, path):
    """How many controls training poses move, for both mixes, and the rig's own test shots."""
    import numpy as np

    svg = Svg(620, 270, "Controls away from rest in training poses")
    axes = Axes(svg, 56, 34, 540, 180, (1, face.control_count), (0, 100), log_x=True)
    axes.ticks([1, 3, 10, 30, 100, 300], [0, 25, 50, 75, 100])
    axes.labels("controls away from rest", "", "share of poses with no more than so many controls, %")
    shots = os.path.join(work, "shots")
    if not os.path.exists(shots):
        tool(build, "sample", "sample", "--out", shots, "--poses", 1)
    curves = []
    for mix in ("dense", "paper"):
        folder = os.path.join(work, "mix_" + mix)
        if not os.path.exists(folder):
            tool(build, "sample", "sample", "--out", folder, "--poses", 2000, "--no-shots", "--mix", mix)
        curves.append((f"--mix {mix}", moved_counts(folder, face.rest_controls)))
    test = [np.load(os.path.join(shots, c["controls"])) for c in clips_of(shots) if c.get("split") == "test"]
    curves.append(("frames of the test shots", np.sort((np.concatenate(test) != face.rest_controls).sum(axis=1))))
    for i, (name, counts) in enumerate(curves):
        shares = 100 * (np.arange(len(counts)) + 1) / len(counts)
        keep = [k for k in range(len(counts)) if k + 1 == len(counts) or counts[k + 1] != counts[k]]
        axes.curve([max(1, int(counts[k])) for k in keep], [shares[k] for k in keep], i + 1, dotted=i == 2)
        svg.add(f'<line class="curve s{i + 1}" x1="{70 + 180 * i}" x2="{90 + 180 * i}" y1="257" y2="257"/>')
        svg.text(96 + 180 * i, 261, name, "start", "small")
    write(path, svg.page())


# ---- All


def write(path, text):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def draw_face_pictures(build, work, pictures):
    os.environ["FACEBAKER_LIBRARY"] = os.path.join(build, "lib", "libfacebaker.so")
    import facebaker
    import raster

    os.makedirs(work, exist_ok=True)
    archive, report = os.path.join(work, "face.fbk"), os.path.join(work, "report")
    if not os.path.exists(archive):
        tool(build, "bake", "sample", "--out", archive, "--recipe", "compact", "--use", "variant", "--poses", 8000,
             "--report", report)
    face = facebaker.load(archive)
    network = json.loads(tool(build, "inspect", archive, "--json"))["network"]
    labels, of_column = region_labels(face, [region["layers"][-1]["outputs"] for region in network["regions"]])
    triangles = raster.triangles_of(face.polygon_sizes, face.polygon_corners)
    training_curves(report, os.path.join(pictures, "training.svg"))
    shutil.copyfile(os.path.join(report, "error_map.png"), os.path.join(pictures, "error_map.png"))
    regions_picture(face, triangles, labels, os.path.join(pictures, "regions.png"))
    row_blocks_picture(face, of_column, os.path.join(pictures, "row_blocks.png"))
    print("largest distances:", correctives_picture(build, work, face, triangles, os.path.join(pictures, "correctives.png")))
    poses_plot(build, work, face, os.path.join(pictures, "poses.svg"))


def main(arguments):
    only_diagrams = arguments[:1] == ["--diagrams"]
    arguments = arguments[only_diagrams:]
    if len(arguments) not in (2, 3):
        print(__doc__, file=sys.stderr)
        return 2
    pictures = arguments[2] if len(arguments) == 3 else os.path.join(HERE, "pictures")
    os.makedirs(pictures, exist_ok=True)
    for name, draw in diagrams.DIAGRAMS.items():
        write(os.path.join(pictures, name), draw())
    if not only_diagrams:
        draw_face_pictures(os.path.abspath(arguments[0]), os.path.abspath(arguments[1]), pictures)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
