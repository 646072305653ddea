// bench_vertices RECIPE POSES SEED WORK DIVISIONS...: bakes the sample face cut finer and finer (see
// tests/rigs/dense), the same motion with more vertices, and prints errors by the number of vertices: of frames that
// were not trained on, the largest distance of the worst vertex, its 99th percentile over vertices and the rms; then
// the rms on poses held back. WORK: folder for what is sampled, which each bake removes. FB_RIG_CONTROLS of the
// environment bakes fewer controls, FB_BENCH_MIX "paper" sparser poses, FB_BENCH_EPOCHS sets the passes over them.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "bake/dataset/open_source.h"
#include "bake/pipeline/bake.h"
#include "base/status.h"

using namespace fb;
using namespace fb::bake;

namespace {

// Tells notes on the error stream.
struct Notes final : Progress {
  void begin(fb::Phase, std::string_view, std::uint64_t) override {}
  void update(std::uint64_t) override {}
  bool cancelled() const override { return false; }
  void note(std::string_view sentence) override {
    std::fprintf(stderr, "  %.*s\n", static_cast<int>(sentence.size()), sentence.data());
  }
};

void bake_and_print(const BakeOptions& options, const char* divisions) {
  setenv("FB_RIG_DIVISIONS", divisions, 1);
  Notes notes;
  const auto source = open_source(FB_PLUGIN_DENSE);
  const Baked baked = bake_face(*source, options, notes);
  const double mm = 10 * source->rest().diagonal();  // of the sample face, which is in centimetres
  const Errors& held = baked.held_back.total;
  const Errors none, &unseen = baked.independent ? baked.independent->total : none;
  const BytesRead read = baked.independent ? baked.independent->bytes_read : BytesRead();
  std::printf("| %zu | %.3f (%.2e) | %.2e | %.2e | %.3f (%.2e) | %.2e | %.2f | %.2f | %.0f |\n",
              source->rest().vertex_count(), unseen.max * mm, unseen.max, unseen.p99, unseen.rms, held.max * mm,
              held.max, held.rms, read.mean / 1e6, double(baked.archive.size()) / 1e6, baked.train_seconds);
  for (const std::string& warning : baked.warnings) std::fprintf(stderr, "  warning: %s\n", warning.c_str());
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 6) fail(Status::invalid_argument, "give RECIPE POSES SEED WORK DIVISIONS...");
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  BakeOptions options;
  options.recipe = argv[1];
  options.poses = std::strtoull(argv[2], nullptr, 10);
  options.seed = std::strtoull(argv[3], nullptr, 10);
  options.use = Use::variant;
  if (const char* mix = std::getenv("FB_BENCH_MIX")) options.mix = mix;
  if (const char* epochs = std::getenv("FB_BENCH_EPOCHS"))
    options.epochs = static_cast<std::uint32_t>(std::strtoul(epochs, nullptr, 10));
  std::printf(
      "| vertices | unseen: worst, mm (of the diagonal) | p99 | rms | held back: worst | rms | MB read a pose | "
      "archive, "
      "MB | training, s |\n| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  for (int i = 5; i < argc; ++i) {
    options.work = std::filesystem::path(argv[4]) / (options.recipe + "." + argv[i]);
    bake_and_print(options, argv[i]);
    std::filesystem::remove_all(options.work);
  }
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
