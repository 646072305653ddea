// Packing an archive anew, without poses and without training: with another licence, or into fewer bytes by larger
// quantisation steps of the basis.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bake/measure/errors.h"
#include "base/progress.h"

namespace fb::bake {

struct RepackOptions {
  std::uint64_t max_bytes = 0;  // of the archive: the smallest steps within them; 0: any
  // Largest displacement of a vertex by this repacking, over D. With max_bytes a limit; alone: the fewest bytes within
  // it. 0: alone, no vertex is displaced; with max_bytes, default_repack_error of the archive.
  double max_error = 0;
  bool force = false;        // where the limits cannot be met, the nearest there is instead of a failure
  std::uint64_t seed = 1;    // of the reference poses of an archive that has none, or whose steps change
  std::string licence = {};  // replaces that of the archive; empty: it stays
  std::string about = {};    // put over what the archive says of the character (about.h); empty: that stays as it is
  std::vector<std::byte> thumbnail = {};  // replaces that of the archive; empty: it stays
  std::string sockets = {};               // a JSON array, added to those of the archive (given_sockets.h); may be empty
};

struct RepackResult {
  std::vector<std::byte> archive;
  std::uint64_t bytes = 0, source_bytes = 0;  // of the archive now, and as it was
  std::uint32_t source_version = 0;           // of the format it was in, major * 1000 + minor
  double factor = 1;                          // of the quantisation steps of the basis
  Errors displacement;                        // of vertices by this repacking, on `displacement.frames` poses
  double max_error = 0;                       // the limit that held, over D; 0: none did
  bool within_limits = true;                  // false only with `force`
};

// Limit of the displacement where only bytes are given, over D: the largest error that the certificate states, less
// what earlier repackings displaced, so that repacking at most doubles the largest error known; 0.01 for an archive
// that states none.
double default_repack_error(const std::string& certificate);

// Reads an archive and packs it anew. Without limits it poses as before, to the last bit; with
// limits the certificate states the displacement (add_requantisation_errors). Displacements are measured with the
// runtime on the rest pose, both ends of all controls and seeded dense poses: harder poses than those of shots. Fails
// with invalid_argument on an error that is negative or not finite; as read_archive does; and, without `force`, with
// limit where max_bytes and the error allowed exclude each other. The message says the fewest bytes within that error,
// and the error within those bytes or of the smallest archive there is.
RepackResult repack(std::span<const std::byte> archive, const RepackOptions& options, Progress& progress);

}  // namespace fb::bake
