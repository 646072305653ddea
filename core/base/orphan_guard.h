#pragma once

#include <sys/types.h>

namespace fb {

// Starts what waits for the end of this process: a process of its own, a shell. Where none can be started, nothing is
// guarded. Called before a child is started, so that no time passes between that and guarding it.
void prepare_guard() noexcept;
// Has a group of processes killed when this process ends, however it ends, unless the group was released before.
void guard_group(pid_t group) noexcept;
// Called before the group's leader is waited for, whose number may then be another's.
void release_group(pid_t group) noexcept;
// Any thread may call all of them.

}  // namespace fb
