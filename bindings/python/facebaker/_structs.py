"""The structs of facebaker.h as ctypes has them; the test of layouts compares them with the header."""

from ctypes import POINTER, Structure, c_char_p, c_float, c_uint32, c_uint64, c_void_p


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
