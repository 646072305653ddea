// The boundary between C++ and C: every exported function that can fail runs inside abi_guard().
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

// Stores the message for fb_last_error() of this thread and returns the status.
fb_status report(Status status, const char* message) noexcept;

// Calls body(); converts any exception to a status and this thread's message.
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

// Fails on a struct that was not initialised. In every version of the headers, structs begin with struct_size and
// another 32-bit number.
inline void require_size(std::uint32_t struct_size, const char* what) {
  if (struct_size < 8)
    fail(Status::invalid_argument, "%s: struct_size is %u; fill the struct with %s_init first", what, struct_size,
         what);
}

// Writes defaults to a caller's struct of struct_size bytes: fields that this library does not know are set to 0, and
// nothing beyond struct_size is written.
template <class Struct>
void fill_struct(Struct* to, std::uint32_t struct_size, Struct defaults) {
  if (!to || struct_size < 8) return;
  defaults.struct_size = struct_size;
  std::memset(static_cast<void*>(to), 0, struct_size);
  std::memcpy(static_cast<void*>(to), &defaults, std::min<std::size_t>(struct_size, sizeof defaults));
}

// The caller's struct in this library's version: defaults for fields that an older caller does not have; fields of a
// newer caller are ignored.
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
