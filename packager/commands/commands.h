// The commands of the tool, a file each. Each function declares a command's options; the command runs while the command
// line is parsed, prints results on standard output and progress on standard error, and throws fb::Error or
// facebaker::Error when it fails.
#pragma once

namespace CLI {
class App;
}

namespace fb::tool {

void add_sample(CLI::App& tool);
void add_plan(CLI::App& tool);
void add_check(CLI::App& tool);
void add_bake(CLI::App& tool);
void add_eval(CLI::App& tool);
void add_diff(CLI::App& tool);
void add_compare(CLI::App& tool);
void add_inspect(CLI::App& tool);
void add_verify(CLI::App& tool);
void add_pack(CLI::App& tool);
void add_pose(CLI::App& tool);
void add_view(CLI::App& tool);
void add_export(CLI::App& tool);
void add_bench(CLI::App& tool);
void add_rig_host(CLI::App& tool);
void add_farm(CLI::App& tool);
void add_help(CLI::App& tool);
void add_completion(CLI::App& tool);
void add_write_manual(CLI::App& tool);

}  // namespace fb::tool
