#pragma once

#include <facebaker/facebaker_bake.hpp>
#include <string>
#include <vector>

#include "options/command.h"

namespace fb::tool {

// Clips of the user: --clip NAME=FILE.npy.
void add_clip_files(Command command, std::vector<std::string>& clips);

class ClipFiles {
 public:
  // Reads the files of these options. Fails naming the option or the file.
  void read(const std::vector<std::string>& options, std::uint32_t control_count);
  // Shots to train on, for the C interface; valid as long as this.
  const std::vector<fb_rig_clip>& clips() const { return clips_; }

 private:
  struct File {
    std::string name;
    std::vector<float> controls;
  };
  std::vector<File> files_;
  std::vector<fb_rig_clip> clips_;
};

}  // namespace fb::tool
