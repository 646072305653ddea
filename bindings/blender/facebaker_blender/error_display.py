"""Shows or hides how far the baked faces of a scene are from their rigs: their colours, and viewports that show these."""

from __future__ import annotations

from typing import Any, Dict, List

from .face_preview import ARCHIVE, COLOURS, preview_of, show_colours, update_previews
from .shown_lengths import millimetres_of

_BY_ATTRIBUTE = "VERTEX"  # as Blender calls it in solid shading, which shows no material
_USUAL = "MATERIAL"
_before: Dict[int, str] = {}  # by address, what viewports coloured surfaces by


def show_errors(context: Any) -> None:
    """As the window's choice is. Raises SettingsError if a mesh of a face's rig is gone."""
    chosen = context.scene.facebaker
    for preview in previews_in(context.scene):
        show_colours(context, preview, chosen.colours, share_of(preview, chosen.red_from))
    context.view_layer.update()
    update_previews(context.scene, context.evaluated_depsgraph_get(), again=True)
    _set_viewports(context, chosen.colours)


def previews_in(scene: Any) -> List[Any]:
    """The objects of baked faces."""
    return [scene_object for scene_object in scene.objects if ARCHIVE in scene_object.keys()]


def share_of(preview: Any, millimetres: float) -> float:
    """The share of a face's diagonal that is so many millimetres."""
    state = preview_of(preview)
    unit = state and millimetres_of(state.face.units)
    return millimetres / (unit * float(state.face.diagonal)) if state and unit else 1e-3


def _set_viewports(context: Any, colours: bool) -> None:
    """Solid shading shows vertices' colours while there are errors to be seen; afterwards what it showed before."""
    wanted = colours and any(preview.get(COLOURS) for preview in previews_in(context.scene))
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type != "VIEW_3D":
                continue
            shading = area.spaces.active.shading
            place = area.spaces.active.as_pointer()
            if wanted and shading.color_type != _BY_ATTRIBUTE:
                _before[place] = shading.color_type
                shading.color_type = _BY_ATTRIBUTE
            elif not wanted and shading.color_type == _BY_ATTRIBUTE:
                shading.color_type = _before.pop(place, _USUAL)
