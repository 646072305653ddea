"""Modifiers that change the number of vertices."""

from __future__ import annotations

from typing import Any, List

from .channels import SettingsError

def _vertices(context: Any, mesh_object: Any) -> int:
    context.view_layer.update()
    evaluated = mesh_object.evaluated_get(context.evaluated_depsgraph_get())
    return len(evaluated.data.vertices)


def count_changers(context: Any, mesh_object: Any) -> List[Any]:
    """The modifiers that, as they are shown in the viewport, change the number of vertices. Found by switching all off and
    on again one after the other, which leaves them as they were."""
    shown = [modifier for modifier in mesh_object.modifiers if modifier.show_viewport]
    if _vertices(context, mesh_object) == len(mesh_object.data.vertices):
        return []
    found = []
    try:
        for modifier in shown:
            modifier.show_viewport = False
        count = _vertices(context, mesh_object)
        for modifier in shown:
            modifier.show_viewport = True
            now = _vertices(context, mesh_object)
            if now != count:
                found.append(modifier)
            count = now
    finally:
        for modifier in shown:
            modifier.show_viewport = True
        context.view_layer.update()
    return found


def refuse_count_changers(context: Any, mesh_object: Any) -> None:
    """Raises SettingsError that names the modifiers that change the number of vertices."""
    changers = count_changers(context, mesh_object)
    if changers:
        names = ", ".join(f'"{modifier.name}" ({modifier.type})' for modifier in changers)
        before = len(mesh_object.data.vertices)
        raise SettingsError(
            f'"{mesh_object.name}": modifiers change the number of vertices, {before} without them: {names}. Choose '
            '"apply" to bake the mesh as they make it, or "off" to switch them off during the bake'
        )
