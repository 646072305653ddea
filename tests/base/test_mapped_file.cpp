#include <doctest/doctest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <string>
#include <thread>

#include "base/file.h"
#include "base/mapped_file.h"
#include "base/status.h"
#include "temporary_folder.h"

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
    const MappedFile one(path), other(path);
    CHECK(one.bytes().size() == 100003);
    CHECK(text_of(one) == text_of(other));
#ifdef __linux__
    CHECK(mappings(path) == std::vector<std::string>{"r--s", "r--s"});
#endif
    write_file(path, std::string("new"));
    CHECK(text_of(one).ends_with("aend"));
    CHECK(text_of(MappedFile(path)) == "new");
  }
  CHECK(mappings(path).empty());
}

TEST_CASE("files that cannot be mapped are read; errors name the file") {
  const test::Folder folder;
  const std::string empty = folder.path() / "empty", pipe = folder.path() / "pipe", file = folder.path() / "file";
  write_file(empty, std::string());
  CHECK(MappedFile(empty).bytes().empty());
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  std::thread writer([&] { std::ofstream(pipe) << "through a pipe"; });
  CHECK(text_of(MappedFile(pipe)) == "through a pipe");
  writer.join();

  write_file(file, std::string("12345"));
  CHECK(MappedFile(file, 5).bytes().size() == 5);
  const auto refusal = [](const std::string& path) {
    try {
      MappedFile(path, 4);
    } catch (const Error& error) {
      CHECK(std::strstr(error.what(), path.c_str()) != nullptr);
      return error.status();
    }
    return Status::ok;
  };
  CHECK(refusal(file) == Status::limit);
  CHECK(refusal(folder.path() / "nothing") == Status::not_found);
  CHECK(refusal(folder.path()) == Status::io);
}
