"""Reading and writing the channels of controls in a scene."""

from __future__ import annotations

from typing import Any, Dict, List, Sequence, Tuple

import bpy
import numpy as np

from .channels import Channel, SceneControl, SettingsError, there_are
from .rotations import quaternion_of_vector, vector_of_quaternion


def find_object(name: str, graph: Any = None) -> Any:
    """The object of the file that has this name; graph: as this dependency graph has evaluated it. Raises SettingsError."""
    found = bpy.data.objects.get(name)
    if found is None:
        raise SettingsError(f'there is no object "{name}"; {there_are((o.name for o in bpy.data.objects), name)}')
    return found.evaluated_get(graph) if graph else found


def find_bone(object_name: str, bone: str, graph: Any = None) -> Any:
    """The pose bone. Raises SettingsError."""
    owner = find_object(object_name, graph)
    bones = owner.pose.bones if owner.pose else {}
    found = bones.get(bone)
    if found is None:
        raise SettingsError(f'"{object_name}" has no bone "{bone}"; {there_are(bones.keys(), bone)}')
    return found


def property_owner(channel: Channel, graph: Any = None) -> Any:
    """What has the custom property of a channel: a pose bone, an object or its data. Raises SettingsError."""
    if channel.bone:
        owner = find_bone(channel.object, channel.bone, graph)
    elif channel.on_data:
        data = find_object(channel.object).data
        owner = data.evaluated_get(graph) if graph else data
    else:
        owner = find_object(channel.object, graph)
    if channel.key not in owner.keys():
        raise SettingsError(f'"{channel.bone or channel.object}" has no custom property "{channel.key}"')
    return owner


def find_shape_key(channel: Channel, graph: Any = None) -> Any:
    """The key block. Raises SettingsError."""
    keys = getattr(find_object(channel.object).data, "shape_keys", None)
    if keys and graph:
        keys = keys.evaluated_get(graph)
    blocks = keys.key_blocks if keys else {}
    found = blocks.get(channel.key)
    if found is None:
        raise SettingsError(f'"{channel.object}" has no shape key "{channel.key}"; {there_are(blocks.keys(), channel.key)}')
    return found


def channel_block(channel: Channel) -> Any:
    """The data-block whose animation sets the channel: an object, its data or its shape keys. Raises SettingsError."""
    if channel.of_bone:
        return find_bone(channel.object, channel.bone).id_data
    return (find_shape_key(channel) if channel.kind == "shape_key" else property_owner(channel)).id_data


class _BoneVector:
    """The location or scale of a pose bone."""

    def __init__(self, bone: Any, attribute: str, axes: Sequence[int], columns: Sequence[int]) -> None:
        self.bone, self.attribute, self.axes, self.columns = bone, attribute, list(axes), list(columns)
        self.ids = (bone.id_data,)

    def read(self) -> List[float]:
        vector = getattr(self.bone, self.attribute)
        return [vector[axis] for axis in self.axes]

    def write(self, values: Sequence[float]) -> None:
        vector = list(getattr(self.bone, self.attribute))
        for axis, value in zip(self.axes, values):
            vector[axis] = value
        setattr(self.bone, self.attribute, vector)

    def state(self) -> Any:
        return tuple(getattr(self.bone, self.attribute))

    def restore(self, state: Any) -> None:
        setattr(self.bone, self.attribute, state)


class _BoneRotation:
    """The rotation of a pose bone; see channels.Channel."""

    def __init__(self, bone: Any, axes: Sequence[int], columns: Sequence[int]) -> None:
        self.bone, self.axes, self.columns = bone, list(axes), list(columns)
        self.ids = (bone.id_data,)

    def read(self) -> List[float]:
        vector = self._vector()
        return [vector[axis] for axis in self.axes]

    def _vector(self) -> Sequence[float]:
        if self.bone.rotation_mode == "QUATERNION":
            return vector_of_quaternion(self.bone.rotation_quaternion)
        if self.bone.rotation_mode == "AXIS_ANGLE":
            angle, *axis = self.bone.rotation_axis_angle
            length = sum(a * a for a in axis) ** 0.5 or 1.0
            return [angle * a / length for a in axis]
        return list(self.bone.rotation_euler)

    def write(self, values: Sequence[float]) -> None:
        mode = self.bone.rotation_mode
        vector = list(self.bone.rotation_euler) if mode not in ("QUATERNION", "AXIS_ANGLE") else [0.0, 0.0, 0.0]
        for axis, value in zip(self.axes, values):
            vector[axis] = value
        if mode == "QUATERNION":
            self.bone.rotation_quaternion = quaternion_of_vector(vector)
        elif mode == "AXIS_ANGLE":
            angle = sum(v * v for v in vector) ** 0.5
            self.bone.rotation_axis_angle = [angle, *([v / angle for v in vector] if angle else [0.0, 1.0, 0.0])]
        else:
            self.bone.rotation_euler = vector

    def state(self) -> Any:
        bone = self.bone
        return tuple(bone.rotation_quaternion), tuple(bone.rotation_axis_angle), tuple(bone.rotation_euler)

    def restore(self, state: Any) -> None:
        bone = self.bone
        bone.rotation_quaternion, bone.rotation_axis_angle, bone.rotation_euler = state


class _ShapeKey:
    def __init__(self, block: Any, column: int) -> None:
        self.block, self.columns = block, [column]
        self.ids = (block.id_data,)

    def read(self) -> List[float]:
        return [self.block.value]

    def write(self, values: Sequence[float]) -> None:
        self.block.value = values[0]

    def state(self) -> Any:
        return self.block.value

    def restore(self, state: Any) -> None:
        self.block.value = state


class _Property:
    def __init__(self, owner: Any, key: str, whole: bool, column: int) -> None:
        self.owner, self.key, self.whole, self.columns = owner, key, whole, [column]
        self.ids = (owner.id_data,)

    def read(self) -> List[float]:
        return [float(self.owner[self.key])]

    def write(self, values: Sequence[float]) -> None:
        # Keeps the property's type, which Blender would change with the value's.
        kind = type(self.owner[self.key])
        self.owner[self.key] = kind(round(values[0])) if self.whole else float(values[0])
        self.owner.id_data.update_tag()  # custom properties do not mark what their drivers move

    def state(self) -> Any:
        return self.owner[self.key]

    def restore(self, state: Any) -> None:
        self.owner[self.key] = state


class SceneChannels:
    """The channels of a list of controls, resolved in the open file. Valid until objects are removed, an undo, or
    another file. graph: to read them as this dependency graph has evaluated them, with the animation of its frame; such
    channels cannot be written. Raises SettingsError, by name, on what is not there."""

    def __init__(self, controls: Sequence[SceneControl], graph: Any = None) -> None:
        self.count = len(controls)
        self._targets: List[Any] = []
        vectors: Dict[Tuple[str, str, str], List[Tuple[int, int]]] = {}
        for column, control in enumerate(controls):
            channel = control.channel
            if channel.of_bone:
                vectors.setdefault((channel.object, channel.bone, channel.kind), []).append((channel.axis, column))
            elif channel.kind == "shape_key":
                self._targets.append(_ShapeKey(find_shape_key(channel, graph), column))
            else:
                owner = property_owner(channel, graph)
                self._targets.append(_Property(owner, channel.key, channel.whole, column))
        for (rig, name, kind), pairs in vectors.items():
            bone, axes, columns = find_bone(rig, name, graph), [axis for axis, _ in pairs], [c for _, c in pairs]
            rotates = kind == "rotation"
            self._targets.append(
                _BoneRotation(bone, axes, columns) if rotates else _BoneVector(bone, kind, axes, columns)
            )
        self._written: Any = None

    def read(self) -> "np.ndarray[Any, np.dtype[np.float32]]":
        """(controls,), float32: what the scene has them at."""
        values = np.empty(self.count, np.float32)
        for target in self._targets:
            values[target.columns] = target.read()
        return values

    def write(self, values: "np.ndarray[Any, np.dtype[np.float32]]") -> None:
        """Sets all controls, those that changed since the last call, and marks what depends on them for evaluation."""
        changed = np.full(self.count, True) if self._written is None else values != self._written
        for target in self._targets:
            if changed[target.columns].any():
                target.write(values[target.columns].tolist())
        self._written = values.copy()

    def state(self) -> List[Any]:
        """What restore() brings back, exactly."""
        return [target.state() for target in self._targets]

    def restore(self, state: Sequence[Any]) -> None:
        for target, was in zip(self._targets, state):
            target.restore(was)
        for block in {block.as_pointer(): block for target in self._targets for block in target.ids}.values():
            block.update_tag()
        self._written = None
