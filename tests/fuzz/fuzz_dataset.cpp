// Feeds arbitrary dataset folders to the dataset reader. The input is the folder's files one after the other, each as
// an index into `names`, modulo 8, two bytes of length, and contents.
#include <algorithm>
#include <vector>

#include "bake/dataset/dataset_source.h"
#include "bake/dataset/rest_mesh.h"
#include "fuzz_folder.h"

using fuzz::expect_message;
using fuzz::folder;

namespace {

constexpr const char* names[] = {"dataset.json",        "rest.npy", "faces.npy", "clip.controls.npy", "clip.points.npy",
                                 "clip.000.points.npy", "rest.obj", "rest.glb"};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  for (const char* name : names) std::filesystem::remove(folder() / name);
  for (std::size_t at = 0; at + 3 <= size;) {
    const std::size_t length = std::min<std::size_t>(data[at + 1] | data[at + 2] << 8, size - at - 3);
    fuzz::put(names[data[at] % 8], data + at + 3, length);
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
