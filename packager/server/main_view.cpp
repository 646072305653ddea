// facebaker-view: the tool with a web server, which `facebaker view` becomes.
#include "commands/tool.h"
#include "commands/view_program.h"
#include "server/http_server.h"

int main(int argc, char** argv) {
  fb::tool::use_passive_waiting(argv);
  fb::tool::set_view_server(fb::tool::open_http_server);
  return fb::tool::run_tool(argc, argv);
}
