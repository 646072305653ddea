// The whole tool, for the programs that are it: facebaker and facebaker-mpi.
#pragma once

namespace fb::tool {

// Threads that spin while they wait for each other make training several times slower as soon as anything else runs on
// the machine. OpenMP reads its wait policy when it is loaded, so this sets it and has the program execute itself
// again, once. To be called first.
void use_passive_waiting(char** argv);

// Parses the command line and runs a command; returns the exit code. What fails is told on standard error.
int run_tool(int argc, char** argv);

}  // namespace fb::tool
