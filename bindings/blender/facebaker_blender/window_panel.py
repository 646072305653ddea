"""The panels in the 3D view's sidebar."""

from __future__ import annotations

from typing import Any, List

import bpy

from .bake_job import BakeJob
from .bake_result import result_lines, warnings_of
from .window_controls import draw_controls
from .window_errors import draw_problem, problem_of
from .window_jobs import job_of, start_watching, viewer
from .window_text import TickedRows, draw_properties, draw_text

_INTERRUPTED = "interrupted"  # as the tool begins what it says after Stop


class FACEBAKER_UL_shots(TickedRows, bpy.types.UIList):
    """Actions; what the selected one is for is shown below."""


class SidebarPanel:
    """Of the add-on's tab."""

    bl_space_type, bl_region_type, bl_category = "VIEW_3D", "UI", "FaceBaker"


class FACEBAKER_PT_rig(SidebarPanel, bpy.types.Panel):
    bl_label, bl_idname = "Rig", "FACEBAKER_PT_rig"

    def draw(self, context: Any) -> None:
        layout, chosen = self.layout, context.scene.facebaker
        draw_problem(layout, context, problem_of("rig"))
        layout.operator("facebaker.choose")
        for item in [*chosen.meshes, *chosen.armatures]:
            layout.prop(item, "object", text="")
        draw_properties(
            layout, context, chosen, ("bones", "collections", "selected", "scales", "modifiers", "driven_joints")
        )
        layout.operator("facebaker.find")
        for line in chosen.found.splitlines():
            draw_text(layout, context, line, "INFO")
        if chosen.controls:
            draw_controls(layout, context, chosen)
        if chosen.shots:
            layout.template_list("FACEBAKER_UL_shots", "", chosen, "shots", chosen, "shot", rows=2)
            if 0 <= chosen.shot < len(chosen.shots):
                shot = chosen.shots[chosen.shot]
                box = layout.box()
                draw_text(box, context, f"{shot.name}, frames {shot.first} to {shot.last}", boxed=True)
                draw_properties(box, context, shot, ("split",))


class FACEBAKER_PT_bake(SidebarPanel, bpy.types.Panel):
    bl_label, bl_idname = "Bake", "FACEBAKER_PT_bake"

    def draw(self, context: Any) -> None:
        layout, chosen, job = self.layout, context.scene.facebaker, job_of(context)
        running = job is not None and job.process.running
        if job is not None:
            _draw_state(layout, context, job, running)
        draw_problem(layout, context, problem_of("bake"))
        if running:
            start_watching()
            layout.operator("facebaker.stop", icon="CANCEL")
            return
        draw_properties(layout, context, chosen, ("character", "out", "recipe", "use", "rig_budget", "workers"))
        if job is None:
            draw_text(layout, context, "Name a file that ends in .fbk; save the scene first if its path begins with //", "INFO")
            return
        layout.operator("facebaker.bake", icon="RENDER_STILL").go_on = False
        if job.process.unfinished:
            layout.operator("facebaker.bake", text="Continue the bake").go_on = True


def _draw_state(layout: Any, context: Any, job: BakeJob, running: bool) -> None:
    """How far a bake is, what it came to, or why it failed."""
    if running:
        for index, line in enumerate(job.process.progress.lines):
            draw_text(layout, context, line, "TIME" if index else "RENDER_ANIMATION")
        return
    failure, document = job.process.failure, job.process.document
    if failure.startswith(_INTERRUPTED):
        draw_text(layout, context, "The bake was stopped. What is done is kept.", "INFO")
    else:
        draw_problem(layout, context, failure)
    if document is not None:
        column = layout.column()
        for line in result_lines(document):
            draw_text(column, context, line)
        _draw_warnings(column, context, warnings_of(document))


def _draw_warnings(layout: Any, context: Any, warnings: List[str]) -> None:
    """How many there are, and behind an arrow all of each."""
    if not warnings:
        return
    chosen = context.scene.facebaker
    arrow = "DISCLOSURE_TRI_DOWN" if chosen.show_warnings else "DISCLOSURE_TRI_RIGHT"
    text = f"{len(warnings)} warning" + ("s" if len(warnings) > 1 else "")
    row = layout.row()
    row.alignment = "LEFT"
    row.prop(chosen, "show_warnings", text=text, icon=arrow, emboss=False)
    for warning in warnings if chosen.show_warnings else ():
        draw_text(layout, context, warning)


class FACEBAKER_PT_preview(SidebarPanel, bpy.types.Panel):
    bl_label, bl_idname = "Baked face", "FACEBAKER_PT_preview"

    def draw(self, context: Any) -> None:
        layout, chosen, job = self.layout, context.scene.facebaker, job_of(context)
        draw_problem(layout, context, problem_of("face"))
        layout.operator("facebaker.show")
        if job is not None and job.archive.is_file():
            _draw_pages(layout, context, job)
        draw_properties(layout, context, chosen, ("colours", "red_from"))
        _draw_shown(layout, context)
        for line in chosen.measured.splitlines():
            draw_text(layout, context, line)


def _draw_pages(layout: Any, context: Any, job: BakeJob) -> None:
    """The report of a face, and the viewer."""
    if job.report_page.is_file():
        layout.operator("facebaker.report", icon="URL")
    layout.operator("facebaker.view", icon="URL")
    if viewer.running:
        draw_text(layout, context, f"The viewer runs: {viewer.address}" if viewer.address else "The viewer starts")
        if viewer.address:
            layout.operator("facebaker.copy", text="Copy address", icon="COPYDOWN").text = viewer.address
        layout.operator("facebaker.end_viewer", icon="CANCEL")


def _draw_shown(layout: Any, context: Any) -> None:
    """Of the faces that the scene shows: the time of a pose, and how far it is off."""
    from .error_display import previews_in
    from .face_preview import COLOURS, shown_preview

    for preview in previews_in(context.scene):
        state = shown_preview(preview)
        if state is None:
            continue
        draw_text(layout, context, f"{preview.name}: {1000 * state.face_ms:.0f} microseconds a pose")
        draw_problem(layout, context, state.problem)
        if preview.get(COLOURS) and not state.problem:
            draw_text(layout, context, f"Worst vertex of this pose: off by {state.max_length}")


CLASSES = (FACEBAKER_UL_shots, FACEBAKER_PT_rig, FACEBAKER_PT_bake, FACEBAKER_PT_preview)
