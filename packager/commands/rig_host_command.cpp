#include <poll.h>
#include <unistd.h>
#include <facebaker/facebaker_bake.hpp>

#include <cstdlib>
#include <memory>
#include <thread>

#include "commands/commands.h"
#include "commands/joint_options.h"

namespace fb::tool {
namespace {

struct RigHostCommand {
  std::string source;
  JointOptions joints;

  void run() const;
};

// What a variable of the protocol says, which the parent has set.
int descriptor(const char* variable, int otherwise) {
  const char* const told = std::getenv(variable);
  return told ? std::atoi(told) : otherwise;
}

// Ends this process a second after its parent is gone: a rig that hangs would never find out.
void end_with_parent(int requests) {
  pollfd end = {requests, 0, 0};
  while (::poll(&end, 1, -1) < 0) continue;
  ::sleep(1);
  ::_exit(1);
}

void RigHostCommand::run() const {
  const int requests = descriptor("FACEBAKER_RIG_REQUESTS", 3), answers = descriptor("FACEBAKER_RIG_ANSWERS", 4);
  std::thread(end_with_parent, requests).detach();
  const char* const path = source.c_str();
  fb_source_desc desc;
  fb_source_desc_init(&desc);
  desc.paths = &path;
  desc.path_count = 1;
  joints.fill(desc);
  facebaker::check(fb_source_serve(&desc, requests, answers));
}

}  // namespace

void add_rig_host(Command tool) {
  auto command = std::make_shared<RigHostCommand>();
  const Command app = tool.add_command("rig-host", "Serve a rig to the process that started this one (--isolate does)");
  app.add_option("SOURCE", command->source, "A rig plugin (librig_NAME.so), a .glb, .gltf or .vrm, or \"sample\"")
      .required();
  command->joints.add_to(app);
  app.footer(
      "Requests come on descriptor 3, or the one that FACEBAKER_RIG_REQUESTS names, answers go to descriptor 4, or\n"
      "FACEBAKER_RIG_ANSWERS, in the rig protocol: docs/rig-protocol.md. `exec:facebaker rig-host SOURCE` is a "
      "source.");
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
