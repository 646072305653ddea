// What the sample face has besides positions: meanings of controls, texture coordinates, materials, sockets.
#include <doctest/doctest.h>
#include <facebaker/facebaker_rig.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "rig.h"
#include "uv_layout.h"

extern "C" fb_status fb_rig_open(const char* path, fb_rig* rig, char* message, uint32_t message_size);

using namespace sample_face;

namespace test_face_surface {
namespace {

const fb_rig& plugin() {
  static const auto rig = [] {
    const auto destroy = [](fb_rig* opened) {
      opened->destroy(opened->user);
      delete opened;
    };
    std::unique_ptr<fb_rig, decltype(destroy)> opened(new fb_rig{}, destroy);
    char message[256] = "";
    REQUIRE(fb_rig_open("", opened.get(), message, sizeof message) == FB_OK);
    return opened;
  }();
  return *rig;
}

const Rig& face() {
  static const Rig rig;
  return rig;
}

Vec3 rest(std::uint32_t vertex) {
  return face().rest()[vertex];
}

// By vertex, how far a control moves it from a face whose jaw is a little open.
std::vector<Vec3> moves(std::uint32_t control) {
  std::vector<float> values(plugin().control_count, 0.0f);
  values[std::size_t(face().controls().index("jaw_open"))] = 0.4f;
  std::vector<Vec3> before(face().rest().size()), after = before;
  face().pose(values.data(), before.data());
  values[control] = 1;
  face().pose(values.data(), after.data());
  for (std::size_t v = 0; v < after.size(); ++v) after[v] -= before[v];
  return after;
}

// Where a control moves the face, and how, by squared distances.
struct Stir {
  Vec3 place, way;
};
Stir stir(std::uint32_t control) {
  Stir stir;
  float sum = 0;
  const std::vector<Vec3> all = moves(control);
  for (std::uint32_t v = 0; v < all.size(); ++v) {
    const float square = dot(all[v], all[v]);
    stir.place += rest(v) * square;
    stir.way += all[v] * square;
    sum += square;
  }
  return {stir.place * (1 / sum), stir.way * (1 / sum)};
}

Uv pair(std::uint32_t corner) {
  const std::uint32_t uv = plugin().uv_corners[corner];
  REQUIRE(uv < plugin().uv_count);
  return {plugin().uvs[2 * uv], plugin().uvs[2 * uv + 1]};
}

// Twice the area, above 0 where a, b and c run counter-clockwise.
double turn(Uv a, Uv b, Uv c) {
  return (double(b.u) - a.u) * (double(c.v) - a.v) - (double(b.v) - a.v) * (double(c.u) - a.u);
}

const std::set<std::string> kArkit = {
    "browDownLeft",      "browDownRight",      "browInnerUp",         "browOuterUpLeft",
    "browOuterUpRight",  "cheekPuff",          "cheekSquintLeft",     "cheekSquintRight",
    "eyeBlinkLeft",      "eyeBlinkRight",      "eyeLookDownLeft",     "eyeLookDownRight",
    "eyeLookInLeft",     "eyeLookInRight",     "eyeLookOutLeft",      "eyeLookOutRight",
    "eyeLookUpLeft",     "eyeLookUpRight",     "eyeSquintLeft",       "eyeSquintRight",
    "eyeWideLeft",       "eyeWideRight",       "jawForward",          "jawLeft",
    "jawOpen",           "jawRight",           "mouthClose",          "mouthDimpleLeft",
    "mouthDimpleRight",  "mouthFrownLeft",     "mouthFrownRight",     "mouthFunnel",
    "mouthLeft",         "mouthLowerDownLeft", "mouthLowerDownRight", "mouthPressLeft",
    "mouthPressRight",   "mouthPucker",        "mouthRight",          "mouthRollLower",
    "mouthRollUpper",    "mouthShrugLower",    "mouthShrugUpper",     "mouthSmileLeft",
    "mouthSmileRight",   "mouthStretchLeft",   "mouthStretchRight",   "mouthUpperUpLeft",
    "mouthUpperUpRight", "noseSneerLeft",      "noseSneerRight",      "tongueOut"};

}  // namespace

TEST_CASE("controls have names of ARKit and action units, each at most once") {
  REQUIRE(kArkit.size() == 52);
  std::set<std::string> arkit, facs;
  for (std::uint32_t i = 0; i < plugin().control_count; ++i) {
    const fb_rig_labels& labels = plugin().labels[i];
    CAPTURE(plugin().controls[i].name);
    if (*labels.arkit) {
      CHECK(arkit.insert(labels.arkit).second);
      CHECK(kArkit.contains(labels.arkit));
    }
    if (*labels.facs) {
      CHECK(facs.insert(labels.facs).second);
      CHECK(std::string(labels.facs).starts_with("AU"));
    }
  }
  CHECK(arkit.size() == 36);
  CHECK(facs.size() == 52);
  const auto index = std::size_t(face().controls().index("jaw_open"));
  CHECK(std::strcmp(plugin().labels[index].arkit, "jawOpen") == 0);
  CHECK(std::strcmp(plugin().labels[index].facs, "AU26") == 0);
}

TEST_CASE("names of a side are on that side, and go where they say") {
  for (std::uint32_t i = 0; i < plugin().control_count; ++i) {
    const std::string arkit = plugin().labels[i].arkit;
    if (arkit.empty()) continue;
    CAPTURE(arkit);
    const Stir is = stir(i);
    if (arkit.ends_with("Left")) CHECK(is.place.x > 0.5f);
    if (arkit.ends_with("Right")) CHECK(is.place.x < -0.5f);
    const std::string whole = arkit.substr(0, arkit.rfind(is.place.x > 0 ? "Left" : "Right"));
    if (whole.ends_with("Up") || whole == "eyeWide" || whole == "mouthSmile") CHECK(is.way.y > 0.05f);
    if (whole.ends_with("Down") || whole == "eyeBlink" || whole == "mouthFrown") CHECK(is.way.y < -0.05f);
    if (arkit == "jawForward" || arkit == "tongueOut" || arkit == "mouthPucker") CHECK(is.way.z > 0.05f);
  }
}

TEST_CASE("partners do the same on the other side") {
  int partners = 0;
  for (std::uint32_t i = 0; i < plugin().control_count; ++i) {
    const std::string mirror = plugin().labels[i].mirror;
    if (mirror.empty()) continue;
    const auto other = std::uint32_t(face().controls().index(mirror));
    CAPTURE(mirror);
    CHECK(plugin().labels[other].mirror == std::string(plugin().controls[i].name));
    if (other < i) continue;
    ++partners;
    const Stir here = stir(i), there = stir(other);
    CHECK(length(here.place - mirrored(there.place)) < 0.25f);  // the middle of the lips is the right one's
    CHECK(length(here.way - mirrored(there.way)) < 0.01f);
  }
  CHECK(partners == 199);
}

TEST_CASE("the surface lies flat in one square, turned over nowhere") {
  for (std::uint32_t i = 0; i < 2 * plugin().uv_count; ++i) {
    CHECK(plugin().uvs[i] >= 0);
    CHECK(plugin().uvs[i] <= 1);
  }
  double least = 1e9, most = 0;  // length in the square of a centimetre of the surface
  int turned = 0;
  for (std::uint32_t q = 0; q < plugin().polygon_count; ++q) {
    double flat = 0;
    for (std::uint32_t i = 0; i < 4; ++i) {
      const double area = turn(pair(4 * q + (i + 3) % 4), pair(4 * q + i), pair(4 * q + (i + 1) % 4));
      turned += area <= 0;
      flat += 0.25 * area;
    }
    const std::uint32_t* c = plugin().polygon_corners + std::size_t(4) * q;
    const double area = 0.5 * double(length(cross(rest(c[2]) - rest(c[0]), rest(c[3]) - rest(c[1]))));
    least = std::min(least, std::sqrt(flat / area));
    most = std::max(most, std::sqrt(flat / area));
  }
  CHECK(turned == 0);
  CHECK(least * 512 > 5);  // pixels of the picture
  CHECK(most * 512 < 100);
}

TEST_CASE("nothing lies over anything else in the square") {
  constexpr int kSize = 1024;
  std::vector<int> covered(std::size_t(kSize) * kSize, 0);
  for (std::uint32_t q = 0; q < plugin().polygon_count; ++q)
    for (std::uint32_t half = 1; half <= 2; ++half) {
      const Uv a = pair(4 * q), b = pair(4 * q + half), c = pair(4 * q + half + 1);
      const auto [left, right] = std::minmax({a.u, b.u, c.u});
      const auto [low, high] = std::minmax({a.v, b.v, c.v});
      for (int y = int(low * kSize); y <= int(high * kSize); ++y)
        for (int x = int(left * kSize); x <= int(right * kSize); ++x) {
          const Uv p{(float(x) + 0.5f) / kSize, (float(y) + 0.5f) / kSize};
          constexpr double kWithin = 1e-9;
          if (turn(a, b, p) > kWithin && turn(b, c, p) > kWithin && turn(c, a, p) > kWithin)
            ++covered[std::size_t(y) * kSize + std::size_t(x)];
        }
    }
  int once = 0, more = 0;
  for (const int times : covered) {
    once += times == 1;
    more += times > 1;
  }
  CHECK(more == 0);
  CHECK(once > kSize * kSize * 0.7);
}

TEST_CASE("four materials have all polygons, and a picture") {
  REQUIRE(plugin().mesh_count == 1);
  const fb_mesh& mesh = plugin().meshes[0];
  CHECK(mesh.vertex_count == plugin().vertex_count);
  CHECK(mesh.polygon_count == plugin().polygon_count);
  std::vector<std::string> names;
  std::uint32_t polygons = 0;
  for (std::uint32_t r = 0; r < mesh.run_count; ++r) {
    const fb_material& material = plugin().materials[mesh.runs[r].material];
    names.emplace_back(material.name);
    REQUIRE(material.texture_count == 1);
    CHECK(material.textures[0].slot == FB_TEXTURE_BASE_COLOUR);
    CHECK(material.textures[0].image < plugin().image_count);
    // The first and the last polygon of each are those of the part that it is named after.
    const Span part = r == 0   ? face().mesh().skin
                      : r == 1 ? Span{face().mesh().eyes[0].first, 2 * face().mesh().eyes[0].count}
                      : r == 2 ? Span{face().mesh().upper_teeth.first, 2 * face().mesh().upper_teeth.count}
                               : face().mesh().tongue;
    for (const std::uint32_t polygon : {polygons, polygons + mesh.runs[r].polygon_count - 1})
      CHECK(plugin().polygon_corners[4 * polygon] - part.first < part.count);
    polygons += mesh.runs[r].polygon_count;
  }
  CHECK(names == std::vector<std::string>{"skin", "eye", "teeth", "tongue"});
  CHECK(polygons == mesh.polygon_count);
  const auto* bytes = static_cast<const unsigned char*>(plugin().images[0].bytes);
  REQUIRE(plugin().images[0].byte_count > 1000);
  CHECK(std::memcmp(bytes, "\x89PNG\r\n\x1a\n", 8) == 0);
  CHECK(plugin().images[0].byte_count < 100000);
}

TEST_CASE("sockets hang on what is near them, and on nothing that the jaw moves") {
  const std::vector<Vec3> opened = moves(std::uint32_t(face().controls().index("jaw_open")));
  std::vector<std::string> names;
  for (std::uint32_t s = 0; s < plugin().socket_count; ++s) {
    const fb_socket& socket = plugin().sockets[s];
    names.emplace_back(socket.name);
    CAPTURE(names.back());
    const Vec3 origin{socket.frame[3], socket.frame[7], socket.frame[11]};
    const std::set<std::uint32_t> vertices(socket.vertices, socket.vertices + socket.vertex_count);
    REQUIRE(vertices.size() == socket.vertex_count);
    REQUIRE(vertices.size() >= 3);
    const std::vector<Vec3> moved =
        moves(std::uint32_t(face().controls().index(socket.name == std::string("earring_L")   ? "ear_lobe_y_L"
                                                    : socket.name == std::string("earring_R") ? "ear_lobe_y_R"
                                                                                              : "nose_bridge_z")));
    float most = 0;
    for (const std::uint32_t v : vertices) {
      CHECK(length(rest(v) - origin) < 7);
      CHECK(length(opened[v]) < 0.01f);
      most = std::max(most, length(moved[v]));
    }
    if (socket.name == std::string("hat"))
      CHECK(most == 0);
    else
      CHECK(most > 0.01f);
    const Vec3 a = rest(socket.vertices[0]), b = rest(socket.vertices[1]), c = rest(socket.vertices[2]);
    CHECK(length(cross(b - a, c - a)) > 0.2f);  // not on one line
  }
  CHECK(names == std::vector<std::string>{"hat", "glasses", "earring_L", "earring_R"});
}

}  // namespace test_face_surface
