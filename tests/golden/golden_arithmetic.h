#pragma once

#include "archive/archive_editor.h"

namespace fb {

// An archive that holds rules of the arithmetic which faces of an ordinary size hardly meet.
Bytes archive_of_arithmetic();

}  // namespace fb
