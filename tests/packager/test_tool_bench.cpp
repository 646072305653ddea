#include <doctest/doctest.h>

#include <algorithm>
#include <sstream>

#include "base/file.h"
#include "tool_files.h"
#include "tool_run.h"

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
        "same model, floats, Eigen", "paper's network, Eigen", "cold: positions", "cold: paper's network, Eigen",
        "batch of 4: positions", "batch of 4: paper's network, Eigen", "batch of 4: writing alone"}) {
    CHECK_MESSAGE(median_of(figures, figure) > 0, std::string(figure));
    CHECK_MESSAGE(run.out.find(figure) != std::string::npos, std::string(figure));
  }
  CHECK(figures.find("processor,compiler,flags,instruction set") == 0);
  const std::size_t lines = std::count(figures.begin(), figures.end(), '\n');
  CHECK(lines > 15);
  // 8 layers of 256 and a dense basis take longer than 30 vertices.
  CHECK(median_of(figures, "paper's network, Eigen") > median_of(figures, "positions"));
}
