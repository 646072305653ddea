#include <facebaker/facebaker_bake.h>

#include <atomic>
#include <memory>
#include <string>

#include "abi_guard.h"
#include "bake/dataset/open_source.h"
#include "bake/pipeline/bake.h"
#include "bake/rig/rig_source.h"
#include "bake/sampling/sampling.h"

using fb::fail;
using fb::Status;
using fb::capi::abi_guard;
using fb::capi::fill_struct;
using fb::capi::read_struct;
using fb::capi::require;

namespace {

// Passes progress on to a host, and its wish to stop back.
class HostProgress final : public fb::Progress {
 public:
  HostProgress(fb_progress report, void* user) : report_(report), user_(user) {}

  void begin(std::string_view stage, std::uint64_t total) override {
    stage_ = stage;
    total_ = total;
    update(0);
  }
  void update(std::uint64_t done) override {
    if (report_ && report_(user_, stage_.c_str(), done, total_) != 0) cancelled_ = true;
  }
  bool cancelled() const override { return cancelled_; }
  void note(std::string_view) override {}

 private:
  fb_progress report_;
  void* user_;
  std::string stage_;
  std::uint64_t total_ = 0;
  std::atomic<bool> cancelled_ = false;
};

std::unique_ptr<fb::bake::Source> open(const fb_source* sources, std::uint32_t count) {
  std::vector<std::string> paths;
  for (std::uint32_t s = 0; s < count; ++s) {
    if (!sources[s].path == !sources[s].rig)
      fail(Status::invalid_argument, "source %u needs either a path or a rig", s);
    if (sources[s].rig && count > 1) fail(Status::invalid_argument, "source %u is a rig; a rig is baked alone", s);
    if (sources[s].rig) return std::make_unique<fb::bake::RigSource>(*sources[s].rig);
    paths.push_back(sources[s].path);
  }
  return fb::bake::open_sources(paths);
}

fb::Parallel on(std::uint32_t threads) {
  if (threads > 4096) fail(Status::invalid_argument, "%u threads", threads);
  return {static_cast<int>(threads)};
}

}  // namespace

extern "C" {

void fb_sample_desc_fill(fb_sample_desc* to, uint32_t struct_size) {
  const fb::bake::SamplingOptions options;
  fb_sample_desc defaults = {};
  defaults.poses = options.poses;
  defaults.seed = options.seed;
  defaults.mix = "dense";
  fill_struct(to, struct_size, defaults);
}

fb_status fb_sample(const fb_sample_desc* desc) {
  return abi_guard([&] {
    require(desc, "desc");
    const fb_sample_desc known = read_struct(*desc, fb_sample_desc_init, "fb_sample_desc");
    require(known.directory, "fb_sample_desc: directory");
    require(known.mix, "fb_sample_desc: mix");
    fb::bake::SamplingOptions options;
    options.poses = known.poses;
    options.seed = known.seed;
    options.mix = known.mix;
    HostProgress progress(known.progress, known.progress_user);
    const std::unique_ptr<fb::bake::Source> source = open(&known.source, 1);
    fb::bake::sample(*source, options, known.directory, on(known.threads), progress);
  });
}

void fb_bake_desc_fill(fb_bake_desc* to, uint32_t struct_size) {
  const fb::bake::BakeOptions options;
  fb_bake_desc defaults = {};
  defaults.recipe = "hero";
  defaults.use = "backlot";
  defaults.poses = options.poses;
  defaults.seed = options.seed;
  fill_struct(to, struct_size, defaults);
}

fb_status fb_bake(const fb_bake_desc* desc) {
  return abi_guard([&] {
    require(desc, "desc");
    const fb_bake_desc known = read_struct(*desc, fb_bake_desc_init, "fb_bake_desc");
    require(known.sources, "fb_bake_desc: sources");
    require(known.archive, "fb_bake_desc: archive");
    require(known.recipe, "fb_bake_desc: recipe");
    require(known.use, "fb_bake_desc: use");
    fb::bake::BakeOptions options;
    options.recipe = known.recipe;
    options.use = fb::bake::use_from(known.use);
    options.seed = known.seed;
    options.poses = known.poses;
    options.parallel = on(known.threads);
    HostProgress progress(known.progress, known.progress_user);
    const std::unique_ptr<fb::bake::Source> source = open(known.sources, known.source_count);
    fb::bake::bake_to_file(*source, known.archive, options, progress);
  });
}

}  // extern "C"
