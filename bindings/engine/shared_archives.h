/** @file
 * Archives that are loaded once, however many characters a host makes of the same bytes: for engines whose resources
 * are no objects that hold a face. C++17, on the public headers alone.
 */
#ifndef FACEBAKER_ENGINE_SHARED_ARCHIVES_H
#define FACEBAKER_ENGINE_SHARED_ARCHIVES_H

#include <facebaker/facebaker.hpp>

#include <cstddef>
#include <memory>
#include <vector>

namespace facebaker::engine {

/** A loaded archive. Immutable. */
struct SharedArchive {
  std::vector<unsigned char> bytes;  ///< what it was loaded from
  Model model;                       ///< the face
};

/** That of these bytes: the same for the same bytes as long as somebody holds it. Thread-safe. Throws Error. */
std::shared_ptr<const SharedArchive> load_shared(const void* bytes, std::size_t size);

}  // namespace facebaker::engine

#endif
