// How core code reports failure: it throws Error; only capi turns that into the status codes of facebaker.h.
#pragma once

#include <cstdint>
#include <exception>
#include <string>
#include <utility>

namespace fb {

// Same numbers as FB_OK, FB_ERROR_... in facebaker.h (a test compares them).
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
  not_finite = 9,  // NaN or infinity where a number is needed
  bad_data = 10,   // a dataset or mesh that contradicts itself
  rig = 11,        // a rig plugin failed or lied
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

// printf into a string.
[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...);

// Throws Error with a printf-style message that names what is wrong and where.
[[noreturn]] [[gnu::format(printf, 2, 3)]] void fail(Status status, const char* pattern, ...);

// Calls work() and puts "where: " before what it complains about: the file whose bytes were looked at.
template <class Work>
auto with_context(const std::string& where, Work&& work) {
  try {
    return work();
  } catch (const Error& error) {
    throw Error(error.status(), where + ": " + error.what());
  }
}

}  // namespace fb
