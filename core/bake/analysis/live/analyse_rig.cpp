#include <algorithm>

#include "bake/analysis/blendshape_parts.h"
#include "bake/analysis/live/corrective_search.h"
#include "bake/analysis/live/excitation_curves.h"
#include "bake/analysis/live/finite_differences.h"
#include "base/status.h"

namespace fb {

Probe probe_rig(Source& source, const ProbeOptions& options, const Parallel& parallel, Progress& progress) {
  if (!source.live())
    fail(Status::invalid_argument, "\"%s\" is a recording: probe_poses is for it", source.schema().name.c_str());
  Probe probe;
  RigAsker rig(source, options, parallel, progress);
  const std::vector<ControlCurve> curves = probe_curves(rig, options, probe.motion);
  std::vector<const CurveBase*> parts;
  for (const ControlCurve& curve : curves) {
    parts.push_back(&curve.part);
    probe.linear_controls += curve.part.shapes.size() == 1;
  }
  append(probe.base, parts);
  const DenseProbe dense = probe_dense(rig, options.seed);
  const std::vector<float> among_many = toggled_motion(dense, {}, Over::largest, rig);
  for (std::size_t i = 0; i < among_many.size(); ++i) probe.motion[i] = std::max(probe.motion[i], among_many[i]);
  probe.curve_error = test_curves(rig, curves, options.seed);
  InteractionProbe interactions(rig, options, curves, dense, probe.base);
  if (options.max_pairs > 0) interactions.find(2, options.max_pairs);
  if (options.max_triples > 0) {
    interactions.find(3, options.max_triples);
    interactions.find(4, options.max_triples / 4);
  }
  probe.interactions = interactions.finish();
  probe.residual_motion = toggled_motion(dense, probe.base, Over::root_mean_square, rig);
  probe.rig_calls = rig.calls();
  return probe;
}

}  // namespace fb
