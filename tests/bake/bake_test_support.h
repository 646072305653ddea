// What the tests of rig sources, datasets and sampling share.
#pragma once

#include <doctest/doctest.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "bake/dataset/open_source.h"
#include "bake/rig/source.h"
#include "base/status.h"
#include "temporary_folder.h"

namespace fb::test {

inline std::unique_ptr<bake::Source> open_toy() {
  return bake::open_source(FB_TOY_RIG);
}

// The toy rig with one lie (lying_rig.c lists them).
inline std::unique_ptr<bake::Source> open_liar(const char* lie) {
  setenv("FB_LIE", lie, 1);
  return bake::open_source(FB_LYING_RIG);
}

// The message `work` fails with; fails the test if it does not fail with this status.
template <class Work>
std::string failure(Status status, Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    CHECK_MESSAGE(error.status() == status, error.what());
    return error.what();
  }
  FAIL("nothing failed");
  return "";
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace fb::test
