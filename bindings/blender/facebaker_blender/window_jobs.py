"""What the window has running: bakes and the viewer; and where it finds the tool and the Python package."""

from __future__ import annotations

import pathlib
from typing import Any, Dict, Optional

import bpy

from .bake_job import BakeJob
from .channels import SettingsError
from .tool_command import add_package_path
from .viewer_process import ViewerProcess
from .window_errors import set_problem
from .window_properties import preferences

viewer = ViewerProcess()
_jobs: Dict[str, BakeJob] = {}
_INTERVAL = 0.5  # seconds


def offer_package(context: Any) -> None:
    """Makes the package facebaker importable, from where the preferences say. Raises SettingsError."""
    chosen = preferences(context)
    add_package_path(bpy.path.abspath(chosen.package) if chosen else "")


def chosen_tool(context: Any) -> str:
    """The program that the preferences name, "" if they name none."""
    chosen = preferences(context)
    return str(bpy.path.abspath(chosen.tool)) if chosen else ""


def job_of(context: Any) -> Optional[BakeJob]:
    """The bake of the archive that the window names, None if the name is none."""
    path = bpy.path.abspath(context.scene.facebaker.out)
    if not path or not pathlib.Path(path).is_absolute():
        return None
    if path not in _jobs:
        try:
            _jobs[path] = BakeJob(path)
        except SettingsError:
            return None
    return _jobs[path]


def start_watching() -> None:
    """Has Blender call watch() while something runs; also for a bake that an earlier session started."""
    if not bpy.app.timers.is_registered(watch):
        bpy.app.timers.register(watch, first_interval=_INTERVAL)


def end_watching() -> None:
    """Of the add-on when it is disabled: bakes go on, the viewer ends."""
    if bpy.app.timers.is_registered(watch):
        bpy.app.timers.unregister(watch)
    viewer.stop()


def watch() -> Optional[float]:
    """Called by Blender while bakes or the viewer run: reads how far they have come and has the panel drawn again."""
    running = [job for job in _jobs.values() if job.process.poll()]
    for job in _jobs.values():
        job.tidy()
    if viewer.failure:
        set_problem("face", viewer.failure)
        viewer.stop()
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()
    return _INTERVAL if running or viewer.running else None
