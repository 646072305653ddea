#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bake/rig/source.h"

namespace fb::bake {

// Several sources of one character as one. Poses are evaluated by the first live one.
class MergedSource final : public Source {
 public:
  // Fails, naming the two sources, unless controls, vertex order, polygons, meshes and rest points (to 1e-5 of the
  // diagonal) agree. Meshes and character are those of the first source. A clip that occurs twice with the same controls is kept once; if only its name does, the later one is
  // renamed "NAME (2)". Both are noted. The same controls in two splits are refused: a test clip would be trained on.
  MergedSource(std::vector<std::unique_ptr<Source>> sources, const std::vector<std::string>& names);

  const RigSchema& schema() const override { return sources_[0]->schema(); }
  const Mesh& rest() const override { return sources_[0]->rest(); }
  const Character& character() const override { return sources_[0]->character(); }
  const std::vector<Clip>& clips() const override { return clips_; }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override;
  bool readable(std::size_t clip) const override;
  std::vector<std::string> notes() const override { return notes_; }
  bool live() const override { return live_ != nullptr; }
  bool thread_safe() const override;
  void evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) override;
  std::size_t preferred_block() const override { return live_ ? live_->preferred_block() : 0; }
  std::string version() const override { return live_ ? live_->version() : ""; }
  std::uint64_t program_hash() const override { return live_ ? live_->program_hash() : 0; }
  bool recorded(std::size_t clip) const override;
  std::unique_ptr<EvaluationBackend> make_backend(const Parallel& parallel) override;

 private:
  struct Origin {
    Source* source;
    std::size_t clip;
  };

  void add_clips(Source& source, const std::string& name);

  std::vector<std::unique_ptr<Source>> sources_;
  Source* live_ = nullptr;
  std::vector<Clip> clips_;
  std::vector<Origin> origins_;  // of each clip
  std::vector<std::string> notes_;
};

}  // namespace fb::bake
