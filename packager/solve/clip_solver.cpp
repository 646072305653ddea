#include "solve/clip_solver.h"

#include <facebaker/facebaker_solve.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include "base/status.h"

namespace fb::tool {
namespace {

constexpr std::size_t decided_frames = 16;  // that tell which controls the target decides
constexpr std::size_t motion_floats = 12;

struct DestroySolver {
  void operator()(fb_solver* solver) const { fb_solver_destroy(solver); }
};
using SolverPointer = std::unique_ptr<fb_solver, DestroySolver>;

SolverPointer make_solver(const facebaker::Model& model, const SolveTarget& target) {
  std::vector<std::uint32_t> vertices;
  std::vector<float> weights;
  for (const SurfacePoint& point : target.face_points) {
    vertices.insert(vertices.end(), point.vertices.begin(), point.vertices.end());
    weights.insert(weights.end(), point.weights.begin(), point.weights.end());
  }
  fb_solver_desc desc;
  fb_solver_desc_init(&desc);
  if (!target.face_points.empty()) {
    desc.point_count = static_cast<std::uint32_t>(target.face_points.size());
    desc.point_vertices = vertices.data();
    desc.point_weights = weights.data();
  }
  fb_solver* solver = nullptr;
  facebaker::check(fb_solver_create(model.get(), &desc, &solver));
  return SolverPointer(solver);
}

class ClipSolver {
 public:
  ClipSolver(const facebaker::Model& model, const SolveTarget& target, const ClipPreferences& preferences)
      : target_(target),
        preferences_(preferences),
        solver_(make_solver(model, target)),
        controls_(model.control_count()),
        points_(target.points(model.vertex_count())),
        rest_(fb_rest_controls(model.get()), fb_rest_controls(model.get()) + controls_),
        current_(rest_),
        motion_(preferences.find_motion ? motion_floats : 0),
        differences_(points_),
        decided_(controls_),
        measured_(points_) {
    clip.controls.resize(target.frames * controls_);
    clip.motions.resize(target.frames * motion_.size());
    clip.frames.resize(target.frames);
    clip.decided.resize(controls_);
    clip.point_squares.resize(points_);
    clip.point_max.resize(points_);
  }

  // before: where the frame's controls should be near, by `smoothness`; null: nowhere.
  void solve_frame(std::size_t frame, const float* before, float smoothness, bool last) {
    find_targets(frame);
    fb_solve_desc desc;
    fb_solve_desc_init(&desc);
    desc.points = targets_.data();
    desc.noise = preferences_.noise;
    desc.nearness = preferences_.nearness;
    desc.sparsity = preferences_.sparsity;
    desc.smoothness = smoothness;
    desc.symmetry = preferences_.symmetry;
    desc.max_iterations = preferences_.most_iterations;
    desc.tolerance = 1e-3f;  // a clip has time
    desc.before = before;
    desc.movable = preferences_.movable.empty() ? nullptr : preferences_.movable.data();
    desc.find_motion = preferences_.find_motion;
    desc.controls = current_.data();
    desc.motion = motion_.empty() ? nullptr : motion_.data();
    desc.point_differences = last ? differences_.data() : nullptr;
    const std::size_t step = std::max<std::size_t>(1, target_.frames / decided_frames);
    const bool decides = last && frame % step == 0;
    desc.decided = decides ? decided_.data() : nullptr;
    fb_solve_result result;
    fb_solve_result_init(&result);
    if (fb_solve(solver_.get(), &desc, &result) != FB_OK)
      fail(Status::bad_data, "frame %zu of %s: %s", frame, target_.what.c_str(), fb_last_error());
    std::copy(current_.begin(), current_.end(), clip.controls.begin() + std::ptrdiff_t(frame * controls_));
    std::copy(motion_.begin(), motion_.end(), clip.motions.begin() + std::ptrdiff_t(frame * motion_.size()));
    clip.frames[frame] = {clip.frames[frame].iterations + result.iterations, result.point_count, result.worst_point,
                          result.rms_difference, result.max_difference};
    if (last) note_differences(decides);
  }

  void start_from(std::size_t frame) {
    std::copy_n(clip.controls.begin() + std::ptrdiff_t(frame * controls_), controls_, current_.begin());
    std::copy_n(clip.motions.begin() + std::ptrdiff_t(frame * motion_.size()), motion_.size(), motion_.begin());
  }
  const float* controls_of(std::size_t frame) const { return clip.controls.data() + frame * controls_; }
  std::size_t control_count() const { return controls_; }

  void finish() {
    for (std::size_t p = 0; p < points_; ++p)
      if (measured_[p] > 0) clip.point_squares[p] /= measured_[p];
    for (float& share : clip.decided) share /= static_cast<float>(std::max<std::size_t>(1, decided_count_));
  }

  SolvedClip clip;

 private:
  // Offsets turn with the head, as it was last found.
  void find_targets(std::size_t frame) {
    target_.find(frame, raw_, targets_);
    const auto infinite = std::find_if(raw_.begin(), raw_.end(), [](float number) { return std::isinf(number); });
    if (infinite != raw_.end())
      fail(Status::not_finite, "frame %zu of %s: point %zu is infinite", frame, target_.what.c_str(),
           static_cast<std::size_t>(infinite - raw_.begin()) / 3);
    if (targets_.size() != 3 * points_)
      fail(Status::bad_data, "frame %zu of %s has %zu points, and %zu are followed", frame, target_.what.c_str(),
           targets_.size() / 3, points_);
    const bool turned = !motion_.empty() && std::any_of(motion_.begin(), motion_.end(), [](float m) { return m != 0; });
    for (std::size_t p = 0; p < points_ && !target_.offsets.empty(); ++p)
      for (std::size_t a = 0; a < 3; ++a) {
        const float* const offset = &target_.offsets[3 * p];
        targets_[3 * p + a] -=
            turned ? motion_[4 * a] * offset[0] + motion_[4 * a + 1] * offset[1] + motion_[4 * a + 2] * offset[2]
                   : offset[a];
      }
  }

  void note_differences(bool decides) {
    for (std::size_t p = 0; p < points_; ++p) {
      if (!(differences_[p] >= 0)) continue;
      clip.point_squares[p] += double(differences_[p]) * differences_[p];
      clip.point_max[p] = std::max(clip.point_max[p], differences_[p]);
      ++measured_[p];
    }
    if (!decides) return;
    for (std::size_t c = 0; c < controls_; ++c) clip.decided[c] += decided_[c];
    ++decided_count_;
  }

  const SolveTarget& target_;
  const ClipPreferences& preferences_;
  SolverPointer solver_;
  std::size_t controls_, points_, decided_count_ = 0;
  std::vector<float> rest_, current_, motion_, raw_, targets_, differences_, decided_;
  std::vector<std::size_t> measured_;
};

}  // namespace

SolvedClip solve_clip(const facebaker::Model& model, const SolveTarget& target, const ClipPreferences& preferences,
                      Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  ClipSolver solver(model, target, preferences);
  const std::size_t frames = target.frames;
  const bool backwards = preferences.backwards && preferences.smoothness > 0 && frames > 1;
  progress.begin(Phase::measuring, "solving frames", backwards ? 2 * frames - 1 : frames);
  for (std::size_t f = 0; f < frames; ++f) {
    const float* const before = f > 0 ? solver.controls_of(f - 1) : nullptr;
    solver.solve_frame(f, before, preferences.smoothness, !backwards || f + 1 == frames);
    progress.step(f + 1);
  }
  // Both neighbours count: the squares of the distances from them are, but for a constant, twice that of their mean.
  std::vector<float> between(solver.control_count());
  for (std::size_t f = frames - 1; f > 0 && backwards; --f) {
    const std::size_t frame = f - 1;
    for (std::size_t c = 0; c < between.size(); ++c) {
      const float after = solver.controls_of(f)[c];
      between[c] = frame > 0 ? 0.5f * (solver.controls_of(frame - 1)[c] + after) : after;
    }
    solver.start_from(frame);
    solver.solve_frame(frame, between.data(), frame > 0 ? 2 * preferences.smoothness : preferences.smoothness, true);
    progress.step(frames + frames - f);
  }
  solver.finish();
  solver.clip.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return std::move(solver.clip);
}

}  // namespace fb::tool
