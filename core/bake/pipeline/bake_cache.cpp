#include "bake/pipeline/bake_cache.h"

#include <nlohmann/json.hpp>
#include <optional>

#include "archive/writer.h"
#include "bake/measure/verify.h"
#include "bake/pipeline/recipe_table.h"
#include "bake/rig/character_json.h"
#include "bake/rig/json_field.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/keep_asking.h"
#include "base/output_lock.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "figures/json_fields.h"

namespace fb::bake {

namespace {

using Json = nlohmann::json;

constexpr const char* archive_name = "face.fbk";
constexpr const char* figures_name = "bake.json";

// What the archive tells besides the mesh: names and meanings of controls, meshes, materials, images and sockets.
nlohmann::ordered_json described(const Source& data) {
  nlohmann::ordered_json description = {{"name", data.schema().name}, {"units", data.schema().units}};
  for (const Control& control : data.schema().controls) {
    nlohmann::ordered_json& labels = description["controls"].emplace_back();
    labels["name"] = control.name;
    write_labels(control, labels);
  }
  const Character& character = data.character();
  write_character(
      data.rest().parts, character,
      [&](std::size_t i, nlohmann::ordered_json& image) { image["hash"] = hash64(character.images[i].bytes); },
      description);
  if (const Skin& skin = character.skin; skin.influences > 0)
    description["skin"] = hash64_of<std::uint16_t>(skin.joints, hash64_of<float>(skin.weights));
  return description;
}

// Hash of everything that the result depends on; options that change only the speed are left out.
std::uint64_t cache_key(Source& data, const RigEvaluator* rig, const BakeOptions& options) {
  const PoseSet poses = training_poses(data, options.use), sample = poses.subsampled(16);
  std::vector<float> points(sample.size() * data.rest().points.size());
  sample.read_points(0, sample.size(), points);
  const bool evaluates_rig = find_recipe(options.recipe).evaluates_rig;
  Json fields = {FB_VERSION, options.recipe, name_of(options.use), evaluates_rig ? options.rig_budget : 0,
                 rig != nullptr};
  for (const OptionRow& row : option_table)
    if (row.changes_face) fields.push_back(option_text(options, row));
  for (const double share : options.level_shares) fields.push_back(share);
  for (const auto& mesh : options.level_meshes) fields.push_back(hash64(read_file(mesh)));
  const std::uint64_t samples = hash64_of<float>(poses.controls(), hash64_of<float>(points));
  const Mesh& rest = data.rest();
  fields.push_back(described(data).dump(-1, ' ', false, Json::error_handler_t::replace));
  const std::uint64_t mesh = hash64_of<std::uint32_t>(rest.uv_corners, hash64_of<float>(rest.uvs, samples));
  return hash64_of<char>(fields.dump(), hash64_of<std::uint32_t>(rest.polygon_corners, mesh));
}

// Of bake.json, besides what it is of.
template <class Visit, MaybeConst<Baked> Struct>
void visit_cached(Visit& visit, Struct& baked) {
  visit("poses", baked.poses);
  visit("coefficients", baked.coefficients);
  visit("parameters", baked.parameters);
  visit("train_seconds", baked.train_seconds);
  visit.object("quantisation", [&](auto& quantisation) {
    visit_distances(quantisation, baked.quantisation);
    quantisation("worst_frame", baked.quantisation.worst_frame);
  });
  visit.object("stats", [&](auto& stats) {
    stats("bones", baked.stats.bones);
    stats("rig_calls", baked.stats.rig_calls);
    visit_fields(stats, baked.stats);
  });
}

// None if it is missing, damaged or of another key.
std::optional<Baked> load(const std::filesystem::path& folder, std::uint64_t key) {
  if (!std::filesystem::exists(folder / figures_name) || !std::filesystem::exists(folder / archive_name))
    return std::nullopt;
  const std::vector<std::byte> text = read_file(folder / figures_name);
  const Json json = object_in({reinterpret_cast<const char*>(text.data()), text.size()});
  Baked baked;
  baked.archive = read_file(folder / archive_name);
  try {
    const FieldReader reader(json);
    std::uint64_t of_key = 0, of_archive = 0;
    reader("key", of_key);
    reader("archive", of_archive);
    if (of_key != key || of_archive != hash64(baked.archive)) return std::nullopt;
    visit_cached(reader, baked);
    return baked;
  } catch (const Error&) {
    return std::nullopt;
  }
}

void save(const std::filesystem::path& folder, std::uint64_t key, const Baked& baked) {
  Json json = {{"key", key}, {"archive", hash64(baked.archive)}};
  FieldWriter writer(json);
  visit_cached(writer, baked);
  write_verified_archive(folder / archive_name, baked.archive);
  write_file(folder / figures_name, json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace

Baked cached_bake(Source& data, RigEvaluator* rig, const BakeOptions& options, Progress& progress) {
  const OutputLock lock = OutputLock::of_folder(options.work);
  const std::uint64_t key = cache_key(data, rig, options);
  if (std::optional<Baked> earlier = load(options.work, key)) {
    progress.note("taken from " + shown(options.work) + ", where it was baked before");
    return std::move(*earlier);
  }
  PackedFace face = train_and_pack(data, rig, options, progress);
  Baked baked = std::move(face.baked);
  keep_asking(progress, [&] {
    baked.archive = archive::write_archive(face.model, face.proof, {options.licence, {}});
    save(options.work, key, baked);
  });
  return baked;
}

}  // namespace fb::bake
