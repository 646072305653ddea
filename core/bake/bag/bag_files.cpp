#include "bake/bag/bag_files.h"

#include <optional>
#include <vector>

#include "bake/bag/bag_path.h"
#include "bake/bag/message_digest.h"
#include "bake/bag/tag_files.h"
#include "base/file.h"
#include "base/input_file.h"
#include "base/locked_file.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fs = std::filesystem;

namespace fb::bake {

void BagFiles::claim(const std::string& path, const std::string& from) {
  if (const std::string fault = bag_path_fault(path); !fault.empty())
    fail(Status::bad_data, "%s: cannot be in a bag as %s: it %s", shown(from).c_str(), shown(path).c_str(),
         fault.c_str());
  const auto [before, added] = claims_.emplace(folded_path(path), Claim{path, from});
  if (added) return;
  const Claim& first = before->second;
  if (first.path == path)
    fail(Status::bad_data, "%s and %s would both be %s in the bag", shown(first.from).c_str(), shown(from).c_str(),
         shown(path).c_str());
  fail(Status::bad_data, "%s and %s would have names in the bag that differ in %s only: %s and %s",
       shown(first.from).c_str(), shown(from).c_str(),
       composed_path(first.path) == composed_path(path) ? "Unicode's normalisation" : "the case of letters",
       shown(first.path).c_str(), shown(path).c_str());
}

template <class Read>
void BagFiles::write_pieces(const std::string& path, const std::string& from, Read&& read) {
  claim(path, from);
  const fs::path file = folder_ / path;
  make_folder(file.parent_path());
  std::optional<LockedFile> out = LockedFile::open(file, LockedFile::Missing::create);
  if (!out || !out->empty()) fail(Status::io, "%s: is being written by another process", shown(file).c_str());
  MessageDigest digest(sha512);
  BaggedFile bagged;
  read([&](std::span<const std::byte> piece) {
    out->write(piece);
    digest.add(piece);
    bagged.bytes += piece.size();
    progress_.ask();
  });
  out->sync();
  bagged.digest = digest.finish();
  files_.emplace(path, bagged);
}

void BagFiles::write(const std::string& path, std::span<const std::byte> bytes, const std::string& from) {
  write_pieces(path, from, [&](const auto& take) { take(bytes); });
}

void BagFiles::write(const std::string& path, std::string_view text) {
  write(path, std::as_bytes(std::span(text)), path);
}

void BagFiles::copy(const std::string& path, const fs::path& file) {
  const InputFile from(file);
  write_pieces(path, file.string(), [&](const auto& take) {
    std::vector<std::byte> piece(read_piece_bytes);
    for (std::uint64_t at = 0;;) {
      const std::size_t got = from.read_at(at, piece);
      if (got == 0) break;
      take(std::span<const std::byte>(piece.data(), got));
      at += got;
    }
  });
}

void BagFiles::copy(const std::string& path, const ClosedFolder& from, const std::string& inside) {
  const fs::path file = from.path() / inside;
  write_pieces(path, file.string(), [&](const auto& take) { with_path(file, [&] { from.read(inside, take); }); });
}

void BagFiles::adopt(const std::string& path) {
  claim(path, path);
  const InputFile file(folder_ / path);
  MessageDigest digest(sha512);
  std::vector<std::byte> bytes;
  file.read_all(bytes);
  digest.add(bytes);
  files_.emplace(path, BaggedFile{digest.finish(), bytes.size()});
}

std::string BagFiles::manifest(bool payload) const {
  std::string text;
  for (const auto& [path, file] : files_)
    if (path.starts_with(payload_prefix) == payload) text += file.digest + "  " + encode_bag_path(path) + "\n";
  return text;
}

void BagFiles::sync_folders() const {
  const auto complain = [&](const std::string& path, const std::string& reason) {
    fail_on(folder_ / path, Status::io, reason);
  };
  for (const ClosedFolder::Entry& entry : ClosedFolder(folder_).list(complain, progress_))
    if (entry.kind == ClosedFolder::Kind::folder) sync_folder(folder_ / entry.path);
  sync_folder(folder_);
}

}  // namespace fb::bake
