"""The panel that solves shapes to controls, and what its buttons do."""

from __future__ import annotations

import time
from typing import Any, List, Optional, Set

import bpy

from .solve_job import SolveJob
from .tool_command import find_tool
from .window_errors import Failing, draw_problem, fail, problem_of, set_problem
from .window_face_operators import baked_job
from .window_jobs import chosen_tool, offer_package
from .window_panel import SidebarPanel
from .window_text import draw_properties, draw_text

_INTERVAL = 0.1  # seconds
_PROPERTIES = ("frames", "place", "action", "noise", "only", "locked", "head_motion")
_running: List[SolveJob] = []  # at most one


class FACEBAKER_OT_solve(Failing, bpy.types.Operator):
    """Find the controls of the baked face for the shape of the active mesh, which has the same vertices, and key them on the
    rig"""

    bl_idname, bl_label, bl_options = "facebaker.solve", "Solve to controls", {"UNDO"}
    part = "solve"
    _timer: Any = None

    def work(self, context: Any) -> None:
        """Of a script: waits for the end."""
        job = _begin(context)
        try:
            while not job.advance(_INTERVAL):
                time.sleep(0 if job.reading else _INTERVAL)
            _finish(context, job)
        finally:
            end_solve()

    def invoke(self, context: Any, _event: Any) -> Set[str]:
        """Of the button: frames are read and the tool runs while the window stays alive."""
        if bpy.app.background:
            return self.execute(context)
        set_problem(self.part, "")
        try:
            _begin(context)
        except Exception as error:
            return fail(self, context, error)
        self._timer = context.window_manager.event_timer_add(_INTERVAL, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Any, event: Any) -> Set[str]:
        """While frames are read nothing may be edited; Esc stops."""
        job = _running[0] if _running else None
        if job is None:
            return self._ended(context, {"CANCELLED"})
        goes_on = {"RUNNING_MODAL"} if job.reading else {"PASS_THROUGH"}
        if event.type == "ESC" and job.reading:
            job.stop()
        elif event.type != "TIMER":
            return goes_on
        for area in context.screen.areas if context.screen else ():
            area.tag_redraw()
        try:
            if not job.advance(_INTERVAL):
                return goes_on
            if not job.stopped:
                _finish(context, job)
        except Exception as error:
            return self._ended(context, fail(self, context, error))
        return self._ended(context, {"CANCELLED"} if job.stopped else {"FINISHED"})

    def cancel(self, context: Any) -> None:
        """Called by Blender when another file is opened."""
        self._ended(context, {"CANCELLED"})

    def _ended(self, context: Any, how: Set[str]) -> Set[str]:
        context.window_manager.event_timer_remove(self._timer)
        end_solve()
        return how


class FACEBAKER_OT_stop_solve(Failing, bpy.types.Operator):
    """Stop the solve; no keys are written"""

    bl_idname, bl_label = "facebaker.stop_solve", "Stop"
    part = "solve"

    def work(self, _: Any) -> None:
        for job in _running:
            job.stop()


class FACEBAKER_PT_solve(SidebarPanel, bpy.types.Panel):
    bl_label, bl_idname = "Solve to controls", "FACEBAKER_PT_solve"

    def draw(self, context: Any) -> None:
        layout, chosen, job = self.layout, context.scene.facebaker.solve, running_solve()
        if job is not None:
            for line in job.lines:
                draw_text(layout, context, line)
            layout.operator("facebaker.stop_solve", icon="CANCEL")
            return
        draw_problem(layout, context, problem_of("solve"))
        draw_properties(layout, context, chosen, _PROPERTIES)
        frames = chosen.request(context.scene).frames
        if frames:
            draw_text(layout, context, f"Frames {frames[0]} to {frames[1]}")
        layout.operator("facebaker.solve", icon="KEY_HLT")
        for line in chosen.found.splitlines():
            draw_text(layout, context, line)


def running_solve() -> Optional[SolveJob]:
    """The solve that runs, None if none does."""
    return _running[0] if _running else None


def end_solve() -> None:
    """Ends the solve that runs, if one does."""
    while _running:
        _running.pop().close()


def _begin(context: Any) -> SolveJob:
    if _running:
        raise RuntimeError("a solve is running")
    offer_package(context)
    job = baked_job(context)
    request = context.scene.facebaker.solve.request(context.scene)
    solve = SolveJob(context, job.archive, job.settings, request, find_tool(chosen_tool(context)))
    _running.append(solve)
    return solve


def _finish(context: Any, job: SolveJob) -> None:
    context.scene.facebaker.solve.found = "\n".join(job.finish(context))


CLASSES = (FACEBAKER_OT_solve, FACEBAKER_OT_stop_solve, FACEBAKER_PT_solve)
