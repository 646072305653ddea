"""What a loaded face holds."""

from __future__ import annotations

import ctypes
import functools
import json
import weakref
from ctypes import POINTER, byref, c_void_p, cast
from typing import Any, Callable, Dict, List, Optional, Tuple, Type, TypeVar, Union

import numpy as np
import numpy.typing as npt

from . import _from_structs as read
from . import _interop as abi
from ._arrays import Floats, Indices, fan_corners
from ._character import About, Channel, Control, DrivenJoint, ExactPose, Image, Joint, Level, Material, Mesh, Skin, Socket
from ._library import AnyStruct, check, library
from ._scratches import ScratchPool

Item = TypeVar("Item")


class _Model:
    """A reference to a model, which the face and its arrays share."""

    def __init__(self, handle: c_void_p) -> None:
        self.handle = handle
        weakref.finalize(self, library.fb_release, handle)


class FaceContents:
    """The part of Face that does not pose.

    name, units ("cm", ...), up_axis ("y" or "z"): of the character. vertex_count, control_count; coefficient_count, the
    columns of the basis; level_count, levels of detail with level 0. diagonal: of the rest mesh's bounding box, in units.
    runtime_bytes: memory of the model. instruction_set: that poses are evaluated with. regions: names of the parts that
    have a network of their own. error_regions: names of those that expected errors are given for. controls: of class
    Control, in the order of every pose. source: the absolute path or the bytes that it was loaded from."""

    def __init__(self, handle: c_void_p, source: Union[str, bytes]) -> None:
        """Called by load(). Takes ownership of the reference in handle."""
        self._model: Optional[_Model] = _Model(handle)
        self.source = source
        self._scratches = ScratchPool(handle)
        self.vertex_count: int = library.fb_vertex_count(handle)
        self.control_count: int = library.fb_control_count(handle)
        self.coefficient_count: int = library.fb_coefficient_count(handle)
        self.level_count: int = library.fb_level_count(handle)
        self.name: str = library.fb_name(handle).decode()
        self.units: str = library.fb_units(handle).decode()
        self.up_axis: str = library.fb_up_axis(handle).decode()
        self.diagonal: float = library.fb_diagonal(handle)
        self.runtime_bytes: int = library.fb_runtime_bytes(handle)
        self.instruction_set: str = library.fb_instruction_set(handle).decode()
        self.regions = self._names(library.fb_region_count, library.fb_region_name)
        self.error_regions = self._names(library.fb_error_region_count, library.fb_error_region_name)
        structs = [self._struct(abi.fb_control, index) for index in range(self.control_count)]
        self.controls: Tuple[Control, ...] = read.controls_of(structs)

    def __repr__(self) -> str:
        source = f"{len(self.source)} bytes" if isinstance(self.source, bytes) else repr(self.source)
        counts = f"{self.control_count} controls, {self.vertex_count} vertices, {self.coefficient_count} coefficients"
        return f"<facebaker.Face {self.name!r} from {source}: {counts}>"

    def close(self) -> None:
        """Has the model freed once its arrays and the calls that are using it are gone, too. Further calls raise
        ValueError. Nobody needs to call this: a face that nothing refers to is freed as well."""
        self._model = None
        self._scratches.close()

    @property
    def _handle(self) -> c_void_p:
        if self._model is None:
            raise ValueError(f"the face {self.name!r} is closed")
        return self._model.handle

    # Texts and pictures

    @property
    def provenance(self) -> Dict[str, Any]:
        """How the archive was made, as a dictionary; empty if it is not recorded."""
        return _object(library.fb_provenance(self._handle))

    @property
    def about(self) -> About:
        """Whose the character is and what may be done with it, see docs/characters.md; empty if nothing is said."""
        return _object(library.fb_about(self._handle))

    @property
    def thumbnail(self) -> Optional[bytes]:
        """A picture of the character, the bytes of a square PNG; None if there is none."""
        count = ctypes.c_uint64()
        address = library.fb_thumbnail(self._handle, byref(count))
        return ctypes.string_at(address, count.value) if address else None

    @functools.cached_property
    def certificate(self) -> Dict[str, Any]:
        """The errors measured when the face was baked, as FORMAT.md has them; empty without. The archive is read again, by
        libfacebaker_bake."""
        return _object(self._archive_text("certificate").encode())

    @functools.cached_property
    def licence(self) -> str:
        """The text of the licence; "" if there is none. The archive is read again, by libfacebaker_bake."""
        return self._archive_text("licence")

    def _archive_text(self, field: str) -> str:
        from ._archive import Archive

        return Archive(self.source).text(field)

    # Controls and rest mesh

    @property
    def names(self) -> List[str]:
        """The names of the controls."""
        return [control.name for control in self.controls]

    @property
    def ranges(self) -> Floats:
        """(controls, 2): minimum and maximum of every control."""
        return np.array([(c.minimum, c.maximum) for c in self.controls], np.float32)

    @property
    def rest_controls(self) -> Floats:
        """(controls,): their values in the rest pose."""
        return self._view(library.fb_rest_controls(self._handle), self.control_count)

    @property
    def rest_positions(self) -> Floats:
        """(vertices, 3), in units."""
        return self._view(library.fb_rest_positions(self._handle), 3 * self.vertex_count, (self.vertex_count, 3))

    @property
    def polygon_sizes(self) -> Indices:
        """(polygons,): corners of every polygon."""
        return self._view(library.fb_polygon_sizes(self._handle), library.fb_polygon_count(self._handle))

    @property
    def polygon_corners(self) -> Indices:
        """(corners,): vertex indices, polygon after polygon."""
        return self._view(library.fb_polygon_corners(self._handle), self._corner_count)

    @functools.cached_property
    def triangle_corners(self) -> Indices:
        """(triangles, 3): indices of polygon_corners and uv_corners; every polygon as a fan around its first corner."""
        return _frozen(fan_corners(self.polygon_sizes))

    @functools.cached_property
    def triangles(self) -> Indices:
        """(triangles, 3): vertex indices, for programs that draw triangles."""
        corners = self.triangle_corners
        return _frozen(self.polygon_corners[corners] if len(corners) else corners)

    @property
    def uvs(self) -> Floats:
        """(texture coordinates, 2): u and v, v growing upwards; empty if the source had none."""
        count = library.fb_uv_count(self._handle)
        return self._view(library.fb_uvs(self._handle), 2 * count, (count, 2))

    @property
    def uv_corners(self) -> Indices:
        """(corners,): the index into uvs of every polygon corner; empty without texture coordinates."""
        count = self._corner_count if library.fb_uv_count(self._handle) else 0
        return self._view(library.fb_uv_corners(self._handle), count)

    @property
    def tangent_signs(self) -> Floats:
        """(vertices,): -1 where the texture is mirrored, else 1; empty without texture coordinates."""
        count = self.vertex_count if library.fb_uv_count(self._handle) else 0
        return self._view(library.fb_tangent_signs(self._handle), count)

    @property
    def vertex_order(self) -> Indices:
        """(vertices,): baked order, the source index of every vertex."""
        order = library.fb_vertex_order(self._handle)
        if not order:
            return np.arange(self.vertex_count, dtype=np.uint32)
        return self._view(order, self.vertex_count)

    @property
    def error_vertex_regions(self) -> Indices:
        """(vertices,): the index into error_regions of every vertex; empty if there are none."""
        count = self.vertex_count if self.error_regions else 0
        return self._view(library.fb_error_vertex_regions(self._handle), count)

    # The character; see docs/characters.md

    @functools.cached_property
    def meshes(self) -> Tuple[Mesh, ...]:
        """At least one."""
        return self._items(abi.fb_mesh, read.mesh_of)

    @functools.cached_property
    def materials(self) -> Tuple[Material, ...]:
        return self._items(abi.fb_material, read.material_of)

    @functools.cached_property
    def images(self) -> Tuple[Image, ...]:
        """Picture files as they are, for the textures of materials."""
        return self._items(abi.fb_image, read.image_of)

    @functools.cached_property
    def sockets(self) -> Tuple[Socket, ...]:
        """Named frames that follow the surface; evaluate_batch gives them for poses."""
        return self._items(abi.fb_socket, read.socket_of)

    @functools.cached_property
    def channels(self) -> Tuple[Channel, ...]:
        """Named numbers beside positions; evaluate_batch gives them for poses."""
        return self._items(abi.fb_channel, read.channel_of)

    @functools.cached_property
    def joints(self) -> Tuple[Joint, ...]:
        """The skeleton that carries the face."""
        return self._items(abi.fb_joint, read.joint_of)

    @property
    def skin(self) -> Optional[Skin]:
        """How vertices follow joints: a pair of (vertices, influences), joints uint16 and weights float32; None if the face
        has no skin. Positions are those before skinning."""
        influences = library.fb_skin_influences(self._handle)
        if influences == 0:
            return None
        shape, count = (self.vertex_count, influences), self.vertex_count * influences
        joints: npt.NDArray[np.uint16] = self._view(library.fb_skin_joints(self._handle), count, shape)
        weights: Floats = self._view(library.fb_skin_weights(self._handle), count, shape)
        return Skin(joints, weights)

    @functools.cached_property
    def driven_joints(self) -> Tuple[DrivenJoint, ...]:
        """Joints that the controls move; evaluate_batch gives where they are in poses."""
        return self._items(abi.fb_driven_joint, read.driven_joint_of)

    @property
    def driven_skin(self) -> Optional[Skin]:
        """How vertices follow driven joints, as skin; weights of a vertex sum to at most 1. None if there are none."""
        influences = library.fb_driven_influences(self._handle)
        if influences == 0:
            return None
        shape, count = (self.vertex_count, influences), self.vertex_count * influences
        joints: npt.NDArray[np.uint16] = self._view(library.fb_driven_skin_joints(self._handle), count, shape)
        weights: Floats = self._view(library.fb_driven_skin_weights(self._handle), count, shape)
        return Skin(joints, weights)

    @functools.cached_property
    def exact_poses(self) -> Tuple[ExactPose, ...]:
        """Poses that come out as the rig gave them."""
        return self._items(abi.fb_exact_pose, read.exact_pose_of)

    @functools.cached_property
    def levels(self) -> Tuple[Level, ...]:
        """Levels of detail, with level 0, the whole; evaluate_batch's lod chooses among them."""
        structs = [self._struct(abi.fb_level, index) for index in range(self.level_count)]
        return tuple(read.level_of(struct, len(self.meshes)) for struct in structs)

    @property
    def _corner_count(self) -> int:
        count: int = library.fb_polygon_corner_count(self._handle)
        return count

    def _names(self, count: Any, name: Any) -> Tuple[str, ...]:
        return tuple(name(self._handle, index).decode() for index in range(count(self._handle)))

    def _struct(self, kind: Type[AnyStruct], index: int) -> AnyStruct:
        made = library.filled(kind)
        check(getattr(library, f"{kind.__name__}_at")(self._handle, index, made))
        return made

    def _items(self, kind: Type[AnyStruct], convert: Callable[[AnyStruct], Item]) -> Tuple[Item, ...]:
        count = getattr(library, f"{kind.__name__}_count")(self._handle)
        return tuple(convert(self._struct(kind, index)) for index in range(count))

    def _view(self, pointer: Any, count: int, shape: Optional[Tuple[int, ...]] = None) -> npt.NDArray[Any]:
        """A read-only array over memory of the model, which it keeps alive."""
        if count == 0:
            return np.empty(shape or 0, np.dtype(pointer._type_))
        memory = cast(pointer, POINTER(pointer._type_ * count)).contents
        memory._model = self._model
        return _frozen(np.ctypeslib.as_array(memory).reshape(shape or count))


def _frozen(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    array.flags.writeable = False
    return array


def _object(text: Optional[bytes]) -> Dict[str, Any]:
    """A JSON object; empty without a text, or if it is something else."""
    try:
        value = json.loads(text or b"{}")
    except ValueError:
        return {}
    return value if isinstance(value, dict) else {}
