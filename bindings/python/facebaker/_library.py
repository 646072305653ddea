"""The ctypes interface of libfacebaker: loading the library, its structs, functions and errors."""

import ctypes
import ctypes.util
import os
import pathlib
from ctypes import POINTER, Structure, c_char_p, c_double, c_float, c_int32, c_size_t, c_uint32, c_uint64, c_void_p


class Error(Exception):
    """A call that failed. `status` is the number of facebaker.h, `status_name` its constant."""

    def __init__(self, status, status_name, message):
        super().__init__(message)
        self.status = status
        self.status_name = status_name


class ControlStruct(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("name", c_char_p),
        ("group", c_char_p),
        ("minimum", c_float),
        ("maximum", c_float),
        ("rest", c_float),
        ("reserved_float", c_float),
    ]


class BatchDesc(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("threads", c_uint32),
        ("poses", c_uint64),
        ("controls", POINTER(c_float)),
        ("control_floats", c_uint64),
        ("control_stride", c_uint64),
        ("positions", c_void_p),
        ("position_floats", c_uint64),
        ("pose_stride", c_uint64),
        ("vertex_stride", c_uint64),
        ("parallel_for", c_void_p),
        ("parallel_user", c_void_p),
        ("vertex_order", c_uint32),
        ("format", c_uint32),
        ("normals", c_void_p),
        ("normal_numbers", c_uint64),
        ("normal_pose_stride", c_uint64),
        ("normal_vertex_stride", c_uint64),
        ("regions", POINTER(c_uint32)),
        ("region_count", c_uint64),
        ("tangents", c_void_p),
        ("tangent_numbers", c_uint64),
        ("tangent_pose_stride", c_uint64),
        ("tangent_vertex_stride", c_uint64),
        ("meshes", POINTER(c_uint32)),
        ("mesh_count", c_uint64),
        ("sockets", POINTER(c_float)),
        ("socket_floats", c_uint64),
        ("socket_pose_stride", c_uint64),
        ("channels", POINTER(c_float)),
        ("channel_floats", c_uint64),
        ("channel_pose_stride", c_uint64),
        ("expected_errors", POINTER(c_float)),
        ("expected_error_floats", c_uint64),
        ("expected_error_pose_stride", c_uint64),
        ("outside", POINTER(c_uint32)),
        ("displacements", c_uint32),
        ("reserved_displacements", c_uint32),
        ("bounds", POINTER(c_float)),
        ("bounds_floats", c_uint64),
        ("bounds_pose_stride", c_uint64),
        ("lod", c_float),
        ("level_only", c_uint32),
    ]


class RowBlockStruct(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("first_row", c_uint32),
        ("row_count", c_uint32),
        ("column_count", c_uint32),
    ]


# name: (result, arguments). Handles are void pointers.
_FUNCTIONS = {
    "fb_status_name": (c_char_p, [c_int32]),
    "fb_last_error": (c_char_p, []),
    "fb_version_string": (c_char_p, []),
    "fb_load": (c_int32, [c_char_p, c_void_p, POINTER(c_void_p)]),
    "fb_load_memory": (c_int32, [c_char_p, c_size_t, c_void_p, POINTER(c_void_p)]),
    "fb_release": (None, [c_void_p]),
    "fb_vertex_count": (c_uint32, [c_void_p]),
    "fb_control_count": (c_uint32, [c_void_p]),
    "fb_coefficient_count": (c_uint32, [c_void_p]),
    "fb_name": (c_char_p, [c_void_p]),
    "fb_units": (c_char_p, [c_void_p]),
    "fb_up_axis": (c_char_p, [c_void_p]),
    "fb_provenance": (c_char_p, [c_void_p]),
    "fb_control_fill": (None, [POINTER(ControlStruct), c_uint32]),
    "fb_control_at": (c_int32, [c_void_p, c_uint32, POINTER(ControlStruct)]),
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
    "fb_scratch_destroy": (None, [c_void_p]),
    "fb_evaluate": (c_int32, [c_void_p, c_void_p, POINTER(c_float), POINTER(c_float)]),
    "fb_clamped_count": (c_uint64, [c_void_p]),
    "fb_batch_desc_fill": (None, [POINTER(BatchDesc), c_uint32]),
    "fb_evaluate_batch": (c_int32, [c_void_p, c_void_p, POINTER(BatchDesc)]),
    "fb_evaluate_coefficients": (c_int32, [c_void_p, c_void_p, POINTER(c_float), POINTER(c_float)]),
    "fb_instruction_set": (c_char_p, [c_void_p]),
    "fb_region_count": (c_uint32, [c_void_p]),
    "fb_region_name": (c_char_p, [c_void_p, c_uint32]),
    "fb_vertex_order": (POINTER(c_uint32), [c_void_p]),
    "fb_row_block_fill": (None, [POINTER(RowBlockStruct), c_uint32]),
    "fb_row_block_count": (c_uint32, [c_void_p]),
    "fb_row_block_at": (c_int32, [c_void_p, c_uint32, POINTER(RowBlockStruct)]),
    "fb_error_region_count": (c_uint32, [c_void_p]),
    "fb_error_region_name": (c_char_p, [c_void_p, c_uint32]),
    "fb_error_vertex_regions": (POINTER(c_uint32), [c_void_p]),
    "fb_level_count": (c_uint32, [c_void_p]),
    "fb_expected_error": (c_int32, [c_void_p, c_void_p, POINTER(c_float), POINTER(c_float), POINTER(c_uint32)]),
    "fb_row_block_values": (c_int32, [c_void_p, c_uint32, POINTER(c_uint32), POINTER(c_float)]),
}


def _candidates():
    named = os.environ.get("FACEBAKER_LIBRARY")
    if named:
        return [named]
    beside = sorted(pathlib.Path(__file__).parent.glob("libfacebaker.so*"))
    found = ctypes.util.find_library("facebaker")
    return [str(path) for path in beside] + ([found] if found else [])


def _open():
    candidates = _candidates()
    if not candidates:
        raise ImportError("libfacebaker was not found; name it in the environment variable FACEBAKER_LIBRARY")
    library = ctypes.CDLL(candidates[0])
    for name, (result, arguments) in _FUNCTIONS.items():
        function = getattr(library, name)
        function.restype = result
        function.argtypes = arguments
    return library


library = _open()
__version__ = library.fb_version_string().decode()


def check(status):
    """Raises Error unless status is FB_OK. To be called on the thread whose call gave the status."""
    if status != 0:
        raise Error(status, library.fb_status_name(status).decode(), library.fb_last_error().decode("utf-8", "replace"))
