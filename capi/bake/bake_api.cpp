#include <algorithm>
#include <array>

#include "bake/authoring.h"
#include "bake/measure/locality.h"
#include "bake/pipeline/recipe_table.h"
#include "bake/rig/foreign_call.h"
#include "base/sha256.h"

using namespace fb::capi;

namespace {

const std::vector<std::string>& recipes() {
  static const std::vector<std::string> names = fb::bake::recipe_names();
  return names;
}

// The poses that a description names.
std::vector<std::string> exact_of(const fb_bake_desc& desc) {
  std::vector<std::string> names;
  for (std::uint32_t i = 0; i < desc.exact_count; ++i) {
    require(desc.exact, "fb_bake_desc: exact");
    require(desc.exact[i], "fb_bake_desc: one of exact");
    names.emplace_back(desc.exact[i]);
  }
  return names;
}

// What the host draws.
std::vector<std::byte> drawn_thumbnail(const fb_bake_desc& desc, std::span<const std::byte> archive) {
  std::vector<std::byte> png(FB_THUMBNAIL_BYTES);
  std::uint64_t size = 0;
  std::array<char, 512> message{};
  const fb_status status = fb::bake::foreign_call("draw_thumbnail", [&] {
    return desc.draw_thumbnail(desc.thumbnail_user, archive.data(), archive.size(), png.data(), &size, message.data(),
                               static_cast<std::uint32_t>(message.size()));
  });
  message.back() = '\0';
  if (status != FB_OK) {
    const bool known = status == FB_ERROR_INTERRUPTED || status == FB_ERROR_OUT_OF_MEMORY;
    fail(known ? static_cast<fb::Status>(status) : fb::Status::internal, "%s",
         message[0] ? message.data() : fb::format("draw_thumbnail returned %d without a message", status).c_str());
  }
  if (size > png.size())
    fail(fb::Status::limit, "draw_thumbnail wrote %llu bytes; a thumbnail may have %u",
         static_cast<unsigned long long>(size), FB_THUMBNAIL_BYTES);
  png.resize(size);
  return png;
}

// desc must outlive the options.
fb::bake::BakeOptions options_of(const fb_bake_desc& desc, const fb::bake::Source& source, fb::Progress& progress) {
  require(desc.recipe, "fb_bake_desc: recipe");
  fb::bake::BakeOptions options = training_options(desc, "fb_bake_desc", progress);
  options.recipe = desc.recipe;
  options.use = use_of(desc.use);
  options.examples = examples_of(desc, source, progress);
  options.exact = exact_of(desc);
  options.licence = text_or_empty(desc.licence);
  options.created = text_or_empty(desc.created);
  options.about = text_or_empty(desc.about);
  options.thumbnail = bytes_or_none(desc.thumbnail, desc.thumbnail_bytes);
  if (desc.draw_thumbnail)
    options.draw_thumbnail = [&desc](std::span<const std::byte> archive) { return drawn_thumbnail(desc, archive); };
  for (const std::filesystem::path& file : desc.source->files)
    options.source_files.push_back(
        {file.filename().string(), std::filesystem::file_size(file), fb::sha256_of_file(file)});
  if (desc.level_share_count > 0) require(desc.level_shares, "fb_bake_desc: level_shares");
  for (std::uint32_t i = 0; i < desc.level_share_count; ++i) options.level_shares.push_back(desc.level_shares[i]);
  if (desc.level_mesh_count > 0) require(desc.level_meshes, "fb_bake_desc: level_meshes");
  for (std::uint32_t i = 0; i < desc.level_mesh_count; ++i) {
    require(desc.level_meshes[i], "fb_bake_desc: one of level_meshes");
    options.level_meshes.emplace_back(reinterpret_cast<const char8_t*>(desc.level_meshes[i]));
  }
  options.reuse = text_or_empty(desc.reuse);
  return options;
}

// Within what the bake left of the rig's budget.
void measure_locality(fb_report& report, fb::bake::Source& source, const fb::bake::BakeOptions& options,
                      std::uint64_t asked, fb::Progress& progress) {
  const std::uint64_t left =
      options.rig_budget > 0 ? options.rig_budget - std::min(options.rig_budget, asked) : UINT64_MAX;
  const auto locality = fb::bake::locality_within(left, source.schema().control_count());
  fb::MethodReport& face = report.faces.methods[0];
  const std::array<std::span<const std::byte>, 1> archives = {face.archive};
  if (!source.live()) {
    for (auto& recorded : fb::bake::recorded_locality(archives, source, options.parallel, progress))
      face.locality = std::move(recorded);
    return;
  }
  if (!locality) return;
  fb::bake::RigEvaluator rig(source, options.parallel);
  face.locality = fb::bake::measure_locality(archives, rig, *locality, progress).at(0);
}

std::unique_ptr<fb_report> report_of(const fb_bake_desc& desc, fb::bake::Baked baked, const fb::bake::Source& source) {
  auto report = std::make_unique<fb_report>();
  report->json = bake_json(desc.archive, source, baked);
  report->quantisation = baked.quantisation;
  report->faces.name = source.schema().name;
  report->faces.units = source.schema().units;
  report->faces.diagonal = source.rest().diagonal();
  report->faces.rig_calls = baked.rig_calls;
  report->faces.asked_by_stage = baked.asked_by_stage;
  fb::MethodReport& face = report->faces.methods.emplace_back();
  face.name = desc.recipe;
  face.use = name_of(use_of(desc.use));
  face.dependency = baked.dependency;
  if (baked.independent && (desc.measure & FB_MEASURE_QUALITY)) {
    face.independent = std::move(*baked.independent);
    report->faces.measured_split = face.independent.clips.at(0).split;
  }
  static_cast<fb::BakedFace&>(face) = std::move(baked);
  return report;
}

}  // namespace

extern "C" {

uint32_t fb_recipe_count(void) {
  return static_cast<uint32_t>(recipes().size());
}

const char* fb_recipe_name(uint32_t index) {
  return index < recipes().size() ? recipes()[index].c_str() : nullptr;
}

void fb_bake_desc_fill(fb_bake_desc* to, uint32_t struct_size) {
  fb_bake_desc defaults = {};
  fill_options(defaults);
  defaults.recipe = "hero";
  defaults.use = FB_USE_BACKLOT;
  fill_struct(to, struct_size, defaults);
}

fb_status fb_bake(const fb_bake_desc* desc, fb_report** report) {
  return abi_guard([&] {
    require(desc, "desc");
    const fb_bake_desc known = read_struct(*desc, fb_bake_desc_init, "fb_bake_desc");
    fb::bake::Source& source = source_of(known.source, "fb_bake_desc: source");
    require(known.archive, "fb_bake_desc: archive");
    HostProgress progress(known.callbacks);
    const fb::bake::BakeOptions options = options_of(known, source, progress);
    fb::bake::Baked baked = fb::bake::bake_to_file(source, known.archive, options, progress);
    const std::uint64_t asked = baked.asked;
    auto made = report_of(known, std::move(baked), source);
    if (known.measure & FB_MEASURE_LOCALITY) measure_locality(*made, source, options, asked, progress);
    hand_over(std::move(made), report);
  });
}

}  // extern "C"
