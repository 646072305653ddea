#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "archive/writer.h"
#include "bake/measure/verify.h"
#include "bake/migrate/version_0_2.h"
#include "base/file.h"
#include "base/status.h"
#include "verb_options.h"
#include "verbs.h"

namespace fb {
namespace {

struct PackVerb {
  std::string archive, out, licence;
  std::uint64_t seed = 1;

  void run() const;
};

Archive read_any(std::span<const std::byte> bytes) {
  return is_version_0_2(bytes) ? read_version_0_2(bytes) : read_archive(bytes);
}

void PackVerb::run() const {
  const auto bytes = read_file(archive);
  Archive face = naming(archive, [&] { return read_any(bytes); });
  if (!licence.empty()) {
    const auto text = read_file(licence, 1u << 20);
    face.text.licence.assign(reinterpret_cast<const char*>(text.data()), text.size());
  }
  if (face.proof.hashes.empty()) face.proof = make_proof(face.model, seed);
  const auto packed = write_archive(face.model, face.proof, face.text);
  verify_archive(packed);
  write_file(out, packed);
  std::printf("%s: %zu bytes, format version %u.%u\n%s: %zu bytes, format version %u.%u\n", archive.c_str(),
              bytes.size(), face.format_version / 1000, face.format_version % 1000, out.c_str(), packed.size(),
              archive_format_version() / 1000, archive_format_version() % 1000);
}

}  // namespace

void add_pack(CLI::App& tool) {
  auto verb = std::make_shared<PackVerb>();
  CLI::App* app = tool.add_subcommand("pack", "Pack an archive anew, from this or an older version of the format");
  add_archive(*app, verb->archive);
  app->add_option("--out", verb->out, "The archive to write (.fbk); it appears complete or not at all")
      ->type_name("FACE.fbk")
      ->required();
  app->add_option("--licence", verb->licence, "A text file: the licence to put into the archive")->type_name("FILE");
  add_seed(*app, verb->seed);
  app->footer("The face poses as it did, to the last bit; its proof is kept, or made where it has none.");
  app->callback([verb] { verb->run(); });
}

}  // namespace fb
