#include "bake/baselines/skinning/bone_motion.h"

#include <algorithm>

#include "bake/baselines/skinning/bone_fitter.h"
#include "bake/linalg/gemm.h"

namespace fb::bake {

HoldoutSet::HoldoutSet(const PoseSet& poses, std::size_t most, Progress& progress) {
  const PoseSet some = poses.subsampled(most);
  const std::size_t rows = poses.source().rest().points.size();
  count = some.size();
  displacements.resize(count * rows);
  trajectories.resize(3 * count, rows / 3);
  progress.begin("reading poses for bones", count);
  for (std::size_t p = 0; p < count; ++p) {
    const std::span<float> pose = std::span(displacements).subspan(p * rows, rows);
    some.read_displacements(p, 1, pose);
    trajectories.middleRows(3 * p, 3) = Eigen::Map<const Eigen::Matrix3Xf>(pose.data(), 3, rows / 3);
    progress.step(p + 1);
  }
}

void fit_poses(const Skeleton& skeleton, const Mesh& rest, const HoldoutSet& poses, std::uint32_t sweeps,
               std::vector<float>& transforms, const Parallel& parallel) {
  const BoneFitter fitter(skeleton, rest);
  const bool warm = !transforms.empty();
  const std::size_t rows = rest.points.size(), numbers = skeleton.numbers();
  transforms.resize(poses.count * numbers);
  parallel_for(parallel, poses.count, [&](std::size_t p, std::size_t) {
    fitter.fit(std::span(poses.displacements).subspan(p * rows, rows),
               std::span(transforms).subspan(p * numbers, numbers), warm, sweeps);
  });
}

BoneMotion::BoneMotion(const Skeleton& skeleton, const Mesh& rest, const HoldoutSet& poses,
                       const std::vector<float>& transforms, const Parallel& parallel)
    : skeleton_(&skeleton), rest_(&rest) {
  const std::size_t bones = skeleton.bone_count(), numbers = skeleton.numbers(), rows = 3 * poses.count;
  Eigen::MatrixXf stacked(rows, 4 * bones);  // [A t] of a pose below that of the last, bones side by side
  for (std::size_t p = 0; p < poses.count; ++p)
    for (std::size_t b = 0; b < bones; ++b)
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t k = 0; k < 4; ++k)
          stacked(3 * p + axis, 4 * b + k) = transforms[p * numbers + 12 * b + 4 * axis + k];
  products_ = (stacked.transpose() * stacked).cast<double>();
  const std::size_t vertices = rest.vertex_count(), tile = 256;
  against_.resize(4 * bones, vertices);
  parallel_for(parallel, (vertices + tile - 1) / tile, [&](std::size_t i, std::size_t) {
    const std::size_t first = i * tile, count = std::min(tile, vertices - first);
    gemm(Op::transposed, Op::plain, 4 * bones, count, rows, stacked.data(), rows,
         poses.trajectories.data() + first * rows, rows, 0, against_.data() + first * 4 * bones, 4 * bones);
  });
}

Eigen::Vector4d BoneMotion::place(std::size_t vertex, std::size_t bone) const {
  Eigen::Vector4d x;
  for (int k = 0; k < 3; ++k) x[k] = double(rest_->points[3 * vertex + k]) - skeleton_->centres[bone][k];
  x[3] = 1;
  return x;
}

double BoneMotion::misfit(std::size_t vertex, std::size_t bone) const {
  const Eigen::Vector4d x = place(vertex, bone);
  return x.dot(products_.block<4, 4>(4 * bone, 4 * bone) * x) -
         2 * x.dot(against_.block<4, 1>(4 * bone, vertex).cast<double>());
}

void BoneMotion::form(std::size_t vertex, Eigen::MatrixXd& products, Eigen::VectorXd& against) const {
  const std::size_t bones = skeleton_->bone_count();
  Eigen::Matrix4Xd places(4, bones);
  for (std::size_t b = 0; b < bones; ++b) places.col(b) = place(vertex, b);
  products.resize(bones, bones);
  against.resize(bones);
  for (std::size_t b = 0; b < bones; ++b) {
    against[b] = places.col(b).dot(against_.block<4, 1>(4 * b, vertex).cast<double>());
    const Eigen::VectorXd column = products_.middleCols<4>(4 * b) * places.col(b);
    for (std::size_t a = 0; a < bones; ++a) products(a, b) = places.col(a).dot(column.segment<4>(4 * a));
  }
}

}  // namespace fb::bake
