// The messages of the rig protocol (docs/rig-protocol.md) as bytes, for both of its ends.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bake/rig/rig_description.h"
#include "bake/rig/source.h"

namespace fb::bake {

inline constexpr std::uint64_t rig_protocol_version = 1;
// Where a child finds its two pipes, unless the environment says otherwise, and the variables that say so.
inline constexpr int rig_requests_descriptor = 3, rig_answers_descriptor = 4;
inline constexpr const char *rig_requests_variable = "FACEBAKER_RIG_REQUESTS",
                            *rig_answers_variable = "FACEBAKER_RIG_ANSWERS";

// A line of JSON and numbers.
struct RigMessage {
  std::string text;
  std::vector<std::byte> data;
};

std::vector<std::byte> bytes_of(const RigMessage& message);

// Puts a message together from bytes as they come, from anyone: memory grows with what has come, not with what is
// announced. Fails with rig, naming the byte of the stream, on what is no message or is too long.
class MessageReader {
 public:
  // Bytes that are still wanted: to the end of the header, then to that of the message. 0: release() it.
  std::size_t wanted() const;
  // At most wanted() bytes.
  void take(std::span<const std::byte> bytes);
  // The message; the reader begins the next one.
  RigMessage release();
  // Data bytes that a message may have from now on.
  void limit_data(std::uint64_t bytes) { most_data_ = bytes; }
  // Whether a message has begun.
  bool begun() const { return header_bytes_ > 0; }

 private:
  void read_header();

  std::array<std::byte, 16> header_{};
  std::size_t header_bytes_ = 0;
  std::uint64_t text_size_ = 0, data_size_ = 0;
  std::uint64_t most_data_ = std::uint64_t{1} << 32;
  std::uint64_t position_ = 0;  // of the message in the stream
  RigMessage message_;
};

// What a parent asks.
RigMessage hello_request();
RigMessage evaluate_request(std::span<const float> controls, std::size_t poses);
RigMessage bye_request();

enum class RigRequest { hello, evaluate, bye };
// Which of these a message is; fails with rig on another, or another version.
RigRequest request_of(const RigMessage& message);
// The poses of an evaluate request; fails with rig unless they are as many as it says.
std::vector<float> poses_of(const RigMessage& request, std::size_t controls);

// What a child answers: what it is, points of all poses, or why not.
struct RigFailure {
  std::optional<std::size_t> pose;  // within the request; none: not known
  std::string reason;
};

RigMessage hello_answer(const Source& rig);
RigMessage points_answer(const Source& rig, std::span<const float> points, std::size_t poses);
RigMessage error_answer(const RigFailure& failure);

// What a child says that it is: checked as every source is. Fails with rig or not_finite, naming field or clip.
RigDescription description_of(const RigMessage& answer);
// The floats that a pose has in an answer.
std::size_t answer_floats(const RigDescription& rig);
// Fills the points of so many poses, or returns why there are none. Fails with rig, saying what is wrong with the
// message.
std::optional<RigFailure> read_answer(const RigMessage& answer, const RigDescription& rig, std::size_t poses,
                                      std::span<float> points);

}  // namespace fb::bake
