"""Finds the controls of a face: unlocked channels of pose bones, shape keys and custom properties."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Dict, List, Sequence, Set, Tuple

import numpy as np

from .action_shots import animated_paths, used_ranges
from .bone_choice import FindOptions, check_options, chosen_bones
from .bone_groups import bone_groups
from .bone_limits import bone_path, driven_paths, escaped, is_locked, limits_of, property_range, rotation_attribute
from .channels import Channel, SceneControl, named_apart
from .control_names import face_part, mirror_channel_name, part_of_kin
from .ranges import assumed_range, control_range
from .scene_evaluator import SceneEvaluator
from .time_dependence import frame_drivers

Paths = Set[Tuple[str, int]]
MOVES = 1e-6  # of the diagonal: what moves less moves nothing
STILL = 1e-5  # of a channel: less is a rounding of what wrote the file
# Custom properties that Blender and its add-ons keep for themselves.
_PRIVATE = ("_RNA_UI", "rigify", "rig_ui", "cycles", "facebaker", "cycles_visibility", "rig_id")


def find_controls(
    armatures: Sequence[Any], meshes: Sequence[Any], options: FindOptions
) -> Tuple[List[SceneControl], List[str]]:
    """The controls of these objects, and notes about what was left out. Their ranges contain what the file's actions
    animate. Changes nothing in the scene. Raises SettingsError on options that choose nothing."""
    check_options(armatures, options)
    found: List[SceneControl] = []
    notes: List[str] = []
    for armature in armatures:
        animated = animated_paths(armature)
        bones, driven = chosen_bones(armature, options), driven_paths(armature)
        groups = bone_groups(armature, bones)
        found += [c for b in bones for c in _bone_channels(armature, b, groups[b.name], options, driven, animated)]
        if options.properties:
            found += [c for b in bones for c in _properties(armature, b, b.name, False, groups[b.name], notes)]
            found += _properties(armature, armature, "", False, "", notes)
            found += _properties(armature, armature.data, "", True, "", notes)
    for mesh in meshes:
        if options.shape_keys:
            found += _shape_keys(mesh, notes)
        if options.properties:
            part = part_of_kin(mesh.name)
            found += _properties(mesh, mesh, "", False, part, notes) + _properties(mesh, mesh.data, "", True, part, notes)
    keys = [mesh.data.shape_keys for mesh in meshes if mesh.data.shape_keys]
    notes += frame_drivers([*armatures, *meshes, *keys])
    return named_apart(_ranged(found, armatures, _diagonal(meshes), options.moved)), notes


def _diagonal(meshes: Sequence[Any]) -> float:
    """Of the box round all meshes, as they are now."""
    corners = [np.array(mesh.matrix_world) @ (*corner, 1) for mesh in meshes for corner in mesh.bound_box]
    return float(np.linalg.norm(np.ptp(np.array(corners)[:, :3], 0))) if corners else 0.0


def _bone_channels(
    armature: Any, bone: Any, group: str, options: FindOptions, driven: Paths, animated: Paths
) -> List[SceneControl]:
    controls = []
    for kind in ("location", "rotation", "scale"):
        attribute = rotation_attribute(bone) if kind == "rotation" else kind
        first = 1 if attribute in ("rotation_quaternion", "rotation_axis_angle") else 0
        for axis in range(3):
            path = bone_path(bone.name, attribute)
            place = axis + first  # of the curve
            wanted = kind in options.kinds or (path, place) in animated or limits_of(bone, kind, axis) != (None, None)
            is_driven = (path, place) in driven or first and (path, 0) in driven
            if not wanted or is_locked(bone, kind, axis) or is_driven:
                continue
            channel = Channel(kind, armature.name, bone.name, axis)
            controls.append(_unranged(channel, group))
    return controls


def _unranged(channel: Channel, group: str) -> SceneControl:
    """Its range is found later."""
    rest = channel.neutral
    name, mirror = channel.short_name, mirror_channel_name(channel)
    return SceneControl(name, channel, rest - 1, rest + 1, rest, group, mirror)


def _ranged(
    controls: Sequence[SceneControl], armatures: Sequence[Any], diagonal: float, moved: bool
) -> List[SceneControl]:
    """With the ranges of channels of bones, and those of properties that animation takes further; channels that limits
    hold in place are left out, and with `moved` those of bones that no action changes."""
    by_name = {armature.name: armature for armature in armatures}
    result = []
    for control, used in zip(controls, used_ranges(controls)):
        channel, low, high, rest = control.channel, control.minimum, control.maximum, control.rest
        if moved and channel.of_bone and not (used and used[1] - used[0] > STILL):
            continue
        if channel.of_bone:
            bone = by_name[channel.object].pose.bones[channel.bone]
            limits = limits_of(bone, channel.kind, channel.axis)
            assumed = assumed_range(channel.kind, bone.bone.length, diagonal)
            low, high, rest = control_range(limits, used, assumed, channel.neutral)
        elif used and channel.kind == "property":
            low, high = min(low, used[0]), max(high, used[1])
        if low < high:
            result.append(replace(control, minimum=low, maximum=high, rest=rest))
    return result


def _shape_keys(mesh: Any, notes: List[str]) -> List[SceneControl]:
    keys = getattr(mesh.data, "shape_keys", None)
    if keys is None:
        return []
    if not keys.use_relative:
        notes.append(f'"{mesh.name}": its shape keys are absolute; they are left out')
        return []
    driven = driven_paths(keys)
    controls = []
    for block in keys.key_blocks:
        if block == keys.reference_key or block.mute:
            continue
        if (f'key_blocks["{escaped(block.name)}"].value', 0) in driven:
            continue
        low, high = float(block.slider_min), float(block.slider_max)
        if low >= high:
            notes.append(f'"{mesh.name}": shape key "{block.name}" has the range {low:g} to {high:g}; it is left out')
            continue
        channel = Channel("shape_key", mesh.name, key=block.name)
        group = face_part(block.name) or part_of_kin(mesh.name)
        rest = min(max(0.0, low), high)
        controls.append(SceneControl(block.name, channel, low, high, rest, group, mirror_channel_name(channel)))
    return controls


def _properties(
    owner_object: Any, owner: Any, bone: str, on_data: bool, group: str, notes: List[str]
) -> List[SceneControl]:
    """group: of those whose names tell no part of the face."""
    driven = {path for path, _ in driven_paths(owner.id_data)}
    controls = []
    for key in owner.keys():
        if key.startswith(_PRIVATE) or not isinstance(owner[key], (float, int)):
            continue
        prefix = f'pose.bones["{escaped(bone)}"]' if bone else ""
        if f'{prefix}["{escaped(key)}"]' in driven:
            continue
        whole = isinstance(owner[key], int)
        span = (0.0, 1.0, float(owner[key])) if isinstance(owner[key], bool) else property_range(owner, key)
        place = f'"{bone or owner.name}"'
        if span is None:
            notes.append(f'{place}: property "{key}" has no range; give it one to have it as a control')
            continue
        channel = Channel("property", owner_object.name, bone, key=key, on_data=on_data, whole=whole)
        part = face_part(bone) or face_part(key) or group
        controls.append(SceneControl(channel.short_name, channel, *span, part, mirror_channel_name(channel)))
    return controls


def still_controls(evaluator: SceneEvaluator, seed: int = 0, step: Any = None) -> List[str]:
    """Names of controls that move no vertex: neither alone, at the end of their range that is further from rest, nor in
    a random pose of all others within half of their ranges, where a switch may count that does nothing at rest. Costs
    three evaluations a control. step: called with the number of controls done."""
    controls = evaluator.settings.controls
    rest = evaluator.rest_controls
    ends = np.array([_far_end(control) for control in controls], np.float32)
    low, high = (np.array([getattr(c, end) for c in controls], np.float32) for end in ("minimum", "maximum"))
    drawn = np.random.default_rng(seed).uniform(0, 0.5, len(controls))
    sides = np.where(np.random.default_rng(seed + 1).uniform(size=len(controls)) < 0.5, low, high)
    crowd = (rest + drawn * (sides - rest)).astype(np.float32)
    among = evaluator.evaluate(crowd[None])[0]
    tolerance = MOVES * evaluator.diagonal
    still = []
    for index, control in enumerate(controls):
        alone, others = rest.copy(), crowd.copy()
        alone[index] = others[index] = ends[index]
        moved = max(
            float(np.abs(evaluator.evaluate(pose[None])[0] - base).max())
            for pose, base in ((alone, evaluator.rest_positions), (others, among))
        )
        if moved <= tolerance and crowd[index] != ends[index]:
            still.append(control.name)
        if step:
            step(index + 1)
    return still


def _far_end(control: SceneControl) -> float:
    return (
        control.maximum if control.maximum - control.rest >= control.rest - control.minimum else control.minimum
    )


def groups_of(controls: Sequence[SceneControl]) -> Dict[str, int]:
    """How many controls each group has."""
    counts: Dict[str, int] = {}
    for control in controls:
        counts[control.group] = counts.get(control.group, 0) + 1
    return counts
