// Chooses the precision of a packed face for a target: a size in bytes, an error.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "bake/compress/blockwise_pca.h"
#include "bake/compress/pack_model.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb::bake {

struct FitTarget {
  std::uint64_t max_bytes = 0;  // of the archive; 0: any
  double max_error = 0;         // largest error of a vertex, over D; 0: any
  bool force = false;           // where a target cannot be met, the nearest there is instead of a failure
};

// One scale for truncation, quantisation and dropping of columns of the basis, and the bits of weights.
struct Precision {
  double scale = 1e-5;  // over D: BlockwisePcaOptions::threshold; the steps of PackOptions follow from it
  int weight_bits = 8;

  PackOptions pack() const;
};

struct FitChoice {
  Precision precision;
  std::uint64_t bytes = 0;
  double error = 0;
};

// Bisects a geometric ladder of scales for weights of 8 and of 16 bits, taking bytes to fall and the error to grow
// along it. Without max_error: the least error within max_bytes. With it: the fewest bytes with at most that error,
// within max_bytes if given. A target that cannot be met is approached: the coarsest there is, or the fewest bytes with
// an error within 1 % of the least; bytes come first. Calls `error` at most 12 times for different precisions, and only
// twice without max_error. Fails with invalid_argument without a target.
FitChoice choose_precision(const FitTarget& target, const std::function<std::uint64_t(const Precision&)>& bytes,
                           const std::function<double(const Precision&)>& error);

struct Fitted {
  FaceModel model;
  PackOptions packing;
  PackedModel packed;  // pack_model(model, packing), what was measured
  FitChoice choice;
  std::string unmet;  // what of the target was not met, with force; empty: nothing
};

// What else choosing a precision takes: see BlockwisePca and PackOptions.
struct FitInputs {
  std::span<const std::vector<float>> covariance;
  std::span<const float> direct_sizes = {};
  std::function<std::vector<float>(const FaceModel&)> samples = {};  // of a truncated model; empty: none
  double normal_weight = 0;
};

// Compresses a model by blockwise PCA and packs it in the precision of choose_precision. `error` measures a candidate
// on validation poses, `bytes` gives its archive's size. Notes what was reached. A target that cannot be met is a
// failure with limit, which names what can be and its cost, or, with FitTarget::force, Fitted::unmet.
Fitted fit_target(const FaceModel& model, const FitInputs& inputs, const FitTarget& target,
                  const std::function<double(const PackedModel&)>& error,
                  const std::function<std::uint64_t(const PackedModel&)>& bytes, const Parallel& parallel,
                  Progress& progress);

}  // namespace fb::bake
