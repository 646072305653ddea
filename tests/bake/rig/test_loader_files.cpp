// What tinygltf is given to open files by, against stand-ins for its versions.
#include <doctest/doctest.h>

#include <fstream>
#include <functional>
#include <string>

#include "bake/rig/gltf/loader_files.h"
#include "bake_test_support.h"
#include "temporary_folder.h"

namespace fb::bake::test_loader_files {
using namespace fb::test;

namespace {

using Bytes = std::vector<unsigned char>;

// As of version 2.7, with plain functions, all of which it takes.
struct OldCallbacks {
  bool (*FileExists)(const std::string&, void*);
  std::string (*ExpandFilePath)(const std::string&, void*);
  bool (*ReadWholeFile)(Bytes*, std::string*, const std::string&, void*);
  bool (*WriteWholeFile)(std::string*, const std::string&, const Bytes&, void*);
  void* user_data;
};
struct OldLoader {
  void SetFsCallbacks(OldCallbacks given) { callbacks = given; }
  OldCallbacks callbacks{};
};

// As of version 2.9, which refuses where one is missing.
struct NewCallbacks {
  std::function<bool(const std::string&, void*)> FileExists;
  std::function<std::string(const std::string&, void*)> ExpandFilePath;
  std::function<bool(Bytes*, std::string*, const std::string&, void*)> ReadWholeFile;
  std::function<bool(std::string*, const std::string&, const Bytes&, void*)> WriteWholeFile;
  std::function<bool(std::size_t*, std::string*, const std::string&, void*)> GetFileSizeInBytes;
  void* user_data;
};
struct NewLoader {
  bool SetFsCallbacks(NewCallbacks given, std::string* = nullptr) {
    if (!given.FileExists || !given.ExpandFilePath || !given.ReadWholeFile || !given.WriteWholeFile ||
        !given.GetFileSizeInBytes)
      return false;
    callbacks = std::move(given);
    return true;
  }
  NewCallbacks callbacks{};
};

// As of a version to come, which wants more.
struct NextCallbacks : NewCallbacks {
  std::function<bool(const std::string&)> OneMore;
};
struct NextLoader {
  bool SetFsCallbacks(const NextCallbacks& given, std::string* = nullptr) { return bool(given.OneMore); }
};

// The bytes of a file as the loader reads it.
template <class Loader>
std::string read(const Loader& loader, const std::string& path) {
  const auto& by = loader.callbacks;
  const std::string expanded = by.ExpandFilePath(path, by.user_data);
  REQUIRE(by.FileExists(expanded, by.user_data));
  Bytes bytes;
  std::string error;
  const bool whole = by.ReadWholeFile(&bytes, &error, expanded, by.user_data);
  REQUIRE(whole);
  return {bytes.begin(), bytes.end()};
}

template <class Loader>
void check_confined(const Loader& loader, const std::string& elsewhere) {
  CHECK(read(loader, "in.bin") == "inside");
  for (const std::string& path : {std::string("../out.bin"), elsewhere, std::string("file://") + elsewhere}) {
    CAPTURE(path);
    failure(Status::bad_data, [&] { read(loader, path); });
  }
  std::string error;
  CHECK(!loader.callbacks.WriteWholeFile(&error, "new.bin", {1}, loader.callbacks.user_data));
}

}  // namespace

TEST_CASE("no version of the loader opens files elsewhere, and a loader that refuses is an error") {
  const Folder folder;
  std::filesystem::create_directory(folder / "inner");
  std::ofstream(folder / "inner/in.bin") << "inside";
  std::ofstream(folder / "out.bin") << "outside";
  const std::string elsewhere = (folder / "out.bin").string();
  FilesBeside beside(folder / "inner");

  OldLoader old;
  open_files_beside<OldCallbacks>(old, beside);
  check_confined(old, elsewhere);

  NewLoader latest;
  open_files_beside<NewCallbacks>(latest, beside);
  check_confined(latest, elsewhere);
  std::size_t size = 1;
  CHECK(latest.callbacks.GetFileSizeInBytes(&size, nullptr, "in.bin", latest.callbacks.user_data));
  CHECK(size == 0);

  NextLoader next;
  CHECK(contains(failure(Status::internal, [&] { open_files_beside<NextCallbacks>(next, beside); }),
                 "this version of tinygltf refuses"));
}

}  // namespace fb::bake::test_loader_files
