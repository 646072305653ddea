// facebaker: the command line tool.
#include <string_view>

#include "commands/memory_end.h"
#include "commands/tool.h"
#include "commands/view_program.h"

int main(int argc, char** argv) {
  using namespace fb::tool;
  use_passive_waiting(argv);
  // A rig's process answers that a pose failed; facebaker-view refuses a request.
  if (argc < 2 || std::string_view(argv[1]) != "rig-host") end_where_memory_ends();
  hand_over_view(argc, argv);
  return run_tool(argc, argv);
}
