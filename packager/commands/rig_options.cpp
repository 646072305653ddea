#include "commands/rig_options.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "commands/command_options.h"
#include "commands/interrupt.h"
#include "commands/progress_bar.h"

namespace fb::tool {
namespace {

SourceOpener& source_opener() {
  static SourceOpener opener = [](const fb_source_desc& desc) { return facebaker::Source(desc); };
  return opener;
}

}  // namespace

void set_source_opener(SourceOpener opener) {
  source_opener() = std::move(opener);
}

void RigOptions::add_to(Command command) {
  joints_.add_to(command);
  command.add_flag("--isolate", isolate_,
                   "Run the rig in a child process: where it crashes or hangs, it is started again, and the pose that "
                   "did it is named");
  command
      .add_option(
          "--workers", workers_,
          "Child processes that evaluate poses at once, for exec: and, as --isolate does, for other rigs. Results "
          "do not depend on it.")
      .between(1, 256)
      .type_name("N");
  command
      .add_option("--rig-timeout", pose_seconds_,
                  "A pose that takes a rig in a child process longer hangs; to start, it may take five times as long")
      .between(0.01, 1e6)
      .type_name("SECONDS")
      .shows_default();
}

void RigOptions::add_clip_budget_to(Command command) {
  command
      .add_option("--clip-budget", clip_budget_,
                  "Frames of a rig's own clips to evaluate at most, N of those to train on and N of those to measure "
                  "on: evenly spaced stretches of every clip; by default the rig budget, and all without one")
      .between(std::uint64_t{1}, std::uint64_t{1} << 32)
      .type_name("N");
}

facebaker::Source RigOptions::open(const std::vector<std::string>& sources, std::vector<std::string>& notes,
                                   std::uint64_t rig_budget, std::uint64_t test_poses) const {
  const std::vector<const char*> paths = c_strings(sources);
  std::error_code unknown;
  const std::string host = std::filesystem::read_symlink("/proc/self/exe", unknown).string();
  fb_source_desc desc;
  fb_source_desc_init(&desc);
  desc.paths = paths.data();
  desc.path_count = static_cast<std::uint32_t>(paths.size());
  desc.callbacks = collect_notes(notes);
  desc.callbacks.progress = [](void*, const char*, std::uint64_t, std::uint64_t) -> std::int32_t {
    return interrupt_requested();
  };
  desc.workers = std::max(workers_, isolate_ ? 1u : 0u);
  if (!unknown) desc.host = host.c_str();
  desc.pose_seconds = pose_seconds_;
  desc.clip_budget = clip_budget_ > 0 ? clip_budget_ : rig_budget;
  desc.test_poses = test_poses;
  joints_.fill(desc);
  return source_opener()(desc);
}

}  // namespace fb::tool
