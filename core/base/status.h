// Failures: core code throws Error; only capi converts it to the status codes of facebaker.h.
#pragma once

#include <cstdint>
#include <exception>
#include <string>
#include <utility>

namespace fb {

// The numbers of FB_OK, FB_ERROR_... in facebaker.h (a test compares them).
enum class Status : std::int32_t {
  ok = 0,
  invalid_argument = 1,  // null pointer, wrong buffer size, value of the wrong kind
  not_found = 2,         // no such file, control, clip or recipe
  io = 3,                // the system refused a read or a write; disk full
  not_an_archive = 4,    // the file is not an .fbk at all
  corrupt = 5,           // an .fbk that is truncated or damaged
  unsupported = 6,       // an .fbk (or ABI) newer than this library
  limit = 7,             // beyond a limit the caller set
  out_of_memory = 8,
  not_finite = 9,  // NaN or infinity where a finite number is required
  bad_data = 10,   // an inconsistent dataset or mesh
  rig = 11,        // a rig plugin failed or broke its contract
  interrupted = 12,
  internal = 13,
};

class Error : public std::exception {
 public:
  Error(Status status, std::string message) : status_(status), message_(std::move(message)) {}
  Status status() const noexcept { return status_; }
  const char* what() const noexcept override { return message_.c_str(); }

 private:
  Status status_;
  std::string message_;
};

// printf to a string.
[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...);

// Throws Error with a printf-style message that names the fault and its place.
[[noreturn]] [[gnu::format(printf, 2, 3)]] void fail(Status status, const char* pattern, ...);

// Calls work() and prefixes the message of an Error with "where: ", such as the path of the file being read.
template <class Work>
auto with_context(const std::string& where, Work&& work) {
  try {
    return work();
  } catch (const Error& error) {
    throw Error(error.status(), where + ": " + error.what());
  }
}

}  // namespace fb
