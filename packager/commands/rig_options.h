#pragma once

#include <cstdint>
#include <facebaker/facebaker_bake.hpp>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace fb::tool {

// How commands open sources whose rigs may be slow, crash or hang: --isolate, --workers, --rig-timeout.
struct RigOptions {
  void add_to(CLI::App& command);
  // Opens sources; what was found while opening is added to `notes`. Interrupted by the signals of interrupt.h.
  facebaker::Source open(const std::vector<std::string>& sources, std::vector<std::string>& notes) const;

 private:
  bool isolate_ = false;
  std::uint32_t workers_ = 0;
  double pose_seconds_ = 60;
};

}  // namespace fb::tool
