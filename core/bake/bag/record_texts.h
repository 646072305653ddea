#pragma once

#include <string>

#include "bake/bag/face_record.h"

namespace fb::bake {

// What the archive of a face states of whose it is and what may be done with it, for people.
std::string rights_text(const FaceRecord& face);

// How it was made, and how far it is from what it was made of.
std::string provenance_text(const FaceRecord& face);

}  // namespace fb::bake
