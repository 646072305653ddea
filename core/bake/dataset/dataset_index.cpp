#include "bake/dataset/dataset_index.h"

#include <algorithm>
#include <cinttypes>
#include <nlohmann/json.hpp>
#include <unordered_set>

#include "bake/rig/character_json.h"
#include "bake/rig/json_field.h"
#include "base/file.h"
#include "base/file_extension.h"
#include "base/path_inside.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fs = std::filesystem;

namespace fb::bake {
namespace {

using nlohmann::json;

constexpr const char* format_name = "facebaker-dataset";
constexpr int format_version = 1;

// A file name, or a list of them.
std::vector<std::string> read_files(const JsonField& field) {
  if (field.is_text()) return {field.nonempty_text()};
  std::vector<std::string> names;
  for (const JsonField& item : field.nonempty_items()) names.push_back(item.nonempty_text());
  return names;
}

DatasetIndex::Entry read_entry(const JsonField& field) {
  DatasetIndex::Entry entry;
  entry.name = field["name"].nonempty_text();
  entry.kind = field["kind"].read_or(entry.kind, clip_kind_from);
  entry.split = field["split"].read_or(entry.split, split_from);
  if (field["fps"].exists()) entry.fps = field["fps"].number();
  if (entry.fps <= 0) field["fps"].refuse("is not above zero");
  entry.controls = read_files(field["controls"]);
  if (field["points"].exists()) entry.points = read_files(field["points"]);
  if (field["channels"].exists()) entry.channels = read_files(field["channels"]);
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

void read_rest(const JsonField& rest, DatasetIndex& index) {
  if (rest.is_text()) {
    index.rest_mesh = rest.nonempty_text();
    return;
  }
  index.rest_arrays.points = rest["points"].nonempty_text();
  index.rest_arrays.faces = rest["faces"].nonempty_text();
  if (rest["uvs"].exists() || rest["uv_faces"].exists()) {
    index.rest_arrays.uvs = rest["uvs"].nonempty_text();
    index.rest_arrays.uv_faces = rest["uv_faces"].nonempty_text();
  }
}

void read_clips(const JsonField& root, DatasetIndex& index, const Attempts& attempt) {
  std::unordered_set<std::string> names;
  for (const JsonField& item : root["clips"].nonempty_items())
    attempt([&] {
      DatasetIndex::Entry entry = read_entry(item);
      if (!names.insert(entry.name).second) item["name"].refuse(format("\"%s\" occurs twice", entry.name.c_str()));
      index.clips.push_back(std::move(entry));
    });
}

void read_sampling(const JsonField& sampling, DatasetIndex& index) {
  index.sampling =
      DatasetIndex::Sampling{sampling["request"].hash(), sampling["plan"].hash(), sampling["shard_frames"].count(1)};
  if (const JsonField left_out = sampling["left_out"]; left_out.exists()) index.sampling->left_out = left_out.count(1);
}

// `schema_only`: rest mesh and clips may be missing.
DatasetIndex read_index(const JsonField& root, const Attempts& attempt, bool schema_only) {
  DatasetIndex index;
  const JsonField named_format = root["format"];  // no attempt: without an object there is nothing else to find
  attempt([&] {
    if (named_format.text_or("") != format_name) root.refuse(format("its \"format\" is not \"%s\"", format_name));
  });
  attempt([&] {
    if (const double version = root["version"].number(); version != format_version)
      root["version"].refuse(format("is %g; this program reads %d", version, format_version), Status::unsupported);
  });
  attempt([&] { index.schema.name = root["name"].nonempty_text(); });
  attempt([&] { index.schema.units = root["units"].nonempty_text(); });
  attempt([&] {
    const std::string axis = root["up_axis"].nonempty_text();
    if (axis != "y" && axis != "z") root["up_axis"].refuse("is neither \"y\" nor \"z\"");
    index.schema.up_axis = axis;
  });
  if (!schema_only || root["rest"].exists()) attempt([&] { read_rest(root["rest"], index); });
  attempt([&] {
    for (const JsonField& item : root["controls"].nonempty_items())
      attempt([&] { index.schema.controls.push_back(read_control(item)); });
  });
  if (!schema_only) attempt([&] { read_clips(root, index, attempt); });
  attempt([&] {
    const auto name_image = [&](const JsonField& image) {
      index.image_files.push_back(image["file"].nonempty_text());
      return std::vector<std::byte>();
    };
    read_character(root, name_image, index.parts, index.character);
    index.schema.channels = read_channels(root);
    index.driven_joints = read_driven_joints(root);
  });
  if (const JsonField skin = root["skin"]; skin.exists())
    attempt([&] {
      index.skin_joints = skin["joints"].nonempty_text();
      index.skin_weights = skin["weights"].nonempty_text();
    });
  if (!index.driven_joints.empty())
    attempt([&] {
      const JsonField skin = root["driven_skin"];
      index.driven_skin_joints = skin["joints"].nonempty_text();
      index.driven_skin_weights = skin["weights"].nonempty_text();
    });
  if (root["sampling"].exists() && !schema_only) attempt([&] { read_sampling(root["sampling"], index); });
  if (!schema_only) attempt([&] { index.plan = root["plan"].flag_or(false); });
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
  const auto root = parse_json<json>({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, shown(path));
  return read_index(JsonField(root, shown(path) + ":"), attempt, schema_only);
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
  root["controls"] = json_of(index.schema.controls);
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
  write_driven_joints(index.driven_joints, root);
  if (!index.driven_joints.empty())
    root["driven_skin"] = {{"joints", index.driven_skin_joints}, {"weights", index.driven_skin_weights}};
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
