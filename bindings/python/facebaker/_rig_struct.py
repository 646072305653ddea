"""A facebaker.Rig as the fb_rig of facebaker_rig.h, which libfacebaker_bake evaluates in this process."""

from __future__ import annotations

import ctypes
import json
from ctypes import c_float, c_uint16, c_uint32, sizeof
from typing import Any, List, Optional, Sequence

import numpy as np

from . import _interop as abi
from ._calls import text_bytes
from ._character import ALPHA_MODES, NUMBERS, SLOTS, WRAPS, Channel, Image, Joint, Material, Mesh, Socket
from ._rig import KINDS, SPLITS, Clip, Rig, describe

_IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)


class HostRig:
    """Keeps everything that `struct` points to. Not to be moved to another process."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._raised: Optional[BaseException] = None
        self._kept: List[Any] = []
        self.struct = self._description()
        if rig.skinned:
            self.struct.evaluate_skinned = abi.fb_rig_evaluate_skinned(self._evaluate_skinned)
        elif rig.channels:
            self.struct.evaluate_all = abi.fb_rig_evaluate_all(self._evaluate_all)
        else:
            self.struct.evaluate = abi.fb_rig_evaluate(self._evaluate)

    def take_raised(self) -> Optional[BaseException]:
        """What the rig raised last since this was called; None if nothing."""
        raised, self._raised = self._raised, None
        return raised

    # Evaluating

    def _evaluate(self, _: Any, poses: int, controls: int, positions: int, message: int, size: int) -> int:
        return self._answer(poses, controls, positions, None, None, message, size)

    def _evaluate_all(
        self, _: Any, poses: int, controls: int, positions: int, channels: int, message: int, size: int
    ) -> int:
        return self._answer(poses, controls, positions, channels, None, message, size)

    def _evaluate_skinned(
        self, _: Any, poses: int, controls: int, positions: int, channels: int, joints: int, message: int, size: int
    ) -> int:
        return self._answer(poses, controls, positions, channels, joints, message, size)

    def _answer(
        self,
        poses: int,
        controls: int,
        positions: int,
        channels: Optional[int],
        joints: Optional[int],
        message: int,
        size: int,
    ) -> int:
        try:
            rig = self._rig
            given = _memory(controls, poses, len(rig.controls))
            given.flags.writeable = False
            result = rig.evaluate_poses(given)
            _memory(positions, poses, 3 * len(rig.rest_positions))[:] = result.positions.reshape(poses, -1)
            if channels is not None:
                _memory(channels, poses, len(rig.channels))[:] = result.channels
            if joints is not None:
                frames = result.frames.reshape(poses, -1)
                _memory(joints, poses, abi.FB_FRAME_FLOATS * len(rig.joints))[:] = frames
            return abi.FB_OK
        except BaseException as error:  # SystemExit, too: the library has to return first
            self._raised = error
            text = describe(error).encode()[: size - 1] + b"\0"
            ctypes.memmove(message, text, len(text))
            return abi.FB_ERROR_RIG

    # Describing

    def _description(self) -> abi.fb_rig:
        rig = self._rig
        struct = abi.fb_rig(
            struct_size=sizeof(abi.fb_rig),
            abi=abi.FB_RIG_ABI,
            name=text_bytes(rig.name),
            units=text_bytes(rig.units),
            up_axis=text_bytes(rig.up_axis),
            flags=abi.FB_RIG_THREAD_SAFE * rig.thread_safe | abi.FB_RIG_SKINNED * rig.skinned,
            vertex_count=len(rig.rest_positions),
            polygon_count=len(rig.polygon_sizes),
            uv_count=len(rig.uvs),
            preferred_block=rig.preferred_block,
            version=text_bytes(rig.version),
            about=None if rig.about is None else json.dumps(rig.about).encode(),
        )
        self._point(struct, "rest_positions", rig.rest_positions, c_float)
        self._point(struct, "polygon_sizes", rig.polygon_sizes, c_uint32)
        self._point(struct, "polygon_corners", rig.polygon_corners, c_uint32)
        if len(rig.uvs):
            self._point(struct, "uvs", rig.uvs, c_float)
            self._point(struct, "uv_corners", rig.uv_corners, c_uint32)
        if rig.skin:
            struct.skin_influences = rig.skin.weights.shape[1]
            self._point(struct, "skin_joints", rig.skin.joints, c_uint16)
            self._point(struct, "skin_weights", rig.skin.weights, c_float)
        self._list(struct, "control", [self._control(control) for control in rig.controls], abi.fb_rig_control)
        labels = [
            abi.fb_rig_labels(*[text_bytes(t) for t in (c.arkit, c.facs, c.unit, c.mirror)]) for c in rig.controls
        ]
        struct.label_stride = sizeof(abi.fb_rig_labels)
        struct.labels = (abi.fb_rig_labels * len(labels))(*labels)
        self._list(struct, "clip", [self._clip(clip) for clip in rig.clips], abi.fb_rig_clip)
        self._list(struct, "mesh", [self._mesh(mesh) for mesh in rig.meshes], abi.fb_mesh, "meshes")
        self._list(struct, "material", [self._material(material) for material in rig.materials], abi.fb_material)
        self._list(struct, "image", [self._image(image) for image in rig.images], abi.fb_image)
        self._list(struct, "socket", [self._socket(socket) for socket in rig.sockets], abi.fb_socket)
        self._list(struct, "channel", [self._channel(channel) for channel in rig.channels], abi.fb_channel)
        self._list(struct, "joint", [self._joint(joint) for joint in rig.joints], abi.fb_joint)
        numbers = [sum(1 << NUMBERS.index(number) for number in set(joint.numbers)) for joint in rig.joints]
        struct.joint_numbers = (c_uint32 * len(numbers))(*numbers)
        return struct

    def _point(self, struct: Any, field: str, array: Any, kind: Any) -> None:
        """Has a field point to an array, which is kept."""
        self._kept.append(array)
        setattr(struct, field, array.ctypes.data_as(ctypes.POINTER(kind)))

    def _list(self, struct: Any, name: str, items: Sequence[Any], kind: Any, plural: str = "") -> None:
        setattr(struct, name + "_count", len(items))
        setattr(struct, name + "_stride", sizeof(kind))
        setattr(struct, plural or name + "s", (kind * len(items))(*items))

    def _control(self, control: Any) -> abi.fb_rig_control:
        name, group = text_bytes(control.name), text_bytes(control.group)
        return abi.fb_rig_control(name, group, control.minimum, control.maximum, control.rest)

    def _clip(self, clip: Clip) -> abi.fb_rig_clip:
        return clip_struct(clip, self._kept)

    def _mesh(self, mesh: Mesh) -> abi.fb_mesh:
        none = abi.FB_NO_MATERIAL
        runs = [abi.fb_material_run(r.polygons, none if r.material is None else r.material) for r in mesh.materials]
        return abi.fb_mesh(
            struct_size=sizeof(abi.fb_mesh),
            run_count=len(runs),
            name=text_bytes(mesh.name),
            runs=(abi.fb_material_run * len(runs))(*runs),
            vertex_count=mesh.vertices,
            polygon_count=mesh.polygons,
        )

    def _material(self, material: Material) -> abi.fb_material:
        textures = [
            abi.fb_texture(_index(SLOTS, t.slot), t.image, _index(WRAPS, t.wrap_u), _index(WRAPS, t.wrap_v), t.scale)
            for t in material.textures
        ]
        return abi.fb_material(
            struct_size=sizeof(abi.fb_material),
            alpha_mode=_index(ALPHA_MODES, material.alpha_mode),
            name=text_bytes(material.name),
            base_colour=tuple(material.base_colour),
            metallic=material.metallic,
            roughness=material.roughness,
            emissive=tuple(material.emissive),
            alpha_cutoff=material.alpha_cutoff,
            double_sided=int(material.double_sided),
            texture_count=len(textures),
            textures=(abi.fb_texture * len(textures))(*textures),
        )

    def _image(self, image: Image) -> abi.fb_image:
        data = np.frombuffer(image.data, np.uint8)
        self._kept.append(data)
        return abi.fb_image(
            struct_size=sizeof(abi.fb_image),
            name=text_bytes(image.name),
            media_type=text_bytes(image.media_type),
            bytes=data.ctypes.data,
            byte_count=len(data),
        )

    def _socket(self, socket: Socket) -> abi.fb_socket:
        struct = abi.fb_socket(
            struct_size=sizeof(abi.fb_socket),
            vertex_count=len(socket.vertices),
            name=text_bytes(socket.name),
            vertices=(c_uint32 * len(socket.vertices))(*map(int, socket.vertices)),
        )
        if socket.weights is not None:
            weights = np.asarray(socket.weights, np.float32)
            if weights.shape != (len(socket.vertices),):
                raise ValueError(f'socket "{socket.name}": {weights.shape} weights of {len(socket.vertices)} vertices')
            struct.weights = (c_float * len(weights))(*map(float, weights))
        if socket.frame is not None:
            struct.frame = _frame(socket.frame, f'socket "{socket.name}"')
        return struct

    def _channel(self, channel: Channel) -> abi.fb_channel:
        return abi.fb_channel(
            struct_size=sizeof(abi.fb_channel),
            name=text_bytes(channel.name),
            unit=text_bytes(channel.unit),
            minimum=channel.minimum,
            maximum=channel.maximum,
            rest=channel.rest,
        )

    def _joint(self, joint: Joint) -> abi.fb_joint:
        what, zeros = f'joint "{joint.name}"', (0.0,) * abi.FB_FRAME_FLOATS
        return abi.fb_joint(
            struct_size=sizeof(abi.fb_joint),
            parent=abi.FB_NO_JOINT if joint.parent is None else joint.parent,
            name=text_bytes(joint.name),
            rest=_frame(_IDENTITY if joint.rest is None else joint.rest, what),
            inverse_bind=_frame(zeros if joint.inverse_bind is None else joint.inverse_bind, what),
        )


def clip_struct(clip: Clip, kept: List[Any]) -> abi.fb_rig_clip:
    """A clip, whose controls are a contiguous float32 array, which is appended to `kept`."""
    controls: Any = clip.controls
    kept.append(controls)
    return abi.fb_rig_clip(
        name=text_bytes(clip.name),
        kind=KINDS.index(clip.kind),
        split=SPLITS.index(clip.split),
        fps=clip.fps,
        frames=len(controls),
        controls=controls.ctypes.data_as(ctypes.POINTER(c_float)),
    )


def _memory(address: int, rows: int, columns: int) -> Any:
    """The floats at an address as an array."""
    block: Any = (c_float * (rows * columns)).from_address(address)
    return np.frombuffer(block, np.float32).reshape(rows, columns)


def _frame(values: Any, what: str) -> Any:
    numbers = np.asarray(values, np.float32).ravel()
    if len(numbers) != abi.FB_FRAME_FLOATS:
        raise ValueError(f"{what}: a frame of {len(numbers)} numbers, not (3, 4)")
    return (c_float * abi.FB_FRAME_FLOATS)(*map(float, numbers))


def _index(words: Sequence[str], word: str) -> int:
    if word not in words:
        raise ValueError(f"{word!r} is none of {', '.join(words)}")
    return words.index(word)
