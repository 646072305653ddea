// Partners of the face's vertices on other meshes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include "base/file.h"
#include "base/status.h"
#include "head_meshes.h"
#include "render/png_file.h"
#include "solve/correspondence_file.h"
#include "solve/fit_picture.h"
#include "solve/mesh_alignment.h"
#include "solve/mesh_correspondence.h"
#include "temporary_folder.h"

using namespace fb;
using namespace fb::tool;
using namespace fb::test;

namespace test_mesh_correspondence {

const SampledSurface& face() {
  static const SampledSurface surface(sample_head().view(), 1500);
  return surface;
}

// Z up, in metres.
const Similarity elsewhere = {{1, 0, 0, 0, 0, -1, 0, 1, 0}, 0.01, {3, -2, 1}};

TEST_CASE("vertices of the face find their partners on a mesh of another topology") {
  const HeadMesh other = moved(dual_head(2), elsewhere);
  const SampledSurface surface(other.view(), 1500);
  const Alignment alignment = align_surfaces(surface, face(), {});
  const MeshCorrespondence found = find_correspondence(face(), surface, alignment.to_face);
  MESSAGE(correspondence_text(found, "cm"));
  CHECK(found.vertices.size() == sample_head().points.size() / 3);
  CHECK(found.statistics.without < 0.1);
  CHECK(found.statistics.median < 0.02);
  CHECK(found.statistics.p95 < 0.15);
  // A partner is where the vertex itself is.
  std::size_t near = 0, partners = 0;
  for (const Correspondence& c : found.vertices) {
    if (c.partner != Partner::found) continue;
    ++partners;
    const Vector3 at = alignment.to_face(c.other.at(other.points));
    const float off = length(at - vector_at(face().points.data(), c.vertex));
    CHECK(off == doctest::Approx(c.distance).epsilon(0.01).scale(0.01));
    near += off < 0.15f;
  }
  CHECK(double(near) > 0.95 * double(partners));
  CHECK(correspondence_text(found, "cm").find(" vertices have a partner on the target, half of them within 0.") !=
        std::string::npos);
}

TEST_CASE("what is missing of the other mesh has no partners, and the rest keeps its own") {
  const HeadMesh whole = dual_head(1), other = moved(cut_beyond(whole, 2.6f), elsewhere);
  const SampledSurface surface(other.view(), 1500);
  const MeshCorrespondence found = find_correspondence(face(), surface, elsewhere.inverse());
  MESSAGE(correspondence_text(found, "cm"));
  std::size_t beyond = 0, kept = 0, before = 0;
  for (const Correspondence& c : found.vertices) {
    const float x = face().points[3 * std::size_t{c.vertex}];
    beyond += x > 3.2f && c.partner == Partner::found;
    before += x < 1.5f;
    kept += x < 1.5f && c.partner == Partner::found;
  }
  CHECK(beyond == 0);
  CHECK(double(kept) > 0.8 * double(before));
  CHECK(found.statistics.border > 0);
  CHECK(found.statistics.far > 100);
}

TEST_CASE("chosen vertices, bounds and normals are respected") {
  // A square that the face's triangle lies over, once facing it and once from behind.
  const HeadMesh square = {{0, 0, 0, 4, 0, 0, 4, 4, 0, 0, 4, 0}, {4}, {0, 1, 2, 3}};
  const HeadMesh behind = {square.points, {4}, {3, 2, 1, 0}};
  const HeadMesh triangle = {{1, 1, 0.5f, 2, 1, 0.5f, 1, 2, 1}, {3}, {0, 1, 2}};
  const SampledSurface small(triangle.view(), 10), front(square.view(), 10), back(behind.view(), 10);
  const auto partners = [&](const SampledSurface& other, const CorrespondenceOptions& options) {
    std::vector<Partner> all;
    for (const Correspondence& c : find_correspondence(small, other, {}, options).vertices) all.push_back(c.partner);
    return all;
  };
  using enum Partner;
  CHECK(partners(front, {.bound = 2.0}) == std::vector{found, found, found});
  CHECK(partners(front, {.bound = 0.7}) == std::vector{found, found, far});
  CHECK(partners(front, {.vertices = {2, 0}, .bound = 0.7}) == std::vector{far, found});
  CHECK(partners(back, {.bound = 2.0}) == std::vector{turned, turned, turned});
  CHECK_THROWS_WITH_AS(find_correspondence(small, front, {}, {.vertices = {3}}),
                       "vertex 3 of the face: it has 3 vertices", Error);
  const Similarity aside = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, 1, {1.5, 0, 0}};
  const MeshCorrespondence shifted = find_correspondence(small, front, aside, {.bound = 2.0});
  CHECK(shifted.vertices[0].partner == border);
  CHECK(shifted.vertices[1].partner == found);
  CHECK(shifted.vertices[1].distance == doctest::Approx(0.5));
}

TEST_CASE("correspondences are written and read again, also as arrays") {
  const Folder folder;
  std::vector<Correspondence> rows(3);
  rows[0] = {5, {{1, 2, 3}, {0.5f, 0.25f, 0.25f}}, 0.1f, Partner::found};
  rows[1] = {6, {{1, 2, 3}, {1, 0, 0}}, 9, Partner::far};
  rows[2] = {7, {{0, 0, 9}, {0, 0, 1}}, 0.2f, Partner::found};
  write_correspondence(folder / "pairs.json", rows);
  const std::vector<Correspondence> again = read_correspondence(folder / "pairs.json", 8, 10);
  REQUIRE(again.size() == 2);
  CHECK(again[0].vertex == 5);
  CHECK(again[0].other == rows[0].other);
  CHECK(again[1].vertex == 7);
  CHECK(again[1].other == rows[2].other);

  std::string npy = std::string("\x93NUMPY\x01\x00", 8) + '\x76' + '\0';
  npy += "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 7), }";
  npy.resize(127, ' ');
  npy += '\n';
  const float row[] = {5, 1, 2, 3, 0.5f, 0.25f, 0.25f};
  npy.append(reinterpret_cast<const char*>(row), sizeof row);
  write_file(folder / "pairs.npy", npy);
  const std::vector<Correspondence> array = read_correspondence(folder / "pairs.npy", 8, 10);
  REQUIRE(array.size() == 1);
  CHECK(array[0].other == rows[0].other);

  const auto fault = [&](const std::string& text) -> std::string {
    write_file(folder / "bad.json", text);
    try {
      read_correspondence(folder / "bad.json", 8, 10);
      return "";
    } catch (const Error& error) {
      const std::string message = error.what();
      return message.substr(message.find("bad.json") + 8);
    }
  };
  CHECK(fault("{}") == ": there is no list \"correspondences\" of rows of seven numbers");
  CHECK(fault("{\"correspondences\": []}") == ": no correspondences");
  CHECK(fault("{\"correspondences\": [[1, 2]]}") ==
        ": row 0 is [1,2]: a row is a vertex of the face, three of the target, three weights");
  CHECK(fault("{\"correspondences\": [[8, 1, 2, 3, 1, 0, 0]]}") ==
        ", row 0: 8 is no vertex of the face, which has 8, counted from 0");
  CHECK(fault("{\"correspondences\": [[1, 1, 2.5, 3, 1, 0, 0]]}") ==
        ", row 0: 2.5 is no vertex of the target, which has 10, counted from 0");
  CHECK(fault("{\"correspondences\": [[1, 1, 2, 3, 1, 1, 0]]}") == ", row 0: the weights sum to 2, not to 1");
  CHECK(fault("{\"correspondences\": [[1, 1, 2, 3, 1, 0, 0], [1, 1, 2, 3, 1, 0, 0]]}") ==
        ", row 1: the vertex 1 of the face is that of row 0 too");
  CHECK_THROWS_AS(read_correspondence(folder / "pairs.txt", 8, 10), Error);
}

TEST_CASE("the picture shows the fit, and where there is none") {
  const HeadMesh other = moved(cut_beyond(dual_head(1), 2.6f), elsewhere);
  const SampledSurface surface(other.view(), 1500);
  const MeshCorrespondence found = find_correspondence(face(), surface, elsewhere.inverse());
  const Image image = draw_mesh_fit(sample_head().view(), other.view(), elsewhere.inverse(), found, {.unit = "cm"});
  if (const char* folder = std::getenv("FB_KEEP_PICTURES"))
    write_png(std::filesystem::path(folder) / "mesh_fit.png", image);
  CHECK(image.width > 4 * 420);
  CHECK(image.height > 520);
  // Blue in the first panel, on the side that is missing, which is the viewer's right.
  const auto blue = [&](int left, int right) {
    std::size_t count = 0;
    for (int y = 0; y < 520; ++y)
      for (int x = left; x < right; ++x) count += image.at(x, y).b > image.at(x, y).r + 60;
    return count;
  };
  CHECK(blue(218, 428) > 3000);
  CHECK(blue(218, 428) > 3 * blue(8, 218));
}

}  // namespace test_mesh_correspondence
