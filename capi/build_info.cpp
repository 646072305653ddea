// What the library was built with, as a text.
#include <facebaker/facebaker.h>

#include <string>

#include "archive/reader.h"
#include "base/openmp_date.h"
#include "base/status.h"
#include "runtime/instruction_set.h"
#include "version.h"

namespace {

std::string compiler_text() {
#if defined(__clang__)
  return "clang " __clang_version__;
#elif defined(__GNUC__)
  return "gcc " __VERSION__;
#elif defined(_MSC_VER)
  return fb::format("MSVC %d", _MSC_VER);
#else
  return "unknown";
#endif
}

std::string instruction_sets_text() {
  std::string names;
  for (const auto* kernels : fb::runtime::built_kernels())
    names += (names.empty() ? "" : ", ") + std::string(kernels->name);
  return names + "; here: " + fb::runtime::runnable_kernels().back()->name;
}

std::string build_info_text() {
  const long openmp = fb::openmp_date();
  const unsigned format = fb::archive::archive_format_version();
  std::string text = fb::format("FaceBaker: %s\n", FB_VERSION_STRING);
  text += fb::format("format: %u.%u\n", format / 1000, format % 1000);
  text += fb::format("compiler: %s\n", compiler_text().c_str());
  text += "OpenMP: " + (openmp ? std::to_string(openmp) : std::string("none")) + "\n";
  text += fb::format("instruction sets: %s\n", instruction_sets_text().c_str());
  return text + "linked: " FB_LINKED "\n";
}

}  // namespace

const char* fb_build_info(void) {
  try {
    static const std::string text = build_info_text();
    return text.c_str();
  } catch (...) {
    return "FaceBaker: " FB_VERSION_STRING "\n";
  }
}
