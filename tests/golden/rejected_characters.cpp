#include "golden_edits.h"

namespace fb {
namespace {

void write_rejected_definitions(const RejectedWriter& out) {
  const PackedModel model = tiny_packed_model();
  // The vertices are at byte 19; the first control's name and group take 4 + 8 and 4 + 5 bytes, from byte 27 on.
  constexpr std::size_t minimum = 48, maximum = minimum + 4, rest = maximum + 4;
  out.patched("corrupt-vertices-many.fbk", "definition", 19, std::uint32_t(268435457));
  out.renamed("corrupt-control-nameless.fbk", "definition", "jaw_open", "", model);
  out.renamed("corrupt-control-names.fbk", "definition", "mouth_side", "jaw_open", model);
  out.patched("corrupt-control-range.fbk", "definition", minimum, 1.0f);
  out.patched("corrupt-control-rest.fbk", "definition", rest, 1.5f);
  out.patched("corrupt-control-infinite.fbk", "definition", maximum, infinity);
  out.write("corrupt-string-long.fbk", edited([](ArchiveEditor& archive) {
              rename(archive["definition"].stored, "tiny", std::string(65536, 'n'));
              archive["definition"].set(archive["definition"].stored);
              deflate_section(archive["definition"], 9);
            }));
  // The names of the smallest model take 4, 4 + 2 and 4 + 1 bytes.
  Bytes contents;
  edited([&](ArchiveEditor& archive) { contents = archive["definition"].stored; }, smallest());
  contents.resize(19);
  append(contents, std::uint32_t(0));
  out.replaced("corrupt-no-controls.fbk", "definition", contents, smallest());
}

void write_rejected_labels(const RejectedWriter& out) {
  PackedModel model = character_model();
  model.schema.controls[3].labels.facs = "AU45";
  out.renamed("corrupt-label-arkit.fbk", "labels", "eyeBlinkLeft", "jawOpen", model);
  out.renamed("corrupt-label-facs.fbk", "labels", "AU45", "AU26", model);
  out.patched("corrupt-mirror-self.fbk", "labels", 30, std::uint32_t(0), model);
}

void write_rejected_meshes(const RejectedWriter& out) {
  const PackedModel model = character_model();
  const auto write = [&](const char* file, const std::function<void(Bytes&)>& change) {
    out.write(file, changed("meshes", change, model));
  };
  // Of the second mesh: its name at byte 40, vertices, polygons, one run.
  constexpr std::size_t vertices = 49, polygons = vertices + 4, runs = polygons + 4, run = runs + 4;
  out.renamed("corrupt-mesh-nameless.fbk", "meshes", "head", "", model);
  out.renamed("corrupt-mesh-names.fbk", "meshes", "teeth", "head", model);
  out.patched("corrupt-mesh-left.fbk", "meshes", vertices, std::uint32_t(13), model);
  write("corrupt-mesh-empty.fbk", [](Bytes& b) {
    patch(b, 0, std::uint32_t(3));
    insert(b, b.size(), {1, 'x', 0, 0, 0});
    erase(b, b.size() - 15, 3);
  });
  write("corrupt-mesh-run-empty.fbk", [&](Bytes& b) {
    patch(b, runs, std::uint32_t(2));
    insert(b, b.size(), {0, no_item});
  });
  for (const std::uint32_t count : {4, 6})
    write(count == 4 ? "corrupt-mesh-polygons.fbk" : "corrupt-mesh-polygons-left.fbk", [&](Bytes& b) {
      patch(b, polygons, count);
      patch(b, run, count);
    });
}

void write_rejected_surfaces(const RejectedWriter& out) {
  const PackedModel model = character_model();
  // The first material's textures take 11 bytes each: slot, wraps, image and scale.
  constexpr std::size_t texture = 58;
  out.patched("corrupt-material-cutoff.fbk", "materials", 49, infinity, model);
  out.patched("corrupt-texture-scale.fbk", "materials", texture + 7, nan_bits, model);
  out.patched("corrupt-texture-twice.fbk", "materials", texture + 11, std::uint8_t(0), model);
  out.patched("unsupported-texture-wrap-u.fbk", "materials", texture + 1, std::uint8_t(3), model);
  out.write("corrupt-material-no-images.fbk", without("images", model));
  const auto thumbnail = [&](const char* file, std::uint8_t high, std::uint8_t low) {
    const auto change = [&](Bytes& b) {
      for (const std::size_t at : {18, 22}) patch(b, at, high), patch(b, at + 1, low);
    };
    out.write(file, changed("thumbnail", change, model));
  };
  thumbnail("corrupt-thumbnail-large.fbk", 2, 1);
  thumbnail("corrupt-thumbnail-zero.fbk", 0, 0);
  for (const std::size_t size : {0, 23})
    out.write(format("corrupt-thumbnail-%zu-bytes.fbk", size).c_str(),
              changed(
                  "thumbnail", [&](Bytes& b) { b.resize(size); }, model));
}

void write_rejected_sockets(const RejectedWriter& out) {
  const PackedModel model = character_model();
  out.renamed("corrupt-socket-nameless.fbk", "sockets", "nose", "", model);
  out.renamed("corrupt-socket-names.fbk", "sockets", "tooth", "nose", model);
  out.patched("corrupt-socket-weight-infinite.fbk", "sockets", 16 + 5 * 4, infinity, model);
  const auto drop_vertex = [](Bytes& b) {  // of the second socket, which has three
    constexpr std::size_t count = 113, third = count + 4 + 8;
    patch(b, count, std::uint32_t(2));
    erase(b, third, 4);
    erase(b, third + 8, 4);
  };
  out.write("corrupt-socket-vertices.fbk", changed("sockets", drop_vertex, model));
}

void write_rejected_channels(const RejectedWriter& out) {
  const PackedModel model = character_model();
  out.renamed("corrupt-channel-nameless.fbk", "channels", "frown", "", model);
  out.renamed("corrupt-channel-names.fbk", "channels", "blush", "frown", model);
  out.patched("corrupt-channel-infinite.fbk", "channels", 17 + 4, infinity, model);
  out.patched("corrupt-channel-scale-infinite.fbk", "channels", 17 + 12, infinity, model);
  PackedModel points = smallest();  // and two vertices that carry channels
  for (const char* name : {"a", "b", "c", "d"}) points.schema.channels.push_back({name, "", 0, 1, 0, 1});
  points.rest.carrier_vertices = 2;
  points.rest.points.resize(12);
  points.order = {0, 1, 2, 3};
  points.row_blocks = {{0, 6, {}, {}}, {6, 6, {}, {}}};
  const auto swap_last = [](Bytes& b) {  // differences of 2 and -1
    b[8 + 2] = std::byte(4);
    b[8 + 3] = std::byte(1);
  };
  out.write("corrupt-channel-order.fbk", changed("basis", swap_last, points));
  const auto move_rows = [](Bytes& b) {
    b[8 + 16 + 4] = std::byte(9);
    b[8 + 16 + 5] = std::byte(3);
  };
  out.write("corrupt-channel-rows.fbk", changed("basis", move_rows, points));
}

}  // namespace

void write_rejected_characters(const RejectedWriter& out) {
  const PackedModel model = character_model();
  out.write("corrupt-labels-more.fbk", changed(
                                           "labels", [](Bytes& b) { b.resize(b.size() + 2); }, model));
  // The first control's texts take 4 + 7, 4 + 4 and 4 + 7 bytes; then its partner, and 16 bytes of the second control.
  out.patched("corrupt-mirror-missing.fbk", "labels", 30, std::uint32_t(5), model);
  out.patched("corrupt-mirror-alone.fbk", "labels", 30, std::uint32_t(1), model);
  // The unit and two regions take 4 + 4 + (4 + 5 + 4) + (4 + 17 + 4) bytes, three runs 4 + 3 x 8.
  constexpr std::size_t runs = 46, error_weights = runs + 4 + 24, trained = error_weights + 10, pairs = trained + 10;
  out.patched("corrupt-error-unit.fbk", "expected-errors", 0, 0.0f, model);
  out.patched("corrupt-error-constant.fbk", "expected-errors", 17, -1.0f, model);
  out.patched("corrupt-error-runs.fbk", "expected-errors", runs + 4, std::uint32_t(8), model);
  out.patched("corrupt-error-region.fbk", "expected-errors", runs + 8, std::uint32_t(2), model);
  out.patched("corrupt-error-trained.fbk", "expected-errors", trained, std::uint8_t(201), model);
  out.patched("corrupt-error-pairs.fbk", "expected-errors", pairs + 1, std::uint8_t(128), model);
  out.patched("unproven-error.fbk", "expected-errors", error_weights, std::uint8_t(200), model);
  for (const char* name : {"meshes", "materials", "images", "sockets", "channels"}) {
    out.write(format("corrupt-no-%s.fbk", name).c_str(), changed(
                                                             name, [](Bytes& b) { b.assign(4, {}); }, model));
    out.write(format("corrupt-%s-more.fbk", name).c_str(), changed(
                                                               name, [](Bytes& b) { b.resize(b.size() + 2); }, model));
  }
  out.patched("corrupt-mesh-vertices.fbk", "meshes", 12, std::uint32_t(17), model);
  out.patched("corrupt-mesh-run.fbk", "meshes", 24, std::uint32_t(7), model);
  out.patched("corrupt-mesh-material.fbk", "meshes", 28, std::uint32_t(2), model);
  PackedModel points = model;
  points.rest.polygon_sizes.clear(), points.rest.polygon_corners.clear();
  points.rest.uvs.clear(), points.rest.uv_corners.clear();
  points.rest.parts = {{"head", 18, 0}, {"teeth", 12, 0}};
  points.character.sockets.clear();
  const auto move_vertex = [](Bytes& b) {  // to the other mesh, so that a row block has vertices of both
    patch(b, 12, std::uint32_t(17));
    patch(b, 24 + 9, std::uint32_t(13));
  };
  out.write("corrupt-mesh-rows.fbk", changed("meshes", move_vertex, points));
  out.patched("corrupt-material-factor.fbk", "materials", 12, std::uint32_t(0x7fc00000), model);
  out.patched("corrupt-material-image.fbk", "materials", 61, std::uint32_t(3), model);
  out.patched("corrupt-socket-vertex.fbk", "sockets", 16, std::uint32_t(30), model);
  out.patched("corrupt-socket-meshes.fbk", "sockets", 16, std::uint32_t(18), model);
  out.patched("corrupt-socket-weight.fbk", "sockets", 16 + 5 * 4, 0.0f, model);
  out.patched("corrupt-socket-frame.fbk", "sockets", 16 + 5 * 8, std::uint32_t(0x7f800000), model);
  out.patched("corrupt-about.fbk", "about", 3, std::uint8_t(0xff), model);
  out.patched("corrupt-about-zero.fbk", "about", 3, std::uint8_t(0), model);
  out.write("corrupt-about-long.fbk", changed(
                                          "about", [](Bytes& b) { b.resize(65537, std::byte(' ')); }, model));
  out.patched("corrupt-thumbnail.fbk", "thumbnail", 1, std::uint8_t('G'), model);
  out.patched("corrupt-thumbnail-oblong.fbk", "thumbnail", 19, std::uint8_t(2), model);
  out.write("corrupt-thumbnail-long.fbk", changed(
                                              "thumbnail", [](Bytes& b) { b.resize(65537); }, model));
  write_rejected_definitions(out);
  write_rejected_labels(out);
  write_rejected_meshes(out);
  write_rejected_surfaces(out);
  write_rejected_sockets(out);
  write_rejected_channels(out);
  // The last number of frames, of channels, of expected errors and of "outside", of which each pose has so many.
  const std::size_t channels = model.schema.channels.size(), errors = model.expected.count();
  const auto change_behind = [&](const char* file, std::size_t numbers_after) {
    const auto change = [&](Bytes& b) {
      std::uint32_t poses = 0;
      std::memcpy(&poses, b.data(), sizeof poses);
      b[b.size() - 4 * (poses * numbers_after + 1)] ^= std::byte(1);
    };
    out.write(file, changed("proof", change, model));
  };
  change_behind("unproven-frame.fbk", channels + errors + 1);
  change_behind("unproven-channel.fbk", errors + 1);
  change_behind("unproven-expected.fbk", 1);
  change_behind("unproven-outside.fbk", 0);
  // The first channel's name takes 4 + 5 bytes, its unit 4.
  out.patched("corrupt-channel-range.fbk", "channels", 17, 1.0f, model);
  out.patched("corrupt-channel-rest.fbk", "channels", 17 + 8, 2.0f, model);
  out.patched("corrupt-channel-scale.fbk", "channels", 17 + 12, 0.0f, model);
  out.patched("unsupported-alpha-mode.fbk", "materials", 48, std::uint8_t(3), model);
  out.patched("unsupported-material-flags.fbk", "materials", 53, std::uint8_t(3), model);
  out.patched("unsupported-texture-slot.fbk", "materials", 58, std::uint8_t(5), model);
  out.patched("unsupported-texture-wrap.fbk", "materials", 60, std::uint8_t(3), model);
}

void write_rejected_bodies(const RejectedWriter& out) {
  const PackedModel model = body_model();
  // Three joints, whose names take 4 + 4, 4 + 4 and 4 + 3 bytes; 30 counts, 30 joints of vertices.
  constexpr std::size_t head_joint = 4 + 4 + 4 + 4 + 96, skin_joints = 4 + 30, skin_weights = skin_joints + 60;
  out.patched("corrupt-joint-parent.fbk", "joints", head_joint + 8, std::uint32_t(1), model);
  out.patched("corrupt-joint-name.fbk", "joints", head_joint + 4, std::uint32_t(0x6b63656e), model);
  out.patched("corrupt-joint-frame.fbk", "joints", head_joint + 12, std::uint32_t(0x7f800000), model);
  out.renamed("corrupt-joint-nameless.fbk", "joints", "neck", "", model);
  out.patched("corrupt-joint-bind.fbk", "joints", head_joint + 60, infinity, model);
  out.write("corrupt-joints-65537.fbk", edited(
                                            [](ArchiveEditor& archive) {
                                              Bytes contents = numbers({65537});
                                              contents.resize(4 + 65537 * 104);
                                              archive["joints"].set(contents);
                                              deflate_section(archive["joints"], 9);
                                            },
                                            model));
  const auto drop_influence = [](Bytes& b) {  // of the first vertex, which has one
    for (std::size_t plane = 4; plane-- > 0;) erase(b, skin_weights + 30 * plane, 1);
    erase(b, skin_joints, 2);
    b[4] = std::byte(0);
  };
  out.write("corrupt-skin-part.fbk", changed("skin", drop_influence, model));
  out.patched("corrupt-skin-none.fbk", "skin", 0, std::uint32_t(0), model);
  out.patched("corrupt-skin-infinite.fbk", "skin", skin_weights + 3 * 30, std::uint8_t(0x7f), model);
  out.patched("corrupt-skin-influences.fbk", "skin", 0, std::uint32_t(33), model);
  out.patched("corrupt-skin-count.fbk", "skin", 4, std::uint8_t(3), model);
  out.patched("corrupt-skin-joint.fbk", "skin", skin_joints, std::uint16_t(3), model);
  out.patched("corrupt-skin-weight.fbk", "skin", skin_weights + 3 * 30, std::uint8_t(0xbf), model);
  out.patched("corrupt-skin-sum.fbk", "skin", skin_weights + 3 * 30, std::uint8_t(0x3e), model);
  out.write("corrupt-skin-mesh.fbk", changed(
                                         "skin", [](Bytes& b) { std::swap(b[4], b[4 + 18]); }, model));
  out.write("corrupt-skin-more.fbk", changed(
                                         "skin", [](Bytes& b) { b.resize(b.size() + 2); }, model));
  out.write("corrupt-skin-alone.fbk", edited(
                                          [](ArchiveEditor& archive) {
                                            std::erase_if(archive.sections,
                                                          [](const auto& section) { return section.name == "joints"; });
                                          },
                                          model));
  out.write("corrupt-joints-none.fbk", changed(
                                           "joints", [](Bytes& b) { b.assign(4, {}); }, model));
  out.write("corrupt-joints-more.fbk", changed(
                                           "joints", [](Bytes& b) { b.resize(b.size() + 2); }, model));
}

}  // namespace fb
