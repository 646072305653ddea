// Where markers sit on the face: found for a neutral frame, and in files.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/file.h"
#include "base/random.h"
#include "base/status.h"
#include "head_meshes.h"
#include "render/png_file.h"
#include "solve/fit_picture.h"
#include "solve/marker_placement.h"
#include "solve/mesh_alignment.h"
#include "temporary_folder.h"

using namespace fb;
using namespace fb::tool;
using namespace fb::test;

namespace test_marker_placement {

const SampledSurface& face() {
  static const SampledSurface surface(sample_head().view(), 1500);
  return surface;
}

constexpr double height = 0.15;  // centimetres: of the middle of a marker of 3 mm

// Points of the front of the face, spread over it, off the skin as markers are.
std::vector<Vector3> markers_on_face(std::size_t count) {
  std::vector<Vector3> markers;
  const SurfaceSamples samples = sample_surface(face().points, face().triangles, 80 * count);
  const float half = 0.5f * (face().box.low.z + face().box.high.z);
  const float tall = face().box.high.y - face().box.low.y, low = face().box.low.y + 0.25f * tall,
              high = face().box.low.y + 0.75f * tall;
  for (std::size_t i = 0; i < samples.points.size() && markers.size() < count; i += 7) {
    const Vector3 p = samples.points[i], n = samples.normals[i];
    if (p.z < half || p.y < low || p.y > high || n.z < 0.3f) continue;
    markers.push_back(p + n * float(height));
  }
  return markers;
}

// Z up, looking along -y, in millimetres, as a capture volume may have it.
const Similarity volume = {{1, 0, 0, 0, 0, -1, 0, 1, 0}, 10, {200, 100, 1500}};

MarkerTake take_of(const std::vector<Vector3>& markers) {
  MarkerTake take;
  take.metres_per_unit = 0.001;
  take.frames = 1;
  for (std::size_t i = 0; i < markers.size(); ++i) {
    take.names.push_back("m" + std::to_string(i));
    const Vector3 p = volume(markers[i]);
    take.positions.insert(take.positions.end(), {p.x, p.y, p.z});
    take.missing.push_back(0);
  }
  return take;
}

double off_by(const std::vector<Vector3>& markers, const Similarity& to_face) {
  double most = 0;
  for (const Vector3 p : markers) most = std::max(most, double(length(to_face(volume(p)) - p)));
  return 10 * most;
}

TEST_CASE("markers of a neutral frame find their places on the face") {
  for (const std::size_t count : {std::size_t{24}, std::size_t{40}, std::size_t{120}}) {
    const std::vector<Vector3> markers = markers_on_face(count);
    REQUIRE(markers.size() == count);
    const MarkerTake take = take_of(markers);
    const std::vector<Vector3> seen = seen_markers(take, 0);
    CHECK(likely_metres_per_unit(seen) == 0.001);
    CHECK(likely_metres_per_unit(markers) == 0.01);
    const Alignment known = align_points(seen, face(), "y", height, {.scale = 0.1});
    MESSAGE(count, " markers: off by ", off_by(markers, known.to_face), " mm, rms ", 10 * known.rms, " mm, rival ",
            known.rival);
    CHECK(off_by(markers, known.to_face) < 0.5);
    CHECK(known.rival > 10);
    const Alignment flat = align_points(seen, face(), "y", 0, {.scale = 0.1});
    MESSAGE("as if on the skin: off by ", off_by(markers, flat.to_face), " mm");
    CHECK(off_by(markers, flat.to_face) < 6);
    // Somebody whose face is a tenth smaller than the rig's.
    const Alignment scaled = align_points(seen, face(), "y", height, {.scale = 0.09, .scale_range = 1.25});
    MESSAGE("of another size: off by ", off_by(markers, scaled.to_face), " mm, scale ", scaled.to_face.scale);
    CHECK(off_by(markers, scaled.to_face) < 0.5);
    std::vector<Vector3> noisy = seen;
    Random random(8);
    for (Vector3& p : noisy) p = p + Vector3{random.normal(), random.normal(), random.normal()} * 0.3f;
    const Alignment rough = align_points(noisy, face(), "y", height, {.scale = 0.1});
    MESSAGE("with 0.3 mm of noise: off by ", off_by(markers, rough.to_face), " mm, rms ", 10 * rough.rms, " mm, rival ",
            rough.rival);
    CHECK(off_by(markers, rough.to_face) < 3);
    CHECK(rough.rival > clear_rival);

    const MarkerPlacement placement = place_markers(take, 0, known.to_face, face(), 1, "cm");
    CHECK(placement.notes.empty());
    REQUIRE(placement.markers.size() == count);
    float farthest = 0;
    for (std::size_t i = 0; i < count; ++i)
      farthest = std::max(farthest, length(placement.markers[i].point.at(face().points) - markers[i]));
    CHECK(farthest < 0.2f);
  }
  CHECK_THROWS_AS(align_points(std::span<const Vector3>(), face(), "y", 0, {.scale = 1}), Error);
}

TEST_CASE("markers that are not seen, or far from the face, have no place") {
  MarkerTake take = take_of(markers_on_face(12));
  take.missing[3] = 1;
  take.positions[3 * 5 + 1] -= 500;
  const MarkerPlacement placement = place_markers(take, 0, volume.inverse(), face(), 1, "cm");
  CHECK(placement.markers.size() == 10);
  REQUIRE(placement.notes.size() == 2);
  CHECK(placement.notes[0] == "the marker \"m3\" is not seen in the neutral frame: it has no place on the face");
  CHECK(placement.notes[1].find("the marker \"m5\" is ") == 0);
  CHECK(placement.notes[1].find(" mm away from the face in the neutral frame") != std::string::npos);
  CHECK(seen_markers(take, 0).size() == 11);
  CHECK_THROWS_WITH_AS(seen_markers(take, 1), "frame 1 of the markers: they have 1, counted from 0", Error);

  take.frames = 3;
  take.positions.resize(3 * take.positions.size());
  take.missing.resize(36, 0);
  take.missing[12] = 1;
  CHECK(fullest_frame(take) == 2);
}

TEST_CASE("a placement is written and read again") {
  const Folder folder;
  MarkerPlacement placement;
  placement.markers = {{"brow \"l\"", {{1, 2, 3}, {0.25f, 0.25f, 0.5f}}, 0.15f},
                       {"nez\xc3\xa9", {{7, 8, 9}, {1, 0, 0}}, 0}};
  write_marker_placement(folder / "at.json", placement, "cm");
  const std::vector<std::byte> bytes = read_file(folder / "at.json");
  CHECK(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()) ==
        "{\"markers\": {\n"
        "  \"brow \\\"l\\\"\": {\"vertices\":[1,2,3],\"weights\":[0.25,0.25,0.5],\"distance_mm\":1.5},\n"
        "  \"nez\xc3\xa9\": {\"vertices\":[7,8,9],\"weights\":[1.0,0.0,0.0],\"distance_mm\":0.0}\n"
        "}}\n");
  const MarkerPlacement again = read_marker_placement(folder / "at.json", 10);
  REQUIRE(again.markers.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(again.markers[i].name == placement.markers[i].name);
    CHECK(again.markers[i].point == placement.markers[i].point);
  }
  CHECK(folder.entries() == 1);

  write_file(folder / "short.json",
             R"({"markers": {"a": {"vertices": [4]}, "b": {"vertices": [1, 2], "weights": [0.3, 0.7005]}}})");
  const MarkerPlacement few = read_marker_placement(folder / "short.json", 10);
  CHECK(few.markers[0].point.vertices == std::array<std::uint32_t, 3>{4, 4, 4});
  CHECK(few.markers[0].point.weights == std::array<float, 3>{1, 0, 0});
  CHECK(few.markers[1].point.weights[0] + few.markers[1].point.weights[1] == doctest::Approx(1));
}

TEST_CASE("a bad placement is refused with the marker and the reason") {
  const Folder folder;
  const auto fault = [&](const std::string& text) -> std::string {
    write_file(folder / "at.json", text);
    try {
      read_marker_placement(folder / "at.json", 10);
      return "";
    } catch (const Error& error) {
      const std::string message = error.what(), path = (folder / "at.json").string() + ": ";
      return message.find(path) == 0 ? message.substr(path.size()) : "no path: " + message;
    }
  };
  const auto marker = [&](const std::string& place) { return fault("{\"markers\": {\"m\": " + place + "}}"); };
  CHECK(fault("{").find("no JSON: ") == 0);
  CHECK(fault(std::string(100, '[')).find("no path") == std::string::npos);
  CHECK(fault("1e999").find("no JSON: ") == 0);
  CHECK(fault("[]") == "there is no object \"markers\" that says where each marker sits");
  CHECK(fault("{\"markers\": {}}") == "\"markers\" is empty");
  CHECK(marker("3") == "marker \"m\": there is no \"vertices\"");
  CHECK(marker("{\"vertices\": []}") == "marker \"m\": \"vertices\" is no list of one to three vertices");
  CHECK(marker("{\"vertices\": [1, -2, 3]}") == "marker \"m\": \"vertices\" has -2, no number of a vertex");
  CHECK(marker("{\"vertices\": [1, 2, 3]}") ==
        "marker \"m\": \"weights\" is no list of a number for each of the 3 vertices");
  CHECK(marker("{\"vertices\": [1, 2], \"weights\": [1, \"x\"]}") == "marker \"m\": \"weights\" has \"x\", no number");
  CHECK(marker("{\"vertices\": [1, 10], \"weights\": [1, 0]}") ==
        "marker \"m\": vertex 10, while there are 10, counted from 0");
  CHECK(marker("{\"vertices\": [1, 2], \"weights\": [1, 1]}") == "marker \"m\": the weights sum to 2, not to 1");
  CHECK(marker("{\"vertices\": [1, 2], \"weights\": [1e300, 4]}") ==
        "marker \"m\": the weight 1e+300 is not from -1 to 2");
  CHECK(marker("{\"vertices\": [1, 2], \"weights\": [-3, 4]}") == "marker \"m\": the weight -3 is not from -1 to 2");
}

TEST_CASE("the picture shows where markers sit") {
  const std::vector<Vector3> markers = markers_on_face(60);
  const MarkerTake take = take_of(markers);
  const MarkerPlacement placement = place_markers(take, 0, volume.inverse(), face(), 1, "cm");
  const FitPictureOptions options = {.unit = "cm"};
  const Image image = draw_marker_fit(sample_head().view(), placement, options),
              bare = draw_marker_fit(sample_head().view(), {}, options);
  if (const char* folder = std::getenv("FB_KEEP_PICTURES"))
    write_png(std::filesystem::path(folder) / "marker_fit.png", image);
  std::size_t rims = 0, others = 0;
  const auto is_rim = [](Rgb c) { return c == Rgb{20, 22, 28}; };
  rims = static_cast<std::size_t>(std::ranges::count_if(image.pixels, is_rim));
  others = static_cast<std::size_t>(std::ranges::count_if(bare.pixels, is_rim));
  CHECK(others == 0);
  CHECK(rims > 60 * 40);
}

}  // namespace test_marker_placement
