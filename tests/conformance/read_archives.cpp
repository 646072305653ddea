// Reads archives for test_mutations.py. Standard input: for each, u32 bytes, little-endian, and so many bytes. Standard
// output: a line for each, "accepted", or what is wrong.
#include <cstdio>
#include <vector>

#include "archive/reader.h"
#include "base/status.h"
#include "runtime/evaluator.h"

int main() {
  using namespace fb;
  std::uint32_t size = 0;
  while (std::fread(&size, sizeof size, 1, stdin) == 1) {
    std::vector<std::byte> bytes(size);
    if (std::fread(bytes.data(), 1, size, stdin) != size) return 1;
    try {
      const archive::Archive read = archive::read_archive(bytes, {std::uint64_t(1) << 28});
      const runtime::Evaluator face(read.model);
      std::puts("accepted");
    } catch (const Error& error) {
      std::puts(error.what());
    }
  }
  return std::fflush(stdout) == 0 ? 0 : 1;
}
