// Feeds arbitrary dataset folders to the dataset reader. The input is the folder's files one after the other, each as
// an index into `names`, modulo 8, two bytes of length, and contents.
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "bake/dataset/dataset_source.h"
#include "bake/dataset/rest_mesh.h"
#include "base/file.h"
#include "base/status.h"

namespace {

constexpr const char* names[] = {"dataset.json",        "rest.npy", "faces.npy", "clip.controls.npy", "clip.points.npy",
                                 "clip.000.points.npy", "rest.obj", "rest.glb"};

// In memory if possible; one folder per process.
const std::filesystem::path& folder() {
  static const std::filesystem::path path = [] {
    const std::filesystem::path shared = "/dev/shm";
    const auto base = std::filesystem::is_directory(shared) ? shared : std::filesystem::temp_directory_path();
    auto made = base / ("fb-fuzz-dataset-" + std::to_string(::getpid()));
    std::filesystem::create_directories(made);
    std::atexit([] { std::filesystem::remove_all(folder()); });
    return made;
  }();
  return path;
}

// Runs work(); an Error must have a message.
template <class Work>
void expect_message(Work&& work) {
  try {
    work();
  } catch (const fb::Error& error) {
    if (std::strlen(error.what()) < 10) __builtin_trap();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  for (const char* name : names) std::filesystem::remove(folder() / name);
  for (std::size_t at = 0; at + 3 <= size;) {
    const std::size_t length = std::min<std::size_t>(data[at + 1] | data[at + 2] << 8, size - at - 3);
    fb::write_file(folder() / names[data[at] % 8], std::as_bytes(std::span(data + at + 3, length)));
    at += 3 + length;
  }
  expect_message([] {
    fb::bake::DatasetSource source(folder());
    std::vector<float> points(source.rest().points.size());
    for (std::size_t clip = 0; clip < source.clips().size(); ++clip)
      if (source.readable(clip) && source.clips()[clip].controls.size() > 0) source.read(clip, 0, 1, points);
  });
  expect_message([] { fb::bake::read_mesh(folder() / "rest.obj"); });
  expect_message([] { fb::bake::read_mesh(folder() / "rest.glb"); });
  return 0;
}
