#include "bake/measure/contact.h"

#include <doctest/doctest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "archive/writer.h"
#include "bake/compress/pack_model.h"
#include "bake/measure/certificate.h"
#include "bake/measure/evaluate.h"
#include "grid_quads.h"
#include "memory_source.h"

namespace test_contact {

using namespace fb;
using namespace fb::bake;

namespace {

using Points = std::vector<float>;

constexpr std::uint32_t side = 8;

// Adds a grid of squares of size 1 at a height, which faces up or down.
void add_sheet(Mesh& mesh, float height, bool up, float shift = 0) {
  const auto first = static_cast<std::uint32_t>(mesh.vertex_count());
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < side; ++x)
      mesh.points.insert(mesh.points.end(), {float(x) + shift, float(y), height});
  add_grid_quads(mesh, side, first, up);
}

// Two lips, `gap` apart: the lower one faces up, the upper one down.
Mesh lips(float gap) {
  Mesh mesh;
  add_sheet(mesh, 0, true);
  add_sheet(mesh, gap, false);
  return mesh;
}

// The upper sheet moved.
Points upper_moved(Points points, Vector3 way) {
  for (std::size_t v = side * side; v < points.size() / 3; ++v) {
    points[3 * v] += way.x;
    points[3 * v + 1] += way.y;
    points[3 * v + 2] += way.z;
  }
  return points;
}

std::vector<TouchingPair> touching(const Mesh& rest, const Points& pose) {
  return ContactFinder(rest).touching(pose, vertex_normals(rest.triangles(), pose));
}

ContactErrors errors(const Mesh& rest, const Points& truth, const Points& predicted) {
  Points error(truth.size());
  for (std::size_t i = 0; i < error.size(); ++i)
    error[i] = static_cast<float>((predicted[i] - truth[i]) / rest.diagonal());
  ContactSums sums;
  sums.add_frame(0, touching(rest, truth), error);
  return sums.figures();
}

constexpr std::size_t all = 2 * side * side;
constexpr float closed = 0.005f;  // half of the distance at which sheets of this size touch

// Lips that control 0 closes; the archive never moves.
MemorySource mouth() {
  MemorySource source(2, side, [](const float* controls, std::span<float> points) {
    for (std::size_t v = side * side; v < points.size() / 3; ++v) points[3 * v + 2] -= (2 - closed) * controls[0];
  });
  source.edit_rest() = lips(2);
  source.add_clip("talk", ClipKind::shot, Split::test, 600, 0, 1);
  for (std::size_t f = 0; f < 600; ++f) source.edit_clip(0).controls[2 * f] = f % 7 < 3 ? 1.0f : 0.5f;
  return source;
}

EvalReport measured(MemorySource& source, int threads) {
  FaceModel model;
  model.schema = source.schema();
  model.rest = source.rest();
  model.network.features = {{Feature::Kind::identity, 0, 1, 0}};
  model.network.direct = {0};
  Points shape(model.rest.points.size());
  for (std::size_t v = side * side; v < shape.size() / 3; ++v) shape[3 * v + 2] = -1.9f;
  model.basis = make_basis(static_cast<std::uint32_t>(shape.size()), 1, shape);
  return evaluate_archive(archive::write_archive(pack_model(model, {}), {}), source, Split::test, {.threads = threads},
                          silent_progress(), Detail::quality);
}

}  // namespace

TEST_CASE("lips that close touch in all places, and a gap is told from one lip in the other") {
  const Mesh rest = lips(2);
  const double d = rest.diagonal();
  REQUIRE(closed < visible_gap * d);
  CHECK(touching(rest, rest.points).empty());
  const Points truth = upper_moved(rest.points, {0, 0, closed - 2});
  CHECK(touching(rest, truth).size() == all);
  CHECK(touching(rest, upper_moved(truth, {0, 0, 2 * closed})).empty());

  const ContactErrors open = errors(rest, truth, upper_moved(truth, {0, 0, 0.05f}));
  CHECK(open.pairs == all);
  CHECK(open.frames == 1);
  CHECK(open.open == all);
  CHECK(open.deep == 0);
  CHECK(open.rms == doctest::Approx(0.05 / d).epsilon(1e-4));
  CHECK(open.worst == doctest::Approx(0.05 / d).epsilon(1e-4));
  const ContactErrors deep = errors(rest, truth, upper_moved(truth, {0, 0, -0.05f}));
  CHECK(deep.open == 0);
  CHECK(deep.deep == all);
  CHECK(deep.max == doctest::Approx(0.05 / d).epsilon(1e-4));
  CHECK(deep.worst == doctest::Approx(-0.05 / d).epsilon(1e-4));
  // What slides along touches still.
  CHECK(errors(rest, truth, upper_moved(truth, {0.05f, -0.05f, 0})).max < 1e-6);
  // A difference that nobody sees is no opening.
  CHECK(errors(rest, truth, upper_moved(truth, {0, 0, closed})).open == 0);
}

TEST_CASE("lips that are closed at rest, or lie a little in each other, touch") {
  const Mesh rest = lips(closed);
  CHECK(touching(rest, rest.points).size() == all);
  const Mesh open = lips(2);
  CHECK(touching(open, upper_moved(open.points, {0, 0, -2 - closed})).size() == all);
}

TEST_CASE("a vertex touches the nearest point of a triangle, also between its corners") {
  Mesh rest;
  add_sheet(rest, 0, true);
  add_sheet(rest, 2, false, 0.5f);
  const Points truth = upper_moved(rest.points, {0, 0, closed - 2});
  const std::vector<TouchingPair> pairs = touching(rest, truth);
  CHECK(pairs.size() == all - 2 * side);  // but the columns that lie beside the other sheet
  for (const TouchingPair& pair : pairs) {
    CHECK(pair.weights[0] + pair.weights[1] + pair.weights[2] == doctest::Approx(1));
    CHECK(std::abs(pair.direction.z) == doctest::Approx(1));
    CHECK((pair.direction.z > 0) == (pair.vertex >= side * side));
  }
  // One vertex of the lower sheet sinks: its pair opens, and those that touch beside it by their share.
  Points predicted = truth;
  const std::size_t sunk = 3 * side + 3;
  predicted[3 * sunk + 2] -= 0.1f;
  const ContactErrors figures = errors(rest, truth, predicted);
  CHECK(figures.worst_vertex == sunk);
  CHECK(figures.max == doctest::Approx(0.1 / rest.diagonal()).epsilon(1e-4));
  CHECK(figures.open > 1);
  CHECK(figures.deep == 0);
  CHECK(figures.vertex_share == doctest::Approx(double(pairs.size()) / all));
  CHECK(figures.error_share == doctest::Approx(1));
  predicted[0] += 0.1f;  // at the border, where nothing touches
  CHECK(errors(rest, truth, predicted).error_share == doctest::Approx(0.5).epsilon(1e-4));
}

TEST_CASE("a sheet that is folded touches itself, but not along the fold") {
  Mesh rest;
  add_sheet(rest, 0, true);
  Points folded = rest.points;
  for (std::size_t v = 0; v < side * side; ++v)
    if (v % side >= side / 2) {
      folded[3 * v] = float(side - 1 - v % side);
      folded[3 * v + 2] = closed;
    }
  const std::vector<TouchingPair> pairs = touching(rest, folded);
  static_assert(side == 8);
  std::set<std::uint32_t> columns;
  for (const TouchingPair& pair : pairs) columns.insert(pair.vertex % side);
  CHECK(pairs.size() == (side - 2) * side);
  CHECK(columns == std::set<std::uint32_t>{0, 1, 2, 5, 6, 7});
}

TEST_CASE("seams, doubled sheets and the two sides of a thin sheet do not touch") {
  Mesh seam;
  add_sheet(seam, 0, true);
  add_sheet(seam, 0, true, float(side - 1));
  CHECK(touching(seam, seam.points).empty());
  Mesh twice;
  add_sheet(twice, 0, true);
  add_sheet(twice, 0, true);
  CHECK(touching(twice, twice.points).empty());
  for (const float thickness : {0.0f, closed}) {
    Mesh thin;
    add_sheet(thin, 0, false);
    add_sheet(thin, thickness, true);
    thin.points.insert(thin.points.end(), {0, 0, 5});  // a vertex without a polygon
    Points bent = thin.points;
    for (std::size_t v = 0; v < bent.size() / 3; ++v) bent[3 * v + 2] += 0.02f * bent[3 * v] * bent[3 * v];
    CHECK(touching(thin, thin.points).empty());
    CHECK(touching(thin, bent).empty());
  }
}

TEST_CASE("a fold of a seam counts as the fold of one surface") {
  // Two sheets with vertices of their own along x = side - 1, folded there.
  Mesh rest;
  add_sheet(rest, 0, true);
  add_sheet(rest, 0, true, float(side - 1));
  Points folded = rest.points;
  for (std::size_t v = side * side; v < folded.size() / 3; ++v) {
    folded[3 * v] = 2 * float(side - 1) - folded[3 * v];
    folded[3 * v + 2] = folded[3 * v] < float(side - 1) ? closed : 0;
  }
  std::set<std::uint32_t> columns;
  for (const TouchingPair& pair : touching(rest, folded)) columns.insert(pair.vertex % side);
  CHECK(columns.size() == side);
  CHECK(touching(rest, folded).size() == 2 * (side - 1) * side);
}

TEST_CASE("what a rig hides by shrinking it does not touch") {
  const Mesh rest = lips(closed);
  Points shrunk = rest.points;
  for (float& x : shrunk) x *= 0.05f;
  CHECK(touching(rest, rest.points).size() == all);
  CHECK(touching(rest, shrunk).empty());
}

TEST_CASE("large and collapsed triangles, and faces far away, are searched as others are") {
  Mesh rest = lips(2);
  const std::uint32_t n = static_cast<std::uint32_t>(rest.vertex_count());
  rest.points.insert(rest.points.end(), {-50, -50, 1, 50, -50, 1, 0, 50, 1, 3, 3, 1.0f - closed, 3, 3, 1.0f - closed});
  rest.polygon_sizes.insert(rest.polygon_sizes.end(), {3, 3});
  rest.polygon_corners.insert(rest.polygon_corners.end(), {n, n + 2, n + 1, n + 3, n + 4, n + 3});
  const Points pose = upper_moved(rest.points, {0, 0, -2});
  CHECK(touching(rest, rest.points).empty());
  // The large triangle lies on the lower sheet now, and faces it; the upper sheet lies below.
  CHECK(touching(rest, upper_moved(rest.points, {0, 0, closed - 1})).size() >= side * side);
  Points far = pose;
  for (std::size_t i = 0; i < far.size(); i += 3) far[i] += 1e12f;
  CHECK(touching(rest, far).size() <= n + 5);
}

TEST_CASE("contact is measured in evenly spaced frames, the same for any number of threads") {
  MemorySource source = mouth();
  const EvalReport one = measured(source, 1), three = measured(source, 3);
  const ContactErrors &a = one.quality.value().contact, &b = three.quality.value().contact;
  CHECK(a.looked_at == 200);  // every third of 600 frames
  std::size_t frames = 0;
  for (std::size_t f = 0; f < 600; f += 3) frames += f % 7 < 3;
  CHECK(a.frames == frames);
  CHECK(a.pairs == frames * all);
  const double off = (2 - closed - 1.9) / one.diagonal;
  CHECK(a.rms == doctest::Approx(off).epsilon(1e-2));
  CHECK(a.open == a.pairs);
  CHECK(a.worst_frame % 3 == 0);
  CHECK(a.worst_frame % 7 < 3);
  CHECK(a.rms == b.rms);
  CHECK(a.max == b.max);
  CHECK(a.worst_frame == b.worst_frame);
  CHECK(a.worst_vertex == b.worst_vertex);
}

TEST_CASE("sums joined in order are the sums of all frames") {
  const Mesh rest = lips(2);
  const Points truth = upper_moved(rest.points, {0, 0, closed - 2});
  const std::vector<TouchingPair> pairs = touching(rest, truth);
  ContactSums whole, first, second;
  for (std::size_t f = 0; f < 6; ++f) {
    Points error(truth.size());
    error[3 * f + 2] = f == 4 ? -0.02f : 0.001f * float(f);
    whole.add_frame(f, pairs, error);
    if (f < 3)
      first.add_frame(f, pairs, error);
    else
      second.add_frame(f - 3, pairs, error);
  }
  first.append(second, 3);
  const ContactErrors a = whole.figures(), b = first.figures();
  CHECK(a.worst_frame == 4);
  CHECK(b.worst_frame == 4);
  CHECK(a.worst_vertex == 4);
  CHECK(b.worst_vertex == 4);
  CHECK(a.worst > 0);  // the lower lip sinks
  CHECK(a.pairs == b.pairs);
  CHECK(a.open == b.open);
  CHECK(a.rms == doctest::Approx(b.rms));
  CHECK(a.vertex_share == doctest::Approx(b.vertex_share));
  CHECK(a.error_share == doctest::Approx(b.error_share));
}

TEST_CASE("the certificate states contact, and is read without it") {
  MemorySource source = mouth();
  const EvalReport report = measured(source, 2);
  CertifiedFace face;
  face.dependency = report.total;
  face.independent = report;
  const std::string text = certificate(face);
  const nlohmann::json contact = nlohmann::json::parse(text).at("independent").at("contact");
  const ContactErrors& figures = report.quality.value().contact;
  CHECK(contact.at("looked_at") == figures.looked_at);
  CHECK(contact.at("frames") == figures.frames);
  CHECK(contact.at("pairs") == figures.pairs);
  CHECK(contact.at("open") == figures.open);
  CHECK(contact.at("deep") == figures.deep);
  CHECK(contact.at("rms") == doctest::Approx(figures.rms).epsilon(1e-5));
  CHECK(contact.at("max") == doctest::Approx(figures.max).epsilon(1e-5));
  CHECK(contact.at("error_share") == doctest::Approx(figures.error_share).epsilon(1e-5));
  nlohmann::json old = nlohmann::json::parse(text);
  old.at("independent").erase("contact");
  REQUIRE(certified_errors(old.dump()));
  CHECK(certified_errors(old.dump())->largest == certified_errors(text)->largest);
}

}  // namespace test_contact
