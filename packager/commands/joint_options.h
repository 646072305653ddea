#pragma once

#include <facebaker/facebaker_bake.h>

#include <string>
#include <vector>

#include "options/command.h"

namespace fb::tool {

// How a glTF file is read: --joints and --control-joint, what its joints are, and --skip-broken. Wherever a source is
// opened by its path.
struct JointOptions {
  void add_to(Command command);
  // Sets the members of a source's description, which borrow this.
  void fill(fb_source_desc& desc) const;

 private:
  std::string joints_ = "auto";
  std::vector<std::string> names_;
  bool skip_broken_ = false;
  mutable std::vector<const char*> pointers_;  // to names_
};

}  // namespace fb::tool
