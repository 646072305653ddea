// A live rig without clips, with poses that are drawn for it to be measured on.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bake/rig/source.h"

namespace fb::bake {

// Another source, which is live and has no clips, with those of make_test_poses, of split test.
class DrawnClips final : public Source {
 public:
  DrawnClips(std::unique_ptr<Source> source, std::uint64_t seed, std::size_t poses);

  const RigSchema& schema() const override { return source_->schema(); }
  const Mesh& rest() const override { return source_->rest(); }
  const Character& character() const override { return source_->character(); }
  const std::vector<Clip>& clips() const override { return clips_; }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override;
  std::vector<std::string> notes() const override;
  bool live() const override { return true; }
  bool thread_safe() const override { return source_->thread_safe(); }
  void evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) override {
    source_->evaluate(controls, count, points);
  }
  std::size_t preferred_block() const override { return source_->preferred_block(); }
  std::string version() const override { return source_->version(); }
  std::uint64_t program_hash() const override { return source_->program_hash(); }
  std::unique_ptr<EvaluationBackend> make_backend(const Parallel& parallel) override;

 private:
  const std::unique_ptr<Source> source_;
  const std::vector<Clip> clips_;
  const std::string note_;
};

}  // namespace fb::bake
