#include "bake/authoring.h"
#include "bake/measure/bytes_read.h"
#include "bake/measure/certificate.h"
#include "base/file.h"
#include "base/shown_path.h"
#include "model/feature_values.h"
#include "runtime/evaluator.h"

using fb::fail;
using fb::Status;
using namespace fb::capi;

namespace {

std::unique_ptr<fb_archive> read(std::string name, std::vector<std::byte> bytes) {
  auto archive = std::make_unique<fb_archive>();
  archive->contents = fb::archive::read_archive(bytes);
  archive->recipe = recipe_of(archive->contents);
  archive->certificate_summary = fb::bake::certificate_summary(archive->contents.text.certificate);
  archive->rest_controls = archive->contents.model.schema.rest_pose();
  archive->name = std::move(name);
  archive->bytes = std::move(bytes);
  return archive;
}

const fb::PackedModel& model_of(const fb_archive* archive) {
  require(archive, "archive");
  return archive->contents.model;
}

const fb::PackedRegion& region_at(const fb_archive* archive, std::uint32_t index) {
  const auto& regions = model_of(archive).regions;
  if (index >= regions.size()) fail(Status::invalid_argument, "region %u of %zu", index, regions.size());
  return regions[index];
}

const fb::PackedLayer& layer_at(const fb_archive* archive, std::uint32_t region, std::uint32_t index) {
  const auto& layers = region_at(archive, region).layers;
  if (index >= layers.size()) fail(Status::invalid_argument, "layer %u of %zu", index, layers.size());
  return layers[index];
}

fb_archive_info info_of(const fb_archive& archive) {
  const fb::archive::Archive& contents = archive.contents;
  const fb::PackedModel& model = contents.model;
  fb_archive_info info = {};
  info.format_version = contents.format_version;
  info.bytes = archive.bytes.data();
  info.byte_count = archive.bytes.size();
  info.name = model.schema.name.c_str();
  info.recipe = archive.recipe.c_str();
  info.licence = contents.text.licence.c_str();
  info.certificate_summary = archive.certificate_summary.c_str();
  info.certificate = contents.text.certificate.c_str();
  info.provenance = model.provenance.c_str();
  info.section_count = static_cast<std::uint32_t>(contents.sections.size());
  info.note_count = static_cast<std::uint32_t>(contents.notes.size());
  info.proof_poses = static_cast<std::uint32_t>(contents.proof.hashes.size());
  info.proof_vertices = static_cast<std::uint32_t>(contents.proof.vertices.size());
  info.vertex_count = static_cast<std::uint32_t>(model.rest.surface_vertex_count());
  info.control_count = static_cast<std::uint32_t>(model.schema.control_count());
  info.feature_count = static_cast<std::uint32_t>(model.features.size());
  info.direct_count = static_cast<std::uint32_t>(model.direct.size());
  info.region_count = static_cast<std::uint32_t>(model.regions.size());
  info.coefficient_count = model.columns;
  info.parameter_count = model.parameter_count();
  info.value_count = model.value_count();
  info.about = model.character.about.c_str();
  info.thumbnail = model.character.thumbnail.empty() ? nullptr : model.character.thumbnail.data();
  info.thumbnail_bytes = model.character.thumbnail.size();
  return info;
}

}  // namespace

extern "C" {

fb_status fb_archive_open(const char* path, fb_archive** archive) {
  return abi_guard([&] {
    require(path, "path");
    require(archive, "archive");
    std::vector<std::byte> bytes = fb::read_file(path);
    *archive = fb::with_path(path, [&] { return read(path, std::move(bytes)); }).release();
  });
}

fb_status fb_archive_open_memory(const void* bytes, uint64_t size, const char* name, fb_archive** archive) {
  return abi_guard([&] {
    require(bytes, "bytes");
    require(archive, "archive");
    const auto* first = static_cast<const std::byte*>(bytes);
    *archive = read(name ? name : "memory", {first, first + size}).release();
  });
}

void fb_archive_close(fb_archive* archive) {
  delete archive;
}

void fb_archive_info_fill(fb_archive_info* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_archive_describe(const fb_archive* archive, fb_archive_info* info) {
  return abi_guard([&] {
    require(archive, "archive");
    write_struct(info, info_of(*archive), "fb_archive_info");
  });
}

void fb_section_fill(fb_section* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_archive_section_at(const fb_archive* archive, uint32_t index, fb_section* section) {
  return abi_guard([&] {
    require(archive, "archive");
    const auto& sections = archive->contents.sections;
    if (index >= sections.size()) fail(Status::invalid_argument, "section %u of %zu", index, sections.size());
    const fb::archive::SectionInfo& found = sections[index];
    write_struct(section, {0, 0, found.name.c_str(), found.stored_bytes, found.raw_bytes}, "fb_section");
  });
}

const char* fb_archive_note_at(const fb_archive* archive, uint32_t index) {
  return archive && index < archive->contents.notes.size() ? archive->contents.notes[index].c_str() : nullptr;
}

fb_status fb_archive_pose_bytes(const fb_archive* archive, const float* controls, uint64_t poses, uint64_t* bytes) {
  return abi_guard([&] {
    const fb::PackedModel& model = model_of(archive);
    require(controls, "controls");
    require(bytes, "bytes");
    const fb::bake::BytesReadCounter count(model);
    const std::size_t width = model.schema.control_count();
    for (std::uint64_t pose = 0; pose < poses; ++pose) bytes[pose] = count.of_pose({controls + pose * width, width});
  });
}

fb_status fb_archive_features(const fb_archive* archive, const float* controls, float* features) {
  return abi_guard([&] {
    const fb::PackedModel& model = model_of(archive);
    require(controls, "controls");
    require(features, "features");
    feature_values(model.features, controls, archive->rest_controls.data(), features);
  });
}

const uint32_t* fb_archive_direct(const fb_archive* archive) {
  return archive ? archive->contents.model.direct.data() : nullptr;
}

void fb_region_fill(fb_region* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_archive_region_at(const fb_archive* archive, uint32_t index, fb_region* region) {
  return abi_guard([&] {
    const fb::PackedRegion& found = region_at(archive, index);
    write_struct(region,
                 {0, static_cast<std::uint32_t>(found.layers.size()), found.name.c_str(), found.features.data(),
                  static_cast<std::uint32_t>(found.features.size()),
                  static_cast<std::uint32_t>(found.gate.features.size()), found.gate.features.data()},
                 "fb_region");
  });
}

void fb_layer_fill(fb_layer* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_archive_layer_at(const fb_archive* archive, uint32_t region, uint32_t layer, fb_layer* to) {
  return abi_guard([&] {
    const fb::PackedLayer& found = layer_at(archive, region, layer);
    write_struct(to,
                 {0, found.inputs, found.outputs, static_cast<std::int32_t>(found.activation), found.skip ? 1u : 0u,
                  found.wide ? 16u : 8u},
                 "fb_layer");
  });
}

fb_status fb_archive_layer_values(const fb_archive* archive, uint32_t region, uint32_t layer, float* weights,
                                  float* bias) {
  return abi_guard([&] {
    const fb::PackedLayer& found = layer_at(archive, region, layer);
    require(weights, "weights");
    require(bias, "bias");
    for (std::size_t i = 0; i < found.weights.size(); ++i)
      weights[i] = found.scales[i / found.inputs] * static_cast<float>(found.weights[i]);
    std::copy(found.bias.begin(), found.bias.end(), bias);
  });
}

fb_status fb_inspect(const fb_archive* archive, fb_report** report) {
  return abi_guard([&] {
    const fb::PackedModel& model = model_of(archive);
    require(report, "report");
    auto made = std::make_unique<fb_report>();
    const std::uint64_t runtime_bytes = fb::runtime::Evaluator(model).bytes();
    made->json = inspect_json(archive->name, archive->contents, archive->bytes.size(), runtime_bytes);
    *report = made.release();
  });
}

}  // extern "C"
