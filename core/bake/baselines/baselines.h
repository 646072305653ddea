// The systems that hero and compact are compared with.
#pragma once

#include "bake/recipe/recipe.h"

namespace fb {

Learnt make_linear(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);
Learnt make_kanyuk2018(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);
Learnt make_bailey2018(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);
Learnt make_paper(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);
Learnt make_paper_tuned(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);
Learnt make_paper_gradients(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);

}  // namespace fb
