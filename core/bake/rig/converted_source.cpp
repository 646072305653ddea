#include "bake/rig/converted_source.h"

#include <vector>

#include "bake/rig/converted_backend.h"

namespace fb::bake {

void ConvertedSource::read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) {
  std::vector<float> from(count * source().rest().points.size());
  source().read(clip, first, count, from);
  convert(frames_of(clips().at(clip), first, count, schema().control_count()), from, count, points);
}

void ConvertedSource::evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) {
  std::vector<float> from(count * source().rest().points.size());
  source().evaluate(controls, count, from);
  convert(controls, from, count, points);
}

std::unique_ptr<EvaluationBackend> ConvertedSource::make_backend(const Parallel& parallel) {
  const auto converted = [this](std::span<const float> controls, std::span<const float> from, std::size_t poses,
                                std::span<float> to) { convert(controls, from, poses, to); };
  return std::make_unique<ConvertedBackend>(source().make_backend(parallel), source().rest().points.size(), converted);
}

}  // namespace fb::bake
