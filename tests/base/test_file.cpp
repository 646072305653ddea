#include <doctest/doctest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "base/file.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "temporary_folder.h"

namespace fb::test_file {
namespace {

namespace fs = std::filesystem;

Status status_of(const fs::path& path, std::uint64_t limit = UINT64_MAX) {
  try {
    read_file(path, limit);
    return Status::ok;
  } catch (const Error& error) {
    CHECK_MESSAGE(std::string(error.what()).ends_with("(" + shown(path.native()) + ")"), error.what());
    return error.status();
  }
}

std::string text_of(const fs::path& path) {
  const auto bytes = read_file(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

mode_t mode_of(const fs::path& path) {
  struct stat found = {};
  CHECK(::stat(path.c_str(), &found) == 0);
  return found.st_mode & 07777;
}

// The message of writing to this path; "" if it succeeds.
std::string refusal(const fs::path& path) {
  try {
    write_file(path, std::string("new"));
    return "";
  } catch (const Error& error) {
    return error.what();
  }
}

}  // namespace

TEST_CASE("a written file is read back, also if empty or larger than a block") {
  test::Folder folder;
  for (const std::size_t size : {0, 1, 65536, 200001}) {
    std::vector<std::byte> bytes(size);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i * 7);
    write_file(folder.path() / "f", bytes);
    CHECK(read_file(folder.path() / "f") == bytes);
  }
  write_file(folder.path() / "f", std::string("text"));
  CHECK(read_file(folder.path() / "f").size() == 4);
  CHECK(folder.entries() == 1);
}

TEST_CASE("errors of reading name the file") {
  test::Folder folder;
  CHECK(status_of(folder.path() / "missing") == Status::not_found);
  CHECK(status_of(folder.path() / "missing" / "f") == Status::not_found);
  CHECK(status_of(folder.path() / std::string(5000, 'f')) == Status::io);  // the system's reason, not "no such file"
  CHECK(status_of(folder.path()) == Status::io);
  write_file(folder.path() / "f", std::string("12345"));
  CHECK(status_of(folder.path() / "f", 4) == Status::limit);
  CHECK(status_of(folder.path() / "f", 5) == Status::ok);
}

TEST_CASE("an uncommitted file leaves the old one and no temporary file") {
  test::Folder folder;
  const fs::path path = folder.path() / "f";
  write_file(path, std::string("old"));
  {
    AtomicFile file(path);
    file.write(std::as_bytes(std::span("new")));
    CHECK(read_file(path).size() == 3);
    CHECK(folder.entries() == 2);
  }
  CHECK(read_file(path).size() == 3);
  CHECK(folder.entries() == 1);
}

TEST_CASE("a check before the rename sees the whole file, and keeps the old one when it fails") {
  test::Folder folder;
  const fs::path path = folder.path() / "f";
  write_file(path, std::string("old"));
  const std::string text = "newer";
  {
    AtomicFile file(path);
    file.write(std::as_bytes(std::span(text)));
    CHECK_THROWS_WITH_AS(file.commit([&](const fs::path& written) {
      CHECK(written != path);
      CHECK(read_file(written).size() == text.size());
      fail(Status::corrupt, "refused");
    }),
                         "refused", Error);
  }
  CHECK(read_file(path).size() == 3);
  CHECK(folder.entries() == 1);
  AtomicFile file(path);
  file.write(std::as_bytes(std::span(text)));
  file.commit([](const fs::path&) {});
  CHECK(read_file(path).size() == text.size());
}

TEST_CASE("errors of writing name the file") {
  test::Folder folder;
  CHECK_THROWS_WITH_AS(write_file(folder.path(), std::string()), doctest::Contains("is a directory"), Error);
  CHECK_THROWS_WITH_AS(write_file(folder.path() / "no" / "f", std::string()), doctest::Contains("cannot be written"),
                       Error);
  CHECK(folder.entries() == 0);
}

TEST_CASE("a file that is replaced hands on its rights and its owner") {
  test::Folder folder;
  const fs::path path = folder / "f";
  const mode_t before = ::umask(027);
  write_file(path, std::string("old"));
  CHECK(mode_of(path) == 0640);  // a new file, by the umask
  for (const mode_t mode : {0600, 0666, 0751, 0640}) {
    ::chmod(path.c_str(), mode);
    AtomicFile file(path);
    const fs::path partial = path.native() + ".facebaker-partial";
    CHECK(mode_of(partial) == mode);  // before there is anything to read
    file.commit();
    CHECK(mode_of(path) == mode);
  }
  if (::geteuid() == 0) {
    REQUIRE(::chown(path.c_str(), 1234, 4321) == 0);
    write_file(path, std::string("new"));
    struct stat found = {};
    CHECK(::stat(path.c_str(), &found) == 0);
    CHECK(found.st_uid == 1234);
    CHECK(found.st_gid == 4321);
  }
  ::umask(before);
}

TEST_CASE("what a killed process left behind hands on nothing") {
  test::Folder folder;
  const mode_t before = ::umask(022);
  const fs::path partial = folder / "f.facebaker-partial";
  std::ofstream(partial) << "left over";
  ::chmod(partial.c_str(), 0600);
  write_file(folder / "f", std::string("new"));
  CHECK(text_of(folder / "f") == "new");
  CHECK(mode_of(folder / "f") == 0644);
  CHECK(folder.entries() == 1);
  ::umask(before);
}

TEST_CASE("links are followed: what they point at is written") {
  test::Folder folder;
  make_folder(folder / "there");
  fs::create_symlink("there/f", folder / "link");
  fs::create_symlink(folder / "link", folder / "second");
  write_file(folder / "second", std::string("first"));  // which nothing was at
  CHECK(text_of(folder / "there/f") == "first");
  ::chmod((folder / "there/f").c_str(), 0600);
  write_file(folder / "second", std::string("next"));
  CHECK(text_of(folder / "there/f") == "next");
  CHECK(mode_of(folder / "there/f") == 0600);
  CHECK(fs::is_symlink(folder / "second"));
  CHECK(fs::is_symlink(folder / "link"));
  CHECK(folder.entries() == 3);
  fs::create_symlink("nowhere/f", folder / "lost");
  CHECK(refusal(folder / "lost").find("nowhere/f") != std::string::npos);
  fs::create_symlink("circle", folder / "circle");
  CHECK(refusal(folder / "circle").find("symbolic links") != std::string::npos);
  fs::create_symlink("there", folder / "folder");
  CHECK(refusal(folder / "folder").ends_with("is a directory, not a file"));
}

TEST_CASE("a file that may not be written is refused, a link where one may not write is followed") {
  test::Folder folder;
  ::chmod(folder.path().c_str(), 0777);
  make_folder(folder / "theirs");
  make_folder(folder / "open");
  ::chmod((folder / "open").c_str(), 0777);
  fs::create_symlink("../open/f", folder / "theirs/link");
  const pid_t child = ::fork();
  if (child == 0) {  // as somebody who is not root
    if (::geteuid() == 0 && ::setuid(65534) != 0) ::_exit(2);
    if (!refusal(folder / "theirs/link").empty() || text_of(folder / "open/f") != "new") ::_exit(3);
    ::chmod((folder / "open/f").c_str(), 0444);
    if (!refusal(folder / "open/f").ends_with("cannot be written: Permission denied")) ::_exit(4);
    if (::geteuid() == 65534 && !refusal(folder / "theirs/f").ends_with("Permission denied")) ::_exit(5);
    ::_exit(0);
  }
  int status = 0;
  CHECK(::waitpid(child, &status, 0) == child);
  CHECK(WEXITSTATUS(status) == 0);
  CHECK(status == 0);
}

TEST_CASE("folders are made with their parents, also through a name that ends in a slash") {
  test::Folder folder;
  make_folder(folder / "a/b/c/");
  make_folder(folder / "a/b");
  CHECK(fs::is_directory(folder / "a/b/c"));
  write_file(folder / "f", std::string());
  CHECK_THROWS_WITH_AS(make_folder(folder / "f/g"), doctest::Contains("f/g: cannot be created"), Error);
  CHECK_THROWS_WITH_AS(make_folder(folder / "f"), doctest::Contains("f: cannot be created"), Error);
}

}  // namespace fb::test_file
