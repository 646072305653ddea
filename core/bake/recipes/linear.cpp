// Linear blendshapes: each control's shape at its limit, one for either side of rest, scaled by how far the control is
// and added up. What a rig exports to an engine today, and what every method is compared with.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "bake/recipes/finish_face.h"
#include "bake/rig/evaluate_parallel.h"
#include "base/checked.h"

namespace fb {
namespace {

using Matrix = Eigen::MatrixXf;  // a column is a shape or a pose

constexpr float negligible = 1e-7f;         // of the diagonal: what a shape leaves out
constexpr double packing_tolerance = 1e-6;  // over the diagonal: there is no other error to hide a larger one in
constexpr std::size_t fitted_poses = 4096;

// One side of a control: a ramp that is 0 at rest and 1 at the limit.
std::vector<Feature> ramps_of(const RigSchema& schema) {
  std::vector<Feature> ramps;
  for (std::size_t c = 0; c < schema.control_count(); ++c) {
    const Control& control = schema.controls[c];
    for (const float limit : {control.maximum, control.minimum})
      if (limit != control.rest)
        ramps.push_back({Feature::Kind::ramp, static_cast<std::uint32_t>(c), 1 / (limit - control.rest), 0});
  }
  return ramps;
}

float value_of(const Feature& ramp, const RigSchema& schema, const float* pose) {
  return std::max((pose[ramp.control] - schema.controls[ramp.control].rest) * ramp.scale, 0.0f);
}

// Asks a live rig for every control at its limits.
Matrix ask_shapes(Source& rig, const std::vector<Feature>& ramps, const Parallel& parallel, Progress& progress) {
  const std::vector<float>& rest = rig.rest().points;
  std::vector<float> poses;
  for (const Feature& ramp : ramps) {
    std::vector<float> pose = rig.schema().rest_pose();
    const Control& control = rig.schema().controls[ramp.control];
    pose[ramp.control] = ramp.scale > 0 ? control.maximum : control.minimum;
    poses.insert(poses.end(), pose.begin(), pose.end());
  }
  Matrix shapes(rest.size(), ramps.size());
  progress.begin("asking for blendshapes", ramps.size());
  evaluate_parallel(rig, poses, ramps.size(), std::span(shapes.data(), shapes.size()), parallel);
  progress.step(ramps.size());
  return shapes.colwise() - Eigen::Map<const Eigen::VectorXf>(rest.data(), rest.size());
}

// From recorded poses: the pose in which a ramp is furthest along alone gives its shape; the shapes of ramps that are
// never alone are fitted to what the others leave, by least squares over evenly spaced poses.
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
  const PoseSet sample = poses.thinned(fitted_poses);
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

Learnt make_linear(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress) {
  Learnt learnt;
  FaceModel& model = learnt.model;
  model.schema = poses.source().schema();
  model.rest = poses.source().rest();
  model.network.features = ramps_of(model.schema);
  Matrix shapes = rig ? ask_shapes(*rig, model.network.features, options.parallel, progress)
                      : find_shapes(poses, model.network.features, progress);
  const float least = negligible * static_cast<float>(model.rest.diagonal());
  shapes = (shapes.array().abs() < least).select(0.0f, shapes);
  model.network.direct.resize(model.network.features.size());
  std::iota(model.network.direct.begin(), model.network.direct.end(), 0u);
  model.basis = make_basis(checked_u32(shapes.rows(), "coordinates"), checked_u32(shapes.cols(), "blendshapes"),
                           std::vector<float>(shapes.data(), shapes.data() + shapes.size()));
  learnt.packing.basis_tolerance = packing_tolerance;
  if (asks_target(options)) return finish_face(model, {}, {}, learnt.packing, poses, options, progress);
  return learnt;
}

}  // namespace fb
