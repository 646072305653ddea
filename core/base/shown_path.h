// Paths and other long texts in messages: a message has room for its reason whatever it names.
#pragma once

#include <concepts>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/status.h"

namespace fb {

// The text as visible_text.h makes it, or if that has more than 240 bytes its beginning and end with "..." between
// them. UTF-8 characters stay whole.
std::string shown(std::string_view text);
template <std::same_as<std::filesystem::path> Path>
std::string shown(const Path& path) {
  const std::u8string text = path.u8string();
  return shown(std::string_view(reinterpret_cast<const char*>(text.data()), text.size()));
}

// Fails with a message about a file: the reason, then the path as shown.
[[noreturn]] void fail_on(const std::filesystem::path& path, Status status, const std::string& reason);

// Calls work() and adds the path to the message of an Error, as fail_on() does.
template <class Work>
auto with_path(const std::filesystem::path& path, Work&& work) {
  try {
    return work();
  } catch (const Error& error) {
    fail_on(path, error.status(), error.what());
  }
}

}  // namespace fb
