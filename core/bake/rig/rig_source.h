#pragma once

#include <memory>
#include <string>

#include "bake/rig/rig_description.h"
#include "bake/rig/source.h"

namespace fb::bake {

// A live rig behind the C interface, filled by a host or by a plugin.
class RigSource final : public Source {
 public:
  // Checks the rig, copies what it declares, and evaluates its rest pose, which must be its rest mesh to 1e-5 of the
  // diagonal. What `rig` points to must outlive this; `owner`, if given, is kept until then and may free it.
  // `program_hash`: see Source.
  explicit RigSource(const fb_rig& rig, std::shared_ptr<const void> owner = nullptr, std::uint64_t program_hash = 0);

  const RigSchema& schema() const override { return description_.schema; }
  const Mesh& rest() const override { return description_.rest; }
  const Character& character() const override { return description_.character; }
  const std::vector<Clip>& clips() const override { return description_.clips; }
  void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override;
  bool live() const override { return true; }
  bool thread_safe() const override { return (rig_.flags & FB_RIG_THREAD_SAFE) != 0; }
  void evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) override;
  std::size_t preferred_block() const override { return description_.preferred_block; }
  std::string version() const override { return description_.version; }
  std::uint64_t program_hash() const override { return program_hash_; }

 private:
  void evaluate_block(const float* controls, std::size_t first, std::size_t count, float* points) const;

  fb_rig rig_;
  std::shared_ptr<const void> owner_;
  RigDescription description_;
  double diagonal_;  // of the rest mesh
  std::uint64_t program_hash_;
};

// Opens a plugin: a shared library exporting fb_rig_open. Fails naming the path.
OpenedSource open_rig_plugin(const std::string& path);

}  // namespace fb::bake
