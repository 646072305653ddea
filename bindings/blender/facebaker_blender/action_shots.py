"""Actions as shots: the controls that their curves animate, frame by frame, read off the curves without playing them."""

from __future__ import annotations

from typing import Any, Dict, Iterable, List, Optional, Sequence, Set, Tuple

import bpy
import numpy as np

from .bake_settings import BakeSettings, Shot
from .bone_limits import bone_path, escaped, rotation_attribute
from .channels import SceneControl, SettingsError
from .rotations import vector_of_quaternion
from .scene_channels import find_bone

Curves = Dict[Tuple[str, int], Any]


def curves_of(action: Any) -> Curves:
    """The F-curves of an action by data path and index. From Blender 4.4 on an action has slots; the curves of all of
    them count."""
    curves = getattr(action, "fcurves", None)
    if curves is None:
        curves = [
            curve
            for layer in action.layers
            for strip in layer.strips
            for bag in strip.channelbags
            for curve in bag.fcurves
        ]
    return {(curve.data_path, curve.array_index): curve for curve in curves}


def data_path(control: SceneControl) -> str:
    """The path under which F-curves animate a control's channel. Not of rotations, which depend on the bone's mode."""
    channel = control.channel
    if channel.of_bone:
        return bone_path(channel.bone, channel.kind)
    if channel.kind == "shape_key":
        return f'key_blocks["{escaped(channel.key)}"].value'
    key = f'["{escaped(channel.key)}"]'
    return f'pose.bones["{escaped(channel.bone)}"]{key}' if channel.bone else key


def _values(control: SceneControl, curves: Curves, frames: Sequence[int]) -> Optional[List[float]]:
    """The control's values in these frames, None if nothing animates it."""
    channel = control.channel
    if channel.kind == "rotation":
        return _rotation_values(control, curves, frames)
    curve = curves.get((data_path(control), max(channel.axis, 0)))
    return [curve.evaluate(frame) for frame in frames] if curve else None


def _rotation_values(control: SceneControl, curves: Curves, frames: Sequence[int]) -> Optional[List[float]]:
    channel = control.channel
    attribute = rotation_attribute(find_bone(channel.object, channel.bone))
    path = bone_path(channel.bone, attribute)
    if attribute == "rotation_euler":
        curve = curves.get((path, channel.axis))
        return [curve.evaluate(frame) for frame in frames] if curve else None
    parts = [curves.get((path, index)) for index in range(4)]
    if not any(parts):
        return None
    neutral = (1.0, 0.0, 0.0, 0.0) if attribute == "rotation_quaternion" else (0.0, 0.0, 1.0, 0.0)
    result = []
    for frame in frames:
        numbers = [curve.evaluate(frame) if curve else fixed for curve, fixed in zip(parts, neutral)]
        if attribute == "rotation_quaternion":
            vector: Sequence[float] = vector_of_quaternion(numbers)
        else:
            length = sum(n * n for n in numbers[1:]) ** 0.5 or 1.0
            vector = [numbers[0] * n / length for n in numbers[1:]]
        result.append(vector[channel.axis])
    return result


def animated_values(
    action: Any, controls: Sequence[SceneControl], first: int, last: int
) -> "Tuple[np.ndarray[Any, np.dtype[np.float32]], List[int]]":
    """(frames, controls), float32, of the frames from first to last; and the indices of the controls that the action
    animates. The others are at rest."""
    frames = range(first, last + 1)
    values = np.empty((len(frames), len(controls)), np.float32)
    curves, animated = curves_of(action), []
    for column, control in enumerate(controls):
        found = _values(control, curves, frames)
        values[:, column] = control.rest if found is None else found
        if found is not None:
            animated.append(column)
    return values, animated


def find_shots(controls: Sequence[SceneControl], actions: Optional[Iterable[Any]] = None) -> List[Shot]:
    """A shot for each action of the file, in the order of their names, that animates a control for two frames or more."""
    shots = []
    for action in sorted(bpy.data.actions if actions is None else actions, key=lambda action: str(action.name)):
        first, last = (int(round(frame)) for frame in action.frame_range)
        if last > first and animated_values(action, controls, first, first)[1]:
            shots.append(Shot(action.name, first, last))
    return shots


def used_ranges(
    controls: Sequence[SceneControl], actions: Optional[Iterable[Any]] = None
) -> List[Optional[Tuple[float, float]]]:
    """The least and the largest value of each control in actions that animate it; None where none does."""
    used: List[Optional[Tuple[float, float]]] = [None] * len(controls)
    for action in bpy.data.actions if actions is None else actions:
        first, last = (int(round(frame)) for frame in action.frame_range)
        values, animated = animated_values(action, controls, first, max(first, last))
        for column in animated:
            low, high = float(values[:, column].min()), float(values[:, column].max())
            before = used[column] or (low, high)
            used[column] = min(low, before[0]), max(high, before[1])
    return used


def animated_paths() -> Set[Tuple[str, int]]:
    """(data path, index) of all curves of all actions of the file."""
    return {key for action in bpy.data.actions for key in curves_of(action)}


def shot_values(settings: BakeSettings, shot: Shot) -> "np.ndarray[Any, np.dtype[np.float32]]":
    """(frames, controls), float32, of a shot, within the ranges of the controls. Raises SettingsError if its action is
    not there."""
    action = bpy.data.actions.get(shot.action)
    if action is None:
        raise SettingsError(f'there is no action "{shot.action}"')
    values, _ = animated_values(action, settings.controls, shot.first, shot.last)
    low = np.array([control.minimum for control in settings.controls], np.float32)
    high = np.array([control.maximum for control in settings.controls], np.float32)
    clipped: "np.ndarray[Any, np.dtype[np.float32]]" = np.clip(values, low, high)
    return clipped
