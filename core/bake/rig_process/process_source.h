#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bake/rig/source.h"
#include "bake/rig_process/rig_workers.h"

namespace fb::bake {

// A live rig in child processes that speak the rig protocol.
class ProcessSource final : public Source {
 public:
  // Starts a child, checks what it says as that of every rig, and evaluates its rest pose, asking `progress` meanwhile.
  ProcessSource(RigCommand command, Progress* progress);

  const RigSchema& schema() const override { return workers_.description().schema; }
  const Mesh& rest() const override { return workers_.description().rest; }
  const Character& character() const override { return workers_.description().character; }
  const std::vector<Clip>& clips() const override { return workers_.description().clips; }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override;
  std::vector<std::string> notes() const override { return workers_.description().notes; }
  bool live() const override { return true; }
  void evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) override;
  std::size_t preferred_block() const override;
  std::string version() const override { return workers_.description().version; }
  std::uint64_t program_hash() const override { return program_hash_; }
  std::unique_ptr<EvaluationBackend> make_backend(const Parallel& parallel) override;

 private:
  const std::uint64_t program_hash_;
  RigWorkers workers_;
  Progress* opening_;  // asked by evaluate while this is constructed
};

// The prefix of a source that is a command, run by /bin/sh.
inline constexpr const char* command_prefix = "exec:";

}  // namespace fb::bake
