#include "bake/measure/error_regions.h"

#include <algorithm>
#include <cmath>

#include "bake/measure/face_parts.h"
#include "bake/regions/weighted_kmeans.h"
#include "base/random_streams.h"

namespace fb::bake {
namespace {

constexpr std::size_t most_clusters = 7;
constexpr float still_block = 2e-3f;  // over D: row blocks that no control moves further, as a root mean square

// Rows of `motions` scaled to length 1.
void scale_to_length_one(std::span<float> row) {
  double squares = 0;
  for (const float value : row) squares += double(value) * value;
  if (squares == 0) return;
  for (float& value : row) value = static_cast<float>(value / std::sqrt(squares));
}

}  // namespace

ErrorRegions error_regions(const PackedModel& model, const FaceMap& map, std::uint64_t seed) {
  const std::size_t vertices = model.rest.surface_vertex_count(), controls = model.schema.control_count();
  const auto source_vertex = [&](std::size_t baked) { return model.order.empty() ? baked : model.order[baked]; };
  // By vertex in baked order: the row block of its first row.
  std::vector<std::size_t> block_of(vertices);
  for (std::size_t b = 0; b < model.row_blocks.size(); ++b)
    for (std::uint32_t row = model.row_blocks[b].first_row; row < 3 * vertices; ++row) {
      if (row >= model.row_blocks[b].first_row + model.row_blocks[b].row_count) break;
      if (row % 3 == 0) block_of[row / 3] = b;
    }
  std::vector<float> motions(model.row_blocks.size() * controls);
  std::vector<double> counts(model.row_blocks.size());
  for (std::size_t i = 0; i < vertices; ++i) {
    float* const row = &motions[block_of[i] * controls];
    for (std::size_t c = 0; c < controls; ++c)
      row[c] += map.motion(c, source_vertex(i)) * map.motion(c, source_vertex(i));
    ++counts[block_of[i]];
  }

  std::vector<std::size_t> moving;  // row blocks
  std::vector<float> points;
  std::vector<double> weights;
  for (std::size_t b = 0; b < counts.size(); ++b) {
    const auto row = std::span(motions).subspan(b * controls, controls);
    for (float& value : row) value = std::sqrt(value / static_cast<float>(std::max(counts[b], 1.0)));
    if (*std::max_element(row.begin(), row.end()) < still_block) continue;
    scale_to_length_one(row);
    moving.push_back(b);
    points.insert(points.end(), row.begin(), row.end());
    weights.push_back(counts[b]);
  }
  const std::vector<std::uint32_t> clusters =
      moving.empty() ? std::vector<std::uint32_t>()
                     : weighted_kmeans(points, controls, weights,
                                       {.clusters = most_clusters, .seed = seed_of(seed, Stream::error_regions)});
  const std::uint32_t none = clusters.empty() ? 0 : *std::max_element(clusters.begin(), clusters.end()) + 1;
  std::vector<std::uint32_t> of_block(counts.size(), none);
  for (std::size_t i = 0; i < moving.size(); ++i) of_block[moving[i]] = clusters[i];

  // Numbered as they come, so that each has vertices.
  ErrorRegions regions;
  regions.of_vertex.resize(vertices);
  std::vector<std::uint32_t> number(none + 1, none + 1);
  for (std::size_t i = 0; i < vertices; ++i) {
    std::uint32_t& region = number[of_block[block_of[i]]];
    if (region == none + 1) {
      region = static_cast<std::uint32_t>(regions.sizes.size());
      regions.sizes.push_back(0);
    }
    regions.of_vertex[source_vertex(i)] = region;
    ++regions.sizes[region];
    if (regions.runs.empty() || regions.runs.back().region != region) regions.runs.push_back({0, region});
    ++regions.runs.back().vertices;
  }
  FaceParts parts{std::vector<std::string>(regions.sizes.size()), regions.of_vertex};
  describe(parts, map, model.schema);
  regions.names = std::move(parts.titles);
  return regions;
}

}  // namespace fb::bake
