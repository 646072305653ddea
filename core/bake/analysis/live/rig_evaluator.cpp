#include "bake/analysis/live/rig_evaluator.h"

#include <algorithm>
#include <chrono>
#include <string>

#include "bake/rig/evaluate_parallel.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t block_poses = 128;                 // 9 MB of 6,000 vertices
constexpr std::chrono::microseconds worth_keeping{500};  // a pose; a quicker rig is sooner asked again than read

std::string describe(const RigSchema& schema, std::span<const float> rest, std::span<const float> pose) {
  std::string text;
  std::size_t named = 0;
  for (std::size_t c = 0; c < pose.size(); ++c)
    if (pose[c] != rest[c] && named++ < 3)
      text += format("%s\"%s\" at %g", text.empty() ? "" : ", ", schema.controls[c].name.c_str(), double(pose[c]));
  return named > 3 ? text + format(" and %zu more", named - 3) : text;
}

}  // namespace

RigEvaluator::RigEvaluator(Source& rig, const AnalysisOptions& options, const Parallel& parallel, Progress& progress)
    : rig_(&rig),
      budget_(options.rig_budget),
      parallel_(parallel),
      progress_(&progress),
      rest_(rig.schema().rest_pose()),
      diagonal_(rig.rest().diagonal()) {
  if (!options.answers.empty()) log_.emplace(options.answers);
}

void RigEvaluator::begin(std::string_view stage, std::size_t count) {
  progress_->begin(stage, count);
  done_ = 0;
}

void RigEvaluator::answer(std::span<const float> controls, std::size_t count, std::span<float> points) {
  if (log_ && log_->find(controls, points)) return;
  const auto start = std::chrono::steady_clock::now();
  try {
    evaluate_parallel(*rig_, controls, count, points, parallel_);
  } catch (const PoseError& error) {
    const std::span<const float> pose = controls.subspan(error.pose() * rest_.size(), rest_.size());
    fail(error.status(), "control %s: %s", describe(schema(), rest_, pose).c_str(), error.reason().c_str());
  }
  if (!log_) return;
  if (std::chrono::steady_clock::now() - start < static_cast<std::int64_t>(count) * worth_keeping)
    log_.reset();
  else
    log_->keep(points);
}

void RigEvaluator::ask(std::size_t count, const Fill& fill, const Visit& visit) {
  if (count > left())
    fail(Status::limit, "%zu poses are asked for where %llu are left", count, static_cast<unsigned long long>(left()));
  const std::vector<float>& rest_points = rig_->rest().points;
  const std::size_t width = rest_.size(), size = rest_points.size();
  std::vector<float> controls, points;
  for (std::size_t first = 0; first < count; first += block_poses) {
    const std::size_t poses = std::min(block_poses, count - first);
    controls.clear();
    for (std::size_t i = 0; i < poses; ++i) controls.insert(controls.end(), rest_.begin(), rest_.end());
    points.resize(poses * size);
    const auto pose = [&](std::size_t i) { return std::span(controls).subspan(i * width, width); };
    for (std::size_t i = 0; i < poses; ++i) fill(first + i, pose(i));
    answer(controls, poses, points);
    calls_ += poses;
    parallel_for(parallel_, poses, [&](std::size_t i, std::size_t) {
      const std::span<float> displacement = std::span(points).subspan(i * size, size);
      for (std::size_t k = 0; k < size; ++k) displacement[k] -= rest_points[k];
      visit(first + i, pose(i), displacement);
    });
    progress_->step(done_ += poses);
  }
}

}  // namespace fb::bake
