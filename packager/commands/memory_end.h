#pragma once

namespace fb::tool {

// From now on, an allocation by `new` that finds no memory ends the program with a message and exit code 1, in place of
// an exception: destructors of the JSON library allocate, and crash or abort while such an exception passes them.
// Outputs stay as they were; what is left beside them is what a killed command leaves, which the next one removes.
void end_where_memory_ends();

}  // namespace fb::tool
