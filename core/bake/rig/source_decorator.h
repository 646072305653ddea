#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bake/rig/source.h"

namespace fb::bake {

// Another source in all but what a class that is derived from this overrides.
class SourceDecorator : public Source {
 public:
  const RigSchema& schema() const override { return source_.schema(); }
  const Mesh& rest() const override { return source_.rest(); }
  const Character& character() const override { return source_.character(); }
  const std::vector<Clip>& clips() const override { return source_.clips(); }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override {
    source_.read(clip, first, count, points);
  }
  bool readable(std::size_t clip) const override { return source_.readable(clip); }
  std::vector<std::string> notes() const override { return source_.notes(); }
  bool live() const override { return source_.live(); }
  bool thread_safe() const override { return source_.thread_safe(); }
  void evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) override {
    source_.evaluate(controls, count, points);
  }
  std::size_t preferred_block() const override { return source_.preferred_block(); }
  std::string version() const override { return source_.version(); }
  std::uint64_t program_hash() const override { return source_.program_hash(); }
  bool recorded(std::size_t clip) const override { return source_.recorded(clip); }
  std::unique_ptr<EvaluationBackend> make_backend(const Parallel& parallel) override;

 protected:
  // `source` must outlive this.
  explicit SourceDecorator(Source& source) : source_(source) {}
  explicit SourceDecorator(std::unique_ptr<Source> source) : owned_(std::move(source)), source_(*owned_) {}

  Source& source() const { return source_; }

 private:
  const std::unique_ptr<Source> owned_;
  Source& source_;
};

}  // namespace fb::bake
