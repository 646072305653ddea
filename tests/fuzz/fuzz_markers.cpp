// Feeds arbitrary bytes to what reads targets of a solve: the first byte says which kind of file the others are.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "fuzz_folder.h"
#include "solve/correspondence_file.h"
#include "solve/marker_file.h"
#include "solve/marker_placement.h"

namespace {

constexpr std::size_t vertices = 100;

void check_take(const fb::tool::MarkerTake& take) {
  const std::size_t places = take.frames * take.markers();
  if (take.frames == 0 || take.markers() == 0 || take.missing.size() != places || take.positions.size() != 3 * places)
    std::abort();
  for (std::size_t i = 0; i < 3 * places; ++i)
    if (!std::isfinite(take.positions[i]) || (take.missing[i / 3] != 0 && take.positions[i] != 0)) std::abort();
  fb::tool::seen_markers(take, fb::tool::fullest_frame(take));
}

void check_point(const fb::tool::SurfacePoint& point) {
  float sum = 0;
  for (const float weight : point.weights) sum += weight;
  if (std::ranges::any_of(point.vertices, [](std::uint32_t v) { return v >= vertices; }) ||
      !(std::abs(sum - 1) < 1e-5f))
    std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  if (size == 0) return 0;
  const auto file = [&](const char* name) { return fuzz::put(name, data + 1, size - 1); };
  fuzz::expect_message([&] {
    switch (data[0]) {
      case 't':
        check_take(fb::tool::read_marker_file(file("take.trc")));
        break;
      case 'c':
        check_take(fb::tool::read_marker_file(file("take.csv")));
        break;
      case 'p':
        for (const auto& marker : fb::tool::read_marker_placement(file("placement.json"), vertices).markers)
          check_point(marker.point);
        break;
      case 'j':
        for (const auto& c : fb::tool::read_correspondence(file("pairs.json"), vertices, vertices))
          check_point(c.other);
        break;
      default:
        break;
    }
  });
  return 0;
}
