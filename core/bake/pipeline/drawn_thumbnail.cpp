#include "bake/pipeline/drawn_thumbnail.h"

#include <algorithm>

#include "bake/pipeline/repack.h"
#include "base/keep_asking.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// Empty: there is none.
std::vector<std::byte> draw(std::span<const std::byte> archive, const BakeOptions& options, Progress& progress) {
  RepackOptions with;
  with.thumbnail = ask_during(progress, [&] { return options.draw_thumbnail(archive); });
  if (with.thumbnail.empty()) return {};
  check_thumbnail(with.thumbnail);
  std::vector<std::byte> packed =
      ask_during(progress, [&] { return repack(archive, with, silent_progress()).archive; });
  if (options.max_bytes > 0 && packed.size() > options.max_bytes)
    fail(Status::limit, "with its %zu bytes the archive has %zu, more than the %llu asked for", with.thumbnail.size(),
         packed.size(), static_cast<unsigned long long>(options.max_bytes));
  return packed;
}

}  // namespace

std::uint64_t drawn_thumbnail_bytes(std::uint64_t max_bytes) {
  // The tool's have 2 to 7 KB of faces of clay, 20 KB with textures, and 38 KB at most.
  return std::min<std::uint64_t>(std::clamp<std::uint64_t>(max_bytes / 24, 8 << 10, 40 << 10), max_bytes / 4);
}

std::vector<std::byte> with_drawn_thumbnail(std::vector<std::byte> archive, const BakeOptions& options,
                                            Progress& progress) {
  if (!options.draw_thumbnail || !options.thumbnail.empty()) return archive;
  try {
    std::vector<std::byte> packed = draw(archive, options, progress);
    return packed.empty() ? archive : packed;
  } catch (const Error& error) {
    if (error.status() == Status::interrupted || error.status() == Status::out_of_memory) throw;
    progress.note(format("the archive has no thumbnail: %s", error.what()));
    return archive;
  }
}

}  // namespace fb::bake
