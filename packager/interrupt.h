#pragma once

namespace fb {

// From now on the first Ctrl-C (SIGINT) only raises a flag and says so; a second one ends the program at once.
void watch_interrupts();

// True once Ctrl-C was pressed. Callable from any thread.
bool interrupt_requested();

}  // namespace fb
