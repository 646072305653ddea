#pragma once

namespace fb::tool {

// Installs signal handlers: the first Ctrl-C (SIGINT), SIGTERM or SIGHUP sets a flag and prints a line; a second one
// ends the program at once. SIGXFSZ is ignored, so that writing beyond the limit on file sizes fails like a full disk.
void watch_interrupts();

// Whether one of them came. Thread-safe.
bool interrupt_requested();

}  // namespace fb::tool
