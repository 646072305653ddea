// Preservation metadata as XML of PREMIS 3.0 (Library of Congress, 2016).
#pragma once

#include <map>
#include <string>
#include <vector>

#include "bake/bag/bag_files.h"
#include "bake/bag/face_record.h"

namespace fb::bake {

// Of the files of a payload: an object with checksum, size and format for each; who made them, when and of what; that
// archives were validated and the bag was made, on `date`, by `software` ("FaceBaker VERSION"); and the rights that
// archives state. Paths within the bag identify objects.
std::string premis_xml(const std::map<std::string, BaggedFile>& files, const std::vector<FaceRecord>& faces,
                       const std::string& date, const std::string& software);

}  // namespace fb::bake
