#include "bake/bag/write_bag.h"

#include <system_error>

#include "archive/reader.h"
#include "bake/bag/bag_files.h"
#include "bake/bag/check_bag.h"
#include "bake/bag/check_files.h"
#include "bake/bag/face_record.h"
#include "bake/bag/kept_texts.h"
#include "bake/bag/partial_folder.h"
#include "bake/bag/premis.h"
#include "bake/bag/record_texts.h"
#include "bake/bag/tag_files.h"
#include "base/file.h"
#include "base/output_lock.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fs = std::filesystem;

namespace fb::bake {
namespace {

constexpr const char *access_prefix = "data/access/", *metadata_prefix = "data/metadata/",
                     *source_prefix = "data/source/";

// The name of a file or folder that somebody gave, with or without a slash at its end.
std::string name_of(const fs::path& path) {
  const fs::path named = path.has_filename() ? path : path.parent_path();
  const std::string name = named.filename().string();
  std::error_code error;
  return name == "." || name == ".." ? fs::canonical(path, error).filename().string() : name;
}

// Fails on what cannot be read in a folder.
ClosedFolder::Complain complain_of(const fs::path& folder) {
  return [folder](const std::string& path, const std::string& reason) { fail_on(folder / path, Status::io, reason); };
}

class BagWriter {
 public:
  BagWriter(const BagContents& contents, const fs::path& folder, Progress& progress)
      : contents_(contents), folder_(folder), progress_(progress), files_(folder, progress) {}

  void run() {
    add_archives();
    for (const fs::path& file : contents_.beside) files_.copy(archives_prefix + name_of(file), file);
    add_copies();
    add_sources();
    for (const auto& [path, file] : contents_.files) files_.copy(payload_prefix + path, file);
    add_texts();
    add_tag_files();
    files_.sync_folders();
  }

 private:
  void add_archives();
  void add_copies();
  void adopt_copies(const fs::path& access, FaceRecord& face);
  void add_thumbnail(std::size_t index);
  void add_sources();
  void add_folder(const fs::path& source, const std::string& prefix);
  void add_texts();
  void add_tag_files();

  const BagContents& contents_;
  const fs::path folder_;
  Progress& progress_;
  BagFiles files_;
  std::vector<FaceRecord> faces_;
};

void BagWriter::add_archives() {
  progress_.begin(Phase::writing, "verifying archives", contents_.archives.size());
  for (const fs::path& archive : contents_.archives) {
    const std::vector<std::byte> bytes = read_file(archive);
    faces_.push_back(with_path(archive, [&] { return read_face_record(bytes, name_of(archive)); }));
    files_.write(faces_.back().file, bytes, archive.string());
    progress_.step(faces_.size());
  }
}

void BagWriter::add_copies() {
  const fs::path access = folder_ / "data" / "access";
  make_folder(access);
  progress_.begin(Phase::writing, "making access copies", faces_.size());
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    FaceRecord& face = faces_[i];
    if (contents_.make_copies)
      contents_.make_copies(i, access / face.name);
    else
      add_thumbnail(i);
    if (contents_.make_copies) adopt_copies(access, face);
    progress_.step(i + 1);
  }
  std::error_code not_empty;
  fs::remove(access, not_empty);
}

// What is new in the folder is of this face.
void BagWriter::adopt_copies(const fs::path& access, FaceRecord& face) {
  for (const ClosedFolder::Entry& entry : ClosedFolder(access).list(complain_of(access), progress_)) {
    const std::string path = access_prefix + entry.path;
    if (files_.all().contains(path)) continue;
    files_.adopt(path);
    face.copies.push_back(path);
  }
}

void BagWriter::add_thumbnail(std::size_t index) {
  const archive::Archive read = archive::read_archive(read_file(contents_.archives[index]));
  if (read.model.character.thumbnail.empty()) return;
  faces_[index].copies.push_back(access_prefix + faces_[index].name + ".png");
  files_.write(faces_[index].copies.back(), read.model.character.thumbnail, faces_[index].name);
}

void BagWriter::add_sources() {
  progress_.begin(Phase::writing, "copying sources", contents_.sources.size());
  for (std::size_t i = 0; i < contents_.sources.size(); ++i) {
    const fs::path& source = contents_.sources[i];
    const std::string path = source_prefix + name_of(source);
    std::error_code missing;
    if (fs::is_directory(source, missing))
      add_folder(source, path + "/");
    else
      files_.copy(path, source);
    progress_.step(i + 1);
  }
}

void BagWriter::add_folder(const fs::path& source, const std::string& prefix) {
  OutputLock::refuse_if_written(source);
  const ClosedFolder folder(source);
  bool empty = true;
  for (const ClosedFolder::Entry& entry : folder.list(complain_of(source), progress_)) {
    if (entry.kind == ClosedFolder::Kind::folder) continue;
    if (entry.kind == ClosedFolder::Kind::link)
      fail_on(source / entry.path, Status::bad_data, "is a symbolic link, which a bag cannot have: give what it names");
    if (entry.kind == ClosedFolder::Kind::other)
      fail_on(source / entry.path, Status::bad_data, "is neither file nor folder");
    files_.copy(prefix + entry.path, folder, entry.path);
    empty = false;
  }
  if (empty) fail_on(source, Status::bad_data, "holds no file");
}

void BagWriter::add_texts() {
  for (const KeptText& kept : kept_texts()) files_.write(std::string(payload_prefix) + kept.path, kept.text);
  for (const FaceRecord& face : faces_) {
    files_.write(metadata_prefix + face.name + ".rights.txt", rights_text(face));
    files_.write(metadata_prefix + face.name + ".provenance.txt", provenance_text(face));
  }
  files_.write(std::string(metadata_prefix) + "premis.xml",
               premis_xml(files_.all(), faces_, contents_.date, contents_.software));
}

void BagWriter::add_tag_files() {
  PayloadOxum oxum;
  for (const auto& [path, file] : files_.all()) oxum.bytes += file.bytes, ++oxum.files;
  std::string info = bag_info_line("Bagging-Date", contents_.date) +
                     bag_info_line("Bag-Software-Agent", contents_.software) +
                     bag_info_line("Payload-Oxum", std::to_string(oxum.bytes) + "." + std::to_string(oxum.files));
  for (const auto& [label, value] : contents_.info) info += bag_info_line(label, value);
  const std::string payload = files_.manifest(true);
  files_.write(declaration_name, "BagIt-Version: 1.0\nTag-File-Character-Encoding: UTF-8\n");
  files_.write(info_name, info);
  files_.write("manifest-sha512.txt", payload);
  files_.write("tagmanifest-sha512.txt", files_.manifest(false));
}

void check_contents(const BagContents& contents) {
  if (contents.archives.empty()) fail(Status::invalid_argument, "there is no archive to put into the bag");
  // Before anything takes long.
  const auto require_there = [](const fs::path& path) {
    std::error_code error;
    if (!fs::exists(path, error)) fail_on(path, Status::not_found, "no such file");
  };
  for (const auto* given : {&contents.archives, &contents.beside, &contents.sources})
    for (const fs::path& path : *given) require_there(path);
  for (const auto& [path, file] : contents.files) require_there(file);
  for (const auto& [label, value] : contents.info) {
    bag_info_line(label, value);
    for (const char* own : {"Bagging-Date", "Bag-Software-Agent", "Payload-Oxum"})
      if (label == own) fail(Status::invalid_argument, "%s is written by the bag itself", own);
  }
}

}  // namespace

BagReport write_bag(const fs::path& folder, const BagContents& contents, const Parallel& parallel, Progress& progress) {
  check_contents(contents);
  PartialFolder partial(folder);
  BagWriter(contents, partial.path(), progress).run();
  BagReport report = check_bag(partial.path(), parallel, progress);
  if (!report.valid()) {
    const BagNote& first = report.faults[0];
    fail(Status::internal, "%s: is not valid as it was written: %s: %s", shown(folder).c_str(),
         shown(first.file).c_str(), first.reason.c_str());
  }
  partial.commit();
  return report;
}

}  // namespace fb::bake
