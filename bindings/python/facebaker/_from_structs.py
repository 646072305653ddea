"""What the structs of facebaker_character.h say, as the classes of _character. Arrays and bytes are copies."""

from __future__ import annotations

import ctypes
from typing import Any, Sequence, Tuple

import numpy as np

from . import _interop as abi
from ._character import ALPHA_MODES, NUMBERS, SLOTS, WRAPS, Channel, Control, DrivenJoint, ExactPose, Image, Joint, Level
from ._character import Material, MaterialRun, Mesh, Socket, Texture


def copied(pointer: Any, count: int) -> Any:
    """A NumPy copy of so many numbers."""
    return np.array(np.ctypeslib.as_array(pointer, (count,))) if count else np.zeros(0, np.dtype(pointer._type_))


def controls_of(structs: Sequence[abi.fb_control]) -> Tuple[Control, ...]:
    names = [struct.name.decode() for struct in structs]
    return tuple(
        Control(
            name, struct.group.decode(), struct.minimum, struct.maximum, struct.rest, unit=struct.unit.decode(),
            arkit=struct.arkit.decode(), facs=struct.facs.decode(),
            mirror="" if struct.mirror == abi.FB_NO_CONTROL else names[struct.mirror],
        )
        for name, struct in zip(names, structs)
    )  # fmt: skip


def mesh_of(struct: abi.fb_mesh) -> Mesh:
    none, runs = abi.FB_NO_MATERIAL, [struct.runs[i] for i in range(struct.run_count)]
    return Mesh(
        struct.name.decode(),
        struct.vertex_count,
        struct.polygon_count,
        tuple(MaterialRun(run.polygon_count, None if run.material == none else run.material) for run in runs),
        struct.first_vertex,
        struct.first_polygon,
        struct.first_corner,
        struct.corner_count,
    )


def material_of(struct: abi.fb_material) -> Material:
    textures = [struct.textures[i] for i in range(struct.texture_count)]
    return Material(
        struct.name.decode(),
        tuple(struct.base_colour),
        struct.metallic,
        struct.roughness,
        tuple(struct.emissive),
        ALPHA_MODES[struct.alpha_mode],
        struct.alpha_cutoff,
        bool(struct.double_sided),
        tuple(Texture(SLOTS[t.slot], t.image, WRAPS[t.wrap_u], WRAPS[t.wrap_v], t.scale) for t in textures),
    )


def image_of(struct: abi.fb_image) -> Image:
    data = ctypes.string_at(struct.bytes, struct.byte_count)
    return Image(struct.name.decode(), struct.media_type.decode(), data)


def _frame(values: Any) -> Any:
    return np.array(values, np.float32).reshape(3, 4)


def socket_of(struct: abi.fb_socket) -> Socket:
    count = struct.vertex_count
    return Socket(
        struct.name.decode(), copied(struct.vertices, count), copied(struct.weights, count), _frame(struct.frame)
    )


def channel_of(struct: abi.fb_channel) -> Channel:
    return Channel(struct.name.decode(), struct.minimum, struct.maximum, struct.rest, struct.unit.decode())


def joint_of(struct: abi.fb_joint) -> Joint:
    parent = None if struct.parent == abi.FB_NO_JOINT else struct.parent
    return Joint(struct.name.decode(), parent, _frame(struct.rest), _frame(struct.inverse_bind))


def driven_joint_of(struct: abi.fb_driven_joint) -> DrivenJoint:
    parent = None if struct.parent == abi.FB_NO_JOINT else struct.parent
    numbers = tuple(name for bit, name in enumerate(NUMBERS) if struct.numbers >> bit & 1)
    return DrivenJoint(struct.name.decode(), parent, numbers, _frame(struct.rest), struct.outer_rotations)


def exact_pose_of(struct: abi.fb_exact_pose) -> ExactPose:
    return ExactPose(struct.name.decode(), copied(struct.controls, struct.control_count))


def level_of(struct: abi.fb_level, meshes: int) -> Level:
    """meshes: how many the face has."""
    return Level(
        struct.vertex_count,
        copied(struct.polygon_sizes, struct.polygon_count),
        copied(struct.polygon_corners, struct.corner_count),
        copied(struct.uv_corners, struct.corner_count if struct.uv_corners else 0),
        tuple(mesh_of(struct.meshes[i]) for i in range(meshes)),
        struct.coefficient_count,
    )
