// facebaker: the command line tool.
#include "commands/tool.h"
#include "commands/view_program.h"

int main(int argc, char** argv) {
  fb::tool::use_passive_waiting(argv);
  fb::tool::hand_over_view(argc, argv);
  return fb::tool::run_tool(argc, argv);
}
