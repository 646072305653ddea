// A rig whose poses a host evaluates, on as many machines as it has.
#pragma once

#include <facebaker/facebaker_source.h>

#include <memory>
#include <string>
#include <vector>

#include "bake/rig/source.h"

namespace fb::bake {

// Another live source in all but evaluation, which is the host's; clips that are recorded are still read.
class SpreadSource final : public Source {
 public:
  // `source` and what the spreader points to must outlive this; `owner`, if given, is kept until then and may free
  // them.
  SpreadSource(Source& source, const fb_spreader& spreader, std::shared_ptr<const void> owner);

  const RigSchema& schema() const override { return source_.schema(); }
  const Mesh& rest() const override { return source_.rest(); }
  const Character& character() const override { return source_.character(); }
  const std::vector<Clip>& clips() const override { return source_.clips(); }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override;
  bool readable(std::size_t clip) const override { return source_.readable(clip); }
  std::vector<std::string> notes() const override { return source_.notes(); }
  bool live() const override { return true; }
  void evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) override;
  std::size_t preferred_block() const override;
  std::string version() const override { return source_.version(); }
  std::uint64_t program_hash() const override { return source_.program_hash(); }
  bool recorded(std::size_t clip) const override { return source_.recorded(clip); }
  std::unique_ptr<EvaluationBackend> make_backend(const Parallel& parallel) override;

 private:
  const std::shared_ptr<const void> owner_;
  Source& source_;
  const fb_spreader spreader_;
};

}  // namespace fb::bake
