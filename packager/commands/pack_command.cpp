#include <facebaker/facebaker_bake.hpp>
#include <memory>
#include <optional>

#include "base/status.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/library_options.h"
#include "commands/progress_bar.h"
#include "commands/results.h"
#include "commands/thumbnail.h"

namespace fb::tool {
namespace {

struct PackCommand {
  PackCommand() { fb_pack_desc_init(&desc); }

  std::string archive, out, licence, about, sockets;
  fb_pack_desc desc;
  Parallel parallel;
  bool force = false, thumbnail = false;

  void run();
};

std::string version_text(std::uint32_t format) {
  return std::to_string(format / 1000) + "." + std::to_string(format % 1000);
}

// What repacking within limits changed.
std::string displacement_text(const fb_pack_result& result) {
  return format(
      "steps of the basis %.3g times as large: vertices displaced by up to %.3g of the diagonal, mse %.3g, on %llu "
      "poses%s\n",
      result.step_factor, result.displacement.max, result.displacement.mse,
      static_cast<unsigned long long>(result.displacement.frames),
      result.within_limits ? "" : "; forced beyond what was allowed");
}

void PackCommand::run() {
  const std::string licence_words = file_text(licence), about_words = file_text(about),
                    socket_words = file_text(sockets);
  const std::vector<std::byte> picture =
      thumbnail ? draw_thumbnail(facebaker::Model(archive), parallel) : std::vector<std::byte>();
  desc.path = archive.c_str();
  desc.out = out.c_str();
  desc.licence = licence.empty() ? nullptr : licence_words.c_str();
  desc.about = about.empty() ? nullptr : about_words.c_str();
  desc.sockets = sockets.empty() ? nullptr : socket_words.c_str();
  desc.thumbnail = picture.empty() ? nullptr : picture.data();
  desc.thumbnail_bytes = picture.size();
  desc.force = force ? 1 : 0;
  const bool limited = desc.max_bytes > 0 || desc.max_error > 0;
  const facebaker::Report report = [&] {
    std::optional<ProgressBar> progress;
    if (limited) desc.callbacks = progress.emplace().callbacks();
    return facebaker::pack(desc);
  }();
  fb_pack_result result;
  fb_pack_result_init(&result);
  facebaker::check(fb_report_pack(report.get(), &result));
  print_result(format("%s: %llu bytes, format version %s\n%s: %llu bytes, format version %s\n%s", archive.c_str(),
                      static_cast<unsigned long long>(result.bytes_before), version_text(result.format_before).c_str(),
                      out.c_str(), static_cast<unsigned long long>(result.archive_bytes),
                      version_text(result.format).c_str(), limited ? displacement_text(result).c_str() : ""));
}

}  // namespace

void add_pack(Command tool) {
  auto command = std::make_shared<PackCommand>();
  const Command app = tool.add_command("pack", "Pack an archive again, from this or an older version of the format");
  add_archive(app, command->archive);
  add_out_archive(app, command->out);
  add_licence(app, command->licence);
  add_about(app, command->about);
  app.add_option("--sockets", command->sockets,
                 "A JSON file: an array of sockets (docs/characters.md), which are added, or replace those of the same "
                 "names")
      .type_name("FILE.json");
  app.add_flag("--thumbnail", command->thumbnail, "Draw the picture of the face that file managers show");
  app.add_option("--max-bytes", command->desc.max_bytes,
                 "Bytes the archive may have: in the smallest quantisation steps within them; 0: any")
      .checked(whole_number)
      .type_name("N")
      .shows_default();
  app.add_option("--max-error", command->desc.max_error,
                 "Largest displacement of a vertex by repacking, over the diagonal. Alone: in as few bytes as it "
                 "allows; with --max-bytes: a limit; 0: none, or with --max-bytes the largest certified error")
      .not_negative()
      .type_name("E")
      .shows_default();
  add_library_option(app, "force", command->force);
  add_library_option(app, "seed", command->desc.seed);
  add_threads(app, command->parallel);
  app.footer(
      "Without --max-bytes and --max-error the face poses as it did, to the last bit; its reference poses are kept, or "
      "made where it has none or sockets are given.");
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
