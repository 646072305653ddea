#include "commands/view_program.h"

#include <unistd.h>

#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/status.h"

namespace fb::tool {
namespace {

ServerOpener& server_opener() {
  static ServerOpener opener;
  return opener;
}

}  // namespace

void hand_over_view(int argc, char** argv) {
  if (argc < 2 || std::string_view(argv[1]) != "view") return;
  std::error_code unknown;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", unknown).replace_filename("facebaker-view");
  ::execv(program.c_str(), argv);
}

void set_view_server(ServerOpener opener) {
  server_opener() = std::move(opener);
}

std::unique_ptr<ViewServer> open_view_server(int port) {
  if (!server_opener())
    fail(Status::unsupported,
         "there is no program facebaker-view beside this one, which has the web server: it is built where "
         "libmicrohttpd is");
  return server_opener()(port);
}

}  // namespace fb::tool
