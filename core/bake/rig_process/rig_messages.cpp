#include "bake/rig_process/rig_messages.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>

#include "bake/rig/carried_numbers.h"
#include "bake/rig/character_json.h"
#include "bake/rig/driven_pose.h"
#include "bake/rig/json_field.h"
#include "bake/rig/source_rules.h"
#include "base/checked.h"
#include "base/shown_path.h"

namespace fb::bake {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little, "messages are written in the byte order of memory");

constexpr std::array<char, 4> signature = {'F', 'B', 'R', '1'};
constexpr std::size_t header_size = 16;
constexpr std::uint32_t most_text = 1u << 26;

RigMessage message_of(const ordered_json& fields) {
  return {fields.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n", {}};
}

template <class T>
void append(std::vector<std::byte>& data, std::span<const T> values) {
  const auto bytes = std::as_bytes(values);
  data.insert(data.end(), bytes.begin(), bytes.end());
}

// Bytes from anyone, for a message: what cannot be printed is a dot.
std::string quoted(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte byte : bytes) {
    const char c = static_cast<char>(byte);
    text += c >= ' ' && c <= '~' ? c : '.';
  }
  return '"' + text + '"';
}

// The text of a message, and its fields.
json parsed(const RigMessage& message) {
  return parse_json<json>(message.text, "a message (" + shown(message.text) + ")", Status::rig);
}
JsonField fields_of(const json& text) {
  return {text, "a message:", Status::rig};
}

// The data of a message, number after number.
class Numbers {
 public:
  explicit Numbers(const RigMessage& message) : left_(message.data) {}
  template <class T>
  std::vector<T> take(std::size_t count, const char* what) {
    if (count > left_.size() / sizeof(T))
      fail(Status::rig, "the data end within the %s: %zu numbers are needed, %zu bytes left", what, count,
           left_.size());
    std::vector<T> values(count);
    if (count > 0) std::memcpy(values.data(), left_.data(), count * sizeof(T));
    left_ = left_.subspan(count * sizeof(T));
    return values;
  }
  void finish() const {
    if (!left_.empty()) fail(Status::rig, "%zu bytes of data are left over", left_.size());
  }

 private:
  std::span<const std::byte> left_;
};

// The sentence of an answer of type "error".
std::string reason_of(const JsonField& fields) {
  const std::string reason = fields["message"].any_text();
  return reason.empty() ? "an error without a message" : shown(reason);
}

void check_version(const JsonField& fields) {
  if (const std::uint64_t version = fields["version"].count(); version != rig_protocol_version)
    fail(Status::rig, "version %llu of the rig protocol, where %llu is spoken",
         static_cast<unsigned long long>(version), static_cast<unsigned long long>(rig_protocol_version));
}

Mesh read_mesh(const JsonField& fields, Numbers& numbers) {
  Mesh mesh;
  mesh.points = numbers.take<float>(3 * std::size_t{fields["vertices"].count()}, "rest mesh");
  mesh.polygon_sizes = numbers.take<std::uint32_t>(fields["polygons"].count_or(0), "sizes of polygons");
  std::size_t corners = 0;
  for (const std::uint32_t size : mesh.polygon_sizes) corners += size;
  mesh.polygon_corners = numbers.take<std::uint32_t>(corners, "corners of polygons");
  if (const std::size_t uvs = fields["uvs"].count_or(0)) {
    mesh.uvs = numbers.take<float>(2 * uvs, "texture coordinates");
    mesh.uv_corners = numbers.take<std::uint32_t>(corners, "texture coordinates of corners");
  }
  return mesh;
}

Skin read_skin(const JsonField& influences, Numbers& numbers, const Mesh& rest) {
  Skin skin{influences.count_or(0), {}, {}};
  const std::size_t places = checked_multiply(rest.surface_vertex_count(), skin.influences, "influences");
  skin.joints = numbers.take<std::uint16_t>(places, "joints of vertices");
  skin.weights = numbers.take<float>(places, "weights of joints");
  tidy(skin);
  return skin;
}

// The skin of the joints, and which of them controls drive: in positions that come after skinning, or beside others.
void read_skins(const JsonField& fields, Numbers& numbers, RigDescription& rig) {
  rig.character.skin = read_skin(fields["skin_influences"], numbers, rig.rest);
  DrivenJoints& driven = rig.rest.driven;
  driven.joints = read_driven_joints(fields);
  if (!driven.empty()) {
    driven.skin = read_skin(fields["driven_influences"], numbers, rig.rest);
    round_weights(driven.skin);
  }
  const std::vector<std::uint32_t> joint_numbers = read_joint_numbers(fields);
  if (fields["skinned"].flag_or(false)) {
    if (!driven.empty()) fields["driven_joints"].refuse("stands beside \"skinned\"");
    take_out_skin(rig, joint_numbers);
  } else if (std::ranges::any_of(joint_numbers, [](std::uint32_t of_joint) { return of_joint != 0; })) {
    fields["joints"].refuse("has numbers without \"skinned\"");
  }
}

std::vector<Clip> read_clips(const JsonField& fields, Numbers& numbers, std::size_t controls) {
  std::vector<Clip> clips;
  for (const JsonField& from : fields["clips"].items_or_none()) {
    Clip clip;
    clip.name = from["name"].text();
    clip.kind = from["kind"].read_or(clip.kind, clip_kind_from);
    clip.split = from["split"].read_or(clip.split, split_from);
    clip.fps = from["fps"].number();
    clip.frames = from["frames"].count();
    clip.controls = numbers.take<float>(checked_multiply(clip.frames, controls, "frames x controls"), "clips");
    clips.push_back(std::move(clip));
  }
  return clips;
}

// Of a pose, behind its positions: numbers, and then frames of joints.
std::size_t answered_numbers(const RigDescription& rig) {
  return rig.skinned ? rig.schema.channels.size() : carried_count(rig.schema, rig.rest);
}
std::size_t frame_floats(const RigDescription& rig) {
  return rig.skinned ? 12 * rig.joints.count() : 0;
}

}  // namespace

std::vector<std::byte> bytes_of(const RigMessage& message) {
  const std::uint32_t text = checked_u32(message.text.size(), "a message's text");
  const std::uint64_t data = message.data.size();
  std::vector<std::byte> bytes(header_size + text + data);
  std::memcpy(bytes.data(), signature.data(), 4);
  std::memcpy(bytes.data() + 4, &text, sizeof text);
  std::memcpy(bytes.data() + 8, &data, sizeof data);
  std::ranges::copy(std::as_bytes(std::span(message.text)), bytes.begin() + header_size);
  std::ranges::copy(message.data, bytes.begin() + header_size + text);
  return bytes;
}

std::size_t MessageReader::wanted() const {
  if (header_bytes_ < header_.size()) return header_.size() - header_bytes_;
  return text_size_ + data_size_ - message_.text.size() - message_.data.size();
}

void MessageReader::take(std::span<const std::byte> bytes) {
  if (header_bytes_ < header_.size()) {
    std::ranges::copy(bytes, header_.begin() + static_cast<std::ptrdiff_t>(header_bytes_));
    header_bytes_ += bytes.size();
    const std::size_t seen = std::min(header_bytes_, signature.size());
    if (std::memcmp(header_.data(), signature.data(), seen) != 0)
      fail(Status::rig, "at byte %llu: %s, where a message begins with \"FBR1\"",
           static_cast<unsigned long long>(position_), quoted(std::span(header_).first(header_bytes_)).c_str());
    if (header_bytes_ == header_.size()) read_header();
    return;
  }
  const std::size_t of_text = std::min<std::size_t>(bytes.size(), text_size_ - message_.text.size());
  message_.text.append(reinterpret_cast<const char*>(bytes.data()), of_text);
  append(message_.data, bytes.subspan(of_text));
}

void MessageReader::read_header() {
  std::uint32_t text = 0;
  std::memcpy(&text, header_.data() + 4, sizeof text);
  std::memcpy(&data_size_, header_.data() + 8, sizeof data_size_);
  text_size_ = text;
  if (text_size_ > most_text)
    fail(Status::rig, "at byte %llu: a message with %u bytes of text, more than %u",
         static_cast<unsigned long long>(position_), text, most_text);
  if (data_size_ > most_data_)
    fail(Status::rig, "at byte %llu: a message with %llu bytes of data, more than %llu",
         static_cast<unsigned long long>(position_), static_cast<unsigned long long>(data_size_),
         static_cast<unsigned long long>(most_data_));
}

RigMessage MessageReader::release() {
  position_ += header_size + text_size_ + data_size_;
  header_bytes_ = 0;
  text_size_ = data_size_ = 0;
  return std::exchange(message_, {});
}

RigMessage hello_request() {
  return message_of({{"type", "hello"}, {"version", rig_protocol_version}});
}

RigMessage evaluate_request(std::span<const float> controls, std::size_t poses) {
  RigMessage message = message_of({{"type", "evaluate"}, {"poses", poses}});
  append(message.data, controls);
  return message;
}

RigMessage bye_request() {
  return message_of({{"type", "bye"}});
}

RigRequest request_of(const RigMessage& message) {
  const json text = parsed(message);
  const JsonField fields = fields_of(text);
  const std::string type = fields["type"].text();
  if (type == "evaluate") return RigRequest::evaluate;
  if (type == "bye") return RigRequest::bye;
  if (type != "hello") fail(Status::rig, "a request of type \"%s\"", shown(type).c_str());
  check_version(fields);
  return RigRequest::hello;
}

std::vector<float> poses_of(const RigMessage& request, std::size_t controls) {
  Numbers numbers(request);
  std::vector<float> values = numbers.take<float>(
      checked_multiply(fields_of(parsed(request))["poses"].count(), controls, "poses x controls"), "controls");
  numbers.finish();
  return values;
}

RigMessage hello_answer(const Source& rig) {
  const RigSchema& schema = rig.schema();
  const Mesh& rest = rig.rest();
  ordered_json clips = ordered_json::array();
  for (const Clip& clip : rig.clips())
    clips.push_back({{"name", clip.name},
                     {"kind", name_of(clip.kind)},
                     {"split", name_of(clip.split)},
                     {"fps", clip.fps},
                     {"frames", clip.frames}});
  ordered_json hello = {{"type", "hello"},
                        {"version", rig_protocol_version},
                        {"name", schema.name},
                        {"units", schema.units},
                        {"up_axis", schema.up_axis},
                        {"controls", json_of(schema.controls)},
                        {"vertices", rest.surface_vertex_count()},
                        {"polygons", rest.polygon_sizes.size()},
                        {"uvs", rest.uvs.size() / 2},
                        {"clips", clips},
                        {"preferred_block", rig.preferred_block()},
                        {"rig_version", rig.version()}};
  if (const std::vector<std::string> notes = rig.notes(); !notes.empty()) hello["notes"] = notes;
  write_character(
      rest.parts, rig.character(),
      [&](std::size_t i, ordered_json& image) { image["bytes"] = rig.character().images[i].bytes.size(); }, hello);
  const Skin& skin = rig.character().skin;
  if (skin.influences > 0) hello["skin_influences"] = skin.influences;
  write_about(rig.character().about, hello);
  write_channels(schema.channels, hello);
  const DrivenJoints& driven = rest.driven;
  write_driven_joints(driven.joints, hello);
  if (!driven.empty()) hello["driven_influences"] = driven.skin.influences;
  RigMessage message = message_of(hello);
  append<float>(message.data, rest.surface_points());
  append<std::uint32_t>(message.data, rest.polygon_sizes);
  append<std::uint32_t>(message.data, rest.polygon_corners);
  append<float>(message.data, rest.uvs);
  append<std::uint32_t>(message.data, rest.uv_corners);
  for (const Image& image : rig.character().images) append<std::byte>(message.data, image.bytes);
  append<std::uint16_t>(message.data, skin.joints);
  append<float>(message.data, skin.weights);
  append<std::uint16_t>(message.data, driven.skin.joints);
  append<float>(message.data, driven.skin.weights);
  for (const Clip& clip : rig.clips()) append<float>(message.data, clip.controls);
  return message;
}

RigMessage points_answer(const Source& rig, std::span<const float> points, std::size_t poses) {
  RigMessage message = message_of({{"type", "points"}, {"poses", poses}});
  const RigSchema& schema = rig.schema();
  std::vector<float> positions(poses * rig.rest().surface_points().size());
  std::vector<float> channels(poses * carried_count(schema, rig.rest()));
  split_carried(schema, rig.rest(), points, poses, positions, channels);
  append<float>(message.data, positions);
  append<float>(message.data, channels);
  return message;
}

RigMessage error_answer(const RigFailure& failure) {
  ordered_json fields = {{"type", "error"}, {"message", failure.reason}};
  if (failure.pose) fields["pose"] = *failure.pose;
  return message_of(fields);
}

RigDescription description_of(const RigMessage& answer) {
  const json text = parsed(answer);
  const JsonField fields = fields_of(text);
  const std::string type = fields["type"].text();
  if (type == "error") fail(Status::rig, "%s", reason_of(fields).c_str());
  if (type != "hello") fail(Status::rig, "answered hello by a message of type \"%s\"", shown(type).c_str());
  check_version(fields);
  RigDescription rig;
  rig.schema = {fields["name"].text(), fields["units"].text(), fields["up_axis"].text(), {}};
  for (const JsonField& from : fields["controls"].items()) rig.schema.controls.push_back(read_control(from));
  Numbers numbers(answer);
  rig.version = fields["rig_version"].text_or("");
  rig.rest = read_mesh(fields, numbers);
  try {
    read_character(
        fields, [&](const JsonField& image) { return numbers.take<std::byte>(image["bytes"].count(), "images"); },
        rig.rest.parts, rig.character);
    rig.schema.channels = read_channels(fields);
    read_skins(fields, numbers, rig);
  } catch (const Error& error) {
    fail(Status::rig, "%s", error.what());
  }
  for (Socket& socket : rig.character.sockets) set_default_frame(socket, rig.rest.points);
  rig.clips = read_clips(fields, numbers, rig.schema.control_count());
  numbers.finish();
  rig.preferred_block = std::min<std::size_t>(fields["preferred_block"].count_or(0), most_preferred_poses);
  for (const JsonField& note : fields["notes"].items_or_none()) rig.notes.push_back(note.text());
  check_source(rig.schema, rig.rest, rig.character);
  add_channel_vertices(rig.schema, rig.rest);
  if (!rig.rest.driven.empty()) {
    add_joint_vertices(rig.rest);
    check(rig.rest);
  }
  check_clips(rig.clips);
  for (const Clip& clip : rig.clips) check_values(clip, rig.schema);
  return rig;
}

std::size_t answer_floats(const RigDescription& rig) {
  return rig.rest.surface_points().size() + answered_numbers(rig) + frame_floats(rig);
}

std::optional<RigFailure> read_answer(const RigMessage& answer, const RigDescription& rig, std::size_t poses,
                                      std::span<float> points) {
  const json text = parsed(answer);
  const JsonField fields = fields_of(text);
  const std::string type = fields["type"].text();
  if (type == "error") {
    RigFailure failure{std::nullopt, reason_of(fields)};
    if (fields["pose"].exists()) failure.pose = fields["pose"].count();
    if (failure.pose && *failure.pose >= poses)
      fail(Status::rig, "an error for pose %zu of a request for %zu", *failure.pose, poses);
    return failure;
  }
  if (type != "points") fail(Status::rig, "an answer of type \"%s\" to a request for points", shown(type).c_str());
  const std::size_t bytes = poses * answer_floats(rig) * sizeof(float);
  if (fields["poses"].count() != poses || answer.data.size() != bytes)
    fail(Status::rig, "points of %llu poses in %zu bytes, where %zu poses in %zu bytes were asked for",
         static_cast<unsigned long long>(fields["poses"].count()), answer.data.size(), poses, bytes);
  Numbers numbers(answer);
  std::vector<float> positions = numbers.take<float>(poses * rig.rest.surface_points().size(), "positions");
  const std::vector<float> carried = numbers.take<float>(poses * answered_numbers(rig), "channels");
  if (!rig.skinned) {
    join_carried(rig.schema, rig.rest, positions, carried, poses, points);
    return std::nullopt;
  }
  const std::vector<float> frames = numbers.take<float>(poses * frame_floats(rig), "frames of joints");
  try {
    take_out_poses(rig, positions, carried, frames, poses, points);
  } catch (const PoseError& error) {
    return RigFailure{error.pose(), error.reason()};
  }
  return std::nullopt;
}

}  // namespace fb::bake
