#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "farm/farm_folder.h"

namespace fb::tool {

// How an array job of Slurm is made.
struct SlurmArray {
  std::string program;            // facebaker, as machines of the cluster find it
  std::filesystem::path list;     // of the characters
  std::size_t jobs = 0;           // characters at once; 0: as many as Slurm allows
  std::vector<std::string> more;  // options of sbatch
};

// Writes the job script, farm.sbatch, whose tasks bake one of these characters each.
std::filesystem::path write_job_script(const FarmFolder& folder, const std::vector<FarmCharacter>& characters,
                                       const SlurmArray& array);

// Submits it by sbatch, keeps the number of the job in the file farm.job, and returns it. Fails with invalid_argument
// while the job before is still in Slurm's queue, and with io where sbatch refuses, with what it says.
std::string submit_job(const FarmFolder& folder, const std::filesystem::path& script);

}  // namespace fb::tool
