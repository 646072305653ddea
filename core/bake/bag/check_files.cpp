#include "bake/bag/check_files.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <optional>

#include "bake/bag/message_digest.h"
#include "bake/measure/verify.h"
#include "base/file_extension.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::array<unsigned char, 8> signature = {0x89, 'F', 'B', 'K', '\r', '\n', 0x1a, '\n'};

bool has_signature(std::span<const std::byte> bytes) {
  return bytes.size() >= signature.size() && std::memcmp(bytes.data(), signature.data(), signature.size()) == 0;
}

// What was found in a file.
struct CheckedFile {
  std::vector<std::string> faults;
  std::string warning;
  std::optional<CheckedArchive> archive;
};

class FileCheck {
 public:
  FileCheck(const ClosedFolder& folder, const std::string& path, const std::vector<ExpectedDigest>& expected)
      : folder_(folder), path_(path), expected_(expected), named_archive_(file_extension(path) == ".fbk") {
    archive_ = named_archive_ && path.starts_with(archives_prefix);
    for (const ExpectedDigest& one : expected) digests_.emplace_back(one.algorithm);
  }

  // asked(): called after each piece.
  template <class Asked>
  CheckedFile run(Asked&& asked) {
    try {
      folder_.read(path_, [&](std::span<const std::byte> piece) {
        take(piece);
        asked();
      });
    } catch (const Error& error) {
      if (error.status() != Status::io) throw;
      found_.faults.emplace_back(error.what());
      return std::move(found_);
    }
    compare();
    if (archive_) verify();
    return std::move(found_);
  }

 private:
  void take(std::span<const std::byte> piece) {
    if (!begun_) archive_ = archive_ || has_signature(piece);
    begun_ = true;
    for (MessageDigest& digest : digests_) digest.add(piece);
    if (archive_) bytes_.insert(bytes_.end(), piece.begin(), piece.end());
  }

  void compare() {
    for (std::size_t i = 0; i < expected_.size(); ++i)
      if (digests_[i].finish() != expected_[i].digest)
        found_.faults.push_back("its bytes have another checksum than " + expected_[i].manifest + " states");
    if (named_archive_ && !archive_) found_.warning = "is called .fbk and is no FaceBaker archive";
  }

  void verify() {
    try {
      const VerifyReport verified = verify_archive(bytes_);
      found_.archive = CheckedArchive{path_, verified.bytes, verified.poses, verified.vertices};
    } catch (const Error& error) {
      if (error.status() == Status::out_of_memory || error.status() == Status::interrupted) throw;
      found_.faults.push_back(std::string("does not verify: ") + error.what());
    }
  }

  const ClosedFolder& folder_;
  const std::string& path_;
  const std::vector<ExpectedDigest>& expected_;
  const bool named_archive_;
  bool archive_, begun_ = false;
  std::vector<MessageDigest> digests_;
  std::vector<std::byte> bytes_;  // of an archive
  CheckedFile found_;
};

}  // namespace

void check_files(const ClosedFolder& folder, const std::map<std::string, std::vector<ExpectedDigest>>& files,
                 const Parallel& parallel, Progress& progress, BagReport& report) {
  std::vector<const std::pair<const std::string, std::vector<ExpectedDigest>>*> order;
  for (const auto& file : files) order.push_back(&file);
  std::vector<CheckedFile> found(order.size());
  std::atomic<std::uint64_t> done = 0;
  progress.begin(Phase::measuring, "checking files", order.size());
  parallel_for(parallel, order.size(), [&](std::size_t i, std::size_t) {
    found[i] = FileCheck(folder, order[i]->first, order[i]->second).run([&] { progress.ask(); });
    progress.step(++done);
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (const std::string& fault : found[i].faults) report.add_fault(order[i]->first, fault);
    if (!found[i].warning.empty()) report.add_warning(order[i]->first, found[i].warning);
    if (found[i].archive) report.archives.push_back(*found[i].archive);
  }
}

}  // namespace fb::bake
