#include <facebaker/facebaker_bake.hpp>
#include <memory>
#include <string>

#include "base/file.h"
#include "commands/command_options.h"
#include "commands/commands.h"
#include "commands/results.h"
#include "export/control_header.h"

namespace fb::tool {
namespace {

struct HeaderCommand {
  std::string archive, out, name;

  void run() const {
    const HeaderLanguage language = header_language(out);
    const facebaker::Model model(archive);
    write_file(out, control_header(model, language, name));
    print_result(format("%s: %u controls\n", out.c_str(), model.control_count()));
  }
};

}  // namespace

void add_header(Command tool) {
  auto command = std::make_shared<HeaderCommand>();
  const Command app =
      tool.add_command("header", "Write constants for the controls of an archive, for programs in C, C# or TypeScript");
  add_archive(app, command->archive);
  app.add_option("--out", command->out, "The source file to write: NAME.h, NAME.cs or NAME.ts")
      .required()
      .type_name("FILE");
  app.add_option("--name", command->name, "What the face is called in the code; default: the archive's own name");
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
