#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "archive/writer.h"
#include "bake/measure/verify.h"
#include "bake/migrate/version_0_2.h"
#include "bake/quantize/coarsen.h"
#include "base/file.h"
#include "base/status.h"
#include "verb_options.h"
#include "verbs.h"

namespace fb {
namespace {

struct PackVerb {
  std::string archive, out, licence;
  std::uint64_t seed = 1, max_bytes = 0;
  double max_error = 0;

  void run() const;

 private:
  std::string coarsen(Archive& face) const;
};

Archive read_any(std::span<const std::byte> bytes) {
  return is_version_0_2(bytes) ? read_version_0_2(bytes) : read_archive(bytes);
}

// What the certificate says was measured before; how far poses have moved since is added to it.
void note_repacking(std::string& certificate, double error) {
  using Json = nlohmann::ordered_json;
  const auto shallow = [](int depth, Json::parse_event_t, Json&) { return depth < 32; };
  Json json = Json::parse(certificate, shallow, false);
  if (!json.is_object()) json = Json::object();
  const auto before = json.find("repacked");
  const double earlier = before != json.end() && before->is_object() ? before->value("max", 0.0) : 0;
  json["repacked"] = {{"max", earlier + error}};
  certificate = json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// Rounds further, as the options ask; what it says is for people.
std::string PackVerb::coarsen(Archive& face) const {
  constexpr std::uint64_t other_seed = 0x9e3779b9;  // poses that the proof does not have
  std::vector<float> poses = make_proof(face.model, seed).controls;
  const std::vector<float> more = make_proof(face.model, seed ^ other_seed).controls;
  poses.insert(poses.end(), more.begin(), more.end());
  const auto with = [&](double factor) { return coarsened(face.model, factor); };
  const Coarsening choice = choose_coarsening(
      max_bytes, max_error,
      [&](double factor) {
        const PackedModel model = with(factor);
        ArchiveText text = face.text;
        if (factor > 1) note_repacking(text.certificate, 1);
        return std::uint64_t(write_archive(model, make_proof(model, seed), text).size());
      },
      [&](double factor) { return worst_difference(face.model, with(factor), poses); });
  if (choice.factor > 1) {
    face.model = with(choice.factor);
    face.proof = {};
    note_repacking(face.text.certificate, choice.error);
  }
  const bool kept = max_bytes > 0 ? choice.bytes <= max_bytes : choice.error <= max_error;
  return format(
      "steps of the basis %.3g times as large: %.3g of the diagonal from what it was, at most, on %zu poses%s\n",
      choice.factor, choice.error, poses.size() / face.model.schema.control_count(),
      kept ? "" : "; what was asked for cannot be had");
}

void PackVerb::run() const {
  const auto bytes = read_file(archive);
  Archive face = naming(archive, [&] { return read_any(bytes); });
  if (!licence.empty()) face.text.licence = licence_text(licence);
  const std::string said = max_bytes > 0 || max_error > 0 ? coarsen(face) : "";
  if (face.proof.hashes.empty()) face.proof = make_proof(face.model, seed);
  const auto packed = write_archive(face.model, face.proof, face.text);
  verify_archive(packed);
  write_file(out, packed);
  std::printf("%s: %zu bytes, format version %u.%u\n%s: %zu bytes, format version %u.%u\n%s", archive.c_str(),
              bytes.size(), face.format_version / 1000, face.format_version % 1000, out.c_str(), packed.size(),
              archive_format_version() / 1000, archive_format_version() % 1000, said.c_str());
}

}  // namespace

void add_pack(CLI::App& tool) {
  auto verb = std::make_shared<PackVerb>();
  CLI::App* app = tool.add_subcommand("pack", "Pack an archive anew, from this or an older version of the format");
  add_archive(*app, verb->archive);
  app->add_option("--out", verb->out, "The archive to write (.fbk); it appears complete or not at all")
      ->type_name("FACE.fbk")
      ->required();
  add_licence(*app, verb->licence);
  app->add_option("--max-bytes", verb->max_bytes, "Bytes the archive may have: rounded no more than they ask; 0: any")
      ->check(whole_number)
      ->type_name("N")
      ->capture_default_str();
  app->add_option(
         "--max-error", verb->max_error,
         "How far a vertex may come to lie from where it was, over the diagonal: in as few bytes as it allows; "
         "after --max-bytes; 0: nowhere else")
      ->check(CLI::NonNegativeNumber)
      ->type_name("E")
      ->capture_default_str();
  add_seed(*app, verb->seed);
  app->footer(
      "Unless rounded, the face poses as it did, to the last bit; its proof is kept, or made where it has none.");
  app->callback([verb] { verb->run(); });
}

}  // namespace fb
