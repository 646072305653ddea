// A slow rig's own clips, in part.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bake/rig/source.h"

namespace fb::bake {

// Another source, whose clips of one split have so many frames at most. Where they have more, every clip gives its
// share in stretches of about 32 consecutive frames, evenly spaced over it; each stretch is a clip of its own, called
// "CLIP [FIRST-LAST]" by its frames. A clip whose share is less than a frame is left out.
class LimitedClips final : public Source {
 public:
  // `frames`: of each split, at least 1.
  LimitedClips(std::unique_ptr<Source> source, std::uint64_t frames);

  const RigSchema& schema() const override { return source_->schema(); }
  const Mesh& rest() const override { return source_->rest(); }
  const Character& character() const override { return source_->character(); }
  const std::vector<Clip>& clips() const override { return clips_; }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override;
  bool readable(std::size_t clip) const override { return source_->readable(origins_.at(clip).clip); }
  std::vector<std::string> notes() const override { return source_->notes(); }
  bool live() const override { return source_->live(); }
  bool thread_safe() const override { return source_->thread_safe(); }
  void evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) override {
    source_->evaluate(controls, count, points);
  }
  std::size_t preferred_block() const override { return source_->preferred_block(); }
  std::string version() const override { return source_->version(); }
  std::uint64_t program_hash() const override { return source_->program_hash(); }
  bool recorded(std::size_t clip) const override { return source_->recorded(origins_.at(clip).clip); }
  std::unique_ptr<EvaluationBackend> make_backend(const Parallel& parallel) override;

 private:
  // Where a clip begins in the source.
  struct Origin {
    std::size_t clip, frame;
  };

  void add(std::size_t clip, std::size_t first, std::size_t count);
  void add_stretches(std::size_t clip, std::size_t frames);

  const std::unique_ptr<Source> source_;
  std::vector<Clip> clips_;
  std::vector<Origin> origins_;
};

}  // namespace fb::bake
