// What is in a bag, and what cannot be put into one.
#include <doctest/doctest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bake/bag/kept_texts.h"
#include "made_bag.h"
#include "watched_progress.h"

namespace fs = std::filesystem;

namespace test_write_bag {

using fb::write_file;
using fb::test::digest_of;
using fb::test::Folder;
using fb::test::text_of;

namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

fb::bake::BagContents contents_of(const std::vector<fs::path>& archives) {
  fb::bake::BagContents contents;
  contents.archives = archives;
  contents.date = "2026-11-29";
  contents.software = "FaceBaker 1.2";
  return contents;
}

// "" or the message of what it fails with; what stands in the folder then is checked.
std::string failure(const Folder& folder, const fb::bake::BagContents& contents) {
  const std::size_t entries = folder.entries();
  try {
    fb::bake::write_bag(folder / "bag", contents, {1}, fb::silent_progress());
  } catch (const fb::Error& error) {
    CHECK(!fs::exists(folder / "bag"));
    CHECK(folder.entries() == entries);
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a bag holds archives, texts, rights and provenance") {
  const Folder folder;
  write_file(folder / "king.fbk",
             fb::test::tiny_archive(1, R"({"author":"A & B","rights":{"expires":"2031-12-31","agreement":"17/4",)"
                                       R"("uses":"stage <only>","learning":"forbidden"}})"));
  write_file(folder / "king.fbk.sig", std::string("signature"));
  fs::create_directories(folder / "rig/poses");
  write_file(folder / "rig/dataset.json", std::string("{}"));
  write_file(folder / "rig/poses/100%.npy", std::string("numbers"));
  fb::bake::BagContents contents = contents_of({folder / "king.fbk"});
  contents.beside = {folder / "king.fbk.sig"};
  contents.sources = {folder / "rig/"};
  contents.info = {{"Source-Organization", "An archive"}};
  contents.make_copies = [](std::size_t, const fs::path& base) {
    write_file(base.string() + ".png", std::string("png"));
  };
  const fb::bake::BagReport report = fb::bake::write_bag(folder / "new/bag", contents, {1}, fb::silent_progress());
  CHECK(report.valid());
  const fs::path bag = folder / "new/bag";
  CHECK(text_of(bag / "data/archives/king.fbk") == text_of(folder / "king.fbk"));
  CHECK(text_of(bag / "data/archives/king.fbk.sig") == "signature");
  CHECK(text_of(bag / "data/source/rig/poses/100%.npy") == "numbers");
  CHECK(text_of(bag / "data/access/king.fbk.png") == "png");
  CHECK(contains(text_of(bag / "manifest-sha512.txt"), digest_of("numbers") + "  data/source/rig/poses/100%25.npy\n"));
  CHECK(contains(text_of(bag / "bag-info.txt"), "Source-Organization: An archive\n"));
  const std::string rights = text_of(bag / "data/metadata/king.fbk.rights.txt");
  CHECK(contains(rights, "rights.expires: 2031-12-31\n"));
  CHECK(contains(rights, "CC0"));
  CHECK(contains(text_of(bag / "data/metadata/king.fbk.provenance.txt"), "created: 2026-11-01\n"));
  const std::string premis = text_of(bag / "data/metadata/premis.xml");
  for (const char* part :
       {"<endDate>2031-12-31</endDate>", "<restriction>stage &lt;only&gt;</restriction>",
        "<otherRightsDocumentationIdentifierValue>17/4<", "<eventDateTime>2026-11-01</eventDateTime>",
        "<relatedObjectIdentifierValue>data/archives/king.fbk<", "<licenseTerms>CC0</licenseTerms>"})
    CHECK_MESSAGE(contains(premis, part), premis);
  CHECK(contains(premis, "<messageDigest>" + digest_of(text_of(folder / "king.fbk")) + "</messageDigest>"));
  CHECK(fs::exists(folder / "new/bag.facebaker-lock") == false);
}

TEST_CASE("texts in a bag are those of the tree") {
  const fb::test::MadeBag bag;
  for (const fb::bake::KeptText& kept : fb::bake::kept_texts())
    CHECK(text_of(bag / (std::string("data/") + kept.path)) == kept.text);
  const fs::path tree = FB_SOURCE_ROOT;
  for (const auto& entry : fs::directory_iterator(tree / "core/archive"))
    if (entry.path().extension() == ".md")
      CHECK(text_of(bag / ("data/texts/" + entry.path().filename().string())) == text_of(entry.path()));
  for (const auto& entry : fs::directory_iterator(bag / "data/reader"))
    if (entry.path().extension() == ".py")
      CHECK(text_of(entry.path()) == text_of(tree / "tests/conformance" / entry.path().filename()));
}

TEST_CASE("the same archives and date give the same bytes") {
  const fb::test::MadeBag a, b;
  CHECK(text_of(a / "tagmanifest-sha512.txt") == text_of(b / "tagmanifest-sha512.txt"));
}

TEST_CASE("what cannot be in a bag is named") {
  const Folder folder;
  write_file(folder / "king.fbk", fb::test::tiny_archive(1));
  fs::create_directories(folder / "more");
  const auto with = [&](const std::string& name) {
    write_file(folder / ("more/" + name), fb::test::tiny_archive(1));
    return contents_of({folder / "king.fbk", folder / ("more/" + name)});
  };
  CHECK(contains(failure(folder, with("king.fbk")), "would both be data/archives/king.fbk in the bag"));
  CHECK(contains(failure(folder, with("KING.fbk")), "differ in the case of letters only"));
  fb::bake::BagContents contents = with("e\u0301.fbk");
  write_file(folder / "\u00e9.fbk", fb::test::tiny_archive(1));
  contents.archives.push_back(folder / "\u00e9.fbk");
  CHECK(contains(failure(folder, contents), "differ in Unicode's normalisation only"));
  CHECK(contains(failure(folder, with("aux.fbk")), "that Windows keeps for a device"));
  CHECK(contains(failure(folder, with("\xe9.fbk")), "has a name that is no UTF-8"));
  CHECK(contains(failure(folder, contents_of({folder / "none.fbk"})), "no such file"));
  CHECK(contains(failure(folder, contents_of({})), "there is no archive"));

  std::vector<std::byte> bytes = fb::test::tiny_archive(1);
  bytes[bytes.size() / 2] ^= std::byte(1);
  write_file(folder / "damaged.fbk", bytes);
  CHECK(contains(failure(folder, contents_of({folder / "damaged.fbk"})), "damaged.fbk"));

  contents = contents_of({folder / "king.fbk"});
  fs::create_directory(folder / "rig");
  contents.sources = {folder / "rig"};
  CHECK(contains(failure(folder, contents), "holds no file"));
  fs::create_symlink("/etc", folder / "rig/link");
  CHECK(contains(failure(folder, contents), "is a symbolic link"));
  contents.sources.clear();
  contents.files = {{"../outside", folder / "king.fbk"}};
  CHECK(contains(failure(folder, contents), "leads out of its folder"));
  contents.files.clear();
  contents.info = {{"Contact-Name", "two\nlines"}};
  CHECK(contains(failure(folder, contents), "is not one line of UTF-8"));
  contents.info = {{"Payload-Oxum", "1.1"}};
  CHECK(contains(failure(folder, contents), "is written by the bag itself"));
}

TEST_CASE("a folder that is not empty stays as it is") {
  const Folder folder;
  write_file(folder / "king.fbk", fb::test::tiny_archive(1));
  fs::create_directory(folder / "bag");
  write_file(folder / "bag/mine", std::string("mine"));
  CHECK_THROWS_AS(fb::bake::write_bag(folder / "bag", contents_of({folder / "king.fbk"}), {1}, fb::silent_progress()),
                  fb::Error);
  CHECK(text_of(folder / "bag/mine") == "mine");
  CHECK(folder.entries() == 2);
  fs::remove(folder / "bag/mine");
  // What a killed process left is gone with the next bag.
  fs::create_directories(folder / "bag.facebaker-partial/data");
  write_file(folder / "bag.facebaker-partial/data/half", std::string("half"));
  CHECK(fb::bake::write_bag(folder / "bag/", contents_of({folder / "king.fbk"}), {1}, fb::silent_progress()).valid());
  CHECK(folder.entries() == 2);
  CHECK(!fs::exists(folder / "bag/data/half"));
}

}  // namespace test_write_bag
