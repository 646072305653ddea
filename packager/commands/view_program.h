// How `facebaker view` gets its web server.
#pragma once

#include "view/view_server.h"

namespace fb::tool {

// If the command is `view`, has the program facebaker-view beside this one take its place, which has the server.
// Returns where there is none.
void hand_over_view(int argc, char** argv);

// Of a program that has a server: before commands run.
void set_view_server(ServerOpener opener);
// Fails with unsupported where none was set.
std::unique_ptr<ViewServer> open_view_server(int port);

}  // namespace fb::tool
