#include "bake/rig/changed_rig.h"

#include <algorithm>
#include <cmath>

#include "base/random_streams.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t poses_checked = 8;
constexpr double spread_factor = 4;  // of the furthest of few vertices: it is seldom the limit

// The furthest vertex between two poses; its distance over `diagonal`.
ChangedPose furthest(std::uint64_t record, std::span<const float> before, std::span<const float> now, double diagonal) {
  ChangedPose worst{record};
  for (std::size_t i = 0; i < before.size(); i += 3) {
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double d = double(now[i + axis]) - double(before[i + axis]);
      squared += d * d;
    }
    const double distance = std::sqrt(squared) / diagonal;
    if (distance > worst.distance) worst = {record, i / 3, distance};
  }
  return worst;
}

}  // namespace

RigComparison::RigComparison(RigEvaluator& rig, EarlierEvaluations& earlier, EvaluationCache* answers)
    : rig_(rig), earlier_(earlier), answers_(answers) {}

void RigComparison::evaluate(std::span<const float> controls, std::span<float> points) {
  const std::size_t width = rig_.rest_pose().size(), size = rig_.coordinate_count(), count = controls.size() / width;
  const auto pose = [&](std::size_t i) { return controls.subspan(i * width, width); };
  std::vector<std::size_t> missing;
  std::vector<float> some;
  for (std::size_t i = 0; i < count; ++i) {
    if (answers_ && answers_->find(pose(i), points.subspan(i * size, size))) continue;
    missing.push_back(i);
    some.insert(some.end(), pose(i).begin(), pose(i).end());
  }
  std::vector<float> found(missing.size() * size);
  try {
    rig_.evaluate_apart(some, missing.size(), found);
  } catch (const PoseError& error) {
    fail(error.status(), "%s: %s", describe_pose(rig_.schema(), pose(missing[error.pose()])).c_str(),
         error.reason().c_str());
  }
  for (std::size_t k = 0; k < missing.size(); ++k) {
    const auto of_pose = std::span(found).subspan(k * size, size);
    std::ranges::copy(of_pose, points.subspan(missing[k] * size, size).begin());
    if (answers_) answers_->store(pose(missing[k]), of_pose);
  }
  if (answers_) answers_->flush();
}

std::vector<ChangedPose> RigComparison::compare(std::span<const std::uint64_t> records, EvaluationStage& stage) {
  const std::size_t width = rig_.rest_pose().size(), size = rig_.coordinate_count();
  const std::size_t most = std::clamp<std::size_t>(rig_.block_poses(), 1, 64);
  std::vector<ChangedPose> changes;
  std::vector<float> controls, before, now;
  std::vector<std::uint64_t> read;
  for (std::size_t first = 0; first < records.size(); first += most) {
    const auto block = records.subspan(first, std::min(most, records.size() - first));
    controls.resize(block.size() * width);
    before.resize(block.size() * size);
    read.clear();
    for (const std::uint64_t record : block)
      if (earlier_.read(record, std::span(controls).subspan(read.size() * width, width),
                        std::span(before).subspan(read.size() * size, size)))
        read.push_back(record);
    now.resize(read.size() * size);
    evaluate(std::span(controls).first(read.size() * width), now);
    for (std::size_t i = 0; i < read.size(); ++i)
      changes.push_back(furthest(read[i], std::span(before).subspan(i * size, size),
                                 std::span(now).subspan(i * size, size), rig_.diagonal()));
    stage.advance(block.size());
  }
  return changes;
}

double RigComparison::tolerance(std::span<const std::uint64_t> records) {
  const std::size_t size = rig_.coordinate_count(), poses = std::min(records.size(), poses_checked);
  std::vector<float> controls(rig_.rest_pose().size()), points(size), again(size);
  double spread = 0;
  for (std::size_t i = 0; i < poses; ++i) {
    const std::uint64_t record = records[i * records.size() / poses];
    if (!earlier_.read(record, controls, points)) continue;
    rig_.evaluate_apart(controls, 1, points);
    rig_.evaluate_apart(controls, 1, again);
    spread = std::max(spread, furthest(record, points, again, rig_.diagonal()).distance);
  }
  return std::max(least_rig_tolerance, spread_factor * spread);
}

std::string distance_text(const RigEvaluator& rig, double distance) {
  return format("%.2g of the diagonal (%.2g %s)", distance, distance * rig.diagonal(), rig.schema().units.c_str());
}

void check_rig_unchanged(RigEvaluator& rig, std::uint64_t seed, const std::filesystem::path& work, Progress& progress) {
  EvaluationCache* const cache = rig.cache();
  if (!cache || cache->record_count() == 0) return;
  const std::uint64_t count = cache->record_count(), poses = std::min<std::uint64_t>(count, poses_checked);
  Random random = open_stream(seed, Stream::unchanged_rig, count);
  std::vector<std::uint64_t> records;
  for (std::uint64_t i = 0; i < poses; ++i) {
    const std::uint64_t first = i * count / poses, end = (i + 1) * count / poses;
    records.push_back(first + random.below(static_cast<std::uint32_t>(end - first)));
  }
  EvaluationStage stage(progress, Phase::sampling, "evaluating kept poses again", poses);
  EarlierEvaluations earlier(*cache);
  RigComparison comparison(rig, earlier);
  const std::vector<ChangedPose> changes = comparison.compare(records, stage);
  const auto worst = std::ranges::max_element(changes, {}, &ChangedPose::distance);
  if (worst == changes.end() || worst->distance <= least_rig_tolerance) return;
  if (worst->distance <= comparison.tolerance(records)) return;
  std::vector<float> controls(rig.rest_pose().size()), points(rig.coordinate_count());
  cache->read(worst->record, controls, points);
  fail(Status::invalid_argument,
       "%s: the rig has changed: evaluated again, it puts vertex %zu of pose %llu (%s) %s from where it was. Bake into "
       "another folder; --reuse FOLDER, with this one, takes over what still holds",
       shown(work).c_str(), worst->vertex, static_cast<unsigned long long>(worst->record),
       describe_pose(rig.schema(), controls).c_str(), distance_text(rig, worst->distance).c_str());
}

}  // namespace fb::bake
