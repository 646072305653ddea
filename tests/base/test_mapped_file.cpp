#include <doctest/doctest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <string>

#include "base/file.h"
#include "base/mapped_file.h"
#include "base/status.h"
#include "temporary_folder.h"

namespace test_mapped_file {

using namespace fb;

namespace {

std::string text_of(const MappedFile& file) {
  return {reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()};
}

// The permissions of this file's mappings in /proc/self/maps: "r--s" is read-only and shared.
std::vector<std::string> mappings(const std::string& path) {
  std::ifstream maps("/proc/self/maps");
  std::vector<std::string> kinds;
  for (std::string line; std::getline(maps, line);)
    if (line.ends_with(path)) kinds.push_back(line.substr(line.find(' ') + 1, 4));
  return kinds;
}

}  // namespace

TEST_CASE("a file is mapped read-only and shared, and stays valid when it is replaced") {
  const test::Folder folder;
  const std::string path = folder.path() / "face.fbk";
  write_file(path, std::string(100000, 'a') + "end");
  {
    const MappedFile one{InputFile(path)}, other{InputFile(path)};
    CHECK(one.bytes().size() == 100003);
    CHECK(text_of(one) == text_of(other));
#ifdef __linux__
    CHECK(mappings(path) == std::vector<std::string>{"r--s", "r--s"});
#endif
    write_file(path, std::string("new"));
    CHECK(text_of(one).ends_with("aend"));
    CHECK(text_of(MappedFile(InputFile(path))) == "new");
  }
  CHECK(mappings(path).empty());
  write_file(path, std::string());
  CHECK(MappedFile(InputFile(path)).bytes().empty());
}

TEST_CASE("only regular files are opened, and no other is waited for") {
  const test::Folder folder;
  const std::string pipe = folder.path() / "pipe", file = folder.path() / "file";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  write_file(file, std::string("12345"));
  const auto refusal = [](const std::string& path) {
    try {
      InputFile(path, 4);
    } catch (const Error& error) {
      CHECK(std::strstr(error.what(), path.c_str()) != nullptr);
      return error.status();
    }
    return Status::ok;
  };
  CHECK(refusal(pipe) == Status::io);
  CHECK(refusal("/dev/zero") == Status::io);
  CHECK(refusal(folder.path()) == Status::io);
  CHECK(refusal(folder.path() / "nothing") == Status::not_found);
  CHECK(refusal(file) == Status::limit);
  CHECK(InputFile(file, 5).size() == 5);
}

TEST_CASE("a file that became shorter is read up to its end") {
  const test::Folder folder;
  const std::string path = folder.path() / "file";
  write_file(path, std::string("12345"));
  const InputFile file(path);
  REQUIRE(::truncate(path.c_str(), 3) == 0);
  std::vector<std::byte> bytes;
  file.read_all(bytes);
  CHECK(bytes.size() == 3);
  bytes.resize(9);
  CHECK(file.read_at(1, bytes) == 2);
}

}  // namespace test_mapped_file
