"""Serves the rig of a scene to FaceBaker, in a Blender without a window that FaceBaker starts:

    blender -b scene.blend -P rig_child.py -- settings.json

The file beside the settings that is named like them with .version, if it is there, holds the version of the rig."""

from __future__ import annotations

import pathlib
import sys
from typing import Sequence


def main(arguments: Sequence[str]) -> int:
    """What the script does: its exit code."""
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
    from facebaker_blender.bake_settings import load_settings
    from facebaker_blender.tool_command import add_package_path

    if len(arguments) != 1:
        print("usage: blender -b scene.blend -P rig_child.py -- settings.json", file=sys.stderr)
        return 2
    add_package_path()
    from facebaker.serve import serve, serve_failure

    from facebaker_blender.scene_evaluator import SceneEvaluator
    from facebaker_blender.scene_rig import scene_rig

    try:
        settings = load_settings(arguments[0])
        evaluator = SceneEvaluator(settings)
        evaluator.__enter__()
        stamp = pathlib.Path(arguments[0]).with_suffix(".version")
        version = f"{settings.deformation} {stamp.read_text().strip() if stamp.is_file() else ''}"
        rig = scene_rig(evaluator, version)
    except Exception as error:
        serve_failure(error)
        return 1
    serve(rig)
    return 0  # this process ends with its copy of the scene: nothing is left to restore


if __name__ == "__main__":
    words = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    sys.exit(main(words))
