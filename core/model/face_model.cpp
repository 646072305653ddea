#include "model/face_model.h"

#include "base/status.h"

namespace fb {

void check(const FaceModel& model) {
  check(model.schema);
  check(model.rest);
  check(model.network, model.schema.control_count());
  check(model.basis);
  if (model.basis.rows != model.rest.points.size())
    fail(Status::bad_data, "the basis has %u rows for %zu coordinates", model.basis.rows, model.rest.points.size());
  if (model.basis.columns != model.network.coefficient_count())
    fail(Status::bad_data, "the basis has %u columns for %zu coefficients", model.basis.columns,
         model.network.coefficient_count());
}

}  // namespace fb
