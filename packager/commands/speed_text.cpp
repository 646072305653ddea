#include "commands/speed_text.h"

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

}  // namespace

std::string speed_text(const Speed& speed) {
  Table table({"one thread, microseconds a pose", "least", "median", "p99", "times the paper's", "kB", "GB/s"});
  for (const SpeedLine& line : speed.lines)
    table.add({line.name, format("%.1f", line.least), format("%.1f", line.median), format("%.1f", line.p99),
               ratio(speed, line), line.bytes > 0 ? format("%.0f", line.bytes * 1e-3) : "",
               line.bytes > 0 ? format("%.1f", line.bytes * 1e-3 / line.median) : ""});
  return table.text() + format("%s; %s, %s\nposes: %s; Eigen: %s; loading: %.1f ms\n", speed.processor.c_str(),
                               speed.compiler.c_str(), speed.flags.c_str(), speed.instruction_set.c_str(),
                               speed.eigen.c_str(), speed.load * 1e-3);
}

std::string speed_csv(const Speed& speed) {
  const auto quoted = [](const std::string& text) { return '"' + text + '"'; };
  std::string csv = "processor,compiler,flags,instruction set,Eigen,figure,least us,median us,p99 us,bytes\n";
  const std::string begin = quoted(speed.processor) + ',' + quoted(speed.compiler) + ',' + quoted(speed.flags) + ',' +
                            quoted(speed.instruction_set) + ',' + quoted(speed.eigen) + ',';
  for (const SpeedLine& line : speed.lines)
    csv += begin + quoted(line.name) + format(",%.3f,%.3f,%.3f,%.0f\n", line.least, line.median, line.p99, line.bytes);
  return csv + begin + quoted("loading") + format(",%.3f,,,\n", speed.load);
}

}  // namespace fb::tool
