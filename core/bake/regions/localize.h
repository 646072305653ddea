#pragma once

#include <span>

#include "model/face_model.h"

namespace fb {

struct LocalizeOptions {
  std::uint32_t chunk_vertices = 64;
  double threshold = 2e-5;  // over D: a chunk keeps the directions whose root mean square motion a vertex is larger
};

// Rewrites a basis so that a pose reads less of it: vertices are put in an order where neighbours of one region lie
// together and cut into chunks; in each chunk the columns of a region become fewer of the chunk's own, the principal
// directions of that region's motion there, and the rotation is merged into the region's last, linear layer. Direct
// columns are kept, left out of the chunks they do not move. `covariance`: one matrix a region, outputs x outputs, of
// its coefficients over poses. The result has the same features, regions and hidden layers.
FaceModel localize_basis(const FaceModel& model, std::span<const std::vector<float>> covariance,
                         const LocalizeOptions& options);

}  // namespace fb
