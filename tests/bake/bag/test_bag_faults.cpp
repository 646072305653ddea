// Each way in which a bag can be wrong is found and named.
#include <doctest/doctest.h>
#include <sys/stat.h>

#include <algorithm>

#include "made_bag.h"

namespace fs = std::filesystem;

namespace test_bag_faults {

namespace {

using fb::write_file;
using fb::test::append_to;
using fb::test::digest_of;
using fb::test::MadeBag;
using fb::test::replace_in;
using fb::test::text_of;

struct Fault {
  std::string name;
  std::function<void(const fs::path& bag)> damage;
  std::string file, reason;  // how it is named; parts of the reason
};

constexpr const char *manifest = "manifest-sha512.txt", *words = "data/other/words.txt";

// A line of a manifest for a file of these words.
std::string line(const std::string& path) {
  return digest_of("some words\n") + "  " + path + "\n";
}

std::function<void(const fs::path&)> adds_line(const std::string& text) {
  return [text](const fs::path& bag) { append_to(bag / manifest, text); };
}

std::function<void(const fs::path&)> replaces(const char* file, const std::string& from, const std::string& to) {
  return [file, from, to](const fs::path& bag) { replace_in(bag / file, from, to); };
}

std::function<void(const fs::path&)> writes(const std::string& file, const std::string& text) {
  return [file, text](const fs::path& bag) {
    fs::create_directories((bag / file).parent_path());
    write_file(bag / file, text);
  };
}

// A file that a manifest names.
std::function<void(const fs::path&)> keeps(const std::string& file) {
  return [file](const fs::path& bag) {
    writes(file, "some words\n")(bag);
    append_to(bag / manifest, line(file));
  };
}

std::vector<Fault> faults_of_files() {
  return {
      {"missing", [](const fs::path& bag) { fs::remove(bag / words); }, words,
       "is missing; manifest-sha512.txt names it"},
      {"changed byte", replaces(words, "words", "wordz"), words, "another checksum than manifest-sha512.txt states"},
      {"extra", writes("data/more.txt", "more"), "data/more.txt", "manifest-sha512.txt does not name it"},
      {"truncated", [](const fs::path& bag) { fs::resize_file(bag / "data/archives/old.fbk", 100); },
       "data/archives/old.fbk", "another checksum"},
      {"link to a file", [](const fs::path& bag) { fs::create_symlink("words.txt", bag / "data/other/link"); },
       "data/other/link", "is a symbolic link, which is not followed"},
      {"link in place of a file",
       [](const fs::path& bag) {
         fs::rename(bag / words, bag.parent_path() / "kept.txt");
         fs::create_symlink(bag.parent_path() / "kept.txt", bag / words);
       },
       words, "is a symbolic link"},
      {"link to a folder", [](const fs::path& bag) { fs::create_symlink("/", bag / "data/root"); }, "data/root",
       "is a symbolic link"},
      {"data is a link",
       [](const fs::path& bag) {
         fs::rename(bag / "data", bag.parent_path() / "elsewhere");
         fs::create_symlink(bag.parent_path() / "elsewhere", bag / "data");
       },
       "data", "is a symbolic link"},
      {"a manifest is a link",
       [](const fs::path& bag) {
         fs::rename(bag / manifest, bag.parent_path() / "listed.txt");
         fs::create_symlink(bag.parent_path() / "listed.txt", bag / manifest);
       },
       manifest, "is a symbolic link"},
      {"pipe", [](const fs::path& bag) { REQUIRE(mkfifo((bag / "data/pipe").c_str(), 0600) == 0); }, "data/pipe",
       "a pipe, a socket or a device"},
      {"a pipe in place of a file",
       [](const fs::path& bag) {
         fs::remove(bag / words);
         REQUIRE(mkfifo((bag / words).c_str(), 0600) == 0);
       },
       words, "a pipe, a socket or a device"},
      {"case alone", keeps("data/other/Words.txt"), words, "differs from data/other/Words.txt in the case of letters"},
      {"case of folders alone", keeps("data/OTHER/words.txt"), "data/other", "differs from data/OTHER"},
      {"normalisation alone",
       [](const fs::path& bag) {
         keeps("data/e\u0301.txt")(bag);
         keeps("data/\u00e9.txt")(bag);
       },
       "data/\u00e9.txt", "in Unicode's normalisation only"},
      {"device of Windows", keeps("data/other/nul.txt"), "data/other/nul.txt", "that Windows keeps for a device"},
      {"backslash on the disk", keeps("data/a\\b"), "data/a\\b", "has a backslash in its name"},
      {"name that is no UTF-8", writes("data/caf\xe9", "x"), "data/caf\xe9", "has a name that is no UTF-8"},
      {"a bag in the bag",
       [](const fs::path& bag) {
         keeps("data/inner/bagit.txt")(bag);
         keeps("data/inner/data/words.txt")(bag);
       },
       "data/inner/bagit.txt", "begins a bag in the bag"},
      {"no payload folder", [](const fs::path& bag) { fs::remove_all(bag / "data"); }, "data",
       "there is no such folder"},
      {"empty payload",
       [](const fs::path& bag) {
         fs::remove_all(bag / "data");
         fs::create_directory(bag / "data");
         write_file(bag / manifest, std::string());
       },
       "data", "holds no file"},
      {"data is a file",
       [](const fs::path& bag) {
         fs::remove_all(bag / "data");
         write_file(bag / "data", std::string("x"));
       },
       "data", "is a file, not a folder"},
      {"an archive that is damaged, with the checksum of the damage",
       [](const fs::path& bag) {
         const fs::path file = bag / "data/archives/old.fbk";
         std::string bytes = text_of(file);
         const std::string before = digest_of(bytes);
         bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
         write_file(file, bytes);
         replace_in(bag / manifest, before, digest_of(bytes));
       },
       "data/archives/old.fbk", "does not verify: "},
      {"an archive that is empty, with its checksum",
       [](const fs::path& bag) {
         const fs::path file = bag / "data/archives/old.fbk";
         replace_in(bag / manifest, digest_of(text_of(file)), digest_of(""));
         write_file(file, std::string());
       },
       "data/archives/old.fbk", "does not verify: "},
  };
}

std::vector<Fault> faults_of_manifests() {
  const std::string digest = digest_of("some words\n");
  return {
      {"UTF-16",
       writes(manifest, std::string("\xff\xfe"
                                    "a\0",
                                    4)),
       manifest, "is UTF-16, not UTF-8"},
      {"byte order mark",
       [](const fs::path& bag) { write_file(bag / manifest, "\xef\xbb\xbf" + text_of(bag / manifest)); }, manifest,
       "begins with a byte order mark"},
      {"Latin-1", adds_line(line("data/caf\xe9")), manifest, "is not UTF-8: byte \\xe9 in line "},
      {"zero byte", adds_line(digest + "  data/a" + std::string(1, '\0') + "b\n"), manifest,
       "has a zero byte in line "},
      {"out of the bag", adds_line(line("../words.txt")), "../words.txt", "leads out of its folder by \"..\""},
      {"out of the payload", adds_line(line("data/../../words.txt")), "data/../../words.txt",
       "leads out of its folder"},
      {"absolute", adds_line(line("/etc/passwd")), "/etc/passwd", "has an absolute path"},
      {"backslash", adds_line(line("data\\words.txt")), "data\\words.txt", "has a backslash in its name"},
      {"drive", adds_line(line("C:/words.txt")), "C:/words.txt", "begins with the letter of a drive"},
      {"home", adds_line(line("~root/words.txt")), "~root/words.txt", "stands for a home folder"},
      {"part of no name", adds_line(line("data//words.txt")), "data//words.txt", "has an empty part between slashes"},
      {"part of a point", adds_line(line("data/./words.txt")), "data/./words.txt", "has a part \".\""},
      {"not in the payload", adds_line(line("bagit.txt")), "bagit.txt", "names it, and it is not in data/"},
      {"trailing slash", adds_line(line("data/other/")), "data/other/", "ends in a slash, as only a folder does"},
      {"a folder", adds_line(line("data/other")), "data/other", "is a folder; manifest-sha512.txt names it as a file"},
      {"twice", adds_line(line(words)), words, "names it a second time"},
      {"twice, with another checksum", adds_line(digest_of("x") + "  " + words + "\n"), words,
       "names it a second time, with another checksum"},
      {"the name of a file in other letters", adds_line(line("data/other/WORDS.txt")), "data/other/WORDS.txt",
       "is missing; manifest-sha512.txt names it, and it differs from data/other/words.txt in the case of letters "
       "only"},
      {"no path", adds_line(digest + "\n"), "line ", "is no checksum with a path after it"},
      {"empty line", adds_line("\n"), "line ", "is no checksum with a path after it"},
      {"short checksum", adds_line("abc123  data/x\n"), "data/x", "has 6 digits instead of 128"},
      {"not hexadecimal", adds_line(std::string(128, 'g') + "  data/x\n"), "data/x", "is not hexadecimal"},
      {"per cent sign", adds_line(line("data/100%.txt")), "data/100%.txt", "a % that is not of %0A, %0D or %25"},
      {"none", [](const fs::path& bag) { fs::remove(bag / manifest); }, "",
       "there is no manifest by a known algorithm"},
      {"unknown algorithm alone",
       [](const fs::path& bag) { fs::rename(bag / manifest, bag / "manifest-whirlpool.txt"); }, "",
       "there is no manifest by a known algorithm"},
      {"another manifest lacks files", writes("manifest-sha256.txt", ""), words,
       "manifest-sha256.txt does not name it"},
      {"another manifest has another checksum",
       writes("manifest-sha256.txt", digest_of("x", "sha256") + "  " + words + "\n"), words,
       "another checksum than manifest-sha256.txt states"},
  };
}

std::vector<Fault> faults_of_tags() {
  return {
      {"no declaration", [](const fs::path& bag) { fs::remove(bag / "bagit.txt"); }, "bagit.txt",
       "there is no such file: the folder is no bag"},
      {"another version", replaces("bagit.txt", "1.0", "3.7"), "bagit.txt", "declares BagIt 3.7"},
      {"no version", replaces("bagit.txt", "BagIt-Version: ", "Version: "), "bagit.txt", "its first line is not"},
      {"another encoding", replaces("bagit.txt", "UTF-8", "ISO-8859-1"), "bagit.txt",
       "declares the encoding ISO-8859-1"},
      {"no encoding", writes("bagit.txt", "BagIt-Version: 1.0\n"), "bagit.txt", "its second line is not"},
      {"more lines", [](const fs::path& bag) { append_to(bag / "bagit.txt", "Comment: none\n"); }, "bagit.txt",
       "has more than its two lines"},
      {"bytes of Payload-Oxum", replaces("bag-info.txt", "Payload-Oxum: ", "Payload-Oxum: 9"), "bag-info.txt",
       "bytes; the payload has"},
      {"files of Payload-Oxum",
       [](const fs::path& bag) {
         const std::string text = text_of(bag / "bag-info.txt");
         const std::size_t at = text.find("Payload-Oxum: "), point = text.find('.', at);
         write_file(bag / "bag-info.txt", text.substr(0, point + 1) + "9" + text.substr(point + 1));
       },
       "bag-info.txt", "files; the payload has"},
      {"form of Payload-Oxum", replaces("bag-info.txt", "Payload-Oxum: ", "Payload-Oxum: about "), "bag-info.txt",
       "not bytes, a point and a number of files"},
      {"a line without a label", [](const fs::path& bag) { append_to(bag / "bag-info.txt", "no label here\n"); },
       "bag-info.txt", "is no label with a colon and a value"},
      {"a description that is no UTF-8",
       [](const fs::path& bag) { append_to(bag / "bag-info.txt", "Contact-Name: Ren\xe9\n"); }, "bag-info.txt",
       "is not UTF-8"},
      {"a changed description", replaces("bag-info.txt", "2026-11-29", "2025-11-29"), "bag-info.txt",
       "another checksum than tagmanifest-sha512.txt states"},
      {"a description that is gone", [](const fs::path& bag) { fs::remove(bag / "bag-info.txt"); }, "bag-info.txt",
       "is missing; tagmanifest-sha512.txt names it"},
      {"a tag manifest with a file of the payload",
       [](const fs::path& bag) { append_to(bag / "tagmanifest-sha512.txt", line(words)); }, words,
       "names a file of the payload"},
      {"to be fetched",
       [](const fs::path& bag) {
         fs::remove(bag / words);
         write_file(bag / "fetch.txt", std::string("https://example.org/words 11 ") + words + "\n");
       },
       words, "is to be fetched from https://example.org/words, which is not done"},
      {"fetched to elsewhere", writes("fetch.txt", "https://example.org/words 11 ../words.txt\n"), "../words.txt",
       "leads out of its folder"},
      {"fetched, and in no manifest", writes("fetch.txt", "https://example.org/words - data/new.txt\n"), "data/new.txt",
       "fetch.txt names it, and no manifest does"},
      {"no list of what to fetch", writes("fetch.txt", "https://example.org/words\n"), "line 1 of fetch.txt",
       "is no address with a length and a path after it"},
  };
}

void check_faults(const std::vector<Fault>& faults) {
  for (const Fault& fault : faults) {
    CAPTURE(fault.name);
    const MadeBag bag;
    fault.damage(bag.path());
    const fb::bake::BagReport report = bag.check();
    CHECK(!report.valid());
    std::string all;
    for (const fb::bake::BagNote& note : report.faults) all += note.file + ": " + note.reason + "\n";
    const bool found = std::ranges::any_of(report.faults, [&](const fb::bake::BagNote& note) {
      const bool named = note.file == fault.file || (fault.file == "line " && note.file.starts_with("line "));
      return named && note.reason.find(fault.reason) != std::string::npos;
    });
    CHECK_MESSAGE(found, all);
  }
}

}  // namespace

TEST_CASE("what is wrong with files is named") {
  check_faults(faults_of_files());
}

TEST_CASE("what is wrong with manifests is named") {
  check_faults(faults_of_manifests());
}

TEST_CASE("what is wrong with other texts is named") {
  check_faults(faults_of_tags());
}

TEST_CASE("one fault is one fault") {
  for (const Fault& fault : faults_of_files()) {
    if (fault.name != "missing" && fault.name != "extra" && fault.name != "changed byte") continue;
    CAPTURE(fault.name);
    const MadeBag bag;
    fs::remove(bag / "bag-info.txt");  // whose Payload-Oxum is wrong, too
    fs::remove(bag / "tagmanifest-sha512.txt");
    fault.damage(bag.path());
    CHECK(bag.check().faults.size() == 1);
  }
}

TEST_CASE("all faults of a bag are collected") {
  const MadeBag bag;
  replace_in(bag / words, "words", "wordz");
  replace_in(bag / "bagit.txt", "1.0", "3.7");
  write_file(bag / "data/more.txt", std::string("more"));
  fs::remove(bag / "data/archives/young.fbk");
  std::vector<std::string> files;
  for (const fb::bake::BagNote& note : bag.check().faults) files.push_back(note.file);
  for (const char* file : {words, "bagit.txt", "data/more.txt", "data/archives/young.fbk", "bag-info.txt"})
    CHECK_MESSAGE(std::ranges::find(files, file) != files.end(), file);
}

}  // namespace test_bag_faults
