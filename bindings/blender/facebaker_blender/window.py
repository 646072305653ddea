"""Registers the add-on's classes and handlers with Blender."""

from __future__ import annotations

import bpy

from . import face_preview, window_operators, window_panel, window_properties
from .channels import SettingsError


def register() -> None:
    """Called when the add-on is enabled."""
    for kind in (*window_properties.CLASSES, *window_operators.CLASSES, *window_panel.CLASSES):
        bpy.utils.register_class(kind)
    bpy.types.Scene.facebaker = bpy.props.PointerProperty(type=window_properties.FACEBAKER_PG_scene)
    try:
        window_operators.offer_package(bpy.context)
    except SettingsError as error:
        print(f"FaceBaker: {error}")  # operators say it again when they need it
    face_preview.add_handlers()


def unregister() -> None:
    """Called when the add-on is disabled."""
    face_preview.remove_handlers()
    if bpy.app.timers.is_registered(window_operators.watch):
        bpy.app.timers.unregister(window_operators.watch)
    del bpy.types.Scene.facebaker
    for kind in reversed((*window_properties.CLASSES, *window_operators.CLASSES, *window_panel.CLASSES)):
        bpy.utils.unregister_class(kind)
