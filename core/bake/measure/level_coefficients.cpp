#include "bake/measure/level_coefficients.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bake/measure/measured_face.h"

namespace fb::bake {
namespace {

constexpr std::size_t sized_poses = 500;

// Of a coefficient, over poses.
struct CoefficientSize {
  double square = 0;   // mean
  double largest = 0;  // magnitude
};

std::vector<CoefficientSize> coefficient_sizes(const PackedModel& model, const PoseSet& poses,
                                               const Parallel& parallel) {
  MeasuredFace face(model, worker_count(parallel));
  const std::size_t width = face.evaluator().control_count(), count = face.evaluator().coefficient_count();
  const PoseSet some = poses.subsampled(sized_poses);
  const std::vector<float> controls = some.controls();
  std::vector<float> values(some.size() * count);
  parallel_for(parallel, some.size(), [&](std::size_t pose, std::size_t worker) {
    std::ranges::copy(face.coefficients(&controls[pose * width], worker), &values[pose * count]);
  });
  std::vector<CoefficientSize> sizes(count);
  for (std::size_t i = 0; i < values.size(); ++i) {
    CoefficientSize& size = sizes[i % sizes.size()];
    size.square += double(values[i]) * values[i] / double(some.size());
    size.largest = std::max(size.largest, double(std::fabs(values[i])));
  }
  return sizes;
}

// What a coefficient moves at a level.
struct LevelMotion {
  double squares = 0;  // of distances, summed over vertices, mean over poses
  double largest = 0;  // distance
  bool in_level = false, in_channels = false;
};

std::vector<LevelMotion> level_motion(const PackedModel& model, const DetailLevel& level,
                                      const std::vector<CoefficientSize>& sizes) {
  std::vector<LevelMotion> motion(model.columns);
  for (const PackedRowBlock& block : model.row_blocks) {
    const bool channels = block.first_row >= 3 * model.rest.surface_vertex_count();
    if (!channels && block.first_row >= 3 * std::size_t(level.vertices)) continue;
    for (std::size_t c = 0; c < block.columns.size(); ++c) {
      const std::uint32_t column = block.columns[c].column;
      LevelMotion& of = motion[column];
      (channels ? of.in_channels : of.in_level) = true;
      if (channels) continue;
      const std::vector<float> values = displacements(block, c);
      double all = 0, most = 0, vertex = 0;
      for (std::size_t i = 0; i < values.size(); ++i) {
        const double square = double(values[i]) * values[i];
        all += square;
        vertex = (block.first_row + i) % 3 == 0 ? square : vertex + square;
        most = std::max(most, vertex);
      }
      of.squares += all * sizes[column].square;
      of.largest = std::max(of.largest, std::sqrt(most) * sizes[column].largest);
    }
  }
  return motion;
}

}  // namespace

void choose_level_coefficients(PackedModel& model, const PoseSet& poses, const Errors& whole,
                               const Parallel& parallel) {
  const std::vector<CoefficientSize> sizes = coefficient_sizes(model, poses, parallel);
  const double diagonal = model.rest.diagonal();
  const auto direct = static_cast<std::uint32_t>(model.direct.size());
  for (std::size_t k = 1; k <= model.levels.size(); ++k) {
    DetailLevel& level = model.levels[k - 1];
    const std::vector<LevelMotion> motion = level_motion(model, level, sizes);
    const double rms = (std::ldexp(1, static_cast<int>(k)) - 1) * whole.rms * diagonal,
                 largest = double(k) / 2 * whole.max * diagonal;
    double left = rms * rms * level.vertices;
    std::vector<std::uint32_t> order(model.columns - direct);
    std::iota(order.begin(), order.end(), direct);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return motion[a].squares < motion[b].squares; });
    if (k > 1) level.used_coefficients = model.levels[k - 2].used_coefficients;
    for (const std::uint32_t column : order) {
      const LevelMotion& of = motion[column];
      std::uint8_t& used = level.used_coefficients[column - direct];
      if (!of.in_level || of.in_channels) continue;
      if (used && (of.largest > largest || of.squares > left)) continue;
      used = 0;
      left -= of.squares;
    }
  }
}

}  // namespace fb::bake
