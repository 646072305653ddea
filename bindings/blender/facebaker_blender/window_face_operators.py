"""What the buttons of a baked face do: show it, its report and the viewer."""

from __future__ import annotations

import webbrowser
from typing import Any

import bpy

from .bake_job import BakeJob
from .channels import SettingsError
from .scene_evaluator import SceneEvaluator
from .tool_command import find_tool
from .window_errors import Failing
from .window_jobs import chosen_tool, job_of, offer_package, start_watching, viewer


class FACEBAKER_OT_show(Failing, bpy.types.Operator):
    """Show the baked face beside the rig, in place of the one that is shown; it follows the same controls"""

    bl_idname, bl_label, bl_options = "facebaker.show", "Show baked face", {"UNDO"}
    part = "face"

    def work(self, context: Any) -> None:
        offer_package(context)
        from .bake_settings import load_settings
        from .error_display import show_errors
        from .face_measure import measure_face
        from .face_preview import add_preview, preview_of

        job, chosen = baked_job(context), context.scene.facebaker
        settings = load_settings(job.settings)
        preview = add_preview(context, str(job.archive), settings, replace=True)
        show_errors(context)
        state = preview_of(preview)
        if state is not None:
            with SceneEvaluator(settings, context) as evaluator:
                measure = measure_face(state.face, evaluator, drawn=20, linear=False)
            chosen.measured = "\n".join(measure.short_lines())


class FACEBAKER_OT_report(Failing, bpy.types.Operator):
    """Open the report of the bake in the browser: pictures, curves and tables of its errors, and what to do about them"""

    bl_idname, bl_label = "facebaker.report", "Open report"
    part = "face"

    def work(self, context: Any) -> None:
        page = baked_job(context).report_page
        if not page.is_file():
            raise SettingsError(f"{page}: there is no report; bake the face again")
        if not webbrowser.open(page.as_uri()):
            raise SettingsError(f"no browser was found; the report is {page}")


class FACEBAKER_OT_view(Failing, bpy.types.Operator):
    """Show the baked face in the browser, to turn, pose and play it; ends with Blender"""

    bl_idname, bl_label = "facebaker.view", "Open viewer"
    part = "face"

    def work(self, context: Any) -> None:
        archive = baked_job(context).archive
        viewer.start(find_tool(chosen_tool(context)), archive)
        start_watching()


class FACEBAKER_OT_end_viewer(Failing, bpy.types.Operator):
    """End the viewer; the page in the browser stays, but cannot be loaded again"""

    bl_idname, bl_label = "facebaker.end_viewer", "End viewer"
    part = "face"

    def work(self, _: Any) -> None:
        viewer.stop()


def baked_job(context: Any) -> BakeJob:
    """The bake of the archive that the window names. Raises SettingsError if it has not been baked."""
    job = job_of(context)
    if job is None or not job.archive.is_file():
        raise SettingsError("there is no such archive yet; bake it first")
    return job


CLASSES = (FACEBAKER_OT_show, FACEBAKER_OT_report, FACEBAKER_OT_view, FACEBAKER_OT_end_viewer)
