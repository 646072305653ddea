// Stock Draco as a program for fbk_read.py: decodes standard input, writes points and, if there are faces, the points'
// indices and the faces, in the form that fbk_read.py documents.
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
  if (!done.ok() || buffer.remaining_size() != 0 || !positions || (mesh.num_faces() > 0 && !indices)) return 1;
  const bool integers = positions->data_type() == draco::DT_INT32;
  if (!integers && positions->data_type() != draco::DT_FLOAT32) return 1;
  const auto write = [](std::uint32_t number) { std::fwrite(&number, sizeof number, 1, stdout); };
  const std::uint32_t count = mesh.num_points(), faces = mesh.num_faces();
  write(count);
  write(faces);
  write(integers);
  for (draco::PointIndex point(0); point < count; ++point) {
    std::uint32_t xyz[3];  // the bits of either kind
    positions->GetMappedValue(point, xyz);
    std::fwrite(xyz, sizeof xyz, 1, stdout);
  }
  for (draco::PointIndex point(0); faces > 0 && point < count; ++point) {
    std::uint32_t index = 0;
    indices->GetMappedValue(point, &index);
    write(index);
  }
  for (draco::FaceIndex face(0); face < faces; ++face)
    for (const draco::PointIndex& point : mesh.face(face)) write(point.value());
  return std::fflush(stdout) == 0 ? 0 : 1;
}
