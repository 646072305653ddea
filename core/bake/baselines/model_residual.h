#pragma once

#include "bake/rig/pose_rows.h"
#include "model/face_model.h"

namespace fb::bake {

// The coefficients a model without gates computes, in float, for poses (count x controls): count x columns.
std::vector<float> model_coefficients(const FaceModel& model, std::span<const float> controls,
                                      const Parallel& parallel);

// The root mean square of each coefficient over at most 2,000 of the poses, evenly spaced: what packing goes by.
std::vector<float> coefficient_sizes(const FaceModel& model, const PoseSet& poses, const Parallel& parallel);

// What a model without gates, in float, leaves over of recorded poses: what the parts added to it next learn. The model
// must outlive it.
class ModelResidual final : public PoseRows {
 public:
  ModelResidual(PoseSet poses, const FaceModel& model);
  void read(std::size_t first, std::size_t count, std::span<float> values, const Parallel& parallel) const override;
  std::unique_ptr<PoseRows> subsampled(std::size_t count) const override;

 private:
  const FaceModel* model_;
  std::vector<std::size_t> row_of_;  // of the basis: which coordinate of the mesh it is
};

}  // namespace fb::bake
