#include <doctest/doctest.h>

#include "base/file_extension.h"

namespace fb {

TEST_CASE("extensions of files are in lower case") {
  CHECK(file_extension("a/Face.GLB") == ".glb");
  CHECK(file_extension("face.0001.Png") == ".png");
  CHECK(file_extension("FACE") == "");
  CHECK(file_extension("a.b/face") == "");
}

}  // namespace fb
