// Evaluating blocks of poses for a host, and by a host.
#include "bake/authoring.h"
#include "bake/rig/carried_numbers.h"
#include "bake/rig/rig_evaluator.h"
#include "bake/rig/spread_source.h"
#include "base/checked.h"

using fb::fail;
using fb::Status;
using namespace fb::capi;

namespace {

// What a spread source keeps until it is closed: the host's, then the one below.
class SpreadOwner {
 public:
  SpreadOwner(fb_source* source, const fb_spreader& spreader) : source_(source), spreader_(spreader) {}
  SpreadOwner(const SpreadOwner&) = delete;
  SpreadOwner& operator=(const SpreadOwner&) = delete;
  ~SpreadOwner() {
    if (kept_ && spreader_.close) spreader_.close(spreader_.user);
    if (kept_) fb_source_close(source_);
  }
  // From now on.
  void keep() { kept_ = true; }

 private:
  fb_source* const source_;
  const fb_spreader spreader_;
  bool kept_ = false;
};

// The buffers of a block as spans.
struct Buffers {
  std::span<const float> controls;
  std::span<float> positions, numbers;
};

Buffers buffers_of(const fb::bake::Source& source, const fb_pose_block& block) {
  const std::size_t numbers = fb::bake::carried_count(source.schema(), source.rest());
  if (block.poses > 0) {
    require(block.controls, "fb_pose_block: controls");
    require(block.positions, "fb_pose_block: positions");
    require(block.answered, "fb_pose_block: answered");
    if (numbers > 0) require(block.channels, "fb_pose_block: channels");
  }
  const auto floats = [&](std::size_t of_pose, const char* what) {
    return fb::checked_multiply(block.poses, of_pose, what);
  };
  return {{block.controls, floats(source.schema().control_count(), "poses x controls")},
          {block.positions, floats(source.rest().surface_points().size(), "poses x 3 x vertices")},
          {block.channels, floats(numbers, "poses x numbers")}};
}

// Evaluates poses and counts them; `answered`: of points.
void evaluate_points(fb::bake::Source& source, fb_pose_block& block, std::span<const float> controls,
                     std::span<float> points, std::span<char> answered) {
  HostProgress progress(block.callbacks);
  const auto backend = source.make_backend(parallel_of(block.threads, block.callbacks.progress ? &progress : nullptr));
  try {
    progress.ask();
    backend->evaluate_block({controls, static_cast<std::size_t>(block.poses), points, answered});
  } catch (const fb::bake::PoseError& error) {
    block.evaluated = backend->evaluated();
    block.failed = error.pose();
    throw fb::Error(error.status(), error.reason());
  } catch (...) {
    block.evaluated = backend->evaluated();
    throw;
  }
  block.evaluated = backend->evaluated();
}

}  // namespace

extern "C" {

void fb_pose_block_fill(fb_pose_block* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

void fb_spreader_fill(fb_spreader* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_source_evaluate_block(fb_source* source, fb_pose_block* block) {
  return abi_guard([&] {
    fb::bake::Source& from = source_of(source, "source");
    require(block, "block");
    if (block->struct_size < sizeof *block)
      fail(Status::invalid_argument, "fb_pose_block: struct_size is %u; fill the struct with fb_pose_block_init first",
           block->struct_size);
    if (!from.live())
      fail(Status::invalid_argument, "\"%s\" is a recording: new poses cannot be evaluated",
           from.schema().name.c_str());
    const Buffers buffers = buffers_of(from, *block);
    block->evaluated = 0;
    block->failed = block->poses;
    std::fill_n(block->answered, block->poses, std::uint8_t{0});
    if (block->poses == 0) return;
    const fb::RigSchema& schema = from.schema();
    const bool apart = !buffers.numbers.empty();
    std::vector<float> apart_points(apart ? block->poses * from.rest().points.size() : 0);
    const std::span<float> points = apart ? std::span(apart_points) : buffers.positions;
    std::vector<char> answered(block->poses);
    const auto hand_over = [&] {
      if (apart) fb::bake::split_carried(schema, from.rest(), points, block->poses, buffers.positions, buffers.numbers);
      std::copy(answered.begin(), answered.end(), block->answered);
    };
    try {
      evaluate_points(from, *block, buffers.controls, points, answered);
    } catch (...) {
      hand_over();
      throw;
    }
    hand_over();
  });
}

fb_status fb_source_spread(fb_source* source, const fb_spreader* spreader, fb_source** spread) {
  return abi_guard([&] {
    fb::bake::Source& from = source_of(source, "source");
    require(spreader, "spreader");
    require(spread, "spread");
    const fb_spreader known = read_struct(*spreader, fb_spreader_init, "fb_spreader");
    if (!known.evaluate) fail(Status::invalid_argument, "fb_spreader: evaluate is null");
    auto owner = std::make_shared<SpreadOwner>(source, known);
    auto made = std::make_unique<fb_source>(
        fb_source{std::make_unique<fb::bake::SpreadSource>(from, known, owner), source->files, source->identity});
    owner->keep();
    *spread = made.release();
  });
}

}  // extern "C"
