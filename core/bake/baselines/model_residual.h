#pragma once

#include "bake/rig/pose_rows.h"
#include "model/face_model.h"

namespace fb::bake {

// The coefficients of a model without gates, computed in float, for poses (count x controls): count x columns.
std::vector<float> model_coefficients(const FaceModel& model, std::span<const float> controls,
                                      const Parallel& parallel);

// The root mean square of each coefficient over at most 2,000 of the poses, evenly spaced:
// PackOptions::coefficient_sizes.
std::vector<float> rms_coefficients(const FaceModel& model, const PoseSet& poses, const Parallel& parallel);

// Recorded displacements minus those of a model without gates, computed in float. The model must outlive it.
class ModelResidual final : public PoseRows {
 public:
  ModelResidual(PoseSet poses, const FaceModel& model);
  void read(std::size_t first, std::size_t count, std::span<float> values, const Parallel& parallel) const override;
  std::unique_ptr<PoseRows> subsampled(std::size_t count) const override;

 private:
  const FaceModel* model_;
  std::vector<std::size_t> coordinate_of_row_;  // the coordinate of the mesh of each row of the basis
};

}  // namespace fb::bake
