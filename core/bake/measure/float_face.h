#pragma once

#include <span>
#include <vector>

#include "model/face_model.h"

namespace fb::bake {

// A face of floats posed in the plainest way and summed in double: what packing is measured against, and the check of
// the runtime that shares none of its arithmetic but features and activations.
class FloatFace {
 public:
  // Checks the model, which must outlive the face.
  explicit FloatFace(const FaceModel& model);

  // One pose (control_count values, clamped to their ranges) as 3 x vertices positions. Thread-safe.
  std::vector<double> evaluate(std::span<const float> controls) const;

  // The weights of the basis' columns in that pose. Thread-safe.
  std::vector<double> coefficients(std::span<const float> controls) const;

 private:
  std::vector<double> run(const Region& region, std::span<const float> features) const;

  const FaceModel& model_;
  std::vector<float> rest_controls_;
  std::vector<std::vector<double>> at_rest_;  // what each region's last layer gives there
};

}  // namespace fb::bake
