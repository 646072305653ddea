// Bags that are whole, ours and those of others, and paths in them.
#include <doctest/doctest.h>

#include <algorithm>

#include "bake/bag/bag_path.h"
#include "bake/bag/closed_folder.h"
#include "bake/bag/tag_files.h"
#include "made_bag.h"

namespace fs = std::filesystem;

namespace test_check_bag {

using fb::write_file;
using fb::test::append_to;
using fb::test::digest_of;
using fb::test::MadeBag;
using fb::test::text_of;

TEST_CASE("a bag that was written is whole") {
  const MadeBag bag;
  const fb::bake::BagReport report = bag.check();
  CHECK(report.valid());
  CHECK(report.warnings.empty());
  CHECK(report.version == "1.0");
  CHECK(report.algorithms == std::vector<std::string>{"sha512"});
  CHECK(report.files == bag.written().files);
  CHECK(report.archives.size() == 2);
  for (const fb::bake::CheckedArchive& archive : report.archives) CHECK(archive.poses > 0);
  CHECK(report.info.at(0) == std::pair<std::string, std::string>("Bagging-Date", "2026-11-29"));
}

// A bag as other programs write them.
class OtherBag {
 public:
  explicit OtherBag(const std::string& version = "1.0") {
    fs::create_directories(folder_ / "bag/data/a b");
    write_file(folder_ / "bag/bagit.txt", "BagIt-Version: " + version + "\r\nTag-File-Character-Encoding: UTF-8\r\n");
    write_file(folder_ / "bag/data/a b/words", std::string("some words\n"));
  }
  void list(const char* algorithm, const std::string& path, const char* between = "  ") {
    append(std::string("manifest-") + algorithm + ".txt",
           digest_of("some words\n", algorithm) + between + path + "\r\n");
  }
  void append(const std::string& file, const std::string& text) {
    const fs::path path = folder_ / "bag" / file;
    write_file(path, (fs::exists(path) ? text_of(path) : "") + text);
  }
  fs::path path() const { return folder_ / "bag"; }
  fb::bake::BagReport check() const { return fb::bake::check_bag(path(), {1}, fb::silent_progress()); }

 private:
  fb::test::Folder folder_;
};

bool warns(const fb::bake::BagReport& report, const std::string& reason) {
  return std::ranges::any_of(report.warnings,
                             [&](const auto& note) { return note.reason.find(reason) != std::string::npos; });
}

TEST_CASE("valid bags of others are accepted") {
  for (const char* algorithm : {"sha224", "sha256", "sha384", "sha512"}) {
    OtherBag bag;
    bag.list(algorithm, "data/a b/words", " \t");
    bag.append("bag-info.txt", "Contact-Name: A\r\n  B\r\nContact-Name: C\r\nPayload-Oxum: 11.1\r\n");
    const fb::bake::BagReport report = bag.check();
    CHECK(report.valid());
    CHECK(report.warnings.empty());
    CHECK(report.archives.empty());
    CHECK(report.info.at(0).second == "A B");
  }
}

TEST_CASE("what is weak or odd in a bag is told") {
  OtherBag weak("0.97");
  weak.list("md5", "./data/a b/words");
  CHECK(weak.check().valid());
  CHECK(warns(weak.check(), "is BagIt 0.97"));
  CHECK(warns(weak.check(), "find damage, not forgery"));
  CHECK(warns(weak.check(), "with \"./\" before it"));
  OtherBag odd;
  odd.list("sha256", "data/a b/words", " *");
  odd.append("manifest-whirlpool.txt", "00 data/a b/words\n");
  odd.append("tagmanifest-sha256.txt", digest_of(text_of(odd.path() / "bagit.txt"), "sha256") + "  bagit.txt\n");
  const fb::bake::BagReport report = odd.check();
  CHECK(report.valid());
  CHECK(warns(report, "begins with \"*\""));
  CHECK(warns(report, "is by an algorithm that is not known here"));
  CHECK(warns(report, "no tag manifest names it"));
}

TEST_CASE("a file called bagit.txt is not yet a bag in the bag") {
  OtherBag bag;
  bag.list("sha256", "data/a b/words");
  bag.append("data/bagit.txt", "some words\n");
  bag.list("sha256", "data/bagit.txt");
  CHECK(bag.check().valid());
}

TEST_CASE("files with line ends and per cent signs in their names are encoded") {
  const std::string odd = "data/a\nb\rc%d%0A";
  CHECK(fb::bake::encode_bag_path(odd) == "data/a%0Ab%0Dc%25d%250A");
  CHECK(fb::bake::decode_bag_path("data/a%0ab%0Dc%25d%250A", false) == odd);
  CHECK(!fb::bake::decode_bag_path("data/%41", false));
  CHECK(!fb::bake::decode_bag_path("data/%", false));
  CHECK(fb::bake::decode_bag_path("data/100%25%0A", true) == "data/100%25\n");
  OtherBag bag;
  fs::rename(bag.path() / "data/a b/words", bag.path() / odd);
  bag.list("sha512", fb::bake::encode_bag_path(odd));
  CHECK(bag.check().valid());
}

TEST_CASE("an archive is known by its signature, whatever it is called") {
  OtherBag bag;
  bag.list("sha256", "data/a b/words");
  const std::vector<std::byte> archive = fb::test::tiny_archive(1);
  const std::string bytes(reinterpret_cast<const char*>(archive.data()), archive.size());
  write_file(bag.path() / "data/face", bytes);
  write_file(bag.path() / "data/backup.fbk", std::string("of a database"));
  bag.append("manifest-sha256.txt", digest_of(bytes, "sha256") + "  data/face\n" +
                                        digest_of("of a database", "sha256") + "  data/backup.fbk\n");
  const fb::bake::BagReport report = bag.check();
  CHECK(report.valid());
  REQUIRE(report.archives.size() == 1);
  CHECK(report.archives[0].file == "data/face");
  CHECK(warns(report, "is called .fbk and is no FaceBaker archive"));
}

TEST_CASE("a closed folder is not left") {
  const fb::test::Folder folder;
  write_file(folder / "outside", std::string("secret"));
  fs::create_directories(folder / "in/deeper");
  fs::create_symlink(folder.path(), folder / "in/up");
  fs::create_symlink(folder / "outside", folder / "in/link");
  const fb::bake::ClosedFolder closed(folder / "in");
  for (const char* path : {"../outside", "up/outside", "link", "deeper/../../outside", "/etc/passwd", "deeper", ""})
    CHECK_THROWS_AS_MESSAGE(closed.read_text(path, 100), fb::Error, path);
}

}  // namespace test_check_bag
