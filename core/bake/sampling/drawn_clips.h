// A live rig without clips, with poses that are drawn for it to be measured on.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bake/rig/source_decorator.h"

namespace fb::bake {

// Another source, which is live and has no clips, with those of make_test_poses, of split test.
class DrawnClips final : public SourceDecorator {
 public:
  DrawnClips(std::unique_ptr<Source> source, std::uint64_t seed, std::size_t poses);

  const std::vector<Clip>& clips() const override { return clips_; }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override;
  bool readable(std::size_t) const override { return true; }
  bool recorded(std::size_t) const override { return false; }
  std::vector<std::string> notes() const override;

 private:
  const std::vector<Clip> clips_;
  const std::string note_;
};

}  // namespace fb::bake
