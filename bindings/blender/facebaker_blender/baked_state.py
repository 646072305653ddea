"""The meshes of a rig as they were baked: for errors, whatever the viewport and renders show of them. And the modifiers that
were switched off for the bake, which the baked face keeps."""

from __future__ import annotations

from typing import Any, List, Sequence, Tuple

import numpy as np

from .bake_settings import BakeSettings
from .mesh_modifiers import count_changers
from .node_inputs import copy_inputs
from .scene_channels import find_object

_PREFIX = "FaceBaker "  # of modifiers that have the baked meshes evaluated
_HOLDER = "facebaker_baked_"  # of properties that have them saved, which modifiers do not
# They follow the pose: a modifier before one of them cannot come after the face.
_FOLLOWING = {
    "ARMATURE", "LATTICE", "MESH_DEFORM", "SURFACE_DEFORM", "CURVE", "HOOK", "WARP", "SHRINKWRAP", "CAST", "SIMPLE_DEFORM",
    "NODES",
}  # fmt: skip
_LEVELS = {"SUBSURF": "levels", "MULTIRES": "levels"}


def switched_off(context: Any, settings: BakeSettings, mesh_object: Any) -> List[Any]:
    """The modifiers that a bake with these settings switches off."""
    return count_changers(context, mesh_object) if settings.modifiers == "off" else []


def add_baked_meshes(context: Any, settings: BakeSettings, preview: Any) -> None:
    """Has the dependency graph of every scene with the preview evaluate the meshes as they were baked: copies in no
    collection, which a modifier of the preview refers to and which nothing shows."""
    remove_baked_meshes(preview)
    for index, name in enumerate(settings.meshes):
        source = find_object(name)
        dropped = {modifier.name for modifier in switched_off(context, settings, source)}
        copy = source.copy()
        copy.name = f"{name} as baked"
        for modifier in list(copy.modifiers):
            if modifier.name in dropped or not modifier.show_viewport:
                copy.modifiers.remove(modifier)
                continue
            modifier.show_render = True
            if modifier.type in _LEVELS:
                modifier.render_levels = getattr(modifier, _LEVELS[modifier.type])
        copy.hide_viewport = copy.hide_render = False
        link = preview.modifiers.new(_PREFIX + name, "DATA_TRANSFER")  # of no data: it changes nothing
        link.object = preview[f"{_HOLDER}{index}"] = copy
        link.show_expanded = False


def remove_baked_meshes(preview: Any) -> None:
    """The reverse of add_baked_meshes()."""
    import bpy

    for modifier in [m for m in preview.modifiers if m.type == "DATA_TRANSFER" and m.name.startswith(_PREFIX)]:
        preview.modifiers.remove(modifier)
    for key in [key for key in preview.keys() if key.startswith(_HOLDER)]:
        copy = preview[key]
        del preview[key]
        if copy is not None and copy.users == 0:
            bpy.data.objects.remove(copy)


def baked_meshes(preview: Any) -> List[Any]:
    """The copies, in the order of the face's meshes; empty where there are none."""
    found = {int(key[len(_HOLDER) :]): preview[key] for key in preview.keys() if key.startswith(_HOLDER)}
    return [found[index] for index in sorted(found) if found[index] is not None]


def keep_modifiers(context: Any, settings: BakeSettings, preview: Any) -> None:
    """Gives the preview the modifiers that were switched off and come after everything that follows the pose, such as a
    subdivision. The edges of meshes that have none of them are creased, so that they keep their shape."""
    kept: List[Any] = []
    creases: List[Any] = []
    first = 0
    for name in settings.meshes:
        mesh_object = find_object(name)
        own = _trailing(mesh_object, switched_off(context, settings, mesh_object))
        kept += [modifier for modifier in own if modifier.type not in {other.type for other in kept}]
        creases.append(_creases(mesh_object.data, first, own))
        first += len(mesh_object.data.vertices)
    for modifier in kept:
        _copy_modifier(modifier, preview)
    if any(modifier.type in _LEVELS for modifier in kept):
        _set_creases(preview.data, np.concatenate([edges for edges, _ in creases]), np.concatenate([c for _, c in creases]))


def _trailing(mesh_object: Any, dropped: Sequence[Any]) -> List[Any]:
    """Those of the dropped modifiers that come after the last one that follows the pose."""
    names = {modifier.name for modifier in dropped}
    last = -1
    for place, modifier in enumerate(mesh_object.modifiers):
        if modifier.show_viewport and modifier.type in _FOLLOWING and modifier.name not in names:
            last = place
    return [m for place, m in enumerate(mesh_object.modifiers) if place > last and m.name in names]


def _copy_modifier(modifier: Any, preview: Any) -> None:
    copy = preview.modifiers.new(modifier.name, modifier.type)
    for entry in modifier.bl_rna.properties:
        if not entry.is_readonly and entry.identifier not in ("name", "type"):
            setattr(copy, entry.identifier, getattr(modifier, entry.identifier))
    if modifier.type == "NODES":
        copy_inputs(modifier, copy)


def _creases(mesh: Any, first: int, own: Sequence[Any]) -> Tuple[Any, Any]:
    """Pairs of vertices, counted from `first`, and how sharp the edge between them is: 1 for meshes without a subdivision."""
    edges = np.empty(2 * len(mesh.edges), np.int32)
    mesh.edges.foreach_get("vertices", edges)
    values = np.zeros(len(mesh.edges), np.float32)
    if not any(modifier.type in _LEVELS for modifier in own):
        values[:] = 1
    elif hasattr(mesh, "attributes") and "crease_edge" in mesh.attributes:
        mesh.attributes["crease_edge"].data.foreach_get("value", values)
    elif len(mesh.edges) and hasattr(mesh.edges[0], "crease"):  # before Blender 4
        mesh.edges.foreach_get("crease", values)
    return edges.reshape(-1, 2) + first, values


def _set_creases(mesh: Any, edges: Any, values: Any) -> None:
    """Creases the edges of a mesh, whatever their order."""
    if not values.any():
        return
    known = {tuple(sorted(pair)): value for pair, value in zip(edges.tolist(), values.tolist())}
    own = np.empty(2 * len(mesh.edges), np.int32)
    mesh.edges.foreach_get("vertices", own)
    creases = np.array([known.get(tuple(sorted(pair)), 0.0) for pair in own.reshape(-1, 2).tolist()], np.float32)
    if hasattr(mesh.edges[0], "crease"):  # before Blender 4
        mesh.edges.foreach_set("crease", creases)
        return
    attribute = mesh.attributes.get("crease_edge") or mesh.attributes.new("crease_edge", "FLOAT", "EDGE")
    attribute.data.foreach_set("value", creases)
