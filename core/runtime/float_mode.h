#pragma once

#include <memory>
#include <type_traits>

namespace fb::runtime {

// Implementation of with_float_mode().
void call_with_float_mode(void (*call)(void* work), void* work);

// Calls work() in the runtime's floating-point mode on this thread: round to nearest, denormals kept. The host's mode
// is restored afterwards, also if work() throws. Results would otherwise depend on the host's mode, such as
// flush-to-zero in a game engine. This is the only place where the mode changes: the call goes through a function
// pointer in another translation unit, so the compiler cannot move arithmetic across the change. Allocates nothing.
template <class Work>
void with_float_mode(Work&& work) {
  call_with_float_mode([](void* callable) { (*static_cast<std::remove_reference_t<Work>*>(callable))(); },
                       const_cast<void*>(static_cast<const void*>(std::addressof(work))));
}

}  // namespace fb::runtime
