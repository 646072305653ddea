#include "bake/baselines/pose_correctives.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "bake/analysis/sparse_blendshapes.h"
#include "bake/baselines/pca.h"
#include "bake/linalg/gemm.h"

namespace fb::bake {
namespace {

using Matrix = Eigen::MatrixXf;  // a column is a feature or a component, a row a pose

constexpr double target_variance = 0.999;          // share that the principal components of the residual hold
constexpr Eigen::Index scored_components = 48;     // leading components by which candidates are scored
constexpr Eigen::Index validation_stride = 5;      // every fifth pose is a validation pose
constexpr Eigen::Index scored_poses = 3000;        // at most
constexpr Eigen::Index poses_per_corrective = 12;  // in which a corrective is active, at least
constexpr float ridge = 1e-3f;                     // over the mean of the diagonal

struct Candidate {
  Feature feature;
  float score = 0;
};

// A hat with its peak at half the ramp.
Feature middle_hat(const Feature& ramp) {
  return {Feature::Kind::hat, ramp.control, 2 * ramp.scale, 0, 1};
}

// The values of a feature from those of the ramps (poses x ramps).
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

// Scores the features of ramp `a` alone and with each later ramp by how much of the residual they explain on their own.
// Of the product and the minimum of two ramps, keeps the better one.
std::vector<Candidate> score_candidates(std::size_t a, const std::vector<Feature>& ramps, const Matrix& values,
                                        const Matrix& residual) {
  const Eigen::Index later = values.cols() - static_cast<Eigen::Index>(a) - 1, poses = values.rows();
  Matrix candidates(poses, 2 * later + 1), products(residual.cols(), candidates.cols());
  candidates.col(0) = value_of(middle_hat(ramps[a]), ramps, values);
  for (Eigen::Index b = 0; b < later; ++b) {
    const auto other = values.col(static_cast<Eigen::Index>(a) + 1 + b);
    candidates.col(2 * b + 1) = values.col(a).cwiseProduct(other);
    candidates.col(2 * b + 2) = values.col(a).cwiseMin(other);
  }
  gemm(Op::transposed, Op::plain, residual.cols(), candidates.cols(), poses, residual.data(), poses, candidates.data(),
       poses, 0, products.data(), residual.cols());
  const auto score = [&](Eigen::Index column) {
    if ((candidates.col(column).array() > 1e-3f).count() < poses_per_corrective) return 0.0f;
    return products.col(column).squaredNorm() / candidates.col(column).squaredNorm();
  };
  std::vector<Candidate> found = {{middle_hat(ramps[a]), score(0)}};
  for (Eigen::Index b = 0; b < later; ++b) {
    Feature feature{Feature::Kind::product};
    feature.first = static_cast<std::uint32_t>(a);
    feature.second = static_cast<std::uint32_t>(a + 1 + b);
    const float product = score(2 * b + 1), minimum = score(2 * b + 2);
    if (ramps[feature.first].control == ramps[feature.second].control)
      continue;  // two sides of one control are never active together
    if (minimum > product) feature.kind = Feature::Kind::minimum;
    found.push_back({feature, std::max(product, minimum)});
  }
  return found;
}

bool same(const Feature& a, const Feature& b) {
  return a.kind == b.kind && a.control == b.control && a.scale == b.scale && a.first == b.first && a.second == b.second;
}

// The `count` new features with the highest scores.
std::vector<Feature> select_features(const std::vector<Feature>& ramps, const Matrix& values, const Matrix& residual,
                                     const std::vector<Feature>& taken, std::size_t count, const Parallel& parallel) {
  std::vector<std::vector<Candidate>> by_ramp(ramps.size());
  parallel_for(parallel, ramps.size(),
               [&](std::size_t a, std::size_t) { by_ramp[a] = score_candidates(a, ramps, values, residual); });
  std::vector<Candidate> all;
  for (const std::vector<Candidate>& ramp_candidates : by_ramp)
    for (const Candidate& candidate : ramp_candidates)
      if (candidate.score > 0 && std::none_of(taken.begin(), taken.end(),
                                              [&](const Feature& feature) { return same(feature, candidate.feature); }))
        all.push_back(candidate);
  std::stable_sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  std::vector<Feature> chosen;
  for (std::size_t i = 0; i < std::min(count, all.size()); ++i) chosen.push_back(all[i].feature);
  return chosen;
}

// Ridge regression: shapes (features x components) for feature values and target coefficients.
Matrix fit_shapes(const Matrix& features, const Matrix& targets) {
  Matrix inner = features.transpose() * features;
  inner.diagonal().array() += ridge * std::max(inner.trace() / static_cast<float>(inner.rows()), 1e-12f);
  return inner.ldlt().solve(features.transpose() * targets);
}

// The rows of the validation poses, or of the training poses.
Matrix rows_of(const Matrix& all, bool validation) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < all.rows(); ++i)
    if ((i % validation_stride == validation_stride - 1) == validation) rows.push_back(i);
  return all(rows, Eigen::seqN(0, all.cols()));
}

bool is_zero(const PoseRows& rows, const Parallel& parallel) {
  const std::unique_ptr<PoseRows> sample = rows.subsampled(64);
  std::vector<float> values(sample->size() * sample->rows());
  sample->read(0, sample->size(), values, parallel);
  return std::all_of(values.begin(), values.end(), [](float value) { return value == 0; });
}

// The values of the ramps in poses: poses x ramps.
Matrix ramp_values(const PoseSet& poses, const std::vector<Feature>& ramps) {
  const std::vector<float> controls = poses.controls(), rest = poses.source().schema().rest_pose();
  Matrix by_pose(ramps.size(), poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i)
    evaluate_features(ramps, std::span(controls).subspan(i * rest.size(), rest.size()), rest,
                      std::span(by_pose.col(static_cast<Eigen::Index>(i)).data(), ramps.size()));
  return by_pose.transpose();
}

// Values of ramps, and targets: coefficients of the residual's principal components.
struct Samples {
  Matrix ramps, targets;
};

// Matching pursuit of up to max_count features, with early stopping on the validation poses.
std::vector<Feature> pursue_features(const Samples& samples, const std::vector<Feature>& ramps, std::size_t max_count,
                                     std::uint32_t rounds, const Parallel& parallel, Progress& progress) {
  const Samples train{rows_of(samples.ramps, false), rows_of(samples.targets, false)};
  const Samples validation{rows_of(samples.ramps, true), rows_of(samples.targets, true)};
  std::vector<Eigen::Index> scored(std::min(scored_poses, train.ramps.rows()));
  for (std::size_t i = 0; i < scored.size(); ++i)
    scored[i] = static_cast<Eigen::Index>(i) * train.ramps.rows() / static_cast<Eigen::Index>(scored.size());

  std::vector<Feature> selected, best;
  Matrix train_features(train.ramps.rows(), 0), validation_features(validation.ramps.rows(), 0);
  Matrix residual = train.targets;
  double least_error = validation.targets.squaredNorm();
  progress.begin(Phase::analysis, "choosing correctives", rounds);
  for (std::uint32_t round = 0; round < rounds; ++round) {
    const std::size_t wanted = max_count * (round + 1) / rounds - selected.size();
    const std::vector<Feature> added = select_features(
        ramps, train.ramps(scored, Eigen::seqN(0, train.ramps.cols())),
        residual(scored, Eigen::seqN(0, std::min(scored_components, residual.cols()))), selected, wanted, parallel);
    if (added.empty()) break;
    const Eigen::Index before = train_features.cols(), after = before + static_cast<Eigen::Index>(added.size());
    train_features.conservativeResize(Eigen::NoChange, after);
    validation_features.conservativeResize(Eigen::NoChange, after);
    for (std::size_t i = 0; i < added.size(); ++i) {
      train_features.col(before + i) = value_of(added[i], ramps, train.ramps);
      validation_features.col(before + i) = value_of(added[i], ramps, validation.ramps);
    }
    selected.insert(selected.end(), added.begin(), added.end());
    const Matrix shapes = fit_shapes(train_features, train.targets);
    residual = train.targets - train_features * shapes;
    const double error = (validation.targets - validation_features * shapes).squaredNorm();
    progress.step(round + 1);
    if (error >= least_error) break;
    least_error = error;
    best = selected;
  }
  return best;
}

}  // namespace

PoseCorrectives find_correctives(const PoseRows& residual, const std::vector<Feature>& ramps,
                                 const CorrectiveOptions& options, const Parallel& parallel, Progress& progress) {
  const std::unique_ptr<PoseRows> sample = residual.subsampled(options.poses);
  const auto poses = static_cast<Eigen::Index>(sample->size());
  const std::size_t max_count =
      std::min(options.max_count, static_cast<std::size_t>((poses - poses / validation_stride) / poses_per_corrective));
  if (max_count == 0 || ramps.empty() || is_zero(*sample, parallel)) return {};
  const PrincipalComponents pca = principal_components(*sample, target_variance, parallel, progress);
  const Samples samples{ramp_values(sample->poses(), ramps),
                        Eigen::Map<const Matrix>(pca.coefficients.data(), pca.count, poses).transpose()};
  const std::vector<Feature> selected = pursue_features(samples, ramps, max_count, options.rounds, parallel, progress);
  if (selected.empty()) return {};

  Matrix features(poses, selected.size());
  for (std::size_t i = 0; i < selected.size(); ++i) features.col(i) = value_of(selected[i], ramps, samples.ramps);
  const Matrix shapes = fit_shapes(features, samples.targets).transpose();  // components x features
  PoseCorrectives result{selected, std::vector<float>(selected.size() * pca.rows)};
  gemm(Op::plain, Op::plain, pca.rows, selected.size(), pca.count, pca.components.data(), pca.rows, shapes.data(),
       pca.count, 0, result.shapes.data(), pca.rows);
  return result;
}

}  // namespace fb::bake
