#pragma once

#include "base/open_descriptor.h"

namespace fb::tool {

// A socket that listens on a port of 127.0.0.1; `port` 0: any that is free, and set to it. Fails with io, naming the
// port, where it is taken.
OpenDescriptor listen_here(int& port);

}  // namespace fb::tool
