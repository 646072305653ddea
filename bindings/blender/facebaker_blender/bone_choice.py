"""Which bones of armatures controls are looked for on, and which of their channels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Iterable, List, Sequence, Set, Tuple

from .channels import SettingsError, there_are
from .control_names import matches

KINDS = ("location", "rotation", "scale")
LAYERS = 32  # of bones, before Blender 4


@dataclass(frozen=True)
class FindOptions:
    """What is looked at. bones: patterns of names ("lip.*"); none: all. collections: names of bone collections, or before
    Blender 4 numbers of bone layers, counted from 0; none: those that are visible. selected: only bones that are
    selected. kinds: of channels of bones; others are looked at only where they are limited or animated. shape_keys,
    properties: whether they are looked at. moved: only channels of bones that an action changes."""

    bones: Tuple[str, ...] = ()
    collections: Tuple[str, ...] = ()
    selected: bool = False
    kinds: Tuple[str, ...] = ("location", "rotation")
    shape_keys: bool = True
    properties: bool = True
    moved: bool = False


def check_options(armatures: Sequence[Any], options: FindOptions) -> None:
    """Raises SettingsError, naming what there is, if a pattern, a collection or the selection chooses nothing."""
    unknown = [kind for kind in options.kinds if kind not in KINDS]
    if unknown:
        raise SettingsError(f'no kind of channel is called "{unknown[0]}"; {there_are(KINDS)}')
    bones = [bone for armature in armatures for bone in armature.pose.bones if not _is_hidden(bone)]
    names = [bone.name for bone in bones]
    for pattern in options.bones:
        if not any(matches(name, [pattern]) for name in names):
            raise SettingsError(f'no bone that is shown matches "{pattern}"; {there_are(names, pattern)}')
    known = {name: None for armature in armatures for name in _known_collections(armature.data)}
    used = {name for bone in bones for name in _collections_of(bone.bone)}
    for name in options.collections:
        if name not in known:
            raise SettingsError(f'no bone collection is called "{name}"; {there_are(known, name)}')
        if name not in used:
            raise SettingsError(f'the bone collection "{name}" has no bone that is shown')
    if options.selected and not any(map(_is_selected, bones)):
        raise SettingsError("no bone is selected")


def chosen_bones(armature: Any, options: FindOptions) -> List[Any]:
    """The pose bones that the options choose, in the armature's order."""
    return [
        bone
        for bone in armature.pose.bones
        if not _is_hidden(bone)
        and (not options.selected or _is_selected(bone))
        and matches(bone.name, list(options.bones))
        and _in_collections(armature.data, bone.bone, options)
    ]


def _is_hidden(bone: Any) -> bool:
    return bool(getattr(bone.bone, "hide", False) or getattr(bone, "hide", False))  # moved in Blender 5


def _is_selected(bone: Any) -> bool:
    return bool(getattr(bone, "select", False) or getattr(bone.bone, "select", False))  # moved in Blender 5


def _known_collections(data: Any) -> Iterable[str]:
    """Names of an armature's bone collections; before Blender 4 the numbers of layers that hold bones."""
    if hasattr(data, "layers"):
        return [str(layer) for layer in range(LAYERS) if any(bone.layers[layer] for bone in data.bones)]
    return [str(collection.name) for collection in getattr(data, "collections_all", data.collections)]


def _collections_of(bone: Any) -> Set[str]:
    """The collections that a bone is in, and those around them."""
    if hasattr(bone, "layers"):  # before Blender 4
        return {str(layer) for layer, inside in enumerate(bone.layers) if inside}
    names = set()
    for collection in bone.collections:
        while collection is not None:
            names.add(str(collection.name))
            collection = getattr(collection, "parent", None)
    return names


def _in_collections(data: Any, bone: Any, options: FindOptions) -> bool:
    if options.collections:
        return not _collections_of(bone).isdisjoint(options.collections)
    if options.bones:
        return True
    if hasattr(bone, "layers"):
        return any(inside and data.layers[layer] for layer, inside in enumerate(bone.layers))
    visible = any(getattr(place, "is_visible_effectively", place.is_visible) for place in bone.collections)
    return visible or not len(bone.collections)
