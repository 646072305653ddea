// The longest time between two reports of progress while recipes are baked: how long Ctrl-C may wait. In processor time
// of one thread, so that it does not depend on what else the machine does.
//   bench_progress SOURCE POSES EPOCHS BOUND RECIPE...
// Prints the longest gaps of each recipe; fails where one is longer than BOUND seconds.
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "bake/dataset/open_source.h"
#include "bake/pipeline/bake.h"
#include "base/status.h"

namespace {

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// What a host sees of a bake: calls of begin, update and ask.
class GapMeter final : public fb::Progress {
 public:
  struct Gap {
    double seconds;
    std::string where;
  };

  void begin(fb::Phase, std::string_view stage, std::uint64_t total) override {
    report("to " + std::string(stage));
    stage_ = std::string(stage) + " (" + std::to_string(total) + ")";
  }
  void update(std::uint64_t done) override { report("to " + std::to_string(done)); }
  bool cancelled() const override { return false; }
  void note(std::string_view) override {}
  void ask() override { report("to a question"); }

  // Gaps of more than 10 ms, the longest first, after one more report.
  const std::vector<Gap>& finish() {
    report("to the end");
    std::stable_sort(gaps_.begin(), gaps_.end(), [](const Gap& a, const Gap& b) { return a.seconds > b.seconds; });
    return gaps_;
  }
  std::size_t reports() const { return reports_; }
  double seconds() const { return last_ - start_; }

 private:
  void report(const std::string& where) {
    const double now = thread_seconds();
    if (now - last_ > 0.01) gaps_.push_back({now - last_, stage_ + " " + where});
    ++reports_;
    last_ = now;
  }

  double start_ = thread_seconds(), last_ = start_;
  std::size_t reports_ = 0;
  std::string stage_ = "start";
  std::vector<Gap> gaps_;
};

double longest_gap(fb::bake::Source& source, fb::bake::BakeOptions options) {
  GapMeter meter;
  options.parallel = {.threads = 1, .progress = &meter};
  fb::bake::bake_face(source, options, meter);
  const auto& gaps = meter.finish();
  std::printf("%s: %zu reports in %.1f s\n", options.recipe.c_str(), meter.reports(), meter.seconds());
  for (std::size_t i = 0; i < std::min<std::size_t>(5, gaps.size()); ++i)
    std::printf("  %6.3f s  %s\n", gaps[i].seconds, gaps[i].where.c_str());
  return gaps.empty() ? 0 : gaps[0].seconds;
}

}  // namespace

int main(int argc, char** argv) try {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  if (argc < 6) fb::fail(fb::Status::invalid_argument, "bench_progress SOURCE POSES EPOCHS BOUND RECIPE...");
  const auto source = fb::bake::open_source(std::string(argv[1]));
  const double bound = std::atof(argv[4]);
  bool kept = true;
  for (int i = 5; i < argc; ++i) {
    fb::bake::BakeOptions options;
    options.recipe = argv[i];
    options.poses = static_cast<std::uint64_t>(std::atoll(argv[2]));
    options.epochs = static_cast<std::uint32_t>(std::atoi(argv[3]));
    options.work = std::filesystem::temp_directory_path() / ("fb_bench_progress_" + std::to_string(::getpid()));
    std::filesystem::remove_all(options.work);
    kept = longest_gap(*source, options) <= bound && kept;
    std::filesystem::remove_all(options.work);
  }
  return kept ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "bench_progress: %s\n", error.what());
  return 1;
}
