#include "commands/report_json.h"

#include <nlohmann/json.hpp>

#include "commands/json_text.h"

namespace fb::tool {
namespace {

using Json = nlohmann::ordered_json;

void add_figures(Json& to, const Errors& errors) {
  to["frames"] = errors.frames;
  to["mse"] = errors.mse;
  to["rms"] = errors.rms;
  to["mean"] = errors.mean;
  to["p99"] = errors.p99;
  to["max"] = errors.max;
  to["mfm"] = errors.mfm;
  to["worst_frame"] = errors.worst_frame;
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

Json touched(const TouchedBytes& bytes) {
  return {{"poses", bytes.poses},
          {"mean", bytes.mean},
          {"p95", bytes.p95},
          {"max", bytes.max},
          {"all", bytes.runtime_bytes}};
}

Json part_list(const std::vector<PartErrors>& parts, const char* count) {
  Json list = Json::array();
  for (const PartErrors& part : parts)
    list.push_back({{"name", part.name}, {count, part.count}, {"mse", part.mse}, {"max", part.max}});
  return list;
}

// null where it was not measured.
Json quality_of(const EvalReport& report) {
  if (!report.quality) return nullptr;
  const Quality& q = *report.quality;
  return {{"normal_degrees_rms", q.normal_rms},
          {"normal_degrees_p99", q.normal_p99},
          {"jitter", q.jitter},
          {"jitter_frames", q.jitter_frames},
          {"border_jump", q.border_jump},
          {"inside_jump", q.inside_jump},
          {"border_edges", q.border_edges},
          {"regions", part_list(q.regions, "vertices")},
          {"controls", part_list(q.controls, "frames")}};
}

Json locality_of(const std::optional<Locality>& locality) {
  if (!locality) return nullptr;
  Json worst = Json::array();
  for (const ControlLeak& leak : locality->leaks) {
    if (leak.leak == 0 || worst.size() == 10) break;
    worst.push_back({{"control", leak.control}, {"leak", leak.leak}, {"vertex", leak.vertex}});
  }
  return {{"largest", locality->largest},
          {"share_above", locality->above},
          {"tolerance", locality->options.tolerance},
          {"still", locality->options.still},
          {"poses", locality->options.poses},
          {"worst", std::move(worst)}};
}

}  // namespace

std::string eval_json(const std::string& archive, const EvalReport& report, const std::optional<Locality>& locality) {
  return json_text({{"archive", archive},
                    {"units", report.units},
                    {"diagonal", report.diagonal},
                    {"clips", clip_list(report)},
                    {"total", figures(report.total)},
                    {"touched_bytes", touched(report.touched)},
                    {"quality", quality_of(report)},
                    {"locality", locality_of(locality)}});
}

std::string compare_json(const CompareReport& report) {
  Json methods = Json::array();
  for (const MethodReport& method : report.methods)
    methods.push_back({{"name", method.name},
                       {"use", name_of(method.use)},
                       {"total", figures(method.independent.total)},
                       {"clips", clip_list(method.independent)},
                       {"dependency", figures(method.dependency)},
                       {"bytes", method.bytes},
                       {"touched_bytes", touched(method.independent.touched)},
                       {"parameters", method.parameters},
                       {"coefficients", method.coefficients},
                       {"bones", method.stats.bones},
                       {"poses", method.poses},
                       {"train_seconds", method.train_seconds},
                       {"rig_calls", method.stats.rig_calls},
                       {"quality", quality_of(method.independent)},
                       {"locality", locality_of(method.locality)}});
  Json failed = Json::array();
  for (const MethodFailure& failure : report.failures)
    failed.push_back({{"name", failure.name}, {"use", name_of(failure.use)}, {"reason", failure.reason}});
  return json_text({{"name", report.name},
                    {"units", report.units},
                    {"diagonal", report.diagonal},
                    {"rig_calls", report.rig_calls},
                    {"methods", std::move(methods)},
                    {"failed", std::move(failed)}});
}

std::string bake_json(const std::string& archive, const Baked& baked) {
  return json_text({{"archive", archive},
                    {"bytes", baked.archive.size()},
                    {"poses", baked.poses},
                    {"rig_calls", baked.rig_calls},
                    {"coefficients", baked.coefficients},
                    {"parameters", baked.parameters},
                    {"train_seconds", baked.train_seconds},
                    {"quantisation", figures(baked.quantisation)}});
}

}  // namespace fb::tool
