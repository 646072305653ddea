#include <doctest/doctest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/file.h"
#include "bench/sparse_shapes.h"
#include "bench/timing.h"
#include "commands/speed_text.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_bench {

namespace {

// The median of a figure in the comma-separated values, or -1.
double median_of(const std::string& csv, const std::string& figure) {
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t at = line.find("\"" + figure + "\",");
    if (at == std::string::npos) continue;
    double least = -1, median = -1;
    if (std::sscanf(line.c_str() + at + figure.size() + 3, "%lf,%lf", &least, &median) == 2 && least <= median)
      return median;
  }
  return -1;
}

std::string text_of(const std::string& path) {
  const std::vector<std::byte> bytes = fb::read_file(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

TEST_CASE("bench times a face beside float networks, and names processor and compiler") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", csv = folder / "speed.csv";
  write_tiny_archive(archive);
  const ToolRun run = run_tool({"bench", archive, "--poses", "5", "--rounds", "2", "--batch", "4", "--csv", csv});
  REQUIRE(run.exit_code == 0);
  const std::string figures = text_of(csv);
  for (const char* figure :
       {"positions", "positions, baked order", "positions, halves", "positions and normals", "coefficients", "at rest",
        "sparse morph targets, floats", "crowd of 8, 1 thread", "crowd of 8, 2 threads", "100 instances, 1 thread",
        "100 instances in turn", "same model, floats, Eigen", "paper's network, Eigen", "cold: positions",
        "cold: paper's network, Eigen", "batch of 4: positions", "batch of 4: paper's network, Eigen"}) {
    CHECK_MESSAGE(median_of(figures, figure) > 0, std::string(figure));
    CHECK_MESSAGE(run.out.find(figure) != std::string::npos, std::string(figure));
  }
  CHECK(median_of(figures, "batch of 4: writing alone") >= 0);  // of so few bytes no longer than reading the clock
  CHECK(figures.find("processor,compiler,flags,instruction set") == 0);
  const std::size_t lines = std::count(figures.begin(), figures.end(), '\n');
  CHECK(lines > 15);
  // 8 layers of 256 and a dense basis take longer than 30 vertices.
  CHECK(median_of(figures, "paper's network, Eigen") > median_of(figures, "positions"));
}

TEST_CASE("bench --json has the main figures by name, and all lines") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", file = folder / "speed.json";
  write_tiny_archive(archive);
  const ToolRun run = run_tool({"bench", archive, "--poses", "5", "--rounds", "2", "--batch", "4", "--json", file});
  REQUIRE(run.exit_code == 0);
  CHECK(run.out.find("| positions ") != std::string::npos);
  const auto json = nlohmann::json::parse(text_of(file));
  const auto line = [&](const std::string& name) {
    for (const auto& one : json.at("lines"))
      if (one.at("name") == name) return one;
    FAIL("no line ", name);
    return nlohmann::json();
  };
  CHECK(json.at("pose_us_warm") == line("positions").at("median_us"));
  CHECK(json.at("pose_us_cold") == line("cold: positions").at("median_us"));
  CHECK(json.at("batch_us_per_pose") == line("batch of 4: positions").at("median_us"));
  CHECK(json.at("eigen_fp32_us") == line("same model, floats, Eigen").at("median_us"));
  CHECK(json.at("paper_us") == line("paper's network, Eigen").at("median_us"));
  CHECK(json.at("pose_us_warm") > 0);
  const auto bound = [&](const std::string& name) { return line(name).at("bound_us").get<double>(); };
  CHECK(json.at("bound_us") == bound("positions"));
  CHECK(bound("positions") >= line("reading as many bytes as a pose reads").at("median_us"));
  CHECK(bound("positions, halves") < bound("positions"));
  CHECK(bound("positions and normals") > bound("positions"));
  CHECK(bound("coefficients") == 0);
  const double spread = json.at("noise").at("spread"), waited = json.at("noise").at("waited");
  CHECK(line(json.at("noise").at("line")).at("spread") == spread);
  CHECK(json.at("believable") == (spread <= 0.1 && waited <= 0.05));

  const std::size_t batches = json.at("scratch_bytes").at("batches"), single = json.at("scratch_bytes").at("single");
  CHECK(single > 0);
  CHECK(batches > single);
  CHECK(json.at("morph_targets").at("shapes") > 0);
  CHECK(line("crowd of 8, 2 threads").at("clock") == "elapsed");
  CHECK(line("positions").at("clock") == "thread");

  const ToolRun printed = run_tool({"bench", archive, "--poses", "5", "--rounds", "2", "--batch", "4", "--crowd", "3",
                                    "--instances", "7", "--json", "-"});
  CHECK(printed.out.find("crowd of 3, 2 threads") != std::string::npos);
  CHECK(printed.out.find("7 instances in turn") != std::string::npos);
  CHECK(nlohmann::json::parse(printed.out).at("lines").size() == json.at("lines").size());
  CHECK(run_tool({"bench", archive, "--json", folder / "none/speed.json"}).exit_code != 0);
}

TEST_CASE("the spread between rounds is that of their medians") {
  using fb::tool::spread_between_rounds;
  CHECK(spread_between_rounds({5, 5, 5, 5}, 1) == 0);
  CHECK(spread_between_rounds({5, 9, 5, 5, 5, 1}, 2) == 0);  // single poses do not count
  CHECK(spread_between_rounds({4, 4, 4, 6, 6, 6}, 2) == doctest::Approx(2.0 / 6));
  // Of eight rounds the two quickest and the two slowest do not count.
  CHECK(spread_between_rounds({1, 1, 10, 10, 10, 10, 90, 90}, 8) == 0);
  CHECK(spread_between_rounds({1, 1, 10, 10, 10, 11, 90, 90}, 8) == doctest::Approx(0.1));
  CHECK(spread_between_rounds({}, 3) == 0);
}

TEST_CASE("a run among busy neighbours says that it is not to be believed") {
  fb::tool::Speed speed;
  speed.noise = {"positions", 0.04, 0.01};
  CHECK(fb::tool::speed_text(speed).find("The machine was quiet") != std::string::npos);
  speed.noise.waited = 0.2;
  const std::string waited = fb::tool::speed_text(speed);
  CHECK(waited.find("DO NOT BELIEVE THIS RUN") != std::string::npos);
  CHECK(waited.find("waited for 20 %") != std::string::npos);
  speed.noise = {"positions", 0.31, 0};
  CHECK(fb::tool::speed_text(speed).find("\"positions\" differ by 31 %") != std::string::npos);
  CHECK(!speed.noise.believable());

  const std::string crowded = "DO NOT BELIEVE \"crowd of 8, 2 threads\": they had 1.1 processors";
  fb::tool::SpeedLine two{"crowd of 8, 2 threads", 1, 1, 1, 0, 0, true, 1.1},
      paper{"paper's network, Eigen", 9, 9, 9, 0, 0, false};
  speed.lines = {two, paper};
  CHECK(fb::tool::speed_text(speed).find(crowded) != std::string::npos);
  speed.lines[0].processors = 1.9;
  CHECK(fb::tool::speed_text(speed).find("\": they had") == std::string::npos);
}

TEST_CASE("sparse morph targets are the face at the ends of one control and of two") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk";
  write_tiny_archive(archive);
  const facebaker::Model model(archive);
  const std::size_t width = model.control_count();
  REQUIRE(width >= 3);
  // Poses at rest but for the ends of some controls.
  std::vector<float> controls;
  const auto add = [&](const std::vector<std::uint32_t>& moved) {
    const std::vector<float> rest = model.rest_controls();
    controls.insert(controls.end(), rest.begin(), rest.end());
    for (const std::uint32_t c : moved) controls[controls.size() - width + c] = model.control(c).maximum;
  };
  for (std::uint32_t c = 0; c < width; ++c) add({c});
  for (std::uint32_t c = 1; c < width; ++c) add({0, c});
  const std::size_t two = controls.size() / width;
  fb::tool::SparseShapes shapes(model, controls);
  CHECK(shapes.corrective_count() > 0);
  CHECK(shapes.error(two) <= fb::tool::SparseShapes::threshold * 2);  // of a shape, and of a corrective
  shapes.evaluate(model.rest_controls().data());
  for (std::size_t v = 0; v < model.vertex_count(); ++v)
    for (std::size_t axis = 0; axis < 3; ++axis)
      CHECK(shapes.positions()[4 * v + axis] == model.rest_positions()[3 * v + axis]);
  CHECK(shapes.pose_bytes(model.rest_controls().data()) < shapes.pose_bytes(controls.data()));
  CHECK(shapes.pose_bytes(controls.data()) < shapes.bytes());
}

}  // namespace test_tool_bench
