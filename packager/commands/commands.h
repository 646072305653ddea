// The commands of the tool, a file each. Each function declares a command's options; the command runs while the command
// line is parsed, prints results on standard output and progress on standard error, and throws fb::Error or
// facebaker::Error when it fails.
#pragma once

#include "options/command.h"

namespace fb::tool {

void add_sample(Command tool);
void add_plan(Command tool);
void add_check(Command tool);
void add_bake(Command tool);
void add_eval(Command tool);
void add_diff(Command tool);
void add_compare(Command tool);
void add_inspect(Command tool);
void add_verify(Command tool);
void add_sign(Command tool);
void add_pack(Command tool);
void add_bag(Command tool);
void add_pose(Command tool);
void add_solve(Command tool);
void add_view(Command tool);
void add_export(Command tool);
void add_header(Command tool);
void add_bench(Command tool);
void add_rig_host(Command tool);
void add_farm(Command tool);
void add_help(Command tool);
void add_completion(Command tool);
void add_write_manual(Command tool);

}  // namespace fb::tool
