// The C headers compile as C++, and the numbers the core throws are those the ABI pins.
#include <facebaker/facebaker.h>
#include <facebaker/facebaker_bake.h>

#include "base/status.h"

using fb::Status;

constexpr bool same(Status status, fb_status number) {
  return static_cast<fb_status>(status) == number;
}

static_assert(same(Status::ok, FB_OK) && same(Status::invalid_argument, FB_ERROR_INVALID_ARGUMENT) &&
              same(Status::not_found, FB_ERROR_NOT_FOUND) && same(Status::io, FB_ERROR_IO) &&
              same(Status::not_an_archive, FB_ERROR_NOT_AN_ARCHIVE) && same(Status::corrupt, FB_ERROR_CORRUPT) &&
              same(Status::unsupported, FB_ERROR_UNSUPPORTED) && same(Status::limit, FB_ERROR_LIMIT) &&
              same(Status::out_of_memory, FB_ERROR_OUT_OF_MEMORY) && same(Status::not_finite, FB_ERROR_NOT_FINITE) &&
              same(Status::bad_data, FB_ERROR_BAD_DATA) && same(Status::rig, FB_ERROR_RIG) &&
              same(Status::interrupted, FB_ERROR_INTERRUPTED) && same(Status::internal, FB_ERROR_INTERNAL));
