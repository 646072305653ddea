#include "bake/dataset/dataset_index.h"

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <nlohmann/json.hpp>
#include <unordered_set>

#include "bake/rig/character_json.h"
#include "base/file.h"
#include "base/file_extension.h"
#include "base/json_depth.h"
#include "base/path_inside.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fs = std::filesystem;

namespace fb::bake {
namespace {

using nlohmann::json;

constexpr const char* format_name = "facebaker-dataset";
constexpr int format_version = 1;

// A JSON value and the path to it, with which messages begin: "dataset.json: clips[2] fps".
class Field {
 public:
  Field(const json& root, const fs::path& file) : value_(root), where_(shown(file)), inside_(": ") {}

  [[noreturn]] void refuse(const std::string& why, Status status = Status::bad_data) const {
    fail(status, "%s: %s", where_.c_str(), why.c_str());
  }

  bool has(const char* key) const { return value_.is_object() && value_.contains(key); }

  Field operator[](const char* key) const {
    if (!value_.is_object()) refuse("is no object");
    const auto found = value_.find(key);
    if (found == value_.end()) refuse(format("has no \"%s\"", key));
    return {*found, where_ + inside_ + key};
  }

  std::string text_or_empty() const {
    if (!value_.is_string()) refuse("is no string");
    std::string text = value_.get<std::string>();
    if (text.find('\0') != std::string::npos) refuse("holds a zero byte");
    return text;
  }

  std::string text() const {
    std::string text = text_or_empty();
    if (text.empty()) refuse("is empty");
    return text;
  }

  double number() const {
    if (!value_.is_number()) refuse("is no number");
    const double number = value_.get<double>();
    if (!std::isfinite(number)) refuse("is not finite", Status::not_finite);
    return number;
  }

  float single() const {
    const double value = number();
    if (std::abs(value) > 3.4e38) refuse("is too large for a float");
    return static_cast<float>(value);
  }

  std::uint64_t hash() const {
    std::uint64_t hash = 0;
    if (std::sscanf(text().c_str(), "%" SCNx64, &hash) != 1) refuse("is no hexadecimal number");
    return hash;
  }

  std::uint64_t count() const {
    if (!value_.is_number_unsigned() || value_.get<std::uint64_t>() == 0) refuse("is no positive whole number");
    return value_.get<std::uint64_t>();
  }

  bool flag() const {
    if (!value_.is_boolean()) refuse("is neither true nor false");
    return value_.get<bool>();
  }

  std::vector<Field> items() const {
    if (!value_.is_array()) refuse("is no list");
    if (value_.empty()) refuse("is empty");
    std::vector<Field> items;
    for (std::size_t i = 0; i < value_.size(); ++i)
      items.push_back(Field(value_[i], where_ + "[" + std::to_string(i) + "]"));
    return items;
  }

  // A file name, or a list of them.
  std::vector<std::string> files() const {
    if (value_.is_string()) return {text()};
    std::vector<std::string> names;
    for (const Field& item : items()) names.push_back(item.text());
    return names;
  }

  // The character's fields of this object.
  void read_character(DatasetIndex& index) const {
    try {
      bake::read_character(
          value_,
          [&](const json& image) {
            const auto file = image.find("file");
            if (file == image.end() || !file->is_string() || file->get<std::string>().empty())
              fail(Status::bad_data, "images[%zu] has no \"file\"", index.image_files.size());
            index.image_files.push_back(file->get<std::string>());
            return std::vector<std::byte>();
          },
          index.parts, index.character);
      index.schema.channels = read_channels(value_);
    } catch (const Error& error) {
      refuse(error.what(), error.status());
    }
  }

  bool is_text() const { return value_.is_string(); }

  // Calls read(text), adding this field's path to messages of errors.
  template <class Read>
  auto word(Read&& read) const {
    try {
      return read(text());
    } catch (const Error& error) {
      refuse(error.what(), error.status());
    }
  }

 private:
  Field(const json& value, std::string where) : value_(value), where_(std::move(where)), inside_(" ") {}

  const json& value_;
  std::string where_;
  const char* inside_;  // between where_ and a key of it
};

Control read_control(const Field& field) {
  Control control;
  control.name = field["name"].text();
  control.minimum = field["min"].single();
  control.maximum = field["max"].single();
  control.rest = field["default"].single();
  const auto text = [&](const char* key) { return field.has(key) ? field[key].text_or_empty() : std::string(); };
  control.group = text("group");
  control.labels = {text("arkit"), text("facs"), text("unit"), text("mirror")};
  return control;
}

DatasetIndex::Entry read_entry(const Field& field) {
  DatasetIndex::Entry entry;
  entry.name = field["name"].text();
  if (field.has("kind")) entry.kind = field["kind"].word(clip_kind_from);
  if (field.has("split")) entry.split = field["split"].word(split_from);
  if (field.has("fps")) entry.fps = field["fps"].number();
  if (entry.fps <= 0) field["fps"].refuse("is not above zero");
  entry.controls = field["controls"].files();
  if (field.has("points")) entry.points = field["points"].files();
  if (field.has("channels")) entry.channels = field["channels"].files();
  return entry;
}

// Calls read(), or adds what is wrong to a list where there is one.
class Attempts {
 public:
  explicit Attempts(std::vector<std::string>* faults) : faults_(faults) {}

  template <class Read>
  bool operator()(Read&& read) const {
    if (!faults_) return read(), true;
    try {
      read();
      return true;
    } catch (const Error& error) {
      faults_->push_back(error.what());
      return false;
    }
  }

 private:
  std::vector<std::string>* faults_;
};

void read_rest(const Field& rest, DatasetIndex& index) {
  if (rest.is_text()) {
    index.rest_mesh = rest.text();
    return;
  }
  index.rest_arrays.points = rest["points"].text();
  index.rest_arrays.faces = rest["faces"].text();
  if (rest.has("uvs") || rest.has("uv_faces")) {
    index.rest_arrays.uvs = rest["uvs"].text();
    index.rest_arrays.uv_faces = rest["uv_faces"].text();
  }
}

void read_clips(const Field& root, DatasetIndex& index, const Attempts& attempt) {
  std::unordered_set<std::string> names;
  for (const Field& item : root["clips"].items())
    attempt([&] {
      DatasetIndex::Entry entry = read_entry(item);
      if (!names.insert(entry.name).second) item.refuse(format("clip name \"%s\" occurs twice", entry.name.c_str()));
      index.clips.push_back(std::move(entry));
    });
}

void read_sampling(const Field& sampling, DatasetIndex& index) {
  index.sampling =
      DatasetIndex::Sampling{sampling["request"].hash(), sampling["plan"].hash(), sampling["shard_frames"].count()};
  if (sampling.has("left_out")) index.sampling->left_out = sampling["left_out"].count();
}

// `schema_only`: rest mesh and clips may be missing.
DatasetIndex read_index(const Field& root, const Attempts& attempt, bool schema_only) {
  DatasetIndex index;
  attempt([&] {
    if (!root.has("format") || root["format"].text() != format_name)
      root.refuse(format("its \"format\" is not \"%s\"", format_name));
  });
  attempt([&] {
    if (const double version = root["version"].number(); version != format_version)
      root["version"].refuse(format("is %g; this program reads %d", version, format_version), Status::unsupported);
  });
  attempt([&] { index.schema.name = root["name"].text(); });
  attempt([&] { index.schema.units = root["units"].text(); });
  attempt([&] {
    const std::string axis = root["up_axis"].text();
    if (axis != "y" && axis != "z") root["up_axis"].refuse("is neither \"y\" nor \"z\"");
    index.schema.up_axis = axis;
  });
  if (!schema_only || root.has("rest")) attempt([&] { read_rest(root["rest"], index); });
  attempt([&] {
    for (const Field& item : root["controls"].items())
      attempt([&] { index.schema.controls.push_back(read_control(item)); });
  });
  if (!schema_only) attempt([&] { read_clips(root, index, attempt); });
  attempt([&] { root.read_character(index); });
  if (root.has("skin"))
    attempt([&] {
      index.skin_joints = root["skin"]["joints"].text();
      index.skin_weights = root["skin"]["weights"].text();
    });
  if (root.has("sampling") && !schema_only) attempt([&] { read_sampling(root["sampling"], index); });
  if (root.has("plan") && !schema_only) attempt([&] { index.plan = root["plan"].flag(); });
  return index;
}

// One name is written as a string, several as a list.
json names(const std::vector<std::string>& files) {
  return files.size() == 1 ? json(files[0]) : json(files);
}

}  // namespace

fs::path dataset_path(const fs::path& folder, const std::string& name) {
  return with_context(shown(folder / dataset_file), [&] { return path_inside(folder, name); });
}

namespace {

DatasetIndex parse_index(const fs::path& path, const Attempts& attempt, bool schema_only) {
  const std::vector<std::byte> bytes = read_file(path, std::uint64_t{1} << 28);
  const char* text = reinterpret_cast<const char*>(bytes.data());
  with_context(shown(path), [&] { check_json_depth({text, bytes.size()}); });
  json root;
  try {
    root = json::parse(text, text + bytes.size());
  } catch (const json::exception& error) {
    const std::string why = error.what();  // "[json.exception...] parse error at line 3, ..."
    fail(Status::bad_data, "%s: is no JSON: %s", shown(path).c_str(), why.substr(why.find("] ") + 2).c_str());
  }
  return read_index(Field(root, path), attempt, schema_only);
}

DatasetIndex read_checked(const fs::path& path, bool schema_only) {
  DatasetIndex index = parse_index(path, Attempts(nullptr), schema_only);
  with_context(shown(path), [&] { check(index.schema); });
  return index;
}

}  // namespace

DatasetIndex read_dataset_index(const fs::path& folder) {
  return read_checked(folder / dataset_file, false);
}

DatasetIndex read_dataset_index(const fs::path& folder, std::vector<std::string>& faults) {
  DatasetIndex index;
  const Attempts attempt(&faults);
  attempt([&] { index = parse_index(folder / dataset_file, attempt, false); });
  return index;
}

DatasetIndex read_dataset_schema(const fs::path& file) {
  return read_checked(file, true);
}

void write_dataset_index(const fs::path& folder, const DatasetIndex& index) {
  using Ordered = nlohmann::ordered_json;
  Ordered root = {{"format", format_name},
                  {"version", format_version},
                  {"name", index.schema.name},
                  {"units", index.schema.units},
                  {"up_axis", index.schema.up_axis}};
  const MeshArrays& rest = index.rest_arrays;
  if (index.rest_mesh.empty())
    root["rest"] = {{"points", rest.points}, {"faces", rest.faces}};
  else
    root["rest"] = index.rest_mesh;
  if (!rest.uvs.empty()) {
    root["rest"]["uvs"] = rest.uvs;
    root["rest"]["uv_faces"] = rest.uv_faces;
  }
  root["controls"] = Ordered::array();
  for (const Control& c : index.schema.controls) {
    Ordered control = {{"name", c.name}, {"min", c.minimum}, {"max", c.maximum}, {"default", c.rest}};
    write_labels(c, control);
    root["controls"].push_back(control);
  }
  root["clips"] = Ordered::array();
  for (const DatasetIndex::Entry& entry : index.clips) {
    Ordered clip = {{"name", entry.name},
                    {"kind", name_of(entry.kind)},
                    {"split", name_of(entry.split)},
                    {"fps", entry.fps},
                    {"controls", names(entry.controls)}};
    if (!entry.points.empty()) clip["points"] = names(entry.points);
    if (!entry.channels.empty()) clip["channels"] = names(entry.channels);
    root["clips"].push_back(clip);
  }
  write_character(
      index.parts, index.character, [&](std::size_t i, Ordered& image) { image["file"] = index.image_files[i]; }, root);
  if (!index.skin_joints.empty()) root["skin"] = {{"joints", index.skin_joints}, {"weights", index.skin_weights}};
  write_about(index.character.about, root);
  write_channels(index.schema.channels, root);
  if (index.sampling)
    root["sampling"] = {{"request", format("%016" PRIx64, index.sampling->request)},
                        {"plan", format("%016" PRIx64, index.sampling->plan)},
                        {"shard_frames", index.sampling->shard_frames}};
  if (index.sampling && index.sampling->left_out > 0) root["sampling"]["left_out"] = index.sampling->left_out;
  if (index.plan) root["plan"] = true;
  try {
    write_file(folder / dataset_file, root.dump(1) + "\n");
  } catch (const json::exception& error) {
    fail(Status::bad_data, "%s: a name is not UTF-8: %s", shown(folder / dataset_file).c_str(), error.what());
  }
}

std::string shard_name(const std::string& name, std::size_t number) {
  std::size_t end = name.size();
  const std::string lower = lower_case(name);
  for (const char* suffix :
       {".points.npy", ".controls.npy", ".channels.npy", ".npy", ".points.mdd", ".mdd", ".points.pc2", ".pc2"})
    if (lower.ends_with(suffix)) {
      end = name.size() - std::char_traits<char>::length(suffix);
      break;
    }
  return name.substr(0, end) + format(".%03zu", number) + name.substr(end);
}

bool has_shards(const fs::path& folder, const std::vector<std::string>& names) {
  const auto there = [&](const std::string& name) { return fs::exists(dataset_path(folder, name)); };
  if (names.size() == 1 && there(shard_name(names[0], 0))) return true;
  return std::all_of(names.begin(), names.end(), there);
}

std::vector<fs::path> shard_files(const fs::path& folder, const std::vector<std::string>& names) {
  std::vector<fs::path> files;
  if (names.size() > 1) {
    for (const std::string& name : names) files.push_back(dataset_path(folder, name));
    return files;
  }
  const auto shard = [&](std::size_t number) { return dataset_path(folder, shard_name(names.at(0), number)); };
  for (std::size_t i = 0; fs::exists(shard(i)); ++i) files.push_back(shard(i));
  const fs::path whole = dataset_path(folder, names.at(0));
  if (fs::exists(whole)) {
    if (!files.empty())
      fail(Status::bad_data, "%s: is there whole and in shards, such as %s: remove one", shown(whole).c_str(),
           shown(files[0].filename()).c_str());
    return {whole};
  }
  if (files.empty())
    fail(Status::not_found, "%s: no such file, and no shard %s", shown(whole).c_str(),
         shown(shard(0).filename()).c_str());
  if (fs::exists(shard(files.size() + 1)))
    fail(Status::not_found, "%s: no such file, but the next shard is there", shown(shard(files.size())).c_str());
  return files;
}

}  // namespace fb::bake
