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
#include "base/keep_asking.h"
#include "base/random_streams.h"

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

PoseSet validation_poses(const TrainingPoses& training) {
  return (training.split.validation.empty() ? training.all : training.held_back()).subsampled(measured_poses);
}

// What every pose reads, whatever the precision: a number for each control, feature, list entry and vertex.
std::uint64_t constant_bytes(const PackedModel& packed) {
  return BytesReadCounter(packed).of_pose(packed.schema.rest_pose());
}

// Mean number of bytes that a frame of the clip reads beside constant_bytes.
double mean_bytes_read(const PackedModel& packed, const Clip& clip) {
  const BytesReadCounter counter(packed);
  const std::size_t width = packed.schema.control_count();
  double sum = 0;
  for (std::size_t frame = 0; frame < clip.frames; ++frame)
    sum += static_cast<double>(counter.of_pose(std::span(clip.controls).subspan(frame * width, width)));
  return sum / static_cast<double>(clip.frames) - static_cast<double>(constant_bytes(packed));
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

// What poses of some shots may read on average, by the recipe; 0: any number of bytes.
struct PoseBound {
  const Clip& shots;
  double max_bytes_read;

  bool kept_by(const PackedModel& packed) const {
    return max_bytes_read <= 0 || mean_bytes_read(packed, shots) <= max_bytes_read;
  }
};

struct BoundedResult {
  RecipeResult result;
  double factor = 1;
};

// The result for the smallest factor found with which poses keep to the bound: doubled until they do, then bisected.
// That of the largest factor where none does. make(factor): a packed result.
template <class Make>
BoundedResult fit_bound(const PoseBound& bound, const Make& make) {
  const auto fits = [&](const RecipeResult& result) { return bound.kept_by(*result.packed); };
  BoundedResult best{make(1)};
  double too_small = 1;
  while (!fits(best.result)) {
    if (best.factor >= largest_factor) return best;
    too_small = best.factor;
    best = {make(2 * too_small), 2 * too_small};
  }
  for (int step = 0; step < bisections && best.factor > too_small; ++step) {
    const double middle = std::sqrt(too_small * best.factor);
    RecipeResult other = make(middle);
    if (fits(other))
      best = {std::move(other), middle};
    else
      too_small = middle;
  }
  return best;
}

std::string unmet_text(const PoseBound& bound, const PackedModel& least) {
  return format(
      "poses of this face cannot keep to the %.3g MB that the recipe lets them read: the least reached is %.3g MB, "
      "with the recipe's precision divided by %g; it keeps its precision instead",
      bound.max_bytes_read / 1e6, mean_bytes_read(least, bound.shots) / 1e6, largest_factor);
}

// The precision of fit_bound, told where it is not the recipe's own.
std::string lowered_text(const PoseBound& bound, const BoundedResult& fitted) {
  const PackedModel& packed = *fitted.result.packed;
  return format(
      "the recipe's precision is divided by %.3g: frames of synthetic shots then read %.3g MB on average, besides the "
      "%.3g MB that every pose reads; the recipe allows for %.3g MB",
      fitted.factor, mean_bytes_read(packed, bound.shots) / 1e6, double(constant_bytes(packed)) / 1e6,
      bound.max_bytes_read / 1e6);
}

// Keeps to the bound. One that cannot be met is a warning, and does not count: a face of a lower precision that does
// not meet it either is good for nothing.
template <class Make>
RecipeResult bounded_result(PoseBound bound, Progress& progress, const Make& make) {
  BoundedResult fitted = fit_bound(bound, make);
  if (!bound.kept_by(*fitted.result.packed)) {
    std::string warning = unmet_text(bound, *fitted.result.packed);
    bound.max_bytes_read = 0;
    fitted = fit_bound(bound, make);
    fitted.result.warnings.push_back(std::move(warning));
  }
  if (fitted.factor > 1) {
    fitted.result.stats.notes.push_back(lowered_text(bound, fitted));
    progress.note(fitted.result.stats.notes.back());
  }
  return std::move(fitted.result);
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

Clip bounded_shots(const RigSchema& schema, std::uint64_t seed) {
  return make_test_poses(schema, seed_of(seed, Stream::bounding_shots)).back();
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
                         const BlockwisePcaOptions& pca_options, const PackOptions& packing,
                         const TrainingPoses& training, const BakeOptions& options, Progress& progress,
                         double max_bytes_read) {
  const std::vector<float> sizes = direct_sizes(model, without_shots(training.all));
  const auto samples = [&](const FaceModel& truncated) {
    return sampled_coefficients(truncated, training.all, without_asking(options.parallel));
  };
  if (options.max_bytes == 0 && options.max_error <= 0) {
    const BlockwisePca pca(model, covariance, pca_options.block_vertices, options.parallel, sizes);
    const Clip shots = bounded_shots(model.schema, options.seed);
    // The bytes that a pose reads are counted before the best rounding is looked for: it takes longest and does not
    // change them.
    const bool bounded = max_bytes_read > 0;
    const auto pack = [&](RecipeResult& result, bool rounded_well) {
      result.packing.rate_distortion = rounded_well;
      if (rounded_well) result.packing.samples = samples(result.model);
      result.packed = pack_model(result.model, result.packing, without_asking(options.parallel));
    };
    progress.begin(Phase::packing, "rounding", 0);
    RecipeResult result = bounded_result({shots, max_bytes_read}, progress, [&](double factor) {
      return ask_during(progress, [&] {
        RecipeResult made = with_factor(pca, pca_options.threshold, packing, factor);
        pack(made, !bounded);
        return made;
      });
    });
    if (bounded) keep_asking(progress, [&] { pack(result, true); });
    return result;
  }
  const PoseSet validation = validation_poses(training);
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
  RecipeResult result{std::move(fitted.model), std::move(fitted.packing), {}, {}, std::move(fitted.packed)};
  if (!fitted.unmet.empty()) result.warnings.push_back(std::move(fitted.unmet));
  return result;
}

}  // namespace fb::bake
