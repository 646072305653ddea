#include <doctest/doctest.h>

#include <filesystem>

#include "base/file.h"
#include "base/shown_path.h"
#include "base/status.h"
#include "temporary_folder.h"

namespace fb {
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

TEST_CASE("folders are made with their parents, also through a name that ends in a slash") {
  test::Folder folder;
  make_folder(folder / "a/b/c/");
  make_folder(folder / "a/b");
  CHECK(fs::is_directory(folder / "a/b/c"));
  write_file(folder / "f", std::string());
  CHECK_THROWS_WITH_AS(make_folder(folder / "f/g"), doctest::Contains("f/g: cannot be created"), Error);
  CHECK_THROWS_WITH_AS(make_folder(folder / "f"), doctest::Contains("f: cannot be created"), Error);
}

}  // namespace fb
