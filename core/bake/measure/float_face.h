#pragma once

#include <span>
#include <vector>

#include "model/face_model.h"

namespace fb::bake {

// Reference evaluation of a float model, with sums in double: quantisation is measured against it, and it checks the
// runtime, with which it shares only features and activations.
class FloatFace {
 public:
  // Checks the model, which must outlive the face.
  explicit FloatFace(const FaceModel& model);

  // One pose (control_count values, clamped to their ranges) as 3 x vertices positions. Thread-safe.
  std::vector<double> evaluate(std::span<const float> controls) const;

  // The coefficients of the basis' columns in that pose. Thread-safe.
  std::vector<double> coefficients(std::span<const float> controls) const;

 private:
  std::vector<double> run(const Region& region, std::span<const float> features) const;

  const FaceModel& model_;
  std::vector<float> rest_controls_;
  std::vector<std::vector<double>> at_rest_;  // outputs of each region at rest
};

}  // namespace fb::bake
