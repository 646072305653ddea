// facebaker: the command line tool.
#include "commands/tool.h"

int main(int argc, char** argv) {
  fb::tool::use_passive_waiting(argv);
  return fb::tool::run_tool(argc, argv);
}
