#include "bake/baselines/ramp_blendshapes.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace fb::bake {
namespace {

using Matrix = Eigen::MatrixXf;  // a column is a shape or a pose

constexpr std::size_t most_fitted_poses = 4096;
constexpr float min_isolated_value = 0.05f;  // of a ramp: poses nearer to rest are too inexact to scale up

float value_of(const Feature& ramp, const RigSchema& schema, const float* pose) {
  return std::max((pose[ramp.control] - schema.controls[ramp.control].rest) * ramp.scale, 0.0f);
}

// Evaluates a live rig with every control at its limits.
Matrix evaluate_shapes(RigEvaluator& rig, const std::vector<Feature>& ramps, Progress& progress) {
  const std::vector<float>& rest = rig.rest().points;
  std::vector<float> poses;
  for (const Feature& ramp : ramps) {
    std::vector<float> pose = rig.schema().rest_pose();
    const Control& control = rig.schema().controls[ramp.control];
    pose[ramp.control] = ramp.scale > 0 ? control.maximum : control.minimum;
    poses.insert(poses.end(), pose.begin(), pose.end());
  }
  Matrix shapes(rest.size(), ramps.size());
  progress.begin(Phase::analysis, "evaluating blendshapes", ramps.size());
  rig.evaluate_cached(poses, ramps.size(), std::span(shapes.data(), shapes.size()));
  progress.step(ramps.size());
  return shapes.colwise() - Eigen::Map<const Eigen::VectorXf>(rest.data(), rest.size());
}

// The pose that has the largest value of each ramp while all others are 0.
struct IsolatedPoses {
  std::vector<std::size_t> pose;  // number of poses: none
  std::vector<float> value;
};

IsolatedPoses isolated_poses(const PoseSet& poses, const std::vector<Feature>& ramps) {
  const RigSchema& schema = poses.source().schema();
  const std::vector<float> controls = poses.controls();
  IsolatedPoses isolated{std::vector<std::size_t>(ramps.size(), poses.size()),
                         std::vector<float>(ramps.size(), min_isolated_value)};
  for (std::size_t pose = 0; pose < poses.size(); ++pose) {
    std::size_t active = 0, ramp = 0;
    float value = 0;
    for (std::size_t r = 0; r < ramps.size() && active < 2; ++r)
      if (const float v = value_of(ramps[r], schema, controls.data() + pose * schema.control_count()); v > 1e-6f) {
        ++active;
        ramp = r;
        value = v;
      }
    if (active == 1 && value > isolated.value[ramp]) {
      isolated.value[ramp] = value;
      isolated.pose[ramp] = pose;
    }
  }
  return isolated;
}

// Fits the shapes of the ramps `missing` to what the shapes of the others leave.
void fit_missing_shapes(const PoseSet& poses, const std::vector<Feature>& ramps,
                        const std::vector<std::size_t>& missing, Matrix& shapes, Progress& progress) {
  const RigSchema& schema = poses.source().schema();
  const std::size_t rows = poses.source().rest().points.size();
  const PoseSet sample = poses.subsampled(most_fitted_poses);
  progress.begin(Phase::analysis, "fitting blendshapes", sample.size());
  const std::vector<float> controls = sample.controls();
  Matrix inner = Matrix::Zero(missing.size(), missing.size()), outer = Matrix::Zero(rows, missing.size());
  Matrix residual(rows, 1);
  Eigen::VectorXf weights(ramps.size()), missing_weights(missing.size());
  for (std::size_t pose = 0; pose < sample.size(); ++pose) {
    progress.step(pose + 1);
    for (std::size_t r = 0; r < ramps.size(); ++r)
      weights[r] = value_of(ramps[r], schema, controls.data() + pose * schema.control_count());
    for (std::size_t m = 0; m < missing.size(); ++m) missing_weights[m] = weights[missing[m]];
    if (missing_weights.isZero(0)) continue;
    sample.read_displacements(pose, 1, std::span(residual.data(), rows));
    residual.noalias() -= shapes * weights;
    inner.noalias() += missing_weights * missing_weights.transpose();
    outer.noalias() += residual * missing_weights.transpose();
  }
  inner.diagonal().array() += 1e-3f * std::max(inner.trace() / missing.size(), 1e-6f);
  const Matrix fitted = inner.ldlt().solve(outer.transpose()).transpose();
  for (std::size_t m = 0; m < missing.size(); ++m) shapes.col(missing[m]) = fitted.col(m);
}

Matrix recorded_shapes(const PoseSet& poses, const std::vector<Feature>& ramps, Progress& progress) {
  const std::size_t rows = poses.source().rest().points.size();
  const IsolatedPoses isolated = isolated_poses(poses, ramps);
  Matrix shapes = Matrix::Zero(rows, ramps.size());
  std::vector<std::size_t> missing;
  progress.begin(Phase::analysis, "finding blendshapes", ramps.size());
  for (std::size_t r = 0; r < ramps.size(); ++r) {
    if (isolated.pose[r] < poses.size()) {
      poses.read_displacements(isolated.pose[r], 1, std::span(shapes.col(r).data(), rows));
      shapes.col(r) /= isolated.value[r];
    } else {
      missing.push_back(r);
    }
    progress.step(r + 1);
  }
  if (missing.empty()) return shapes;
  progress.note(std::to_string(missing.size()) + " of " + std::to_string(ramps.size()) +
                " blendshapes are never seen alone and are fitted by least squares");
  fit_missing_shapes(poses, ramps, missing, shapes, progress);
  return shapes;
}

}  // namespace

std::vector<Feature> ramp_features(const RigSchema& schema) {
  std::vector<Feature> ramps;
  for (std::size_t c = 0; c < schema.control_count(); ++c) {
    const Control& control = schema.controls[c];
    for (const float limit : {control.maximum, control.minimum})
      if (limit != control.rest)
        ramps.push_back({Feature::Kind::ramp, static_cast<std::uint32_t>(c), 1 / (limit - control.rest), 0});
  }
  return ramps;
}

std::vector<float> ramp_shapes(const PoseSet& poses, RigEvaluator* rig, const std::vector<Feature>& ramps,
                               Progress& progress) {
  const Matrix shapes = rig ? evaluate_shapes(*rig, ramps, progress) : recorded_shapes(poses, ramps, progress);
  return std::vector<float>(shapes.data(), shapes.data() + shapes.size());
}

void drop_below(std::vector<float>& shapes, const Mesh& rest, double threshold) {
  const float least = static_cast<float>(threshold * rest.diagonal());
  for (float& value : shapes)
    if (std::abs(value) < least) value = 0;
}

}  // namespace fb::bake
