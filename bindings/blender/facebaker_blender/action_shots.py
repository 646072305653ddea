"""Actions as shots: the controls that their curves animate, frame by frame, read off the curves without playing them."""

from __future__ import annotations

from typing import Any, Iterable, List, Optional, Sequence, Set, Tuple

import bpy
import numpy as np

from .action_curves import ActionCurves, Curves
from .bake_settings import BakeSettings, Shot
from .bone_limits import bone_path, escaped, rotation_attribute
from .channels import SceneControl, SettingsError
from .rotations import vector_of_quaternion
from .scene_channels import channel_block, find_bone


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


class Animation:
    """What the actions of the file animate of some controls. Valid as ActionCurves is. Raises SettingsError, by name, on
    channels that are not there."""

    def __init__(self, controls: Sequence[SceneControl]) -> None:
        self.controls = list(controls)
        self._blocks = [channel_block(control.channel) for control in controls]
        self._curves = ActionCurves()

    def values(
        self, action: Any, first: int, last: int
    ) -> "Tuple[np.ndarray[Any, np.dtype[np.float32]], List[int]]":
        """(frames, controls), float32, of the frames from first to last; and the indices of the controls that the action
        animates. The others are at rest."""
        frames = range(first, last + 1)
        values = np.empty((len(frames), len(self.controls)), np.float32)
        animated = []
        for column, (control, block) in enumerate(zip(self.controls, self._blocks)):
            found = _values(control, self._curves.of(action, block), frames)
            values[:, column] = control.rest if found is None else found
            if found is not None:
                animated.append(column)
        return values, animated

    def frames(self, action: Any) -> Tuple[int, int]:
        """The first and the last frame of the action: those that it is set to have, else those of its keys, of all curves
        that animate data-blocks with controls."""
        if getattr(action, "use_frame_range", False):
            return int(round(action.frame_range[0])), int(round(action.frame_range[1]))
        blocks = {block.as_pointer(): block for block in self._blocks}.values()
        ranges = [curve.range() for block in blocks for curve in self._curves.of(action, block).values()]
        if not ranges:
            return 0, 0
        return int(round(min(low for low, _ in ranges))), int(round(max(high for _, high in ranges)))


def find_shots(controls: Sequence[SceneControl], actions: Optional[Iterable[Any]] = None) -> List[Shot]:
    """A shot for each action of the file, in the order of their names, that animates a control for two frames or more."""
    shots, animation = [], Animation(controls)
    for action in sorted(bpy.data.actions if actions is None else actions, key=lambda action: str(action.name)):
        first, last = animation.frames(action)
        if last > first and animation.values(action, first, first)[1]:
            shots.append(Shot(action.name, first, last))
    return shots


def used_ranges(
    controls: Sequence[SceneControl], actions: Optional[Iterable[Any]] = None
) -> List[Optional[Tuple[float, float]]]:
    """The least and the largest value of each control in actions that animate it; None where none does."""
    used: List[Optional[Tuple[float, float]]] = [None] * len(controls)
    animation = Animation(controls)
    for action in bpy.data.actions if actions is None else actions:
        values, animated = animation.values(action, *animation.frames(action))
        for column in animated:
            low, high = float(values[:, column].min()), float(values[:, column].max())
            before = used[column] or (low, high)
            used[column] = min(low, before[0]), max(high, before[1])
    return used


def animated_paths(block: Any) -> Set[Tuple[str, int]]:
    """(data path, index) of all curves that actions of the file have for a data-block."""
    curves = ActionCurves()
    return {key for action in bpy.data.actions for key in curves.of(action, block)}


def shot_values(settings: BakeSettings, shot: Shot) -> "np.ndarray[Any, np.dtype[np.float32]]":
    """(frames, controls), float32, of a shot, within the ranges of the controls. Raises SettingsError if its action is
    not there."""
    action = bpy.data.actions.get(shot.action)
    if action is None:
        raise SettingsError(f'there is no action "{shot.action}"')
    values, _ = Animation(settings.controls).values(action, shot.first, shot.last)
    low = np.array([control.minimum for control in settings.controls], np.float32)
    high = np.array([control.maximum for control in settings.controls], np.float32)
    clipped: "np.ndarray[Any, np.dtype[np.float32]]" = np.clip(values, low, high)
    return clipped
