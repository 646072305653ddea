#include "farm/slurm_array.h"

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <memory>

#include "base/file.h"
#include "base/status.h"
#include "farm/shell_words.h"

namespace fb::tool {
namespace {

struct CommandResult {
  int exit_code;
  std::string output;  // without white space at the end
};

// Runs a command of Slurm's; standard error is part of the output.
CommandResult run_command(const std::vector<std::string>& words) {
  std::FILE* pipe = ::popen((shell_words(words) + " 2>&1").c_str(), "r");
  if (!pipe) fail(Status::io, "%s cannot be started", words[0].c_str());
  std::string output;
  std::array<char, 4096> text;
  while (const std::size_t got = std::fread(text.data(), 1, text.size(), pipe)) output.append(text.data(), got);
  const int status = ::pclose(pipe);
  output.erase(output.find_last_not_of(" \n\r\t") + 1);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), output};
}

// The value of an option in a line that begins with #SBATCH.
std::string quoted(const std::string& value) {
  if (value.find('"') != std::string::npos || value.find('\n') != std::string::npos)
    fail(Status::invalid_argument, "%s: sbatch takes neither \" nor line ends in its options", value.c_str());
  return value.find(' ') == std::string::npos ? value : '"' + value + '"';
}

// Whether Slurm still has tasks of a job, waiting or running.
bool in_queue(const std::string& job) {
  const CommandResult found = run_command({"squeue", "--noheader", "--jobs=" + job, "--format=%i"});
  return found.exit_code == 0 && !found.output.empty();  // Slurm forgets jobs that are over
}

std::string digits_of(const std::vector<std::byte>& bytes) {
  std::string digits;
  for (const std::byte byte : bytes) {
    const char c = static_cast<char>(byte);
    if (c < '0' || c > '9') break;
    digits += c;
  }
  return digits;
}

}  // namespace

std::filesystem::path write_job_script(const FarmFolder& folder, const std::vector<FarmCharacter>& characters,
                                       const SlurmArray& array) {
  const std::filesystem::path out = std::filesystem::absolute(folder.path());
  std::string script =
      "#!/bin/sh\n# Written by `facebaker farm --slurm`: a task for each character that was not done.\n";
  const auto option = [&](const std::string& name, const std::string& value) {
    script += "#SBATCH --" + name + "=" + quoted(value) + "\n";
  };
  option("job-name", "facebaker-farm");
  option("chdir", std::filesystem::current_path().string());
  option("output", (out / "slurm-%A_%a.out").string());
  option("array", format("0-%zu", characters.size() - 1) + (array.jobs > 0 ? format("%%%zu", array.jobs) : ""));
  for (const std::string& word : array.more) script += "#SBATCH " + quoted(word) + "\n";
  script += "[ -z \"$SLURM_CPUS_PER_TASK\" ] || export OMP_NUM_THREADS=\"$SLURM_CPUS_PER_TASK\"\nset --";
  for (const FarmCharacter& character : characters) script += " \\\n  " + character.name;
  script +=
      "\nshift \"$SLURM_ARRAY_TASK_ID\"\nexec " +
      shell_words({array.program, "farm", std::filesystem::absolute(array.list).string(), "--out", out.string()}) +
      " --only \"$1\"\n";
  const std::filesystem::path path = out / "farm.sbatch";
  write_file(path, script);
  return path;
}

std::string submit_job(const FarmFolder& folder, const std::filesystem::path& script) {
  const std::filesystem::path record = folder.path() / "farm.job";
  if (std::filesystem::exists(record)) {
    const std::string before = digits_of(read_file(record, 4096));
    if (!before.empty() && in_queue(before))
      fail(Status::invalid_argument, "job %s of this folder is still in Slurm's queue: wait for it, or scancel %s",
           before.c_str(), before.c_str());
  }
  const CommandResult submitted = run_command({"sbatch", "--parsable", script.string()});
  if (submitted.exit_code != 0) fail(Status::io, "sbatch: %s", submitted.output.c_str());
  write_file(record, submitted.output + "\n");
  return submitted.output.substr(0, submitted.output.find(';'));
}

}  // namespace fb::tool
