#include "bake/measure/worst_vertex.h"

#include <algorithm>

#include "bake/measure/measured_face.h"
#include "base/length_units.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t controls_named = 3;

// How far the archive moves a vertex in a pose by each control that is off rest there, others as they are.
std::vector<std::pair<float, std::size_t>> shares_of_controls(const PackedModel& model, std::vector<float> pose,
                                                              std::uint32_t vertex) {
  MeasuredFace face(model);
  const auto position = [&] { return vector_at(face.points(pose.data()).data(), vertex); };
  const Vector3 posed = position();
  std::vector<std::pair<float, std::size_t>> shares;
  for (std::size_t c = 0; c < pose.size(); ++c) {
    const float value = pose[c], rest = model.schema.controls[c].rest;
    if (value == rest) continue;
    pose[c] = rest;
    const float moved = length(position() - posed);
    if (moved > 0) shares.emplace_back(moved, c);
    pose[c] = value;
  }
  std::stable_sort(shares.begin(), shares.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  return shares;
}

std::string names_of(const RigSchema& schema, const std::vector<std::pair<float, std::size_t>>& shares) {
  const std::size_t named = std::min(shares.size(), controls_named);
  std::string names;
  for (std::size_t i = 0; i < named; ++i)
    names += (i == 0 ? "" : i + 1 == named ? " and " : ", ") + ("\"" + schema.controls[shares[i].second].name + "\"");
  return names;
}

WorstVertex worst_of(const Errors& errors) {
  return {errors.max, errors.worst_frame, errors.worst_vertex};
}

}  // namespace

std::string describe_worst(const PackedModel& model, const FaceMap& map, const PoseSet& poses,
                           const WorstVertex& worst) {
  std::string text;
  for (const PoseSet::Range& range : poses.ranges())
    if (worst.pose >= range.first_pose && worst.pose < range.first_pose + range.count)
      text = format("frame %zu of \"%s\" at vertex %u (%s)", range.frame + worst.pose - range.first_pose,
                    poses.source().clips()[range.clip].name.c_str(), worst.vertex, map.name_of(worst.vertex).c_str());
  std::vector<float> pose(model.schema.control_count());
  poses.read_controls(worst.pose, 1, pose);
  const std::string names = names_of(model.schema, shares_of_controls(model, pose, worst.vertex));
  return names.empty() ? text : text + ", where " + names + " act";
}

std::optional<std::string> worst_vertex_warning(const PackedModel& model, const PoseSet& training,
                                                const Errors& dependency, const PoseSet& unseen,
                                                const std::optional<Errors>& independent, bool live,
                                                const Parallel& parallel) {
  const double unseen_max = independent ? independent->max : 0;
  if (std::max(unseen_max, dependency.max) <= worst_vertex_bound) return std::nullopt;
  const FaceMap map(model, parallel);
  std::string text;
  const auto add = [&](const char* which, const PoseSet& poses, const Errors& errors) {
    const std::string length = length_text(errors.max * model.rest.diagonal(), model.schema.units);
    text += format("%s is off by %s, %.3g %% of the diagonal: %s", which, length.c_str(), 100 * errors.max,
                   describe_worst(model, map, poses, worst_of(errors)).c_str());
  };
  if (unseen_max > worst_vertex_bound) add("the worst vertex of unseen poses", unseen, *independent);
  if (dependency.max > unseen_max)
    add(text.empty() ? "the worst vertex of poses trained on" : "; that of poses trained on", training, dependency);
  return text + (live ? ". --poses-like, with control values of such motion, trains on more poses near it"
                      : ". More recorded poses of these controls together would help");
}

}  // namespace fb::bake
