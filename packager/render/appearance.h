// What the surface of a drawn mesh looks like.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/vector3.h"
#include "render/texture.h"

namespace fb::tool {

// Of a material, what a picture in plain light shows of it.
struct SurfaceColour {
  Vector3 colour;         // albedo, linear; multiplies the texture's
  Vector3 emissive = {};  // linear
  float alpha = 1;        // multiplies the texture's
  float least_alpha = 0;  // what has less is not drawn: a surface covers what is behind it, or is not there
  std::optional<std::size_t> texture{};  // of Appearance::textures
  TextureWrap wrap_u = TextureWrap::repeat, wrap_v = TextureWrap::repeat;
};

struct Appearance {
  std::vector<Texture> textures;
  std::vector<SurfaceColour> colours;
  std::vector<std::uint32_t> of_triangle;  // index of a colour
  std::vector<float> uvs;                  // u and v of the three corners of each triangle; empty: no textures

  // What a point of a triangle shows, by its barycentric coordinates of the corners b and c.
  struct Seen {
    Vector3 colour, emissive;
    bool covers = true;  // whether there is a surface at all
  };
  Seen at(std::size_t triangle, float b, float c) const;
};

}  // namespace fb::tool
