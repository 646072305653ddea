// Bags for tests: one that is whole, and what is done to it.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "archive/writer.h"
#include "bake/bag/check_bag.h"
#include "bake/bag/message_digest.h"
#include "bake/bag/write_bag.h"
#include "bake/measure/verify.h"
#include "base/file.h"
#include "base/parallel.h"
#include "temporary_folder.h"
#include "test_models.h"

namespace fb::test {

inline std::string text_of(const std::filesystem::path& file) {
  const std::vector<std::byte> bytes = read_file(file);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline std::string digest_of(const std::string& text, const char* algorithm = bake::sha512) {
  bake::MessageDigest digest(algorithm);
  digest.add(std::as_bytes(std::span(text)));
  return digest.finish();
}

inline void replace_in(const std::filesystem::path& file, const std::string& from, const std::string& to) {
  std::string text = text_of(file);
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  write_file(file, text.replace(at, from.size(), to));
}

inline void append_to(const std::filesystem::path& file, const std::string& text) {
  write_file(file, text_of(file) + text);
}

inline std::vector<std::byte> tiny_archive(std::uint64_t seed, const std::string& about = "") {
  PackedModel model = tiny_packed_model(seed);
  model.character.about = about;
  model.provenance = R"({"creator":"FaceBaker 1.2","created":"2026-11-01","recipe":"hero"})";
  return archive::write_archive(model, bake::make_proof(model, 1), {"CC0", ""});
}

// A bag of two archives and a source, with one more file in data/ for tests to damage: other/words.txt.
class MadeBag {
 public:
  MadeBag() {
    write_file(folder_ / "old.fbk", tiny_archive(1));
    write_file(folder_ / "young.fbk", tiny_archive(2));
    write_file(folder_ / "words.txt", std::string("some words\n"));
    bake::BagContents contents;
    contents.archives = {folder_ / "old.fbk", folder_ / "young.fbk"};
    contents.files = {{"other/words.txt", folder_ / "words.txt"}};
    contents.date = "2026-11-29";
    contents.software = "FaceBaker 1.2";
    report_ = bake::write_bag(path(), contents, {1}, silent_progress());
  }
  std::filesystem::path path() const { return folder_ / "bag"; }
  std::filesystem::path operator/(const std::string& name) const { return path() / name; }
  const bake::BagReport& written() const { return report_; }
  bake::BagReport check() const { return bake::check_bag(path(), {1}, silent_progress()); }

 private:
  Folder folder_;
  bake::BagReport report_;
};

}  // namespace fb::test
