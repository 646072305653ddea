#include "bake/rig_process/rig_host.h"

#include <string.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <optional>

#include "bake/rig_process/rig_messages.h"
#include "base/checked.h"

namespace fb::bake {
namespace {

void write_message(int descriptor, const RigMessage& message) {
  const std::vector<std::byte> bytes = bytes_of(message);
  for (std::size_t sent = 0; sent < bytes.size();) {
    const ssize_t wrote = ::write(descriptor, bytes.data() + sent, bytes.size() - sent);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0) fail(Status::io, "descriptor %d cannot be written: %s", descriptor, ::strerror(errno));
    sent += static_cast<std::size_t>(wrote);
  }
}

// The next message; nothing at the end of the requests.
std::optional<RigMessage> read_message(int descriptor, MessageReader& reader) {
  std::array<std::byte, 1 << 16> bytes;
  while (const std::size_t wanted = reader.wanted()) {
    const ssize_t got = ::read(descriptor, bytes.data(), std::min(bytes.size(), wanted));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(Status::io, "descriptor %d cannot be read: %s", descriptor, ::strerror(errno));
    if (got == 0 && !reader.begun()) return std::nullopt;
    if (got == 0) fail(Status::rig, "the requests end within a message");
    reader.take(std::span(bytes).first(static_cast<std::size_t>(got)));
  }
  return reader.release();
}

RigMessage evaluate(Source& rig, const RigMessage& request) {
  const std::vector<float> controls = poses_of(request, rig.schema().control_count());
  const std::size_t poses = controls.size() / rig.schema().control_count();
  std::vector<float> points(checked_multiply(poses, rig.rest().points.size(), "poses x 3 x vertices"));
  try {
    rig.evaluate(controls, poses, points);
  } catch (const PoseError& error) {
    return error_answer({error.pose(), error.reason()});
  } catch (const Error& error) {
    return error_answer({std::nullopt, error.what()});
  }
  return points_answer(rig, points, poses);
}

}  // namespace

void serve_rig(Source& rig, int requests, int answers) {
  if (!rig.live())
    return refuse_to_serve(format("\"%s\" is a recording, which has no new poses", rig.schema().name.c_str()), answers);
  MessageReader reader;
  while (const auto request = read_message(requests, reader)) {
    switch (request_of(*request)) {
      case RigRequest::hello:
        write_message(answers, hello_answer(rig));
        break;
      case RigRequest::evaluate:
        write_message(answers, evaluate(rig, *request));
        break;
      case RigRequest::bye:
        return;
    }
  }
}

void refuse_to_serve(const std::string& reason, int answers) {
  write_message(answers, error_answer({std::nullopt, reason}));
}

}  // namespace fb::bake
