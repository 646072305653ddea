#pragma once

#include <cxxabi.h>

#include <exception>
#include <string>
#include <typeinfo>
#include <utility>

#include "base/status.h"

namespace fb::bake {

// Calls code that is not ours, such as a rig's. Whatever it throws becomes Error(rig), whose message begins with
// `what`: "the rig threw an exception: no licence".
template <class Work>
auto foreign_call(const char* what, Work&& work) {
  try {
    return work();
#ifdef __GLIBCXX__  // libc++ has no name for it
  } catch (const abi::__forced_unwind&) {
    throw;  // the thread is being cancelled
#endif
  } catch (const std::exception& error) {
    fail(Status::rig, "%s threw an exception: %s", what, error.what());
  } catch (...) {
    const std::type_info* const type = abi::__cxa_current_exception_type();
    fail(Status::rig, "%s threw an exception that has no message (C++ type %s)", what, type ? type->name() : "unknown");
  }
}

}  // namespace fb::bake
