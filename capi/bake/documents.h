// The results of the authoring calls as JSON documents: indented, ending in a newline, bytes that are no UTF-8
// replaced, figures that are not finite null. Keys are an interface: they are only ever added.
#pragma once

#include <facebaker/facebaker_bake.h>

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "archive/reader.h"
#include "bake/measure/face_difference.h"
#include "bake/measure/verify.h"
#include "bake/pipeline/bake.h"
#include "bake/sampling/sampling.h"
#include "figures/dataset_figures.h"
#include "figures/face_figures.h"

namespace fb::capi {

std::string json_text(const nlohmann::ordered_json& json);

std::string sample_json(const std::string& dataset, const bake::SampleReport& report);
// `rest`: whether the plan has a rest mesh.
std::string plan_json(const std::string& dataset, const bake::PosePlan& plan, bool rest);
std::string bake_json(const std::string& archive, const bake::Source& source, const bake::Baked& baked);
// "quality" and "locality" are null where they were not measured.
std::string eval_json(const std::string& archive, const MethodReport& face);
// Of fb_compare and fb_check; with details, see fb_report_details.
std::string faces_json(const FaceFigures& faces, bool details);
std::string dataset_json(const DatasetFigures& figures, bool details);
std::string verify_json(const std::string& archive, const bake::VerifyReport& report);
// `before`, `now`: paths of the archives.
std::string diff_json(const std::string& before, const archive::Archive& old_archive, const std::string& now,
                      const archive::Archive& new_archive, const bake::FaceDifference& difference);
std::string pack_json(const std::string& archive, const std::string& out, const fb_pack_result& result);
// total_bytes: of the file; runtime_bytes: what a loaded face keeps in memory.
std::string inspect_json(const std::string& path, const archive::Archive& archive, std::uint64_t total_bytes,
                         std::uint64_t runtime_bytes);

// What the archive says about how it was made: the provenance's "recipe", "" if it has none.
std::string recipe_of(const archive::Archive& archive);

}  // namespace fb::capi
