"""Saves and renders a scene with the baked face beside its rig, and its errors as colours beside that."""

from __future__ import annotations

import pathlib
from typing import Any, Optional

import bpy
import numpy as np

from .action_shots import shot_values
from .bake_settings import BakeSettings, Path
from .face_preview import add_preview, update_previews
from .preview_object import BESIDE
from .scene_channels import SceneChannels

ERROR_SCALE = 1e-3  # of the diagonal: red in pictures; a third of a millimetre on a head


def save_preview(archive: Path, settings: BakeSettings, blend: Optional[Path], picture: Optional[Path]) -> None:
    """Adds previews to the open file, in the frame of its shots that has most controls at work. blend: where to save it,
    relative to the working folder; picture: where to render it. Either may be None."""
    pose_from_shots(settings)
    add_preview(bpy.context, str(archive), settings, 1)
    coloured = add_preview(bpy.context, str(archive), settings, 2, True, ERROR_SCALE)
    bpy.context.view_layer.update()
    update_previews(bpy.context.scene, bpy.context.evaluated_depsgraph_get(), again=True)
    if blend:
        bpy.ops.wm.save_as_mainfile(filepath=str(pathlib.Path(blend).resolve()), copy=True, check_existing=False)
    if picture:
        render_beside(settings, coloured, picture)


def pose_from_shots(settings: BakeSettings) -> None:
    """Sets the controls as in the frame of the test shots in which they are furthest from rest."""
    rest = np.array([control.rest for control in settings.controls], np.float32)
    spans = np.array([control.span for control in settings.controls], np.float32)
    best, pose = 0.0, rest
    for shot in settings.shots:
        for values in shot_values(settings, shot):
            distance = float(np.abs((values - rest) / spans).sum())
            if distance > best:
                best, pose = distance, values
    SceneChannels(settings.controls).write(pose)
    bpy.context.view_layer.update()


def render_beside(settings: BakeSettings, coloured: Any, path: Path) -> None:
    """Renders rig, baked face and errors in a row, on the CPU. What it adds to the scene stays there."""
    scene = bpy.context.scene
    corners = np.array([coloured.matrix_world @ vertex.co for vertex in coloured.data.vertices])
    low, high = corners.min(0), corners.max(0)
    width, height = high[0] - low[0], high[2] - low[2]
    camera = bpy.data.objects.new("FaceBaker camera", bpy.data.cameras.new("FaceBaker camera"))
    scene.collection.objects.link(camera)
    step = BESIDE * width  # the middle one of three faces is one step to the left of the coloured one
    camera.location = ((low[0] + high[0]) / 2 - step, low[1] - 10 * height, (low[2] + high[2]) / 2)
    camera.rotation_euler = (np.pi / 2, 0, 0)
    camera.data.type, camera.data.ortho_scale = "ORTHO", 2 * step + 1.1 * width
    camera.data.clip_end = 100 * height + 1000
    scene.camera = camera
    for turn, strength in (((0.9, 0, 0.4), 2.5), ((1.2, 0, -0.9), 1.2)):
        lamp = bpy.data.objects.new("FaceBaker sun", bpy.data.lights.new("FaceBaker sun", "SUN"))
        lamp.rotation_euler, lamp.data.energy = turn, strength
        lamp.data.angle, lamp.data.use_shadow = 0, False
        if hasattr(getattr(lamp.data, "cycles", None), "cast_shadow"):  # before Blender 4
            lamp.data.cycles.cast_shadow = False
        scene.collection.objects.link(lamp)
    render = scene.render
    render.engine = "CYCLES"
    # Direct light without shadows: nothing to be sampled but edges, so there is no noise.
    scene.cycles.device, scene.cycles.samples, scene.cycles.use_denoising = "CPU", 8, False
    scene.cycles.max_bounces = 0
    render.resolution_x, render.resolution_percentage = 900, 100
    render.resolution_y = int(900 * 1.1 * height / camera.data.ortho_scale)
    render.image_settings.compression, render.dither_intensity = 100, 0
    render.image_settings.file_format, render.filepath = "PNG", str(pathlib.Path(path).resolve())
    scene.world = scene.world or bpy.data.worlds.new("FaceBaker world")
    scene.view_settings.view_transform = "Standard"
    with only_rendered([*settings.meshes, *[o.name for o in scene.objects if "facebaker_archive" in o.keys()]]):
        bpy.ops.render.render(write_still=True)


class only_rendered:
    """Renders no other meshes and curves than these, within a `with`."""

    def __init__(self, names: Any) -> None:
        self._names = set(names)

    def __enter__(self) -> None:
        self._hidden = []
        for scene_object in bpy.context.scene.objects:
            shown = scene_object.type in ("MESH", "CURVE", "SURFACE", "META", "FONT") and not scene_object.hide_render
            if shown and scene_object.name not in self._names:
                scene_object.hide_render = True
                self._hidden.append(scene_object)

    def __exit__(self, *_: Any) -> None:
        for scene_object in self._hidden:
            scene_object.hide_render = False
