#include <dlfcn.h>

#include <array>
#include <cstring>
#include <filesystem>

#include "bake/rig/foreign_call.h"
#include "bake/rig/rig_description.h"
#include "bake/rig/rig_source.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/shown_path.h"

namespace fb::bake {
namespace {

// A loaded library and the rig it opened, with room for the longer struct of a plugin compiled against a newer header.
struct Plugin {
  void* library = nullptr;
  bool opened = false;
  union {
    fb_rig rig;
    std::array<char, 4 * sizeof(fb_rig)> room{};
  };

  Plugin() = default;
  Plugin(const Plugin&) = delete;
  Plugin& operator=(const Plugin&) = delete;
  ~Plugin() {
    try {
      // Where `destroy` lies in another layout is unknown.
      if (opened && rig.abi == FB_RIG_ABI && rig.struct_size >= smallest_rig && rig.destroy)
        foreign_call("the rig", [&] { rig.destroy(rig.user); });
    } catch (const Error&) {
      // There is nobody to tell; what it did not free is lost.
    }
    if (library) dlclose(library);
  }
};

}  // namespace

OpenedSource open_rig_plugin(const std::string& path) {
  const std::string file = std::filesystem::absolute(path).string();
  auto plugin = std::make_shared<Plugin>();
  // NODELETE: threads the plugin started, such as OpenMP's, may still run its code when it is closed.
  plugin->library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (!plugin->library) {
    const std::string why = dlerror(), place = file + ": ";
    fail(Status::rig, "%s: cannot be loaded as a rig plugin: %s", shown(path).c_str(),
         why.c_str() + (why.starts_with(place) ? place.size() : 0));
  }
  const auto open = reinterpret_cast<fb_rig_open_function>(dlsym(plugin->library, FB_RIG_OPEN_SYMBOL));
  if (!open) fail(Status::rig, "%s: is no rig plugin: it does not export %s", shown(path).c_str(), FB_RIG_OPEN_SYMBOL);
  std::array<char, 512> message{};
  const fb_status status = with_context(shown(path), [&] {
    return foreign_call(FB_RIG_OPEN_SYMBOL, [&] {
      return open(file.c_str(), &plugin->rig, message.data(), static_cast<std::uint32_t>(message.size()));
    });
  });
  message.back() = '\0';
  if (status != FB_OK)
    fail(Status::rig, "%s: the rig cannot be opened: %s", shown(path).c_str(),
         message[0] ? message.data() : format("status %d without a message", status).c_str());
  plugin->opened = true;
  try {
    return std::make_unique<RigSource>(plugin->rig, plugin, hash64(read_file(file)));
  } catch (const Error& error) {
    fail(error.status(), "%s: %s", shown(path).c_str(), error.what());
  }
}

}  // namespace fb::bake
