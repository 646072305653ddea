// Golden archives: what was once accepted stays accepted and evaluates to the same bits; what was refused stays
// refused.
#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>

#include "archive/reader.h"
#include "archive/writer.h"
#include "bake/measure/verify.h"
#include "base/file.h"
#include "base/status.h"
#include "test_models.h"

using namespace fb;
using namespace fb::archive;
using namespace fb::bake;

namespace {

using Path = std::filesystem::path;

// The committed archives, and those written during the build.
const std::vector<Path> folders = {FB_GOLDEN "/2.0", FB_GOLDEN "/2.1", FB_GOLDEN_NEW};

// What 2.1 adds is little.
bool is_of_2_1(const Path& folder) {
  return folder.filename() == "2.1";
}

std::vector<Path> files_of(const Path& folder) {
  std::vector<Path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

const char* name_of(Status status) {
  switch (status) {
    case Status::not_an_archive:
      return "not_an_archive";
    case Status::corrupt:
      return "corrupt";
    case Status::unsupported:
      return "unsupported";
    default:
      return "another status";
  }
}

// The status of a refused archive; "unproven" if the archive is valid but its proof does not hold; otherwise "".
std::string verdict(const Path& file) {
  const auto bytes = read_file(file);
  try {
    read_archive(bytes);
  } catch (const Error& error) {
    CHECK(std::string(error.what()).size() > 10);
    return name_of(error.status());
  }
  try {
    verify_archive(bytes);
  } catch (const Error& error) {
    CHECK(error.status() == Status::corrupt);
    return "unproven";
  }
  return "";
}

}  // namespace

TEST_CASE("golden archives are accepted and evaluate as archived") {
  for (const Path& folder : folders) {
    const auto files = files_of(folder / "accepted");
    CHECK(files.size() >= (is_of_2_1(folder) ? 4 : 30));
    for (const Path& file : files) CHECK_MESSAGE(verdict(file) == "", file);
  }
}

TEST_CASE("rejected golden archives are refused with the same status") {
  for (const Path& folder : folders) {
    const auto files = files_of(folder / "rejected");
    CHECK(files.size() >= (is_of_2_1(folder) ? 18 : 350));
    for (const Path& file : files) {
      const std::string name = file.stem().string();
      CHECK_MESSAGE(verdict(file) == name.substr(0, name.find('-')), file);
    }
  }
}

TEST_CASE("an accepted archive survives being written and read again") {
  for (const Path& folder : folders)
    for (const Path& file : files_of(folder / "accepted")) {
      const Archive first = read_archive(read_file(file));
      const auto again = write_archive(first.model, first.proof, first.text);
      CHECK_MESSAGE(again == write_archive(read_archive(again).model, first.proof, first.text), file);
      verify_archive(again);
    }
}

TEST_CASE("a proof with a position that is not a number is refused, as its bits depend on the machine") {
  PackedModel model = levelled_model();
  model.exact = exact_model().exact;
  REQUIRE(make_proof(model, 1).hashes.size() > 11);
  // Positions become infinite, and NaN at a level of detail, where a corner counts for nothing.
  for (ExactPose& pose : model.exact) pose.step = 3e38f;
  CHECK_THROWS_WITH_AS(make_proof(model, 1), doctest::Contains("a position that is not a number"), Error);
}
