"""The panel in the 3D view's sidebar."""

from __future__ import annotations

from typing import Any

import bpy

from .window_operators import job_of, result_lines, start_watching


class FACEBAKER_UL_controls(bpy.types.UIList):
    """Controls; searched by name."""

    def draw_item(
        self, _context: Any, layout: Any, _data: Any, item: Any, _icon: Any, _active_data: Any, _active: Any, _index: Any
    ) -> None:
        row = layout.row(align=True)
        row.prop(item, "use", text="")
        row.label(text=item.name)


class FACEBAKER_UL_shots(bpy.types.UIList):
    """Actions, and what they are for."""

    def draw_item(
        self, _context: Any, layout: Any, _data: Any, item: Any, _icon: Any, _active_data: Any, _active: Any, _index: Any
    ) -> None:
        row = layout.row(align=True)
        row.prop(item, "use", text="")
        row.label(text=f"{item.name}  {item.first}-{item.last}")
        row.prop(item, "split", text="")


class _SidebarPanel:
    bl_space_type, bl_region_type, bl_category = "VIEW_3D", "UI", "FaceBaker"


class FACEBAKER_PT_rig(_SidebarPanel, bpy.types.Panel):
    bl_label, bl_idname = "Rig", "FACEBAKER_PT_rig"

    def draw(self, context: Any) -> None:
        layout, chosen = self.layout, context.scene.facebaker
        layout.operator("facebaker.choose")
        for item in [*chosen.meshes, *chosen.armatures]:
            layout.prop(item, "object", text="")
        column = layout.column(align=True)
        for name in "bones", "collections", "selected", "scales", "modifiers", "driven_joints":
            column.prop(chosen, name)
        layout.operator("facebaker.find")
        if chosen.controls:
            used = sum(item.use for item in chosen.controls)
            layout.label(text=f"{used} of {len(chosen.controls)} controls")
            layout.template_list("FACEBAKER_UL_controls", "", chosen, "controls", chosen, "control", rows=6)
            self._draw_control(chosen)
        if chosen.shots:
            layout.template_list("FACEBAKER_UL_shots", "", chosen, "shots", chosen, "shot", rows=2)


    def _draw_control(self, chosen: Any) -> None:
        """The group and the range of the control that is chosen in the list."""
        if 0 <= chosen.control < len(chosen.controls):
            item = chosen.controls[chosen.control]
            column = self.layout.column(align=True)
            column.prop(item, "group")
            row = column.row(align=True)
            for name in "minimum", "rest", "maximum":
                row.prop(item, name)


class FACEBAKER_PT_bake(_SidebarPanel, bpy.types.Panel):
    bl_label, bl_idname = "Bake", "FACEBAKER_PT_bake"

    def draw(self, context: Any) -> None:
        layout, chosen, job = self.layout, context.scene.facebaker, job_of(context)
        column = layout.column(align=True)
        for name in "character", "out", "recipe", "use", "rig_budget", "workers":
            column.prop(chosen, name)
        if job is None:
            layout.label(text="Name a .fbk file, in a saved file", icon="INFO")
            return
        if job.process.running:
            start_watching()
            layout.label(text=job.process.progress.text, icon="RENDER_ANIMATION")
            layout.operator("facebaker.stop", icon="CANCEL")
            return
        layout.operator("facebaker.bake", icon="RENDER_STILL").go_on = False
        if job.process.unfinished:
            layout.operator("facebaker.bake", text="Go on with the interrupted bake").go_on = True
        for line in result_lines(job):
            layout.label(text=line)


class FACEBAKER_PT_preview(_SidebarPanel, bpy.types.Panel):
    bl_label, bl_idname = "Baked face", "FACEBAKER_PT_preview"

    def draw(self, context: Any) -> None:
        from .face_preview import ARCHIVE, COLOURS, shown_preview

        layout, chosen = self.layout, context.scene.facebaker
        layout.operator("facebaker.show")
        row = layout.row(align=True)
        row.prop(chosen, "colours")
        row.prop(chosen, "scale")
        layout.operator("facebaker.colours")
        for scene_object in context.scene.objects:
            state = shown_preview(scene_object) if ARCHIVE in scene_object.keys() else None
            if state is None:
                continue
            layout.label(text=f"{scene_object.name}: {1000 * state.face_ms:.0f} us a pose")
            if state.problem:
                layout.label(text=state.problem, icon="ERROR")
            elif scene_object.get(COLOURS):
                layout.label(text=f"largest error: {state.max_error:.1e}")
        column = layout.column(align=True)
        for line in chosen.measured.splitlines():
            column.label(text=line)


CLASSES = (FACEBAKER_UL_controls, FACEBAKER_UL_shots, FACEBAKER_PT_rig, FACEBAKER_PT_bake, FACEBAKER_PT_preview)
