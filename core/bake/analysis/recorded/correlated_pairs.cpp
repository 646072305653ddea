#include "bake/analysis/recorded/recorded_poses.h"

#include <Eigen/Dense>
#include <algorithm>

#include "bake/linalg/gemm.h"
#include "base/random_streams.h"

namespace fb::bake {
namespace {

constexpr std::size_t sketch_width = 48;  // numbers a pose that its residual is projected to
constexpr std::size_t rounds = 4;
constexpr Eigen::Index fewest_poses = 8;  // with both controls active, for a pair to be considered

std::vector<float> draw_projection(std::size_t size, std::uint64_t seed) {
  std::vector<float> projection(size * sketch_width);
  for (std::size_t i = 0; i < size; ++i) {
    Random random = open_stream(seed, Stream::pair_projection, i);
    for (std::size_t k = 0; k < sketch_width; ++k) projection[k * size + i] = random.normal();
  }
  return projection;
}

// Projected residuals: poses x sketch_width.
Eigen::MatrixXf sketch_poses(const RecordedPoses& recorded, std::uint64_t seed, const Parallel& parallel,
                             Progress& progress) {
  const std::size_t size = recorded.poses->source().rest().points.size(), count = recorded.picked.size();
  const std::vector<float> projection = draw_projection(size, seed);
  Eigen::MatrixXf sketch(static_cast<Eigen::Index>(count), static_cast<Eigen::Index>(sketch_width));
  std::vector<float> residuals, flat;
  progress.begin(Phase::analysis, "finding pairs in recorded poses", count);
  for (std::size_t first = 0; first < count; first += recorded_poses_in_memory) {
    const std::size_t poses = std::min(recorded_poses_in_memory, count - first);
    residuals.resize(poses * size);
    flat.resize(poses * sketch_width);
    recorded.read(first, poses, residuals, parallel);
    gemm(Op::transposed, Op::plain, poses, sketch_width, size, residuals.data(), size, projection.data(), size, 0,
         flat.data(), poses);
    sketch.middleRows(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(poses)) =
        Eigen::Map<const Eigen::MatrixXf>(flat.data(), static_cast<Eigen::Index>(poses), sketch.cols());
    progress.step(first + poses);
  }
  return sketch;
}

// Values of every control's factor: poses x controls.
Eigen::MatrixXf values_of(const RecordedPoses& recorded, std::span<const Feature> features) {
  Eigen::MatrixXf table(static_cast<Eigen::Index>(recorded.picked.size()), static_cast<Eigen::Index>(features.size()));
  std::vector<float> values(features.size());
  for (std::size_t i = 0; i < recorded.picked.size(); ++i) {
    evaluate_features(features, recorded.pose(i), recorded.rest, values);
    for (std::size_t c = 0; c < values.size(); ++c)
      table(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) = values[c];
  }
  return table;
}

// Adds the `wanted` pairs whose product explains most of the sketch, and their normalised products as columns.
void add_pairs(const Eigen::MatrixXf& single, const Eigen::MatrixXf& sketch, std::size_t wanted,
               std::vector<ControlPair>& chosen, Eigen::MatrixXf& columns, const Parallel& parallel) {
  const auto width = static_cast<std::uint32_t>(single.cols());
  struct Gain {
    float share;
    std::uint32_t a, b;
  };
  std::vector<std::vector<Gain>> of_control(width);
  const float energy = sketch.squaredNorm();
  parallel_for(parallel, width, [&](std::size_t a, std::size_t) {
    const auto first = static_cast<Eigen::Index>(a);
    const Eigen::Index others = static_cast<Eigen::Index>(width) - first - 1;
    if (others == 0 || energy == 0) return;
    const Eigen::MatrixXf products = single.rightCols(others).array().colwise() * single.col(first).array();
    const Eigen::MatrixXf along = products.transpose() * sketch;
    for (Eigen::Index k = 0; k < others; ++k) {
      const float length = products.col(k).squaredNorm();
      if ((products.col(k).array() != 0).count() < fewest_poses) continue;
      of_control[a].push_back({along.row(k).squaredNorm() / length / energy, static_cast<std::uint32_t>(a),
                               static_cast<std::uint32_t>(first + 1 + k)});
    }
  });
  std::vector<Gain> gains;
  for (const std::vector<Gain>& some : of_control) gains.insert(gains.end(), some.begin(), some.end());
  std::stable_sort(gains.begin(), gains.end(), [](const Gain& a, const Gain& b) { return a.share > b.share; });
  // An unrelated product explains one of as many directions as there are poses.
  const float chance = 4 / static_cast<float>(sketch.rows());
  for (const Gain& gain : gains) {
    if (wanted == 0 || gain.share < chance) break;
    const ControlPair pair(gain.a, gain.b);
    if (std::find(chosen.begin(), chosen.end(), pair) != chosen.end()) continue;
    chosen.push_back(pair);
    columns.conservativeResize(Eigen::NoChange, columns.cols() + 1);
    columns.rightCols(1) = single.col(gain.a).cwiseProduct(single.col(gain.b)).normalized();
    --wanted;
  }
}

}  // namespace

std::vector<ControlPair> correlated_pairs(const RecordedPoses& recorded, std::span<const Feature> features,
                                          std::size_t most, std::uint64_t seed, const Parallel& parallel,
                                          Progress& progress) {
  const Eigen::MatrixXf sketch = sketch_poses(recorded, seed, parallel, progress);
  const Eigen::MatrixXf single = values_of(recorded, features);
  std::vector<ControlPair> chosen;
  Eigen::MatrixXf unexplained = sketch, columns(sketch.rows(), 0);
  for (std::size_t round = 0; round < rounds && chosen.size() < most; ++round) {
    const std::size_t before = chosen.size();
    add_pairs(single, unexplained, std::min((most + rounds - 1) / rounds, most - before), chosen, columns, parallel);
    if (chosen.size() == before) break;
    // Columns have length 1; the small ridge keeps nearly equal columns from large opposite weights.
    const Eigen::MatrixXf gram =
        columns.transpose() * columns + 1e-3f * Eigen::MatrixXf::Identity(columns.cols(), columns.cols());
    unexplained = sketch - columns * gram.ldlt().solve(columns.transpose() * sketch);
  }
  return chosen;
}

}  // namespace fb::bake
