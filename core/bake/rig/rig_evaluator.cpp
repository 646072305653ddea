#include "bake/rig/rig_evaluator.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "bake/rig/driven_pose.h"
#include "base/hash.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// Of evaluate_each: 9 MB of 6,000 vertices, and of larger faces so many bytes, unless that is fewer than some poses.
constexpr std::size_t poses_in_memory = 128, fewest_in_memory = 16, wanted_bytes = std::size_t{1} << 26;
constexpr std::size_t bytes_in_memory = std::size_t{1} << 28;
constexpr std::chrono::microseconds slow_pose{500};
// A pose is kept if the rig takes so many times as long for it as the disk: few that are kept are asked for again. The
// disk is measured for rigs of more bytes a second than any disk takes.
constexpr double kept_seconds = 4, bytes_of_any_disk = 20e6;

std::vector<float> gathered(std::span<const float> controls, std::size_t width, std::span<const std::size_t> poses) {
  std::vector<float> some;
  for (const std::size_t pose : poses) {
    const std::span<const float> values = controls.subspan(pose * width, width);
    some.insert(some.end(), values.begin(), values.end());
  }
  return some;
}

}  // namespace

const char* name_of(EvaluationPurpose purpose) {
  constexpr std::array<const char*, purpose_count> names = {"driven joints",
                                                            "single controls",
                                                            "drawn poses",
                                                            "poses like the examples",
                                                            "poses where an ensemble disagrees",
                                                            "clips and test poses",
                                                            "analysis",
                                                            "poses of single regions",
                                                            "measuring"};
  return names.at(static_cast<std::size_t>(purpose));
}

std::string describe_pose(const RigSchema& schema, std::span<const float> pose) {
  constexpr std::size_t most_named = 3;
  std::string text;
  std::size_t active = 0;
  for (std::size_t c = 0; c < pose.size(); ++c)
    if (pose[c] != schema.controls[c].rest && active++ < most_named)
      text += format("%s\"%s\" at %g", text.empty() ? "" : ", ", schema.controls[c].name.c_str(), double(pose[c]));
  if (active == 0) return "all controls at rest";
  return active > most_named ? text + format(" and %zu more", active - most_named) : text;
}

RigEvaluator::RigEvaluator(Source& source, const Parallel& parallel, const std::filesystem::path& cache)
    : RigEvaluator(source, source.make_backend(parallel), parallel, cache) {}

RigEvaluator::RigEvaluator(Source& source, std::unique_ptr<EvaluationBackend> backend, const Parallel& parallel,
                           const std::filesystem::path& cache)
    : SourceDecorator(source),
      parallel_(parallel),
      backend_(std::move(backend)),
      rest_pose_(source.schema().rest_pose()),
      diagonal_(source.rest().diagonal()) {
  known_.insert(hash64_of<float>(rest_pose_));
  if (source.live() && !cache.empty()) cache_.emplace(cache, identity_of(source));
  if (cache_) known_.insert(cache_->reused_poses().begin(), cache_->reused_poses().end());
}

// Calls evaluate(points) for points as the rig gives them.
template <class Evaluate>
void RigEvaluator::give(std::span<const float> controls, std::size_t count, std::span<float> points,
                        const Evaluate& evaluate) {
  if (!conversion_) return evaluate(points);
  std::vector<float> from(count * rig_coordinate_count());
  evaluate(std::span(from));
  conversion_->convert(controls, from, count, points);
}

void RigEvaluator::spend(std::span<const float> controls, std::size_t poses) {
  if (!source().live()) return;
  const std::size_t width = rest_pose_.size();
  const std::lock_guard lock(requesting_);
  std::vector<std::uint64_t> fresh;
  for (std::size_t i = 0; i < poses; ++i)
    if (const std::uint64_t hash = hash64_of(controls.subspan(i * width, width)); known_.insert(hash).second)
      fresh.push_back(hash);
  for (const EvaluationBudget* budget = budget_; budget; budget = budget->outer_) {
    const std::uint64_t used = requested_ - budget->requested_before_;
    if (budget->poses_ == 0 || used + fresh.size() <= budget->poses_) continue;
    for (const std::uint64_t hash : fresh) known_.erase(hash);
    fail(Status::invalid_argument,
         "rig \"%s\": evaluating %zu poses more than the %llu so far would pass the rig budget of %llu",
         schema().name.c_str(), fresh.size(), static_cast<unsigned long long>(used),
         static_cast<unsigned long long>(budget->poses_));
  }
  requested_ += fresh.size();
}

EvaluationCount RigEvaluator::since_purpose() const {
  return {requested() - before_purpose_.asked, evaluated() - before_purpose_.evaluated,
          rig_seconds_ - before_purpose_.seconds};
}

EvaluationCounts RigEvaluator::counts() const {
  EvaluationCounts all = counts_;
  all[static_cast<std::size_t>(purpose_)] += since_purpose();
  return all;
}

EvaluationPurpose RigEvaluator::set_purpose(EvaluationPurpose purpose) {
  counts_ = counts();
  before_purpose_ = {requested(), evaluated(), rig_seconds_};
  return std::exchange(purpose_, purpose);
}

std::uint64_t RigEvaluator::remaining() const {
  std::uint64_t least = UINT64_MAX;
  for (const EvaluationBudget* budget = budget_; budget; budget = budget->outer_)
    if (budget->poses_ > 0) least = std::min(least, budget->poses_ - budget->requested());
  return least;
}

std::size_t RigEvaluator::block_poses() const {
  if (!parallel_.progress || !source().live()) return SIZE_MAX;
  const double seconds = pose_seconds_, poses = seconds > 0 ? std::min(backend_->block_seconds() / seconds, 1e6) : 0;
  return std::max(static_cast<std::size_t>(poses), backend_->least_poses());
}

void RigEvaluator::run_block(const EvaluationBlock& block) {
  const auto start = std::chrono::steady_clock::now();
  backend_->evaluate_block(block);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  pose_seconds_ = std::max(took.count() / static_cast<double>(block.count), 1e-9);
  rig_seconds_ += took.count();
  if (parallel_.progress) parallel_.progress->ask();
}

void RigEvaluator::read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) {
  if (source().recorded(clip)) {
    if (source().live()) frames_read_ += count;
    given().read(clip, first, count, points);
    if (parallel_.progress) parallel_.progress->ask();
    return;
  }
  const Clip& from = clips().at(clip);
  const std::size_t width = rest_pose_.size();
  const std::span<const float> controls = frames_of(from, first, count, width);
  try {
    evaluate_apart_cached(controls, count, points);
  } catch (const PoseError& error) {
    fail(error.status(), "clip \"%s\", frame %zu: %s (%s)", from.name.c_str(), first + error.pose(),
         error.reason().c_str(), describe_pose(schema(), controls.subspan(error.pose() * width, width)).c_str());
  }
}

void RigEvaluator::check_sizes(std::span<const float> controls, std::size_t count,
                               std::span<const float> points) const {
  const std::size_t width = rest_pose_.size(), size = coordinate_count();
  if (controls.size() != count * width || points.size() != count * size)
    fail(Status::invalid_argument, "%zu poses need %zu control values and %zu coordinates, not %zu and %zu", count,
         count * width, count * size, controls.size(), points.size());
}

void RigEvaluator::evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) {
  check_sizes(controls, count, points);
  spend(controls, count);
  give(controls, count, points, [&](std::span<float> to) { run_backend(controls, count, to); });
}

void RigEvaluator::evaluate_apart(std::span<const float> controls, std::size_t count, std::span<float> points) {
  check_sizes(controls, count, points);
  give(controls, count, points, [&](std::span<float> to) { run_backend(controls, count, to); });
}

void RigEvaluator::run_backend(std::span<const float> controls, std::size_t count, std::span<float> points) {
  const std::size_t width = rest_pose_.size(), size = rig_coordinate_count();
  std::vector<char> answered;
  for (std::size_t first = 0; first < count;) {
    const std::size_t poses = std::min(block_poses(), count - first);
    answered.assign(poses, 0);
    try {
      run_block({controls.subspan(first * width, poses * width), poses, points.subspan(first * size, poses * size),
                 answered});
    } catch (const PoseError& error) {
      throw PoseError(error.status(), first + error.pose(), error.reason());
    }
    first += poses;
  }
}

void RigEvaluator::evaluate_cached(std::span<const float> controls, std::size_t count, std::span<float> points) {
  check_sizes(controls, count, points);
  spend(controls, count);
  const Keep keep = cache_limit_.keep_requested ? Keep::all : Keep::within_limit;
  give(controls, count, points, [&](std::span<float> to) { run_cached(controls, count, to, keep); });
  tell_limit();
}

void RigEvaluator::evaluate_apart_cached(std::span<const float> controls, std::size_t count, std::span<float> points) {
  check_sizes(controls, count, points);
  give(controls, count, points, [&](std::span<float> to) { run_cached(controls, count, to, Keep::within_limit); });
}

void RigEvaluator::run_cached(std::span<const float> controls, std::size_t count, std::span<float> points, Keep keep) {
  if (!cache_) return run_backend(controls, count, points);
  const std::size_t width = rest_pose_.size(), size = rig_coordinate_count();
  const auto pose = [&](std::size_t i) { return controls.subspan(i * width, width); };
  const auto points_of = [&](std::size_t i) { return points.subspan(i * size, size); };
  std::vector<std::size_t> missing;
  std::vector<std::pair<std::size_t, std::size_t>> copies;  // pose, an equal one before it
  std::unordered_map<std::uint64_t, std::size_t> seen;
  std::unique_lock lock(caching_);
  const bool slow = missing_poses_ > 0 && missing_time_ >= static_cast<std::int64_t>(missing_poses_) * slow_pose;
  for (std::size_t i = 0; i < count; ++i) {
    if (cache_->find(pose(i), points_of(i))) continue;
    if (slow) {
      const auto [same, first] = seen.try_emplace(hash64_of(pose(i)), i);
      if (!first && std::ranges::equal(pose(i), pose(same->second))) {
        copies.emplace_back(i, same->second);
        continue;
      }
    }
    missing.push_back(i);
  }
  lock.unlock();
  evaluate_missing(controls, missing, points, keep);
  for (const auto& [to, from] : copies) std::ranges::copy(points_of(from), points_of(to).begin());
}

void RigEvaluator::evaluate_missing(std::span<const float> controls, std::span<const std::size_t> missing,
                                    std::span<float> points, Keep keep) {
  const std::size_t width = rest_pose_.size(), size = rig_coordinate_count();
  std::vector<float> some_controls, some_points;
  std::vector<char> answered;
  for (std::span<const std::size_t> left = missing; !left.empty();) {
    const std::span<const std::size_t> some = left.first(std::min(block_poses(), left.size()));
    left = left.subspan(some.size());
    const bool all = some.size() * width == controls.size();  // nothing to copy
    if (!all) {
      some_controls = gathered(controls, width, some);
      some_points.resize(some.size() * size);
    }
    answered.assign(some.size(), 0);
    const EvaluationBlock block = {all ? controls : some_controls, some.size(), all ? points : some_points, answered};
    const auto start = std::chrono::steady_clock::now();
    const auto take = [&] {
      for (std::size_t k = 0; k < some.size(); ++k)
        if (!all && answered[k])
          std::ranges::copy(block.points.subspan(k * size, size), points.begin() + some[k] * size);
      keep_slow(std::chrono::steady_clock::now() - start, block, keep);
    };
    try {
      run_block(block);
    } catch (const PoseError& error) {
      take();
      throw PoseError(error.status(), some[error.pose()], error.reason());
    } catch (...) {
      take();
      throw;
    }
    take();
  }
}

// Adds the answered poses of a block to the cache, if that pays.
void RigEvaluator::keep_slow(std::chrono::steady_clock::duration took, const EvaluationBlock& block, Keep keep) {
  const std::lock_guard lock(caching_);
  missing_time_ += took;
  missing_poses_ += block.count;
  while_writable([&] {
    if (pays_to_keep()) keep_answered(block, keep);
  });
}

// Runs what writes to the cache as long as that can be written.
template <class Work>
void RigEvaluator::while_writable(const Work& work) {
  if (!cache_failure_.empty()) return;
  try {
    work();
  } catch (const Error& error) {
    if (error.status() != Status::io) throw;
    cache_failure_ = error.what();
  }
}

std::uint64_t RigEvaluator::kept_pose_bytes() {
  const std::lock_guard lock(caching_);
  bool kept = false;
  if (cache_) while_writable([&] { kept = pays_to_keep(); });
  return kept ? cache_->record_bytes() : 0;
}

bool RigEvaluator::pays_to_keep() {
  if (missing_poses_ == 0 || missing_time_ < static_cast<std::int64_t>(missing_poses_) * slow_pose) return false;
  const double pose = std::chrono::duration<double>(missing_time_).count() / static_cast<double>(missing_poses_);
  if (static_cast<double>(cache_->record_bytes()) < pose * bytes_of_any_disk / kept_seconds) return true;
  if (!record_seconds_) record_seconds_ = cache_->measure_record_seconds();
  return pose >= kept_seconds * *record_seconds_;
}

void RigEvaluator::keep_answered(const EvaluationBlock& block, Keep keep) {
  const std::size_t width = rest_pose_.size(), size = rig_coordinate_count();
  for (std::size_t i = 0; i < block.count; ++i) {
    if (!block.answered[i]) continue;
    if (keep == Keep::within_limit && cache_->bytes_with_another() > cache_limit_.bytes) {
      limit_reached_ = true;
      break;
    }
    cache_->store(block.controls.subspan(i * width, width), block.points.subspan(i * size, size));
  }
  cache_->flush();
}

void RigEvaluator::tell_limit() {
  if (!limit_reached_ && cache_failure_.empty()) return;
  if (!parallel_.progress || std::exchange(limit_told_, true)) return;
  if (!cache_failure_.empty())
    return parallel_.progress->note(cache_failure_ +
                                    ". The bake goes on without keeping them: it evaluates again what it needs again");
  parallel_.progress->note(format(
      "%llu evaluations of the rig are kept on the disk, as many as the limit of %.0f MiB "
      "allows: the others are not, and an interrupted bake evaluates them again",
      static_cast<unsigned long long>(cache_->record_count()), static_cast<double>(cache_limit_.bytes) / (1 << 20)));
}

void RigEvaluator::evaluate_each(std::size_t count, EvaluationStage& stage, const Fill& fill, const Visit& visit,
                                 std::span<const std::uint32_t> vertices) {
  const std::size_t width = rest_pose_.size(), size = coordinate_count();
  std::vector<float> controls, points;
  const auto pose = [&](std::size_t i) { return std::span(controls).subspan(i * width, width); };
  // More than poses_in_memory only where the rig wants more at once, and then not many bytes.
  const std::size_t pose_bytes = sizeof(float) * size;
  const std::size_t most = std::max(std::clamp(wanted_bytes / pose_bytes, fewest_in_memory, poses_in_memory),
                                    std::min(backend_->least_poses(), bytes_in_memory / pose_bytes));
  for (std::size_t first = 0; first < count; first += most) {
    const std::size_t poses = std::min(most, count - first);
    controls.clear();
    for (std::size_t i = 0; i < poses; ++i) controls.insert(controls.end(), rest_pose_.begin(), rest_pose_.end());
    for (std::size_t i = 0; i < poses; ++i) fill(first + i, pose(i));
    points.resize(poses * size);
    try {
      evaluate_cached(controls, poses, points);
    } catch (const PoseError& error) {
      fail(error.status(), "control %s: %s", describe_pose(schema(), pose(error.pose())).c_str(),
           error.reason().c_str());
    }
    parallel_for(parallel_, poses, [&](std::size_t i, std::size_t) {
      const std::span<float> displacement = std::span(points).subspan(i * size, size);
      points_to_displacements(rest(), displacement, vertices);
      visit(first + i, pose(i), vertices.empty() ? displacement : displacement.first(3 * vertices.size()));
    });
    stage.advance(poses);
  }
}

EvaluationBudget::EvaluationBudget(RigEvaluator& rig, std::uint64_t poses)
    : rig_(rig),
      outer_(rig.budget_),
      poses_(poses),
      requested_before_(rig.requested()),
      evaluated_before_(rig.evaluated()) {
  rig.budget_ = this;
}

}  // namespace fb::bake
