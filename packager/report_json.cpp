#include "report_json.h"

#include <nlohmann/json.hpp>

#include "json_text.h"

namespace fb {
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

}  // namespace

std::string eval_json(const std::string& archive, const EvalReport& report) {
  return json_text({{"archive", archive},
                    {"units", report.units},
                    {"diagonal", report.diagonal},
                    {"clips", clip_list(report)},
                    {"total", figures(report.total)},
                    {"touched_bytes", touched(report.touched)}});
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
                       {"poses", method.poses},
                       {"train_seconds", method.train_seconds}});
  return json_text({{"name", report.name},
                    {"units", report.units},
                    {"diagonal", report.diagonal},
                    {"rig_calls", report.rig_calls},
                    {"methods", std::move(methods)}});
}

std::string bake_json(const std::string& archive, const Baked& baked) {
  return json_text({{"archive", archive},
                    {"bytes", baked.archive.size()},
                    {"poses", baked.poses},
                    {"rig_calls", baked.rig_calls},
                    {"coefficients", baked.coefficients},
                    {"parameters", baked.parameters},
                    {"train_seconds", baked.train_seconds},
                    {"quantisation", baked.quantisation}});
}

std::string verify_json(const std::string& archive, const VerifyReport& report) {
  return json_text(
      {{"archive", archive}, {"bytes", report.bytes}, {"poses", report.poses}, {"vertices", report.vertices}});
}

}  // namespace fb
