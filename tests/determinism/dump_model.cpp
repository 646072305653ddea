// dump_model ARCHIVE POSES DUMP: writes an archive's model and so many poses, from rest to all controls moved, for
// hash_poses.
#include <cstdio>
#include <cstdlib>

#include "archive/reader.h"
#include "base/file.h"
#include "base/random.h"
#include "model_dump.h"

int main(int argc, char** argv) {
  using namespace fb;
  using namespace fb::archive;
  if (argc != 4) {
    std::fprintf(stderr, "usage: dump_model ARCHIVE POSES DUMP\n");
    return 2;
  }
  try {
    PackedModel model = read_archive(read_file(argv[1])).model;
    const int poses = std::atoi(argv[2]);
    Random random(1);
    std::vector<float> controls;
    for (int pose = 0; pose < poses; ++pose)
      for (const Control& c : model.schema.controls) {
        const float value = random.uniform(c.minimum, c.maximum);
        controls.push_back(random.uniform() * float(poses) < float(pose) ? value : c.rest);
      }
    Dump(argv[3], false).all(model, controls);
    return 0;
  } catch (const Error& error) {
    std::fprintf(stderr, "dump_model: %s\n", error.what());
    return 1;
  }
}
