#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "archive/migrate/version_0_2.h"
#include "archive/writer.h"
#include "bake/compress/step_scaling.h"
#include "bake/measure/certificate.h"
#include "bake/measure/verify.h"
#include "base/file.h"
#include "base/status.h"
#include "commands/command_options.h"
#include "commands/commands.h"

namespace fb::tool {
using namespace archive;
using namespace bake;
namespace {

struct PackCommand {
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

// Rounds further, as the options ask; what it says is for people.
std::string PackCommand::coarsen(Archive& face) const {
  constexpr std::uint64_t other_seed = 0x9e3779b9;  // poses that the proof does not have
  std::vector<float> poses = make_proof(face.model, seed).controls;
  const std::vector<float> more = make_proof(face.model, seed ^ other_seed).controls;
  poses.insert(poses.end(), more.begin(), more.end());
  struct Coarser {
    Archive face;
    Errors moved;
  };
  const auto with = [&](double factor) {
    Coarser coarser{face, {}};
    if (factor <= 1) return coarser;
    coarser.face.model = with_scaled_steps(face.model, factor);
    coarser.moved = packing_errors(face.model, coarser.face.model, poses);
    note_repacking(coarser.face.text.certificate, coarser.moved);
    coarser.face.proof = make_proof(coarser.face.model, seed);
    return coarser;
  };
  const StepScaling choice = choose_step_scaling(
      max_bytes, max_error,
      [&](double factor) {
        const Archive coarser = with(factor).face;
        return std::uint64_t(write_archive(coarser.model, coarser.proof, coarser.text).size());
      },
      [&](double factor) { return with(factor).moved.max; });
  auto [chosen, moved] = with(choice.factor);
  face = std::move(chosen);
  const bool kept = max_bytes > 0 ? choice.bytes <= max_bytes : choice.error <= max_error;
  return format(
      "steps of the basis %.3g times as large: %.3g of the diagonal from what it was, at most, and mse %.3g, on %zu "
      "poses%s\n",
      choice.factor, moved.max, moved.mse, poses.size() / face.model.schema.control_count(),
      kept ? "" : "; what was asked for cannot be had");
}

void PackCommand::run() const {
  const auto bytes = read_file(archive);
  Archive face = with_context(archive, [&] { return read_any(bytes); });
  if (!licence.empty()) face.text.licence = licence_text(licence);
  if (face.proof.hashes.empty()) face.proof = make_proof(face.model, seed);
  const std::string said = max_bytes > 0 || max_error > 0 ? coarsen(face) : "";
  const auto packed = write_archive(face.model, face.proof, face.text);
  verify_archive(packed);
  write_file(out, packed);
  std::printf("%s: %zu bytes, format version %u.%u\n%s: %zu bytes, format version %u.%u\n%s", archive.c_str(),
              bytes.size(), face.format_version / 1000, face.format_version % 1000, out.c_str(), packed.size(),
              archive_format_version() / 1000, archive_format_version() % 1000, said.c_str());
}

}  // namespace

void add_pack(CLI::App& tool) {
  auto command = std::make_shared<PackCommand>();
  CLI::App* app = tool.add_subcommand("pack", "Pack an archive anew, from this or an older version of the format");
  add_archive(*app, command->archive);
  app->add_option("--out", command->out, "The archive to write (.fbk); it appears complete or not at all")
      ->type_name("FACE.fbk")
      ->required();
  add_licence(*app, command->licence);
  app->add_option("--max-bytes", command->max_bytes,
                  "Bytes the archive may have: rounded no more than they ask; 0: any")
      ->check(whole_number)
      ->type_name("N")
      ->capture_default_str();
  app->add_option(
         "--max-error", command->max_error,
         "How far a vertex may come to lie from where it was, over the diagonal: in as few bytes as it allows; "
         "after --max-bytes; 0: nowhere else")
      ->check(CLI::NonNegativeNumber)
      ->type_name("E")
      ->capture_default_str();
  add_seed(*app, command->seed);
  app->footer(
      "Unless rounded, the face poses as it did, to the last bit; its proof is kept, or made where it has none.");
  app->callback([command] { command->run(); });
}

}  // namespace fb::tool
