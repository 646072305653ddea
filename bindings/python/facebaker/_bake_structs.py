"""The structs of facebaker_bake.h and the headers it includes as ctypes has them; see _structs."""

from __future__ import annotations

from ctypes import CFUNCTYPE, POINTER, Structure, c_char_p, c_double, c_float, c_int32, c_uint16, c_uint32, c_uint64
from ctypes import c_void_p

from ._structs import ChannelStruct, ImageStruct, JointStruct, MaterialStruct, MeshStruct, SocketStruct

ProgressFunction = CFUNCTYPE(c_int32, c_void_p, c_char_p, c_uint64, c_uint64)
NoteFunction = CFUNCTYPE(None, c_void_p, c_char_p)
# Arrays and the message's buffer are addresses.
EvaluateFunction = CFUNCTYPE(c_int32, c_void_p, c_uint64, c_void_p, c_void_p, c_void_p, c_uint32)
EvaluateAllFunction = CFUNCTYPE(c_int32, c_void_p, c_uint64, c_void_p, c_void_p, c_void_p, c_void_p, c_uint32)


class RigControlStruct(Structure):
    c_name = "fb_rig_control"
    _fields_ = [
        ("name", c_char_p),
        ("group", c_char_p),
        ("minimum", c_float),
        ("maximum", c_float),
        ("rest", c_float),
        ("reserved", c_uint32),
    ]


class RigLabelsStruct(Structure):
    c_name = "fb_rig_labels"
    _fields_ = [("arkit", c_char_p), ("facs", c_char_p), ("unit", c_char_p), ("mirror", c_char_p)]


class RigClipStruct(Structure):
    c_name = "fb_rig_clip"
    _fields_ = [
        ("name", c_char_p),
        ("kind", c_int32),
        ("split", c_int32),
        ("fps", c_double),
        ("frames", c_uint32),
        ("reserved", c_uint32),
        ("controls", POINTER(c_float)),
    ]


class RigStruct(Structure):
    c_name = "fb_rig"
    _fields_ = [
        ("struct_size", c_uint32),
        ("abi", c_uint32),
        ("name", c_char_p),
        ("units", c_char_p),
        ("up_axis", c_char_p),
        ("flags", c_uint32),
        ("control_count", c_uint32),
        ("controls", POINTER(RigControlStruct)),
        ("control_stride", c_uint32),
        ("clip_stride", c_uint32),
        ("vertex_count", c_uint32),
        ("polygon_count", c_uint32),
        ("rest_positions", POINTER(c_float)),
        ("polygon_sizes", POINTER(c_uint32)),
        ("polygon_corners", POINTER(c_uint32)),
        ("clip_count", c_uint32),
        ("reserved", c_uint32),
        ("clips", POINTER(RigClipStruct)),
        ("user", c_void_p),
        ("evaluate", EvaluateFunction),
        ("destroy", c_void_p),
        ("uv_count", c_uint32),
        ("reserved_uv", c_uint32),
        ("uvs", POINTER(c_float)),
        ("uv_corners", POINTER(c_uint32)),
        ("preferred_block", c_uint32),
        ("reserved_block", c_uint32),
        ("version", c_char_p),
        ("mesh_count", c_uint32),
        ("mesh_stride", c_uint32),
        ("meshes", POINTER(MeshStruct)),
        ("material_count", c_uint32),
        ("material_stride", c_uint32),
        ("materials", POINTER(MaterialStruct)),
        ("image_count", c_uint32),
        ("image_stride", c_uint32),
        ("images", POINTER(ImageStruct)),
        ("label_stride", c_uint32),
        ("reserved_labels", c_uint32),
        ("labels", POINTER(RigLabelsStruct)),
        ("socket_count", c_uint32),
        ("socket_stride", c_uint32),
        ("sockets", POINTER(SocketStruct)),
        ("about", c_char_p),
        ("channel_count", c_uint32),
        ("channel_stride", c_uint32),
        ("channels", POINTER(ChannelStruct)),
        ("evaluate_all", EvaluateAllFunction),
        ("joint_count", c_uint32),
        ("joint_stride", c_uint32),
        ("joints", POINTER(JointStruct)),
        ("skin_influences", c_uint32),
        ("reserved_skin", c_uint32),
        ("skin_joints", POINTER(c_uint16)),
        ("skin_weights", POINTER(c_float)),
        ("evaluate_skinned", c_void_p),
    ]


class CallbacksStruct(Structure):
    c_name = "fb_callbacks"
    _fields_ = [("user", c_void_p), ("progress", ProgressFunction), ("note", NoteFunction)]


class SourceDesc(Structure):
    c_name = "fb_source_desc"
    _fields_ = [
        ("struct_size", c_uint32),
        ("path_count", c_uint32),
        ("paths", POINTER(c_char_p)),
        ("rig", POINTER(RigStruct)),
        ("callbacks", CallbacksStruct),
        ("workers", c_uint32),
        ("reserved", c_uint32),
        ("host", c_char_p),
        ("pose_seconds", c_double),
        ("clip_budget", c_uint64),
        ("joints", c_uint32),
        ("control_joint_count", c_uint32),
        ("control_joints", POINTER(c_char_p)),
        ("test_poses", c_uint64),
        ("skip_broken", c_uint32),
        ("reserved_broken", c_uint32),
    ]


class SourceInfoStruct(Structure):
    c_name = "fb_source_info"
    _fields_ = [
        ("struct_size", c_uint32),
        ("flags", c_uint32),
        ("name", c_char_p),
        ("units", c_char_p),
        ("up_axis", c_char_p),
        ("diagonal", c_double),
        ("control_count", c_uint32),
        ("clip_count", c_uint32),
        ("vertex_count", c_uint32),
        ("polygon_count", c_uint32),
        ("polygon_corner_count", c_uint32),
        ("uv_count", c_uint32),
        ("rest_positions", POINTER(c_float)),
        ("polygon_sizes", POINTER(c_uint32)),
        ("polygon_corners", POINTER(c_uint32)),
        ("uvs", POINTER(c_float)),
        ("uv_corners", POINTER(c_uint32)),
        ("identity", c_char_p),
        ("channel_count", c_uint32),
        ("preferred_block", c_uint32),
    ]


class ClipStruct(Structure):
    c_name = "fb_clip"
    _fields_ = [
        ("struct_size", c_uint32),
        ("kind", c_int32),
        ("split", c_int32),
        ("readable", c_uint32),
        ("name", c_char_p),
        ("fps", c_double),
        ("frames", c_uint64),
        ("controls", POINTER(c_float)),
    ]


class SampleDesc(Structure):
    c_name = "fb_sample_desc"
    _fields_ = [
        ("struct_size", c_uint32),
        ("threads", c_uint32),
        ("source", c_void_p),
        ("directory", c_char_p),
        ("poses", c_uint64),
        ("seed", c_uint64),
        ("mix", c_char_p),
        ("rig_budget", c_uint64),
        ("shots", c_uint32),
        ("clip_count", c_uint32),
        ("clips", POINTER(RigClipStruct)),
        ("clip_stride", c_uint32),
        ("reserved", c_uint32),
        ("callbacks", CallbacksStruct),
        ("skip_failing", c_uint32),
        ("example_count", c_uint32),
        ("examples", POINTER(c_char_p)),
        ("schema", c_char_p),
    ]


class CheckDesc(Structure):
    c_name = "fb_check_desc"
    _fields_ = [
        ("struct_size", c_uint32),
        ("threads", c_uint32),
        ("directory", c_char_p),
        ("callbacks", CallbacksStruct),
    ]


class BakeDesc(Structure):
    c_name = "fb_bake_desc"
    _fields_ = [
        ("struct_size", c_uint32),
        ("threads", c_uint32),
        ("source", c_void_p),
        ("archive", c_char_p),
        ("recipe", c_char_p),
        ("use", c_int32),
        ("epochs", c_uint32),
        ("poses", c_uint64),
        ("mix", c_char_p),
        ("rig_budget", c_uint64),
        ("seed", c_uint64),
        ("max_bytes", c_uint64),
        ("max_error", c_double),
        ("force", c_uint32),
        ("measure", c_uint32),
        ("learning_curve", c_uint32),
        ("reserved", c_uint32),
        ("licence", c_char_p),
        ("created", c_char_p),
        ("work", c_char_p),
        ("callbacks", CallbacksStruct),
        ("reuse", c_char_p),
        ("skip_failing", c_uint32),
        ("example_count", c_uint32),
        ("examples", POINTER(c_char_p)),
        ("normal_weight", c_double),
        ("cache_bytes", c_uint64),
        ("about", c_char_p),
        ("thumbnail", c_void_p),
        ("thumbnail_bytes", c_uint64),
        ("exact", POINTER(c_char_p)),
        ("exact_count", c_uint32),
        ("reserved2", c_uint32),
        ("level_share_count", c_uint32),
        ("level_mesh_count", c_uint32),
        ("level_shares", POINTER(c_double)),
        ("level_meshes", POINTER(c_char_p)),
    ]


class CompareDesc(Structure):
    c_name = "fb_compare_desc"
    _fields_ = [
        ("struct_size", c_uint32),
        ("threads", c_uint32),
        ("source", c_void_p),
        ("methods", POINTER(c_char_p)),
        ("method_count", c_uint32),
        ("epochs", c_uint32),
        ("poses", c_uint64),
        ("mix", c_char_p),
        ("rig_budget", c_uint64),
        ("seed", c_uint64),
        ("learning_curve", c_uint32),
        ("reserved", c_uint32),
        ("work", c_char_p),
        ("callbacks", CallbacksStruct),
    ]


class EvalDesc(Structure):
    c_name = "fb_eval_desc"
    _fields_ = [
        ("struct_size", c_uint32),
        ("threads", c_uint32),
        ("archive", c_void_p),
        ("source", c_void_p),
        ("split", c_int32),
        ("measure", c_uint32),
        ("callbacks", CallbacksStruct),
    ]


class PackDesc(Structure):
    c_name = "fb_pack_desc"
    _fields_ = [
        ("struct_size", c_uint32),
        ("force", c_uint32),
        ("path", c_char_p),
        ("bytes", c_char_p),
        ("byte_count", c_uint64),
        ("out", c_char_p),
        ("seed", c_uint64),
        ("max_bytes", c_uint64),
        ("max_error", c_double),
        ("licence", c_char_p),
        ("callbacks", CallbacksStruct),
        ("about", c_char_p),
        ("thumbnail", c_void_p),
        ("thumbnail_bytes", c_uint64),
        ("sockets", c_char_p),
    ]


class ErrorsStruct(Structure):
    c_name = "fb_errors"
    _fields_ = [
        ("frames", c_uint64),
        ("mse", c_double),
        ("rms", c_double),
        ("mean", c_double),
        ("p99", c_double),
        ("max", c_double),
        ("mfm", c_double),
        ("worst_frame", c_uint64),
    ]


class MethodStruct(Structure):
    c_name = "fb_method"
    _fields_ = [
        ("struct_size", c_uint32),
        ("use", c_int32),
        ("name", c_char_p),
        ("archive", c_void_p),
        ("archive_bytes", c_uint64),
        ("poses", c_uint64),
        ("parameters", c_uint64),
        ("coefficients", c_uint64),
        ("rig_calls", c_uint64),
        ("train_seconds", c_double),
        ("unseen", ErrorsStruct),
        ("dependency", ErrorsStruct),
        ("quantisation", ErrorsStruct),
        ("clip_count", c_uint32),
        ("reserved", c_uint32),
    ]


class ClipErrorsStruct(Structure):
    c_name = "fb_clip_errors"
    _fields_ = [
        ("struct_size", c_uint32),
        ("kind", c_int32),
        ("split", c_int32),
        ("reserved", c_uint32),
        ("name", c_char_p),
        ("errors", ErrorsStruct),
    ]


class FailureStruct(Structure):
    c_name = "fb_failure"
    _fields_ = [("struct_size", c_uint32), ("use", c_int32), ("name", c_char_p), ("reason", c_char_p)]


class SampleResultStruct(Structure):
    c_name = "fb_sample_result"
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("poses", c_uint64),
        ("evaluated", c_uint64),
        ("rig_calls", c_uint64),
        ("asked", c_uint64),
        ("left_out", c_uint64),
    ]


class CheckResultStruct(Structure):
    c_name = "fb_check_result"
    _fields_ = [
        ("struct_size", c_uint32),
        ("bakeable", c_uint32),
        ("faults", c_uint64),
        ("warnings", c_uint64),
        ("poses", c_uint64),
        ("evaluated", c_uint64),
    ]


class VerifyResultStruct(Structure):
    c_name = "fb_verify_result"
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("bytes", c_uint64),
        ("poses", c_uint64),
        ("vertices", c_uint64),
    ]


class PackResultStruct(Structure):
    c_name = "fb_pack_result"
    _fields_ = [
        ("struct_size", c_uint32),
        ("within_limits", c_uint32),
        ("archive", c_void_p),
        ("archive_bytes", c_uint64),
        ("bytes_before", c_uint64),
        ("format_before", c_uint32),
        ("format", c_uint32),
        ("step_factor", c_double),
        ("max_error", c_double),
        ("displacement", ErrorsStruct),
    ]


class ArchiveInfoStruct(Structure):
    c_name = "fb_archive_info"
    _fields_ = [
        ("struct_size", c_uint32),
        ("format_version", c_uint32),
        ("bytes", c_void_p),
        ("byte_count", c_uint64),
        ("name", c_char_p),
        ("recipe", c_char_p),
        ("licence", c_char_p),
        ("certificate", c_char_p),
        ("provenance", c_char_p),
        ("certificate_summary", c_char_p),
        ("section_count", c_uint32),
        ("note_count", c_uint32),
        ("proof_poses", c_uint32),
        ("proof_vertices", c_uint32),
        ("vertex_count", c_uint32),
        ("control_count", c_uint32),
        ("feature_count", c_uint32),
        ("direct_count", c_uint32),
        ("region_count", c_uint32),
        ("coefficient_count", c_uint32),
        ("parameter_count", c_uint64),
        ("value_count", c_uint64),
        ("about", c_char_p),
        ("thumbnail", c_void_p),
        ("thumbnail_bytes", c_uint64),
    ]


BAKE_STRUCTS = (
    RigControlStruct, RigLabelsStruct, RigClipStruct, RigStruct, CallbacksStruct, SourceDesc, SourceInfoStruct,
    ClipStruct, SampleDesc, CheckDesc, BakeDesc, CompareDesc, EvalDesc, PackDesc, ErrorsStruct, MethodStruct, ClipErrorsStruct,
    FailureStruct, SampleResultStruct, CheckResultStruct, VerifyResultStruct, PackResultStruct, ArchiveInfoStruct,
)  # fmt: skip
