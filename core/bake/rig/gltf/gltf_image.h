#pragma once

#include <cstddef>

#include "bake/rig/gltf/gltf_file.h"
#include "model/character.h"

namespace fb::bake {

// An image of the file as the picture file it is, from a buffer view, a data URI or a file beside, with the media type
// that its bytes show; that is empty if they are no PNG, JPEG, KTX2 or WebP. Fails, naming the image, where there is
// none.
Image read_gltf_image(const GltfFile& file, std::size_t index);

}  // namespace fb::bake
