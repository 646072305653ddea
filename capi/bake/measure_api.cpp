#include <array>

#include "bake/authoring.h"
#include "bake/measure/evaluate.h"
#include "bake/measure/locality.h"
#include "base/shown_path.h"

using fb::fail;
using fb::Status;
using namespace fb::capi;

namespace {

std::optional<fb::bake::Split> split_of(std::int32_t split) {
  if (split == FB_SPLIT_ALL) return std::nullopt;
  if (split < FB_SPLIT_TRAIN || split > FB_SPLIT_TEST)
    fail(Status::invalid_argument, "fb_eval_desc: split %d is none of FB_SPLIT_...", split);
  return static_cast<fb::bake::Split>(split);
}

std::unique_ptr<fb_report> report_of(const fb_archive& archive, const fb::bake::Source& source, fb::EvalReport errors) {
  auto report = std::make_unique<fb_report>();
  report->faces.name = source.schema().name;
  report->faces.units = source.schema().units;
  report->faces.diagonal = source.rest().diagonal();
  fb::MethodReport& face = report->faces.methods.emplace_back();
  face.name = std::filesystem::path(archive.name).stem().string();
  face.archive = archive.bytes;
  face.independent = std::move(errors);
  return report;
}

}  // namespace

extern "C" {

void fb_eval_desc_fill(fb_eval_desc* to, uint32_t struct_size) {
  fb_eval_desc defaults = {};
  defaults.split = FB_SPLIT_TEST;
  fill_struct(to, struct_size, defaults);
}

fb_status fb_eval(const fb_eval_desc* desc, fb_report** report) {
  return abi_guard([&] {
    require(desc, "desc");
    require(report, "report");
    const fb_eval_desc known = read_struct(*desc, fb_eval_desc_init, "fb_eval_desc");
    require(known.archive, "fb_eval_desc: archive");
    const fb_archive& archive = *known.archive;
    fb::bake::Source& source = source_of(known.source, "fb_eval_desc: source");
    const std::optional<fb::bake::Split> split = split_of(known.split);
    HostProgress progress(known.callbacks);
    const fb::Parallel parallel = parallel_of(known.threads, &progress);
    const bool quality = (known.measure & FB_MEASURE_QUALITY) != 0;
    auto made = report_of(archive, source,
                          fb::bake::evaluate_archive(archive.bytes, source, split, parallel, progress,
                                                     quality ? fb::bake::Detail::quality : fb::bake::Detail::errors));
    fb::MethodReport& face = made->faces.methods[0];
    if (known.measure & FB_MEASURE_LOCALITY) {
      const std::array<std::span<const std::byte>, 1> archives = {archive.bytes};
      fb::bake::RigEvaluator rig(source, parallel);
      auto measured = source.live() ? fb::bake::measure_locality(archives, rig, {}, progress)
                                    : fb::bake::recorded_locality(archives, source, parallel, progress);
      if (!measured.empty()) face.locality = std::move(measured[0]);
    }
    if (split) made->faces.measured_split = fb::bake::name_of(*split);
    made->json = eval_json(archive.name, face);
    *report = made.release();
  });
}

fb_status fb_diff(const fb_archive* before, const fb_archive* now, fb_report** report) {
  return abi_guard([&] {
    require(before, "before");
    require(now, "now");
    auto made = std::make_unique<fb_report>();
    made->json = diff_json(before->name, before->contents, now->name, now->contents,
                           fb::bake::face_difference(before->contents.model, now->contents.model, {}));
    hand_over(std::move(made), report);
  });
}

fb_status fb_verify(const fb_archive* archive, fb_report** report) {
  return abi_guard([&] {
    require(archive, "archive");
    const fb::bake::VerifyReport verified = fb::with_context(
        fb::shown(archive->name), [&] { return fb::bake::verify_archive(archive->contents, archive->bytes.size()); });
    auto made = std::make_unique<fb_report>();
    made->json = verify_json(archive->name, verified);
    made->verify = fb_verify_result{0, 0, verified.bytes, verified.poses, verified.vertices};
    hand_over(std::move(made), report);
  });
}

}  // extern "C"
