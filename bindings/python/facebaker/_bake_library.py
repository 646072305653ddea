"""The ctypes interface of libfacebaker_bake, which is opened when the first call needs it."""

from __future__ import annotations

from ctypes import POINTER, c_char_p, c_int32, c_uint32, c_uint64, c_void_p

from . import _bake_structs as s
from ._library import Functions, Library
from ._structs import ControlStruct

# name: (result, arguments). Handles, and arrays that the caller gives, are void pointers.
_FUNCTIONS: Functions = {
    "fb_status_name": (c_char_p, [c_int32]),
    "fb_last_error": (c_char_p, []),
    "fb_source_desc_fill": (None, [POINTER(s.SourceDesc), c_uint32]),
    "fb_source_open": (c_int32, [POINTER(s.SourceDesc), POINTER(c_void_p)]),
    "fb_source_close": (None, [c_void_p]),
    "fb_source_info_fill": (None, [POINTER(s.SourceInfoStruct), c_uint32]),
    "fb_source_describe": (c_int32, [c_void_p, POINTER(s.SourceInfoStruct)]),
    "fb_control_fill": (None, [POINTER(ControlStruct), c_uint32]),
    "fb_source_control_at": (c_int32, [c_void_p, c_uint32, POINTER(ControlStruct)]),
    "fb_clip_fill": (None, [POINTER(s.ClipStruct), c_uint32]),
    "fb_source_clip_at": (c_int32, [c_void_p, c_uint32, POINTER(s.ClipStruct)]),
    "fb_source_read": (c_int32, [c_void_p, c_uint32, c_uint64, c_uint64, c_void_p, c_uint64]),
    "fb_source_evaluate": (c_int32, [c_void_p, c_void_p, c_uint64, c_uint32, c_void_p, c_uint64]),
    "fb_archive_open": (c_int32, [c_char_p, POINTER(c_void_p)]),
    "fb_archive_open_memory": (c_int32, [c_char_p, c_uint64, c_char_p, POINTER(c_void_p)]),
    "fb_archive_close": (None, [c_void_p]),
    "fb_archive_info_fill": (None, [POINTER(s.ArchiveInfoStruct), c_uint32]),
    "fb_archive_describe": (c_int32, [c_void_p, POINTER(s.ArchiveInfoStruct)]),
    "fb_archive_note_at": (c_char_p, [c_void_p, c_uint32]),
    "fb_sample_desc_fill": (None, [POINTER(s.SampleDesc), c_uint32]),
    "fb_sample": (c_int32, [POINTER(s.SampleDesc), POINTER(c_void_p)]),
    "fb_plan": (c_int32, [POINTER(s.SampleDesc), POINTER(c_void_p)]),
    "fb_check_desc_fill": (None, [POINTER(s.CheckDesc), c_uint32]),
    "fb_check": (c_int32, [POINTER(s.CheckDesc), POINTER(c_void_p)]),
    "fb_recipe_count": (c_uint32, []),
    "fb_recipe_name": (c_char_p, [c_uint32]),
    "fb_bake_desc_fill": (None, [POINTER(s.BakeDesc), c_uint32]),
    "fb_bake": (c_int32, [POINTER(s.BakeDesc), POINTER(c_void_p)]),
    "fb_compare_desc_fill": (None, [POINTER(s.CompareDesc), c_uint32]),
    "fb_compare": (c_int32, [POINTER(s.CompareDesc), POINTER(c_void_p)]),
    "fb_eval_desc_fill": (None, [POINTER(s.EvalDesc), c_uint32]),
    "fb_eval": (c_int32, [POINTER(s.EvalDesc), POINTER(c_void_p)]),
    "fb_pack_desc_fill": (None, [POINTER(s.PackDesc), c_uint32]),
    "fb_pack": (c_int32, [POINTER(s.PackDesc), POINTER(c_void_p)]),
    "fb_verify": (c_int32, [c_void_p, POINTER(c_void_p)]),
    "fb_inspect": (c_int32, [c_void_p, POINTER(c_void_p)]),
    "fb_diff": (c_int32, [c_void_p, c_void_p, POINTER(c_void_p)]),
    "fb_report_free": (None, [c_void_p]),
    "fb_report_json": (c_char_p, [c_void_p]),
    "fb_report_details": (c_int32, [c_void_p, POINTER(c_char_p)]),
    "fb_report_method_count": (c_uint32, [c_void_p]),
    "fb_method_fill": (None, [POINTER(s.MethodStruct), c_uint32]),
    "fb_report_method_at": (c_int32, [c_void_p, c_uint32, POINTER(s.MethodStruct)]),
    "fb_clip_errors_fill": (None, [POINTER(s.ClipErrorsStruct), c_uint32]),
    "fb_report_clip_at": (c_int32, [c_void_p, c_uint32, c_uint32, POINTER(s.ClipErrorsStruct)]),
    "fb_report_failure_count": (c_uint32, [c_void_p]),
    "fb_failure_fill": (None, [POINTER(s.FailureStruct), c_uint32]),
    "fb_report_failure_at": (c_int32, [c_void_p, c_uint32, POINTER(s.FailureStruct)]),
    "fb_sample_result_fill": (None, [POINTER(s.SampleResultStruct), c_uint32]),
    "fb_report_sample": (c_int32, [c_void_p, POINTER(s.SampleResultStruct)]),
    "fb_check_result_fill": (None, [POINTER(s.CheckResultStruct), c_uint32]),
    "fb_report_check": (c_int32, [c_void_p, POINTER(s.CheckResultStruct)]),
    "fb_verify_result_fill": (None, [POINTER(s.VerifyResultStruct), c_uint32]),
    "fb_report_verify": (c_int32, [c_void_p, POINTER(s.VerifyResultStruct)]),
    "fb_pack_result_fill": (None, [POINTER(s.PackResultStruct), c_uint32]),
    "fb_report_pack": (c_int32, [c_void_p, POINTER(s.PackResultStruct)]),
}

library = Library("facebaker_bake", "FACEBAKER_BAKE_LIBRARY", _FUNCTIONS)
check = library.check
