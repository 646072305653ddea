#include "bake/measure/held_back_errors.h"

#include <cmath>
#include <map>

#include "bake/measure/evaluate.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t most_poses = 4000;

// The numbers of the poses of each kind.
std::map<ClipKind, std::vector<std::uint32_t>> poses_by_kind(const PoseSet& poses) {
  std::map<ClipKind, std::vector<std::uint32_t>> by_kind;
  for (const PoseSet::Range& range : poses.ranges()) {
    std::vector<std::uint32_t>& numbers = by_kind[poses.source().clips()[range.clip].kind];
    for (std::size_t i = 0; i < range.count; ++i) numbers.push_back(static_cast<std::uint32_t>(range.first_pose + i));
  }
  return by_kind;
}

}  // namespace

HeldBackErrors held_back_errors(const PackedModel& model, const PoseSet& held_back, const Parallel& parallel,
                                Progress& progress) {
  HeldBackErrors errors;
  if (held_back.size() == 0) return errors;
  errors.total = evaluate_model_on(model, held_back.subsampled(most_poses), parallel, progress);
  for (const auto& [kind, numbers] : poses_by_kind(held_back))
    errors.kinds.push_back({name_of(kind), evaluate_model_on(model, held_back.picked(numbers).subsampled(most_poses),
                                                             parallel, progress)});
  return errors;
}

std::string text_of(const HeldBackErrors& errors) {
  std::string kinds;
  for (const KindErrors& kind : errors.kinds)
    kinds += format("%s%s %.1e", kinds.empty() ? "" : ", ", kind.kind.c_str(), kind.errors.rms);
  const Errors& total = errors.total;
  return format(
      "on %zu poses held back from every fit, the rms error is %.1e of the diagonal (%s), give or take %.0f %%; the "
      "largest %.1e",
      total.frames, total.rms, kinds.c_str(), total.rms > 0 ? 100 * total.rms_deviation / total.rms : 0, total.max);
}

}  // namespace fb::bake
