#include "archive/character_writer.h"

#include <algorithm>
#include <unordered_map>

#include "archive/character_reader.h"

namespace fb::archive {
namespace {

template <std::size_t count>
void write_floats(ByteWriter& out, const std::array<float, count>& values) {
  for (const float value : values) out.number(value);
}

}  // namespace

bool has_labels(const RigSchema& schema) {
  return std::any_of(schema.controls.begin(), schema.controls.end(),
                     [](const Control& control) { return control.labels != ControlLabels{}; });
}

ByteWriter write_labels(const RigSchema& schema) {
  std::unordered_map<std::string_view, std::uint32_t> index;
  for (const Control& control : schema.controls) index.emplace(control.name, static_cast<std::uint32_t>(index.size()));
  ByteWriter out;
  for (const Control& control : schema.controls) {
    out.string(control.labels.arkit, "an ARKit name");
    out.string(control.labels.facs, "a FACS name");
    out.string(control.labels.unit, "a control's unit");
    out.number(control.labels.mirror.empty() ? no_control : index.at(control.labels.mirror));
  }
  return out;
}

ByteWriter write_meshes(const std::vector<MeshPart>& meshes) {
  ByteWriter out;
  out.count(meshes.size(), "meshes");
  for (const MeshPart& mesh : meshes) {
    out.string(mesh.name, "a mesh's name");
    out.number(mesh.vertices);
    out.number(mesh.polygons);
    out.count(mesh.materials.size(), "material runs");
    for (const MaterialRun& run : mesh.materials) {
      out.number(run.polygons);
      out.number(run.material);
    }
  }
  return out;
}

ByteWriter write_materials(const std::vector<Material>& materials) {
  ByteWriter out;
  out.count(materials.size(), "materials");
  for (const Material& material : materials) {
    out.string(material.name, "a material's name");
    write_floats(out, material.base_colour);
    out.number(material.metallic);
    out.number(material.roughness);
    write_floats(out, material.emissive);
    out.number(static_cast<std::uint8_t>(material.alpha_mode));
    out.number(material.alpha_cutoff);
    out.number(static_cast<std::uint8_t>(material.double_sided ? material_double_sided_flag : 0));
    out.count(material.textures.size(), "textures");
    for (const Texture& texture : material.textures) {
      out.number(static_cast<std::uint8_t>(texture.slot));
      out.number(static_cast<std::uint8_t>(texture.wrap_u));
      out.number(static_cast<std::uint8_t>(texture.wrap_v));
      out.number(texture.image);
      out.number(texture.scale);
    }
  }
  return out;
}

ByteWriter write_images(const std::vector<Image>& images) {
  ByteWriter out;
  out.count(images.size(), "images");
  for (const Image& image : images) {
    out.string(image.name, "an image's name");
    out.string(image.media_type, "an image's media type");
    out.count(image.bytes.size(), "bytes of an image");
    out.raw(image.bytes);
  }
  return out;
}

ByteWriter write_sockets(const std::vector<Socket>& sockets) {
  ByteWriter out;
  out.count(sockets.size(), "sockets");
  for (const Socket& socket : sockets) {
    out.string(socket.name, "a socket's name");
    out.count(socket.vertices.size(), "vertices of a socket");
    out.numbers(socket.vertices);
    out.numbers(socket.weights);
    write_floats(out, socket.frame);
  }
  return out;
}

ByteWriter write_joints(const std::vector<Joint>& joints) {
  ByteWriter out;
  out.count(joints.size(), "joints");
  for (const Joint& joint : joints) {
    out.string(joint.name, "a joint's name");
    out.number(joint.parent);
    write_floats(out, joint.rest);
    write_floats(out, joint.inverse_bind);
  }
  return out;
}

std::vector<float> write_influences(ByteWriter& out, const Skin& skin) {
  out.number(skin.influences);
  std::vector<std::uint16_t> joints;
  std::vector<float> weights;
  for (std::size_t v = 0; v < skin.weights.size() / skin.influences; ++v) {
    const std::size_t first = v * skin.influences, count = skin.count(v);
    out.number(static_cast<std::uint8_t>(count));
    joints.insert(joints.end(), &skin.joints[first], &skin.joints[first] + count);
    weights.insert(weights.end(), &skin.weights[first], &skin.weights[first] + count);
  }
  out.numbers(joints);
  return weights;
}

ByteWriter write_skin(const Skin& skin) {
  ByteWriter out;
  out.float_planes(write_influences(out, skin));
  return out;
}

ByteWriter write_channels(const std::vector<Channel>& channels) {
  ByteWriter out;
  out.count(channels.size(), "channels");
  for (const Channel& channel : channels) {
    out.string(channel.name, "a channel's name");
    out.string(channel.unit, "a channel's unit");
    for (const float value : {channel.minimum, channel.maximum, channel.rest, channel.scale}) out.number(value);
  }
  return out;
}

ByteWriter write_expected_errors(const ExpectedErrors& expected) {
  ByteWriter out;
  out.number(expected.unit);
  out.count(expected.regions.size(), "regions");
  for (const ExpectedErrors::Region& region : expected.regions) {
    out.string(region.name, "a region's name");
    out.number(region.constant);
  }
  out.count(expected.runs.size(), "runs of vertices");
  for (const ExpectedErrors::Run& run : expected.runs) {
    out.number(run.vertices);
    out.number(run.region);
  }
  for (const auto* bytes :
       {&expected.weights, &expected.trained_low, &expected.trained_high, &expected.untrained_pairs})
    out.numbers(*bytes);
  return out;
}

}  // namespace fb::archive
