"""Writes values of controls as keys of actions: the reverse of action_shots.py."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, Iterator, List, Sequence, Tuple

import bpy
import numpy as np

from .action_curves import ActionCurves, id_type
from .action_shots import data_path
from .bone_limits import bone_path, rotation_attribute
from .channels import Channel, SceneControl, SettingsError
from .rotations import quaternion_of_vector
from .scene_channels import SceneChannels, channel_block, find_bone

Array = Any  # of NumPy
_STILL = 1e-6  # of a control's range, that no key is worth


@dataclass(frozen=True)
class _Track:
    """A curve to be written. index: -1 where the property is one number. values: one a frame."""

    block: Any
    path: str
    index: int
    group: str
    values: Array
    tolerance: float
    whole: bool = False


def key_controls(
    context: Any, controls: Sequence[SceneControl], values: Array, first: int, locked: Sequence[str], action: str
) -> List[str]:
    """Writes keys for the controls that are not locked, (frames, controls) from a frame on, and shows the pose of the current
    frame. action: the name of a new action; "": keys go into the actions that the rig uses now, in place of those in
    these frames, and a new one where there is none. A new action begins from rest, so locked controls are set to it. Gives
    the names of the actions. Raises SettingsError."""
    tracks = list(_tracks(controls, values, set(locked)))
    blocks = {track.block.as_pointer(): track.block for track in tracks}
    written: List[Any] = []
    for block in blocks.values():
        _use_action(block, action, written)
    for track in tracks:
        try:
            track.block.keyframe_insert(track.path, index=track.index, frame=first, group=track.group)
        except (RuntimeError, TypeError) as error:
            raise SettingsError(f'"{track.block.name}": {track.path} takes no keys: {error}') from None
    curves = ActionCurves()
    for track in tracks:
        used = track.block.animation_data.action
        _write(curves.of(used, track.block)[track.path, max(track.index, 0)], track, first)
    _show_pose(context, controls, values, first, set(locked), bool(action))
    return list(dict.fromkeys(str(block.animation_data.action.name) for block in blocks.values()))


def _tracks(controls: Sequence[SceneControl], values: Array, locked: "set[str]") -> Iterator[_Track]:
    turns: Dict[Tuple[str, str], List[int]] = {}
    for column, control in enumerate(controls):
        channel = control.channel
        if channel.kind == "rotation":
            turns.setdefault((channel.object, channel.bone), []).append(column)
        elif control.name not in locked:
            yield _Track(
                channel_block(channel), data_path(control), channel.axis, channel.bone or _group(channel),
                values[:, column], _STILL * control.span, channel.whole,
            )  # fmt: skip
    for columns in turns.values():
        if any(controls[column].name not in locked for column in columns):
            yield from _rotation_tracks([controls[column] for column in columns], values[:, columns], locked)


def _group(channel: Channel) -> str:
    return "Shape keys" if channel.kind == "shape_key" else "Properties"


def _rotation_tracks(controls: Sequence[SceneControl], values: Array, locked: "set[str]") -> Iterator[_Track]:
    """Of the controls of one bone's rotation. Angles of an Euler rotation are keyed by themselves; all numbers of another
    one, in which axes that have no control do not turn."""
    channel = controls[0].channel
    bone = find_bone(channel.object, channel.bone)
    attribute = rotation_attribute(bone)
    path = bone_path(channel.bone, attribute)
    if attribute == "rotation_euler":
        for control, column in zip(controls, values.T):
            if control.name not in locked:
                yield _Track(bone.id_data, path, control.channel.axis, channel.bone, column, _STILL * control.span)
        return
    vectors = np.zeros((len(values), 3))
    vectors[:, [control.channel.axis for control in controls]] = values
    numbers = _quaternions(vectors) if attribute == "rotation_quaternion" else _axis_angles(vectors)
    for index, column in enumerate(numbers.T):
        yield _Track(bone.id_data, path, index, channel.bone, column, _STILL)


def _quaternions(vectors: Array) -> Array:
    """(frames, 4), of rotation vectors. Of the two that are the same rotation, the one that is nearer to that of the frame
    before, as keys are joined number by number."""
    result = np.array([quaternion_of_vector(vector) for vector in vectors])
    for frame in range(1, len(result)):
        if result[frame] @ result[frame - 1] < 0:
            result[frame] *= -1
    return result


def _axis_angles(vectors: Array) -> Array:
    """(frames, 4), angles and axes of rotation vectors. An axis does not turn round between two frames; where there is no
    angle it is that of the frame before."""
    result: List[List[float]] = []
    axis = np.array([0.0, 1.0, 0.0])
    for vector in vectors:
        angle = float(np.linalg.norm(vector))
        if angle > 0:
            turned = vector / angle
            angle, axis = (angle, turned) if turned @ axis >= 0 or not result else (-angle, -turned)
        result.append([angle, *axis])
    return np.array(result)


def _use_action(block: Any, name: str, made: List[Any]) -> None:
    """Has a data-block use an action: with a name a new one, of which it has a slot of its own where actions have slots; else
    the one it uses, or a new one. made: new actions, the last of which serves several data-blocks if it has slots."""
    animation = block.animation_data_create()
    if animation.is_property_readonly("action"):
        raise SettingsError(f'"{block.name}": its action cannot be set while a strip is edited')
    slots = hasattr(bpy.types, "ActionSlot")
    if animation.action is None or name:
        former = animation.action
        if not (slots and made):
            made.append(bpy.data.actions.new(name or f"{block.name} solved"))
        animation.action = made[-1]
        if former is not None and former.users == 0:
            former.use_fake_user = True  # it would not be saved
        if slots:
            animation.action_slot = None
    if slots and animation.action_slot is None:
        animation.action_slot = animation.action.slots.new(id_type(block), block.name)


def _write(curve: Any, track: _Track, first: int) -> None:
    """Writes a track's values into a curve, in place of its keys in these frames; two or one if nothing moves."""
    points, last = curve.keyframe_points, first + len(track.values) - 1
    still = float(np.ptp(track.values)) <= track.tolerance
    frames = np.unique([first, last]) if still else np.arange(first, last + 1)
    values = np.asarray(track.values, np.float64)[frames - first]
    times = _numbers(points, "co", 2)[:, 0]
    own = np.flatnonzero((times >= first) & (times <= last))
    for index in own[len(frames) :][::-1].tolist():  # more than are needed
        points.remove(points[index], fast=True)
    own = own[: len(frames)]
    added = len(frames) - len(own)
    own = np.concatenate([own, len(points) + np.arange(added)])
    points.add(added)
    _set_numbers(points, "co", own, np.stack([frames, np.round(values) if track.whole else values], 1))
    _set_choice(points, "interpolation", own, "CONSTANT" if track.whole else "LINEAR")
    for side in "handle_left_type", "handle_right_type":
        _set_choice(points, side, own, "AUTO_CLAMPED")
    curve.update()  # sorts keys, and places handles


def _numbers(points: Any, attribute: str, width: int) -> Array:
    """(keys, width), float32."""
    numbers = np.empty(width * len(points), np.float32)
    points.foreach_get(attribute, numbers)
    return numbers.reshape(-1, width)


def _set_numbers(points: Any, attribute: str, rows: Array, values: Array) -> None:
    numbers = _numbers(points, attribute, values.shape[1])
    numbers[rows] = values
    points.foreach_set(attribute, numbers.ravel())


def _set_choice(points: Any, attribute: str, rows: Array, choice: str) -> None:
    numbers = np.empty(len(points), np.int32)
    points.foreach_get(attribute, numbers)
    numbers[rows] = bpy.types.Keyframe.bl_rna.properties[attribute].enum_items[choice].value
    points.foreach_set(attribute, numbers)


def _show_pose(
    context: Any, controls: Sequence[SceneControl], values: Array, first: int, locked: "set[str]", rest_locked: bool
) -> None:
    frame = min(max(context.scene.frame_current - first, 0), len(values) - 1)
    channels = SceneChannels(controls)
    pose = channels.read()
    for column, control in enumerate(controls):
        if control.name not in locked:
            pose[column] = values[frame, column]
        elif rest_locked:
            pose[column] = control.rest
    channels.write(pose)
    context.view_layer.update()
