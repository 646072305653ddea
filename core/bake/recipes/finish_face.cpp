#include "bake/recipes/finish_face.h"

#include <algorithm>
#include <utility>

#include "archive/writer.h"
#include "bake/measure/evaluate.h"
#include "bake/measure/verify.h"
#include "bake/quantize/fit_target.h"
#include "bake/sampling/validation_split.h"

namespace fb {
namespace {

constexpr double validation_share = 0.05;
constexpr std::size_t measured_poses = 500;
constexpr std::uint64_t room = 1024;  // for the provenance, which is written last

PoseSet measured(const PoseSet& poses, std::uint64_t seed) {
  const ValidationSplit split = validation_split(poses, validation_share, seed);
  return (split.validation.empty() ? poses : poses.picked(split.validation)).thinned(measured_poses);
}

}  // namespace

bool asks_target(const BakeOptions& options) {
  return options.max_bytes > 0 || options.max_error > 0;
}

Learnt finish_face(const FaceModel& model, std::span<const std::vector<float>> covariance,
                   const LocalizeOptions& localize, const PackOptions& packing, const PoseSet& poses,
                   const BakeOptions& options, Progress& progress) {
  if (!asks_target(options)) {
    LocalizedModel local = localize_basis(model, covariance, localize, options.parallel);
    Learnt learnt{std::move(local.model), packing};
    learnt.packing.coefficient_sizes = std::move(local.coefficient_sizes);
    return learnt;
  }
  const PoseSet validation = measured(poses, options.seed);
  const auto bytes = [&](const PackedModel& packed) {
    return write_archive(packed, make_proof(packed, options.seed)).size() + room;
  };
  const auto error = [&](const PackedModel& packed) {
    return evaluate_archive_on(write_archive(packed, {}), validation, options.parallel, silent_progress()).max;
  };
  Fitted fitted =
      fit_target(model, covariance, {options.max_bytes, options.max_error}, error, bytes, options.parallel, progress);
  return {std::move(fitted.model), std::move(fitted.packing)};
}

}  // namespace fb
