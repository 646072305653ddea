// The picture of a baked face, which a host draws.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bake/recipe/bake_options.h"
#include "base/progress.h"

namespace fb::bake {

// Bytes of BakeOptions::max_bytes that are left free for a drawn thumbnail.
std::uint64_t drawn_thumbnail_bytes(std::uint64_t max_bytes);

// A finished archive with the thumbnail that options.draw_thumbnail draws of it, unless one is given. A picture is not
// worth a bake: where drawing fails, or the archive would then be longer than max_bytes, it stays as it is, with a note
// that says why. Fails with interrupted and out_of_memory alone, after which the same bake goes on.
std::vector<std::byte> with_drawn_thumbnail(std::vector<std::byte> archive, const BakeOptions& options,
                                            Progress& progress);

}  // namespace fb::bake
