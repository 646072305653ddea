#include "runtime/evaluator.h"

#include <algorithm>

#include "base/status.h"
#include "runtime/float_mode.h"

namespace fb::runtime {

std::size_t Evaluator::find_nan(const float* controls) const {
  if (!kernels().any_nan(controls, control_count())) return control_count();
  return std::find_if(controls, controls + control_count(), [](float v) { return v != v; }) - controls;
}

void Evaluator::refuse_nan(const float* controls) const {
  const std::size_t control = find_nan(controls);
  if (control < control_count())
    fail(Status::not_finite, "control \"%s\" is not a number", schema().controls[control].name.c_str());
}

void Evaluator::evaluate(const float* controls, float* positions, Workspace& workspace,
                         std::size_t vertex_stride) const {
  refuse_nan(controls);
  workspace.clamped_ = 0;
  with_float_mode([&] {
    PoseExecution(layout_, {}, workspace).run_pose(controls, {{positions, vertex_stride}, {}, {}});
  });
}

void Evaluator::evaluate_points(const float* controls, float* points, Workspace& workspace, bool unskinned) const {
  refuse_nan(controls);
  workspace.clamped_ = 0;
  PoseOutput output;
  output.positions = {points, 3};
  output.unskinned = unskinned;
  output.all_points = true;
  with_float_mode([&] { PoseExecution(layout_, {}, workspace).run_pose(controls, output); });
}

void Evaluator::coefficients(const float* controls, float* coefficients, Workspace& workspace,
                             RegionMask regions) const {
  refuse_nan(controls);
  workspace.clamped_ = 0;
  with_float_mode(
      [&] { PoseExecution(layout_, {.regions = regions}, workspace).run_coefficients(controls, coefficients); });
}

void Evaluator::expected_errors(const float* controls, float* errors, std::uint32_t* outside,
                                Workspace& workspace) const {
  if (error_count() == 0) fail(Status::invalid_argument, "the face has no expected errors");
  refuse_nan(controls);
  with_float_mode([&] { layout_.errors.run(controls, errors, outside, workspace.errors_); });
}

void Evaluator::leave_out_idle_regions(MeshMask meshes, bool channels, std::span<std::uint8_t> regions) const {
  constexpr std::uint8_t needed = 2;
  for (std::size_t b = 0; b < layout_.row_blocks.size(); ++b) {
    const std::uint32_t mesh = layout_.meshes.row_block_meshes[b];
    if (!(mesh < meshes.size() ? meshes[mesh] : channels || !layout_.skin.empty())) continue;
    for (const auto& inputs : layout_.row_block_regions.row(b))
      if (regions[inputs.region]) regions[inputs.region] = needed;
  }
  for (std::uint8_t& region : regions) region = region == needed;
}

}  // namespace fb::runtime
