#include "runtime/evaluator.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/checked.h"
#include "base/status.h"
#include "model/feature_values.h"
#include "runtime/float_state.h"
#include "runtime/grouped.h"

namespace fb {
namespace {

std::vector<std::uint32_t> places_of(const std::vector<std::uint32_t>& order) {
  std::vector<std::uint32_t> places(order.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) places[order[i]] = i;
  return places;
}

std::vector<std::uint32_t> first_rows(const PackedModel& model) {
  std::vector<std::uint32_t> rows;
  for (const PackedRowGroup& group : model.groups) rows.push_back(group.first_row);
  rows.push_back(checked_u32(model.rest.points.size(), "the rows of the basis"));
  return rows;
}

// `pages` if the whole numbers of layers and basis, most of which take a byte, fill one.
std::pmr::memory_resource& memory_for(const PackedModel& model, LargePages& pages) {
  std::size_t bytes = 0;
  for (const PackedRegion& region : model.regions)
    for (const PackedLayer& layer : region.layers) bytes += layer.weights.size();
  for (const PackedRowGroup& group : model.groups) bytes += group.values.size();
  return bytes < LargePages::page ? *std::pmr::get_default_resource() : pages;
}

// So many steps ahead is asked for what lies here and there.
constexpr std::size_t ahead = 8;

}  // namespace

Workspace::Workspace(const Evaluator& evaluator, std::pmr::memory_resource& memory)
    : features_(evaluator.graph_, memory),
      inputs_(evaluator.first_input_.back(), evaluator.nets_.size(), memory),
      summands_(evaluator.first_summand_.back(), evaluator.chunks_.size(), memory),
      watches_(evaluator.nets_.size(), &memory),
      open_(evaluator.nets_.size(), &memory),
      coefficients_(evaluator.coefficient_count() * block_poses, &memory),
      layers_(evaluator.work_size_ * block_poses, &memory),
      rows_((evaluator.rest_rows_.size() + 1) * block_poses, &memory),  // whole vectors are read
      moved_(evaluator.chunks_.size() * block_poses, &memory),
      halves_(evaluator.rest_rows_.size() + 1, &memory),
      quantized_(evaluator.longest_list_, block_poses, memory),
      normals_(evaluator.normals_, memory),
      tangents_(evaluator.tangents_, memory) {
  for (std::size_t p = 0; p < block_poses; ++p)
    std::copy(evaluator.rest_rows_.begin(), evaluator.rest_rows_.end(),
              rows_.begin() + p * (evaluator.rest_rows_.size() + 1));
}

Evaluator::Evaluator(const PackedModel& model, std::pmr::memory_resource* memory, std::uint64_t max_bytes,
                     const PoseKernels& kernels)
    : schema_(model.schema),
      kernels_(kernels),
      memory_(memory ? *memory : memory_for(model, pages_), max_bytes),
      graph_(model, memory_),
      nets_(&memory_),
      slopes_(&memory_),
      chunks_(&memory_),
      direct_(model.direct.begin(), model.direct.end(), &memory_),
      first_coefficient_(&memory_),
      first_input_(&memory_),
      first_summand_(&memory_),
      inputs_(&memory_),
      gates_(&memory_),
      summands_(&memory_),
      uses_(&memory_),
      chunk_regions_(&memory_),
      chunk_regions_begin_(&memory_),
      rest_(model.rest.points.begin(), model.rest.points.end(), &memory_),
      rest_rows_(model.rest.points.size(), &memory_),
      order_(model.order.begin(), model.order.end(), &memory_),
      place_of_(&memory_),
      normals_(model.rest, places_of(model.order), first_rows(model), memory_),
      tangents_(model.rest, places_of(model.order), normals_, memory_),
      coefficient_count_(model.columns) {
  const FloatState state;
  const std::vector<std::uint32_t> places = places_of(model.order);
  place_of_.assign(places.begin(), places.end());
  for (std::uint32_t row = 0; row < rest_rows_.size(); ++row) rest_rows_[row] = rest_[model.coordinate(row)];
  nets_.reserve(model.regions.size());
  std::size_t coefficient = direct_.size(), input = 0, summand = 0;
  for (const PackedRegion& region : model.regions) {
    RegionNet& net = nets_.emplace_back(region, memory_);
    net.find_rest(kernels_, region.name.c_str());
    region_names_.push_back(region.name);
    slopes_.push_back(region.gate.features.empty() ? 0 : region.gate.slope);
    first_coefficient_.push_back(static_cast<std::uint32_t>(coefficient));
    first_input_.push_back(checked_u32(input, "the inputs of all regions"));
    coefficient += net.output_count();
    input += net.input_count() + padding;
    widest_layer_ = std::max(widest_layer_, net.widest());
    work_size_ = std::max(work_size_, net.work_size());
  }
  first_coefficient_.push_back(static_cast<std::uint32_t>(coefficient));
  first_input_.push_back(checked_u32(input, "the inputs of all regions"));
  chunks_.reserve(model.groups.size());
  longest_list_ = widest_layer_;
  for (const PackedRowGroup& group : model.groups) {
    first_summand_.push_back(checked_u32(summand, "the columns of all row groups"));
    const std::size_t count = chunks_.emplace_back(group, memory_).summand_count();
    longest_list_ = std::max(longest_list_, count);
    summand += count + padding;
  }
  first_summand_.push_back(checked_u32(summand, "the columns of all row groups"));
  lay_out_uses(model);
}

void Evaluator::lay_out_uses(const PackedModel& model) {
  const std::size_t features = model.features.size(), direct = direct_.size();
  Grouped<InputUse> inputs(features);
  Grouped<std::uint32_t> gates(features);
  for (std::uint32_t r = 0; r < model.regions.size(); ++r) {
    const PackedRegion& region = model.regions[r];
    for (std::uint32_t i = 0; i < region.features.size(); ++i) inputs.add(region.features[i], {r, i});
    for (const std::uint32_t feature : region.gate.features) gates.add(feature, r);
  }
  std::pmr::vector<std::uint32_t> inputs_begin, gates_begin, summands_begin;
  inputs.move_to(inputs_, inputs_begin);
  gates.move_to(gates_, gates_begin);

  Grouped<SummandUse> summands(features);
  Grouped<ChunkRegion> regions(chunks_.size());
  for (std::uint32_t c = 0; c < chunks_.size(); ++c) {
    const RowChunk& chunk = chunks_[c];
    for (std::uint32_t s = 0; s < chunk.summand_count(); ++s)
      if (chunk.column(s) < direct) summands.add(direct_[chunk.column(s)], {c, s, chunk.scale(s)});
    for (std::uint32_t r = 0; r < nets_.size(); ++r) {
      const auto [low, high] = chunk.summands_of(first_coefficient_[r], first_coefficient_[r + 1]);
      for (const RowChunk::Span span : {low, high})
        if (span.begin < span.end) regions.add(c, {r, span.begin, span.end});
    }
  }
  summands.move_to(summands_, summands_begin);
  uses_.resize(features + 1);
  for (std::size_t f = 0; f <= features; ++f) uses_[f] = {inputs_begin[f], gates_begin[f], summands_begin[f]};
  regions.move_to(chunk_regions_, chunk_regions_begin_);
}

std::size_t Evaluator::find_nan(const float* controls) const {
  // Most often there is none, and to know that is quick in whole numbers.
  std::uint32_t most = 0;
  for (std::size_t i = 0; i < control_count(); ++i)
    most = std::max(most, std::bit_cast<std::uint32_t>(controls[i]) & 0x7fffffff);
  if (most <= 0x7f800000) return control_count();
  return std::find_if(controls, controls + control_count(), [](float v) { return v != v; }) - controls;
}

void Evaluator::refuse_nan(const float* controls) const {
  const std::size_t control = find_nan(controls);
  if (control < control_count())
    fail(Status::not_finite, "control \"%s\" is not a number", schema_.controls[control].name.c_str());
}

template <std::size_t poses>
void Evaluator::gather_inputs(Workspace& workspace) const {
  Workspace::Lists& inputs = workspace.inputs_;
  std::fill(inputs.counts.begin(), inputs.counts.end(), 0u);
  std::fill(workspace.watches_.begin(), workspace.watches_.end(), Workspace::Watch{});
  const std::span<const std::uint32_t> active = workspace.features_.active();
  for (std::size_t i = 0; i < active.size(); ++i) {
    if (i + ahead < active.size()) __builtin_prefetch(&uses_[active[i + ahead]]);
    const float* value = workspace.features_[active[i]];
    const Uses* uses = &uses_[active[i]];
    __builtin_prefetch(summands_.data() + uses->summands);
    for (std::uint32_t u = uses[0].inputs; u < uses[1].inputs; ++u) {
      const auto [region, place] = inputs_[u];
      const std::uint32_t at = first_input_[region] + inputs.counts[region]++;
      inputs.places[at] = place;
      Workspace::Watch& watch = workspace.watches_[region];
      for (std::size_t p = 0; p < poses; ++p) {
        inputs.values[at * poses + p] = value[p];
        watch.moved[p] |= value[p] != 0;
      }
    }
    for (std::uint32_t u = uses[0].gates; u < uses[1].gates; ++u) {
      Workspace::Watch& watch = workspace.watches_[gates_[u]];
      for (std::size_t p = 0; p < poses; ++p) {
        const float size = std::fabs(value[p]);
        watch.sum[p] += size;
        watch.most[p] = size > watch.most[p] ? size : watch.most[p];
      }
    }
  }
}

template <std::size_t poses>
void Evaluator::run_regions(RegionMask regions, Workspace& workspace) const {
  gather_inputs<poses>(workspace);
  for (std::size_t r = 0; r < nets_.size(); ++r) {
    const Workspace::Watch& watch = workspace.watches_[r];
    float opening[poses];
    bool open = false;
    for (std::size_t p = 0; p < poses; ++p) {
      opening[p] = watch.moved[p] && (regions.empty() || regions[r] != 0) ? 1 : 0;
      if (slopes_[r] != 0 && opening[p] != 0) {
        const float gate = slopes_[r] * (watch.sum[p] - watch.most[p]);
        opening[p] = gate > 0 ? (gate < 1 ? gate : 1) : 0;
      }
      open |= opening[p] != 0;
    }
    workspace.open_[r] = open;
    if (!open) continue;
    float* coefficients = workspace.coefficients_.data() + first_coefficient_[r] * poses;
    nets_[r].run(kernels_, workspace.inputs_.list(first_input_[r], workspace.inputs_.counts[r], poses), poses,
                 workspace.layers_.data(), workspace.quantized_, coefficients);
    for (std::size_t i = 0; i < nets_[r].output_count(); ++i)
      for (std::size_t p = 0; p < poses; ++p, ++coefficients)
        *coefficients = zero_unless(opening[p] != 0, *coefficients * opening[p]);
  }
}

template <std::size_t poses>
void Evaluator::gather_summands(Workspace& workspace) const {
  // Counts are ends of lists until all are full.
  std::uint32_t* ends = workspace.summands_.counts.data();
  std::copy_n(first_summand_.begin(), chunks_.size(), ends);
  float* values = workspace.summands_.values.data();
  std::uint32_t* places = workspace.summands_.places.data();
  const std::span<const std::uint32_t> active = workspace.features_.active();
  for (std::size_t i = 0; i < active.size(); ++i) {
    if (i + ahead < active.size()) __builtin_prefetch(summands_.data() + uses_[active[i + ahead]].summands);
    float value[poses];
    std::copy_n(workspace.features_[active[i]], poses, value);
    const Uses* uses = &uses_[active[i]];
    const SummandUse* const end = summands_.data() + uses[1].summands;
    for (const SummandUse* use = summands_.data() + uses[0].summands; use < end; ++use) {
      const std::uint32_t at = ends[use->chunk]++;
      places[at] = use->place;
      for (std::size_t p = 0; p < poses; ++p) values[at * poses + p] = value[p] * use->scale;
    }
  }
  for (std::size_t c = 0; c < chunks_.size(); ++c) ends[c] -= first_summand_[c];
}

template <std::size_t poses>
void Evaluator::run_chunks(float* const* rows, Workspace& workspace) const {
  const bool kept = rows[0] == workspace.rows_.data();
  Workspace::Lists& lists = workspace.summands_;
  for (std::size_t c = 0; c < chunks_.size(); ++c) {
    const RowChunk& chunk = chunks_[c];
    if (c + 1 < chunks_.size()) {
      chunks_[c + 1].fetch(lists.places.data() + first_summand_[c + 1], lists.counts[c + 1]);
      for (std::uint32_t u = chunk_regions_begin_[c + 1]; u < chunk_regions_begin_[c + 2]; ++u)
        if (workspace.open_[chunk_regions_[u].region]) chunks_[c + 1].fetch_scales(chunk_regions_[u].begin);
    }
    PoseNumbers list = lists.list(first_summand_[c], lists.counts[c], poses);
    std::uint32_t* places = lists.places.data() + first_summand_[c];
    for (std::uint32_t u = chunk_regions_begin_[c]; u < chunk_regions_begin_[c + 1]; ++u) {
      const auto [region, begin, end] = chunk_regions_[u];
      if (!workspace.open_[region]) continue;
      chunk.weigh<poses>({begin, end}, workspace.coefficients_.data(), list.values + list.count * poses);
      for (std::uint32_t s = begin; s < end; ++s) places[list.count++] = s;
    }
    const float* rest = rest_rows_.data() + chunk.first_row();
    float* to[poses];
    bool moved[poses] = {};
    for (std::size_t p = 0; p < poses; ++p) to[p] = rows[p] + chunk.first_row();
    if (list.count > 0) chunk.run(kernels_, list, poses, workspace.quantized_, rest, to, moved);
    for (std::size_t p = 0; p < poses; ++p) {
      std::uint8_t& was_moved = workspace.moved_[p * chunks_.size() + c];
      if (!moved[p] && !(kept && !was_moved)) std::copy_n(rest, chunk.row_count(), to[p]);
      if (kept) was_moved = moved[p];
    }
  }
}

template <std::size_t poses>
void Evaluator::run_features_on(const PoseOutput* outputs, RegionMask regions, Workspace& workspace) const {
  run_regions<poses>(regions, workspace);
  gather_summands<poses>(workspace);
  const VertexOutput& first = outputs[0].positions;  // the others are alike
  const bool in_place = first.first && first.vertex_stride == 3 && !first.streamed &&
                        first.format == NumberFormat::float32 && !outputs[0].normals.first &&
                        !outputs[0].tangents.first && (place_of_.empty() || first.order == VertexOrder::baked);
  float* rows[poses];
  for (std::size_t p = 0; p < poses; ++p)
    rows[p] = in_place ? static_cast<float*>(outputs[p].positions.first)
                       : workspace.rows_.data() + p * (rest_rows_.size() + 1);
  run_chunks<poses>(rows, workspace);
  for (std::size_t p = 0; p < poses && !in_place; ++p) {
    if (outputs[p].positions.first)
      write_vertices(kernels_, rows[p], vertex_count(), place_of_, workspace.halves_.data(), outputs[p].positions);
    if (!outputs[p].normals.first && !outputs[p].tangents.first) continue;
    normals_.run(kernels_, rows[p], {workspace.moved_.data() + p * chunks_.size(), chunks_.size()}, workspace.normals_);
    if (outputs[p].normals.first)
      write_vertices(kernels_, workspace.normals_.normals(), vertex_count(), place_of_, workspace.halves_.data(),
                     outputs[p].normals);
    if (!outputs[p].tangents.first) continue;
    tangents_.run(rows[p], normals_, workspace.normals_, workspace.tangents_);
    write_vertices(kernels_, workspace.tangents_.tangents(), vertex_count(), place_of_, workspace.halves_.data(),
                   outputs[p].tangents);
  }
}

[[gnu::noinline]] void Evaluator::run_pose(const float* controls, const PoseOutput& output, RegionMask regions,
                                           Workspace& workspace) const {
  workspace.clamped_ += graph_.run(controls, 0, 1, workspace.features_);
  run_features_on<1>(&output, regions, workspace);
}

[[gnu::noinline]] void Evaluator::run_block(const float* controls, std::size_t stride,
                                            const PoseOutput (&outputs)[block_poses], RegionMask regions,
                                            Workspace& workspace) const {
  const std::uint64_t clamped = graph_.run(controls, stride, block_poses, workspace.features_);
  // Together, poses take all features that any of them needs, each at about a third of the time.
  if (workspace.features_.active().size() * block_poses > 3 * workspace.features_.moved_values()) {
    for (std::size_t p = 0; p < block_poses; ++p) run_pose(controls + p * stride, outputs[p], regions, workspace);
    return;
  }
  workspace.clamped_ += clamped;
  run_features_on<block_poses>(outputs, regions, workspace);
}

[[gnu::noinline]] void Evaluator::run_coefficients(const float* controls, RegionMask regions, float* coefficients,
                                                   Workspace& workspace) const {
  workspace.clamped_ += graph_.run(controls, 0, 1, workspace.features_);
  run_regions<1>(regions, workspace);
  for (std::size_t d = 0; d < direct_.size(); ++d) coefficients[d] = *workspace.features_[direct_[d]];
  for (std::size_t r = 0; r < nets_.size(); ++r)
    for (std::uint32_t c = first_coefficient_[r]; c < first_coefficient_[r + 1]; ++c)
      coefficients[c] = workspace.open_[r] ? workspace.coefficients_[c] : 0;
}

void Evaluator::evaluate(const float* controls, float* positions, Workspace& workspace,
                         std::size_t vertex_stride) const {
  refuse_nan(controls);
  const FloatState state;
  workspace.clamped_ = 0;
  run_pose(controls, {{positions, vertex_stride}, {}, {}}, {}, workspace);
}

void Evaluator::coefficients(const float* controls, float* coefficients, Workspace& workspace,
                             RegionMask regions) const {
  refuse_nan(controls);
  const FloatState state;
  workspace.clamped_ = 0;
  run_coefficients(controls, regions, coefficients, workspace);
}

}  // namespace fb
