#include "bake/bag/check_bag.h"

#include <algorithm>
#include <map>
#include <set>

#include "bake/bag/bag_path.h"
#include "bake/bag/check_files.h"
#include "bake/bag/closed_folder.h"
#include "bake/bag/message_digest.h"
#include "bake/bag/tag_files.h"
#include "base/status.h"

namespace fb::bake {
namespace {

using Kind = ClosedFolder::Kind;

constexpr std::uint64_t most_text_bytes = std::uint64_t{1} << 28;

struct Manifest {
  std::string file, algorithm;
  bool payload = false;
  std::set<std::string> paths;
};

// What is said of a path that some system takes for that of another.
std::string difference(const std::string& other, const std::string& path) {
  const bool normalisation = composed_path(other) == composed_path(path);
  return "differs from " + other +
         (normalisation ? " in Unicode's normalisation only" : " in the case of letters only");
}

class BagCheck {
 public:
  BagCheck(const std::filesystem::path& folder, Progress& progress) : folder_(folder), progress_(progress) {}

  BagReport run(const Parallel& parallel);

 private:
  void list();
  void check_names();
  void check_collisions();
  bool begins_bag(const std::string& path) const;
  std::string missing_reason(const std::string& path, const std::string& manifest) const;
  void read_texts();
  void read_manifests();
  void read_manifest_file(Manifest manifest);
  void read_fetched();
  void compare_lists();
  void check_oxum();
  std::optional<std::string> text_of(const std::string& file);

  ClosedFolder folder_;
  Progress& progress_;
  BagReport report_;
  std::map<std::string, ClosedFolder::Entry> entries_;
  std::map<std::string, std::string> folded_;  // to the first path of those that some system takes for one
  std::vector<Manifest> manifests_;
  bool all_manifests_read_ = true;              // false: what is in none may be in one that cannot be read
  std::map<std::string, std::string> fetched_;  // addresses of files that are elsewhere
  std::map<std::string, std::vector<ExpectedDigest>> expected_;  // of files that are there
};

std::optional<std::string> BagCheck::text_of(const std::string& file) {
  try {
    std::string text = folder_.read_text(file, most_text_bytes);
    const std::string fault = tag_text_fault(text);
    if (fault.empty()) return text;
    report_.add_fault(file, fault);
  } catch (const Error& error) {
    if (error.status() != Status::io && error.status() != Status::limit) throw;
    report_.add_fault(file, error.what());
  }
  return std::nullopt;
}

void BagCheck::list() {
  const auto complain = [&](const std::string& path, const std::string& reason) { report_.add_fault(path, reason); };
  for (ClosedFolder::Entry& entry : folder_.list(complain, progress_)) {
    if (entry.kind == Kind::link) report_.add_fault(entry.path, "is a symbolic link, which is not followed");
    if (entry.kind == Kind::other)
      report_.add_fault(entry.path, "is neither file nor folder, but a pipe, a socket or a device");
    if (entry.kind == Kind::file && entry.path.starts_with(payload_prefix)) {
      ++report_.files;
      report_.bytes += entry.bytes;
    }
    entries_.emplace(entry.path, entry);
  }
}

// Of all that is there, whether a manifest names it or not.
void BagCheck::check_names() {
  for (const auto& [path, entry] : entries_) {
    if (const std::string fault = bag_path_fault(path); !fault.empty()) report_.add_fault(path, fault);
    if (begins_bag(path))
      report_.add_fault(path, "begins a bag in the bag, whose own checksums nobody would compare: unpack it");
  }
  const auto payload = entries_.find(payload_folder);
  if (payload == entries_.end())
    report_.add_fault(payload_folder, "there is no such folder");
  else if (payload->second.kind == Kind::file)
    report_.add_fault(payload_folder, "is a file, not a folder");
  else if (payload->second.kind == Kind::folder && report_.files == 0)
    report_.add_fault(payload_folder, "holds no file");
  check_collisions();
}

// Whether it is the declaration of a bag in the payload.
bool BagCheck::begins_bag(const std::string& path) const {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos || path.substr(slash + 1) != declaration_name) return false;
  const auto inner = entries_.find(path.substr(0, slash + 1) + payload_folder);
  return inner != entries_.end() && inner->second.kind == Kind::folder;
}

void BagCheck::check_collisions() {
  for (const auto& [path, entry] : entries_) {
    const auto [first, added] = folded_.emplace(folded_path(path), path);
    if (!added) report_.add_fault(path, difference(first->second, path));
  }
}

void BagCheck::read_texts() {
  if (!entries_.contains(declaration_name))
    report_.add_fault(declaration_name, "there is no such file: the folder is no bag");
  else if (const auto text = text_of(declaration_name))
    report_.version = read_declaration(*text, report_);
  if (is_early(report_.version))
    report_.add_warning(declaration_name,
                        "is BagIt " + report_.version + ", from before RFC 8493; its checksums are compared as of 1.0");
  if (entries_.contains(info_name))
    if (const auto text = text_of(info_name)) report_.info = read_bag_info(*text, report_);
}

void BagCheck::read_manifests() {
  bool payload = false;
  for (const auto& [path, entry] : entries_) {
    const bool tags = path.starts_with("tagmanifest-");
    const std::string prefix = tags ? "tagmanifest-" : "manifest-";
    if (!path.starts_with(prefix) || !path.ends_with(".txt") || path.find('/') != std::string::npos) continue;
    const std::string algorithm = path.substr(prefix.size(), path.size() - prefix.size() - 4);
    if (!digest_digits(algorithm)) {
      report_.add_warning(path, "is by an algorithm that is not known here: its checksums are not compared");
      continue;
    }
    payload |= !tags;
    read_manifest_file({path, algorithm, !tags, {}});
  }
  if (!payload) {
    all_manifests_read_ = false;
    report_.add_fault("", "there is no manifest by a known algorithm, such as manifest-sha512.txt");
  }
  const bool strong =
      std::ranges::any_of(report_.algorithms, [](const auto& name) { return *digest_digits(name) > 40; });
  if (payload && !strong)
    report_.add_warning("", "its checksums find damage, not forgery: none is by SHA-256 or stronger");
}

void BagCheck::read_manifest_file(Manifest manifest) {
  const auto text = text_of(manifest.file);
  if (!text) {
    all_manifests_read_ = all_manifests_read_ && !manifest.payload;
    return;
  }
  const std::size_t faults = report_.faults.size();
  const std::vector<ManifestLine> lines = read_manifest(*text, manifest.file, *digest_digits(manifest.algorithm),
                                                        manifest.payload, is_early(report_.version), report_);
  if (manifest.payload && report_.faults.size() > faults) all_manifests_read_ = false;
  for (const ManifestLine& line : lines) {
    manifest.paths.insert(line.path);
    const auto entry = entries_.find(line.path);
    if (entry != entries_.end() && entry->second.kind == Kind::file)
      expected_[line.path].push_back({manifest.algorithm, line.digest, manifest.file});
  }
  if (std::ranges::find(report_.algorithms, manifest.algorithm) == report_.algorithms.end())
    report_.algorithms.push_back(manifest.algorithm);
  manifests_.push_back(std::move(manifest));
}

void BagCheck::read_fetched() {
  if (!entries_.contains(fetch_name)) return;
  const auto text = text_of(fetch_name);
  if (!text) return;
  for (const FetchLine& line : read_fetch(*text, is_early(report_.version), report_)) {
    fetched_.emplace(line.path, line.url);
    const bool listed = std::ranges::any_of(
        manifests_, [&](const Manifest& one) { return one.payload && one.paths.contains(line.path); });
    if (!listed && all_manifests_read_) report_.add_fault(line.path, "fetch.txt names it, and no manifest does");
    if (entries_.contains(line.path)) report_.add_warning(line.path, "fetch.txt names it, and it is there");
  }
}

std::string BagCheck::missing_reason(const std::string& path, const std::string& manifest) const {
  if (const auto url = fetched_.find(path); url != fetched_.end())
    return "is missing: it is to be fetched from " + url->second + ", which is not done";
  const auto like = folded_.find(folded_path(path));
  return "is missing; " + manifest + " names it" +
         (like == folded_.end() ? "" : ", and it " + difference(like->second, path));
}

// What is named and not there, and what is there and not named.
void BagCheck::compare_lists() {
  std::set<std::string> missing;
  for (const Manifest& manifest : manifests_)
    for (const std::string& path : manifest.paths) {
      const auto entry = entries_.find(path);
      if (entry == entries_.end()) {
        if (!missing.insert(path).second) continue;
        report_.add_fault(path, missing_reason(path, manifest.file));
      } else if (entry->second.kind == Kind::folder) {
        report_.add_fault(path, "is a folder; " + manifest.file + " names it as a file");
      }
    }
  for (const auto& [path, entry] : entries_) {
    if (entry.kind != Kind::file) continue;
    const bool payload = path.starts_with(payload_prefix);
    std::size_t named = 0, manifests = 0;
    for (const Manifest& manifest : manifests_) {
      if (manifest.payload != payload) continue;
      ++manifests;
      named += manifest.paths.contains(path);
      if (payload && all_manifests_read_ && !manifest.paths.contains(path))
        report_.add_fault(path, manifest.file + " does not name it");
    }
    const bool tag_manifest = path.starts_with("tagmanifest-");
    if (!payload && !tag_manifest && manifests > 0 && named == 0)
      report_.add_warning(path, "no tag manifest names it: whether it is as it was is not known");
  }
}

void BagCheck::check_oxum() {
  const PayloadOxum found{report_.bytes, report_.files};
  for (const auto& [label, value] : report_.info) {
    if (label != "Payload-Oxum") continue;
    const std::optional<PayloadOxum> stated = read_oxum(value);
    if (!stated)
      report_.add_fault(info_name, "Payload-Oxum is \"" + value + "\", not bytes, a point and a number of files");
    else if (stated->bytes != found.bytes)
      report_.add_fault(info_name, format("Payload-Oxum states %llu bytes; the payload has %llu",
                                          static_cast<unsigned long long>(stated->bytes),
                                          static_cast<unsigned long long>(found.bytes)));
    else if (stated->files != found.files)
      report_.add_fault(info_name, format("Payload-Oxum states %llu files; the payload has %llu",
                                          static_cast<unsigned long long>(stated->files),
                                          static_cast<unsigned long long>(found.files)));
  }
}

BagReport BagCheck::run(const Parallel& parallel) {
  progress_.begin(Phase::measuring, "reading the bag", 1);
  list();
  check_names();
  read_texts();
  read_manifests();
  read_fetched();
  compare_lists();
  check_oxum();
  check_files(folder_, expected_, parallel, progress_, report_);
  return std::move(report_);
}

}  // namespace

BagReport check_bag(const std::filesystem::path& folder, const Parallel& parallel, Progress& progress) {
  return BagCheck(folder, progress).run(parallel);
}

}  // namespace fb::bake
