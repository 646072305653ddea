"""Recipes side by side on several rigs, each baked as its users would: one line a face.

    recipe_table.py RECIPE,... SOURCE... [-- OPTION...]

bakes every SOURCE by every RECIPE with `facebaker bake` (on PATH) and these options, and prints a table: how far the
face is off on clips that nothing was trained on, largest vertex first, and what it takes. All distances are over the
diagonal but the first, in mm. Driven joints are kept by the recipes that have them."""

import json
import pathlib
import subprocess
import sys
import tempfile

MILLIMETRES = {"mm": 1, "cm": 10, "dm": 100, "m": 1000, "inch": 25.4}


def baked(source, recipe, options, folder):
    out = str(folder / "face.fbk")
    command = ["facebaker", "bake", source, "--recipe", recipe, "--out", out, "--json", "--no-thumbnail", *options]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode != 0:
        sys.exit(f"{' '.join(command)}: {run.stderr.strip().splitlines()[-1]}")
    return json.loads(run.stdout)


def line(source, recipe, figures):
    errors = figures["independent"] or figures["held_back"]
    scale = MILLIMETRES.get(figures["units"], float("nan")) * figures["diagonal"]
    return [
        pathlib.Path(source).stem.removeprefix("librig_"), recipe, f"{errors['max'] * scale:.2g}", f"{errors['max']:.1e}",
        f"{errors['p99fm']:.1e}", f"{errors['mfm']:.1e}", f"{errors['mse']:.1e}", f"{figures['bytes'] / 1000:,.0f}",
        f"{figures['rig_calls']:,}", f"{figures['train_seconds']:.0f}",
    ]  # fmt: skip


def main():
    words = sys.argv[1:]
    options = words[words.index("--") + 1 :] if "--" in words else []
    recipes, *sources = words[: words.index("--")] if "--" in words else words
    print("| rig | recipe | worst vertex, mm | worst vertex | of 99 in 100 frames | on average | mse | kB | rig calls | training, s |")
    print("| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |", flush=True)
    for source in sources:
        for recipe in recipes.split(","):
            with tempfile.TemporaryDirectory() as folder:
                figures = baked(source, recipe, options, pathlib.Path(folder))
            print("| " + " | ".join(line(source, recipe, figures)) + " |", flush=True)


if __name__ == "__main__":
    main()
