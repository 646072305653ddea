#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "bake/measure/certificate.h"
#include "bake/measure/verify.h"
#include "base/file.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/inspect_json.h"

namespace fb::tool {
using namespace bake;
namespace {

struct VerifyCommand {
  std::string archive;
  bool json = false;

  void run() const {
    const auto bytes = read_file(archive);
    const VerifyReport report = with_context(archive, [&] { return verify_archive(bytes); });
    if (json) {
      std::fputs(verify_json(archive, report).c_str(), stdout);
      return;
    }
    if (report.poses == 0)
      std::printf("%s: whole; it carries no poses to check\n", archive.c_str());
    else
      std::printf("%s: whole; %zu poses of %zu vertices evaluate as archived, bit for bit\n", archive.c_str(),
                  report.poses, report.vertices);
    std::fputs(certificate_summary(report.certificate).c_str(), stdout);
  }
};

}  // namespace

void add_verify(CLI::App& tool) {
  auto command = std::make_shared<VerifyCommand>();
  CLI::App* app = tool.add_subcommand("verify", "Check that an archive is whole and still computes what was archived");
  add_archive(*app, command->archive);
  add_json_flag(*app, command->json);
  app->callback([command] { command->run(); });
}

}  // namespace fb::tool
