#pragma once

#include "bake/rig/source_decorator.h"

namespace fb::bake {

// Another source as if its controls drove no joints: only the positions are left of them.
class JointlessSource final : public SourceDecorator {
 public:
  // `source` must outlive this.
  explicit JointlessSource(Source& source);

  const Mesh& rest() const override { return rest_; }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override;
  void evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) override;
  std::unique_ptr<EvaluationBackend> make_backend(const Parallel& parallel) override;

 private:
  // Of poses with the numbers of joints, which come last, to those without.
  void drop_numbers(std::span<const float> from, std::size_t poses, std::span<float> to) const;

  Mesh rest_;
};

}  // namespace fb::bake
