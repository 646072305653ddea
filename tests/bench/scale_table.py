"""The table of bench_scale.sh: scale_table.py BUILD KEEP ROW...

Prints, in Markdown, what measure_bake.py kept of each row, beside loading and poses, which are measured now, and the
exponents along each of vertices, controls and poses: the slope of a line through the logarithms of rows that differ in
nothing else."""
import json
import math
import os
import subprocess
import sys

COLUMNS = ("vertices", "controls", "poses", "recipe", "CPU s", "peak MB", "disk MB", "bytes", "load ms", "pose us",
           "times the bound", "with normals us", "worst mm", "mfm mm")
EXPONENTS = ("CPU s", "peak MB", "disk MB", "bytes", "load ms", "pose us")


def measured(build, keep, row):
    _, controls, poses, recipe, _ = row.split(",")
    with open(os.path.join(keep, row + ".json"), encoding="utf-8") as file:
        kept = json.load(file)
    face = os.path.join(keep, row + ".fbk")
    tool = os.path.join(build, "bin", "facebaker")
    speed = json.loads(subprocess.run([tool, "bench", face, "--poses", "100", "--rounds", "5", "--batch", "16", "--crowd", "2", "--json",
                                       "-"], check=True, text=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout)
    lines = {line["name"]: line for line in speed["lines"]}
    bake, errors = kept["bake"], kept["bake"]["independent"] or kept["bake"]["held_back"]
    millimetres = 10 * bake["diagonal"]  # of a rig in centimetres
    inspected = json.loads(subprocess.run([tool, "inspect", face, "--json"], check=True, text=True, stdout=subprocess.PIPE).stdout)
    return {"vertices": inspected["vertices"], "controls": int(controls), "poses": int(poses), "recipe": recipe, "CPU s": kept["cpu"],
            "peak MB": kept["peak"] / 1e6, "disk MB": kept["disk"] / 1e6, "bytes": bake["bytes"], "load ms": speed["load_us"] / 1e3,
            "pose us": speed["pose_us_warm"], "times the bound": speed["pose_us_warm"] / speed["bound_us"],
            "with normals us": lines["positions and normals"]["median_us"], "worst mm": errors["max"] * millimetres,
            "mfm mm": errors["mfm"] * millimetres}


def shown(value):
    if isinstance(value, str):
        return value
    return f"{value:,}" if isinstance(value, int) else f"{value:,.0f}" if value >= 100 else f"{value:.3g}"


def slope(points):
    """Of a line through the logarithms."""
    logs = [(math.log(x), math.log(y)) for x, y in points]
    x_mean, y_mean = (sum(axis) / len(logs) for axis in zip(*logs))
    return sum((x - x_mean) * (y - y_mean) for x, y in logs) / sum((x - x_mean) ** 2 for x, _ in logs)


def exponents(rows):
    axes = ("vertices", "controls", "poses")
    for axis in axes:
        groups = {}
        for row in rows:
            others = tuple(row[a] for a in axes if a != axis) + (row["recipe"],)
            groups.setdefault(others, {})[row[axis]] = row
        largest = max(groups.values(), key=len)
        if len(largest) < 2:
            continue
        line = [f"{figure} {slope([(x, max(row[figure], 1e-9)) for x, row in largest.items()]):.2f}" for figure in EXPONENTS]
        print(f"With {axis}, from {min(largest):,} to {max(largest):,}: " + ", ".join(line) + ".")


def main():
    build, keep, *names = sys.argv[1:]
    rows = [measured(build, keep, name) for name in names]
    print("| " + " | ".join(COLUMNS) + " |")
    print("|" + " ---: |" * len(COLUMNS))
    for row in rows:
        print("| " + " | ".join(shown(row[column]) for column in COLUMNS) + " |")
    print()
    exponents(rows)


if __name__ == "__main__":
    main()
