#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "base/file.h"
#include "base/match_names.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "commands/commands.h"
#include "commands/interrupt.h"
#include "commands/results.h"
#include "commands/terminal.h"
#include "farm/character_list.h"
#include "farm/farm_run.h"
#include "farm/farm_table.h"
#include "farm/shell_words.h"
#include "farm/slurm_array.h"

namespace fb::tool {
namespace {

struct FarmCommand {
  std::string list, out, sbatch;
  std::vector<std::string> only;
  std::size_t jobs = 0;
  bool slurm = false, status = false;

  void run() const;

 private:
  std::vector<FarmCharacter> chosen() const;
  void bake(const FarmFolder& folder, const std::vector<FarmCharacter>& characters) const;
  void submit(const FarmFolder& folder, const std::vector<FarmCharacter>& characters) const;
};

std::string own_program() {
  std::error_code unknown;
  const std::string path = std::filesystem::read_symlink("/proc/self/exe", unknown).string();
  return unknown ? "facebaker" : path;
}

// The characters of the list, or those of --only.
std::vector<FarmCharacter> FarmCommand::chosen() const {
  std::vector<FarmCharacter> all = read_character_list(list);
  if (only.empty()) return all;
  std::vector<std::string> names;
  for (const FarmCharacter& character : all) names.push_back(character.name);
  for (const std::string& name : only)
    if (std::ranges::find(names, name) == names.end())
      fail(Status::not_found, "%s has no character \"%s\"%s", shown(list).c_str(), shown(name).c_str(),
           names_there_are(name, names).c_str());
  std::erase_if(all,
                [&](const FarmCharacter& character) { return std::ranges::find(only, character.name) == only.end(); });
  return all;
}

void FarmCommand::bake(const FarmFolder& folder, const std::vector<FarmCharacter>& characters) const {
  FarmRun run;
  run.program = own_program();
  run.jobs = std::max<std::size_t>(jobs, 1);
  if (run.jobs > 1) {
    const std::size_t threads = std::max<std::size_t>(1, std::thread::hardware_concurrency() / run.jobs);
    run.more = {"--threads", std::to_string(threads)};
  }
  run.stop = interrupt_requested;
  run.tell = [](const std::string& line) { print_line(line); };
  run_farm(folder, characters, run);
}

void FarmCommand::submit(const FarmFolder& folder, const std::vector<FarmCharacter>& characters) const {
  const SlurmArray array = {own_program(), list, jobs, words_of_line(sbatch)};
  const std::filesystem::path script = write_job_script(folder, characters, array);
  const std::string job = submit_job(folder, script);
  print_result(format("job %s: %zu characters, by %s\n", job.c_str(), characters.size(), shown(script).c_str()));
}

void FarmCommand::run() const {
  const std::vector<FarmCharacter> characters = chosen();
  const FarmFolder folder(out);
  if (!status) {
    std::vector<FarmCharacter> wanted = characters;
    std::erase_if(wanted,
                  [&](const FarmCharacter& character) { return folder.status(character).state == FarmState::done; });
    if (!wanted.empty()) make_folder(out);
    if (slurm && !wanted.empty()) return submit(folder, wanted);
    bake(folder, wanted);
  }
  print_result(farm_table(folder, characters));
  if (interrupt_requested()) fail(Status::interrupted, "interrupted");
  if (const std::size_t done = done_count(folder, characters); done < characters.size())
    fail(Status::not_found, "%zu of %zu characters are not done", characters.size() - done, characters.size());
}

}  // namespace

void add_farm(Command tool) {
  auto command = std::make_shared<FarmCommand>();
  const Command app = tool.add_command("farm", "Bake a list of characters, here or as an array job of Slurm");
  app.add_option("LIST", command->list,
                 "A text file with a character a line: [NAME=]SOURCE and options of `bake`; # begins a comment")
      .required();
  app.add_option("--out", command->out, "Folder of the archives (NAME.fbk) and logs (NAME.log)")
      .type_name("DIR")
      .required();
  app.add_option("--jobs", command->jobs,
                 "Characters at once, which share the machine's threads; with --slurm, tasks that run at once")
      .between(1, 4096)
      .type_name("N");
  app.add_option("--only", command->only, "A character of the list to bake, and not the others (repeatable)")
      .type_name("NAME")
      .repeatable();
  const Option slurm = app.add_flag(
      "--slurm", command->slurm, "Write a job script with a task for each character that is not done, and submit it");
  app.add_option("--sbatch", command->sbatch,
                 "Options of sbatch for the job script, such as \"--time=8:00:00 --cpus-per-task=8\"")
      .type_name("OPTIONS")
      .only_with(slurm);
  app.add_flag("--status", command->status, "Only show what is done, running, stopped or failed, and how good it is")
      .not_with(slurm);
  app.footer(
      "The same command goes on: what is done stays, what was stopped continues from its work folder, what failed is\n"
      "tried again. Exit code 0 once all are done (with --slurm: submitted).");
  app.when_called([command] { command->run(); });
}

}  // namespace fb::tool
