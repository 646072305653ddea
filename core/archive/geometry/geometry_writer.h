// Writes the sections of geometry_reader.h: each function returns the uncompressed contents. Models have passed
// check().
#pragma once

#include <cstdint>
#include <vector>

#include "archive/container/byte_writer.h"
#include "model/mesh.h"

namespace fb::archive {

struct WrittenGeometry {
  ByteWriter section;
  std::vector<std::uint32_t> triangles;  // as a reader decodes them, see RestPoints
};
// Fails with `internal` if Draco does not restore the points bit for bit.
WrittenGeometry write_geometry(const Mesh& mesh);
// `triangles`: those of WrittenGeometry.
ByteWriter write_polygons(const Mesh& mesh, const std::vector<std::uint32_t>& triangles);
ByteWriter write_uvs(const Mesh& mesh);

}  // namespace fb::archive
