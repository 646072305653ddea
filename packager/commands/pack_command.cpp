#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <optional>

#include "archive/reader.h"
#include "bake/pipeline/repack.h"
#include "base/status.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/progress_bar.h"

namespace fb::tool {
using namespace bake;
namespace {

struct PackCommand {
  std::string archive, out, licence;
  RepackOptions options;

  void run();
};

// What repacking within limits changed.
std::string displacement_text(const RepackResult& result) {
  return format(
      "steps of the basis %.3g times as large: vertices displaced by up to %.3g of the diagonal, mse %.3g, on %zu "
      "poses%s\n",
      result.factor, result.displacement.max, result.displacement.mse, result.displacement.frames,
      result.within_limits ? "" : "; forced beyond what was allowed");
}

void PackCommand::run() {
  options.licence = licence_text(licence);
  const bool limited = options.max_bytes > 0 || options.max_error > 0;
  RepackResult result;
  {
    std::optional<ProgressBar> bar;
    if (limited) bar.emplace();
    result = repack_file(archive, out, options, bar ? static_cast<Progress&>(*bar) : silent_progress());
  }
  const auto version = [](std::uint32_t number) { return format("%u.%u", number / 1000, number % 1000); };
  std::printf("%s: %llu bytes, format version %s\n%s: %llu bytes, format version %s\n%s", archive.c_str(),
              static_cast<unsigned long long>(result.source_bytes), version(result.source_version).c_str(), out.c_str(),
              static_cast<unsigned long long>(result.bytes), version(archive::archive_format_version()).c_str(),
              limited ? displacement_text(result).c_str() : "");
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
  app->add_option("--max-bytes", command->options.max_bytes,
                  "Bytes the archive may have: in the smallest quantisation steps within them; 0: any")
      ->check(whole_number)
      ->type_name("N")
      ->capture_default_str();
  app->add_option("--max-error", command->options.max_error,
                  "Largest displacement of a vertex by repacking, over the diagonal. Alone: in as few bytes as it "
                  "allows; with --max-bytes: a limit; 0: none, or with --max-bytes the largest certified error")
      ->check(CLI::NonNegativeNumber)
      ->type_name("E")
      ->capture_default_str();
  add_force(*app, command->options.force);
  add_seed(*app, command->options.seed);
  app->footer(
      "Without --max-bytes and --max-error the face poses as it did, to the last bit; its reference poses are kept, or "
      "made where it has none.");
  app->callback([command] { command->run(); });
}

}  // namespace fb::tool
