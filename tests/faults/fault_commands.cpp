#include "fault_commands.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string_view>

#include "archive/writer.h"
#include "bake/measure/verify.h"
#include "base/file.h"
#include "signing_keys.h"
#include "test_models.h"

namespace fs = std::filesystem;

namespace faults {
namespace {

// Whether the bytes of a file depend on the time that something took.
bool is_timed(const std::string& name) {
  const auto ends = [&](const char* end) { return name.ends_with(end); };
  return (ends(".json") && !ends("dataset.json")) || ends(".md") || ends(".html") || ends(".csv") ||
         ends(".checkpoint") || ends(".sig");
}

// Files that a stopped command may leave for the next one.
bool is_work(const std::string& name) {
  return name.starts_with("face.fbk.work/") || name.starts_with("work/") ||
         name.starts_with("bagged.facebaker-partial/") || name.ends_with(".facebaker-lock") ||
         name.ends_with(".facebaker-partial");
}

}  // namespace

bool whole() {
  const char* text = std::getenv("FB_FAULTS");
  return text && std::string_view(text) == "whole";
}

Tree tree_of(const std::string& folder) {
  Tree tree;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).string();
    if (entry.is_directory())
      tree[name + "/"];
    else
      tree[name] = fb::read_file(entry.path());
  }
  return tree;
}

Workbench::Workbench(Extent extent)
    : out_(folder_ / "out"), old_(fb::archive::write_archive(fb::tiny_packed_model(2), {})) {
  const std::string face = folder_ / "in.fbk", clip = folder_ / "clip.npy", toy = folder_ / "toy.fbk",
                    recorded = folder_ / "recorded";
  const fb::PackedModel model = fb::tiny_packed_model();
  fb::write_file(face, fb::archive::write_archive(model, fb::bake::make_proof(model, 1)));
  write_clip(clip, model.schema, 3);
  reset();
  REQUIRE(run({"", {"bake", FB_TOY_RIG, "--out", toy, "--recipe", "linear", "--poses", "100"}}).exit_code == 0);
  REQUIRE(run({"", {"sample", FB_TOY_RIG, "--out", recorded, "--poses", "100"}}).exit_code == 0);
  const auto in_out = [&](const char* name) { return out_ + "/" + name; };
  const std::string archive = in_out("face.fbk");
  commands_ = {
      {"sample", {"sample", FB_TOY_RIG, "--out", in_out("data"), "--poses", "200"}},
      {"bake linear", {"bake", FB_TOY_RIG, "--out", archive, "--recipe", "linear", "--poses", "100"}},
      {"bake compact", {"bake", recorded, "--out", archive, "--recipe", "compact", "--epochs", "2"}, {}, true},
      {"compare",
       {"compare", FB_TOY_RIG, "--methods", "linear", "--poses", "100", "--work", in_out("work"), "--json",
        in_out("compare.json")},
       {},
       true},
      {"eval", {"eval", toy, FB_TOY_RIG, "--json", in_out("eval.json")}},
      {"pack", {"pack", face, "--out", archive}},
      {"pack smaller", {"pack", face, "--out", archive, "--max-error", "0.01"}},
      {"pose glb", {"pose", face, "--clip", clip, "--out", in_out("face.glb")}},
      {"pose obj", {"pose", face, "--clip", clip, "--out", in_out("face.obj")}},
      {"pose png", {"pose", face, "--size", "32x32", "--out", in_out("face.png")}},
      {"bench",
       {"bench", face, "--poses", "2", "--rounds", "1", "--batch", "2", "--csv", in_out("speed.csv")},
       {},
       true},
  };
  if (extent == Extent::all_writers) add_writers(face, clip, toy, recorded);
  if (!whole()) return;
  const auto bake_live = [&](const char* rig, const char* recipe) {
    return std::vector<std::string>{"bake", rig,        "--out", archive,   "--recipe",
                                    recipe, "--epochs", "3",     "--poses", "100"};
  };
  commands_.push_back({"bake compact, live", bake_live(FB_TOY_RIG, "compact")});
  commands_.push_back({"bake compact, slow rig", bake_live(FB_FAULTY_RIG, "compact"), {"FB_FAULT=slow"}});
  commands_.push_back({"bake paper", bake_live(FB_TOY_RIG, "paper")});
  commands_.push_back(
      {"learning curve",
       {"bake", recorded, "--out", archive, "--recipe", "linear", "--learning-curve", "--work", in_out("work")}});
  commands_.push_back({"report", {"eval", toy, FB_TOY_RIG, "--report", in_out("report")}});
}

void Workbench::add_writers(const std::string& face, const std::string& clip, const std::string& toy,
                            const std::string& recorded) {
  const auto in_out = [&](const char* name) { return out_ + "/" + name; };
  for (const char* end : {".usda", ".mdd", ".pc2", ".glb"})
    commands_.push_back(
        {std::string("export ") + end, {"export", face, in_out("moved") + end, "--clip", clip, "--fps", "24"}});
  commands_.push_back({"export onnx", {"export", face, in_out("face.onnx")}});
  commands_.push_back({"plan", {"plan", FB_TOY_RIG, "--out", in_out("planned"), "--poses", "100"}});
  commands_.push_back({"check", {"check", recorded, "--report", in_out("checked")}, {}, true});
  commands_.push_back({"inspect", {"inspect", toy, "--thumbnail", in_out("face.png")}});
  commands_.push_back({"header", {"header", toy, "--out", in_out("face.h")}});
  commands_.push_back({"bag", {"bag", face, "--out", in_out("bagged"), "--date", "2026-11-29"}});
  const fb::test::SigningTestKey signer(fb::test::new_curve_key());
  const std::string key = folder_ / "key.pem";
  fb::write_file(key, signer.key_pem() + signer.certificate_pem());
  commands_.push_back({"sign", {"sign", face, "--key", key, "--out", in_out("face.fbk.sig")}});
  commands_.push_back({"manual", {"write-manual", in_out("manual")}});
}

void Workbench::reset() const {
  fs::remove_all(out_);
  fs::remove_all(out_ + ".gone");
  fs::create_directory(out_);
  fb::write_file(out_ + "/face.fbk", old_);
}

ToolRun Workbench::run(const Command& command, const ToolSetting& setting) const {
  std::vector<std::string> arguments = command.arguments;
  constexpr std::array<std::string_view, 6> without_threads = {"pack",   "bench",        "inspect",
                                                               "header", "write-manual", "sign"};
  if (std::ranges::find(without_threads, arguments[0]) == without_threads.end())
    arguments.insert(arguments.end(), {"--threads", "1"});
  ToolSetting quiet = setting;
  quiet.environment.insert(quiet.environment.end(), command.environment.begin(), command.environment.end());
  quiet.environment.push_back("OMP_WAIT_POLICY=PASSIVE");  // the tool does not execute itself again
  return run_tool(arguments, quiet);
}

Tree Workbench::expect(const Command& command) const {
  reset();
  const ToolRun run = this->run(command);
  CAPTURE(run.err);
  REQUIRE(run.exit_code == 0);
  Tree tree = tree_of(out_);
  REQUIRE(std::none_of(tree.begin(), tree.end(), [](const auto& file) {
    return file.first.ends_with(".facebaker-lock") || file.first.ends_with(".facebaker-partial");
  }));
  return tree;
}

std::string Workbench::damage(const Tree& expected) const {
  if (!fs::exists(out_ + "/face.fbk")) return "the old face.fbk is gone";
  for (const auto& [name, bytes] : tree_of(out_)) {
    const auto found = expected.find(name);
    const bool old = name == "face.fbk" && bytes == old_;
    if (old || is_work(name) || is_timed(name) || name.ends_with("/")) continue;
    if (found == expected.end()) return name + " is left over";
    if (found->second != bytes) return name + " is neither the old one nor the new one";
  }
  return "";
}

std::string Workbench::difference(const Tree& expected) const {
  const Tree tree = tree_of(out_);
  for (const auto& file : tree)
    if (!expected.contains(file.first)) return file.first + " is left over";
  for (const auto& [name, bytes] : expected) {
    const auto found = tree.find(name);
    if (found == tree.end()) return name + " is missing";
    if (!is_timed(name) && found->second != bytes) return name + " is another";
  }
  return "";
}

}  // namespace faults
