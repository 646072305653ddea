// For vertices of the face, the places of another mesh that mean the same.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "solve/sampled_surface.h"
#include "solve/similarity.h"

namespace fb::tool {

// Why a vertex has no partner that can be believed.
enum class Partner : std::uint8_t {
  found,
  far,     // the other surface is farther away than the bound
  turned,  // it is near, but its normal is more than 60 degrees away: the inside of a lip, the back of a lid
  border,  // the closest point is on an open border: the vertex lies beyond it
};

struct Correspondence {
  std::uint32_t vertex = 0;  // of the face
  SurfacePoint other;        // on the other mesh; of Partner::far, its closest point without regard to normals
  float distance = 0;        // in units of the face, once the other mesh is aligned
  Partner partner = Partner::found;
};

struct CorrespondenceStatistics {
  std::size_t vertices = 0;  // that were asked for
  std::size_t far = 0, turned = 0, border = 0;
  double without = 0;                    // share of the vertices without a partner
  double median = 0, p95 = 0, most = 0;  // distances of the partners found, in units of the face
};

struct CorrespondenceOptions {
  std::vector<std::uint32_t> vertices{};  // of the face; empty: all
  // In units of the face; none: three times the median distance, but at least a hundredth of the face's diagonal.
  std::optional<double> bound{};
  Parallel parallel{};
};

struct MeshCorrespondence {
  std::vector<Correspondence> vertices;  // in the order asked for
  double bound = 0;                      // that was used, in units of the face
  CorrespondenceStatistics statistics;
};

// Closest points of the aligned other mesh with a normal within 60 degrees. Vertices of no polygon have none
// (Partner::turned). Fails with invalid_argument if a vertex is none of the face's.
MeshCorrespondence find_correspondence(const SampledSurface& face, const SampledSurface& other,
                                       const Similarity& to_face, const CorrespondenceOptions& options = {});

// Of what there is in `vertices`.
CorrespondenceStatistics statistics_of(std::span<const Correspondence> vertices);

// Sentences for people, lengths in millimetres where the unit is known: "5,100 of 6,347 vertices have a partner, half
// of them within 0.21 mm, 95 % within 0.8 mm; ...". unit: of the face, such as "cm".
std::string correspondence_text(const MeshCorrespondence& correspondence, const std::string& unit);

}  // namespace fb::tool
