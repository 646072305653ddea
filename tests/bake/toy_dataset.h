// A dataset folder that tests spoil.
#pragma once

#include <fstream>
#include <string>
#include <vector>

#include "bake/dataset/npy.h"
#include "bake_test_support.h"

namespace fb::test::toy_dataset {

inline constexpr std::size_t frames = 6, controls = 2, vertices = 4;

inline std::vector<float> counting(std::size_t count, float step) {
  std::vector<float> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<float>(i) * step;
  return values;
}

// A good dataset by hand, as an exporter would write it: a clip, a test clip, and a plan. Tests spoil it.
struct ToyDataset {
  Folder folder;
  std::string json = R"({ "format": "facebaker-dataset", "version": 1, "name": "hand", "units": "m", "up_axis": "z",
  "exporter": "unknown fields are ignored",
  "rest": { "points": "rest.npy", "faces": "faces.npy" },
  "controls": [ { "name": "open", "min": 0, "max": 1, "default": 0.25, "group": "mouth" },
                { "name": "turn", "min": -0.5, "max": 0.5, "default": 0 } ],
  "clips": [ { "name": "talk", "kind": "regional", "split": "validation", "fps": 24,
               "controls": "talk.controls.npy", "points": "talk.points.npy" },
             { "name": "walk", "split": "test", "controls": "walk.controls.npy", "points": "walk.points.npy" },
             { "name": "later", "controls": "later.controls.npy" } ] })";

  ToyDataset() {
    bake::write_npy(folder / "rest.npy", {vertices, 3}, std::vector<float>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
    bake::write_npy(folder / "faces.npy", {2, 4}, std::vector<std::int32_t>{0, 1, 2, 3, 2, 1, 0, -1});
    for (const auto& [name, step] : {std::pair("talk", 0.04f), std::pair("walk", 0.03f), std::pair("later", 0.02f)})
      bake::write_npy(folder / (std::string(name) + ".controls.npy"), {frames, controls},
                      counting(frames * controls, step));
    for (const char* name : {"talk", "walk"})
      bake::write_npy(folder / (std::string(name) + ".points.npy"), {frames, vertices, 3},
                      counting(frames * vertices * 3, 0.5f));
  }

  void replace(const std::string& from, const std::string& to) {
    const std::size_t at = json.find(from);
    REQUIRE(at != std::string::npos);
    json.replace(at, from.size(), to);
  }

  void write_index() const { std::ofstream(folder / "dataset.json") << json; }

  bake::OpenedSource open() const {
    write_index();
    return bake::open_source(folder.path().string());
  }
};

}  // namespace fb::test::toy_dataset
