// Which files tinygltf may open.
#pragma once

#include <cstddef>
#include <string>
#include <type_traits>
#include <vector>

#include "bake/rig/gltf/files_beside.h"
#include "base/status.h"

namespace fb::bake {

// Lets a loader open no file but those beside, which must outlive it. Fails with internal if the loader refuses that:
// it would open any file. Loader and Callbacks: TinyGLTF and FsCallbacks of tinygltf; since 2.9 these also ask for
// sizes, and refuse an empty callback.
template <class Callbacks, class Loader>
void open_files_beside(Loader& loader, FilesBeside& beside) {
  Callbacks callbacks{};
  callbacks.FileExists = [](const std::string&, void*) { return true; };
  callbacks.ExpandFilePath = [](const std::string& path, void*) { return path; };
  callbacks.ReadWholeFile = [](std::vector<unsigned char>* to, std::string*, const std::string& path, void* user) {
    const std::vector<std::byte> bytes = static_cast<FilesBeside*>(user)->read(path);
    const auto* first = reinterpret_cast<const unsigned char*>(bytes.data());
    to->assign(first, first + bytes.size());
    return true;
  };
  callbacks.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
  };
  if constexpr (requires { callbacks.GetFileSizeInBytes; }) {
    callbacks.GetFileSizeInBytes = [](std::size_t* size, std::string*, const std::string&, void*) {
      *size = 0;  // FilesBeside has a limit of its own
      return true;
    };
  }
  callbacks.user_data = &beside;
  if constexpr (std::is_void_v<decltype(loader.SetFsCallbacks(callbacks))>) {
    loader.SetFsCallbacks(callbacks);
  } else {
    if (!loader.SetFsCallbacks(callbacks))
      fail(Status::internal, "this version of tinygltf refuses to open files by what FaceBaker gives it");
  }
}

}  // namespace fb::bake
