#include <facebaker/facebaker_bake.hpp>
#include <memory>

#include "base/status.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/results.h"

namespace fb::tool {
namespace {

struct VerifyCommand {
  std::string archive;
  bool json = false;

  void run() const {
    const facebaker::Archive face(archive);
    const facebaker::Report report = facebaker::verify(face);
    fb_verify_result result;
    fb_verify_result_init(&result);
    facebaker::check(fb_report_verify(report.get(), &result));
    if (json) {
      print_result(report.json().c_str());
      return;
    }
    if (result.poses == 0)
      print_result(format("%s: whole; it carries no poses to check\n", archive.c_str()));
    else
      print_result(format("%s: whole; %llu poses of %llu vertices evaluate as archived, bit for bit\n", archive.c_str(),
                          static_cast<unsigned long long>(result.poses),
                          static_cast<unsigned long long>(result.vertices)));
    print_result(face.info().certificate_summary);
  }
};

}  // namespace

void add_verify(Command tool) {
  auto command = std::make_shared<VerifyCommand>();
  const Command app =
      tool.add_command("verify", "Check that an archive is complete and evaluates to the bits it was archived with");
  add_archive(app, command->archive);
  add_json_flag(app, command->json);
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
