#include <facebaker/facebaker_bake.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/status.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/face_rights.h"
#include "commands/results.h"

namespace fb::tool {
namespace {

// The document of fb_verify, behind what its rights come to.
std::string with_rights(const std::string& json, const FaceRights& rights) {
  if (!rights.stated()) return json;
  nlohmann::ordered_json document = {{"rights", rights.document()}};
  document.update(nlohmann::ordered_json::parse(json));
  return document.dump(2) + "\n";
}

struct VerifyCommand {
  std::string archive, on;
  bool json = false;

  void run() const {
    const facebaker::Archive face(archive);
    const facebaker::Report report = facebaker::verify(face);
    fb_verify_result result;
    fb_verify_result_init(&result);
    facebaker::check(fb_report_verify(report.get(), &result));
    const FaceRights rights(face.info().about, on);
    if (json) {
      print_result(with_rights(report.json(), rights));
      return;
    }
    for (const std::string& clause : rights.binding()) print_result(archive + ": " + clause + "\n");
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
  add_on(app, command->on);
  add_json_flag(app, command->json);
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
