"""A rig's description as the JSON that the rig protocol and dataset folders share; see docs/rig-protocol.md."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any, Dict, List, Optional

import numpy as np

from ._arrays import ArrayLike
from ._character import Channel, Control, Joint, Material, Mesh, Socket
from ._rig import Rig

Fields = Dict[str, Any]


def character_fields(rig: Rig, images: List[Fields]) -> Fields:
    """Everything about the character but its rest mesh, skin and clips. images: what is said of each image besides its
    name and media type."""
    fields: Fields = {
        "name": rig.name,
        "units": rig.units,
        "up_axis": rig.up_axis,
        "controls": [_control(control) for control in rig.controls],
        "meshes": [_mesh(mesh) for mesh in rig.meshes],
        "materials": [_material(material) for material in rig.materials],
        "images": [
            {"name": image.name, "media_type": image.media_type, **more} for image, more in zip(rig.images, images)
        ],
        "sockets": [socket_fields(socket) for socket in rig.sockets],
        "joints": [_joint(joint) for joint in rig.joints],
        "channels": [_channel(channel) for channel in rig.channels],
    }
    if rig.about is not None:
        fields["about"] = rig.about
    return {key: value for key, value in fields.items() if value != []}


def _control(control: Control) -> Fields:
    fields = _range(control)
    for key in "group", "unit", "arkit", "facs", "mirror":
        if getattr(control, key):
            fields[key] = getattr(control, key)
    return fields


def _range(named: Any) -> Fields:
    return {"name": named.name, "min": float(named.minimum), "max": float(named.maximum), "default": float(named.rest)}


def _channel(channel: Channel) -> Fields:
    fields = _range(channel)
    if channel.unit:
        fields["unit"] = channel.unit
    return fields


def _mesh(mesh: Mesh) -> Fields:
    runs: List[Fields] = []
    for run in mesh.materials:
        runs.append({"polygons": run.polygons})
        if run.material is not None:
            runs[-1]["material"] = run.material
    fields = {"name": mesh.name, "vertices": mesh.vertices, "polygons": mesh.polygons}
    return {**fields, "materials": runs} if runs else fields


def _material(material: Material) -> Fields:
    return {**asdict(material), "textures": [asdict(texture) for texture in material.textures]}


def _numbers(values: Optional[ArrayLike]) -> List[float]:
    numbers: List[float] = np.asarray(values, np.float32).ravel().tolist()
    return numbers


def socket_fields(socket: Socket) -> Fields:
    fields: Fields = {"name": socket.name, "vertices": np.asarray(socket.vertices).tolist()}
    if socket.weights is not None:
        fields["weights"] = _numbers(socket.weights)
    if socket.frame is not None:
        fields["frame"] = _numbers(socket.frame)
    return fields


def _joint(joint: Joint) -> Fields:
    fields: Fields = {"name": joint.name}
    if joint.parent is not None:
        fields["parent"] = joint.parent
    if joint.rest is not None:
        fields["rest"] = _numbers(joint.rest)
    if joint.inverse_bind is not None:
        fields["inverse_bind"] = _numbers(joint.inverse_bind)
    if joint.numbers:
        fields["numbers"] = list(joint.numbers)
    return fields
