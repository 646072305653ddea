#pragma once

#include <atomic>
#include <cstdint>

#include "bake/rig/source.h"

namespace fb::bake {

// A source as it is, that counts the poses a live rig is asked for and stops at a budget.
class RigMeter final : public Source {
 public:
  // `source` must outlive this. `budget`: poses at most; 0: as many as are asked for.
  explicit RigMeter(Source& source, std::uint64_t budget = 0) : source_(source), budget_(budget) {}

  // Poses a live rig was asked for through this, those that failed included; 0 of a recording.
  std::uint64_t calls() const { return calls_; }

  const RigSchema& schema() const override { return source_.schema(); }
  const Mesh& rest() const override { return source_.rest(); }
  const std::vector<Clip>& clips() const override { return source_.clips(); }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override;
  bool readable(std::size_t clip) const override { return source_.readable(clip); }
  std::vector<std::string> notes() const override { return source_.notes(); }
  bool live() const override { return source_.live(); }
  bool thread_safe() const override { return source_.thread_safe(); }
  // Fails with invalid_argument, asking nothing, if the budget does not hold these poses.
  void evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) override;

 private:
  void spend(std::size_t poses);

  Source& source_;
  const std::uint64_t budget_;
  std::atomic<std::uint64_t> calls_{0};
};

}  // namespace fb::bake
