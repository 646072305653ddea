#include "shared_archives.h"

#include <algorithm>
#include <cstring>
#include <mutex>
#include <utility>

namespace facebaker::engine {
namespace {

std::mutex archives_mutex;
std::vector<std::weak_ptr<const SharedArchive>> known_archives;

}  // namespace

std::shared_ptr<const SharedArchive> load_shared(const void* bytes, std::size_t size) {
  const std::lock_guard lock(archives_mutex);
  const auto gone = [](const auto& archive) { return archive.expired(); };
  known_archives.erase(std::remove_if(known_archives.begin(), known_archives.end(), gone), known_archives.end());
  for (const auto& known : known_archives) {
    const std::shared_ptr<const SharedArchive> archive = known.lock();
    if (archive && archive->bytes.size() == size && (size == 0 || std::memcmp(archive->bytes.data(), bytes, size) == 0))
      return archive;
  }
  Model model(bytes, size);
  const auto* first = static_cast<const unsigned char*>(bytes);
  const auto made = std::make_shared<const SharedArchive>(
      SharedArchive{std::vector<unsigned char>(first, first + size), std::move(model)});
  known_archives.push_back(made);
  return made;
}

}  // namespace facebaker::engine
