#include <doctest/doctest.h>

#include "base/file_extension.h"
#include "base/match_names.h"

namespace fb::test_names {

TEST_CASE("extensions of files are in lower case") {
  CHECK(file_extension("a/Face.GLB") == ".glb");
  CHECK(file_extension("face.0001.Png") == ".png");
  CHECK(file_extension("FACE") == "");
  CHECK(file_extension("a.b/face") == "");
}

TEST_CASE("a name that is none is followed by those there are") {
  const std::vector<std::string> names = {"jaw", "brow", "lid"};
  CHECK(names_there_are("jww", names) == "; the closest is \"jaw\"; there are \"jaw\", \"brow\", \"lid\"");
  CHECK(names_there_are("tongue", names) == "; there are \"jaw\", \"brow\", \"lid\"");
  CHECK(names_there_are("jaw", {}) == "; there are none");
  CHECK(list_of_names(names, 2) == "\"jaw\", \"brow\" and 1 more");
}

}  // namespace fb::test_names
