// What the reader makes of an archive, for tests.
#pragma once

#include <doctest/doctest.h>

#include <span>
#include <string>

#include "archive/reader.h"
#include "base/status.h"

namespace fb {
using namespace archive;

struct Outcome {
  Status status = Status::ok;
  std::string message;
};

inline Outcome outcome(std::span<const std::byte> bytes, const ReadLimits& limits = {}) {
  try {
    read_archive(bytes, limits);
    return {};
  } catch (const Error& error) {
    return {error.status(), error.what()};
  }
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

inline void check_refused(std::span<const std::byte> bytes, Status status, const std::string& part,
                          const ReadLimits& limits = {}) {
  const Outcome seen = outcome(bytes, limits);
  CHECK_MESSAGE(seen.status == status, "status " << static_cast<int>(seen.status) << ": " << seen.message);
  CHECK_MESSAGE(contains(seen.message, part), seen.message);
}

}  // namespace fb
