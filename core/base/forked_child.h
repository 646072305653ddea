#pragma once

#include <cstddef>

namespace fb {

// Whether this process was forked and has not called exec() since. Runtimes of OpenMP keep threads, and locks, which
// such a process has lost; who had them made, this library, another copy of it or the host, cannot be known, nor when.
// Where it cannot be known whether the process was forked before this library was loaded, it says yes.
bool in_forked_child();

// As many workers as OpenMP has by default in a new process: OMP_NUM_THREADS, or the processors it may use.
std::size_t workers_by_environment();

}  // namespace fb
