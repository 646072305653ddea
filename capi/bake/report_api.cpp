#include "bake/authoring.h"

using fb::fail;
using fb::Status;
using namespace fb::capi;

namespace {

const fb::MethodReport& method_at(const fb_report* report, std::uint32_t index) {
  require(report, "report");
  const auto& methods = report->faces.methods;
  if (index >= methods.size()) fail(Status::invalid_argument, "method %u of %zu", index, methods.size());
  return methods[index];
}

std::int32_t use_number(const std::string& use) {
  return use == fb::bake::name_of(fb::bake::Use::backlot) ? FB_USE_BACKLOT : FB_USE_VARIANT;
}

template <class Result>
void write_result(const fb_report* report, const std::optional<Result>& result, Result* to, const char* type) {
  require(report, "report");
  if (!result) fail(Status::invalid_argument, "the report is of another call: it has no %s", type);
  write_struct(to, *result, type);
}

}  // namespace

extern "C" {

void fb_report_free(fb_report* report) {
  delete report;
}

const char* fb_report_json(const fb_report* report) {
  return report ? report->json.c_str() : nullptr;
}

fb_status fb_report_details(fb_report* report, const char** json) {
  return abi_guard([&] {
    require(report, "report");
    require(json, "json");
    if (report->faces.methods.empty() && report->details.empty())
      fail(Status::invalid_argument, "the report is of a call that bakes or measures no face: it has no details");
    if (report->details.empty()) report->details = faces_json(report->faces, true);
    *json = report->details.c_str();
  });
}

void fb_method_fill(fb_method* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

uint32_t fb_report_method_count(const fb_report* report) {
  return report ? static_cast<uint32_t>(report->faces.methods.size()) : 0;
}

fb_status fb_report_method_at(const fb_report* report, uint32_t index, fb_method* method) {
  return abi_guard([&] {
    const fb::MethodReport& found = method_at(report, index);
    fb_method full = {};
    full.use = use_number(found.use);
    full.name = found.name.c_str();
    full.archive = found.archive.data();
    full.archive_bytes = found.archive.size();
    full.poses = found.poses;
    full.parameters = found.parameters;
    full.coefficients = found.coefficients;
    full.rig_calls = found.stats.rig_calls;
    full.train_seconds = found.train_seconds;
    full.unseen = c_errors(found.independent.total);
    full.dependency = c_errors(found.dependency);
    full.quantisation = c_errors(report->quantisation);
    full.clip_count = static_cast<std::uint32_t>(found.independent.clips.size());
    write_struct(method, full, "fb_method");
  });
}

void fb_clip_errors_fill(fb_clip_errors* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_report_clip_at(const fb_report* report, uint32_t method, uint32_t index, fb_clip_errors* clip) {
  return abi_guard([&] {
    const auto& clips = method_at(report, method).independent.clips;
    if (index >= clips.size()) fail(Status::invalid_argument, "clip %u of %zu", index, clips.size());
    const fb::ClipErrors& found = clips[index];
    write_struct(
        clip,
        {0, static_cast<std::int32_t>(fb::bake::clip_kind_from(found.kind)),
         static_cast<std::int32_t>(fb::bake::split_from(found.split)), 0, found.name.c_str(), c_errors(found.errors)},
        "fb_clip_errors");
  });
}

void fb_failure_fill(fb_failure* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

uint32_t fb_report_failure_count(const fb_report* report) {
  return report ? static_cast<uint32_t>(report->faces.failures.size()) : 0;
}

fb_status fb_report_failure_at(const fb_report* report, uint32_t index, fb_failure* failure) {
  return abi_guard([&] {
    require(report, "report");
    const auto& failures = report->faces.failures;
    if (index >= failures.size()) fail(Status::invalid_argument, "failure %u of %zu", index, failures.size());
    const fb::MethodFailure& found = failures[index];
    write_struct(failure, {0, use_number(found.use), found.name.c_str(), found.reason.c_str()}, "fb_failure");
  });
}

fb_source* fb_report_source(const fb_report* report) {
  return report && report->recorded.source ? const_cast<fb_source*>(&report->recorded) : nullptr;
}

void fb_sample_result_fill(fb_sample_result* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_report_sample(const fb_report* report, fb_sample_result* result) {
  return abi_guard([&] { write_result(report, report ? report->sample : std::nullopt, result, "fb_sample_result"); });
}

void fb_check_result_fill(fb_check_result* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_report_check(const fb_report* report, fb_check_result* result) {
  return abi_guard([&] { write_result(report, report ? report->check : std::nullopt, result, "fb_check_result"); });
}

void fb_verify_result_fill(fb_verify_result* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_report_verify(const fb_report* report, fb_verify_result* result) {
  return abi_guard([&] { write_result(report, report ? report->verify : std::nullopt, result, "fb_verify_result"); });
}

fb_status fb_report_rights(const fb_report* report, fb_rights_result* result) {
  return abi_guard([&] { write_result(report, report ? report->rights : std::nullopt, result, "fb_rights_result"); });
}

void fb_pack_result_fill(fb_pack_result* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_report_pack(const fb_report* report, fb_pack_result* result) {
  return abi_guard([&] { write_result(report, report ? report->pack : std::nullopt, result, "fb_pack_result"); });
}

void fb_bag_result_fill(fb_bag_result* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_report_bag(const fb_report* report, fb_bag_result* result) {
  return abi_guard([&] { write_result(report, report ? report->bag : std::nullopt, result, "fb_bag_result"); });
}

}  // extern "C"
