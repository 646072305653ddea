#pragma once

namespace fb::tool {

// From now on the first Ctrl-C (SIGINT), SIGTERM or SIGHUP only raises a flag and says so; a second one ends the
// program at once. Writing beyond the limit on a file's size fails like writing to a full disk.
void watch_interrupts();

// True once one of them came. Callable from any thread.
bool interrupt_requested();

}  // namespace fb::tool
