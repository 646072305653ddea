#include "bake/rig/spread_source.h"

#include <algorithm>
#include <array>
#include <utility>

#include "bake/rig/carried_numbers.h"
#include "bake/rig/evaluation_backend.h"
#include "bake/rig/foreign_call.h"
#include "bake/rig/source_rules.h"
#include "base/progress.h"

namespace fb::bake {
namespace {

// Whether the bake is to stop; for fb_callbacks.
std::int32_t ask_to_stop(void* user, const char*, std::uint64_t, std::uint64_t) {
  auto* const progress = static_cast<Progress*>(user);
  try {
    progress->ask();
  } catch (const Error&) {
    return 1;
  }
  return progress->cancelled() ? 1 : 0;
}

class SpreadBackend final : public EvaluationBackend {
 public:
  // `source` is the one that is spread.
  SpreadBackend(const Source& source, const fb_spreader& spreader, Progress* progress)
      : source_(source), spreader_(spreader), progress_(progress) {}
  void evaluate_block(const EvaluationBlock& block) override;
  // The host asks whether to stop while it works; and all that evaluates waits for the last poses of a block.
  double block_seconds() const override { return 4; }
  std::size_t least_poses() const override { return std::max<std::size_t>(1, spreader_.preferred_block); }

 private:
  // Of the answered poses, flags those that keep the rules for points; fails on the first that breaks them.
  // numbers: poses x carried_count().
  void take_points(const fb_pose_block& from, std::span<const float> numbers, const EvaluationBlock& to) const;

  const Source& source_;
  const fb_spreader& spreader_;
  Progress* const progress_;
};

void SpreadBackend::evaluate_block(const EvaluationBlock& block) {
  const RigSchema& schema = source_.schema();
  check_poses(block.controls, schema);
  // With numbers beside them, positions lie closer together than points.
  const std::size_t width = carried_count(schema, source_.rest());
  const bool apart = width > 0;
  std::vector<float> positions(apart ? block.count * source_.rest().surface_points().size() : 0);
  std::vector<float> numbers(block.count * width);
  std::vector<std::uint8_t> answered(block.count);
  fb_pose_block asked = {};
  asked.struct_size = sizeof asked;
  asked.poses = block.count;
  asked.controls = block.controls.data();
  asked.positions = apart ? positions.data() : block.points.data();
  asked.channels = apart ? numbers.data() : nullptr;
  asked.answered = answered.data();
  asked.failed = block.count;
  if (progress_) asked.callbacks = {progress_, ask_to_stop, nullptr};
  std::array<char, 1024> message{};
  const fb_status status = foreign_call("what spreads the rig", [&] {
    return spreader_.evaluate(spreader_.user, &asked, message.data(), static_cast<std::uint32_t>(message.size()));
  });
  message.back() = '\0';
  evaluated_ += asked.evaluated;
  if (status == FB_OK) std::ranges::fill(answered, 1);
  take_points(asked, numbers, block);
  if (status == FB_OK) return;
  const std::string reason = message[0] ? message.data() : format("status %d without a message", status);
  if (status == FB_ERROR_INTERRUPTED) throw Error(Status::interrupted, reason);
  if (asked.failed < block.count) throw PoseError(static_cast<Status>(status), asked.failed, reason);
  throw Error(static_cast<Status>(status), reason);
}

void SpreadBackend::take_points(const fb_pose_block& from, std::span<const float> numbers,
                                const EvaluationBlock& to) const {
  const RigSchema& schema = source_.schema();
  const std::size_t surface = source_.rest().surface_points().size(), size = source_.rest().points.size();
  const std::size_t width = carried_count(schema, source_.rest());
  const double diagonal = source_.rest().diagonal();
  for (std::size_t p = 0; p < to.count; ++p) {
    if (!from.answered[p]) continue;
    const std::span<float> points = to.points.subspan(p * size, size);
    if (width > 0)
      join_carried(schema, source_.rest(), {from.positions + p * surface, surface}, numbers.subspan(p * width, width),
                   1, points);
    if (const auto fault = find_point_fault(points, source_.rest(), diagonal))
      throw PoseError(fault->status, p, format("rig \"%s\": %s", schema.name.c_str(), fault->what.c_str()));
    to.answered[p] = 1;
  }
}

}  // namespace

SpreadSource::SpreadSource(Source& source, const fb_spreader& spreader, std::shared_ptr<const void> owner)
    : SourceDecorator(source), owner_(std::move(owner)), spreader_(spreader) {
  if (!source.live())
    fail(Status::invalid_argument, "\"%s\" is a recording: there is nothing to spread", source.schema().name.c_str());
}

void SpreadSource::read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) {
  if (source().recorded(clip)) return source().read(clip, first, count, points);
  evaluate_clip(*this, clip, first, count, points);
}

void SpreadSource::evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) {
  std::vector<char> answered(count);
  SpreadBackend(source(), spreader_, nullptr).evaluate_block({controls, count, points, answered});
}

std::size_t SpreadSource::preferred_block() const {
  return std::min<std::size_t>(spreader_.preferred_block, most_preferred_poses);
}

std::unique_ptr<EvaluationBackend> SpreadSource::make_backend(const Parallel& parallel) {
  return std::make_unique<SpreadBackend>(source(), spreader_, parallel.progress);
}

}  // namespace fb::bake
