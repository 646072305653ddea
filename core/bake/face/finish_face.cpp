#include "bake/face/finish_face.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "archive/writer.h"
#include "bake/analysis/sparse_blendshapes.h"
#include "bake/compress/fit_target.h"
#include "bake/measure/bytes_read.h"
#include "bake/measure/evaluate.h"
#include "bake/measure/float_face.h"
#include "bake/measure/verify.h"
#include "bake/sampling/sampling.h"
#include "bake/sampling/validation_split.h"
#include "base/keep_asking.h"

namespace fb::bake {
namespace {

constexpr std::size_t measured_poses = 500, size_poses = 2000;
constexpr std::uint64_t text_bytes = 4096;  // of provenance and certificate, which are written last

// Of the section of expected errors, which is written after them: a byte a weight, and bits of pairs that pack to half.
std::uint64_t error_bytes(std::size_t controls) {
  return 1024 + 10 * controls + controls * controls / 32;
}
constexpr double largest_factor = 64;  // of thresholds and steps, to keep within the bytes read per pose
constexpr int bisections = 5;          // of the factor: to 2 % between neighbouring powers of 2

PoseSet validation_poses(const PoseSet& poses, std::uint64_t seed) {
  const ValidationSplit split = held_back(poses, seed);
  return (split.validation.empty() ? poses : poses.picked(split.validation)).subsampled(measured_poses);
}

// Mean number of bytes that a frame of the clip reads.
double mean_bytes_read(const PackedModel& packed, const Clip& clip) {
  const BytesReadCounter counter(packed);
  const std::size_t width = packed.schema.control_count();
  double sum = 0;
  for (std::size_t frame = 0; frame < clip.frames; ++frame)
    sum += static_cast<double>(counter.of_pose(std::span(clip.controls).subspan(frame * width, width)));
  return sum / static_cast<double>(clip.frames);
}

// The model with threshold, tolerance and steps multiplied by `factor`.
RecipeResult with_factor(const BlockwisePca& pca, double threshold, const PackOptions& packing, double factor) {
  BlockwiseModel blockwise = pca.truncated(factor * threshold);
  RecipeResult result{std::move(blockwise.model), packing};
  result.packing.coefficient_sizes = std::move(blockwise.coefficient_sizes);
  result.packing.basis_tolerance *= factor;
  result.packing.drop *= factor;
  result.packing.step *= factor;
  return result;
}

// The smallest factor found with which `shots` read at most max_bytes_read per pose: doubled until they do, then
// bisected.
RecipeResult fit_bytes_read(const BlockwisePca& pca, double threshold, const PackOptions& packing, const Clip& shots,
                            double max_bytes_read, Progress& progress) {
  const auto make = [&](double factor) {
    return ask_during(progress, [&] {
      RecipeResult result = with_factor(pca, threshold, packing, factor);
      result.packed = pack_model(result.model, result.packing);
      return result;
    });
  };
  const auto fits = [&](const RecipeResult& result) {
    return mean_bytes_read(*result.packed, shots) <= max_bytes_read;
  };
  RecipeResult best = make(1);
  double too_small = 1, fitting = 1;
  while (!fits(best) && fitting < largest_factor) {
    too_small = fitting;
    fitting *= 2;
    best = make(fitting);
  }
  for (int step = 0; step < bisections && fitting > too_small; ++step) {
    const double middle = std::sqrt(too_small * fitting);
    RecipeResult other = make(middle);
    const bool enough = fits(other);
    (enough ? fitting : too_small) = middle;
    if (enough) best = std::move(other);
  }
  return best;
}

// The materials that meshes name are not there yet: their bytes are reserved, as those of all that is not learnt.
PackedModel without_materials(PackedModel face) {
  for (MeshPart& part : face.rest.parts)
    for (MaterialRun& run : part.materials) run.material = no_material;
  return face;
}

}  // namespace

PoseSet without_shots(const PoseSet& poses) {
  PoseSet others = training_poses(poses.source(), Use::variant);
  return others.size() > 0 ? others : poses;
}

std::vector<float> direct_sizes(const FaceModel& model, const PoseSet& poses) {
  const std::vector<FeatureUsage> uses =
      feature_usage(model.network.features, model.schema, poses.subsampled(size_poses).controls());
  std::vector<float> sizes;
  for (const std::uint32_t f : model.network.direct)
    sizes.push_back(uses[f].active > 0 ? static_cast<float>(std::sqrt(uses[f].square / uses[f].active)) : 1);
  return sizes;
}

std::vector<float> sampled_coefficients(const FaceModel& model, const PoseSet& poses, const Parallel& parallel) {
  constexpr std::size_t sampled_poses = 1500;
  const FloatFace face(model);
  const PoseSet some = poses.subsampled(sampled_poses);
  const std::vector<float> controls = some.controls();
  const std::size_t width = model.schema.control_count(), columns = model.basis.columns;
  std::vector<float> samples(some.size() * columns);
  parallel_for(parallel, some.size(), [&](std::size_t pose, std::size_t) {
    const std::vector<double> of_pose = face.coefficients(std::span(controls).subspan(pose * width, width));
    std::copy(of_pose.begin(), of_pose.end(), samples.begin() + static_cast<std::ptrdiff_t>(pose * columns));
  });
  return samples;
}

RecipeResult finish_face(const FaceModel& model, std::span<const std::vector<float>> covariance,
                         const BlockwisePcaOptions& pca_options, const PackOptions& packing, const PoseSet& poses,
                         const BakeOptions& options, Progress& progress, double max_bytes_read) {
  const std::vector<float> sizes = direct_sizes(model, without_shots(poses));
  const auto samples = [&](const FaceModel& truncated) {
    return sampled_coefficients(truncated, poses, without_asking(options.parallel));
  };
  if (!has_target(options)) {
    const BlockwisePca pca(model, covariance, pca_options.block_vertices, options.parallel, sizes);
    RecipeResult result;
    if (max_bytes_read <= 0) {
      result = with_factor(pca, pca_options.threshold, packing, 1);
    } else {
      const Clip shots = make_test_poses(model.schema, options.seed + 1).back();
      result = fit_bytes_read(pca, pca_options.threshold, packing, shots, max_bytes_read, progress);
    }
    progress.begin("rounding", 0);
    result.packed = ask_during(progress, [&] {
      result.packing.samples = samples(result.model);
      return pack_model(result.model, result.packing, without_asking(options.parallel));
    });
    return result;
  }
  const PoseSet validation = validation_poses(poses, options.seed);
  const auto bytes = [&](const PackedModel& packed) {
    return ask_during(progress, [&] {
      PackedModel whole = without_materials(packed);
      if (options.complete) options.complete(whole);
      return archive::write_archive(whole, make_proof(whole, options.seed)).size() + text_bytes +
             options.reserved_bytes + error_bytes(packed.schema.control_count());
    });
  };
  const auto error = [&](const PackedModel& packed) {
    return evaluate_model_on(packed, validation, options.parallel, silent_progress()).max;
  };
  Fitted fitted =
      fit_target(model, {covariance, sizes, samples, options.normal_weight},
                 {options.max_bytes, options.max_error, options.force}, error, bytes, options.parallel, progress);
  return {std::move(fitted.model), std::move(fitted.packing), {}, {}, std::move(fitted.packed)};
}

}  // namespace fb::bake
