"""Files of other programs as scenes, read by Blender's own importers."""

from __future__ import annotations

import hashlib
import pathlib
from typing import Any

import bpy

from .channels import SettingsError

# Of a suffix, operators of importers: the first that this Blender has is called. Some are add-ons.
_IMPORTERS = {
    ".fbx": ("import_scene.fbx", "wm.fbx_import"),
    ".usd": ("wm.usd_import",),
    ".usda": ("wm.usd_import",),
    ".usdc": ("wm.usd_import",),
    ".usdz": ("wm.usd_import",),
    ".abc": ("wm.alembic_import",),
    ".dae": ("wm.collada_import",),
    ".glb": ("import_scene.gltf",),
    ".gltf": ("import_scene.gltf",),
    ".vrm": ("import_scene.vrm",),
}


def import_scene(path: pathlib.Path, folder: pathlib.Path) -> None:
    """Makes the file the open scene, in place of what was open; kept in `folder` as a .blend, which is opened instead when
    the same file is imported again, so that an interrupted bake goes on. Raises SettingsError where the file is missing,
    no importer is there, or it fails or gives no mesh."""
    importer = _importer(path)
    if not path.is_file():
        raise SettingsError(f"{path}: no such file")
    kept = folder / f"imported.{hashlib.sha256(path.read_bytes()).hexdigest()[:16]}.blend"
    if kept.is_file():
        bpy.ops.wm.open_mainfile(filepath=str(kept), load_ui=False)
        return
    for scene_object in list(bpy.data.objects):
        bpy.data.objects.remove(scene_object)
    for action in list(bpy.data.actions):
        bpy.data.actions.remove(action)
    try:
        importer(filepath=str(path.resolve()))
    except RuntimeError as error:  # what an operator reports
        reason = str(error).strip().splitlines()[-1]  # behind a traceback, where an add-on fails
        raise SettingsError(f"{path}: Blender's importer fails: {reason}") from None
    if not any(scene_object.type == "MESH" for scene_object in bpy.data.objects):
        raise SettingsError(f"{path}: no mesh is in what Blender imports of it")
    folder.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(kept))


def _importer(path: pathlib.Path) -> Any:
    names = _IMPORTERS.get(path.suffix.lower())
    if names is None:
        raise SettingsError(f"{path}: --import reads {', '.join(sorted(_IMPORTERS))}")
    for name in names:
        module, operator = name.split(".")
        if operator in dir(getattr(bpy.ops, module)):
            return getattr(getattr(bpy.ops, module), operator)
    raise SettingsError(f"{path}: this Blender has no importer of {path.suffix} (bpy.ops.{names[0]}); enable its add-on")
