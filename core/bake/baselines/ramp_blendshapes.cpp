#include "bake/baselines/ramp_blendshapes.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace fb::bake {
namespace {

using Matrix = Eigen::MatrixXf;  // a column is a shape or a pose

constexpr std::size_t fitted_poses = 4096;

float value_of(const Feature& ramp, const RigSchema& schema, const float* pose) {
  return std::max((pose[ramp.control] - schema.controls[ramp.control].rest) * ramp.scale, 0.0f);
}

// Evaluates every control at its limits.
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
  progress.begin("evaluating blendshapes", ramps.size());
  rig.evaluate_cached(poses, ramps.size(), std::span(shapes.data(), shapes.size()));
  progress.step(ramps.size());
  return shapes.colwise() - Eigen::Map<const Eigen::VectorXf>(rest.data(), rest.size());
}

Matrix find_shapes(const PoseSet& poses, const std::vector<Feature>& ramps, Progress& progress) {
  const RigSchema& schema = poses.source().schema();
  const std::size_t rows = poses.source().rest().points.size();
  const std::vector<float> controls = poses.controls();
  std::vector<float> furthest(ramps.size(), 0.05f);  // nearer to rest says too little
  std::vector<std::size_t> alone(ramps.size(), poses.size());
  for (std::size_t pose = 0; pose < poses.size(); ++pose) {
    std::size_t active = 0, which = 0;
    float value = 0;
    for (std::size_t r = 0; r < ramps.size() && active < 2; ++r)
      if (const float v = value_of(ramps[r], schema, controls.data() + pose * schema.control_count()); v > 1e-6f) {
        ++active;
        which = r;
        value = v;
      }
    if (active == 1 && value > furthest[which]) {
      furthest[which] = value;
      alone[which] = pose;
    }
  }

  Matrix shapes = Matrix::Zero(rows, ramps.size());
  std::vector<std::size_t> missing;
  progress.begin("finding blendshapes", ramps.size());
  for (std::size_t r = 0; r < ramps.size(); ++r) {
    if (alone[r] < poses.size()) {
      poses.read_displacements(alone[r], 1, std::span(shapes.col(r).data(), rows));
      shapes.col(r) /= furthest[r];
    } else {
      missing.push_back(r);
    }
    progress.step(r + 1);
  }
  if (missing.empty()) return shapes;

  progress.note(std::to_string(missing.size()) + " of " + std::to_string(ramps.size()) +
                " blendshapes are never seen alone and are fitted by least squares");
  const PoseSet sample = poses.subsampled(fitted_poses);
  progress.begin("fitting blendshapes", sample.size());
  const std::vector<float> sampled = sample.controls();
  Matrix inner = Matrix::Zero(missing.size(), missing.size()), outer = Matrix::Zero(rows, missing.size());
  Matrix block(rows, 1);
  Eigen::VectorXf weights(ramps.size()), open(missing.size());
  for (std::size_t pose = 0; pose < sample.size(); ++pose) {
    progress.step(pose + 1);
    for (std::size_t r = 0; r < ramps.size(); ++r)
      weights[r] = value_of(ramps[r], schema, sampled.data() + pose * schema.control_count());
    for (std::size_t m = 0; m < missing.size(); ++m) open[m] = weights[missing[m]];
    if (open.isZero(0)) continue;
    sample.read_displacements(pose, 1, std::span(block.data(), rows));
    block.noalias() -= shapes * weights;
    inner.noalias() += open * open.transpose();
    outer.noalias() += block * open.transpose();
  }
  inner.diagonal().array() += 1e-3f * std::max(inner.trace() / missing.size(), 1e-6f);
  const Matrix fitted = inner.ldlt().solve(outer.transpose()).transpose();
  for (std::size_t m = 0; m < missing.size(); ++m) shapes.col(missing[m]) = fitted.col(m);
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
  const Matrix shapes = rig ? evaluate_shapes(*rig, ramps, progress) : find_shapes(poses, ramps, progress);
  return std::vector<float>(shapes.data(), shapes.data() + shapes.size());
}

void drop_below(std::vector<float>& shapes, const Mesh& rest, double share) {
  const float least = static_cast<float>(share * rest.diagonal());
  for (float& value : shapes)
    if (std::abs(value) < least) value = 0;
}

}  // namespace fb::bake
