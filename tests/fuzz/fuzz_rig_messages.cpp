// Feeds arbitrary bytes to the parent's and the child's reader of the rig protocol: as what a child says, in pieces
// whose size the first byte gives, and as what a parent asks.
#include <algorithm>
#include <vector>

#include "bake/rig/driven_pose.h"
#include "bake/rig_process/rig_messages.h"
#include "fuzz_folder.h"

using namespace fb::bake;

namespace {

constexpr std::size_t poses = 2, controls = 3;

// A rig of four vertices and a channel.
RigDescription small_rig() {
  RigDescription rig;
  rig.schema.channels = {{"frown", "", 0, 1, 0, 1}};
  rig.rest.points.resize(3 * 5);
  rig.rest.carrier_vertices = 1;
  return rig;
}

// A rig of four vertices whose poses come after skinning by a joint.
RigDescription skinned_rig() {
  constexpr fb::Frame<float> identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  RigDescription rig;
  rig.rest.points = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 1};
  rig.character.joints = {{"lid", fb::no_joint, identity, identity}};
  rig.character.skin = {1, {0, 0, 0, 0}, {1, 1, 0.5f, 1}};
  take_out_skin(rig, std::vector<std::uint32_t>{fb::joint_rotation | fb::joint_scale});
  add_joint_vertices(rig.rest);
  return rig;
}

// All messages of a stream.
template <class Take>
void read_messages(std::span<const std::byte> bytes, std::size_t piece, const Take& take) {
  MessageReader reader;
  reader.limit_data(1u << 20);
  while (!bytes.empty()) {
    const std::size_t count = std::min({piece, bytes.size(), reader.wanted()});
    reader.take(bytes.first(count));
    bytes = bytes.subspan(count);
    if (reader.wanted() == 0) take(reader.release());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span<const std::byte> bytes = std::as_bytes(std::span(data + 1, size - 1));
  const std::size_t piece = 1 + data[0];
  fuzz::expect_message([&] {
    const RigDescription rig = small_rig(), skinned = skinned_rig();
    std::vector<float> points(poses * std::max(rig.rest.points.size(), skinned.rest.points.size()));
    read_messages(bytes, piece, [&](const RigMessage& message) {
      try {
        description_of(message);
      } catch (const fb::Error&) {
        // Its message may be the child's own, however short.
      }
      for (const RigDescription* of : {&rig, &skinned})
        fuzz::expect_message(
            [&] { read_answer(message, *of, poses, std::span(points).first(poses * of->rest.points.size())); });
    });
  });
  fuzz::expect_message([&] {
    read_messages(bytes, piece, [](const RigMessage& message) {
      fuzz::expect_message([&] {
        if (request_of(message) == RigRequest::evaluate) poses_of(message, controls);
      });
    });
  });
  return 0;
}
