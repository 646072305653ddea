"""The control group of each bone: the part of the face that names tell of, how the armature sorts its bones, or which bones
hang together."""

from __future__ import annotations

import re
from typing import Any, Dict, List, Sequence

import bpy

from .control_names import face_part, part_of_kin

# A row of a rig's own panel that shows or hides a layer, as Rigify writes it: the only place where a layer has a name.
_LAYER_ROW = re.compile(r"""['"]layers['"]\s*,\s*index\s*=\s*(\d+)[^)]*?\btext\s*=\s*(['"])(.+?)\2""")


def bone_groups(armature: Any, bones: Sequence[Any]) -> Dict[str, str]:
    """{name: group} of these pose bones of an armature. First of these that tells: a part of the face in the bone's own name;
    in the name of a collection, a layer or a bone group that it is in; in the name of the nearest bone above it that has
    one. Then the smallest of its collections or named layers that does not hold all of these bones, then its bone group.
    What is left is grouped by the bones that it hangs on."""
    layers = layer_names(armature)
    sorts = {bone.name: _sorts(bone, layers) for bone in bones}
    counts: Dict[str, int] = {}
    for names in sorts.values():
        for name in names:
            counts[name] = counts.get(name, 0) + 1
    groups: Dict[str, str] = {}
    for bone in bones:
        names = sorts[bone.name]
        part = face_part(bone.name) or next(filter(None, map(part_of_kin, names)), "") or _part_above(bone)
        telling = [name for name in names if counts[name] < len(bones)]
        groups[bone.name] = part or (min(telling, key=lambda name: counts[name]) if telling else "")
    left = [bone for bone in bones if not groups[bone.name]]
    groups.update(_branches([_chain(bone) for bone in left]))
    return groups


def layer_names(armature: Any) -> Dict[int, str]:
    """Names of an armature's bone layers, before Blender 4: those of its metarig, or of the rig's own panel, a text that
    the armature refers to. Empty where there are none."""
    if not hasattr(armature.data, "layers"):
        return {}
    for data in [armature.data, *bpy.data.armatures]:
        if data == armature.data or getattr(data, "rigify_target_rig", None) == armature:
            named = {index: str(layer.name) for index, layer in enumerate(getattr(data, "rigify_layers", ())) if layer.name}
            if named:
                return named
    texts = [value for owner in (armature, armature.data) for value in owner.values() if isinstance(value, bpy.types.Text)]
    return {int(row[1]): row[3] for text in texts for row in _LAYER_ROW.finditer(text.as_string())}


def _sorts(bone: Any, layers: Dict[int, str]) -> List[str]:
    """Names of the collections that a pose bone is in, and those around them; before Blender 4 of its layers, or without
    them of its bone group."""
    names = []
    for collection in getattr(bone.bone, "collections", None) or ():
        while collection is not None:
            names.append(str(collection.name))
            collection = getattr(collection, "parent", None)  # from Blender 4.1 on
    names += [name for index, name in layers.items() if bone.bone.layers[index]]
    group = getattr(bone, "bone_group", None)
    if group and not names:
        names.append(str(group.name))
    return names


def _part_above(bone: Any) -> str:
    """The part of the face that the nearest bone above tells of, "" if none does."""
    above = bone.parent
    while above is not None:
        if face_part(above.name):
            return part_of_kin(above.name)
        above = above.parent
    return ""


def _chain(bone: Any) -> List[str]:
    """Names from the top of the armature to this bone."""
    names = [str(bone.name)]
    while bone.parent is not None:
        bone = bone.parent
        names.insert(0, str(bone.name))
    return names


def _branches(chains: Sequence[Sequence[str]]) -> Dict[str, str]:
    """{last name: group} of chains of bones, each from the top to a bone. Bones below the place where the chains part are a
    group for each branch, by the name of its first bone; bones before it, and those that are alone on their branch, are
    one group by the topmost of them. A branch with more than half of the bones is divided again, where that leaves more
    than one group."""
    shared, longer = 0, list(chains)
    while len(longer) > 1 and len({chain[shared] for chain in longer}) == 1:
        shared += 1
        longer = [chain for chain in chains if len(chain) > shared]
    branches: Dict[str, List[Sequence[str]]] = {}
    for chain in longer:
        branches.setdefault(chain[shared], []).append(chain[shared:])
    stem = [chain[-1] for chain in chains if len(chain) <= shared]
    alone = [branch[0][-1] for branch in branches.values() if len(branch) == 1]
    above = longer[0][shared - 1] if longer and shared else ""
    groups = {name: stem[0] if stem else above or name for name in [*stem, *alone]}
    for name, branch in branches.items():
        if len(branch) > 1:
            divided = _branches(branch) if 2 * len(branch) > len(chains) else {}
            groups.update(divided if len(set(divided.values())) > 1 else {chain[-1]: name for chain in branch})
    return groups
