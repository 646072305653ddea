// A folder of recorded poses of the production rig: record_production RIG DIR POSES [SEED]
// RIG is librig_production.so. What is written is what somebody without FaceBaker would have recorded: POSES training
// poses (see tests/rigs/production/face_poses.h), and the rig's own clips to test with. Fewer poses of one seed are the
// first of more.
#include <cstdio>
#include <cstdlib>

#include "bake/dataset/open_source.h"
#include "bake/sampling/sampling.h"
#include "base/status.h"
#include "production/face_poses.h"
#include "production/face_rig.h"

using namespace fb;
using namespace fb::bake;

int main(int argc, char** argv) try {
  if (argc < 4) fail(Status::invalid_argument, "give RIG DIR POSES [SEED]");
  const auto source = open_source(argv[1]);
  RigEvaluator rig(*source, Parallel{});
  const std::size_t poses = std::strtoull(argv[3], nullptr, 10);
  const std::uint64_t seed = argc > 4 ? std::strtoull(argv[4], nullptr, 10) : 1;
  const rigs::production::FaceRig face;
  if (face.controls().list().size() != source->schema().control_count())
    fail(Status::invalid_argument, "%s: is not the production rig", argv[1]);
  PosePlan plan = {{"recorded", ClipKind::dense, Split::train, 30, poses,
                    rigs::production::recorded_poses(face.controls(), seed, poses)}};
  for (const Clip& clip : source->clips()) plan.push_back(clip);
  sample_to_dataset(rig, plan, argv[2], silent_progress());
  std::printf("%s: %zu poses\n", argv[2], poses);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
