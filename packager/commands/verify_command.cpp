#include <facebaker/facebaker_bake.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/status.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/face_rights.h"
#include "commands/results.h"
#include "commands/signature_text.h"

namespace fb::tool {
namespace {

// The document of fb_verify behind what its rights come to, with that of the signature, where there are such.
std::string whole_document(const std::string& json, const FaceRights& rights,
                           const std::optional<std::string>& signer) {
  if (!rights.stated() && !signer) return json;
  nlohmann::ordered_json document;
  if (rights.stated()) document["rights"] = rights.document();
  document.update(nlohmann::ordered_json::parse(json));
  if (signer) document["signature"] = nlohmann::ordered_json::parse(*signer);
  return document.dump(2) + "\n";
}

struct VerifyCommand {
  std::string archive, on, signature;
  std::vector<std::string> trusted, withdrawn;
  bool accept_expired = false, json = false;
  std::vector<Option> signature_options;  // that need --signature

  void run() const;

 private:
  std::optional<std::string> check_signature(const facebaker::Archive& face) const;
};

// The document of the signature, if there is one to check.
std::optional<std::string> VerifyCommand::check_signature(const facebaker::Archive& face) const {
  if (signature.empty()) {
    for (const Option& option : signature_options)
      if (option.given()) fail(Status::invalid_argument, "%s needs --signature", option.name().c_str());
    return std::nullopt;
  }
  const std::vector<const char*> trusted_files = c_strings(trusted), lists = c_strings(withdrawn);
  fb_verify_signature_desc desc;
  fb_verify_signature_desc_init(&desc);
  desc.archive = face.get();
  desc.signature = signature.c_str();
  desc.trusted = trusted_files.data();
  desc.trusted_count = static_cast<std::uint32_t>(trusted_files.size());
  desc.withdrawn = lists.data();
  desc.withdrawn_count = static_cast<std::uint32_t>(lists.size());
  desc.on = on.empty() ? nullptr : on.c_str();
  desc.flags = accept_expired ? FB_SIGNATURE_ACCEPT_EXPIRED : 0;
  return facebaker::verify_signature(desc).json();
}

void VerifyCommand::run() const {
  const facebaker::Archive face(archive);
  const facebaker::Report report = facebaker::verify(face);
  const std::optional<std::string> signer = check_signature(face);
  fb_verify_result result;
  fb_verify_result_init(&result);
  facebaker::check(fb_report_verify(report.get(), &result));
  const FaceRights rights(face.info().about, on);
  if (json) {
    print_result(whole_document(report.json(), rights, signer));
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
  if (signer) print_result(signature_text(*signer));
}

void add_signature_options(Command app, VerifyCommand& command) {
  app.add_option("--signature", command.signature,
                 "Check who vouches for the archive: a signature of `facebaker sign`, of all of its bytes")
      .type_name("FACE.fbk.sig");
  const auto needs_signature = [&](const Option& option) { command.signature_options.push_back(option); };
  needs_signature(app.add_option("--trust", command.trusted,
                                 "Who is trusted (repeatable): a PEM file with the certificate of the signer or of who "
                                 "issued it, or with the public key")
                      .type_name("CERT.pem")
                      .repeatable());
  needs_signature(app.add_option("--withdrawn", command.withdrawn,
                                 "Lists of withdrawn consents (repeatable), each with its signature, .sig, beside it")
                      .type_name("LIST.json")
                      .repeatable());
  needs_signature(app.add_flag("--accept-expired", command.accept_expired,
                               "Accept a certificate that has expired, where it was valid when the signer says to have "
                               "signed"));
}

}  // namespace

void add_verify(Command tool) {
  auto command = std::make_shared<VerifyCommand>();
  const Command app =
      tool.add_command("verify", "Check that an archive is complete and evaluates to the bits it was archived with");
  add_archive(app, command->archive);
  add_on(app, command->on);
  add_signature_options(app, *command);
  add_json_flag(app, command->json);
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
