// Faces of extraordinary size, scaled to an ordinary one (see scale_exponent) before anything is computed from them, so
// that squares of distances and products of three of them are normal floats.
#pragma once

#include <memory>
#include <vector>

#include "bake/rig/source.h"
#include "model/mesh_scale.h"
#include "model/packed_model.h"

namespace fb::bake {

// A schema, a mesh and a face with all positions times 2^exponent, which is exact. Channels keep their values.
RigSchema scaled(RigSchema schema, int exponent);
Mesh scaled(Mesh mesh, int exponent);
PackedModel scaled(PackedModel face, int exponent);

// Another source with all its points times 2^exponent. Of a live one, poses are evaluated as they are.
class ScaledSource final : public Source {
 public:
  // `source` must outlive this.
  ScaledSource(Source& source, int exponent);
  ScaledSource(std::unique_ptr<Source> source, int exponent);

  const RigSchema& schema() const override { return schema_; }
  const Mesh& rest() const override { return rest_; }
  const Character& character() const override { return source_.character(); }
  const std::vector<Clip>& clips() const override { return source_.clips(); }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override;
  bool readable(std::size_t clip) const override { return source_.readable(clip); }
  std::vector<std::string> notes() const override { return source_.notes(); }
  bool live() const override { return source_.live(); }
  bool thread_safe() const override { return source_.thread_safe(); }
  void evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) override;
  std::size_t preferred_block() const override { return source_.preferred_block(); }
  std::string version() const override { return source_.version(); }
  std::uint64_t program_hash() const override { return source_.program_hash(); }
  bool recorded(std::size_t clip) const override { return source_.recorded(clip); }
  std::unique_ptr<EvaluationBackend> make_backend(const Parallel& parallel) override;

 private:
  const std::unique_ptr<Source> owned_;
  Source& source_;
  const int exponent_;
  const RigSchema schema_;
  const Mesh rest_;
};

}  // namespace fb::bake
