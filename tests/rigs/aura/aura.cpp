// The Aura rig as a plugin: 72 FACS controls, 267 shapes stored as joint motions of a linear blend skin.
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "aura/aura_weights.h"
#include "support/plugin_rig.h"
#include "support/regions.h"
#include "support/skin.h"

namespace rigs {
namespace {

const std::vector<Region> regions = {
    {"brows", {"browDown", "BrowRaiser"}},
    {"eyes", {"eyesLook"}},
    {"lids", {"eyesClosed", "lidTightener", "upperLidRaiser"}},
    {"cheeks", {"cheek"}},
    {"nose", {"nose", "nostril", "nasolabial"}},
    {"jaw", {"jaw"}},
    {"mouth", {"mouth", "lip", "Lip", "chinRaiser", "dimpler"}},
};

class Aura : public PluginRig {
 public:
  Aura(const RigFolder& folder, const nlohmann::json& header)
      : PluginRig("aura", "cm"),
        weights_(header.dump()),
        skin_(folder.floats(header.at("arrays").at("skin_weights"), {0, 0})) {
    for (const auto& control : header.at("controls")) {
      const std::string name = control.at("name");
      add_control(name, region_of(name, regions), control.at("min"), control.at("max"));
    }
    const auto rest = folder.floats(header.at("arrays").at("rest"), {0, 3});
    set_mesh(rest, folder.integers(header.at("arrays").at("quads"), {0, 4}));
    if (skin_.vertices() != vertices()) throw std::runtime_error("skin weights and rest mesh differ in vertices");
    read_shapes(folder.floats(header.at("arrays").at("N"), {weights_.size(), 3, 4 * skin_.joints()}));
    for (const auto& [name, clip] : header.at("clips").items())
      read_clip(name, folder.floats(clip.at("controls"), {0, weights_.controls()}));
  }

  void evaluate(const float* controls, float* positions) const override {
    std::vector<double> weights(weights_.size());
    weights_.evaluate(controls, weights.data());
    std::vector<double> motions(12 * skin_.joints());
    for (std::size_t shape = 0; shape < weights.size(); ++shape) {
      if (weights[shape] == 0) continue;
      for (std::size_t i = first_[shape]; i < first_[shape + 1]; ++i)
        motions[entries_[i].column] += weights[shape] * entries_[i].value;
    }
    std::vector<JointOffset> joints(skin_.joints());
    for (std::size_t i = 0; i < motions.size(); ++i) joints[i / 12].columns[i % 12] = static_cast<float>(motions[i]);
    skin_.apply(joints.data(), rest().data(), positions);
  }

 private:
  // Keeps what is not zero of N [shapes, 3, 4 x joints], about a twelfth.
  void read_shapes(const Array<float>& motions) {
    const std::size_t row = motions.shape[2];
    first_.push_back(0);
    for (std::size_t shape = 0; shape < motions.shape[0]; ++shape) {
      for (std::size_t i = 0; i < 3 * row; ++i) {
        const float value = motions.values[shape * 3 * row + i];
        if (value != 0) entries_.push_back({3 * (i % row) + i / row, value});
      }
      first_.push_back(entries_.size());
    }
  }

  // Two clips are kept for tests alone, and the second half of the captured range of motion.
  void read_clip(const std::string& name, Array<float> clip) {
    constexpr double fps = 30;
    if (name == "alex_rom_3") {
      const auto middle = clip.values.begin() + static_cast<std::ptrdiff_t>(clip.shape[0] / 2 * clip.shape[1]);
      add_clip(name + ".first", FB_CLIP_SHOT, FB_SPLIT_TRAIN, fps, {clip.values.begin(), middle});
      add_clip(name + ".second", FB_CLIP_SHOT, FB_SPLIT_TEST, fps, {middle, clip.values.end()});
      return;
    }
    const bool test = name == "meta_performance" || name == "facegood_3_15";
    const std::int32_t kind = name == "meta_single_excitations" ? FB_CLIP_EXCITATION
                              : name == "meta_combinations"     ? FB_CLIP_REGIONAL
                                                                : FB_CLIP_SHOT;
    add_clip(name, kind, test ? FB_SPLIT_TEST : FB_SPLIT_TRAIN, fps, std::move(clip.values));
  }

  // One number of a shape's joint motions: joint column / 12, and within it the place in JointOffset::columns.
  struct Entry {
    std::size_t column;
    double value;
  };

  AuraWeights weights_;
  Skin skin_;
  std::vector<Entry> entries_;
  std::vector<std::size_t> first_;  // of a shape's run in entries_; shapes + 1
};

}  // namespace
}  // namespace rigs

extern "C" FB_API fb_status fb_rig_open(const char*, fb_rig* rig, char* message, std::uint32_t message_size) {
  using namespace rigs;
  return open_plugin(
      "aura",
      [](const RigFolder& folder) -> std::unique_ptr<PluginRig> {
        return std::make_unique<Aura>(folder, nlohmann::json::parse(folder.text("rig.json")));
      },
      rig, message, message_size);
}
