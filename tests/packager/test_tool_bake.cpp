// From a rig to figures through the command line: sample, bake, verify, eval, compare, and a picture beside the rig.
#include <doctest/doctest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "bake/dataset/npy.h"
#include "bake/dataset/open_source.h"
#include "bake/measure/evaluate.h"
#include "base/file.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_bake {

using Json = nlohmann::json;

namespace {

const std::vector<std::string> figures = {"mse", "rms", "mean", "p99", "max", "mfm", "p99fm"};

std::string text_of(const std::string& path) {
  const auto bytes = fb::read_file(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void sample_toy(const std::string& dataset) {
  const ToolRun run = run_tool({"sample", FB_TOY_RIG, "--out", dataset, "--poses", "200"});
  CAPTURE(run.err);
  REQUIRE(run.exit_code == 0);
}

std::vector<std::string> quick_bake(const std::string& source, const std::string& out) {
  return {"bake", source, "--out", out, "--recipe", "paper", "--epochs", "1"};
}

// Changes one number of a NumPy file.
void poke(const std::string& path, std::size_t index, float value) {
  const fb::bake::NpyFile file(path);
  std::vector<float> values(file.rows() * file.row_size());
  file.read(0, file.rows(), values);
  values.at(index) = value;
  fb::bake::write_npy(path, file.shape(), std::span<const float>(values));
}

Json read_index(const std::string& dataset) {
  return Json::parse(text_of(dataset + "/dataset.json"));
}
void write_index(const std::string& dataset, const Json& index) {
  std::filesystem::remove(dataset + "/dataset.json");
  fb::write_file(dataset + "/dataset.json", index.dump());
}

// Bakes a dataset with a report, in a folder that has nothing else but the dataset.
void check_bake(const ScratchFolder& folder, const std::string& dataset, const std::string& archive) {
  const ToolRun bake = run_tool({"bake", dataset, "--out", archive, "--recipe", "paper", "--epochs", "2", "--report",
                                 folder / "report", "--json"});
  CAPTURE(bake.err);
  REQUIRE(bake.exit_code == 0);
  const Json baked = Json::parse(bake.out);
  CHECK(baked.at("bytes") == std::filesystem::file_size(archive));
  for (const char* key : {"poses", "coefficients", "parameters", "train_seconds", "quantisation"})
    CHECK(baked.contains(key));
  const Json& unseen = baked.at("independent");
  CHECK(unseen.at("frames") == 12);
  CHECK(unseen.at("mfm") <= unseen.at("p99fm"));
  CHECK(unseen.at("p99fm") <= unseen.at("max"));
  CHECK(folder.names() == std::vector<std::string>{"data", "report", "toy.fbk"});
  CHECK(text_of(folder / "report/bake.json") == bake.out);
}

// The document of `eval` on the toy rig's test clip, against the errors that the library measures.
void check_figures(const Json& measured, const fb::Errors& errors) {
  CHECK(measured.at("units") == "cm");
  CHECK(measured.at("diagonal") > 0);
  REQUIRE(measured.at("clips").size() == 1);
  const Json &clip = measured.at("clips")[0], &total = measured.at("total");
  CHECK(clip.at("name") == "frown");
  CHECK(clip.at("kind") == "shot");
  CHECK(clip.at("split") == "test");
  CHECK(clip.at("frames") == 12);
  for (const std::string& figure : figures) {
    CHECK(clip.at(figure) > 0);
    CHECK(total.at(figure) == clip.at(figure));
  }
  CHECK(total.at("mse") == errors.mse);
  CHECK(total.at("rms") == errors.rms);
  CHECK(total.at("mean") == errors.mean);
  CHECK(total.at("p99") == errors.p99);
  CHECK(total.at("max") == errors.max);
  CHECK(total.at("mfm") == errors.mfm);
  CHECK(total.at("p99fm") == errors.p99fm);
  CHECK(total.at("worst_frame") == errors.worst_frame);
  const Json& touched = measured.at("touched_bytes");
  CHECK(touched.at("poses") == 12);
  CHECK(touched.at("mean") > 0);
  CHECK(touched.at("mean") <= touched.at("max"));
  CHECK(touched.at("p95") <= touched.at("max"));
  CHECK(touched.at("max") <= touched.at("all"));
}

std::size_t clips_of_split(const std::string& archive, const std::string& dataset, const char* split) {
  const ToolRun run = run_tool({"eval", archive, dataset, "--split", split, "--json", "-"});
  REQUIRE(run.exit_code == 0);
  return Json::parse(run.out).at("clips").size();
}

}  // namespace

TEST_CASE("a rig is sampled, baked, verified, measured and shown") {
  const ScratchFolder folder;
  const std::string dataset = folder / "data", archive = folder / "toy.fbk", json = folder / "eval.json";
  sample_toy(dataset);
  const ToolRun again = run_tool({"sample", FB_TOY_RIG, "--out", dataset, "--poses", "200", "--json"});
  REQUIRE(again.exit_code == 0);
  CHECK(Json::parse(again.out).at("evaluated") == 0);  // all of it was there
  check_bake(folder, dataset, archive);

  const ToolRun verify = run_tool({"verify", archive, "--json"});
  REQUIRE(verify.exit_code == 0);
  CHECK(Json::parse(verify.out).at("poses") > 0);
  CHECK(Json::parse(verify.out).at("vertices") > 0);

  const ToolRun eval = run_tool({"eval", archive, dataset, "--json", json, "--report", folder / "report"});
  CAPTURE(eval.err);
  REQUIRE(eval.exit_code == 0);
  const Json measured = Json::parse(text_of(json));
  CHECK(measured.at("archive") == archive);
  const fb::Errors errors = fb::bake::evaluate_archive(fb::read_file(archive), *fb::bake::open_source(dataset),
                                                             fb::bake::Split::test, {}, fb::silent_progress())
                                      .total;
  check_figures(measured, errors);
  CHECK(eval.out.find(std::to_string(measured.at("touched_bytes").at("p95").get<std::uint64_t>())) !=
        std::string::npos);
  CHECK(text_of(folder / "report/eval.json") == text_of(json));
  CHECK(eval.out.find("frown") != std::string::npos);
  CHECK(std::filesystem::file_size(folder / "report/worst.png") > 0);

  // The same clip beside the rig: the same largest error.
  const ToolRun beside = run_tool({"pose", archive, "--clip", dataset + "/frown.controls.npy", "--beside", FB_TOY_RIG,
                                   "--json", "--size", "16x16", "--out", folder / "frown.png"});
  CAPTURE(beside.err);
  REQUIRE(beside.exit_code == 0);
  const Json frames = Json::parse(beside.out);
  CHECK(frames.at("frames") == 12);
  CHECK(frames.at("max").get<double>() == doctest::Approx(errors.max).epsilon(1e-5));

  CHECK(clips_of_split(archive, dataset, "all") == 7);
  CHECK(clips_of_split(archive, dataset, "train") == 6);
}

TEST_CASE("a bake keeps to a limit of bytes or of error, or fails") {
  const ScratchFolder folder;
  const std::string archive = folder / "toy.fbk";
  std::vector<std::string> bake = {"bake", FB_TOY_RIG, "--poses", "100", "--recipe", "linear", "--out", archive};
  const auto with = [&](const std::string& option, const std::string& value) {
    auto words = bake;
    words.insert(words.end(), {option, value});
    return run_tool(words);
  };
  const ToolRun small = with("--max-bytes", "100");
  CHECK(small.exit_code == 1);
  CHECK(small.err.find("facebaker bake: asked for 100 bytes, the smallest reached is ") != std::string::npos);
  CHECK(!std::filesystem::exists(archive));
  bake.push_back("--force");
  REQUIRE(with("--max-bytes", "100").exit_code == 0);
  CHECK(std::filesystem::exists(archive));
  bake.pop_back();
  REQUIRE(with("--max-error", "0.1").exit_code == 0);
  const ToolRun precise = with("--max-error", "1e-3");
  CHECK(precise.exit_code == 1);
  CHECK(precise.err.find("asked for an error of 0.001 of the diagonal, the smallest reached is ") != std::string::npos);
  const ToolRun negative = with("--max-error", "-1");
  CHECK(negative.exit_code == 2);
  CHECK(is_error_line(negative.err, "bake", {"--max-error", "-1 is negative"}));
  bake[5] = "paper";
  const ToolRun paper = with("--max-bytes", "100");
  CHECK(paper.exit_code == 1);
  CHECK(is_error_line(paper.err, "bake", {"\"paper\""}));
}

TEST_CASE("--no-shots leaves the rig's own clips out") {
  const ScratchFolder folder;
  REQUIRE(run_tool({"sample", FB_TOY_RIG, "--out", folder / "data", "--poses", "20", "--no-shots"}).exit_code == 0);
  const Json index = read_index(folder / "data");
  for (const Json& clip : index.at("clips")) {
    CHECK(clip.at("name") != "talk");
    CHECK(clip.at("name") != "frown");
  }
}

TEST_CASE("bench names a source without test clips") {
  const ScratchFolder folder;
  const std::string archive = folder / "toy.fbk";
  REQUIRE(run_tool({"sample", FB_TOY_RIG, "--out", folder / "data", "--poses", "20"}).exit_code == 0);
  REQUIRE(run_tool({"bake", folder / "data", "--recipe", "linear", "--out", archive}).exit_code == 0);
  Json data = read_index(folder / "data");
  for (Json& clip : data.at("clips")) clip["split"] = "train";
  write_index(folder / "data", data);
  const ToolRun bench = run_tool({"bench", archive, "--source", folder / "data"});
  CHECK(bench.exit_code == 1);
  CHECK_MESSAGE(is_error_line(bench.err, "bench", {"data: has no test clips", "--source"}), bench.err);
}

TEST_CASE("a rig budget bounds all evaluations of the rig") {
  const ScratchFolder folder;
  const ToolRun sampled = run_tool({"sample", FB_TOY_RIG, "--out", folder / "data", "--rig-budget", "400", "--json"});
  REQUIRE(sampled.exit_code == 0);
  const Json report = Json::parse(sampled.out);
  CHECK(report.at("asked") <= 400);
  CHECK(report.at("asked") > 380);
  CHECK(report.at("poses") > 380);
  const ToolRun baked = run_tool({"bake", FB_TOY_RIG, "--out", folder / "toy.fbk", "--recipe", "paper", "--use",
                                  "variant", "--epochs", "1", "--rig-budget", "300", "--json"});
  CAPTURE(baked.err);
  REQUIRE(baked.exit_code == 0);
  CHECK(Json::parse(baked.out).at("asked") <= 300);
  CHECK(Json::parse(baked.out).at("poses") == 300);
  const ToolRun poor = run_tool({"sample", FB_TOY_RIG, "--out", folder / "poor", "--rig-budget", "6"});
  CHECK(is_error_line(poor.err, "sample", {"rig budget of 6", "6 controls", "at least"}));
}

TEST_CASE("clips of the user are sampled too, if they fit the rig") {
  const ScratchFolder folder;
  const std::string dataset = folder / "data", clip = folder / "mine.npy", wide = folder / "wide.npy";
  fb::bake::write_npy(clip, {3, 6}, std::span<const float>(std::vector<float>(18, 0.25f)));
  fb::bake::write_npy(wide, {3, 7}, std::span<const float>(std::vector<float>(21)));
  const auto sample = [&](const std::string& text) {
    return run_tool({"sample", FB_TOY_RIG, "--out", dataset, "--poses", "50", "--clip", text});
  };
  for (const std::string& wrong : {wide, "=" + clip, "mine=" + wide, "mine=" + (folder / "none.npy")}) {
    const ToolRun run = sample(wrong);
    CHECK(run.exit_code == 1);
    CHECK(is_error_line(run.err, "sample", {}));
    CHECK(!std::filesystem::exists(dataset));
  }
  REQUIRE(sample("mine=" + clip).exit_code == 0);
  const Json index = read_index(dataset);
  bool found = false;
  for (const Json& entry : index.at("clips")) found = found || entry.at("name") == "mine";
  CHECK(found);
  CHECK(fb::bake::NpyFile(dataset + "/mine.points.npy").shape() == std::vector<std::size_t>{3, 50, 3});
}

TEST_CASE("the same seed gives the same archive, whatever the threads; the kept work is used again") {
  const ScratchFolder folder;
  const std::string dataset = folder / "data";
  sample_toy(dataset);
  const auto bake = [&](const std::string& out, const std::string& threads) {
    return run_tool({"bake", dataset, "--out", out, "--epochs", "2", "--threads", threads, "--work", folder / "work"});
  };
  REQUIRE(bake(folder / "one.fbk", "1").exit_code == 0);
  std::filesystem::remove_all(folder / "work");
  REQUIRE(bake(folder / "two.fbk", "2").exit_code == 0);
  REQUIRE(bake(folder / "three.fbk", "1").exit_code == 0);
  CHECK(text_of(folder / "one.fbk") == text_of(folder / "two.fbk"));
  CHECK(text_of(folder / "one.fbk") == text_of(folder / "three.fbk"));
}

TEST_CASE("compare lists every method with its figures") {
  const ScratchFolder folder;
  const ToolRun run = run_tool({"compare", FB_TOY_RIG, "--poses", "150", "--epochs", "1", "--methods", "linear,paper",
                                "--json", folder / "compare.json"});
  CAPTURE(run.err);
  REQUIRE(run.exit_code == 0);
  const Json json = Json::parse(text_of(folder / "compare.json"));
  std::vector<std::string> names;
  for (const Json& method : json.at("methods")) {
    names.push_back(method.at("name").get<std::string>() + " " + method.at("use").get<std::string>());
    CHECK(method.at("bytes") > 0);
    CHECK(method.at("touched_bytes").at("mean") > 0);
    CHECK(method.at("train_seconds") >= 0);
    CHECK(method.at("clips").size() > 0);
    CHECK(method.at("dependency").at("frames") == method.at("poses"));
    for (const std::string& figure : figures) {
      CHECK(method.at("total").at(figure) >= 0);
      CHECK(method.at("dependency").at(figure) >= 0);
    }
  }
  CHECK(names == std::vector<std::string>{"linear variant", "paper variant", "linear backlot", "paper backlot"});
  CHECK(run.out.find("backlot") != std::string::npos);
  const ToolRun twice = run_tool({"compare", FB_TOY_RIG, "--methods", "linear,linear"});
  CHECK(twice.exit_code == 1);
  CHECK(is_error_line(twice.err, "compare", {"\"linear\"", "more than once"}));
}

TEST_CASE("every command that reads a dataset prints its notes") {
  const ScratchFolder folder;
  const std::string dataset = folder / "data", archive = folder / "face.fbk";
  sample_toy(dataset);
  poke(dataset + "/dense.controls.npy", 0, 9);
  const std::string note = "note: clip \"dense\": 1 control values are outside their range and kept";
  for (const auto& arguments :
       std::vector<std::vector<std::string>>{{"bake", dataset, "--out", archive, "--recipe", "linear"},
                                             {"eval", archive, dataset},
                                             {"compare", dataset, "--methods", "linear"}}) {
    const ToolRun run = run_tool(arguments);
    CAPTURE(run.err);
    CHECK(run.exit_code == 0);
    CHECK(run.err.find(note) != std::string::npos);
  }
}

TEST_CASE("datasets that contradict themselves are refused by file, and nothing is written") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", good = folder / "good";
  sample_toy(good);
  const auto refused = [&](const std::string& name, const std::vector<std::string>& words, auto&& spoil) {
    const std::string dataset = folder / name;
    std::filesystem::copy(good, dataset);
    spoil(dataset);
    const ToolRun run = run_tool(quick_bake(dataset, archive));
    CAPTURE(name);
    CAPTURE(run.err);
    CHECK(run.exit_code == 1);
    CHECK(run.err.find("facebaker bake: ") != std::string::npos);
    for (const std::string& word : words) CHECK(run.err.find(word) != std::string::npos);
    CHECK(!std::filesystem::exists(archive));
    CHECK(!std::filesystem::exists(archive + ".work"));
  };
  refused("nan", {"dense", "frame 2", "vertex 7", "not finite"},
          [](const std::string& data) { poke(data + "/dense.points.npy", 2 * 150 + 7 * 3, NAN); });
  refused("nan-control", {"dense", "frame 1", "jawOpen"},
          [](const std::string& data) { poke(data + "/dense.controls.npy", 1 * 6 + 3, NAN); });
  refused("truncated", {"dense.points.npy", "truncated"}, [](const std::string& data) {
    std::filesystem::resize_file(data + "/dense.points.npy",
                                 std::filesystem::file_size(data + "/dense.points.npy") - 1);
  });
  refused("missing", {"dense.points.npy"},
          [](const std::string& data) { std::filesystem::remove(data + "/dense.points.npy"); });
  refused("narrow", {"dense.controls.npy", "shape"}, [](const std::string& data) {
    fb::bake::write_npy(data + "/dense.controls.npy", {4, 5}, std::span<const float>(std::vector<float>(20)));
  });
  refused("twice", {"dataset.json", "jawOpen"}, [](const std::string& data) {
    Json index = read_index(data);
    index["controls"][0]["name"] = "jawOpen";
    write_index(data, index);
  });
  refused("not-json", {"dataset.json"}, [](const std::string& data) {
    std::filesystem::remove(data + "/dataset.json");
    fb::write_file(data + "/dataset.json", std::string("{\"format\": "));
  });
}

TEST_CASE("unknown sources, failing rigs and a dataset without test clips are refused") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", dataset = folder / "data";
  fb::write_file(folder / "rig.so", std::string("no library"));
  for (const std::string& source : {folder / "nothing", folder.path(), folder / "rig.so", std::string("/dev/null")}) {
    const ToolRun run = run_tool(quick_bake(source, archive));
    CHECK(run.exit_code == 1);
    CHECK(is_error_line(run.err, "bake", {source}));
    CHECK(folder.names() == std::vector<std::string>{"rig.so"});
  }
  const ToolRun failing = run_tool({"sample", FB_FAULTY_RIG, "--out", dataset, "--poses", "200"},
                                   {.environment = {"FB_FAULT=fails on a pose"}});
  CAPTURE(failing.err);
  CHECK(failing.exit_code == 1);
  CHECK(failing.err.find("facebaker sample: ") != std::string::npos);
  CHECK(failing.err.find("did not converge") != std::string::npos);
  std::filesystem::remove_all(dataset);

  sample_toy(dataset);
  const ToolRun recorded = run_tool({"sample", dataset, "--out", folder / "copy"});
  CHECK(recorded.exit_code == 1);
  CHECK(is_error_line(recorded.err, "sample", {dataset, "recording"}));

  REQUIRE(run_tool(quick_bake(dataset, archive)).exit_code == 0);
  Json index = read_index(dataset);
  for (Json& clip : index["clips"]) clip["split"] = "train";
  write_index(dataset, index);
  const ToolRun eval = run_tool({"eval", archive, dataset});
  CHECK(eval.exit_code == 1);
  CHECK(eval.err.find("facebaker eval: ") != std::string::npos);
  CHECK(eval.err.find("test") != std::string::npos);
  // Nor is another face's archive measured against it.
  write_tiny_archive(folder / "tiny.fbk");
  const ToolRun other = run_tool({"eval", folder / "tiny.fbk", dataset, "--split", "train"});
  CHECK(other.exit_code == 1);
  CHECK(other.err.find("facebaker eval: ") != std::string::npos);
}

TEST_CASE("a bake fails early if its archive cannot be written, and on a full disk keeps its work") {
  const ScratchFolder folder;
  const ToolRun nowhere = run_tool(quick_bake(FB_TOY_RIG, folder / "no/such/folder/face.fbk"));
  CHECK(nowhere.exit_code == 1);
  CHECK(is_error_line(nowhere.err, "bake", {"face.fbk", "cannot be written"}));
  CHECK(folder.names().empty());

  const std::string dataset = folder / "data", archive = folder / "face.fbk", file = folder / "file";
  sample_toy(dataset);
  fb::write_file(file, std::string("precious"));
  for (const char* option : {"--work", "--report"}) {
    auto arguments = quick_bake(dataset, archive);
    arguments.insert(arguments.end(), {option, file});
    const ToolRun run = run_tool(arguments);
    CHECK(run.exit_code == 1);
    CHECK(is_error_line(run.err, "bake", {file + ": cannot be created"}));
    CHECK(folder.names() == std::vector<std::string>{"data", "file"});
  }
  fb::write_file(archive, std::string("precious"));
  if (!can_limit_files) {
    MESSAGE("skipped in part: files cannot be limited in a build by clang");
    return;
  }
  const ToolRun full = run_tool(quick_bake(dataset, archive), {.largest_file = 500});
  CHECK(full.exit_code == 1);
  CHECK(full.err.find("facebaker bake: ") != std::string::npos);
  CHECK(text_of(archive) == "precious");
  for (const std::string& name : folder.names()) CHECK(name.find(".partial") == std::string::npos);
}

TEST_CASE("Ctrl-C and SIGTERM stop a bake without an archive, and the same command continues it") {
  for (const int signal : {SIGINT, SIGTERM}) {
    const ScratchFolder folder;
    const std::string dataset = folder / "data", archive = folder / "face.fbk", work = folder / "work";
    sample_toy(dataset);
    const auto bake = [&](const std::string& epochs, const ToolSetting& setting) {
      return run_tool({"bake", dataset, "--out", archive, "--recipe", "paper", "--epochs", epochs, "--work", work},
                      setting);
    };
    const ToolRun stopped = bake("1000000", {.interrupt_when_exists = work, .signal = signal});
    CAPTURE(stopped.err);
    CHECK(stopped.exit_code == 1);
    CHECK(stopped.err.find("stopping") != std::string::npos);
    CHECK(stopped.err.find("run the same command to go on") != std::string::npos);
    CHECK(!std::filesystem::exists(archive));
    CHECK(std::filesystem::exists(work));
    CHECK(bake("1", {}).exit_code == 0);
    CHECK(std::filesystem::exists(archive));
  }
}

TEST_CASE("Ctrl-C stops a comparison, with a message on how to continue one") {
  const ScratchFolder folder;
  const std::string dataset = folder / "data", report = folder / "report", work = folder / "work";
  sample_toy(dataset);
  for (const bool kept : {false, true}) {
    std::vector<std::string> arguments = {"compare",  dataset,   "--methods", "paper",
                                          "--epochs", "1000000", "--report",  report};
    if (kept) arguments.insert(arguments.end(), {"--work", work});
    std::filesystem::remove_all(report);
    const ToolRun stopped = run_tool(arguments, {.interrupt_when_exists = report});
    CAPTURE(stopped.err);
    CHECK(stopped.exit_code == 1);
    CHECK((stopped.err.find("with --work DIR the same command could go on") == std::string::npos) == kept);
    CHECK((stopped.err.find("run the same command to go on") != std::string::npos) == kept);
  }
}

}  // namespace test_tool_bake
