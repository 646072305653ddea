#include "bake/face/finish_face.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "archive/writer.h"
#include "bake/analysis/sparse_blendshapes.h"
#include "bake/compress/fit_target.h"
#include "bake/measure/evaluate.h"
#include "bake/measure/touched_bytes.h"
#include "bake/measure/verify.h"
#include "bake/sampling/sampling.h"
#include "bake/sampling/validation_split.h"

namespace fb::bake {
namespace {

constexpr double validation_share = 0.05;
constexpr std::size_t measured_poses = 500, sized_poses = 2000;
constexpr std::uint64_t room = 4096;  // for provenance and certificate, which are written last

PoseSet measured(const PoseSet& poses, std::uint64_t seed) {
  const ValidationSplit split = validation_split(poses, validation_share, seed);
  return (split.validation.empty() ? poses : poses.picked(split.validation)).subsampled(measured_poses);
}

constexpr double coarsest = 64;  // times what was asked for

// Root mean square of each direct coefficient over those poses where it is not 0: what a column is worth for each time
// that it is read. 1 where none of the poses tells.
std::vector<float> direct_sizes(const FaceModel& model, const PoseSet& poses) {
  const std::vector<FeatureUsage> uses = feature_usage(model.network.features, model.schema, poses.controls());
  std::vector<float> sizes;
  for (const std::uint32_t f : model.network.direct)
    sizes.push_back(uses[f].active > 0 ? static_cast<float>(std::sqrt(uses[f].square / uses[f].active)) : 1);
  return sizes;
}

// Bytes that a frame of the clip reads on average.
double mean_touched(const PackedModel& packed, const Clip& clip) {
  const ByteCount count(packed);
  const std::size_t width = packed.schema.control_count();
  double sum = 0;
  for (std::size_t frame = 0; frame < clip.frames; ++frame)
    sum += static_cast<double>(count.touched(std::span(clip.controls).subspan(frame * width, width)));
  return sum / static_cast<double>(clip.frames);
}

}  // namespace

PoseSet without_shots(const PoseSet& poses) {
  PoseSet others = training_poses(poses.source(), Use::variant);
  return others.size() > 0 ? others : poses;
}

bool asks_target(const BakeOptions& options) {
  return options.max_bytes > 0 || options.max_error > 0;
}

RecipeResult finish_face(const FaceModel& model, std::span<const std::vector<float>> covariance,
                         const BlockwisePcaOptions& localize, const PackOptions& packing, const PoseSet& poses,
                         const BakeOptions& options, Progress& progress, double touched_bytes) {
  const std::vector<float> sizes = direct_sizes(model, without_shots(poses).subsampled(sized_poses));
  if (!asks_target(options)) {
    const BlockwisePca pca(model, covariance, localize.block_vertices, options.parallel, sizes);
    const auto made = [&](double coarser) {
      BlockwiseModel local = pca.truncated(coarser * localize.threshold);
      RecipeResult result{std::move(local.model), packing};
      result.packing.coefficient_sizes = std::move(local.coefficient_sizes);
      result.packing.basis_tolerance *= coarser;
      result.packing.drop *= coarser;
      result.packing.step *= coarser;
      return result;
    };
    if (touched_bytes <= 0) return made(1);
    const Clip shots = make_test_poses(model.schema, options.seed + 1).back();
    const auto fits = [&](const RecipeResult& result) {
      return mean_touched(pack_model(result.model, result.packing), shots) <= touched_bytes;
    };
    // Doubled until it fits, then halved towards the finest that does.
    RecipeResult best = made(1);
    double finer = 1, coarser = 1;
    while (!fits(best) && coarser < coarsest) {
      finer = coarser;
      coarser *= 2;
      best = made(coarser);
    }
    for (int step = 0; step < 5 && coarser > finer; ++step) {
      const double middle = std::sqrt(finer * coarser);
      RecipeResult other = made(middle);
      const bool enough = fits(other);
      (enough ? coarser : finer) = middle;
      if (enough) best = std::move(other);
    }
    return best;
  }
  const PoseSet validation = measured(poses, options.seed);
  const auto bytes = [&](const PackedModel& packed) {
    return archive::write_archive(packed, make_proof(packed, options.seed)).size() + room;
  };
  const auto error = [&](const PackedModel& packed) {
    return evaluate_archive_on(archive::write_archive(packed, {}), validation, options.parallel, silent_progress()).max;
  };
  Fitted fitted = fit_target(model, covariance, {options.max_bytes, options.max_error, options.force}, error, bytes,
                             options.parallel, progress, sizes);
  return {std::move(fitted.model), std::move(fitted.packing)};
}

}  // namespace fb::bake
