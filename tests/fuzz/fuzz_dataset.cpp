// Feeds arbitrary dataset folders to the dataset reader and to the check of folders. The input is the folder's files
// one after the other, each as an index into `names` (of a number beyond them, modulo 8), two bytes of length, and
// contents.
#include <algorithm>
#include <vector>

#include "bake/check/check_dataset.h"
#include "bake/dataset/dataset_source.h"
#include "bake/dataset/rest_mesh.h"
#include "bake/dataset/schema_source.h"
#include "fuzz_folder.h"

using fuzz::expect_message;
using fuzz::folder;

namespace {

constexpr const char* names[] = {
    "dataset.json",        "rest.npy", "faces.npy", "clip.controls.npy", "clip.points.npy",
    "clip.000.points.npy", "rest.obj", "rest.glb",  "clip.points.mdd",   "clip.points.pc2"};
constexpr std::size_t name_count = sizeof names / sizeof names[0];

// What the check calls bakeable, the reader opens; what the reader refuses, the check calls a fault.
void check() {
  const fb::DatasetFigures found = fb::bake::check_dataset(folder(), {}, fb::silent_progress());
  bool opened = true;
  try {
    fb::bake::DatasetSource source(folder());
  } catch (const fb::Error&) {
    opened = false;
  }
  if (found.bakeable && !opened) __builtin_trap();
  if (!opened && (found.faults.empty())) __builtin_trap();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  for (const char* name : names) std::filesystem::remove(folder() / name);
  for (std::size_t at = 0; at + 3 <= size;) {
    const std::size_t length = std::min<std::size_t>(data[at + 1] | data[at + 2] << 8, size - at - 3);
    fuzz::put(names[data[at] < name_count ? data[at] : data[at] % 8], data + at + 3, length);
    at += 3 + length;
  }
  expect_message([] {
    fb::bake::DatasetSource source(folder());
    std::vector<float> points(source.rest().points.size());
    for (std::size_t clip = 0; clip < source.clips().size(); ++clip)
      if (source.readable(clip) && source.clips()[clip].controls.size() > 0) source.read(clip, 0, 1, points);
  });
  expect_message([] { fb::bake::SchemaSource source(folder() / "dataset.json"); });
  expect_message([] { check(); });
  expect_message([] { fb::bake::read_mesh(folder() / "rest.obj"); });
  expect_message([] { fb::bake::read_mesh(folder() / "rest.glb"); });
  return 0;
}
