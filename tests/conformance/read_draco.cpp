// Reads Draco data for test_draco.py. Standard input: for each, little-endian, u32 points, triangles, 1 for integers or
// 0, bytes, and so many bytes. Standard output: a byte 0 for data that is refused; else 1, three u32 a point, three a
// triangle.
#include "archive/geometry/draco_reader.h"

#include <cstdio>
#include <vector>

#include "base/status.h"

int main() {
  using namespace fb;
  std::uint32_t numbers[4];
  while (std::fread(numbers, sizeof numbers, 1, stdin) == 1) {
    std::vector<std::byte> data(numbers[3]);
    if (std::fread(data.data(), 1, data.size(), stdin) != data.size()) return 1;
    try {
      MemoryBudget budget;
      archive::ByteReader in(data, "geometry", budget);
      const archive::DracoMesh mesh = archive::read_draco(in, numbers[0], numbers[1], numbers[2] != 0);
      std::fputc(1, stdout);
      std::fwrite(mesh.positions.data(), 4, mesh.positions.size(), stdout);
      std::fwrite(mesh.triangles.data(), 4, mesh.triangles.size(), stdout);
    } catch (const Error&) {
      std::fputc(0, stdout);
    }
  }
  return std::fflush(stdout) == 0 ? 0 : 1;
}
