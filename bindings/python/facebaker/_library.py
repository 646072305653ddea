"""The ctypes interface of libfacebaker: finding the library, its functions and its errors."""

from __future__ import annotations

import ctypes
import ctypes.util
import os
import pathlib
from ctypes import POINTER, c_char_p, c_double, c_float, c_int32, c_size_t, c_uint16, c_uint32, c_uint64
from ctypes import c_void_p
from typing import Any, Dict, Iterable, List, Tuple

from . import _structs as s
from ._errors import STATUS_ERRORS, Error

Functions = Dict[str, Tuple[Any, List[Any]]]


class Library:
    """A shared library whose functions are attributes; opened when the first is used. Thread-safe."""

    def __init__(self, name: str, variable: str, functions: Functions) -> None:
        self._name, self._variable, self._functions = name, variable, functions

    def __getattr__(self, name: str) -> Any:
        if name not in self._functions:
            raise AttributeError(name)
        if "_opened" not in self.__dict__:
            self._opened = self._open()
        function = getattr(self._opened, name)
        function.restype, function.argtypes = self._functions[name]
        setattr(self, name, function)
        return function

    def check(self, status: int) -> None:
        """Raises Error unless status is FB_OK. To be called on the thread whose call gave the status."""
        if status != 0:
            name = self.fb_status_name(status).decode()
            message = self.fb_last_error().decode("utf-8", "replace")
            raise STATUS_ERRORS.get(status, Error)(status, name, message)

    def _candidates(self) -> List[str]:
        named = os.environ.get(self._variable)
        if named:
            return [named]
        file = f"lib{self._name}.so"
        places = [pathlib.Path(__file__).with_name(file)]
        if os.environ.get("FACEBAKER_LIBRARY"):
            places.insert(0, pathlib.Path(os.environ["FACEBAKER_LIBRARY"]).with_name(file))
        found = ctypes.util.find_library(self._name)
        return [str(place) for place in places if place.exists()] + ([found] if found else [])

    def _open(self) -> ctypes.CDLL:
        candidates = self._candidates()
        if not candidates:
            raise ImportError(f"lib{self._name} was not found; name it in the environment variable {self._variable}")
        try:
            return ctypes.CDLL(candidates[0])
        except OSError as error:
            # What a wheel carries for systems without it; once loaded, it is found by its name.
            if not _load_all(pathlib.Path(__file__).parent.glob("carried/*")):
                raise ImportError(str(error)) from error
        return ctypes.CDLL(candidates[0])


def _load_all(paths: Iterable[pathlib.Path]) -> int:
    """Loads libraries, of which some may need others; how many there are."""
    left = list(paths)
    count = len(left)
    while left:
        failed = [path for path in left if not _loads(path)]
        if len(failed) == len(left):
            break
        left = failed
    return count


def _loads(path: pathlib.Path) -> bool:
    try:
        ctypes.CDLL(str(path))
    except OSError:
        return False
    return True


# name: (result, arguments). Handles, and arrays that the caller gives, are void pointers.
_FUNCTIONS: Functions = {
    "fb_status_name": (c_char_p, [c_int32]),
    "fb_last_error": (c_char_p, []),
    "fb_version_string": (c_char_p, []),
    "fb_load_desc_fill": (None, [POINTER(s.LoadDesc), c_uint32]),
    "fb_load": (c_int32, [c_char_p, POINTER(s.LoadDesc), POINTER(c_void_p)]),
    "fb_load_memory": (c_int32, [c_char_p, c_size_t, POINTER(s.LoadDesc), POINTER(c_void_p)]),
    "fb_release": (None, [c_void_p]),
    "fb_vertex_count": (c_uint32, [c_void_p]),
    "fb_control_count": (c_uint32, [c_void_p]),
    "fb_coefficient_count": (c_uint32, [c_void_p]),
    "fb_name": (c_char_p, [c_void_p]),
    "fb_units": (c_char_p, [c_void_p]),
    "fb_up_axis": (c_char_p, [c_void_p]),
    "fb_provenance": (c_char_p, [c_void_p]),
    "fb_control_fill": (None, [POINTER(s.ControlStruct), c_uint32]),
    "fb_control_at": (c_int32, [c_void_p, c_uint32, POINTER(s.ControlStruct)]),
    "fb_find_control": (c_int32, [c_void_p, c_char_p, POINTER(c_uint32)]),
    "fb_rest_controls": (POINTER(c_float), [c_void_p]),
    "fb_rest_positions": (POINTER(c_float), [c_void_p]),
    "fb_diagonal": (c_double, [c_void_p]),
    "fb_polygon_count": (c_uint32, [c_void_p]),
    "fb_polygon_sizes": (POINTER(c_uint32), [c_void_p]),
    "fb_polygon_corner_count": (c_uint32, [c_void_p]),
    "fb_polygon_corners": (POINTER(c_uint32), [c_void_p]),
    "fb_uv_count": (c_uint32, [c_void_p]),
    "fb_uvs": (POINTER(c_float), [c_void_p]),
    "fb_uv_corners": (POINTER(c_uint32), [c_void_p]),
    "fb_tangent_signs": (POINTER(c_float), [c_void_p]),
    "fb_runtime_bytes": (c_uint64, [c_void_p]),
    "fb_scratch_create": (c_int32, [c_void_p, c_uint32, POINTER(c_void_p)]),
    "fb_scratch_create_single": (c_int32, [c_void_p, c_uint32, POINTER(c_void_p)]),
    "fb_scratch_destroy": (None, [c_void_p]),
    "fb_evaluate": (c_int32, [c_void_p, c_void_p, c_void_p, c_void_p]),
    "fb_clamped_count": (c_uint64, [c_void_p]),
    "fb_batch_desc_fill": (None, [POINTER(s.BatchDesc), c_uint32]),
    "fb_evaluate_batch": (c_int32, [c_void_p, c_void_p, POINTER(s.BatchDesc)]),
    "fb_many_desc_fill": (None, [POINTER(s.ManyDesc), c_uint32]),
    "fb_evaluate_many": (c_int32, [POINTER(s.ManyDesc), POINTER(c_uint32)]),
    "fb_evaluate_coefficients": (c_int32, [c_void_p, c_void_p, c_void_p, c_void_p]),
    "fb_instruction_set": (c_char_p, [c_void_p]),
    "fb_region_count": (c_uint32, [c_void_p]),
    "fb_region_name": (c_char_p, [c_void_p, c_uint32]),
    "fb_vertex_order": (POINTER(c_uint32), [c_void_p]),
    "fb_row_block_fill": (None, [POINTER(s.RowBlockStruct), c_uint32]),
    "fb_row_block_count": (c_uint32, [c_void_p]),
    "fb_row_block_at": (c_int32, [c_void_p, c_uint32, POINTER(s.RowBlockStruct)]),
    "fb_error_region_count": (c_uint32, [c_void_p]),
    "fb_error_region_name": (c_char_p, [c_void_p, c_uint32]),
    "fb_error_vertex_regions": (POINTER(c_uint32), [c_void_p]),
    "fb_level_count": (c_uint32, [c_void_p]),
    "fb_expected_error": (c_int32, [c_void_p, c_void_p, c_void_p, c_void_p, c_void_p]),
    "fb_row_block_values": (c_int32, [c_void_p, c_uint32, c_void_p, c_void_p]),
    "fb_mesh_fill": (None, [POINTER(s.MeshStruct), c_uint32]),
    "fb_mesh_count": (c_uint32, [c_void_p]),
    "fb_mesh_at": (c_int32, [c_void_p, c_uint32, POINTER(s.MeshStruct)]),
    "fb_find_mesh": (c_int32, [c_void_p, c_char_p, POINTER(c_uint32)]),
    "fb_material_fill": (None, [POINTER(s.MaterialStruct), c_uint32]),
    "fb_material_count": (c_uint32, [c_void_p]),
    "fb_material_at": (c_int32, [c_void_p, c_uint32, POINTER(s.MaterialStruct)]),
    "fb_image_fill": (None, [POINTER(s.ImageStruct), c_uint32]),
    "fb_image_count": (c_uint32, [c_void_p]),
    "fb_image_at": (c_int32, [c_void_p, c_uint32, POINTER(s.ImageStruct)]),
    "fb_socket_fill": (None, [POINTER(s.SocketStruct), c_uint32]),
    "fb_socket_count": (c_uint32, [c_void_p]),
    "fb_socket_at": (c_int32, [c_void_p, c_uint32, POINTER(s.SocketStruct)]),
    "fb_find_socket": (c_int32, [c_void_p, c_char_p, POINTER(c_uint32)]),
    "fb_channel_fill": (None, [POINTER(s.ChannelStruct), c_uint32]),
    "fb_channel_count": (c_uint32, [c_void_p]),
    "fb_channel_at": (c_int32, [c_void_p, c_uint32, POINTER(s.ChannelStruct)]),
    "fb_find_channel": (c_int32, [c_void_p, c_char_p, POINTER(c_uint32)]),
    "fb_exact_pose_fill": (None, [POINTER(s.ExactPoseStruct), c_uint32]),
    "fb_exact_pose_count": (c_uint32, [c_void_p]),
    "fb_exact_pose_at": (c_int32, [c_void_p, c_uint32, POINTER(s.ExactPoseStruct)]),
    "fb_joint_fill": (None, [POINTER(s.JointStruct), c_uint32]),
    "fb_joint_count": (c_uint32, [c_void_p]),
    "fb_joint_at": (c_int32, [c_void_p, c_uint32, POINTER(s.JointStruct)]),
    "fb_find_joint": (c_int32, [c_void_p, c_char_p, POINTER(c_uint32)]),
    "fb_level_fill": (None, [POINTER(s.LevelStruct), c_uint32]),
    "fb_level_at": (c_int32, [c_void_p, c_uint32, POINTER(s.LevelStruct)]),
    "fb_skin_influences": (c_uint32, [c_void_p]),
    "fb_skin_joints": (POINTER(c_uint16), [c_void_p]),
    "fb_skin_weights": (POINTER(c_float), [c_void_p]),
    "fb_about": (c_char_p, [c_void_p]),
    "fb_thumbnail": (c_void_p, [c_void_p, POINTER(c_uint64)]),
}

library = Library("facebaker", "FACEBAKER_LIBRARY", _FUNCTIONS)
check = library.check
