// A source made of a formula, for tests of everything that reads poses.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "bake/rig/source.h"
#include "base/random.h"

// A grid of quads; `formula` adds its displacements for a pose to the points.
class MemorySource : public fb::bake::Source {
 public:
  using Formula = std::function<void(const float* controls, std::span<float> points)>;

  MemorySource(std::size_t controls, std::size_t side, Formula formula, bool live = false)
      : formula_(std::move(formula)), live_(live) {
    schema_.name = "formula";
    for (std::size_t c = 0; c < controls; ++c)
      schema_.controls.push_back({"control" + std::to_string(c), -1, 1, 0, c % 2 ? "odd" : "even"});
    for (std::size_t y = 0; y < side; ++y)
      for (std::size_t x = 0; x < side; ++x)
        rest_.points.insert(rest_.points.end(), {float(x), float(y), 0.1f * float((x * y) % 3)});
    for (std::uint32_t y = 0; y + 1 < side; ++y)
      for (std::uint32_t x = 0; x + 1 < side; ++x) {
        const std::uint32_t a = y * side + x, down = static_cast<std::uint32_t>(side);
        rest_.polygon_sizes.push_back(4);
        rest_.polygon_corners.insert(rest_.polygon_corners.end(), {a, a + 1, a + 1 + down, a + down});
      }
  }

  // For tests that need other ranges, groups, poses or vertices.
  fb::RigSchema& edit_schema() { return schema_; }
  fb::Mesh& edit_rest() { return rest_; }
  fb::Character& edit_character() { return character_; }
  fb::bake::Clip& edit_clip(std::size_t clip) { return clips_.at(clip); }

  // Random poses, controls in their range, each active with this probability.
  void add_clip(const std::string& name, fb::bake::ClipKind kind, fb::bake::Split split, std::size_t frames,
                float active, std::uint64_t seed) {
    fb::bake::Clip clip{name, kind, split, 30, frames, {}};
    fb::Random random(seed);
    for (std::size_t i = 0; i < frames * schema_.controls.size(); ++i) {
      const fb::Control& control = schema_.controls[i % schema_.controls.size()];
      const bool on = random.uniform() < active;
      const float value = random.uniform(control.minimum, control.maximum);
      clip.controls.push_back(on ? value : control.rest);
    }
    clips_.push_back(std::move(clip));
  }

  const fb::RigSchema& schema() const override { return schema_; }
  const fb::Mesh& rest() const override { return rest_; }
  const fb::Character& character() const override { return character_; }
  const std::vector<fb::bake::Clip>& clips() const override { return clips_; }
  bool live() const override { return live_; }
  bool thread_safe() const override { return true; }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override {
    pose(std::span(clips_[clip].controls).subspan(first * schema_.controls.size(), count * schema_.controls.size()),
         count, points);
  }
  void evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) override {
    pose(controls, count, points);
  }

 private:
  void pose(std::span<const float> controls, std::size_t count, std::span<float> points) const {
    for (std::size_t i = 0; i < count; ++i) {
      const std::span<float> out = points.subspan(i * rest_.points.size(), rest_.points.size());
      std::copy(rest_.points.begin(), rest_.points.end(), out.begin());
      formula_(controls.data() + i * schema_.controls.size(), out);
    }
  }

  fb::RigSchema schema_;
  fb::Mesh rest_;
  fb::Character character_;
  std::vector<fb::bake::Clip> clips_;
  Formula formula_;
  bool live_;
};
