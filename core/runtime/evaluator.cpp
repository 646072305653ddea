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

void Evaluator::coefficients(const float* controls, float* coefficients, Workspace& workspace,
                             RegionMask regions) const {
  refuse_nan(controls);
  workspace.clamped_ = 0;
  with_float_mode([&] { PoseExecution(layout_, regions, workspace).run_coefficients(controls, coefficients); });
}

}  // namespace fb::runtime
