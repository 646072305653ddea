"""Which meshes and armatures of a scene are the face, where nobody says."""

from __future__ import annotations

from typing import Any, Dict, List, Sequence

from .channels import SettingsError
from .scene_channels import find_object


def chosen_meshes(context: Any, names: Sequence[str]) -> List[Any]:
    """The mesh objects of these names; without names all that are visible and have polygons, but for baked faces,
    the shapes that bones are drawn with and the objects that modifiers of the others use. Raises SettingsError."""
    if names:
        found = [find_object(name) for name in names]
        for scene_object in found:
            if scene_object.type != "MESH":
                raise SettingsError(f'"{scene_object.name}" is of type {scene_object.type}, no mesh')
        return found
    shown = [
        scene_object
        for scene_object in context.view_layer.objects
        if scene_object.type == "MESH" and scene_object.visible_get() and len(scene_object.data.polygons)
        and "facebaker_archive" not in scene_object.keys()
    ]  # fmt: skip
    helpers = _bone_shapes(context) | _modifier_objects(shown)
    found = [scene_object for scene_object in shown if scene_object.name not in helpers]
    if not found:
        raise SettingsError("no mesh is visible; name the meshes")
    return found


def _bone_shapes(context: Any) -> "set[str]":
    armatures = [scene_object for scene_object in context.view_layer.objects if scene_object.pose]
    return {bone.custom_shape.name for armature in armatures for bone in armature.pose.bones if bone.custom_shape}


def _modifier_objects(meshes: Sequence[Any]) -> "set[str]":
    used = set()
    for mesh in meshes:
        for modifier in mesh.modifiers:
            for attribute in "object", "target", "auxiliary_target":
                other = getattr(modifier, attribute, None)
                if other is not None:
                    used.add(other.name)
    return used


def chosen_armatures(meshes: Sequence[Any], names: Sequence[str]) -> List[Any]:
    """The armatures of these names; without names those that deform or carry the meshes, or drive their shape keys.
    Raises SettingsError."""
    if names:
        found = [find_object(name) for name in names]
        for scene_object in found:
            if scene_object.type != "ARMATURE":
                raise SettingsError(f'"{scene_object.name}" is of type {scene_object.type}, no armature')
        return found
    armatures: Dict[str, Any] = {}
    for mesh in meshes:
        for candidate in [*_parents(mesh), *_deformers(mesh), *_drivers(mesh), *_drivers(mesh.data.shape_keys)]:
            if candidate.type == "ARMATURE":
                armatures.setdefault(candidate.name, candidate)
    return list(armatures.values())


def _parents(scene_object: Any) -> List[Any]:
    found = []
    while scene_object.parent:
        scene_object = scene_object.parent
        found.append(scene_object)
    return found


def _deformers(mesh: Any) -> List[Any]:
    """Objects of modifiers, and what moves those in turn: a lattice hangs on a bone."""
    found: List[Any] = []
    for modifier in mesh.modifiers:
        other = getattr(modifier, "object", None) or getattr(modifier, "target", None)
        if other is not None:
            found += [other, *_parents(other)]
            found += [c.target for c in other.constraints if getattr(c, "target", None) is not None]
            found += [*_drivers(other), *_drivers(getattr(other.data, "shape_keys", None))]
    return found


def _drivers(block: Any) -> List[Any]:
    """Objects that the drivers of an ID look at."""
    animation = getattr(block, "animation_data", None)
    if animation is None:
        return []
    return [
        target.id
        for curve in animation.drivers
        for variable in curve.driver.variables
        for target in variable.targets
        if target.id is not None and hasattr(target.id, "type")
    ]
