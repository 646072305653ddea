#include "bake/baselines/model_residual.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bake/analysis/sparse_blendshapes.h"
#include "bake/linalg/gemm.h"
#include "bake/train/trainer.h"

namespace fb::bake {

std::vector<float> model_coefficients(const FaceModel& model, std::span<const float> controls,
                                      const Parallel& parallel) {
  const Network& network = model.network;
  const std::vector<float> rest = model.schema.rest_pose();
  const std::size_t width = network.features.size(), columns = model.basis.columns,
                    count = controls.size() / rest.size();
  std::vector<float> values(count * width), result(count * columns);
  parallel_for(parallel, count, [&](std::size_t i, std::size_t) {
    evaluate_features(network.features, controls.subspan(i * rest.size(), rest.size()), rest,
                      std::span(values).subspan(i * width, width));
    for (std::size_t d = 0; d < network.direct.size(); ++d)
      result[i * columns + d] = values[i * width + network.direct[d]];
  });
  std::size_t column = network.direct.size();
  for (const Region& region : network.regions) {
    const std::size_t outputs = region.layers.back().outputs;
    const std::vector<float> out = run_layers(
        region.layers, {count, region.features.size(), outputs, values, {}, {}, {}, width, region.features}, parallel);
    for (std::size_t i = 0; i < count; ++i)
      std::copy_n(out.data() + i * outputs, outputs, result.data() + i * columns + column);
    column += outputs;
  }
  return result;
}

std::vector<float> rms_coefficients(const FaceModel& model, const PoseSet& poses, const Parallel& parallel) {
  const PoseSet sample = poses.subsampled(2000);
  const std::vector<float> all = model_coefficients(model, sample.controls(), parallel);
  std::vector<double> squares(model.basis.columns);
  for (std::size_t i = 0; i < all.size(); ++i) squares[i % squares.size()] += double(all[i]) * all[i];
  std::vector<float> sizes;
  for (const double sum : squares) sizes.push_back(static_cast<float>(std::sqrt(sum / double(sample.size()))));
  return sizes;
}

ModelResidual::ModelResidual(PoseSet poses, const FaceModel& model)
    : PoseRows(std::move(poses)), model_(&model), coordinate_of_row_(rows()) {
  const std::vector<std::uint32_t>& order = model.basis.order;
  for (std::size_t row = 0; row < coordinate_of_row_.size(); ++row)
    coordinate_of_row_[row] = order.empty() ? row : 3 * std::size_t(order[row / 3]) + row % 3;
}

std::unique_ptr<PoseRows> ModelResidual::subsampled(std::size_t count) const {
  return std::make_unique<ModelResidual>(poses().subsampled(count), *model_);
}

void ModelResidual::read(std::size_t first, std::size_t count, std::span<float> values,
                         const Parallel& parallel) const {
  poses().read_displacements(first, count, values);
  std::vector<float> controls(count * model_->schema.control_count());
  poses().read_controls(first, count, controls);
  const std::vector<float> coefficients = model_coefficients(*model_, controls, parallel);
  const std::size_t columns = model_->basis.columns;
  parallel_for(parallel, model_->basis.row_blocks.size(), [&](std::size_t g, std::size_t) {
    const RowBlock& group = model_->basis.row_blocks[g];
    const std::size_t used = group.columns.size();
    std::vector<float> used_coefficients(used * count), displacements(group.row_count * count);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t c = 0; c < used; ++c)
        used_coefficients[i * used + c] = coefficients[i * columns + group.columns[c]];
    gemm(Op::plain, Op::plain, group.row_count, count, used, group.values.data(), group.row_count,
         used_coefficients.data(), used, 0, displacements.data(), group.row_count);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t row = 0; row < group.row_count; ++row)
        values[i * rows() + coordinate_of_row_[group.first_row + row]] -= displacements[i * group.row_count + row];
  });
}

}  // namespace fb::bake
