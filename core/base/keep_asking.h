#pragma once

#include <functional>

#include "base/parallel.h"
#include "base/progress.h"

namespace fb {

// Calls work(), which cannot ask the progress itself, on a thread of its own, and asks ten times a second meanwhile.
// Returns when the work is done; throws what it throws, or Error(interrupted) after it if the user asked to stop. Where
// no thread can be made, the work is done on this one. Loops of the work must not ask the progress themselves: see
// without_asking.
void keep_asking(Progress& progress, const std::function<void()>& work);

// The same setting for loops inside such work.
inline Parallel without_asking(Parallel parallel) {
  parallel.progress = nullptr;
  return parallel;
}

// The same for work with a result.
template <class Work>
auto ask_during(Progress& progress, Work&& work) {
  decltype(work()) result;
  keep_asking(progress, [&] { result = work(); });
  return result;
}

}  // namespace fb
