#include "bake/pipeline/bake.h"

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "archive/reader.h"
#include "archive/writer.h"
#include "bake/measure/evaluate.h"
#include "bake/measure/verify.h"
#include "bake/pipeline/compare.h"
#include "base/file.h"
#include "base/status.h"
#include "toy_faces.h"
#include "watched_progress.h"

namespace test_recipes {

using namespace fb;
using namespace fb::archive;
using namespace fb::bake;

namespace {

struct StopIn final : test::QuietProgress {
  explicit StopIn(std::string_view stage) : wanted(stage) {}
  void begin(Phase, std::string_view stage, std::uint64_t) override { inside = stage == wanted; }
  void update(std::uint64_t done) override { stopped = stopped || (inside && done > 10); }
  bool cancelled() const override { return stopped; }
  std::string_view wanted;
  bool inside = false, stopped = false;
};

}  // namespace

TEST_CASE("linear blendshapes reproduce a linear face, asked or found in recordings") {
  WorkFolder folder;
  for (const float active : {0.2f, 0.7f}) {  // alone often enough, and too rarely: the rest is fitted
    MemorySource source = face_of(linear_formula);
    source.add_clip("poses", ClipKind::dense, Split::train, active < 0.5f ? 400 : 60, active, 1);
    source.add_clip("unseen", ClipKind::shot, Split::test, 100, 0.6f, 2);
    const Baked baked = bake_face(source, options_in(folder, "linear"), silent_progress());
    CHECK(baked.coefficients == 8);
    CHECK(baked.parameters == 0);
    CHECK(unseen_mse(baked.archive, source) < (active < 0.5f ? 1e-10 : 1e-6));
  }
  MemorySource rig = face_of(linear_formula, true);
  rig.add_clip("unseen", ClipKind::shot, Split::test, 100, 0.6f, 2);
  BakeOptions options = options_in(folder, "linear");
  options.poses = 30;
  CHECK(unseen_mse(bake_face(rig, options, silent_progress()).archive, rig) < 1e-10);
}

TEST_CASE("a live rig that is linear is baked from few poses where nobody says how many") {
  WorkFolder folder;
  MemorySource rig = face_of(linear_formula, true);
  BakeOptions options = options_in(folder, "compact");
  options.poses = 0;
  const Baked baked = bake_face(rig, options, silent_progress());
  CHECK(baked.poses == 2000);
  CHECK(baked.held_back.total.frames > 30);
  CHECK(baked.held_back.total.max < 1e-4);
}

TEST_CASE("a bake keeps to the bytes asked for, or to the error, or says what it reached") {
  const WorkFolder folder;
  MemorySource source(4, 20, linear_formula);
  source.add_clip("dense", ClipKind::dense, Split::train, 300, 0.3f, 1);
  source.add_clip("unseen", ClipKind::shot, Split::test, 60, 0.6f, 2);
  BakeOptions options = options_in(folder, "linear");
  const Baked free = bake_face(source, options, silent_progress());
  const double error = evaluate_archive(free.archive, source, Split::test, {}, silent_progress()).total.max;

  test::Notes notes;
  options.max_bytes = free.archive.size() * 9 / 10;
  const Baked small = bake_face(source, options, notes);
  CHECK(small.archive.size() <= options.max_bytes);
  CHECK(small.archive.size() > options.max_bytes / 2);
  const double grown = evaluate_archive(small.archive, source, Split::test, {}, silent_progress()).total.max;
  CHECK(grown > 0.99 * error);  // most of which the recipe leaves anyway
  CHECK(notes.all.find("asked") == std::string::npos);

  options.max_bytes = 0;
  options.max_error = 2 * grown;
  const Baked rough = bake_face(source, options, notes);
  CHECK(rough.archive.size() <= small.archive.size());
  const auto kept = evaluate_archive(rough.archive, source, Split::train, {}, silent_progress());
  CHECK(kept.total.max < 4 * grown);
  CHECK(notes.all.find("asked") == std::string::npos);

  options.max_bytes = 10;
  CHECK_THROWS_WITH(bake_face(source, options, notes),
                    doctest::Contains("asked for 10 bytes, the smallest reached is "));
  CHECK(notes.all.find("asked") == std::string::npos);
  options.force = true;
  const Baked forced = bake_face(source, options, notes);
  CHECK(forced.archive.size() > 10);
  REQUIRE(forced.warnings.size() >= 2);
  CHECK(forced.warnings.front().find("asked for 10 bytes, the smallest reached is ") == 0);
  CHECK(forced.warnings.back().find("with its certificate, more than the 10 asked for") != std::string::npos);
  CHECK(notes.all.find("warning: " + forced.warnings[0]) != std::string::npos);

  options.recipe = "paper";
  CHECK_THROWS_WITH(bake_face(source, options, notes), doctest::Contains("\"paper\" supports neither"));
  options.max_bytes = 0;
  options.max_error = -1;
  CHECK_THROWS_WITH(bake_face(source, options, notes), doctest::Contains("-1"));
}

TEST_CASE("an error that was asked for holds in every pose that nothing was fitted to, or the bake fails") {
  // Beyond what the training poses reach, the rig bends.
  const auto bent = [](const float* controls, std::span<float> points) {
    const float beyond = std::max(0.0f, std::fabs(controls[0]) - 0.5f);
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (std::size_t k = 0; k < 4; ++k) points[i] += 0.4f * controls[k] * std::sin(float(i * (k + 1)));
      points[i] += beyond * std::cos(float(i));
    }
  };
  MemorySource source(4, 20, bent);
  source.add_clip("dense", ClipKind::dense, Split::train, 300, 0.3f, 1);
  source.add_clip("unseen", ClipKind::shot, Split::test, 60, 0.3f, 2);
  for (std::size_t clip = 0; clip < 2; ++clip)
    for (std::size_t f = 0; f < source.clips()[clip].frames; ++f) {
      float& value = source.edit_clip(clip).controls[4 * f];
      value = std::clamp(value, -0.5f, 0.5f);
    }
  const WorkFolder folder;
  BakeOptions options = options_in(folder, "linear");
  options.max_error = 1e-2;
  test::Notes notes;
  const Baked kept = bake_face(source, options, notes);
  CHECK(kept.independent->total.max <= options.max_error);
  CHECK(notes.all.find("no vertex of the 60 poses that nothing was trained on is off by more than 0.01") !=
        std::string::npos);
  source.edit_clip(1).controls[4 * 7] = 1;
  CHECK_THROWS_WITH(bake_face(source, options, notes),
                    doctest::Contains("but in the 60 poses that nothing was trained on the worst vertex is off by"));
  options.force = true;
  const Baked forced = bake_face(source, options, notes);
  CHECK(forced.independent->total.max > options.max_error);
  REQUIRE(!forced.warnings.empty());
  CHECK(forced.warnings[0].find("asked for an error of 0.01 of the diagonal, but in the 60 poses") == 0);
}

TEST_CASE("what is written is what was verified, and a failure at the end keeps the old file and the work") {
  const WorkFolder folder;
  const std::filesystem::path out = folder.path / "face.fbk", partial = out.string() + ".facebaker-partial";
  MemorySource source(4, 20, linear_formula);
  source.add_clip("dense", ClipKind::dense, Split::train, 100, 0.3f, 1);
  source.add_clip("unseen", ClipKind::shot, Split::test, 20, 0.6f, 2);
  BakeOptions options = options_in(folder, "linear");
  options.work.clear();
  make_folder(folder.path);
  write_file(out, std::string("old"));
  const auto old = read_file(out);
  // Occupies the name of the temporary file when the packed model is measured: the last step cannot write.
  struct Occupy final : test::QuietProgress {
    explicit Occupy(std::filesystem::path path) : path(std::move(path)) {}
    void begin(Phase, std::string_view stage, std::uint64_t) override {
      if (stage == "measuring") std::filesystem::create_directories(path);
    }
    std::filesystem::path path;
  } occupy(partial);
  CHECK_THROWS_WITH(bake_to_file(source, out, options, occupy), doctest::Contains("cannot be written"));
  CHECK(read_file(out) == old);
  CHECK(std::filesystem::exists(out.string() + ".work"));
  std::filesystem::remove(partial);

  const Baked baked = bake_to_file(source, out, options, silent_progress());
  CHECK(read_file(out) == baked.archive);
  CHECK(verify_archive(baked.archive).poses > 0);
  CHECK_FALSE(std::filesystem::exists(out.string() + ".work"));
  // One certificate, of the model that was written.
  const auto certificate = nlohmann::json::parse(read_archive(baked.archive).text.certificate);
  const Errors errors = evaluate_archive(baked.archive, source, Split::test, {}, silent_progress()).total;
  CHECK(certificate["independent"]["max"].get<double>() == doctest::Approx(errors.max).epsilon(1e-5));
}

TEST_CASE("the paper's network beats linear blendshapes on a face with a corrective") {
  WorkFolder folder;
  MemorySource source = curved_face();
  const Baked linear = bake_face(source, options_in(folder, "linear"), silent_progress());
  BakeOptions options = options_in(folder);
  options.epochs = 150;
  const Baked paper = bake_face(source, options, silent_progress());
  CHECK(unseen_mse(paper.archive, source) < 0.5 * unseen_mse(linear.archive, source));
  CHECK(paper.poses == 256);
  CHECK(paper.quantisation.max < 1e-4);
  CHECK(paper.quantisation.max > 1e-8);
  CHECK(paper.quantisation.rms < paper.quantisation.max);
  CHECK(paper.quantisation.mse > 0);
  const PackedModel model = read_archive(paper.archive).model;
  REQUIRE(model.regions.size() == 1);
  CHECK(model.regions[0].layers.size() == 9);
  CHECK(model.regions[0].layers[7].skip);
  CHECK(verify_archive(paper.archive).poses > 0);
}

TEST_CASE("an archive is the same bytes whatever the threads, and after an interruption") {
  WorkFolder once, twice, stopped;
  MemorySource source = curved_face();
  BakeOptions options = options_in(once);
  options.parallel.threads = 1;
  const std::vector<std::byte> whole = bake_face(source, options, silent_progress()).archive;
  options = options_in(twice);
  options.parallel.threads = 3;
  CHECK(bake_face(source, options, silent_progress()).archive == whole);
  for (const char* stage : {"finding blendshapes", "training"}) {
    StopIn progress(stage);
    CHECK_THROWS_AS(bake_face(source, options_in(stopped), progress), Error);
  }
  CHECK(bake_face(source, options_in(stopped), silent_progress()).archive == whole);
}

TEST_CASE("a bake in the work folder of other data takes nothing from it") {
  WorkFolder once, shared;
  MemorySource source = curved_face(), other = curved_face();
  float& control = other.edit_clip(0).controls[4];  // of a pose the sample of the data does not show
  control = control == 0.5f ? 0.25f : 0.5f;
  bake_face(source, options_in(shared), silent_progress());
  CHECK(bake_face(other, options_in(shared), silent_progress()).archive ==
        bake_face(other, options_in(once), silent_progress()).archive);
}

TEST_CASE("a proof holds the rest pose, the ends of all ranges and dense poses") {
  const MemorySource source = curved_face();
  PackedModel model;
  model.schema = source.schema();
  model.rest = source.rest();
  model.row_blocks = {{0, static_cast<std::uint32_t>(model.rest.points.size()), {}, {}}};
  const Proof proof = make_proof(model, 1);
  REQUIRE(proof.controls.size() > 4 * 4);
  CHECK(std::vector<float>(proof.controls.begin(), proof.controls.begin() + 12) ==
        std::vector<float>{0, 1, -2, 0, 1, 3, 0, 1, -1, 0, -4, -1});
  CHECK(proof.hashes.size() == proof.controls.size() / 4);
  CHECK(proof.vertices.size() == 16);
  CHECK(proof.positions.size() == proof.hashes.size() * 16 * 3);
}

TEST_CASE("a variant never reads a shot, and only the certificate a test clip, which changes nothing else") {
  struct Watched final : MemorySource {
    explicit Watched(MemorySource source) : MemorySource(std::move(source)) {}
    std::string read_clips;
    void read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) override {
      if (read_clips.find(clips()[clip].name) == std::string::npos) read_clips += clips()[clip].name + " ";
      MemorySource::read(clip, first, count, points);
    }
  };
  Watched source(face_of(curved_formula, false, 6));
  source.add_clip("dense", ClipKind::dense, Split::train, 150, 0.6f, 1);
  source.add_clip("shot", ClipKind::shot, Split::train, 50, 0.5f, 2);
  source.add_clip("validation", ClipKind::shot, Split::validation, 50, 0.5f, 3);
  source.add_clip("unseen", ClipKind::shot, Split::test, 50, 0.5f, 4);
  WorkFolder folder;
  BakeOptions options = options_in(folder);
  options.epochs = 1;
  options.use = Use::variant;
  const Baked variant = bake_face(source, options, silent_progress());
  CHECK(variant.poses == 150);
  CHECK(source.read_clips == "dense unseen ");
  options.use = Use::backlot;
  CHECK(bake_face(source, options, silent_progress()).poses == 200);
  CHECK(source.read_clips == "dense unseen shot ");

  MemorySource other = face_of(curved_formula, false, 6);
  other.add_clip("dense", ClipKind::dense, Split::train, 150, 0.6f, 1);
  other.add_clip("unseen", ClipKind::shot, Split::test, 20, 0.2f, 5);
  WorkFolder elsewhere;
  BakeOptions same = options_in(elsewhere);
  same.epochs = 1;
  same.use = Use::variant;
  const Archive a = read_archive(variant.archive), b = read_archive(bake_face(other, same, silent_progress()).archive);
  CHECK(a.text.certificate != b.text.certificate);
  CHECK(a.text.certificate.find("\"unseen\"") != std::string::npos);
  CHECK(write_archive(a.model, a.proof) == write_archive(b.model, b.proof));
}

TEST_CASE("compare reports every method as variant and backlot, measured on unseen clips alone") {
  WorkFolder folder;
  MemorySource source = curved_face();
  BakeOptions options = options_in(folder);
  options.epochs = 150;
  const CompareReport report = compare(source, {"linear", "paper"}, options, silent_progress());
  REQUIRE(report.methods.size() == 4);
  for (const MethodReport& method : report.methods) {
    REQUIRE(method.independent.clips.size() == 1);
    CHECK(method.independent.clips[0].name == "unseen");
    CHECK(method.independent.total.frames == 200);
    CHECK(method.dependency.frames == (method.use == "variant" ? 200 : 256));
    CHECK(!method.archive.empty());
  }
  CHECK(report.methods[1].name == "paper");
  CHECK(report.methods[1].use == "variant");
  CHECK(report.methods[1].independent.total.mse < report.methods[0].independent.total.mse);
}

TEST_CASE("what cannot be baked or compared is refused by name") {
  WorkFolder folder;
  MemorySource source = curved_face();
  CHECK_THROWS_WITH(bake_face(source, options_in(folder, "papre"), silent_progress()), doctest::Contains("\"papre\""));
  CHECK_THROWS_WITH(compare(source, {"linear", "nonsense"}, options_in(folder), silent_progress()),
                    doctest::Contains("\"nonsense\""));

  MemorySource untested = face_of(curved_formula, false, 6);
  untested.add_clip("dense", ClipKind::dense, Split::train, 30, 0.6f, 1);
  CHECK_THROWS_WITH(compare(untested, {"linear"}, options_in(folder), silent_progress()),
                    doctest::Contains("no test split"));
  MemorySource only_tests(4, 6, curved_formula);
  only_tests.add_clip("unseen", ClipKind::shot, Split::test, 30, 0.6f, 1);
  CHECK_THROWS_WITH(compare(only_tests, {"linear"}, options_in(folder), silent_progress()),
                    doctest::Contains("split train"));
  CHECK_THROWS_WITH(compare(source, {}, options_in(folder), silent_progress()), doctest::Contains("no method"));
  MemorySource only_shots = face_of(curved_formula, false, 6);
  only_shots.add_clip("shot", ClipKind::shot, Split::train, 30, 0.6f, 1);
  BakeOptions variant = options_in(folder);
  variant.use = Use::variant;
  CHECK_THROWS_WITH(bake_face(only_shots, variant, silent_progress()), doctest::Contains("not a shot"));
}

TEST_CASE("an archive is measured only against its own face") {
  WorkFolder folder;
  MemorySource source = curved_face();
  const Baked baked = bake_face(source, options_in(folder, "linear"), silent_progress());
  MemorySource larger = face_of(curved_formula, false, 9), wider(5, 8, curved_formula), bent = curved_face();
  bent.edit_rest().points[30] += 0.01f;
  larger.add_clip("unseen", ClipKind::shot, Split::test, 5, 0.5f, 4);
  wider.add_clip("unseen", ClipKind::shot, Split::test, 5, 0.5f, 4);
  CHECK_THROWS_WITH(unseen_mse(baked.archive, larger), doctest::Contains("vertices"));
  CHECK_THROWS_WITH(unseen_mse(baked.archive, wider), doctest::Contains("controls"));
  CHECK_THROWS_WITH(unseen_mse(baked.archive, bent), doctest::Contains("vertex 10 has another rest position"));
}

TEST_CASE("an archive whose proof does not hold is refused") {
  WorkFolder folder;
  MemorySource source = curved_face();
  Archive archive = read_archive(bake_face(source, options_in(folder, "linear"), silent_progress()).archive);
  const std::size_t somewhere = archive.proof.positions.size() / 2;
  float& kept = archive.proof.positions[somewhere];
  kept = std::nextafter(kept, 1e9f);
  CHECK_THROWS_WITH(verify_archive(write_archive(archive.model, archive.proof)),
                    doctest::Contains("does not pose as it did"));
  kept = std::nextafter(kept, -1e9f);
  verify_archive(write_archive(archive.model, archive.proof));
  ++archive.proof.hashes[2];
  CHECK_THROWS_WITH(verify_archive(write_archive(archive.model, archive.proof)),
                    doctest::Contains("the positions of pose 2 of its proof have the hash"));
}

TEST_CASE("a rig whose name is no UTF-8 is baked all the same") {
  struct Misnamed final : MemorySource {
    using MemorySource::MemorySource;
    RigSchema misnamed = MemorySource::schema();
    const RigSchema& schema() const override { return misnamed; }
  };
  WorkFolder folder;
  Misnamed source(4, 6, curved_formula);
  source.misnamed.name = "face \xff";
  source.add_clip("dense", ClipKind::dense, Split::train, 40, 0.3f, 1);
  const PackedModel model =
      read_archive(bake_face(source, options_in(folder, "linear"), silent_progress()).archive).model;
  CHECK(model.schema.name == "face \xff");
  CHECK(model.provenance.find("\xef\xbf\xbd") != std::string::npos);
}

}  // namespace test_recipes
