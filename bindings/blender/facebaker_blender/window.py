"""Registers the add-on's classes and handlers with Blender."""

from __future__ import annotations

import bpy

from . import (
    face_preview, window_controls, window_errors, window_face_operators, window_jobs, window_operators, window_panel,
    window_properties, window_solve,
)  # fmt: skip
from .channels import SettingsError

_CLASSES = (
    *window_properties.CLASSES, *window_errors.CLASSES, *window_controls.CLASSES, *window_operators.CLASSES,
    *window_face_operators.CLASSES, *window_panel.CLASSES, *window_solve.CLASSES,
)  # fmt: skip


def register() -> None:
    """Called when the add-on is enabled."""
    for kind in _CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Scene.facebaker = bpy.props.PointerProperty(type=window_properties.FACEBAKER_PG_scene)
    try:
        window_jobs.offer_package(bpy.context)
    except SettingsError as error:
        print(f"FaceBaker: {error}")  # operators say it again when they need it
    face_preview.add_handlers()


def unregister() -> None:
    """Called when the add-on is disabled."""
    face_preview.remove_handlers()
    window_jobs.end_watching()
    window_solve.end_solve()
    del bpy.types.Scene.facebaker
    for kind in reversed(_CLASSES):
        bpy.utils.unregister_class(kind)
