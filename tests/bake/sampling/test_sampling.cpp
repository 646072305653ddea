#include "bake/dataset/open_source.h"
#include "bake/sampling/sampling.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <string_view>

#include "bake/dataset/npy.h"
#include "bake/sampling/mirror_partners.h"
#include "bake_test_support.h"
#include "memory_source.h"
#include "watched_progress.h"

namespace test_sampling {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

constexpr std::size_t width = 6;

struct Recorder final : QuietProgress {
  void update(std::uint64_t done) override { last = done; }
  bool cancelled() const override { return last >= stop_at; }
  void note(std::string_view sentence) override { notes.emplace_back(sentence); }
  std::uint64_t last = 0, stop_at = UINT64_MAX;
  std::vector<std::string> notes;
};

const Clip& clip_named(const PosePlan& plan, std::string_view name) {
  const auto found = std::find_if(plan.begin(), plan.end(), [&](const Clip& clip) { return clip.name == name; });
  REQUIRE_MESSAGE(found != plan.end(), std::string(name));
  return *found;
}

PosePlan plan_toy(SamplingOptions options, const Parallel& parallel = {}) {
  return make_plan(*open_toy(), options, parallel, silent_progress());
}

std::vector<std::size_t> active(const Clip& clip, std::size_t frame) {
  static const auto toy = open_toy();
  static const std::vector<float> rest = toy->schema().rest_pose();
  std::vector<std::size_t> controls;
  for (std::size_t c = 0; c < width; ++c)
    if (clip.controls[frame * width + c] != rest[c]) controls.push_back(c);
  return controls;
}

double mean_active(const Clip& clip) {
  std::size_t count = 0;
  for (std::size_t frame = 0; frame < clip.frames; ++frame) count += active(clip, frame).size();
  return static_cast<double>(count) / static_cast<double>(clip.frames);
}

bool same(const Clip& a, const Clip& b) {
  return a.name == b.name && a.kind == b.kind && a.split == b.split && a.controls == b.controls;
}

}  // namespace

TEST_CASE("a plan has the poses asked for, in the kinds of its mix, within all ranges") {
  const struct {
    const char* mix;
    std::map<std::string, std::size_t> frames;
  } mixes[] = {
      {"paper", {{"excitations", 250}, {"calisthenics", 200}, {"regional", 551}}},
      {"dense", {{"excitations", 50}, {"calisthenics", 50}, {"dense", 250}, {"heavy", 201}, {"performances", 450}}},
  };
  const auto toy = open_toy();
  for (const auto& wanted : mixes) {
    const PosePlan plan = plan_toy({.poses = 1001, .mix = wanted.mix});
    std::size_t training = 0;
    for (const Clip& clip : plan) {
      REQUIRE(clip.controls.size() == clip.frames * width);
      for (std::size_t i = 0; i < clip.controls.size(); ++i) {
        const Control& control = toy->schema().controls[i % width];
        REQUIRE(clip.controls[i] >= control.minimum);
        REQUIRE(clip.controls[i] <= control.maximum);
      }
      if (clip.kind != ClipKind::shot) training += clip.frames;
    }
    CHECK(training == 1001);
    CHECK(plan.size() == wanted.frames.size() + 2);
    for (const auto& [name, count] : wanted.frames) CHECK(clip_named(plan, name).frames == count);
    CHECK(clip_named(plan, "talk").split == Split::train);
    CHECK(clip_named(plan, "frown").split == Split::test);
    CHECK(same(clip_named(plan, "frown"), toy->clips()[1]));
  }
}

TEST_CASE("a plan depends on the seed and on nothing else") {
  const SamplingOptions options{.poses = 800, .seed = 3, .mix = "paper"};
  const PosePlan plan = plan_toy(options), again = plan_toy(options, {.threads = 2});
  REQUIRE(plan.size() == again.size());
  for (std::size_t i = 0; i < plan.size(); ++i) CHECK(same(plan[i], again[i]));
  const PosePlan other = plan_toy({.poses = 800, .seed = 4, .mix = "paper"});
  CHECK(same(clip_named(plan, "excitations"), clip_named(other, "excitations")));
  CHECK_FALSE(same(clip_named(plan, "regional"), clip_named(other, "regional")));
  CHECK_FALSE(same(clip_named(plan, "calisthenics"), clip_named(other, "calisthenics")));
  // More poses of a kind begin with the same ones.
  const Clip more = clip_named(plan_toy({.poses = 1600, .seed = 3, .mix = "paper"}), "regional");
  const Clip& few = clip_named(plan, "regional");
  CHECK(std::equal(few.controls.begin(), few.controls.end(), more.controls.begin()));
}

TEST_CASE("excitations move one control at a time over its whole range, most densely where it bends") {
  const auto toy = open_toy();
  const Clip clip = clip_named(plan_toy({.poses = 4800, .mix = "dense"}), "excitations");
  REQUIRE(clip.frames == 240);
  std::vector<std::vector<float>> values(width);
  for (std::size_t frame = 0; frame < clip.frames; ++frame) {
    const std::vector<std::size_t> moved = active(clip, frame);
    REQUIRE(moved.size() == 1);
    values[moved[0]].push_back(clip.controls[frame * width + moved[0]]);
  }
  for (std::size_t c = 0; c < width; ++c) {
    CAPTURE(c);
    const Control& control = toy->schema().controls[c];
    CHECK(std::set<float>(values[c].begin(), values[c].end()).size() == values[c].size());
    CHECK(values[c].back() == control.maximum);
    if (control.rest != control.minimum) CHECK(values[c].front() == control.minimum);
    std::vector<float> knots = values[c];
    knots.push_back(control.rest);
    std::sort(knots.begin(), knots.end());
    float gap = 0;
    for (std::size_t i = 1; i < knots.size(); ++i) gap = std::max(gap, knots[i] - knots[i - 1]);
    CHECK(gap <= (control.maximum - control.minimum) / 8);
  }
  // The jaw turns, mouthWide scales: only the turn gains from more poses.
  CHECK(values[3].size() > 2 * values[5].size());
}

TEST_CASE("with fewer poses than ends of ranges, the controls that move most come first") {
  const Clip clip = clip_named(plan_toy({.poses = 12, .mix = "paper"}), "excitations");
  REQUIRE(clip.frames == 3);
  std::set<std::size_t> moved;
  for (std::size_t frame = 0; frame < 3; ++frame) moved.insert(active(clip, frame).at(0));
  CHECK(moved.size() == 3);
  CHECK(moved.count(3) == 1);  // the jaw
}

TEST_CASE(
    "regional poses use one control group or several, dense ones more controls, heavy ones the group that moves most") {
  const PosePlan paper = plan_toy({.poses = 2000, .mix = "paper"}), dense = plan_toy({.poses = 2000, .mix = "dense"});
  const Clip& regional = clip_named(paper, "regional");
  std::size_t brow_only = 0, mouth_only = 0, both = 0;
  for (std::size_t frame = 0; frame < regional.frames; ++frame) {
    const std::vector<std::size_t> moved = active(regional, frame);
    const bool brow = !moved.empty() && moved.front() < 3, mouth = !moved.empty() && moved.back() >= 3;
    brow_only += brow && !mouth;
    mouth_only += mouth && !brow;
    both += brow && mouth;
  }
  CHECK(brow_only > regional.frames / 6);
  CHECK(mouth_only > regional.frames / 6);
  CHECK(both > regional.frames / 4);

  const Clip &spread = clip_named(dense, "dense"), &heavy = clip_named(dense, "heavy");
  CHECK(mean_active(spread) > 0.25 * width);
  CHECK(mean_active(spread) < 0.6 * width);
  std::size_t brow = 0, mouth = 0;
  for (std::size_t frame = 0; frame < heavy.frames; ++frame)
    for (const std::size_t c : active(heavy, frame)) ++(c < 3 ? brow : mouth);
  CHECK(mouth > 1.5 * brow);
  // All the way happens, and so does everything between.
  std::size_t full = 0, part = 0;
  for (std::size_t frame = 0; frame < spread.frames; ++frame) {
    full += spread.controls[frame * width + 3] == 1;
    part += spread.controls[frame * width + 3] > 0 && spread.controls[frame * width + 3] < 1;
  }
  CHECK(full > 20);
  CHECK(part > 5 * full / 2);
}

TEST_CASE("excitations are dense where a response bends, not elsewhere") {
  MemorySource rig(
      1, 3,
      [](const float* c, std::span<float> points) {
        for (float& value : points) value += 4 * std::pow(std::max(c[0] - 0.5f, 0.0f), 2);
      },
      true);
  const Clip clip = clip_named(make_plan(rig, {.poses = 2000}, {}, silent_progress()), "excitations");
  const auto between = [&](float low, float high) {
    return std::count_if(clip.controls.begin(), clip.controls.end(), [&](float v) { return v >= low && v < high; });
  };
  CHECK(between(0.5f, 2) > 2 * between(-1, -0.5f));
}

TEST_CASE("opposed controls are seldom active together, and no group is active as a whole") {
  // Twenty controls in two groups of ten; in each, 0 and 2 (1 and 3) push the same vertices apart.
  MemorySource rig(
      20, 5,
      [](const float* c, std::span<float> points) {
        for (std::size_t i = 0; i < points.size(); ++i)
          for (std::size_t k = 0; k < 20; ++k)
            points[i] +=
                (k == 2 || k == 3 ? -c[k] * std::sin(float((k - 1) * i)) : c[k] * std::sin(float((k + 1) * i)));
      },
      true);
  std::size_t against = 0, together = 0, most = 0;
  for (const char* mix : {"paper", "dense"})
    for (const Clip& clip : make_plan(rig, {.poses = 1000, .mix = mix, .test_poses = false}, {}, silent_progress())) {
      if (clip.kind == ClipKind::excitation || clip.kind == ClipKind::calisthenics) continue;
      for (std::size_t frame = 0; frame < clip.frames; ++frame) {
        const float* pose = clip.controls.data() + frame * 20;
        std::size_t moved[2] = {};
        for (std::size_t c = 0; c < 20; ++c) moved[c % 2] += pose[c] != 0;
        if (clip.kind == ClipKind::regional) most = std::max({most, moved[0], moved[1]});
        for (const float product : {pose[0] * pose[2], pose[1] * pose[3]}) {
          against += product > 0;
          together += product < 0;
        }
      }
    }
  CHECK(together > 200);
  CHECK(against > 0);
  CHECK(2 * against < together);
  CHECK(most == 8);
}

TEST_CASE("heavy poses go to every group by its share of the motion, calisthenics to all in turn") {
  // Three groups of eight controls; the second moves most, the third least.
  MemorySource rig(
      24, 4,
      [](const float* c, std::span<float> points) {
        constexpr float sizes[] = {0.5f, 1.0f, 0.4f};
        for (std::size_t k = 0; k < 24; ++k) points[k] += sizes[k / 8] * c[k];
      },
      true);
  std::vector<Control>& controls = rig.edit_schema().controls;
  for (std::size_t c = 0; c < 24; ++c) controls[c].group = std::to_string(c / 8);
  const PosePlan plan = make_plan(rig, {.poses = 3840}, {}, silent_progress());
  const auto moved = [](const Clip& clip, std::size_t frame, std::size_t group) {
    const float* first = clip.controls.data() + frame * 24 + group * 8;
    return std::count_if(first, first + 8, [](float value) { return value != 0; });
  };
  const Clip& heavy = clip_named(plan, "heavy");
  long counts[3] = {};
  for (std::size_t frame = 0; frame < heavy.frames; ++frame)
    for (std::size_t group = 0; group < 3; ++group) counts[group] += moved(heavy, frame, group);
  CHECK(counts[1] > 1.2 * double(counts[0]));
  CHECK(counts[0] > 1.02 * double(counts[2]));
  const Clip walks = clip_named(make_plan(rig, {.poses = 5760, .mix = "paper"}, {}, silent_progress()), "calisthenics");
  REQUIRE(walks.frames == 12 * 96);
  for (std::size_t walk = 0; walk < 12; ++walk) CHECK(moved(walks, walk * 96 + 50, walk % 3) > 0);
}

TEST_CASE("the other side of a control is known by its name") {
  using Names = std::vector<std::string>;
  CHECK(other_side_names("smile_L") == Names{"smile_R"});
  CHECK(other_side_names("browDownR") == Names{"browDownL"});
  CHECK(other_side_names("oris04.L.rx") == Names{"oris04.R.rx"});
  CHECK(other_side_names("lipFunneler_LB") == Names{"lipFunneler_RB"});
  CHECK(other_side_names("lip_upper_L3_full") == Names{"lip_upper_R3_full"});
  CHECK(other_side_names("MouthLeftPullUp") == Names{"MouthRightPullUp"});
  CHECK(other_side_names("eye-left-slit") == Names{"eye-right-slit"});
  CHECK(other_side_names("RIGHT_BROW") == Names{"LEFT_BROW"});
  CHECK(other_side_names("eyesLookLeft_L") == Names{"eyesLookLeft_R", "eyesLookRight_L", "eyesLookRight_R"});
  for (const char* middle : {"jawDrop", "LidLower", "upright", "NeckURL", "tongue_1", ""})
    CHECK_MESSAGE(other_side_names(middle).empty(), middle);

  RigSchema schema;
  for (const char* name : {"jawLeft", "look_R", "jawRight", "lookLeft_R", "lookRight_R", "look_L", "lookLeft_L"})
    schema.controls.push_back({name, 0, 1, 0, ""});
  const auto partners = mirror_partners(schema, [](std::size_t a, std::size_t b) { return a + b == 2 || a + b == 7; });
  CHECK_FALSE(partners[0]);  // left and right work against each other
  CHECK_FALSE(partners[2]);
  CHECK(partners[1] == std::optional<std::size_t>(5));
  CHECK(partners[5] == std::optional<std::size_t>(1));
  CHECK(partners[3] == std::optional<std::size_t>(6));
  CHECK_FALSE(partners[4]);
}

TEST_CASE("performances move both sides of the face, many controls strongly together, seldom opposed") {
  // Forty controls in pairs; numbers 0 and 4 push the same vertices apart, as do 1 and 5.
  MemorySource rig(
      40, 8,
      [](const float* c, std::span<float> points) {
        for (std::size_t k = 0; k < 40; ++k) points[3 * k] += c[k];
        points[3] -= 3 * c[1];
        points[0] -= 1.5f * c[0];
        points[0] += 0.1f * c[4];
        points[12] -= 1.2f * c[0];
        points[15] -= 1.2f * c[1];
      },
      true);
  std::vector<Control>& controls = rig.edit_schema().controls;
  for (std::size_t k = 0; k < 40; ++k)
    controls[k] = {format("c%zu_%c", k / 2, k % 2 ? 'R' : 'L'), 0, 1, 0, std::to_string(k / 10)};
  const PosePlan plan = make_plan(rig, {.poses = 4000}, {}, silent_progress());
  const auto both_sides = [&](const Clip& clip) {
    std::size_t one = 0, both = 0;
    for (std::size_t f = 0; f < clip.frames; ++f)
      for (std::size_t k = 0; k < 40; k += 2) {
        const float l = clip.controls[f * 40 + k], r = clip.controls[f * 40 + k + 1];
        one += std::max(l, r) >= 0.6f;
        both += std::min(l, r) >= 0.4f;
      }
    return double(both) / double(one);
  };
  const Clip& performances = clip_named(plan, "performances");
  REQUIRE(performances.frames == 1800);
  CHECK(both_sides(performances) > 0.6);
  CHECK(both_sides(clip_named(plan, "heavy")) < 0.5);
  std::size_t few = 0, many = 0, ends = 0, against = 0, together = 0;
  for (std::size_t f = 0; f < performances.frames; ++f) {
    const float* pose = performances.controls.data() + f * 40;
    const auto far = std::count_if(pose, pose + 40, [](float value) { return value >= 0.6f; });
    few += far >= 1 && far <= 3;
    many += far >= 10;
    ends += static_cast<std::size_t>(std::count(pose, pose + 40, 1.0f));
    against += pose[0] > 0.4f && pose[4] > 0.4f;
    together += pose[0] > 0.4f && pose[2] > 0.4f;
  }
  CHECK(few > performances.frames / 4);
  CHECK(many > performances.frames / 50);
  CHECK(ends > performances.frames / 5);
  CHECK(2 * against < together);
}

TEST_CASE("calisthenics are smooth within a sequence and reach the ends of ranges") {
  const auto toy = open_toy();
  const Clip clip = clip_named(plan_toy({.poses = 1920, .mix = "paper"}), "calisthenics");
  REQUIRE(clip.frames == 4 * 96);
  std::vector<std::size_t> at_end(width);
  for (std::size_t frame = 0; frame < clip.frames; ++frame)
    for (std::size_t c = 0; c < width; ++c) {
      const Control& control = toy->schema().controls[c];
      const float value = clip.controls[frame * width + c];
      at_end[c] += value == control.maximum;
      if (frame % 96 == 0) continue;
      const float step = std::abs(value - clip.controls[(frame - 1) * width + c]);
      CHECK(step <= 0.15f * (control.maximum - control.minimum));
    }
  for (std::size_t c = 0; c < width; ++c) CHECK(at_end[c] > 0);
}

TEST_CASE("a rig without test clips gets test poses that no training pose equals") {
  const auto toy = open_toy();
  const PosePlan plan = plan_toy({.poses = 3000, .shots = false});
  std::set<std::vector<float>> training;
  std::size_t tested = 0;
  for (const Clip& clip : plan)
    if (clip.split != Split::test)
      for (std::size_t f = 0; f < clip.frames; ++f)
        training.insert({clip.controls.begin() + long(f * width), clip.controls.begin() + long((f + 1) * width)});
  for (const char* name : {"random_15", "random_35", "synthetic_shots"}) {
    const Clip& clip = clip_named(plan, name);
    CHECK(clip.split == Split::test);
    tested += clip.frames;
    std::size_t known = 0;
    for (std::size_t f = 0; f < clip.frames; ++f)
      if (active(clip, f).size() > 1)
        known +=
            training.count({clip.controls.begin() + long(f * width), clip.controls.begin() + long((f + 1) * width)});
    CHECK(known == 0);
  }
  CHECK(tested == 2000);
  CHECK(mean_active(clip_named(plan, "random_15")) == doctest::Approx(0.15 * width).epsilon(0.1));
  CHECK(mean_active(clip_named(plan, "random_35")) == doctest::Approx(0.35 * width).epsilon(0.1));
  const Clip &few = clip_named(plan, "random_15"), &many = clip_named(plan, "random_35");
  std::size_t alike = 0;  // they are drawn apart from each other
  for (std::size_t i = 0; i < few.controls.size(); ++i)
    alike += few.controls[i] != toy->schema().controls[i % width].rest && few.controls[i] == many.controls[i];
  CHECK(alike == 0);
  const Clip& shots = clip_named(plan, "synthetic_shots");
  CHECK(shots.kind == ClipKind::shot);
  for (std::size_t f = 1; f < shots.frames; ++f)
    if (f % 40 != 0)
      for (std::size_t c = 0; c < width; ++c)
        CHECK(std::abs(shots.controls[f * width + c] - shots.controls[(f - 1) * width + c]) <= 0.4f);
  CHECK(same(make_test_poses(toy->schema(), 1)[0], clip_named(plan, "random_15")));
  CHECK_FALSE(same(make_test_poses(toy->schema(), 2)[0], clip_named(plan, "random_15")));
}

TEST_CASE("clips of the user are added, clamped, and refused where they are invalid") {
  const Folder folder;
  const auto toy = open_toy();
  std::vector<float> values(2 * width, 0.25f);
  values[3] = 1.5f;
  write_npy(folder / "smile.npy", {2, width}, values);
  const Clip smile = read_clip("smile", folder / "smile.npy", toy->schema());
  Recorder recorder;
  const PosePlan plan = make_plan(*toy, {.poses = 100, .extra = {smile}}, {}, recorder);
  CHECK(clip_named(plan, "smile").controls[3] == 1);
  CHECK(clip_named(plan, "smile").controls[4] == 0.25f);
  REQUIRE(recorder.notes.size() == 1);
  CHECK(recorder.notes[0] == "clip \"smile\": 1 values outside their range were clamped");
  CHECK(contains(failure(Status::invalid_argument,
                         [&] {
                           plan_toy({.poses = 100, .extra = {smile, smile}});
                         }),
                 "two clips are called \"smile\""));
  values[7] = NAN;
  write_npy(folder / "nan.npy", {2, width}, values);
  CHECK(contains(failure(Status::not_finite, [&] { read_clip("nan", folder / "nan.npy", toy->schema()); }),
                 "clip \"nan\", frame 1: control \"browTwist\" is not finite"));
  write_npy(folder / "thin.npy", {3, 4}, std::span(values).first(12));
  CHECK(contains(failure(Status::bad_data, [&] { read_clip("thin", folder / "thin.npy", toy->schema()); }),
                 "shape (3, 4) where (frames, 6) is needed"));
}

TEST_CASE("what cannot be planned is refused") {
  CHECK(contains(failure(Status::invalid_argument, [] { plan_toy({.mix = "soup"}); }), "\"soup\" is no mix of poses"));
  failure(Status::invalid_argument, [] { plan_toy({.poses = 0}); });
  const auto faulty = open_faulty_rig("fails on a pose");
  CHECK(contains(
      failure(Status::rig, [&] { make_plan(*faulty, {}, {}, silent_progress()); }),
      "control \"browTwist\" moved alone, value 2 of 5: rig \"toy\" failed: the twist solver did not converge"));
}

TEST_CASE("a sampled dataset holds what the rig evaluates") {
  const Folder folder;
  const auto toy = open_toy();
  const SampleReport report = sample(*toy, {.poses = 500}, folder.path(), {}, silent_progress());
  CHECK(report.poses == 524);
  CHECK(report.evaluated == 524);
  const auto recorded = open_source(folder.path());
  CHECK(recorded->notes().empty());
  CHECK(recorded->rest().points == toy->rest().points);
  CHECK(recorded->rest().polygon_corners == toy->rest().polygon_corners);
  CHECK(recorded->schema().controls[2].group == "brow");
  const PosePlan plan = plan_toy({.poses = 500});
  REQUIRE(recorded->clips().size() == plan.size());
  for (std::size_t i = 0; i < plan.size(); ++i) {
    CHECK(same(recorded->clips()[i], plan[i]));
    std::vector<float> read(plan[i].frames * 150), evaluated(read.size());
    recorded->read(i, 0, plan[i].frames, read);
    toy->evaluate(plan[i].controls, plan[i].frames, evaluated);
    CHECK(read == evaluated);
  }
}

TEST_CASE("the bytes on the disk do not depend on the threads") {
  const Folder one, two;
  sample(*open_toy(), {.poses = 700}, one.path(), {.threads = 1}, silent_progress());
  sample(*open_toy(), {.poses = 700}, two.path(), {.threads = 2}, silent_progress());
  CHECK(files_of(one.path()) == files_of(two.path()));
}

// Cuts the plan into small shards: what a slow rig or a large mesh would get.
static void shorten_shards(const std::filesystem::path& folder, Source& rig, const PosePlan& plan) {
  Recorder stop;
  stop.stop_at = 1;
  failure(Status::interrupted, [&] { sample_to_dataset(rig, plan, folder, {}, stop); });
  std::ifstream in(folder / "dataset.json");
  std::string json(std::istreambuf_iterator<char>(in), {});
  const std::size_t at = json.find("\"shard_frames\": ");
  REQUIRE(at != std::string::npos);
  json.replace(at, json.find_first_of(",\n}", at) - at, "\"shard_frames\": 32");
  std::ofstream(folder / "dataset.json") << json;
}

TEST_CASE("interrupted sampling continues where it stopped") {
  const Folder folder;
  const auto toy = open_toy();
  const PosePlan plan = plan_toy({.poses = 300, .mix = "paper"});
  shorten_shards(folder.path(), *toy, plan);
  Recorder stop;
  stop.stop_at = 150;
  CHECK(
      contains(failure(Status::interrupted, [&] { sample_to_dataset(*toy, plan, folder.path(), {}, stop); }), "kept"));
  std::size_t shards = 0;
  for (const auto& file : files_of(folder.path())) {
    CHECK_MESSAGE(!contains(file.first, "partial"), file.first);
    shards += contains(file.first, ".points.npy");
  }
  CHECK(shards >= 4);
  std::filesystem::resize_file(folder / "excitations.001.points.npy", 1000);  // as a full disk might leave it
  const SampleReport rest = sample_to_dataset(*toy, plan, folder.path(), {}, silent_progress());
  CHECK(rest.poses == 324);
  CHECK(rest.evaluated > 150);
  CHECK(rest.evaluated < 260);
  const auto whole = files_of(folder.path());
  CHECK(whole.count("regional.005.points.npy") == 1);
  const SampleReport nothing = sample_to_dataset(*toy, plan, folder.path(), {}, silent_progress());
  CHECK(nothing.evaluated == 0);
  CHECK(files_of(folder.path()) == whole);
}

TEST_CASE("the same request does nothing, another is refused") {
  const Folder folder;
  const auto toy = open_toy();
  const SamplingOptions options{.poses = 100};
  sample(*toy, options, folder.path(), {}, silent_progress());
  const auto before = files_of(folder.path());
  CHECK(sample(*toy, options, folder.path(), {}, silent_progress()).evaluated == 0);
  for (const SamplingOptions& other : {SamplingOptions{.poses = 101}, SamplingOptions{.poses = 100, .seed = 2},
                                       SamplingOptions{.poses = 100, .mix = "paper"}})
    CHECK(
        contains(failure(Status::invalid_argument, [&] { sample(*toy, other, folder.path(), {}, silent_progress()); }),
                 "holds another dataset"));
  CHECK(files_of(folder.path()) == before);
  // A plan that lost a file of controls is made again.
  std::filesystem::remove(folder / "dense.controls.npy");
  std::filesystem::remove(folder / "dense.points.npy");
  CHECK(sample(*toy, options, folder.path(), {}, silent_progress()).evaluated == 25);
  CHECK(files_of(folder.path()) == before);
  // Eight poses are evaluated again.
  RigEvaluator evaluator(*toy);
  sample(evaluator, options, folder.path(), silent_progress());
  CHECK(evaluator.evaluated() == 8);
  // The same declarations, but vertex 0 elsewhere in some poses.
  const auto changed = open_faulty_rig("other shape");
  CHECK(contains(
      failure(Status::invalid_argument, [&] { sample(*changed, options, folder.path(), {}, silent_progress()); }),
      "elsewhere now"));
}

TEST_CASE("a rig that fails while it is sampled is named with the number of the pose in the plan") {
  const Folder folder;
  const auto faulty = open_faulty_rig("fails on a pose");
  PosePlan plan = {{"good", ClipKind::dense, Split::train, 30, 12000, std::vector<float>(12000 * width)},
                   {"bad", ClipKind::dense, Split::train, 30, 500, std::vector<float>(500 * width)}};
  plan[1].controls[345 * width + 1] = -0.5f;
  CHECK(contains(failure(Status::rig, [&] { sample_to_dataset(*faulty, plan, folder.path(), {}, silent_progress()); }),
                 "pose 12345 (clip \"bad\", frame 345): rig \"toy\" failed: the twist solver did not converge"));
  CHECK(files_of(folder.path()).count("good.points.npy") == 1);
  CHECK(files_of(folder.path()).count("bad.points.npy") == 0);
  CHECK(contains(failure(Status::not_found, [&] { open_source(folder.path()); }),
                 "bad.points.npy: no such file: sampling stopped before it"));
}

TEST_CASE("folders that cannot be written are named") {
  const auto toy = open_toy();
  const PosePlan plan = plan_toy({.poses = 20});
  CHECK(contains(failure(Status::io, [&] { sample_to_dataset(*toy, plan, "/dev/null/here", {}, silent_progress()); }),
                 "/dev/null/here"));
  const Folder folder;
  std::ofstream(folder / "dataset.json") << "{}";
  failure(Status::bad_data, [&] { sample_to_dataset(*toy, plan, folder.path(), {}, silent_progress()); });
}

}  // namespace test_sampling
