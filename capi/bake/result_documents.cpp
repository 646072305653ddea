#include <algorithm>
#include <nlohmann/json.hpp>

#include "bake/documents.h"
#include "base/decimal_points.h"

namespace fb::capi {
namespace {

using Json = nlohmann::ordered_json;
using namespace fb::bake;

constexpr std::size_t leaks_listed = 10;

void add_figures(Json& to, const Errors& errors) {
  to["frames"] = errors.frames;
  to["mse"] = errors.mse;
  to["rms"] = errors.rms;
  to["mean"] = errors.mean;
  to["p99"] = errors.p99;
  to["max"] = errors.max;
  to["mfm"] = errors.mfm;
  to["worst_frame"] = errors.worst_frame;
  to["worst_vertex"] = errors.worst_vertex;
}

Json figures(const Errors& errors) {
  Json json;
  add_figures(json, errors);
  return json;
}

Json clip_list(const EvalReport& report) {
  Json list = Json::array();
  for (const ClipErrors& clip : report.clips) {
    Json json = {{"name", clip.name}, {"kind", name_of(clip.kind)}, {"split", name_of(clip.split)}};
    add_figures(json, clip.errors);
    list.push_back(std::move(json));
  }
  return list;
}

Json touched(const BytesRead& bytes) {
  return {{"poses", bytes.poses},
          {"mean", bytes.mean},
          {"p95", bytes.p95},
          {"max", bytes.max},
          {"all", bytes.runtime_bytes}};
}

Json region_list(const Quality& quality) {
  Json list = Json::array();
  for (const PartErrors& region : quality.regions) {
    const FaceParts& parts = quality.parts;
    const auto index =
        static_cast<std::size_t>(std::find(parts.names.begin(), parts.names.end(), region.name) - parts.names.begin());
    list.push_back({{"name", region.name},
                    {"title", parts.titles.at(index)},
                    {"movers", parts.movers.at(index)},
                    {"vertices", region.count},
                    {"mse", region.mse},
                    {"max", region.max}});
  }
  return list;
}

Json control_list(const Quality& quality) {
  Json list = Json::array();
  for (const ControlQuality& control : quality.controls)
    list.push_back(
        {{"name", control.all.name},
         {"frames", control.all.count},
         {"mse", control.all.mse},
         {"max", control.all.max},
         {"vertices", control.vertices},
         {"combined",
          {{"frames", control.combined.count}, {"mse", control.combined.mse}, {"max", control.combined.max}}}});
  return list;
}

Json kind_list(const EvalReport& report) {
  Json list = Json::array();
  for (const KindErrors& kind : report.kinds) {
    Json json = {{"kind", name_of(kind.kind)}};
    add_figures(json, kind.errors);
    list.push_back(std::move(json));
  }
  return list;
}

// Where the gap of touching surfaces is off most.
Json worst_contact_of(const EvalReport& report) {
  const ContactErrors& contact = report.quality->contact;
  if (contact.pairs == 0) return nullptr;
  std::size_t frame = contact.worst_frame, clip = 0;
  for (; frame >= report.clips.at(clip).frames.size(); ++clip) frame -= report.clips[clip].frames.size();
  return {{"clip", report.clips[clip].name},
          {"frame", frame},
          {"vertex", contact.worst_vertex},
          {"place", report.worst_contact},
          {"error", contact.worst}};
}

Json contact_of(const EvalReport& report) {
  const ContactErrors& contact = report.quality->contact;
  return {{"looked_at", contact.looked_at},
          {"frames", contact.frames},
          {"pairs", contact.pairs},
          {"rms", contact.rms},
          {"max", contact.max},
          {"visible", visible_gap},
          {"open", contact.open},
          {"deep", contact.deep},
          {"worst", worst_contact_of(report)}};
}

Json quality_of(const EvalReport& report) {
  if (!report.quality) return nullptr;
  const Quality& q = *report.quality;
  return {{"normal_degrees_rms", q.normal_rms}, {"normal_degrees_p99", q.normal_p99}, {"jitter", q.jitter},
          {"jitter_frames", q.jitter_frames},   {"border_jump", q.border_jump},       {"inside_jump", q.inside_jump},
          {"border_edges", q.border_edges},     {"contact", contact_of(report)},      {"regions", region_list(q)},
          {"controls", control_list(q)}};
}

Json locality_of(const std::optional<Locality>& locality) {
  if (!locality) return nullptr;
  Json worst = Json::array();
  for (const ControlLeak& leak : locality->leaks) {
    if (leak.leak == 0 || worst.size() == leaks_listed) break;
    worst.push_back({{"control", leak.control}, {"leak", leak.leak}, {"vertex", leak.vertex}});
  }
  Json alone = Json::array();
  for (const ControlLeak& control : locality->leaks)
    alone.push_back({{"name", control.control},
                     {"poses", control.alone_poses},
                     {"unseen_poses", control.unseen_poses},
                     {"max", control.alone_error},
                     {"motion", control.alone_motion}});
  return {{"largest", locality->largest},
          {"share_above", locality->above},
          {"tolerance", locality->options.tolerance},
          {"still", locality->options.still},
          {"poses", locality->options.poses},
          {"recorded_poses", locality->recorded_poses},
          {"controls", locality->leaks.size()},
          {"worst", std::move(worst)},
          {"alone", std::move(alone)}};
}

Json expectation_of(const EvalReport& report) {
  if (!report.expectation) return nullptr;
  const Expectation& expected = *report.expectation;
  return {{"frames", expected.frames},
          {"rank", expected.rank},
          {"within_two", expected.within_two},
          {"constant_within_two", expected.constant_within_two},
          {"outside", expected.outside}};
}

Json repeatability_of(const std::optional<Repeatability>& repeatability) {
  if (!repeatability) return nullptr;
  return {{"poses", repeatability->poses}, {"rms", repeatability->rms}, {"max", repeatability->max}};
}

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

Json counts_of(const EvaluationCounts& counts) {
  Json list = Json::array();
  for (std::size_t p = 0; p < counts.size(); ++p)
    if (counts[p].asked > 0 || counts[p].evaluated > 0)
      list.push_back({{"stage", name_of(static_cast<EvaluationPurpose>(p))},
                      {"asked", counts[p].asked},
                      {"evaluated", counts[p].evaluated},
                      {"seconds", counts[p].seconds}});
  return list;
}

Json held_back_of(const HeldBackErrors& errors) {
  if (errors.total.frames == 0) return nullptr;
  Json json = figures(errors.total);
  json["kinds"] = Json::array();
  for (const KindErrors& kind : errors.kinds) {
    Json& of_kind = json["kinds"].emplace_back(Json{{"kind", name_of(kind.kind)}});
    of_kind.update(figures(kind.errors));
  }
  return json;
}

Json method_of(const MethodReport& method) {
  return {{"name", method.name},
          {"use", name_of(method.use)},
          {"total", figures(method.independent.total)},
          {"clips", clip_list(method.independent)},
          {"kinds", kind_list(method.independent)},
          {"dependency", figures(method.dependency)},
          {"bytes", method.bytes},
          {"touched_bytes", touched(method.independent.bytes_read)},
          {"parameters", method.parameters},
          {"coefficients", method.coefficients},
          {"bones", method.stats.bones},
          {"poses", method.poses},
          {"train_seconds", method.train_seconds},
          {"rig_calls", method.stats.rig_calls},
          {"expected", expectation_of(method.independent)},
          {"quality", quality_of(method.independent)},
          {"locality", locality_of(method.locality)}};
}

Json failures_of(const CompareReport& report) {
  Json failed = Json::array();
  for (const MethodFailure& failure : report.failures)
    failed.push_back({{"name", failure.name}, {"use", name_of(failure.use)}, {"reason", failure.reason}});
  return failed;
}

void add_frames(Json& clips, const EvalReport& report) {
  for (std::size_t c = 0; c < report.clips.size(); ++c) {
    Json mse = Json::array(), max = Json::array(), expected = Json::array();
    for (const FrameErrors& frame : report.clips[c].frames) {
      mse.push_back(frame.mse);
      max.push_back(frame.max);
      if (report.expectation) expected.push_back(frame.expected);
    }
    clips[c]["frame_expected"] = std::move(expected);
    clips[c]["frame_mse"] = std::move(mse);
    clips[c]["frame_max"] = std::move(max);
  }
}

Json worst_frame_list(const EvalReport& report) {
  Json list = Json::array();
  for (const FrameOfClip& frame : report.worst)
    list.push_back({{"clip", frame.clip},
                    {"frame", frame.frame},
                    {"mse", frame.errors.mse},
                    {"max", frame.errors.max},
                    {"vertex", frame.errors.worst_vertex}});
  return list;
}

Json stats_of(const BakeStats& stats) {
  Json regions = Json::array(), learning = Json::array();
  for (const RegionStats& region : stats.regions) {
    Json epochs = Json::array();
    for (const EpochLoss& epoch : region.epochs)
      epochs.push_back({{"training", epoch.training}, {"validation", epoch.validation}});
    regions.push_back({{"name", region.name},
                       {"vertices", region.vertices},
                       {"inputs", region.inputs},
                       {"coefficients", region.coefficients},
                       {"parameters", region.parameters},
                       {"energy", region.energy},
                       {"validation", region.validation},
                       {"restarts", region.restarts},
                       {"epochs", std::move(epochs)}});
  }
  for (const LearningPoint& point : stats.learning)
    learning.push_back({{"poses", point.poses}, {"mse", point.mse}, {"max", point.max}});
  return {{"notes", stats.notes},
          {"regions", std::move(regions)},
          {"learning", std::move(learning)},
          {"coverage", stats.coverage}};
}

Json detailed_method(const MethodReport& method) {
  Json json = method_of(method);
  add_frames(json["clips"], method.independent);
  if (const auto& quality = method.independent.quality) {
    json["quality"]["vertex_rms"] = quality->vertex_rms;
    json["quality"]["vertex_region"] = quality->parts.labels;
    json["quality"]["region_names"] = quality->parts.names;
  }
  json["worst_frames"] = worst_frame_list(method.independent);
  json["stats"] = stats_of(method.stats);
  return json;
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

std::string bake_json(const std::string& archive, const Baked& baked) {
  Json controls = Json::array();
  for (const ControlError& error : baked.controls)
    controls.push_back(
        {{"name", error.name}, {"alone", error.alone}, {"among", error.among}, {"among_share", error.among_share}});
  return json_text({{"archive", archive},
                    {"bytes", baked.archive.size()},
                    {"poses", baked.poses},
                    {"rig_calls", baked.rig_calls},
                    {"asked", baked.asked},
                    {"reused", baked.reused},
                    {"plan", plan_of(baked.plan)},
                    {"asked_by_stage", counts_of(baked.counts)},
                    {"coefficients", baked.coefficients},
                    {"parameters", baked.parameters},
                    {"train_seconds", baked.train_seconds},
                    {"held_back", held_back_of(baked.held_back)},
                    {"quantisation", figures(baked.quantisation)},
                    {"exact", baked.exact ? figures(*baked.exact) : Json()},
                    {"controls", std::move(controls)},
                    {"repeatability", repeatability_of(baked.repeatability)},
                    {"warnings", baked.warnings}});
}

std::string eval_json(const std::string& archive, const EvalReport& report, const std::optional<Locality>& locality) {
  return json_text({{"archive", archive},
                    {"units", report.units},
                    {"diagonal", report.diagonal},
                    {"clips", clip_list(report)},
                    {"kinds", kind_list(report)},
                    {"total", figures(report.total)},
                    {"touched_bytes", touched(report.bytes_read)},
                    {"expected", expectation_of(report)},
                    {"quality", quality_of(report)},
                    {"locality", locality_of(locality)}});
}

std::string compare_json(const CompareReport& report) {
  Json methods = Json::array();
  for (const MethodReport& method : report.methods) methods.push_back(method_of(method));
  return json_text({{"name", report.name},
                    {"units", report.units},
                    {"diagonal", report.diagonal},
                    {"rig_calls", report.rig_calls},
                    {"repeatability", repeatability_of(report.repeatability)},
                    {"methods", std::move(methods)},
                    {"failed", failures_of(report)}});
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

std::string details_json(const CompareReport& report, const Measured& measured) {
  Json methods = Json::array();
  for (const MethodReport& method : report.methods) methods.push_back(detailed_method(method));
  return json_text({{"name", report.name},
                    {"units", report.units},
                    {"diagonal", report.diagonal},
                    {"rig_calls", report.rig_calls},
                    {"asked_by_stage", counts_of(report.counts)},
                    {"measured_split", measured.split ? Json(name_of(*measured.split)) : Json()},
                    {"repeatability", repeatability_of(report.repeatability)},
                    {"methods", std::move(methods)},
                    {"failed", failures_of(report)}});
}

}  // namespace fb::capi
