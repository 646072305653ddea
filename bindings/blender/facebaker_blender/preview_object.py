"""The object of a baked face: its mesh, materials and place beside the rig."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List

import bpy
import numpy as np

from .bake_settings import BakeSettings
from .scene_channels import find_object

if TYPE_CHECKING:
    import facebaker

ATTRIBUTE = "facebaker_error"
_MATERIAL = "FaceBaker error"
BESIDE = 1.15  # widths of the face from one to the next


def make_object(face: "facebaker.Face", settings: BakeSettings, place: int, factor: float) -> Any:
    """An object with the face's rest mesh and the rig's materials, so many widths beside the rig, in no scene yet. factor: from
    Blender's coordinates to the face's."""
    mesh = bpy.data.meshes.new(f"{settings.name} baked")
    mesh.from_pydata(face.rest_positions.tolist(), [], _polygons(face))
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))
    mesh.color_attributes.new(ATTRIBUTE, "FLOAT_COLOR", "POINT")
    mesh.color_attributes.active_color = mesh.color_attributes[ATTRIBUTE]
    preview = bpy.data.objects.new(mesh.name, mesh)
    _place(preview, face, settings, place, factor)
    _take_materials(mesh, settings)
    return preview


def show_error_material(preview: Any, shown: bool) -> None:
    """Has the object drawn with a material that shows errors, or with its mesh's own, which stay as they are."""
    material = _error_material() if shown else None
    for slot in preview.material_slots:
        slot.link = "OBJECT"
        slot.material = material
        slot.link = "OBJECT" if shown else "DATA"


def _polygons(face: "facebaker.Face") -> List[List[int]]:
    ends = np.cumsum(face.polygon_sizes)
    corners = face.polygon_corners.tolist()
    return [corners[end - size : end] for size, end in zip(face.polygon_sizes.tolist(), ends.tolist())]


def _place(preview: Any, face: "facebaker.Face", settings: BakeSettings, place: int, factor: float) -> None:
    from mathutils import Matrix

    reference = find_object(settings.reference or settings.meshes[0])
    width = float(np.ptp(face.rest_positions[:, 0])) / factor
    beside = Matrix.Translation((BESIDE * place * width, 0, 0))
    preview.matrix_world = reference.matrix_world @ beside @ Matrix.Scale(1 / factor, 4)


def _take_materials(mesh: Any, settings: BakeSettings) -> None:
    """Those of the rig's meshes."""
    slots: Dict[str, int] = {}
    indices: List[int] = []
    for source in (find_object(name).data for name in settings.meshes):
        known = []
        for material in source.materials:
            if material is not None and material.name not in slots:
                slots[material.name] = len(slots)
                mesh.materials.append(material)
            known.append(slots[material.name] if material is not None else 0)
        indices += [known[p.material_index] if p.material_index < len(known) else 0 for p in source.polygons]
    if not slots:
        mesh.materials.append(None)  # for show_error_material()
    elif len(indices) == len(mesh.polygons):
        mesh.polygons.foreach_set("material_index", indices)


def _error_material() -> Any:
    """One that shows the colours of errors."""
    known = bpy.data.materials.get(_MATERIAL)
    if known is not None:
        return known
    material = bpy.data.materials.new(_MATERIAL)
    if bpy.app.version < (5, 0, 0):  # later materials always have nodes
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    attribute = nodes.new("ShaderNodeAttribute")
    attribute.attribute_name = ATTRIBUTE
    shader = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    links.new(attribute.outputs["Color"], shader.inputs["Base Color"])
    return material
