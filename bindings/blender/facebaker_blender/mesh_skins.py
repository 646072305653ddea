"""Which bones the vertices of a mesh follow, where that is linear blend skinning."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Dict, List, Tuple

import numpy as np

MOST_INFLUENCES = 32  # of a vertex, in an archive

Bone = Tuple[str, str]  # the name of an armature object, and that of a bone


@dataclass
class MeshSkin:
    """bones: that vertices follow. indices: (vertices, influences), of bones; weights: as many, those of a vertex sum to
    1 or are all 0. reason: why a mesh that an armature deforms follows none, "" otherwise."""

    bones: List[Bone] = field(default_factory=list)
    indices: Any = None
    weights: Any = None
    reason: str = ""


def mesh_skin(mesh_object: Any, evaluated: Any) -> MeshSkin:
    """Of a mesh object, with the vertices and their groups that its modifiers make, as they are evaluated now."""
    modifiers = [m for m in mesh_object.modifiers if m.type == "ARMATURE" and m.show_viewport and m.object]
    if not modifiers:
        return _hung_skin(mesh_object, len(evaluated.data.vertices))
    reason = "several armatures deform it" if len(modifiers) > 1 else _unlike_linear(modifiers[0])
    return MeshSkin(reason=reason) if reason else _group_skin(modifiers[0].object, evaluated)


def _hung_skin(mesh_object: Any, vertices: int) -> MeshSkin:
    """Of an object that hangs on a bone."""
    holder = mesh_object.parent
    if holder is None or holder.type != "ARMATURE" or mesh_object.parent_type not in ("BONE", "ARMATURE"):
        return MeshSkin()
    if mesh_object.parent_type == "ARMATURE":
        return MeshSkin(reason="its parent deforms it, without a modifier")
    if mesh_object.parent_bone not in holder.pose.bones:
        return MeshSkin()
    bones = [(holder.name, mesh_object.parent_bone)]
    return MeshSkin(bones, np.zeros((vertices, 1), np.int64), np.ones((vertices, 1)))


def _unlike_linear(modifier: Any) -> str:
    """What makes a modifier something else than a linear blend by vertex groups; "" if nothing does."""
    if modifier.use_bone_envelopes:
        return "bones deform it by their envelopes"
    if modifier.use_deform_preserve_volume:
        return "its armature preserves volume (dual quaternions)"
    if modifier.vertex_group or modifier.use_multi_modifier:
        return "its armature is blended with what was before"
    if not modifier.use_vertex_groups:
        return "its armature does not use vertex groups"
    return ""


def _group_skin(armature: Any, evaluated: Any) -> MeshSkin:
    bone_of_group, bones = _deforming_groups(armature, evaluated)
    multiplied = [bone for _, bone in bones if armature.data.bones[bone].use_envelope_multiply]
    if multiplied:
        return MeshSkin(reason=f'the envelope of bone "{multiplied[0]}" multiplies its weights')
    vertices = evaluated.data.vertices
    # What a vertex has beyond the most is at its end, where weights are least.
    rows = [
        sorted(
            ((entry.weight, bone_of_group[entry.group]) for entry in vertex.groups
             if entry.weight > 0 and entry.group in bone_of_group), reverse=True)[:MOST_INFLUENCES]
        for vertex in vertices
    ]  # fmt: skip
    width = max(map(len, rows), default=0)
    if width == 0:
        return MeshSkin()
    indices, weights = np.zeros((len(rows), width), np.int64), np.zeros((len(rows), width))
    for vertex, row in enumerate(rows):
        for place, (weight, bone) in enumerate(row):
            indices[vertex, place], weights[vertex, place] = bone, weight
    sums = weights.sum(1, keepdims=True)
    # Blender divides by the sum too, and leaves vertices of a smaller one.
    weights = np.where(sums > 1e-4, weights / np.maximum(sums, 1e-4), 0)
    return MeshSkin(bones, indices, weights)


def _deforming_groups(armature: Any, evaluated: Any) -> Tuple[Dict[int, int], List[Bone]]:
    """Of each vertex group that is named like a deforming bone, the index of that bone; these bones."""
    found: Dict[int, int] = {}
    bones: List[Bone] = []
    for group in evaluated.vertex_groups:
        bone = armature.data.bones.get(group.name)
        if bone is not None and bone.use_deform:
            found[group.index] = len(bones)
            bones.append((armature.name, bone.name))
    return found, bones
