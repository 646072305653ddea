#include "solve/marker_placement.h"

#include <algorithm>
#include <cmath>

#include "base/file.h"
#include "base/length_units.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "solve/surface_point_json.h"
#include "solve/take_builder.h"

namespace fb::tool {
namespace {

constexpr std::uint64_t most_placement_bytes = std::uint64_t{16} << 20;

void check_frame(const MarkerTake& take, std::size_t frame) {
  if (frame >= take.frames)
    fail(Status::invalid_argument, "frame %zu of the markers: they have %zu, counted from 0", frame, take.frames);
}

}  // namespace

std::vector<Vector3> seen_markers(const MarkerTake& take, std::size_t frame) {
  check_frame(take, frame);
  std::vector<Vector3> seen;
  for (std::size_t m = 0; m < take.markers(); ++m)
    if (take.missing_of(frame)[m] == 0) seen.push_back(vector_at(take.positions_of(frame).data(), m));
  return seen;
}

std::size_t fullest_frame(const MarkerTake& take) {
  std::size_t fullest = 0;
  std::ptrdiff_t least = PTRDIFF_MAX;
  for (std::size_t frame = 0; frame < take.frames; ++frame) {
    const std::ptrdiff_t missing = std::ranges::count(take.missing_of(frame), 1);
    if (missing >= least) continue;
    least = missing;
    fullest = frame;
  }
  return fullest;
}

MarkerPlacement place_markers(const MarkerTake& take, std::size_t frame, const Similarity& to_face,
                              const SampledSurface& face, double bound, const std::string& unit) {
  check_frame(take, frame);
  MarkerPlacement placement;
  for (std::size_t m = 0; m < take.markers(); ++m) {
    const std::string name = shown(take.names[m]);
    if (take.missing_of(frame)[m] != 0) {
      placement.notes.push_back(
          format("the marker \"%s\" is not seen in the neutral frame: it has no place on the face", name.c_str()));
      continue;
    }
    const auto closest = face.tree.closest(to_face(vector_at(take.positions_of(frame).data(), m)));
    if (!closest || closest->distance > bound) {
      placement.notes.push_back(
          format("the marker \"%s\" is %s away from the face in the neutral frame: it has no "
                 "place on it",
                 name.c_str(), closest ? length_text(closest->distance, unit).c_str() : "infinitely"));
      continue;
    }
    placement.markers.push_back({take.names[m], closest->surface, closest->distance});
  }
  return placement;
}

MarkerPlacement read_marker_placement(const std::filesystem::path& path, std::size_t vertex_count) {
  const nlohmann::json document = read_json_document(path, most_placement_bytes);
  return with_context(shown(path), [&] {
    const auto markers = document.is_object() ? document.find("markers") : document.end();
    if (markers == document.end() || !markers->is_object())
      fail(Status::bad_data, "there is no object \"markers\" that says where each marker sits");
    if (markers->size() > most_markers)
      fail(Status::limit, "%zu markers; at most %zu are read", markers->size(), most_markers);
    MarkerPlacement placement;
    for (const auto& [name, place] : markers->items())
      with_context(format("marker \"%s\"", shown(name).c_str()), [&, &name = name, &place = place] {
        if (!place.is_object() || !place.contains("vertices")) fail(Status::bad_data, "there is no \"vertices\"");
        const nlohmann::json none;
        placement.markers.push_back(
            {name,
             surface_point_of(place["vertices"], place.contains("weights") ? place["weights"] : none, vertex_count),
             0});
      });
    if (placement.markers.empty()) fail(Status::bad_data, "\"markers\" is empty");
    return placement;
  });
}

void write_marker_placement(const std::filesystem::path& path, const MarkerPlacement& placement,
                            const std::string& unit) {
  const std::optional<double> metres = metres_per(unit);
  std::string text = "{\"markers\": {";
  for (const PlacedMarker& marker : placement.markers) {
    nlohmann::ordered_json place = {{"vertices", marker.point.vertices}, {"weights", weights_json(marker.point)}};
    if (metres) place["distance_mm"] = std::round(double(marker.distance) * *metres * 1e6) / 1e3;
    text += &marker == placement.markers.data() ? "\n  " : ",\n  ";
    text += nlohmann::json(marker.name).dump() + ": " + place.dump();
  }
  write_file(path, text + "\n}}\n");
}

}  // namespace fb::tool
