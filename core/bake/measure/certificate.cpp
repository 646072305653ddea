#include "bake/measure/certificate.h"

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "base/hash.h"
#include "base/status.h"

namespace fb::bake {
namespace {

using Json = nlohmann::ordered_json;

// Six digits say more than any figure deserves.
double rounded(double value) {
  return std::strtod(format("%.6g", value).c_str(), nullptr);
}

void add(Json& json, const Errors& errors) {
  json["frames"] = errors.frames;
  json["mse"] = rounded(errors.mse);
  json["rms"] = rounded(errors.rms);
  json["mean"] = rounded(errors.mean);
  json["p99"] = rounded(errors.p99);
  json["max"] = rounded(errors.max);
  json["mfm"] = rounded(errors.mfm);
}

Json on_unseen(const EvalReport& report, Split split) {
  Json json = {{"split", name_of(split)}};
  add(json, report.total);
  for (const ClipErrors& clip : report.clips) {
    Json figures = {{"name", clip.name}, {"kind", name_of(clip.kind)}};
    add(figures, clip.errors);
    json["clips"].push_back(std::move(figures));
  }
  for (const KindErrors& kind : report.kinds) {
    Json figures = {{"kind", name_of(kind.kind)}};
    add(figures, kind.errors);
    json["kinds"].push_back(std::move(figures));
  }
  if (!report.quality) return json;
  for (const PartErrors& part : report.quality->regions)
    json["regions"].push_back(
        {{"name", part.name}, {"vertices", part.count}, {"mse", rounded(part.mse)}, {"max", rounded(part.max)}});
  json["normals"] = {{"rms_degrees", rounded(report.quality->normal_rms)},
                     {"p99_degrees", rounded(report.quality->normal_p99)}};
  return json;
}

}  // namespace

std::string certificate(const Errors& dependency, const std::optional<EvalReport>& independent, Split split,
                        const Errors& quantisation) {
  Json json;
  add(json["dependency"], dependency);
  json["independent"] = independent ? on_unseen(*independent, split) : Json();
  add(json["quantisation"], quantisation);
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void note_repacking(std::string& certificate, const Errors& moved) {
  const auto shallow = [](int depth, Json::parse_event_t, Json&) { return depth < 32; };
  Json json = Json::parse(certificate, shallow, false);
  if (!json.is_object()) json = Json::object();
  const Json before = json.value("repacked", Json());
  const auto in_all = [&](const char* key, double now) {
    const bool known = before.is_object() && before.contains(key) && before[key].is_number();
    return rounded(now + (known ? before[key].get<double>() : 0));
  };
  const double rms = in_all("rms", moved.rms);  // at most: of two displacements it is no more than the sum
  json["repacked"] = {
      {"frames", moved.frames}, {"mse", rounded(rms * rms)}, {"rms", rms}, {"max", in_all("max", moved.max)}};
  certificate = json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::uint64_t training_hash(const PoseSet& poses) {
  constexpr std::size_t at_once = 64;
  const std::size_t width = poses.source().rest().points.size();
  std::vector<float> points(at_once * width);
  std::uint64_t hash = 0;
  for (std::size_t first = 0; first < poses.size(); first += at_once) {
    const std::size_t count = std::min(at_once, poses.size() - first);
    poses.read_points(first, count, std::span(points).first(count * width));
    for (std::size_t i = 0; i < count; ++i) hash = hash64_little(std::span(points).subspan(i * width, width), hash);
  }
  return hash64_little(poses.controls(), hash);
}

}  // namespace fb::bake
