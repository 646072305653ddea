// Bags of archives for those who keep them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "bake/bag/bag_report.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb::bake {

struct BagContents {
  std::vector<std::filesystem::path> archives;  // .fbk
  std::vector<std::filesystem::path> beside;    // signatures and consents, kept beside the archives
  std::vector<std::filesystem::path> sources;   // files and folders that the archives were made of
  // More files of the payload: their paths in data/, and the files.
  std::vector<std::pair<std::string, std::filesystem::path>> files;
  std::vector<std::pair<std::string, std::string>> info;  // more labels and values of bag-info.txt
  std::string date;      // of the bag, "2026-11-29"; the same date gives the same bytes
  std::string software;  // "FaceBaker VERSION"
  // Writes access copies of an archive: files whose names begin with `base`, such as base + ".png". Empty: the
  // archive's own thumbnail is the copy, if it has one.
  std::function<void(std::size_t archive, const std::filesystem::path& base)> make_copies;
};

// Writes a BagIt 1.0 bag (RFC 8493) of archives, each of which is verified, with texts, rights, provenance and a
// reader, and checks it as it lies on the disk (check_bag), before it gets its name: the folder appears whole or not at
// all. Gives what the check found, which is no fault. Fails with not_found, io and as verify_archive on files that
// cannot be had, with bad_data on names that a bag cannot have, on two files of one name, on links in sources, with io
// where the folder is not empty, and with interrupted.
BagReport write_bag(const std::filesystem::path& folder, const BagContents& contents, const Parallel& parallel,
                    Progress& progress);

}  // namespace fb::bake
