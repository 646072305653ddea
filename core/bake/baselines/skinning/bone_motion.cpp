#include "bake/baselines/skinning/bone_motion.h"

#include <algorithm>

#include "bake/baselines/skinning/bone_fitter.h"
#include "bake/linalg/gemm.h"

namespace fb::bake {

PoseSample::PoseSample(const PoseSet& poses, std::size_t max_count, Progress& progress) {
  const PoseSet sample = poses.subsampled(max_count);
  const std::size_t rows = poses.source().rest().points.size();
  count = sample.size();
  displacements.resize(count * rows);
  trajectories.resize(3 * count, rows / 3);
  progress.begin(Phase::analysis, "reading poses for bones", count);
  for (std::size_t p = 0; p < count; ++p) {
    const std::span<float> pose = std::span(displacements).subspan(p * rows, rows);
    sample.read_displacements(p, 1, pose);
    trajectories.middleRows(3 * p, 3) = Eigen::Map<const Eigen::Matrix3Xf>(pose.data(), 3, rows / 3);
    progress.step(p + 1);
  }
}

PoseSample::PoseSample(const Mesh& rest, std::span<const float> points)
    : count(points.size() / rest.points.size()), displacements(points.begin(), points.end()) {
  const std::size_t rows = rest.points.size();
  for (std::size_t i = 0; i < displacements.size(); ++i) displacements[i] -= rest.points[i % rows];
  trajectories.resize(3 * count, rows / 3);
  for (std::size_t p = 0; p < count; ++p)
    trajectories.middleRows(3 * p, 3) = Eigen::Map<const Eigen::Matrix3Xf>(&displacements[p * rows], 3, rows / 3);
}

void fit_poses(const Skeleton& skeleton, const Mesh& rest, const PoseSample& poses, std::uint32_t sweeps,
               std::vector<float>& transforms, const Parallel& parallel) {
  const BoneFitter fitter(skeleton, rest);
  const bool warm_start = !transforms.empty();
  const std::size_t rows = rest.points.size(), parameters = skeleton.parameter_count();
  transforms.resize(poses.count * parameters);
  parallel_for(parallel, poses.count, [&](std::size_t p, std::size_t) {
    fitter.fit(std::span(poses.displacements).subspan(p * rows, rows),
               std::span(transforms).subspan(p * parameters, parameters), warm_start, sweeps);
  });
}

BoneMotion::BoneMotion(const Skeleton& skeleton, const Mesh& rest, const PoseSample& poses,
                       const std::vector<float>& transforms, const Parallel& parallel)
    : skeleton_(&skeleton), rest_(&rest) {
  const std::size_t bones = skeleton.bone_count(), parameters = skeleton.parameter_count(), rows = 3 * poses.count;
  Eigen::MatrixXf stacked(rows, 4 * bones);  // [A t] of all poses below each other, of all bones side by side
  for (std::size_t p = 0; p < poses.count; ++p)
    for (std::size_t b = 0; b < bones; ++b)
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t k = 0; k < 4; ++k)
          stacked(3 * p + axis, 4 * b + k) = transforms[p * parameters + 12 * b + 4 * axis + k];
  products_ = (stacked.transpose() * stacked).cast<double>();
  const std::size_t vertices = rest.vertex_count(), tile = 256;
  projections_.resize(4 * bones, vertices);
  parallel_for(parallel, (vertices + tile - 1) / tile, [&](std::size_t i, std::size_t) {
    const std::size_t first = i * tile, count = std::min(tile, vertices - first);
    gemm(Op::transposed, Op::plain, 4 * bones, count, rows, stacked.data(), rows,
         poses.trajectories.data() + first * rows, rows, 0, projections_.data() + first * 4 * bones, 4 * bones);
  });
}

Eigen::Vector4d BoneMotion::local_position(std::size_t vertex, std::size_t bone) const {
  Eigen::Vector4d x;
  for (int k = 0; k < 3; ++k) x[k] = double(rest_->points[3 * vertex + k]) - skeleton_->centres[bone][k];
  x[3] = 1;
  return x;
}

double BoneMotion::error(std::size_t vertex, std::size_t bone) const {
  const Eigen::Vector4d x = local_position(vertex, bone);
  return x.dot(products_.block<4, 4>(4 * bone, 4 * bone) * x) -
         2 * x.dot(projections_.block<4, 1>(4 * bone, vertex).cast<double>());
}

void BoneMotion::quadratic_form(std::size_t vertex, Eigen::MatrixXd& quadratic, Eigen::VectorXd& linear) const {
  const std::size_t bones = skeleton_->bone_count();
  Eigen::Matrix4Xd positions(4, bones);
  for (std::size_t b = 0; b < bones; ++b) positions.col(b) = local_position(vertex, b);
  quadratic.resize(bones, bones);
  linear.resize(bones);
  for (std::size_t b = 0; b < bones; ++b) {
    linear[b] = positions.col(b).dot(projections_.block<4, 1>(4 * b, vertex).cast<double>());
    const Eigen::VectorXd column = products_.middleCols<4>(4 * b) * positions.col(b);
    for (std::size_t a = 0; a < bones; ++a) quadratic(a, b) = positions.col(a).dot(column.segment<4>(4 * a));
  }
}

}  // namespace fb::bake
