"""The structs of facebaker.h and facebaker_character.h as ctypes has them. A test compares them with the headers, field by
field, so fields are called as they are there."""

from __future__ import annotations

from ctypes import CFUNCTYPE, POINTER, Structure, c_char_p, c_float, c_uint32, c_uint64, c_void_p, sizeof
from typing import Any, TypeVar

FRAME_FLOATS = 12
NONE = 0xFFFFFFFF  # FB_NO_CONTROL, FB_NO_MATERIAL, FB_NO_JOINT

AnyStruct = TypeVar("AnyStruct", bound=Structure)


def filled(struct: "type[AnyStruct]", fill: Any) -> AnyStruct:
    """A struct with the library's defaults, by its fb_..._fill."""
    made = struct()
    fill(made, sizeof(made))
    return made


def assign(struct: Structure, **values: "int | float") -> None:
    """Sets numbers of a struct. Raises ValueError on one that the field cannot hold, which ctypes would cut."""
    for name, value in values.items():
        setattr(struct, name, value)
        if getattr(struct, name) != value:
            raise ValueError(f"{name} is {value}")


LogFunction = CFUNCTYPE(None, c_void_p, c_char_p)


class AllocatorStruct(Structure):
    c_name = "fb_allocator"
    _fields_ = [("user", c_void_p), ("allocate", c_void_p), ("release", c_void_p)]


class LoadDesc(Structure):
    c_name = "fb_load_desc"
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("max_file_bytes", c_uint64),
        ("max_model_bytes", c_uint64),
        ("allocator", AllocatorStruct),
        ("log", LogFunction),
        ("log_user", c_void_p),
        ("instruction_set", c_char_p),
        ("map_file", c_uint32),
        ("reserved_number", c_uint32),
        ("max_name_bytes", c_uint64),
        ("max_vertices", c_uint64),
        ("max_polygons", c_uint64),
        ("max_features", c_uint64),
        ("parallel_for", c_void_p),
        ("parallel_user", c_void_p),
        ("threads", c_uint32),
        ("reserved_threads", c_uint32),
    ]


class ControlStruct(Structure):
    c_name = "fb_control"
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("name", c_char_p),
        ("group", c_char_p),
        ("minimum", c_float),
        ("maximum", c_float),
        ("rest", c_float),
        ("mirror", c_uint32),
        ("arkit", c_char_p),
        ("facs", c_char_p),
        ("unit", c_char_p),
    ]


class BatchDesc(Structure):
    c_name = "fb_batch_desc"
    _fields_ = [
        ("struct_size", c_uint32),
        ("threads", c_uint32),
        ("poses", c_uint64),
        ("controls", c_void_p),
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
        ("sockets", c_void_p),
        ("socket_floats", c_uint64),
        ("socket_pose_stride", c_uint64),
        ("channels", c_void_p),
        ("channel_floats", c_uint64),
        ("channel_pose_stride", c_uint64),
        ("expected_errors", c_void_p),
        ("expected_error_floats", c_uint64),
        ("expected_error_pose_stride", c_uint64),
        ("outside", c_void_p),
        ("displacements", c_uint32),
        ("reserved_displacements", c_uint32),
        ("bounds", c_void_p),
        ("bounds_floats", c_uint64),
        ("bounds_pose_stride", c_uint64),
        ("lod", c_float),
        ("level_only", c_uint32),
    ]


class ManyItem(Structure):
    c_name = "fb_many_item"
    _fields_ = [("model", c_void_p), ("scratch", c_void_p), ("batch", POINTER(BatchDesc))]


class ManyDesc(Structure):
    c_name = "fb_many_desc"
    _fields_ = [
        ("struct_size", c_uint32),
        ("threads", c_uint32),
        ("items", POINTER(ManyItem)),
        ("item_count", c_uint32),
        ("reserved", c_uint32),
        ("parallel_for", c_void_p),
        ("parallel_user", c_void_p),
    ]


class RowBlockStruct(Structure):
    c_name = "fb_row_block"
    _fields_ = [
        ("struct_size", c_uint32),
        ("first_row", c_uint32),
        ("row_count", c_uint32),
        ("column_count", c_uint32),
        ("digit_column_count", c_uint32),
    ]


class MaterialRunStruct(Structure):
    c_name = "fb_material_run"
    _fields_ = [("polygon_count", c_uint32), ("material", c_uint32)]


class MeshStruct(Structure):
    c_name = "fb_mesh"
    _fields_ = [
        ("struct_size", c_uint32),
        ("run_count", c_uint32),
        ("name", c_char_p),
        ("runs", POINTER(MaterialRunStruct)),
        ("vertex_count", c_uint32),
        ("polygon_count", c_uint32),
        ("first_vertex", c_uint32),
        ("first_polygon", c_uint32),
        ("first_corner", c_uint32),
        ("corner_count", c_uint32),
    ]


class TextureStruct(Structure):
    c_name = "fb_texture"
    _fields_ = [("slot", c_uint32), ("image", c_uint32), ("wrap_u", c_uint32), ("wrap_v", c_uint32), ("scale", c_float)]


class MaterialStruct(Structure):
    c_name = "fb_material"
    _fields_ = [
        ("struct_size", c_uint32),
        ("alpha_mode", c_uint32),
        ("name", c_char_p),
        ("base_colour", c_float * 4),
        ("metallic", c_float),
        ("roughness", c_float),
        ("emissive", c_float * 3),
        ("alpha_cutoff", c_float),
        ("double_sided", c_uint32),
        ("texture_count", c_uint32),
        ("textures", POINTER(TextureStruct)),
    ]


class ImageStruct(Structure):
    c_name = "fb_image"
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("name", c_char_p),
        ("media_type", c_char_p),
        ("bytes", c_void_p),
        ("byte_count", c_uint64),
    ]


class SocketStruct(Structure):
    c_name = "fb_socket"
    _fields_ = [
        ("struct_size", c_uint32),
        ("vertex_count", c_uint32),
        ("name", c_char_p),
        ("vertices", POINTER(c_uint32)),
        ("weights", POINTER(c_float)),
        ("frame", c_float * FRAME_FLOATS),
    ]


class ChannelStruct(Structure):
    c_name = "fb_channel"
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("name", c_char_p),
        ("unit", c_char_p),
        ("minimum", c_float),
        ("maximum", c_float),
        ("rest", c_float),
    ]


class ExactPoseStruct(Structure):
    c_name = "fb_exact_pose"
    _fields_ = [
        ("struct_size", c_uint32),
        ("control_count", c_uint32),
        ("name", c_char_p),
        ("controls", POINTER(c_float)),
    ]


class JointStruct(Structure):
    c_name = "fb_joint"
    _fields_ = [
        ("struct_size", c_uint32),
        ("parent", c_uint32),
        ("name", c_char_p),
        ("rest", c_float * FRAME_FLOATS),
        ("inverse_bind", c_float * FRAME_FLOATS),
    ]


class LevelStruct(Structure):
    c_name = "fb_level"
    _fields_ = [
        ("struct_size", c_uint32),
        ("vertex_count", c_uint32),
        ("polygon_count", c_uint32),
        ("corner_count", c_uint32),
        ("polygon_sizes", POINTER(c_uint32)),
        ("polygon_corners", POINTER(c_uint32)),
        ("uv_corners", POINTER(c_uint32)),
        ("meshes", POINTER(MeshStruct)),
        ("coefficient_count", c_uint32),
        ("reserved", c_uint32),
    ]


RUNTIME_STRUCTS = (
    AllocatorStruct,
    LoadDesc,
    ControlStruct, BatchDesc, ManyItem, ManyDesc, RowBlockStruct, MaterialRunStruct, MeshStruct, TextureStruct,
    MaterialStruct, ImageStruct, SocketStruct, ChannelStruct, ExactPoseStruct, JointStruct, LevelStruct,
)  # fmt: skip
