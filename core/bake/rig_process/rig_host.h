// The child's end of the rig protocol.
#pragma once

#include <string>

#include "bake/rig/source.h"

namespace fb::bake {

// Answers the requests that come from one descriptor on another, until bye or the end of the requests. Poses are
// evaluated on the calling thread. A pose that fails is told to the parent, and so is a source that is not live. Fails
// with rig on what is no request, with io where a descriptor cannot be read or written.
void serve_rig(Source& rig, int requests, int answers);

// Tells the parent why there is no rig. Fails with io.
void refuse_to_serve(const std::string& reason, int answers);

}  // namespace fb::bake
