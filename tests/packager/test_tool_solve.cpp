// Controls found by the tool: point caches, markers, sources, what is written, and what is refused.
#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bake/dataset/npy.h"
#include "base/file.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_solve {

using Json = nlohmann::json;

namespace {

constexpr std::size_t frames = 6;

// The tiny face, a clip of it, and where its vertices are in it.
struct TinyClip {
  TinyClip() : model(write_tiny_archive(folder / "face.fbk")) {
    // From near rest on, a little further each frame: what a solve goes from frame to frame through.
    const std::vector<float> ends = write_clip(folder / "ends.npy", model.schema, 1);
    for (std::size_t f = 0; f < frames; ++f)
      for (std::size_t c = 0; c < ends.size(); ++c) {
        const float rest = model.schema.controls[c].rest;
        controls.push_back(rest + 0.06f * float(f) * (ends[c] - rest));
      }
    points = evaluate_clip(model, controls);
    fb::bake::write_npy(folder / "points.npy", {frames, vertices(), 3}, points);
  }
  std::size_t vertices() const { return model.rest.surface_vertex_count(); }
  std::string face() const { return folder / "face.fbk"; }

  // Where the face is once it is solved, less where it should be: the largest distance along an axis.
  double misfit(const std::string& solved) const {
    const fb::bake::NpyFile file(folder / solved);
    REQUIRE(file.shape() == std::vector<std::size_t>{frames, model.schema.control_count()});
    std::vector<float> found(frames * model.schema.control_count());
    file.read(0, frames, found);
    const std::vector<float> at = evaluate_clip(model, found);
    double worst = 0;
    for (std::size_t i = 0; i < at.size(); ++i) worst = std::max(worst, std::fabs(double(at[i]) - points[i]));
    return worst;
  }

  const ScratchFolder folder;
  const fb::PackedModel model;
  std::vector<float> controls, points;
};

std::string text_of(const std::string& path) {
  const std::vector<std::byte> bytes = fb::read_file(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Every second vertex as a marker in millimetres of a face in centimetres, turned to z up and moved; one that is not
// seen in one frame.
void write_take(const TinyClip& clip, const std::string& path, bool rest_first) {
  std::ofstream out(path);
  out << "time";
  for (std::size_t v = 0; v < clip.vertices(); v += 2)
    for (const char axis : {'x', 'y', 'z'}) out << ",m" << v << '.' << axis;
  out << '\n';
  const auto write_frame = [&](std::size_t number, const float* points) {
    out << double(number) / 24;
    for (std::size_t v = 0; v < clip.vertices(); v += 2) {
      const float* const p = points + 3 * v;
      if (number == 2 && v == 4)
        out << ",,,";
      else
        out << ',' << 10 * p[0] + 100 << ',' << -10 * p[2] + 20 << ',' << 10 * p[1] - 7;
    }
    out << '\n';
  };
  if (rest_first) write_frame(0, clip.model.rest.points.data());
  for (std::size_t f = 0; f < frames; ++f) write_frame(f + rest_first, clip.points.data() + f * 3 * clip.vertices());
}

void write_placement(const TinyClip& clip, const std::string& path) {
  Json markers;
  for (std::size_t v = 0; v < clip.vertices(); v += 2) markers["m" + std::to_string(v)] = {{"vertices", {v}}};
  fb::write_file(path, Json{{"markers", markers}}.dump());
}

const std::vector<std::string> exactly = {"--noise", "0.001", "--nearness", "0", "--sparsity", "0"};

ToolRun solve(const TinyClip& clip, const std::string& target, std::vector<std::string> more = {}) {
  std::vector<std::string> arguments = {"solve", clip.face(), clip.folder / target, "--out", clip.folder / "out.npy"};
  arguments.insert(arguments.end(), exactly.begin(), exactly.end());
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_tool(arguments);
}

}  // namespace

TEST_CASE("a clip of vertices is found again, with figures and a report") {
  const TinyClip clip;
  const ToolRun run = solve(clip, "points.npy", {"--report", clip.folder / "report", "--json", clip.folder / "f.json"});
  REQUIRE_MESSAGE(run.exit_code == 0, run.err);
  CHECK(run.out.find("6 frames of 30 points") != std::string::npos);
  CHECK(clip.misfit("out.npy") < 0.05);
  const Json figures = Json::parse(text_of(clip.folder / "f.json"));
  CHECK(figures.at("frames") == frames);
  CHECK(figures.at("points") == 30);
  CHECK(figures.at("max").get<double>() < 0.05);
  const std::string page = text_of(clip.folder / "report/index.html");
  for (const char* part : {"Over time", "Worst frames", "frame_"}) CHECK(page.find(part) != std::string::npos);
  // The same again, and in a point cache.
  const std::string first = text_of(clip.folder / "out.npy");
  REQUIRE(solve(clip, "points.npy").exit_code == 0);
  CHECK(text_of(clip.folder / "out.npy") == first);
  REQUIRE(run_tool({"export", clip.face(), clip.folder / "cache.pc2", "--clip", clip.folder / "out.npy"}).exit_code ==
          0);
  REQUIRE(solve(clip, "cache.pc2").exit_code == 0);
  CHECK(clip.misfit("out.npy") < 0.1);
}

TEST_CASE("markers are followed from where they are placed, wherever the head is") {
  const TinyClip clip;
  write_take(clip, clip.folder / "take.csv", true);
  write_placement(clip, clip.folder / "placement.json");
  const ToolRun run = solve(
      clip, "take.csv",
      {"--placement", clip.folder / "placement.json", "--neutral", "0", "--target-units", "mm", "--no-head-motion"});
  REQUIRE_MESSAGE(run.exit_code == 0, run.err);
  CHECK(run.out.find("7 frames of 15 points") != std::string::npos);
  const fb::bake::NpyFile file(clip.folder / "out.npy");
  std::vector<float> found(5 * frames);
  file.read(1, frames, found);
  const std::vector<float> at = evaluate_clip(clip.model, found);
  for (std::size_t f = 0; f < frames; ++f)
    for (std::size_t v = 0; v < clip.vertices(); v += 2)
      for (std::size_t a = 0; a < 3; ++a) {
        const std::size_t i = 3 * (f * clip.vertices() + v) + a;
        CHECK(at[i] == doctest::Approx(clip.points[i]).scale(1).epsilon(0.05));
      }
  const ToolRun moved = solve(clip, "take.csv",
                              {"--placement", clip.folder / "placement.json", "--neutral", "0", "--target-units", "mm",
                               "--motion-out", clip.folder / "motion.npy"});
  REQUIRE_MESSAGE(moved.exit_code == 0, moved.err);
  const fb::bake::NpyFile motion(clip.folder / "motion.npy");
  CHECK(motion.shape() == std::vector<std::size_t>{frames + 1, 3, 4});
}

TEST_CASE("controls that are locked rest, and only those that are named move") {
  const TinyClip clip;
  const auto moves = [&](std::vector<std::string> more) {
    REQUIRE(solve(clip, "points.npy", std::move(more)).exit_code == 0);
    std::vector<float> found(5 * frames);
    fb::bake::NpyFile(clip.folder / "out.npy").read(0, frames, found);
    std::string names;
    for (std::size_t c = 0; c < 5; ++c)
      for (std::size_t f = 0; f < frames; ++f)
        if (found[5 * f + c] != clip.model.schema.controls[c].rest) {
          names += clip.model.schema.controls[c].name + " ";
          break;
        }
    return names;
  };
  CHECK(moves({}).find("jaw_open") != std::string::npos);
  CHECK(moves({"--lock", "jaw_open"}).find("jaw_open") == std::string::npos);
  CHECK(moves({"--only", "mouth", "--lock", "mouth_side"}) == "jaw_open ");
  const ToolRun run = solve(clip, "points.npy", {"--only", "jaw_opne"});
  CHECK_MESSAGE(is_error_line(run.err, "solve", {"jaw_opne", "jaw_open"}), run.err);
}

TEST_CASE("what cannot be solved is named, and nothing is written") {
  const TinyClip clip;
  const auto refused = [&](const std::string& target, std::vector<std::string> more, std::vector<std::string> words) {
    const ToolRun run = solve(clip, target, std::move(more));
    CHECK(run.exit_code == 1);
    CHECK_MESSAGE(is_error_line(run.err, "solve", words), run.err);
    CHECK(!std::filesystem::exists(clip.folder / "out.npy"));
  };
  refused("missing.npy", {}, {"missing.npy"});
  fb::bake::write_npy(clip.folder / "few.npy", {1, 2, 3}, std::vector<float>(6));
  refused("few.npy", {}, {"few.npy", "2 points", "30 vertices"});
  fb::bake::write_npy(clip.folder / "flat.npy", {2, 90}, std::vector<float>(180));
  refused("flat.npy", {}, {"flat.npy", "(2, 90)"});
  std::vector<float> infinite(90, INFINITY);
  fb::bake::write_npy(clip.folder / "infinite.npy", {1, 30, 3}, infinite);
  refused("infinite.npy", {}, {"frame 0", "point 0", "infinite"});
  refused("points.npy", {"--neutral", "6"}, {"--neutral 6", "0 to 5"});
  refused("points.npy", {"--target-units", "parsec"}, {"--target-units", "parsec"});
  write_take(clip, clip.folder / "take.csv", false);
  fb::write_file(clip.folder / "other.json", std::string(R"({"markers": {"chin": {"vertices": [3]}}})"));
  refused("take.csv", {"--placement", clip.folder / "other.json"}, {"placed markers"});
}

}  // namespace test_tool_solve
