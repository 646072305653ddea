#include "base/output_lock.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <fstream>
#include <string>
#include <thread>

#include "base/file.h"
#include "base/replaced_file.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb {
namespace {

constexpr const char* lock_suffix = ".facebaker-lock";
constexpr std::size_t longest_holder = 400;  // bytes

// One line for messages; control characters become spaces.
std::string first_line(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text(longest_holder, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  text.resize(std::min(text.size(), text.find('\n')));
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ' || c == 127) c = ' ';
  return text;
}

// "process 4711 on machine since 2025-01-31 15:05:13 UTC (facebaker bake ...)"
std::string this_process() {
  char machine[256] = {};
  if (::gethostname(machine, sizeof machine - 1) != 0) machine[0] = 0;
  const std::time_t now = std::time(nullptr);
  std::tm parts = {};
  char since[32] = {};
  ::gmtime_r(&now, &parts);
  std::strftime(since, sizeof since, "%Y-%m-%d %H:%M:%S UTC", &parts);
  std::string text = format("process %ld on %s since %s", static_cast<long>(::getpid()), machine, since);
  // Words are separated by zero bytes, which first_line makes spaces of.
  const std::string command = first_line("/proc/self/cmdline");
  if (!command.empty()) text += " (" + command.substr(0, command.find_last_not_of(' ') + 1) + ")";
  return text.substr(0, longest_holder - 1) + "\n";
}

[[noreturn]] void fail_on_holder(const std::filesystem::path& output, const std::filesystem::path& lock,
                                 bool has_locks) {
  std::string holder = first_line(lock);
  // Who has just taken the lock writes its name next.
  for (int tries = 0; holder.empty() && tries < 20; ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    holder = first_line(lock);
  }
  const std::string remedy =
      has_locks ? "" : ". The file system has no locks: if that process has ended, remove " + shown(lock);
  fail(Status::io, "%s: is being written by %s%s", shown(output).c_str(),
       holder.empty() ? "another process" : holder.c_str(), remedy.c_str());
}

LockedFile lock_or_fail(const std::filesystem::path& output, const std::filesystem::path& lock) {
  std::optional<LockedFile> file = LockedFile::open(lock, LockedFile::Missing::create);
  if (!file || (!file->exclusive() && !file->empty())) fail_on_holder(output, lock, !file);
  return std::move(*file);
}

std::filesystem::path in_folder(const std::filesystem::path& folder) {
  make_folder(folder);
  return folder / lock_suffix;
}

}  // namespace

OutputLock::OutputLock(const std::filesystem::path& output, const std::filesystem::path& lock)
    : file_(lock_or_fail(output, lock)) {
  try {
    file_.clear();
    const std::string holder = this_process();
    file_.write(std::as_bytes(std::span(holder)));
  } catch (...) {
    file_.remove();
    throw;
  }
}

OutputLock OutputLock::of_file(const std::filesystem::path& path) {
  std::filesystem::path lock = resolve_links(path);
  return {path, lock += lock_suffix};
}

OutputLock OutputLock::of_folder(const std::filesystem::path& folder) {
  OutputLock lock(folder, in_folder(folder));
  remove_partial_files(folder);
  return lock;
}

void OutputLock::refuse_if_written(const std::filesystem::path& folder) {
  const std::filesystem::path lock = folder / lock_suffix;
  const LockedFile::Held held = LockedFile::held(lock);
  if (held != LockedFile::Held::no) fail_on_holder(folder, lock, held == LockedFile::Held::yes);
}

OutputLock::~OutputLock() {
  file_.remove();
}

}  // namespace fb
