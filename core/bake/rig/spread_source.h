// A rig whose poses a host evaluates, on as many machines as it has.
#pragma once

#include <facebaker/facebaker_source.h>

#include <memory>
#include <string>
#include <vector>

#include "bake/rig/source_decorator.h"

namespace fb::bake {

// Another live source in all but evaluation, which is the host's; clips that are recorded are still read.
class SpreadSource final : public SourceDecorator {
 public:
  // `source` and what the spreader points to must outlive this; `owner`, if given, is kept until then and may free
  // them.
  SpreadSource(Source& source, const fb_spreader& spreader, std::shared_ptr<const void> owner);

  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override;
  bool thread_safe() const override { return false; }
  void evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) override;
  std::size_t preferred_block() const override;
  std::unique_ptr<EvaluationBackend> make_backend(const Parallel& parallel) override;

 private:
  const std::shared_ptr<const void> owner_;
  const fb_spreader spreader_;
};

}  // namespace fb::bake
