#include <facebaker/facebaker_bake.hpp>
#include <memory>

#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/results.h"
#include "commands/signature_text.h"

namespace fb::tool {
namespace {

struct SignCommand {
  std::string file, key, certificate, pass_phrase_file, out;
  bool json = false;

  void run() const;
};

void SignCommand::run() const {
  const std::string pass_phrase = pass_phrase_file.empty() ? "" : first_line_of(pass_phrase_file);
  fb_sign_desc desc;
  fb_sign_desc_init(&desc);
  desc.path = file.c_str();
  desc.key = key.c_str();
  desc.certificate = certificate.empty() ? nullptr : certificate.c_str();
  desc.pass_phrase = pass_phrase_file.empty() ? nullptr : pass_phrase.c_str();
  desc.signature = out.empty() ? nullptr : out.c_str();
  const facebaker::Report report = facebaker::sign(desc);
  print_result(json ? report.json() : signed_text(report.json()));
}

}  // namespace

void add_sign(Command tool) {
  auto command = std::make_shared<SignCommand>();
  const Command app =
      tool.add_command("sign", "Sign a file: who vouches for an archive, a consent or a list of withdrawals");
  app.add_option("FILE", command->file, "What to sign, which stays as it is; an archive is verified first")
      .type_name("FILE")
      .required();
  app.add_option("--key", command->key,
                 "The signer's private key, PEM: RSA of 2048 bits or more, P-256, P-384 or P-521")
      .type_name("KEY.pem")
      .required();
  app.add_option("--certificate", command->certificate,
                 "The key's certificate, PEM, and those of who issued it (default: they are in KEY.pem, too)")
      .type_name("CERT.pem");
  app.add_option("--pass-phrase", command->pass_phrase_file,
                 "A file whose first line is the pass phrase of an encrypted key; nobody is asked for one")
      .type_name("FILE");
  app.add_option("--out", command->out, "The signature to write, CMS in DER (default: FILE.sig)").type_name("FILE.sig");
  add_json_flag(app, command->json);
  app.footer(
      "The signature covers every byte of the file: of an archive its motion, figures, provenance and rights. "
      "`facebaker verify --signature` checks it, and so does `openssl cms -verify`. docs/archivists.md tells how a key "
      "is "
      "made.");
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
