#include "model/character.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <unordered_set>

#include "base/status.h"
#include "base/utf8.h"

namespace fb {
namespace {

void check_material(const Material& material, std::size_t index, std::size_t images) {
  const std::string name = format("material %zu (\"%s\")", index, material.name.c_str());
  bool finite =
      std::isfinite(material.metallic) && std::isfinite(material.roughness) && std::isfinite(material.alpha_cutoff);
  for (const float factor : material.base_colour) finite = finite && std::isfinite(factor);
  for (const float factor : material.emissive) finite = finite && std::isfinite(factor);
  unsigned slots = 0;
  for (const Texture& texture : material.textures) {
    finite = finite && std::isfinite(texture.scale);
    const unsigned slot = 1u << static_cast<unsigned>(texture.slot);
    if (slots & slot) fail(Status::bad_data, "%s has two textures in one slot", name.c_str());
    slots |= slot;
    if (texture.image >= images)
      fail(Status::bad_data, "%s has a texture of image %u of %zu", name.c_str(), texture.image, images);
  }
  if (!finite) fail(Status::not_finite, "%s has a factor that is not finite", name.c_str());
}

// The index of the part that a vertex belongs to.
std::size_t part_of(const Mesh& rest, std::uint32_t vertex) {
  std::size_t part = 0;
  for (std::uint32_t end = 0; part < rest.parts.size(); ++part)
    if (vertex < (end += rest.parts[part].vertices)) break;
  return part;
}

void check_socket(const Socket& socket, const Mesh& rest) {
  const char* name = socket.name.c_str();
  if (socket.vertices.size() < 3)
    fail(Status::bad_data, "socket \"%s\" has %zu vertices; a frame takes three", name, socket.vertices.size());
  if (socket.weights.size() != socket.vertices.size())
    fail(Status::bad_data, "socket \"%s\" has %zu weights for %zu vertices", name, socket.weights.size(),
         socket.vertices.size());
  for (const std::uint32_t vertex : socket.vertices) {
    if (vertex >= rest.surface_vertex_count())
      fail(Status::bad_data, "socket \"%s\" names vertex %u of %zu", name, vertex, rest.surface_vertex_count());
    if (part_of(rest, vertex) != part_of(rest, socket.vertices[0]))
      fail(Status::bad_data, "socket \"%s\" has vertices of two meshes", name);
  }
  for (const float weight : socket.weights)
    if (!(weight > 0) || !std::isfinite(weight))
      fail(Status::bad_data, "socket \"%s\" has a weight of %g; weights are above 0", name, double(weight));
  if (!std::all_of(socket.frame.begin(), socket.frame.end(), [](float value) { return std::isfinite(value); }))
    fail(Status::not_finite, "socket \"%s\": its frame is not finite", name);
}

void check_about(const std::string& about) {
  if (about.size() > most_about_bytes)
    fail(Status::limit, "what is said about the character has %zu bytes; it may have %zu", about.size(),
         most_about_bytes);
  if (const auto fault = find_utf8_fault(about))
    fail(Status::bad_data, "what is said about the character is no UTF-8 text at byte %zu", *fault);
}

}  // namespace

void set_default_frame(Socket& socket, std::span<const float> points) {
  std::array<float, 12>& frame = socket.frame;
  if (std::any_of(frame.begin(), frame.end(), [](float value) { return value != 0; })) return;
  double centre[3] = {}, sum = 0;
  for (std::size_t i = 0; i < std::min(socket.vertices.size(), socket.weights.size()); ++i) {
    const std::size_t at = 3 * std::size_t(socket.vertices[i]);
    if (at >= points.size()) continue;
    for (std::size_t a = 0; a < 3; ++a) centre[a] += double(socket.weights[i]) * points[at + a];
    sum += socket.weights[i];
  }
  for (std::size_t a = 0; a < 3; ++a) {
    frame[5 * a] = 1;
    frame[4 * a + 3] = static_cast<float>(centre[a] / sum);
  }
}

void check_thumbnail(std::span<const std::byte> png) {
  static constexpr unsigned char beginning[16] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n',
                                                  0,    0,   0,   13,  'I',  'H',  'D',  'R'};
  if (png.size() < 24 || std::memcmp(png.data(), beginning, sizeof beginning) != 0)
    fail(Status::bad_data, "the thumbnail is no PNG");
  const auto pixels = [&](std::size_t at) {
    std::uint32_t number = 0;
    for (std::size_t i = 0; i < 4; ++i) number = number << 8 | std::to_integer<std::uint32_t>(png[at + i]);
    return number;
  };
  const std::uint32_t width = pixels(16), height = pixels(20);
  if (width != height || width == 0 || width > most_thumbnail_pixels)
    fail(Status::bad_data, "the thumbnail has %u x %u pixels; it is square, with at most %u along an edge", width,
         height, most_thumbnail_pixels);
  if (png.size() > most_thumbnail_bytes)
    fail(Status::limit, "the thumbnail has %zu bytes; it may have %zu", png.size(), most_thumbnail_bytes);
}

void check(const Character& character, const Mesh& rest) {
  check_about(character.about);
  if (!character.thumbnail.empty()) check_thumbnail(character.thumbnail);
  check(character.joints, character.skin, rest);
  const std::size_t materials = character.materials.size();
  for (std::size_t m = 0; m < materials; ++m) check_material(character.materials[m], m, character.images.size());
  for (const MeshPart& part : rest.parts)
    for (const MaterialRun& run : part.materials)
      if (run.material != no_material && run.material >= materials)
        fail(Status::bad_data, "mesh \"%s\" names material %u of %zu", part.name.c_str(), run.material, materials);
  std::unordered_set<std::string_view> names;
  for (const Socket& socket : character.sockets) {
    if (socket.name.empty()) fail(Status::bad_data, "a socket without a name");
    if (!names.insert(socket.name).second) fail(Status::bad_data, "two sockets named \"%s\"", socket.name.c_str());
    check_socket(socket, rest);
  }
}

}  // namespace fb
