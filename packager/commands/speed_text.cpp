#include "commands/speed_text.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/status.h"
#include "report/table.h"

namespace fb::tool {
namespace {

// How many times faster than the paper's network under the same condition ("cold: "); "" where that makes no sense.
std::string ratio(const Speed& speed, const SpeedLine& line) {
  const std::size_t colon = line.name.find(": ");
  const std::string condition = colon == std::string::npos ? "" : line.name.substr(0, colon + 2);
  if (line.name.find("reading") == 0 || line.name.find("writing") != std::string::npos) return "";
  return format("%.1f", speed.line(condition + "paper's network, Eigen").median / line.median);
}

// Whether to believe the figures, and why.
std::string noise_text(const Noise& noise) {
  const std::string differ = format("rounds of \"%s\" differ by %.0f %%, and the thread waited for %.0f %% of the time",
                                    noise.line.c_str(), 100 * noise.spread, 100 * noise.waited);
  if (noise.believable()) return "The machine was quiet: " + differ + ".\n";
  return "DO NOT BELIEVE THIS RUN: " + differ +
         "; other programs were at work. Measure again when they rest, or compare ratios within this run only.\n";
}

// About lines of two threads that had no two processors, as others used them or the system put both on one.
std::string processors_text(const std::vector<SpeedLine>& lines) {
  std::string text;
  for (const SpeedLine& line : lines)
    if (line.processors > 0 && line.processors < 1.5 && line.name.find("2 threads") != std::string::npos)
      text +=
          format("DO NOT BELIEVE \"%s\": they had %.1f processors on average.\n", line.name.c_str(), line.processors);
  return text;
}

// The figure "batch of N: what".
const SpeedLine& batch_line(const Speed& speed, const std::string& what) {
  const auto found = std::find_if(speed.lines.begin(), speed.lines.end(), [&](const SpeedLine& line) {
    return line.name.find("batch of ") == 0 && line.name.substr(line.name.find(": ") + 2) == what;
  });
  if (found == speed.lines.end()) fail(Status::not_found, "no figure of batches \"%s\"", what.c_str());
  return *found;
}

// To a tenth of a nanosecond.
double rounded(double microseconds) {
  return std::round(microseconds * 1e4) / 1e4;
}

}  // namespace

std::string speed_text(const Speed& speed) {
  Table table({"one thread, microseconds a pose", "least", "median", "p99", "spread, %", "times the paper's",
               "times the bound", "kB", "GB/s"});
  for (const SpeedLine& line : speed.lines)
    table.add({line.name, format("%.1f", line.least), format("%.1f", line.median), format("%.1f", line.p99),
               format("%.0f", 100 * line.spread), ratio(speed, line),
               line.bound > 0 ? format("%.1f", line.median / line.bound) : "",
               line.bytes > 0 ? format("%.0f", line.bytes * 1e-3) : "",
               line.bytes > 0 ? format("%.1f", line.bytes * 1e-3 / line.median) : ""});
  return table.text() +
         format("%s; %s, %s\nposes: %s; Eigen: %s; loading: %.1f ms\n", speed.processor.c_str(), speed.compiler.c_str(),
                speed.flags.c_str(), speed.instruction_set.c_str(), speed.eigen.c_str(), speed.load * 1e-3) +
         format(
             "scratch: %.2f MB for batches, %.2f MB for single poses\n"
             "morph targets: %zu, and %zu correctives, %.1f MB; they are off by %.1e of the diagonal, rms\n",
             double(speed.scratch.batches) * 1e-6, double(speed.scratch.single) * 1e-6, speed.morphs.shapes,
             speed.morphs.correctives, double(speed.morphs.bytes) * 1e-6, speed.morphs.error) +
         noise_text(speed.noise) + processors_text(speed.lines);
}

std::string speed_json(const Speed& speed) {
  using Json = nlohmann::ordered_json;
  Json lines = Json::array();
  for (const SpeedLine& line : speed.lines)
    lines.push_back({{"name", line.name},
                     {"least_us", rounded(line.least)},
                     {"median_us", rounded(line.median)},
                     {"p99_us", rounded(line.p99)},
                     {"spread", line.spread},
                     {"bytes", line.bytes},
                     {"bound_us", rounded(line.bound)},
                     {"clock", line.elapsed ? "elapsed" : "thread"},
                     {"processors", line.processors}});
  const Json json = {
      {"pose_us_warm", rounded(speed.line("positions").median)},
      {"pose_us_cold", rounded(speed.line("cold: positions").median)},
      {"batch_us_per_pose", rounded(batch_line(speed, "positions").median)},
      {"bound_us", rounded(speed.line("positions").bound)},
      {"eigen_fp32_us", rounded(speed.line("same model, floats, Eigen").median)},
      {"paper_us", rounded(speed.line("paper's network, Eigen").median)},
      {"load_us", rounded(speed.load)},
      {"scratch_bytes", {{"batches", speed.scratch.batches}, {"single", speed.scratch.single}}},
      {"morph_targets",
       {{"shapes", speed.morphs.shapes},
        {"correctives", speed.morphs.correctives},
        {"bytes", speed.morphs.bytes},
        {"rms", speed.morphs.error}}},
      {"believable", speed.noise.believable()},
      {"noise", {{"line", speed.noise.line}, {"spread", speed.noise.spread}, {"waited", speed.noise.waited}}},
      {"processor", speed.processor},
      {"compiler", speed.compiler},
      {"flags", speed.flags},
      {"instruction_set", speed.instruction_set},
      {"eigen", speed.eigen},
      {"lines", lines}};
  return json.dump(2) + "\n";
}

std::string speed_csv(const Speed& speed) {
  const auto quoted = [](const std::string& text) { return '"' + text + '"'; };
  std::string csv = "processor,compiler,flags,instruction set,Eigen,figure,least us,median us,p99 us,bytes,spread\n";
  const std::string begin = quoted(speed.processor) + ',' + quoted(speed.compiler) + ',' + quoted(speed.flags) + ',' +
                            quoted(speed.instruction_set) + ',' + quoted(speed.eigen) + ',';
  for (const SpeedLine& line : speed.lines)
    csv += begin + quoted(line.name) +
           format(",%.3f,%.3f,%.3f,%.0f,%.4f\n", line.least, line.median, line.p99, line.bytes, line.spread);
  return csv + begin + quoted("loading") + format(",%.3f,,,,\n", speed.load);
}

}  // namespace fb::tool
