#include "ranks/rank_messages.h"

#include <cstring>
#include <nlohmann/json.hpp>

#include "base/status.h"

namespace fb::tool {
namespace {

using Json = nlohmann::json;

Bytes packed(const Json& json) {
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  const std::span<const std::byte> bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

Json unpacked(std::span<const std::byte> bytes) {
  return Json::parse(reinterpret_cast<const char*>(bytes.data()),
                     reinterpret_cast<const char*>(bytes.data()) + bytes.size());
}

// Before the reason, the flags, the positions and the numbers of an answer.
struct AnswerHeader {
  std::uint64_t poses, evaluated, failed, reason_bytes;
  std::int32_t status;
  std::uint32_t reserved;
};

template <class T>
void append(Bytes& to, std::span<const T> values) {
  const std::size_t size = to.size();
  to.resize(size + values.size_bytes());
  if (!values.empty()) std::memcpy(to.data() + size, values.data(), values.size_bytes());
}

// Copies the next bytes of a message to as many of `to`.
void take(std::span<const std::byte>& from, void* to, std::size_t bytes) {
  if (from.size() < bytes) fail(Status::internal, "a message between ranks ends early");
  if (bytes > 0) std::memcpy(to, from.data(), bytes);
  from = from.subspan(bytes);
}

}  // namespace

Bytes bytes_of(const OpenRequest& request) {
  return packed({{"paths", request.paths},
                 {"workers", request.workers},
                 {"pose_seconds", request.pose_seconds},
                 {"joints", request.joints},
                 {"control_joints", request.control_joints},
                 {"skip_broken", request.skip_broken}});
}

OpenRequest open_request_from(std::span<const std::byte> bytes) {
  const Json json = unpacked(bytes);
  return {json.at("paths"),  json.at("workers"),        json.at("pose_seconds"),
          json.at("joints"), json.at("control_joints"), json.at("skip_broken")};
}

Bytes bytes_of(const OpenAnswer& answer) {
  return packed({{"machine", answer.machine},
                 {"failure", answer.failure},
                 {"identity", answer.identity},
                 {"poses_at_once", answer.poses_at_once}});
}

OpenAnswer open_answer_from(std::span<const std::byte> bytes) {
  const Json json = unpacked(bytes);
  return {json.at("machine"), json.at("failure"), json.at("identity"), json.at("poses_at_once")};
}

PoseSizes sizes_of(const fb_source_info& info) {
  return {info.control_count, std::size_t{3} * info.vertex_count, info.number_count};
}

Bytes evaluate_request(std::uint64_t number, const fb_pose_block& block, const PoseSizes& sizes, std::size_t first,
                       std::size_t count) {
  Bytes bytes = stop_request(number);
  append<float>(bytes, std::span(block.controls + first * sizes.controls, count * sizes.controls));
  return bytes;
}

Bytes stop_request(std::uint64_t number) {
  Bytes bytes;
  append<std::uint64_t>(bytes, std::span(&number, 1));
  return bytes;
}

std::uint64_t block_number(std::span<const std::byte> request) {
  std::uint64_t number;
  take(request, &number, sizeof number);
  return number;
}

BlockAnswer::BlockAnswer(std::span<const std::byte> request, const PoseSizes& sizes) : sizes_(sizes) {
  request = request.subspan(sizeof(std::uint64_t));
  controls_.resize(request.size() / sizeof(float));
  take(request, controls_.data(), request.size());
  const std::size_t poses = controls_.size() / sizes.controls;
  positions_.resize(poses * sizes.positions);
  numbers_.resize(poses * sizes.numbers);
  answered_.resize(poses);
  fb_pose_block_init(&block_);
  block_.poses = poses;
  block_.controls = controls_.data();
  block_.positions = positions_.data();
  block_.channels = numbers_.empty() ? nullptr : numbers_.data();
  block_.answered = answered_.data();
}

Bytes BlockAnswer::bytes(fb_status status, const std::string& reason) const {
  const AnswerHeader header = {block_.poses, block_.evaluated, block_.failed, reason.size(), status, 0};
  Bytes bytes;
  bytes.reserve(sizeof header + reason.size() + answered_.size() +
                sizeof(float) * (positions_.size() + numbers_.size()));
  append<AnswerHeader>(bytes, std::span(&header, 1));
  append<char>(bytes, reason);
  append<std::uint8_t>(bytes, answered_);
  append<float>(bytes, positions_);
  append<float>(bytes, numbers_);
  return bytes;
}

BlockOutcome take_answer(std::span<const std::byte> answer, const PoseSizes& sizes, fb_pose_block& block,
                         std::size_t first, std::size_t count) {
  AnswerHeader header;
  take(answer, &header, sizeof header);
  if (header.poses != count)
    fail(Status::internal, "a rank answers %zu poses with %zu", count, std::size_t{header.poses});
  if (header.reason_bytes > answer.size()) fail(Status::internal, "a message between ranks ends early");
  BlockOutcome outcome = {header.status, header.evaluated, header.failed, std::string(header.reason_bytes, ' ')};
  take(answer, outcome.reason.data(), header.reason_bytes);
  take(answer, block.answered + first, count);
  take(answer, block.positions + first * sizes.positions, count * sizes.positions * sizeof(float));
  if (sizes.numbers > 0) take(answer, block.channels + first * sizes.numbers, count * sizes.numbers * sizeof(float));
  return outcome;
}

}  // namespace fb::tool
