#include "bake/measure/level_errors.h"

#include <algorithm>

#include "bake/measure/measured_face.h"

namespace fb::bake {
namespace {

constexpr std::size_t measured_frames = 500, frames_of_block = 16;

struct LevelSums {
  ErrorSums own, surface;
};

// The first `count` vertices in baked order.
std::vector<float> first_vertices(const PackedModel& model, std::span<const float> points, std::uint32_t count) {
  std::vector<float> first;
  for (std::uint32_t row = 0; row < 3 * count; ++row) first.push_back(points[model.coordinate(row)]);
  return first;
}

std::vector<LevelSums> sums_of(MeasuredFace& measured, std::size_t worker, const PackedModel& model,
                               const PoseSet& poses, std::size_t begin, std::size_t end) {
  const runtime::Evaluator& face = measured.evaluator();
  const std::size_t width = poses.source().rest().points.size(), surface = 3 * face.vertex_count();
  std::vector<float> truth((end - begin) * width), controls((end - begin) * face.control_count()), posed(surface);
  poses.read_points(begin, end - begin, truth);
  poses.read_controls(begin, end - begin, controls);
  std::vector<LevelSums> sums(model.levels.size());
  for (std::size_t i = 0; i < end - begin; ++i)
    for (std::size_t k = 1; k <= sums.size(); ++k) {
      runtime::Batch batch;
      batch.poses = 1;
      batch.controls = std::span(controls).subspan(i * face.control_count(), face.control_count());
      batch.positions = {posed.data(), posed.size()};
      batch.masks.lod = static_cast<float>(k);
      face.evaluate_batch(batch, {&measured.workspace(worker), 1});
      const auto exact = std::span(truth).subspan(i * width, surface);
      const std::uint32_t own = model.levels[k - 1].vertices;
      sums[k - 1].own.add_frame(first_vertices(model, posed, own), first_vertices(model, exact, own));
      sums[k - 1].surface.add_frame(posed, exact);
    }
  return sums;
}

}  // namespace

std::vector<LevelErrors> measure_levels(const PackedModel& model, const PoseSet& poses, const Parallel& parallel) {
  if (model.levels.empty()) return {};
  const PoseSet some = poses.subsampled(measured_frames);
  std::vector<std::vector<LevelSums>> blocks((some.size() + frames_of_block - 1) / frames_of_block);
  const Parallel workers = poses.readers(parallel);
  MeasuredFace face(model, worker_count(workers));
  parallel_for(workers, blocks.size(), [&](std::size_t b, std::size_t w) {
    blocks[b] = sums_of(face, w, model, some, b * frames_of_block, std::min((b + 1) * frames_of_block, some.size()));
  });
  std::vector<LevelErrors> errors;
  for (std::size_t k = 0; k < model.levels.size(); ++k) {
    LevelSums all;
    for (const std::vector<LevelSums>& block : blocks) {
      all.own.append(block[k].own);
      all.surface.append(block[k].surface);
    }
    const DetailLevel& level = model.levels[k];
    errors.push_back({level.vertices, level.polygon_sizes.size(), coefficients_of(model, level),
                      all.own.figures(model.rest.diagonal()), all.surface.figures(model.rest.diagonal())});
  }
  return errors;
}

}  // namespace fb::bake
