"""The ctypes interface of libfacebaker: finding the library, its functions and its errors."""

import ctypes
import ctypes.util
import os
import pathlib
from ctypes import POINTER, c_char_p, c_double, c_float, c_int32, c_size_t, c_uint32, c_uint64, c_void_p

from ._errors import STATUS_ERRORS, Error
from ._structs import BatchDesc, ControlStruct, RowBlockStruct

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


def _candidates(variable, name):
    named = os.environ.get(variable)
    if named:
        return [named]
    beside = pathlib.Path(__file__).with_name(f"lib{name}.so")
    found = ctypes.util.find_library(name)
    return ([str(beside)] if beside.exists() else []) + ([found] if found else [])


class Library:
    """A library that is opened when its first function is used; functions are attributes."""

    def __init__(self, variable, name, functions):
        self._variable, self._name, self._functions = variable, name, functions

    def __getattr__(self, name):
        if name not in self._functions:
            raise AttributeError(name)
        if "_opened" not in self.__dict__:
            self._opened = self._open()
        function = getattr(self._opened, name)
        function.restype, function.argtypes = self._functions[name]
        setattr(self, name, function)
        return function

    def _open(self):
        candidates = _candidates(self._variable, self._name)
        if not candidates:
            raise ImportError(
                f"lib{self._name} was not found; name it in the environment variable {self._variable}"
            )
        return ctypes.CDLL(candidates[0])

    def check(self, status):
        """Raises Error unless status is FB_OK. To be called on the thread whose call gave the status."""
        if status != 0:
            name = self.fb_status_name(status).decode()
            message = self.fb_last_error().decode("utf-8", "replace")
            raise STATUS_ERRORS.get(status, Error)(status, name, message)


library = Library("FACEBAKER_LIBRARY", "facebaker", _FUNCTIONS)
check = library.check
