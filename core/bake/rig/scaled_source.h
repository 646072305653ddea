// Faces of extraordinary size, scaled to an ordinary one (see scale_exponent) before anything is computed from them, so
// that squares of distances and products of three of them are normal floats.
#pragma once

#include <memory>
#include <vector>

#include "bake/rig/converted_source.h"
#include "model/mesh_scale.h"
#include "model/packed_model.h"

namespace fb::bake {

// A schema, a mesh and a face with all positions times 2^exponent, which is exact. Channels keep their values.
RigSchema scaled(RigSchema schema, int exponent);
Mesh scaled(Mesh mesh, int exponent);
PackedModel scaled(PackedModel face, int exponent);

// Another source with all its points times 2^exponent. Of a live one, poses are evaluated as they are.
class ScaledSource final : public ConvertedSource {
 public:
  // `source` must outlive this.
  ScaledSource(Source& source, int exponent);
  ScaledSource(std::unique_ptr<Source> source, int exponent);

  const RigSchema& schema() const override { return schema_; }
  void convert(std::span<const float> controls, std::span<const float> from, std::size_t poses,
               std::span<float> to) const override;

 private:
  const int exponent_;
  const RigSchema schema_;
};

}  // namespace fb::bake
