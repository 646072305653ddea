#include <doctest/doctest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/file.h"
#include "base/output_lock.h"
#include "base/status.h"
#include "temporary_folder.h"

namespace fb::test_output_lock {
namespace {

namespace fs = std::filesystem;

// A child that does work() and then waits to be killed.
class Child {
 public:
  template <class Work>
  explicit Child(const Work& work) {
    int ready[2];
    REQUIRE(pipe(ready) == 0);
    process_ = fork();
    REQUIRE(process_ >= 0);
    if (process_ == 0) {
      const auto held = work();
      if (write(ready[1], "", 1) != 1) _exit(1);
      while (true) pause();
    }
    char byte;
    REQUIRE(read(ready[0], &byte, 1) == 1);
    close(ready[0]);
    close(ready[1]);
  }
  ~Child() { end(); }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void end() {
    if (process_ <= 0) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    process_ = 0;
  }
  pid_t process() const { return process_; }

 private:
  pid_t process_ = 0;
};

std::string refusal(const fs::path& path) {
  try {
    const OutputLock lock = fs::is_directory(path) ? OutputLock::of_folder(path) : OutputLock::of_file(path);
    return "";
  } catch (const Error& error) {
    CHECK(error.status() == Status::io);
    return error.what();
  }
}

}  // namespace

TEST_CASE("an output is locked once, with a message that names the holder, and leaves nothing") {
  test::Folder folder;
  {
    const OutputLock file = OutputLock::of_file(folder / "face.fbk"), made = OutputLock::of_folder(folder / "a/b");
    for (const fs::path& path : {folder / "face.fbk", folder / "a/b"}) {
      const std::string message = refusal(path);
      CHECK_MESSAGE(message.starts_with(path.string() + ": is being written by process "), message);
      CHECK_MESSAGE(message.find(format("process %d on ", getpid())) != std::string::npos, message);
      CHECK_MESSAGE(message.find(" since 20") != std::string::npos, message);
      CHECK_MESSAGE(message.find("test_base") != std::string::npos, message);  // the command
    }
    CHECK(refusal(folder / "other.fbk") == "");
  }
  CHECK(refusal(folder / "face.fbk") == "");
  CHECK(folder.entries() == 1);
  CHECK(fs::is_empty(folder / "a/b"));
}

TEST_CASE("the lock of another process holds until it is killed") {
  test::Folder folder;
  Child child([&] { return OutputLock::of_file(folder / "face.fbk"); });
  CHECK(refusal(folder / "face.fbk").find(format("process %d on ", child.process())) != std::string::npos);
  child.end();
  CHECK(folder.entries() == 1);  // of the killed process
  CHECK(refusal(folder / "face.fbk") == "");
  CHECK(folder.entries() == 0);
}

TEST_CASE("a folder that is being written is refused to readers, until its writer ends") {
  test::Folder folder;
  OutputLock::refuse_if_written(folder.path());
  Child child([&] { return OutputLock::of_folder(folder.path()); });
  const std::string message =
      format("%s: is being written by process %d on ", folder.path().c_str(), static_cast<int>(child.process()));
  for (int i = 0; i < 2; ++i)
    CHECK_THROWS_WITH_AS(OutputLock::refuse_if_written(folder.path()), doctest::Contains(message.c_str()), Error);
  child.end();
  OutputLock::refuse_if_written(folder.path());
  CHECK(folder.entries() == 1);  // left for the next writer
}

TEST_CASE("partial files of killed processes are removed, those of running ones are not") {
  test::Folder folder;
  const auto begin = [&](const char* name) {
    auto file = std::make_unique<AtomicFile>(folder / name);
    file->write(std::as_bytes(std::span("some")));
    return file;
  };
  Child killed([&] { return begin("a"); });
  Child running([&] { return begin("b"); });
  killed.end();
  write_file(folder / "kept", std::string("text"));
  CHECK(folder.entries() == 3);
  CHECK(refusal(folder.path()) == "");
  CHECK(folder.entries() == 2);
  CHECK_THROWS_WITH_AS(write_file(folder / "b", std::string()), doctest::Contains("b: is being written by"), Error);
  running.end();
  write_file(folder / "b", std::string("overwrites what was left"));
  CHECK(read_file(folder / "b").size() == 24);
  CHECK(folder.entries() == 2);
}

TEST_CASE("a lock that was removed with its folder removes no other") {
  test::Folder folder;
  {
    const OutputLock lock = OutputLock::of_folder(folder / "work");
    remove_folder(folder / "work");
    const OutputLock next = OutputLock::of_folder(folder / "work");
    CHECK(refusal(folder / "work") != "");
  }
  CHECK(fs::is_empty(folder / "work"));
}

TEST_CASE("a lock does not follow links and names the file that it cannot open") {
  test::Folder folder;
  write_file(folder / "precious", std::string("text"));
  fs::create_symlink(folder / "precious", folder / "face.fbk.facebaker-lock");
  fs::create_symlink(folder / "precious", folder / "face.fbk.facebaker-partial");
  CHECK(refusal(folder / "face.fbk").starts_with((folder / "face.fbk.facebaker-lock").string() + ": "));
  CHECK_THROWS_WITH_AS(write_file(folder / "face.fbk", std::string()), doctest::Contains("facebaker-partial: cannot"),
                       Error);
  CHECK(read_file(folder / "precious").size() == 4);
}

}  // namespace fb::test_output_lock
