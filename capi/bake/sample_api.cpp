#include <cmath>

#include "bake/authoring.h"
#include "bake/dataset/schema_source.h"
#include "bake/sampling/planned_folder.h"
#include "bake/sampling/sampling.h"
#include "base/checked.h"

using fb::fail;
using fb::Status;
using namespace fb::capi;

namespace {

fb::bake::Clip clip_of(const fb_rig_clip& from, std::uint32_t index, std::size_t controls) {
  if (!from.name || !*from.name) fail(Status::invalid_argument, "fb_sample_desc: clip %u has no name", index);
  if (from.kind < FB_CLIP_SHOT || from.kind > FB_CLIP_DENSE)
    fail(Status::invalid_argument, "clip \"%s\" is of unknown kind %d", from.name, from.kind);
  if (from.split < FB_SPLIT_TRAIN || from.split > FB_SPLIT_TEST)
    fail(Status::invalid_argument, "clip \"%s\" belongs to unknown split %d", from.name, from.split);
  if (!std::isfinite(from.fps) || from.fps <= 0)
    fail(Status::invalid_argument, "clip \"%s\" has %g frames a second", from.name, from.fps);
  if (!from.controls) fail(Status::invalid_argument, "the controls of clip \"%s\" are null", from.name);
  const std::size_t values = fb::checked_multiply(from.frames, controls, "frames x controls");
  return {from.name,   static_cast<fb::bake::ClipKind>(from.kind), static_cast<fb::bake::Split>(from.split), from.fps,
          from.frames, {from.controls, from.controls + values}};
}

fb::bake::SamplingOptions options_of(const fb_sample_desc& desc, std::size_t controls) {
  fb::bake::BakeOptions common;
  read_options(desc, "fb_sample_desc", common);
  fb::bake::SamplingOptions options;
  options.poses = fb::bake::poses_or_usual(common.poses, common.rig_budget);
  options.seed = common.seed;
  options.mix = common.mix;
  options.shots = desc.shots != 0;
  options.rig_budget = common.rig_budget;
  options.skip_failing = common.skip_failing;
  if (desc.clip_count == 0) return options;
  require(desc.clips, "fb_sample_desc: clips");
  if (desc.clip_stride < sizeof(fb_rig_clip) || desc.clip_stride % alignof(fb_rig_clip) != 0)
    fail(Status::invalid_argument, "fb_sample_desc: clip_stride is %u bytes", desc.clip_stride);
  for (std::uint32_t c = 0; c < desc.clip_count; ++c)
    options.extra.push_back(clip_of(element(desc.clips, desc.clip_stride, c), c, controls));
  return options;
}

// What to plan poses for: the schema, where one is given, else the source.
fb::bake::Source& planned_source(const fb_sample_desc& desc, std::unique_ptr<fb::bake::SchemaSource>& schema) {
  if (!desc.schema) return source_of(desc.source, "fb_sample_desc: source");
  if (desc.source) fail(Status::invalid_argument, "fb_sample_desc: either a source or a schema, not both");
  schema = std::make_unique<fb::bake::SchemaSource>(desc.schema);
  return *schema;
}

// Of poses drawn to test a plan with, in proportion to those to learn from, which a slow program evaluates.
std::size_t test_poses_of_plan(std::uint64_t poses) {
  return std::min<std::uint64_t>(fb::bake::SamplingOptions().drawn_test_poses, poses / 5);
}

}  // namespace

extern "C" {

void fb_sample_desc_fill(fb_sample_desc* to, uint32_t struct_size) {
  fb_sample_desc defaults = {};
  fill_options(defaults);
  defaults.shots = 1;
  defaults.clip_stride = sizeof(fb_rig_clip);
  fill_struct(to, struct_size, defaults);
}

fb_status fb_sample(const fb_sample_desc* desc, fb_report** report) {
  return abi_guard([&] {
    require(desc, "desc");
    const fb_sample_desc known = read_struct(*desc, fb_sample_desc_init, "fb_sample_desc");
    fb::bake::Source& source = source_of(known.source, "fb_sample_desc: source");
    require(known.directory, "fb_sample_desc: directory");
    if (!source.live())
      fail(Status::invalid_argument,
           "\"%s\" is a recording, which has no new poses; sample a rig plugin, a glTF file or \"sample\"",
           source.schema().name.c_str());
    HostProgress progress(known.callbacks);
    fb::bake::RigEvaluator rig(source, parallel_of(known.threads, &progress));
    fb::bake::SamplingOptions options = options_of(known, source.schema().control_count());
    options.examples = examples_of(known, source, progress);
    const fb::bake::SampleReport sampled = fb::bake::sample(rig, options, known.directory, progress);
    auto made = std::make_unique<fb_report>();
    made->json = sample_json(known.directory, sampled);
    made->sample =
        fb_sample_result{0, 0, sampled.poses, sampled.evaluated, sampled.rig_calls, sampled.asked, sampled.left_out};
    hand_over(std::move(made), report);
  });
}

fb_status fb_plan(const fb_sample_desc* desc, fb_report** report) {
  return abi_guard([&] {
    require(desc, "desc");
    const fb_sample_desc known = read_struct(*desc, fb_sample_desc_init, "fb_sample_desc");
    std::unique_ptr<fb::bake::SchemaSource> schema;
    fb::bake::Source& source = planned_source(known, schema);
    require(known.directory, "fb_sample_desc: directory");
    HostProgress progress(known.callbacks);
    fb::bake::SamplingOptions options = options_of(known, source.schema().control_count());
    options.rig_budget = 0;
    options.shots = options.shots && source.live();
    options.drawn_test_poses = test_poses_of_plan(options.poses);
    options.examples = fb::bake::read_examples(example_files(known), source, progress);
    const fb::bake::PosePlan plan =
        fb::bake::plan_poses(source, options, parallel_of(known.threads, &progress), progress);
    fb::bake::write_plan_folder(source, plan, known.directory);
    std::uint64_t poses = 0;
    for (const fb::bake::Clip& clip : plan) poses += clip.frames;
    auto made = std::make_unique<fb_report>();
    made->json = plan_json(known.directory, plan, source.rest().vertex_count() > 0);
    made->sample = fb_sample_result{0, 0, poses, 0, 0, 0, 0};
    hand_over(std::move(made), report);
  });
}

}  // extern "C"
