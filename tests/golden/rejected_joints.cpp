#include "golden_edits.h"

namespace fb {

void write_rejected_joints(const RejectedWriter& out) {
  const char* const section = "driven-joints";
  const PackedModel model = driven_model();
  // Without a proof, which would not hold either.
  const auto write = [&](const char* file, const PackedModel& from, const std::function<void(Bytes&)>& change) {
    Bytes contents;
    edited([&](ArchiveEditor& archive) { contents = archive[section].stored; }, from);
    change(contents);
    out.replaced(file, section, contents, from);
  };
  const auto patched = [&](const char* file, std::size_t at, auto value) {
    write(file, model, [&](Bytes& b) { patch(b, at, value); });
  };
  // Joints: a name, the parent, numbers, outer rotations, of which the last joint has two, and the frame.
  constexpr std::size_t rest_bytes = 4 + 2 + 1 + 48;
  constexpr std::size_t parent = 4 + 4 + 3, numbers = parent + 4, frame = numbers + 2 + 1;
  constexpr std::size_t second_parent = parent + rest_bytes + 4 + 6;
  constexpr std::size_t last = 4 + 3 * (4 + rest_bytes) + 3 + 6 + 3, outer = last + 4 + 3 + 4 + 2;
  constexpr std::size_t scales = last + 4 + rest_bytes + 3 + 2, influences = scales + 4 * 22;
  constexpr std::size_t counts = influences + 4;
  std::size_t followed = 0;
  for (std::size_t v = 0; v < 30; ++v) followed += model.rest.driven.skin.count(v);
  const std::size_t joints = counts + 30, weights = joints + 2 * followed;
  out.renamed("corrupt-driven-nameless.fbk", section, "tongue", "", model);
  out.renamed("corrupt-driven-names.fbk", section, "pin", "lid", model);
  patched("corrupt-driven-parent.fbk", second_parent, std::uint32_t(1));
  patched("corrupt-driven-numbers.fbk", numbers, std::uint16_t(0x1003));
  patched("corrupt-driven-number-more.fbk", numbers, std::uint16_t(0xf));
  patched("corrupt-driven-outer-unknown.fbk", outer + 2, std::uint8_t(8));
  write("corrupt-driven-outer-none.fbk", model, [](Bytes& b) {
    patch(b, outer, std::uint8_t(3));
    b.insert(b.begin() + outer + 2, std::byte(0));
  });
  patched("corrupt-driven-frame.fbk", frame, nan_bits);
  patched("corrupt-driven-scale.fbk", scales, 0.0f);
  patched("corrupt-driven-scale-infinite.fbk", scales, infinity);
  patched("corrupt-driven-influences.fbk", influences, std::uint32_t(0));
  patched("corrupt-driven-influences-many.fbk", influences, std::uint32_t(33));
  patched("corrupt-driven-count.fbk", influences, std::uint32_t(2));
  patched("corrupt-driven-joint.fbk", joints, std::uint16_t(4));
  patched("corrupt-driven-weight.fbk", weights, std::uint16_t(0));
  patched("corrupt-driven-weights.fbk", weights, std::uint16_t(32769));
  write("corrupt-driven-more.fbk", model, [](Bytes& b) { insert(b, b.size(), {0}); });
  out.write("unproven-driven.fbk", changed(
                                       "proof", [](Bytes& b) { b.back() ^= std::byte(1); }, model));
  out.replaced("corrupt-driven-none.fbk", section, Bytes(8), model);
  write("corrupt-driven-outer-many.fbk", many_rotations(), [](Bytes& b) {
    constexpr std::size_t count = 4 + 4 + 3 + 4 + 2;
    patch(b, count, std::uint8_t(16));
    patch(b, count + 1, std::uint8_t(1));  // instead of two numbers, which a further one takes over
    b.insert(b.begin() + count + 2, std::byte(1));
  });
  // The last of 257 joints is the only one that is not below all others.
  write("corrupt-driven-deep.fbk", deep_chain(257), [](Bytes& b) {
    constexpr std::size_t joint = 4 + 5 + rest_bytes;
    patch(b, 4 + 256 * joint + 4 + 5, std::uint32_t(255));
  });
}

}  // namespace fb
