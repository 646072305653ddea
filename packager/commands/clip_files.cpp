#include "commands/clip_files.h"

#include "base/shown_path.h"
#include "base/status.h"

namespace fb::tool {

void add_clip_files(Command command, std::vector<std::string>& clips) {
  command
      .add_option("--clip", clips,
                  "A clip of your own to evaluate as well: a NumPy file of controls, frames x controls (repeatable)")
      .type_name("NAME=FILE.npy")
      .repeatable();
}

void ClipFiles::read(const std::vector<std::string>& options, std::uint32_t control_count) {
  for (const std::string& option : options) {
    const std::size_t equals = option.find('=');
    if (equals == 0 || equals == std::string::npos)
      fail(Status::invalid_argument, "--clip %s: give NAME=controls.npy", shown(option).c_str());
    files_.push_back({option.substr(0, equals), facebaker::read_clip_file(option.substr(equals + 1), control_count)});
  }
  for (const File& file : files_)
    clips_.push_back({file.name.c_str(), FB_CLIP_SHOT, FB_SPLIT_TRAIN, 30,
                      static_cast<std::uint32_t>(file.controls.size() / control_count), 0, file.controls.data()});
}

}  // namespace fb::tool
