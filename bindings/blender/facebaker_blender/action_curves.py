"""Which curves of an action animate a data-block: those of its slot, from Blender 4.4 on."""

from __future__ import annotations

from typing import Any, Dict, Iterator, List, Optional, Tuple

import bpy

Curves = Dict[Tuple[str, int], Any]


class ActionCurves:
    """The curves that actions have for data-blocks (objects, shape keys, meshes, armatures), as the open file is now. Valid
    until data is removed, an undo, or another file."""

    def __init__(self) -> None:
        self._users = _action_users()
        self._found: Dict[Tuple[str, int], Curves] = {}

    def of(self, action: Any, block: Any) -> Curves:
        """The F-curves of an action that animate this data-block, by data path and index; none for one that is animated by
        another action's slot, or is of another type. An action, or a slot, that nothing uses may animate any data-block of
        its type, unless there is one that it is named after."""
        key = action.name, block.as_pointer()
        if key not in self._found:
            curves = self._curves(action, block)
            self._found[key] = {(curve.data_path, curve.array_index): curve for curve in curves}
        return self._found[key]

    def _curves(self, action: Any, block: Any) -> List[Any]:
        users = self._users.get(action.name, {})
        if not is_layered(action):
            if getattr(action, "id_root", "") not in ("", id_type(block)):
                return []
            same_type = [user for user in users.values() if id_type(user[0]) == id_type(block)]
            return [] if same_type and block.as_pointer() not in users else list(action.fcurves)
        if block.as_pointer() in users:
            return _slot_curves(action, users[block.as_pointer()][1])
        taken = {slot for _, slot in users.values()}
        return _slot_curves(action, _free_slot(action, block, taken))


def id_type(block: Any) -> str:
    """As actions and slots have it: "OBJECT", "KEY", "MESH", "ARMATURE"."""
    return str(block.bl_rna.identifier).upper()


def is_layered(action: Any) -> bool:
    """Whether the action's curves are in slots."""
    return not hasattr(action, "fcurves") or bool(getattr(action, "slots", ()))


def _bags(action: Any) -> Iterator[Any]:
    for layer in action.layers:
        for strip in layer.strips:
            yield from strip.channelbags


def _slot_curves(action: Any, slot: Optional[str]) -> List[Any]:
    """slot: its identifier, as "OBrig"; None: none."""
    return [curve for bag in _bags(action) if slot and bag.slot.identifier == slot for curve in bag.fcurves]


def _free_slot(action: Any, block: Any, taken: "set[Optional[str]]") -> Optional[str]:
    """The slot that Blender would give a data-block which does not use the action: one that is named after it, else the
    only one of its type, if that is nobody else's."""
    suitable = [slot for slot in action.slots if slot.target_id_type in (id_type(block), "UNSPECIFIED")]
    for slot in suitable:
        if slot.name_display == block.name and slot.identifier not in taken:
            return str(slot.identifier)
    if len(suitable) != 1 or suitable[0].identifier in taken or _has_owner(suitable[0], block):
        return None
    return str(suitable[0].identifier)


def _has_owner(slot: Any, block: Any) -> bool:
    """Whether the file has another data-block of this type that the slot is named after."""
    named = [other for other in _animatable() if id_type(other) == id_type(block) and other.name == slot.name_display]
    return any(other != block for other in named)


def _animatable() -> Iterator[Any]:
    for blocks in bpy.data.objects, bpy.data.shape_keys, bpy.data.armatures, bpy.data.meshes:
        yield from blocks


def _action_users() -> "Dict[str, Dict[int, Tuple[Any, Optional[str]]]]":
    """By action and pointer of a data-block that uses it, itself or by strips: the data-block and its slot."""
    users: "Dict[str, Dict[int, Tuple[Any, Optional[str]]]]" = {}
    for block in _animatable():
        animation = block.animation_data
        if animation is None:
            continue
        strips = [strip for track in animation.nla_tracks for strip in track.strips if strip.action]
        used = [(strip.action, getattr(strip, "action_slot", None)) for strip in strips]
        if animation.action:
            used.append((animation.action, getattr(animation, "action_slot", None)))
        for action, slot in used:
            users.setdefault(action.name, {})[block.as_pointer()] = block, slot.identifier if slot else None
    return users
