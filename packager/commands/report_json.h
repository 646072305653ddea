// The figures of measuring and baking as JSON text, indented, ending in a newline. Keys are an interface: they are only
// ever added.
#pragma once

#include <optional>
#include <string>

#include "bake/measure/evaluate.h"
#include "bake/measure/locality.h"
#include "bake/pipeline/bake.h"
#include "bake/pipeline/compare.h"

namespace fb::tool {
using namespace bake;

// "quality" and "locality" are null where they were not measured.
std::string eval_json(const std::string& archive, const EvalReport& report, const std::optional<Locality>& locality);
std::string compare_json(const CompareReport& report);
std::string bake_json(const std::string& archive, const Baked& baked);

}  // namespace fb::tool
