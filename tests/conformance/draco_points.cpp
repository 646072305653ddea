// Stock Draco as a program: decodes standard input, writes the number of points, their positions and, if there is an
// attribute of indices, that. For fbk_read.py, which has no other way to it.
#include <draco/compression/decode.h>

#include <cstdint>
#include <cstdio>
#include <iterator>
#include <vector>

int main() {
  std::vector<char> data;
  char block[65536];
  while (const std::size_t got = std::fread(block, 1, sizeof block, stdin)) data.insert(data.end(), block, block + got);
  draco::DecoderBuffer buffer;
  buffer.Init(data.data(), data.size());
  draco::Decoder decoder;
  const auto type = draco::Decoder::GetEncodedGeometryType(&buffer);
  if (!type.ok()) return 1;
  draco::Mesh mesh;
  const draco::Status done = type.value() == draco::TRIANGULAR_MESH
                                 ? decoder.DecodeBufferToGeometry(&buffer, &mesh)
                                 : decoder.DecodeBufferToGeometry(&buffer, static_cast<draco::PointCloud*>(&mesh));
  const draco::PointAttribute* positions = mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  const draco::PointAttribute* indices = mesh.GetNamedAttribute(draco::GeometryAttribute::GENERIC);
  if (!done.ok() || buffer.remaining_size() != 0 || !positions || positions->data_type() != draco::DT_FLOAT32) return 1;
  const std::uint32_t count = mesh.num_points();
  std::fwrite(&count, sizeof count, 1, stdout);
  for (draco::PointIndex point(0); point < count; ++point) {
    float xyz[3];
    positions->GetMappedValue(point, xyz);
    std::fwrite(xyz, sizeof xyz, 1, stdout);
  }
  for (draco::PointIndex point(0); indices && point < count; ++point) {
    std::uint32_t index = 0;
    indices->GetMappedValue(point, &index);
    std::fwrite(&index, sizeof index, 1, stdout);
  }
  return std::fflush(stdout) == 0 ? 0 : 1;
}
