// How precisely a face is kept, chosen by what is asked of it: so many bytes, or so large an error.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "bake/compress/blockwise_pca.h"
#include "bake/compress/pack_model.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb::bake {

struct FitTarget {
  std::uint64_t max_bytes = 0;  // of the archive; 0: not asked
  double max_error = 0;         // largest distance of a vertex, over D; 0: not asked
  bool force = false;           // where a target cannot be met, the nearest there is instead of a failure
};

// One scale for what the basis may lose by localizing, rounding and dropping, and the bits of weights.
struct Precision {
  double scale = 1e-5;  // over D: BlockwisePcaOptions::threshold and PackOptions::step, the others follow from it
  int weight_bits = 8;

  PackOptions pack() const;
};

struct FitChoice {
  Precision precision;
  std::uint64_t bytes = 0;
  double error = 0;
};

// Bisects a ladder of scales for weights of 8 and of 16 bits, taking bytes to fall and the error to grow along it:
// within max_bytes the least error, or if max_error is asked the fewest bytes whose error is not larger. What cannot be
// had is approached: the fewest bytes there are, or the fewest with the error within 1 % of the least; max_bytes comes
// first. Calls `error` 12 times at most for different precisions, and only twice if max_error is not asked. Fails with
// invalid_argument if nothing is asked.
FitChoice choose_precision(const FitTarget& target, const std::function<std::uint64_t(const Precision&)>& bytes,
                           const std::function<double(const Precision&)>& error);

// pack_model(model, packing) is what was measured.
struct Fitted {
  FaceModel model;
  PackOptions packing;
  FitChoice choice;
};

// Localizes a model and packs it as precisely as the target asks. `covariance` and `direct_sizes`: see
// BlockwisePca. `error` measures a candidate on validation poses, `bytes` gives its archive's size. Notes what was
// reached. A target that cannot be met is a failure with limit, which names what can be and its cost, or, with
// FitTarget::force, a note.
Fitted fit_target(const FaceModel& model, std::span<const std::vector<float>> covariance, const FitTarget& target,
                  const std::function<double(const PackedModel&)>& error,
                  const std::function<std::uint64_t(const PackedModel&)>& bytes, const Parallel& parallel,
                  Progress& progress, std::span<const float> direct_sizes = {});

}  // namespace fb::bake
