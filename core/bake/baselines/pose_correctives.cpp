#include "bake/baselines/pose_correctives.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "bake/analysis/sparse_blendshapes.h"
#include "bake/baselines/pca.h"
#include "bake/linalg/gemm.h"

namespace fb::bake {
namespace {

using Matrix = Eigen::MatrixXf;  // a column is a feature or a component, a row a pose

constexpr double variance_held = 0.999;
constexpr Eigen::Index leading = 48;   // components that choices are made by
constexpr Eigen::Index held_back = 5;  // every fifth pose
constexpr Eigen::Index poses_to_choose = 3000;
constexpr Eigen::Index poses_a_corrective = 12;  // at least
constexpr float ridge = 1e-3f;

// Two ramps, or twice the same for the hat between its ends.
struct Candidate {
  Feature feature;
  float score = 0;
};

Feature hat_half_way(const Feature& ramp) {
  return {Feature::Kind::hat, ramp.control, 2 * ramp.scale, 0, 1};
}

// The values of a feature of ramps whose values are given.
Eigen::VectorXf value_of(const Feature& feature, const std::vector<Feature>& ramps, const Matrix& values) {
  if (feature.kind == Feature::Kind::product) return values.col(feature.first).cwiseProduct(values.col(feature.second));
  if (feature.kind == Feature::Kind::minimum) return values.col(feature.first).cwiseMin(values.col(feature.second));
  for (std::size_t r = 0; r < ramps.size(); ++r)
    if (ramps[r].control == feature.control && ramps[r].scale * feature.scale > 0) {
      const Eigen::ArrayXf twice = 2 * values.col(r).array();
      return twice.min(2 - twice).max(0);
    }
  return Eigen::VectorXf::Zero(values.rows());
}

// How much of what is left each feature with ramp `a` (and a later one) explains on its own; of the product and the
// minimum of two ramps the better one.
std::vector<Candidate> candidates_with(std::size_t a, const std::vector<Feature>& ramps, const Matrix& values,
                                       const Matrix& left) {
  const Eigen::Index later = values.cols() - static_cast<Eigen::Index>(a) - 1, poses = values.rows();
  Matrix tried(poses, 2 * later + 1), pulls(left.cols(), tried.cols());
  tried.col(0) = value_of(hat_half_way(ramps[a]), ramps, values);
  for (Eigen::Index b = 0; b < later; ++b) {
    const auto other = values.col(static_cast<Eigen::Index>(a) + 1 + b);
    tried.col(2 * b + 1) = values.col(a).cwiseProduct(other);
    tried.col(2 * b + 2) = values.col(a).cwiseMin(other);
  }
  gemm(Op::transposed, Op::plain, left.cols(), tried.cols(), poses, left.data(), poses, tried.data(), poses, 0,
       pulls.data(), left.cols());
  const auto score = [&](Eigen::Index column) {
    if ((tried.col(column).array() > 1e-3f).count() < poses_a_corrective) return 0.0f;
    return pulls.col(column).squaredNorm() / tried.col(column).squaredNorm();
  };
  std::vector<Candidate> found = {{hat_half_way(ramps[a]), score(0)}};
  for (Eigen::Index b = 0; b < later; ++b) {
    Feature feature{Feature::Kind::product};
    feature.first = static_cast<std::uint32_t>(a);
    feature.second = static_cast<std::uint32_t>(a + 1 + b);
    const float product = score(2 * b + 1), minimum = score(2 * b + 2);
    if (ramps[feature.first].control == ramps[feature.second].control) continue;  // never on together
    if (minimum > product) feature.kind = Feature::Kind::minimum;
    found.push_back({feature, std::max(product, minimum)});
  }
  return found;
}

bool same(const Feature& a, const Feature& b) {
  return a.kind == b.kind && a.control == b.control && a.scale == b.scale && a.first == b.first && a.second == b.second;
}

// The features that explain most of what is left, new ones only.
std::vector<Feature> choose(const std::vector<Feature>& ramps, const Matrix& values, const Matrix& left,
                            const std::vector<Feature>& taken, std::size_t count, const Parallel& parallel) {
  std::vector<std::vector<Candidate>> by_ramp(ramps.size());
  parallel_for(parallel, ramps.size(),
               [&](std::size_t a, std::size_t) { by_ramp[a] = candidates_with(a, ramps, values, left); });
  std::vector<Candidate> all;
  for (const std::vector<Candidate>& some : by_ramp)
    for (const Candidate& candidate : some)
      if (candidate.score > 0 && std::none_of(taken.begin(), taken.end(),
                                              [&](const Feature& feature) { return same(feature, candidate.feature); }))
        all.push_back(candidate);
  std::stable_sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  std::vector<Feature> chosen;
  for (std::size_t i = 0; i < std::min(count, all.size()); ++i) chosen.push_back(all[i].feature);
  return chosen;
}

Matrix fit(const Matrix& features, const Matrix& targets) {
  Matrix inner = features.transpose() * features;
  inner.diagonal().array() += ridge * std::max(inner.trace() / static_cast<float>(inner.rows()), 1e-12f);
  return inner.ldlt().solve(features.transpose() * targets);
}

// Every fifth row, or all others.
Matrix rows_of(const Matrix& all, bool held) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < all.rows(); ++i)
    if ((i % held_back == held_back - 1) == held) rows.push_back(i);
  return all(rows, Eigen::all);
}

bool moves_nothing(const PoseRows& rows, const Parallel& parallel) {
  const std::unique_ptr<PoseRows> few = rows.subsampled(64);
  std::vector<float> values(few->size() * few->rows());
  few->read(0, few->size(), values, parallel);
  return std::all_of(values.begin(), values.end(), [](float value) { return value == 0; });
}

}  // namespace

PoseCorrectives find_correctives(const PoseRows& residual, const std::vector<Feature>& ramps,
                                 const CorrectiveOptions& options, const Parallel& parallel, Progress& progress) {
  const std::unique_ptr<PoseRows> sample = residual.subsampled(options.poses);
  const auto poses = static_cast<Eigen::Index>(sample->size());
  const std::size_t most =
      std::min(options.most, static_cast<std::size_t>((poses - poses / held_back) / poses_a_corrective));
  if (most == 0 || ramps.empty() || moves_nothing(*sample, parallel)) return {};
  const PrincipalComponents pca = principal_components(*sample, variance_held, parallel, progress);
  const Matrix targets = Eigen::Map<const Matrix>(pca.coefficients.data(), pca.count, poses).transpose();

  const RigSchema& schema = residual.poses().source().schema();
  const std::vector<float> controls = sample->poses().controls(), rest = schema.rest_pose();
  Eigen::MatrixXf by_pose(ramps.size(), poses);
  for (Eigen::Index i = 0; i < poses; ++i)
    evaluate_features(ramps, std::span(controls).subspan(i * rest.size(), rest.size()), rest,
                      std::span(by_pose.col(i).data(), ramps.size()));
  const Matrix values = by_pose.transpose();
  const Matrix train = rows_of(values, false), train_targets = rows_of(targets, false);
  const Matrix check = rows_of(values, true), check_targets = rows_of(targets, true);
  std::vector<Eigen::Index> few(std::min(poses_to_choose, train.rows()));
  for (std::size_t i = 0; i < few.size(); ++i)
    few[i] = static_cast<Eigen::Index>(i) * train.rows() / static_cast<Eigen::Index>(few.size());

  std::vector<Feature> taken, best;
  Matrix train_features(train.rows(), 0), check_features(check.rows(), 0), left = train_targets;
  double least = check_targets.squaredNorm();
  progress.begin("choosing correctives", options.rounds);
  for (std::uint32_t round = 0; round < options.rounds; ++round) {
    const std::size_t wanted = most * (round + 1) / options.rounds - taken.size();
    const std::vector<Feature> more =
        choose(ramps, train(few, Eigen::all), left(few, Eigen::seqN(0, std::min(leading, left.cols()))), taken, wanted,
               parallel);
    if (more.empty()) break;
    const Eigen::Index before = train_features.cols(), after = before + static_cast<Eigen::Index>(more.size());
    train_features.conservativeResize(Eigen::NoChange, after);
    check_features.conservativeResize(Eigen::NoChange, after);
    for (std::size_t i = 0; i < more.size(); ++i) {
      train_features.col(before + i) = value_of(more[i], ramps, train);
      check_features.col(before + i) = value_of(more[i], ramps, check);
    }
    taken.insert(taken.end(), more.begin(), more.end());
    const Matrix shapes = fit(train_features, train_targets);
    left = train_targets - train_features * shapes;
    const double error = (check_targets - check_features * shapes).squaredNorm();
    progress.step(round + 1);
    if (error >= least) break;
    least = error;
    best = taken;
  }
  if (best.empty()) return {};

  Matrix features(poses, best.size());
  for (std::size_t i = 0; i < best.size(); ++i) features.col(i) = value_of(best[i], ramps, values);
  const Matrix shapes = fit(features, targets);  // features x components
  PoseCorrectives result{best, std::vector<float>(best.size() * pca.rows)};
  const Matrix turned = shapes.transpose();
  gemm(Op::plain, Op::plain, pca.rows, best.size(), pca.count, pca.components.data(), pca.rows, turned.data(),
       pca.count, 0, result.shapes.data(), pca.rows);
  return result;
}

}  // namespace fb::bake
