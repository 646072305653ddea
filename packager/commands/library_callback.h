// What functions of the tool that the library calls answer it.
#pragma once

#include <cstdint>
#include <exception>
#include <facebaker/facebaker.hpp>
#include <new>
#include <string_view>

#include "base/status.h"

namespace fb::tool {

// Does the work of such a function: FB_OK, or the status of what it throws with its reason in `message`, as the
// library's headers ask for, so that no exception goes through C.
template <class Work>
fb_status answer_library(char* message, std::uint32_t message_size, const Work& work) {
  const auto failed = [&](fb_status status, std::string_view reason) {
    if (message_size > 0) message[reason.copy(message, message_size - 1)] = '\0';
    return status;
  };
  try {
    work();
    return FB_OK;
  } catch (const facebaker::Error& error) {
    return failed(error.status(), error.what());
  } catch (const Error& error) {
    return failed(static_cast<fb_status>(error.status()), error.what());
  } catch (const std::bad_alloc&) {
    return failed(FB_ERROR_OUT_OF_MEMORY, "out of memory");
  } catch (const std::exception& error) {
    return failed(FB_ERROR_INTERNAL, error.what());
  }
}

}  // namespace fb::tool
