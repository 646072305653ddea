"""Text and properties in the sidebar, none of them cut at its width."""

from __future__ import annotations

from typing import Any, Sequence

import blf
import bpy

from .text_wrap import wrapped

USUAL_WIDTH = 220  # of a sidebar in Blender 3.4, the narrowest that is usual, at scale 1
# At scale 1, from pictures of Blender 3.4: tabs and margins of panels; those of labels and of names; a
# box; an icon.
_TABS_AND_MARGINS = 55
_LABEL_MARGINS = 8
_NAME_MARGINS = 5
_BOX = 12
_ICON = 20
_NAME_SHARE = 0.4  # of a row that Blender splits into name and value


class TickedRows:
    """Of a list in the panel: a tick and a name in each row."""

    def draw_item(
        self, _context: Any, layout: Any, _data: Any, item: Any, _icon: Any, _active_data: Any, _active: Any, _index: Any
    ) -> None:
        row = layout.row(align=True)
        row.prop(item, "use", text="")
        row.label(text=item.name)


def row_width(context: Any) -> float:
    """The width of a row of a panel, in pixels at scale 1."""
    region = getattr(context, "region", None)
    if region is None or region.type != "UI":
        return USUAL_WIDTH - _TABS_AND_MARGINS
    view = region.view2d  # a sidebar may be zoomed
    width = view.region_to_view(region.width, 0)[0] - view.region_to_view(0, 0)[0]
    return max(float(width) / ui_scale(context) - _TABS_AND_MARGINS, 60.0)


def ui_scale(context: Any) -> float:
    return float(context.preferences.system.ui_scale) or 1.0  # 0 without a window


def measured(text: str) -> float:
    """The width of a text in the window's font, in pixels at scale 1."""
    preferences = bpy.context.preferences
    scale = ui_scale(bpy.context)
    blf.size(0, preferences.ui_styles[0].widget.points * scale)
    return float(blf.dimensions(0, text)[0]) / scale


def draw_text(layout: Any, context: Any, text: str, icon: str = "NONE", boxed: bool = False) -> None:
    """All of a text, in as many rows as it takes. boxed: the layout is within a box."""
    column = layout.column(align=True)
    column.scale_y = 0.8
    width = row_width(context) - _LABEL_MARGINS - (_BOX if boxed else 0) - (_ICON if icon != "NONE" else 0)
    for index, line in enumerate(wrapped(text, width, measured)):
        column.label(text=line, icon=icon if index == 0 else "BLANK1" if icon != "NONE" else "NONE")


def draw_properties(layout: Any, context: Any, owner: Any, names: Sequence[str]) -> None:
    """Properties with their names in full: before the value, or above it where there is not room."""
    column = layout.column()
    room = _NAME_SHARE * row_width(context) - _NAME_MARGINS
    for name in names:
        entry = owner.bl_rna.properties[name]
        above = entry.type != "BOOLEAN" and measured(entry.name) > room
        row = column.column(align=True)
        if above:
            row.label(text=f"{entry.name}:")
        row.use_property_split, row.use_property_decorate = not above and entry.type != "BOOLEAN", False
        if above:
            row.prop(owner, name, text="")
        else:
            row.prop(owner, name)
