"""Writes recordings as dataset folders, which facebaker bakes and measures on."""

from __future__ import annotations

import json
import os
import pathlib
from typing import Any, Dict, Union

import numpy as np

from ._arrays import padded_polygons
from ._fields import character_fields
from ._rig import Rig


def save_dataset(rig: Rig, folder: Union[str, "os.PathLike[str]"]) -> None:
    """Writes a recording, a Rig without evaluate whose clips have positions, as a dataset folder: dataset.json, written
    last, and NumPy arrays beside it. The folder is made if it is missing; files in it are replaced. Raises ValueError if
    the rig is no recording, or has no clips."""
    if rig.evaluate is not None:
        raise ValueError(f'"{rig.name}" is live: facebaker.sample records its poses')
    if not rig.clips:
        raise ValueError(f'"{rig.name}" has no clips to write')
    place = pathlib.Path(folder)
    place.mkdir(parents=True, exist_ok=True)

    def save(name: str, array: Any) -> str:
        np.save(place / f"{name}.npy", array)
        return f"{name}.npy"

    rest = {
        "points": save("rest", rig.rest_positions),
        "faces": save("faces", padded_polygons(rig.polygon_sizes, rig.polygon_corners)),
    }
    if len(rig.uvs):
        rest["uvs"] = save("uvs", rig.uvs)
        rest["uv_faces"] = save("uv_faces", padded_polygons(rig.polygon_sizes, rig.uv_corners))
    images = []
    for number, image in enumerate(rig.images):
        images.append({"file": f"image{number}"})
        (place / images[-1]["file"]).write_bytes(image.data)
    index: Dict[str, Any] = {
        "format": "facebaker-dataset",
        "version": 1,
        **character_fields(rig, images),
        "rest": rest,
        "clips": [],
    }
    if rig.skin:
        joints = save("skin.joints", rig.skin.joints.astype(np.int32))
        index["skin"] = {"joints": joints, "weights": save("skin.weights", rig.skin.weights)}
    for number, clip in enumerate(rig.clips):
        entry = {"name": clip.name, "kind": clip.kind, "split": clip.split, "fps": clip.fps}
        entry["controls"] = save(f"clip{number}.controls", clip.controls)
        entry["points"] = save(f"clip{number}.points", clip.positions)
        if rig.channels:
            entry["channels"] = save(f"clip{number}.channels", clip.channels)
        index["clips"].append(entry)
    (place / "dataset.json").write_text(json.dumps(index, indent=1) + "\n", encoding="utf-8")
