// What an fb_model is.
#pragma once

#include <facebaker/facebaker.h>

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "archive/reader.h"
#include "base/memory_budget.h"
#include "host_memory.h"
#include "loaded_character.h"
#include "runtime/evaluator.h"

namespace fb::capi {

// What a call to load takes memory from: the host's, up to a limit.
struct LoadMemory {
  explicit LoadMemory(const fb_load_desc& desc)
      : host(desc.allocator), budget(desc.max_model_bytes, desc.allocator.allocate ? &host : nullptr) {}
  HostMemory host;
  MemoryBudget budget;
};

}  // namespace fb::capi

struct fb_model {
  // `from`: what the archive is charged to.
  fb_model(fb::archive::Archive archive, const fb_load_desc& desc, std::shared_ptr<fb::capi::LoadMemory> from)
      : taken(std::move(from)),
        memory(taken->host),
        budget(taken->budget),
        charged(memory, budget),
        kept(desc.allocator.allocate ? static_cast<std::pmr::memory_resource&>(budget) : charged),
        evaluator(charge_names(archive.model, budget), {desc.allocator.allocate ? &kept : nullptr, &kept},
                  fb::runtime::choose_kernels(desc.instruction_set)),
        rest_pose(archive.model.schema.rest_pose()),
        polygon_sizes(archive.model.rest.polygon_sizes.begin(), archive.model.rest.polygon_sizes.end(), &kept),
        polygon_corners(archive.model.rest.polygon_corners.begin(), archive.model.rest.polygon_corners.end(), &kept),
        uv_corners(archive.model.rest.uv_corners.begin(), archive.model.rest.uv_corners.end(), &kept),
        uvs(archive.model.rest.uvs.begin(), archive.model.rest.uvs.end(), &kept),
        diagonal(archive.model.rest.diagonal()),
        provenance(std::move(archive.model.provenance)),
        error_regions(std::move(archive.model.expected.regions)),
        character(archive.model, budget) {
    character.use_polygons(archive.model.rest, polygon_sizes.data(), polygon_corners.data(), uv_corners.data());
  }

  // Charges the names that a model copies from an archive, and the rest pose.
  static const fb::PackedModel& charge_names(const fb::PackedModel& model, fb::MemoryBudget& budget) {
    const fb::RigSchema& schema = model.schema;
    budget.take(schema.controls.size(), sizeof(fb::Control) + 3 * sizeof(float), "controls");
    budget.take(model.regions.size(), 3 * sizeof(std::string), "regions");
    budget.take_text(schema.name.size(), "names");
    for (const fb::Control& control : schema.controls)
      for (const std::string* text : {&control.name, &control.group, &control.labels.arkit, &control.labels.facs,
                                      &control.labels.unit, &control.labels.mirror})
        budget.take_text(text->size(), "names");
    budget.take(schema.channels.size(), sizeof(fb::Channel), "channels");
    for (const fb::Channel& channel : schema.channels)
      for (const std::string* text : {&channel.name, &channel.unit}) budget.take_text(text->size(), "names");
    for (const fb::PackedRegion& region : model.regions) budget.take_text(region.name.size(), "names");
    return model;
  }

  mutable std::atomic<std::uint32_t> references = 1;
  std::shared_ptr<fb::capi::LoadMemory> taken;
  fb::capi::HostMemory& memory;  // of scratches
  fb::MemoryBudget& budget;      // that the model's own memory is charged to
  fb::ChargedMemory charged;
  std::pmr::memory_resource& kept;  // of what the model is made of: a host is asked for chunks, malloc for each block
  fb::runtime::Evaluator evaluator;
  std::vector<float> rest_pose;
  std::pmr::vector<std::uint32_t> polygon_sizes, polygon_corners, uv_corners;
  std::pmr::vector<float> uvs;
  double diagonal;
  std::string provenance;
  std::vector<fb::ExpectedErrors::Region> error_regions;
  fb::capi::LoadedCharacter character;
};
