#pragma once

#include "model/basis.h"
#include "model/mesh.h"

namespace fb::bake {

// The basis with row blocks cut where consecutive rows are of different parts of the mesh, so that each part can be
// posed by itself.
Basis cut_at_parts(Basis basis, const Mesh& rest);

}  // namespace fb::bake
