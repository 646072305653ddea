#include "archive/character_reader.h"

namespace fb::archive {
namespace {

// A number that stands for one of a few things: 0 to `last`.
template <class Kind>
Kind read_kind(ByteReader& in, Kind last, const char* what) {
  const auto kind = in.number<std::uint8_t>(what);
  if (kind > static_cast<std::uint8_t>(last))
    fail(Status::unsupported, "%s has unknown number %u for %s", in.where().c_str(), kind, what);
  return static_cast<Kind>(kind);
}

template <std::size_t count>
void read_floats(ByteReader& in, std::array<float, count>& values, const char* what) {
  for (float& value : values) value = in.number<float>(what);
}

Texture read_texture(ByteReader& in) {
  Texture texture;
  texture.slot = read_kind(in, TextureSlot::emissive, "a texture's slot");
  texture.wrap_u = read_kind(in, Wrap::mirror, "a texture's wrap");
  texture.wrap_v = read_kind(in, Wrap::mirror, "a texture's wrap");
  texture.image = in.number<std::uint32_t>("a texture's image");
  texture.scale = in.number<float>("a texture's scale");
  return texture;
}

}  // namespace

void read_labels(ByteReader& in, RigSchema& schema) {
  const std::size_t controls = schema.controls.size();
  for (std::size_t c = 0; c < controls; ++c) {
    ControlLabels& labels = schema.controls[c].labels;
    labels.arkit = in.string("an ARKit name");
    labels.facs = in.string("a FACS name");
    labels.unit = in.string("a control's unit");
    const auto mirror = in.number<std::uint32_t>("a mirror partner");
    if (mirror == no_control) continue;
    if (mirror >= controls) in.corrupt("a mirror partner that does not exist");
    in.budget().take_text(schema.controls[mirror].name.size(), "names");
    labels.mirror = schema.controls[mirror].name;
  }
  in.end();
}

std::vector<MeshPart> read_meshes(ByteReader& in) {
  std::vector<MeshPart> meshes;
  in.budget().resize(meshes, in.count(16, "meshes"), "meshes");
  for (MeshPart& mesh : meshes) {
    mesh.name = in.string("a mesh's name");
    mesh.vertices = in.number<std::uint32_t>("a mesh's vertices");
    mesh.polygons = in.number<std::uint32_t>("a mesh's polygons");
    in.budget().resize(mesh.materials, in.count(8, "material runs"), "material runs");
    for (MaterialRun& run : mesh.materials) {
      run.polygons = in.number<std::uint32_t>("a material run's polygons");
      run.material = in.number<std::uint32_t>("a material run's material");
    }
  }
  if (meshes.empty()) in.corrupt("there are no meshes");
  in.end();
  return meshes;
}

std::vector<Material> read_materials(ByteReader& in) {
  std::vector<Material> materials;
  in.budget().resize(materials, in.count(50, "materials"), "materials");
  for (Material& material : materials) {
    material.name = in.string("a material's name");
    read_floats(in, material.base_colour, "a base colour");
    material.metallic = in.number<float>("a material's factors");
    material.roughness = in.number<float>("a material's factors");
    read_floats(in, material.emissive, "an emissive colour");
    material.alpha_mode = read_kind(in, AlphaMode::blend, "an alpha mode");
    material.alpha_cutoff = in.number<float>("an alpha cutoff");
    const auto flags = in.number<std::uint8_t>("a material's flags");
    if (flags & ~material_double_sided_flag)
      fail(Status::unsupported, "%s has a material of unknown flags 0x%x", in.where().c_str(), flags);
    material.double_sided = flags & material_double_sided_flag;
    const std::uint32_t textures = in.count(11, "textures");
    in.budget().reserve(material.textures, textures, "textures");
    for (std::uint32_t t = 0; t < textures; ++t) material.textures.push_back(read_texture(in));
  }
  if (materials.empty()) in.corrupt("there are no materials");
  in.end();
  return materials;
}

std::vector<Image> read_images(ByteReader& in) {
  std::vector<Image> images;
  in.budget().resize(images, in.count(12, "images"), "images");
  for (Image& image : images) {
    image.name = in.string("an image's name");
    image.media_type = in.string("an image's media type");
    const auto bytes = in.take(in.number<std::uint32_t>("an image's size"), "an image");
    in.budget().resize(image.bytes, bytes.size(), "an image");
    std::copy(bytes.begin(), bytes.end(), image.bytes.begin());
  }
  if (images.empty()) in.corrupt("there are no images");
  in.end();
  return images;
}

std::vector<Socket> read_sockets(ByteReader& in) {
  std::vector<Socket> sockets;
  in.budget().resize(sockets, in.count(56, "sockets"), "sockets");
  for (Socket& socket : sockets) {
    socket.name = in.string("a socket's name");
    const std::uint32_t vertices = in.count(8, "vertices of a socket");
    socket.vertices = in.numbers<std::uint32_t>(vertices, "vertices of a socket");
    socket.weights = in.numbers<float>(vertices, "weights of a socket");
    read_floats(in, socket.frame, "a socket's frame");
  }
  if (sockets.empty()) in.corrupt("there are no sockets");
  in.end();
  return sockets;
}

std::vector<std::byte> read_thumbnail(ByteReader& in) {
  const auto bytes = in.take(in.left(), "the thumbnail");
  if (bytes.empty()) in.corrupt("there is no thumbnail");
  std::vector<std::byte> png;
  in.budget().resize(png, bytes.size(), "the thumbnail");
  std::copy(bytes.begin(), bytes.end(), png.begin());
  return png;
}

std::vector<Joint> read_joints(ByteReader& in) {
  std::vector<Joint> joints;
  in.budget().resize(joints, in.count(104, "joints"), "joints");
  for (Joint& joint : joints) {
    joint.name = in.string("a joint's name");
    joint.parent = in.number<std::uint32_t>("a joint's parent");
    read_floats(in, joint.rest, "a joint's frame at rest");
    read_floats(in, joint.inverse_bind, "an inverse bind matrix");
  }
  if (joints.empty()) in.corrupt("there are no joints");
  in.end();
  return joints;
}

Skin read_influences(ByteReader& in, std::uint32_t vertices, ReadWeights read_weights) {
  Skin skin;
  skin.influences = in.number<std::uint32_t>("the influences of a vertex");
  if (skin.influences == 0 || skin.influences > most_influences) in.corrupt("influences are not 1 to 32");
  const auto counts = in.take(vertices, "influences of vertices");
  std::uint64_t sum = 0;
  for (const std::byte count : counts) {
    if (std::to_integer<std::uint32_t>(count) > skin.influences) in.corrupt("a vertex has more influences than all");
    sum += std::to_integer<std::uint32_t>(count);
  }
  const auto joints = in.temporary_numbers<std::uint16_t>(sum, "joints of vertices");
  const auto weights = read_weights(in, sum);
  const std::uint64_t places = checked_multiply(vertices, skin.influences, "influences");
  in.budget().resize(skin.joints, places, "joints of vertices");
  in.budget().resize(skin.weights, places, "weights of vertices");
  std::size_t from = 0;
  for (std::size_t v = 0; v < vertices; ++v)
    for (std::size_t k = 0; k < std::to_integer<std::size_t>(counts[v]); ++k, ++from) {
      if (!(weights[from] > 0)) in.corrupt("a weight of a joint is not above 0");
      skin.joints[v * skin.influences + k] = joints[from];
      skin.weights[v * skin.influences + k] = weights[from];
    }
  in.end();
  return skin;
}

Skin read_skin(ByteReader& in, std::uint32_t vertices) {
  return read_influences(in, vertices, [](ByteReader& from, std::uint64_t count) {
    return from.temporary_float_planes(count, "weights of vertices");
  });
}

std::vector<Channel> read_channels(ByteReader& in) {
  std::vector<Channel> channels;
  in.budget().resize(channels, in.count(24, "channels"), "channels");
  for (Channel& channel : channels) {
    channel.name = in.string("a channel's name");
    channel.unit = in.string("a channel's unit");
    for (float* value : {&channel.minimum, &channel.maximum, &channel.rest, &channel.scale})
      *value = in.number<float>("a channel's range");
  }
  if (channels.empty()) in.corrupt("there are no channels");
  in.end();
  return channels;
}

ExpectedErrors read_expected_errors(ByteReader& in, std::size_t controls) {
  ExpectedErrors expected;
  expected.unit = in.number<float>("the unit of errors");
  in.budget().resize(expected.regions, in.count(8, "regions"), "regions");
  for (ExpectedErrors::Region& region : expected.regions) {
    region.name = in.string("a region's name");
    region.constant = in.number<float>("a region's constant");
  }
  if (expected.regions.empty()) in.corrupt("there are no regions");
  in.budget().resize(expected.runs, in.count(8, "runs of vertices"), "runs of vertices");
  for (ExpectedErrors::Run& run : expected.runs) {
    run.vertices = in.number<std::uint32_t>("a run's vertices");
    run.region = in.number<std::uint32_t>("a run's region");
  }
  const auto bytes = [&](std::uint64_t count, const char* what) { return in.numbers<std::uint8_t>(count, what); };
  expected.weights =
      bytes(checked_multiply(controls, expected.regions.size(), "weights of errors"), "weights of errors");
  expected.trained_low = bytes(controls, "trained values");
  expected.trained_high = bytes(controls, "trained values");
  expected.untrained_pairs = bytes(pair_bytes(controls), "pairs of controls");
  in.end();
  return expected;
}

}  // namespace fb::archive
