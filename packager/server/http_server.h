#pragma once

#include "view/view_server.h"

namespace fb::tool {

// A ServerOpener, by cpp-httplib.
std::unique_ptr<ViewServer> open_http_server(int port);

}  // namespace fb::tool
