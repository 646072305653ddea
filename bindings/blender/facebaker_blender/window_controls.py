# mypy: disable-error-code="valid-type"
"""The list of controls in the panel: by group, each with a tick."""

from __future__ import annotations

from typing import Any, List, Set, Tuple

import bpy

from .control_rows import UNGROUPED, grouped_controls, opened_groups, opened_text, shown_controls
from .window_text import TickedRows, draw_text

ROWS = 7  # of an unfolded group, before its list scrolls


class FACEBAKER_UL_controls(TickedRows, bpy.types.UIList):
    """The controls of one group, which is the list's name; those that are searched for."""

    def filter_items(self, _context: Any, data: Any, _name: str) -> Tuple[List[int], List[int]]:
        group, name = _group_of(self.list_id), self.filter_name.lower()
        wanted = {item.name for item in shown_controls(data.controls, data.search) if item.group == group}
        shows = [c.name in wanted and (name in c.name.lower()) != self.use_filter_invert for c in data.controls]
        # Blender inverts what it is given.
        flags = [self.bitflag_filter_item if shown != self.use_filter_invert else 0 for shown in shows]
        order = bpy.types.UI_UL_list.sort_items_by_name(data.controls) if self.use_filter_sort_alpha else []
        return flags, order


def _list_id(group: str) -> str:
    return f"group {group}"


def _group_of(list_id: str) -> str:
    return list_id[len(_list_id("")) :]


class FACEBAKER_OT_tick(bpy.types.Operator):
    """Tick or untick these controls: only what is ticked is baked"""

    bl_idname, bl_label, bl_options = "facebaker.tick", "Tick controls", {"UNDO", "INTERNAL"}
    use: bpy.props.BoolProperty()
    group: bpy.props.StringProperty()
    every: bpy.props.BoolProperty(description="Of all groups")

    def execute(self, context: Any) -> Set[str]:
        chosen = context.scene.facebaker
        for item in shown_controls(chosen.controls, chosen.search):
            if self.every or item.group == self.group:
                item.use = self.use
        return {"FINISHED"}


class FACEBAKER_OT_fold(bpy.types.Operator):
    """Show or hide the controls of this group"""

    bl_idname, bl_label, bl_options = "facebaker.fold", "Fold", {"INTERNAL"}
    group: bpy.props.StringProperty()

    def execute(self, context: Any) -> Set[str]:
        chosen = context.scene.facebaker
        chosen.opened = opened_text(opened_groups(chosen.opened) ^ {self.group})
        return {"FINISHED"}


def draw_controls(layout: Any, context: Any, chosen: Any) -> None:
    """All controls, and the range of the one that is selected."""
    used = sum(item.use for item in chosen.controls)
    draw_text(layout, context, f"{used} of {len(chosen.controls)} controls are ticked")
    row = layout.row(align=True)
    for text, use in (("All", True), ("None", False)):
        button = row.operator("facebaker.tick", text=text)
        button.use, button.every = use, True
    layout.prop(chosen, "search", text="", icon="VIEWZOOM")
    groups = grouped_controls(shown_controls(chosen.controls, chosen.search))
    opened = opened_groups(chosen.opened)
    column = layout.column(align=True)
    for group, items in groups.items():
        unfolded = group in opened or bool(chosen.search) or len(groups) == 1
        _draw_heading(column.row(align=True), group, items, unfolded)
        if unfolded:
            rows = min(len(items), ROWS)
            column.template_list(
                FACEBAKER_UL_controls.__name__, _list_id(group), chosen, "controls", chosen, "control", rows=rows, maxrows=rows
            )
            if 0 <= chosen.control < len(chosen.controls) and chosen.controls[chosen.control] in items:
                _draw_range(column, context, chosen.controls[chosen.control])


def _draw_heading(row: Any, group: str, items: List[Any], unfolded: bool) -> None:
    """A fold, a tick, the name, and how many are ticked; the tick has a bar where only some are."""
    used = sum(item.use for item in items)
    arrow = "DISCLOSURE_TRI_DOWN" if unfolded else "DISCLOSURE_TRI_RIGHT"
    row.operator("facebaker.fold", text="", icon=arrow, emboss=False).group = group
    icon = "CHECKBOX_HLT" if used == len(items) else "REMOVE" if used else "CHECKBOX_DEHLT"
    tick = row.operator("facebaker.tick", text="", icon=icon, emboss=False)
    tick.group, tick.use, tick.every = group, used < len(items), False
    row.label(text=group or UNGROUPED)
    count = row.row()
    count.alignment = "RIGHT"
    count.label(text=f"{used} of {len(items)}")


def _draw_range(layout: Any, context: Any, item: Any) -> None:
    """The group and the range of the control that is selected."""
    box = layout.box()
    draw_text(box, context, item.name, boxed=True)
    column = box.column()
    column.use_property_split, column.use_property_decorate = True, False
    column.prop(item, "group")
    column = column.column(align=True)
    for name in item.range_names:
        column.prop(item, name)


CLASSES = (FACEBAKER_UL_controls, FACEBAKER_OT_tick, FACEBAKER_OT_fold)
