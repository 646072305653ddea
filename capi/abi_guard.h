// The crossing from C++ to C: what every exported function that can fail runs inside.
#pragma once

#include <facebaker/facebaker.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <new>

#include "base/status.h"

namespace fb::capi {

// Keeps the message for fb_last_error of this thread and gives the status back.
fb_status report(Status status, const char* message) noexcept;

// Runs body; any exception becomes a status and this thread's message.
template <class Body>
fb_status abi_guard(Body&& body) noexcept {
  try {
    body();
    return FB_OK;
  } catch (const Error& error) {
    return report(error.status(), error.what());
  } catch (const std::bad_alloc&) {
    return report(Status::out_of_memory, "out of memory");
  } catch (const std::exception& error) {
    return report(Status::internal, error.what());
  } catch (...) {
    return report(Status::internal, "an unknown exception");
  }
}

inline void require(const void* pointer, const char* what) {
  if (!pointer) fail(Status::invalid_argument, "%s is null", what);
}

// Structs begin with struct_size and another 32-bit number in every version of the headers.
inline void require_size(std::uint32_t struct_size, const char* what) {
  if (struct_size < 8)
    fail(Status::invalid_argument, "%s: struct_size is %u; fill the struct with %s_init first", what, struct_size,
         what);
}

// Defaults for a caller whose header has a struct of struct_size bytes: nothing beyond them is touched, and what this
// library does not know of them is 0.
template <class Struct>
void fill_struct(Struct* to, std::uint32_t struct_size, Struct defaults) {
  if (!to || struct_size < 8) return;
  defaults.struct_size = struct_size;
  std::memset(static_cast<void*>(to), 0, struct_size);
  std::memcpy(static_cast<void*>(to), &defaults, std::min<std::size_t>(struct_size, sizeof defaults));
}

// What the caller gave, with defaults for the fields an older caller does not know, without those of a newer one.
template <class Struct>
Struct read_struct(const Struct& given, void (*init)(Struct*), const char* what) {
  require_size(given.struct_size, what);
  Struct full;
  init(&full);
  std::memcpy(&full, &given, std::min<std::size_t>(given.struct_size, sizeof full));
  full.struct_size = sizeof full;
  return full;
}

}  // namespace fb::capi
