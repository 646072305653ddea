#include <nlohmann/json.hpp>

#include "bake/documents.h"
#include "bake/rig/json_field.h"
#include "figures/json_fields.h"
#include "figures/verdict.h"

namespace fb::capi {
namespace {

using Json = nlohmann::ordered_json;
using namespace fb::bake;

Json plan_of(const EvaluationPlan& plan) {
  if (plan.stages.empty()) return nullptr;
  Json stages = Json::array();
  for (const PlannedStage& stage : plan.stages)
    stages.push_back({{"stage", name_of(stage.purpose)},
                      {"expected", stage.expected},
                      {"most", stage.most == UINT64_MAX ? Json() : Json(stage.most)},
                      {"seconds", static_cast<double>(stage.expected) * plan.pose_seconds}});
  return {{"pose_seconds", plan.pose_seconds},
          {"stages", std::move(stages)},
          {"disk_bytes", {{"sampled", plan.sampled_bytes}, {"kept", plan.kept_bytes}}}};
}

// Of clips that were not trained on, or else of poses held back; "" where there are neither.
std::string verdict_of(const Baked& baked, const Source& source) {
  if (baked.independent) return verdict_text(*baked.independent);
  const Errors& held_back = baked.held_back.total;
  if (held_back.frames == 0) return "";
  return verdict_text(held_back, "poses held back", "", source.rest().diagonal(), source.schema().units);
}

}  // namespace

std::string json_text(const nlohmann::ordered_json& json) {
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string sample_json(const std::string& dataset, const SampleReport& report) {
  return json_text({{"dataset", dataset},
                    {"poses", report.poses},
                    {"evaluated", report.evaluated},
                    {"rig_calls", report.rig_calls},
                    {"asked", report.asked},
                    {"left_out", report.left_out}});
}

std::string plan_json(const std::string& dataset, const PosePlan& plan, bool rest) {
  Json clips = Json::array();
  std::size_t poses = 0;
  for (const Clip& clip : plan) {
    clips.push_back(
        {{"name", clip.name}, {"kind", name_of(clip.kind)}, {"split", name_of(clip.split)}, {"frames", clip.frames}});
    poses += clip.frames;
  }
  return json_text({{"dataset", dataset}, {"poses", poses}, {"rest", rest}, {"clips", clips}});
}

std::string bake_json(const std::string& archive, const Source& source, const Baked& baked) {
  Json json;
  FieldWriter write(json);
  write("archive", archive);
  write("bytes", baked.archive.size());
  write("learned", baked.learned);
  write("poses", baked.poses);
  write("rig_calls", baked.rig_calls);
  write("asked", baked.asked);
  write("reused", baked.reused);
  json["plan"] = plan_of(baked.plan);
  write("asked_by_stage", baked.asked_by_stage);
  write("coefficients", baked.coefficients);
  write("parameters", baked.parameters);
  write("train_seconds", baked.train_seconds);
  write("units", source.schema().units);
  write("diagonal", source.rest().diagonal());
  write("verdict", verdict_of(baked, source));
  write("independent", baked.independent ? std::optional(baked.independent->total) : std::nullopt);
  write("held_back", baked.held_back.total.frames > 0 ? std::optional(baked.held_back) : std::nullopt);
  write("quantisation", baked.quantisation);
  write("exact", baked.exact);
  write("controls", baked.controls);
  write("repeatability", baked.repeatability);
  write("warnings", baked.warnings);
  return json_text(json);
}

std::string eval_json(const std::string& archive, const MethodReport& face) {
  const EvalReport& report = face.independent;
  Json json;
  FieldWriter write(json);
  write("archive", archive);
  write("units", report.units);
  write("diagonal", report.diagonal);
  write("verdict", verdict_text(report));
  visit_clips(write, report);
  write("kinds", report.kinds);
  write("total", report.total);
  write("touched_bytes", report.bytes_read);
  write("expected", report.expectation);
  write("quality", report.quality);
  write("locality", face.locality);
  return json_text(json);
}

std::string faces_json(const FaceFigures& faces, bool details) {
  return json_text(fields_of<Json>(faces, {.details = details}));
}

std::string dataset_json(const DatasetFigures& figures, bool details) {
  return json_text(fields_of<Json>(figures, {.details = details}));
}

std::string verify_json(const std::string& archive, const VerifyReport& report) {
  return json_text({{"archive", archive},
                    {"bytes", report.bytes},
                    {"poses", report.poses},
                    {"vertices", report.vertices},
                    {"certificate", object_in(report.certificate)}});
}

std::string pack_json(const std::string& archive, const std::string& out, const fb_pack_result& result) {
  const auto version = [](std::uint32_t format) {
    return std::to_string(format / 1000) + "." + std::to_string(format % 1000);
  };
  return json_text(
      {{"archive", archive},
       {"bytes_before", result.bytes_before},
       {"format_before", version(result.format_before)},
       {"out", out},
       {"bytes", result.archive_bytes},
       {"format", version(result.format)},
       {"within_limits", result.within_limits != 0},
       {"step_factor", result.step_factor},
       {"max_error", result.max_error},
       {"displacement",
        {{"frames", result.displacement.frames}, {"mse", result.displacement.mse}, {"max", result.displacement.max}}}});
}

}  // namespace fb::capi
