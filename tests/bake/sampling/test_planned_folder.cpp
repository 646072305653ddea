#include "bake/sampling/planned_folder.h"

#include <algorithm>
#include <fstream>

#include "bake/dataset/dataset_index.h"
#include "bake/dataset/dataset_source.h"
#include "bake/dataset/npy.h"
#include "bake/dataset/schema_source.h"
#include "bake_test_support.h"

namespace test_planned_folder {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

SamplingOptions few_poses() {
  SamplingOptions options;
  options.poses = 80;
  options.drawn_test_poses = 20;
  return options;
}

PosePlan plan(Source& source, const SamplingOptions& options) {
  return plan_poses(source, options, {}, silent_progress());
}

const char* const schema =
    R"({ "format": "facebaker-dataset", "version": 1, "name": "face", "units": "cm", "up_axis": "y",
  "controls": [ { "name": "jaw", "min": -1, "max": 0, "default": 0, "group": "jaw" },
                { "name": "smile_L", "min": 0, "max": 2, "default": 0 },
                { "name": "smile_R", "min": 0, "max": 2, "default": 0 } ] })";

struct SchemaFile {
  Folder folder;
  std::filesystem::path path = folder / "face.json";

  explicit SchemaFile(const std::string& text = schema) { std::ofstream(path) << text; }
};

}  // namespace

TEST_CASE("the plan of a live rig has the poses that are sampled, and the rest pose") {
  const auto toy = open_toy();
  SamplingOptions options = few_poses();
  const PosePlan planned = plan(*toy, options);
  const PosePlan sampled = make_plan(*toy, options, {}, silent_progress());
  REQUIRE(planned.size() == sampled.size() + 1);
  CHECK(planned[0].name == "rest_pose");
  CHECK(planned[0].controls == toy->schema().rest_pose());
  for (std::size_t c = 0; c < sampled.size(); ++c) {
    CHECK(planned[c + 1].name == sampled[c].name);
    CHECK(planned[c + 1].controls == sampled[c].controls);
  }
}

TEST_CASE("a plan that is written, evaluated and read is what is sampled") {
  const auto toy = open_toy();
  const Folder folder;
  const PosePlan planned = plan(*toy, few_poses());
  write_plan_folder(*toy, planned, folder.path());
  const DatasetIndex index = read_dataset_index(folder.path());
  CHECK(index.plan);
  {
    const DatasetSource waiting(folder.path());
    REQUIRE(waiting.clips().size() == planned.size());
    for (std::size_t c = 0; c < planned.size(); ++c) CHECK_FALSE(waiting.readable(c));
    REQUIRE(waiting.notes().size() == 1);
    CHECK_MESSAGE(contains(waiting.notes()[0], "are left out: they have no points"), waiting.notes()[0]);
    CHECK(!planned_text(waiting).empty());
  }
  const std::size_t size = toy->rest().points.size();
  const auto write_points = [&](std::size_t c, const std::string& name, std::size_t first, std::size_t count) {
    std::vector<float> points(count * size);
    toy->evaluate(frames_of(planned[c], first, count, toy->schema().control_count()), count, points);
    write_npy(folder / name, {count, size / 3, 3}, points);
  };
  for (std::size_t c = 0; c + 1 < planned.size(); ++c) write_points(c, index.clips[c].points[0], 0, planned[c].frames);
  // The last clip comes in shards, and is readable when all of its frames are there.
  const std::size_t last = planned.size() - 1, half = planned[last].frames / 2;
  write_points(last, shard_name(index.clips[last].points[0], 0), 0, half);
  CHECK_FALSE(DatasetSource(folder.path()).readable(last));
  write_points(last, shard_name(index.clips[last].points[0], 1), half, planned[last].frames - half);
  DatasetSource whole(folder.path());
  CHECK(whole.notes().empty());
  CHECK(planned_text(whole).empty());
  std::vector<float> read(size), evaluated(size);
  for (std::size_t c = 0; c < planned.size(); ++c) {
    REQUIRE(whole.readable(c));
    const std::size_t frame = planned[c].frames - 1;
    whole.read(c, frame, 1, read);
    toy->evaluate(frames_of(planned[c], frame, 1, toy->schema().control_count()), 1, evaluated);
    CHECK(read == evaluated);
  }
  // More frames than there are controls are no plan, but wrong.
  write_points(last, shard_name(index.clips[last].points[0], 2), 0, 1);
  CHECK(contains(failure(Status::bad_data, [&] { DatasetSource again(folder.path()); }), "frames of points"));
}

TEST_CASE("poses are planned from a schema alone") {
  const SchemaFile file;
  SchemaSource source(file.path);
  CHECK(source.rest().vertex_count() == 0);
  const PosePlan planned = plan(source, few_poses());
  std::size_t poses = 0, test = 0;
  for (const Clip& clip : planned) {
    poses += clip.frames;
    test += clip.split == Split::test ? clip.frames : 0;
    REQUIRE(clip.controls.size() == 3 * clip.frames);
    for (std::size_t i = 0; i < clip.controls.size(); ++i) {
      const Control& control = source.schema().controls[i % 3];
      CHECK(clip.controls[i] >= control.minimum);
      CHECK(clip.controls[i] <= control.maximum);
    }
  }
  CHECK(poses == 80 + 20 + 1);
  // Every control alone at both ends of its range.
  const auto excitations = std::ranges::find(planned, "excitations", &Clip::name);
  REQUIRE(excitations != planned.end());
  for (std::size_t c = 0; c < 3; ++c)
    for (const float end : {source.schema().controls[c].minimum, source.schema().controls[c].maximum}) {
      std::vector<float> pose = source.schema().rest_pose();
      if (pose[c] == end) continue;
      pose[c] = end;
      bool there = false;
      for (std::size_t f = 0; f < excitations->frames; ++f)
        there = there || std::ranges::equal(frames_of(*excitations, f, 1, 3), pose);
      CHECK(there);
    }
  CHECK(test == 20);
  CHECK(plan(source, few_poses())[3].controls == planned[3].controls);
  SamplingOptions other = few_poses();
  other.seed = 2;
  CHECK(plan(source, other)[3].controls != planned[3].controls);

  const Folder out;
  write_plan_folder(source, planned, out.path());
  CHECK_FALSE(std::filesystem::exists(out / "rest.npy"));
  CHECK(contains(failure(Status::not_found, [&] { DatasetSource waiting(out.path()); }), "writes the rest mesh too"));
}

TEST_CASE("a plan is kept where it is, and nothing else is overwritten") {
  const SchemaFile file;
  SchemaSource source(file.path);
  const PosePlan planned = plan(source, few_poses());
  const Folder out;
  write_plan_folder(source, planned, out.path());
  std::ofstream(out / "rest_pose.points.npy") << "precious";
  write_plan_folder(source, planned, out.path());
  CHECK(std::filesystem::file_size(out / "rest_pose.points.npy") == 8);
  SamplingOptions other = few_poses();
  other.seed = 2;
  const auto refused = [&](const PosePlan& plan) {
    return failure(Status::invalid_argument, [&] { write_plan_folder(source, plan, out.path()); });
  };
  CHECK(contains(refused(plan(source, other)), "holds another dataset"));
  DatasetIndex index = read_dataset_index(out.path());
  index.plan = false;
  write_dataset_index(out.path(), index);
  CHECK(contains(refused(planned), "holds another dataset"));
}

TEST_CASE("schemas that make no sense are refused by name") {
  const struct {
    const char *from, *to, *message;
  } spoiled[] = {
      {"\"max\": 0", "\"max\": -2", "control \"jaw\": minimum -1 is not below maximum -2"},
      {"\"smile_R\"", "\"smile_L\"", "control name \"smile_L\" occurs twice"},
      {"\"units\": \"cm\", ", "", "units is missing"},
      {"\"units\"", "\"sockets\": [{\"name\": \"pin\", \"vertices\": [0, 1, 2]}], \"units\"", "but no \"rest\""},
      {"\"units\"", "\"rest\": \"none.obj\", \"units\"", "none.obj"}};
  for (const auto& wrong : spoiled) {
    CAPTURE(wrong.message);
    std::string text = schema;
    text.replace(text.find(wrong.from), std::string(wrong.from).size(), wrong.to);
    const SchemaFile file(text);
    try {
      SchemaSource source(file.path);
      FAIL("it was read");
    } catch (const Error& error) {
      CHECK_MESSAGE(contains(error.what(), wrong.message), error.what());
    }
  }
}

}  // namespace test_planned_folder
