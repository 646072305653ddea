#include "runtime/evaluator.h"

#include <algorithm>
#include <cmath>

#include "base/checked.h"
#include "base/status.h"
#include "model/feature_values.h"
#include "runtime/float_state.h"
#include "runtime/grouped.h"

namespace fb::runtime {
namespace {

std::vector<std::uint32_t> places_of(const std::vector<std::uint32_t>& order) {
  std::vector<std::uint32_t> places(order.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) places[order[i]] = i;
  return places;
}

std::vector<std::uint32_t> first_rows(const PackedModel& model) {
  std::vector<std::uint32_t> rows;
  for (const PackedRowBlock& group : model.row_blocks) rows.push_back(group.first_row);
  rows.push_back(checked_u32(model.rest.points.size(), "the rows of the basis"));
  return rows;
}

// `pages` if the whole numbers of layers and basis, most of which take a byte, fill one.
std::pmr::memory_resource& memory_for(const PackedModel& model, LargePages& pages) {
  std::size_t bytes = 0;
  for (const PackedRegion& region : model.regions)
    for (const PackedLayer& layer : region.layers) bytes += layer.weights.size();
  for (const PackedRowBlock& group : model.row_blocks) bytes += group.values.size();
  return bytes < LargePages::page ? *std::pmr::get_default_resource() : pages;
}

// So many steps ahead is asked for what lies here and there.
constexpr std::size_t ahead = 8;

}  // namespace

Workspace::Workspace(const Evaluator& evaluator, std::pmr::memory_resource& memory)
    : features_(evaluator.graph_, memory),
      values_(evaluator.first_in_list_.back() * block_poses, &memory),
      places_(evaluator.first_in_list_.back(), &memory),
      ends_(evaluator.first_in_list_.size() - 1, &memory),
      quantised_(evaluator.most_summands_ * block_poses, &memory),
      open_(evaluator.nets_.size(), &memory),
      coefficients_(evaluator.coefficient_count() * block_poses, &memory),
      layers_(evaluator.work_size_ * block_poses, &memory),
      rows_((evaluator.rest_rows_.size() + 1) * block_poses, &memory),  // whole vectors are read
      moved_(evaluator.chunks_.size() * block_poses, &memory),
      halves_(evaluator.rest_rows_.size() + 1, &memory),
      layer_inputs_(evaluator.widest_layer_, block_poses, memory),
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
      direct_(&memory_),
      first_coefficient_(&memory_),
      first_in_list_(&memory_),
      uses_(&memory_),
      uses_begin_(&memory_),
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
  direct_.reserve(model.direct.size());
  for (const std::uint32_t feature : model.direct) direct_.push_back(graph_.number(feature));
  nets_.reserve(model.regions.size());
  std::size_t coefficient = direct_.size();
  for (const PackedRegion& region : model.regions) {
    RegionNet& net = nets_.emplace_back(region, memory_);
    net.find_rest(kernels_, region.name.c_str());
    region_names_.push_back(region.name);
    slopes_.push_back(region.gate.features.empty() ? 0 : region.gate.slope);
    first_coefficient_.push_back(static_cast<std::uint32_t>(coefficient));
    coefficient += net.output_count();
    widest_layer_ = std::max(widest_layer_, net.widest());
    work_size_ = std::max(work_size_, net.work_size());
  }
  first_coefficient_.push_back(static_cast<std::uint32_t>(coefficient));
  chunks_.reserve(model.row_blocks.size());
  for (const PackedRowBlock& group : model.row_blocks) chunks_.emplace_back(group, memory_);
  lay_out_lists(model);
  lay_out_uses(model);
}

void Evaluator::lay_out_lists(const PackedModel& model) {
  std::size_t numbers = 0;
  const auto add = [&](std::size_t longest) {
    first_in_list_.push_back(checked_u32(numbers, "the numbers of all lists"));
    numbers += longest + padding;
  };
  for (const RegionNet& net : nets_) add(net.input_count());
  for (const PackedRegion& region : model.regions) add(region.gate.features.size());
  for (const RowBlockMatrix& chunk : chunks_) add(chunk.summand_count());
  first_in_list_.push_back(checked_u32(numbers, "the numbers of all lists"));
  for (std::size_t first = 0; first < chunks_.size(); first += some_chunks) {
    const std::size_t end = std::min(first + some_chunks, chunks_.size());
    most_summands_ =
        std::max<std::size_t>(most_summands_, first_in_list_[chunk_list(end)] - first_in_list_[chunk_list(first)]);
  }
}

void Evaluator::lay_out_uses(const PackedModel& model) {
  const std::size_t direct = direct_.size();
  Grouped<Use> uses(model.features.size());
  for (std::uint32_t r = 0; r < model.regions.size(); ++r) {
    const PackedRegion& region = model.regions[r];
    for (std::uint32_t i = 0; i < region.features.size(); ++i) uses.add(graph_.number(region.features[i]), {r, i, 1});
    for (const std::uint32_t feature : region.gate.features)
      uses.add(graph_.number(feature), {static_cast<std::uint32_t>(gate_list(r)), 0, 1});
  }
  Grouped<ChunkRegion> regions(chunks_.size());
  for (std::uint32_t c = 0; c < chunks_.size(); ++c) {
    const RowBlockMatrix& chunk = chunks_[c];
    for (std::uint32_t s = 0; s < chunk.summand_count(); ++s)
      if (chunk.column(s) < direct)
        uses.add(direct_[chunk.column(s)], {static_cast<std::uint32_t>(chunk_list(c)), s, chunk.scale(s)});
    for (std::uint32_t r = 0; r < nets_.size(); ++r) {
      const auto [low, high] = chunk.summands_of(first_coefficient_[r], first_coefficient_[r + 1]);
      for (const RowBlockMatrix::Span span : {low, high})
        if (span.begin < span.end) regions.add(c, {r, span.begin, span.end});
    }
  }
  uses.move_to(uses_, uses_begin_);
  regions.move_to(chunk_regions_, chunk_regions_begin_);
}

std::size_t Evaluator::find_nan(const float* controls) const {
  if (!kernels_.any_nan(controls, control_count())) return control_count();
  return std::find_if(controls, controls + control_count(), [](float v) { return v != v; }) - controls;
}

void Evaluator::refuse_nan(const float* controls) const {
  const std::size_t control = find_nan(controls);
  if (control < control_count())
    fail(Status::not_finite, "control \"%s\" is not a number", schema_.controls[control].name.c_str());
}

template <std::size_t poses>
void Evaluator::gather_lists(Workspace& workspace) const {
  std::uint32_t* const ends = workspace.ends_.data();
  std::copy_n(first_in_list_.begin(), workspace.ends_.size(), ends);
  float* const values = workspace.values_.data();
  std::uint32_t* const places = workspace.places_.data();
  const std::uint32_t* const begin = uses_begin_.data();
  const std::span<const std::uint32_t> active = workspace.features_.active();
  for (std::size_t i = 0; i < active.size(); ++i) {
    if (i + ahead < active.size()) __builtin_prefetch(uses_.data() + begin[active[i + ahead]]);
    float value[poses];
    std::copy_n(workspace.features_[active[i]], poses, value);
    const Use* const end = uses_.data() + begin[active[i] + 1];
    for (const Use* use = uses_.data() + begin[active[i]]; use < end; ++use) {
      const std::uint32_t at = ends[use->list]++;
      places[at] = use->place;
      for (std::size_t p = 0; p < poses; ++p) values[at * poses + p] = value[p] * use->scale;
    }
  }
}

template <std::size_t poses>
void Evaluator::run_regions(RegionMask regions, Workspace& workspace) const {
  for (std::size_t r = 0; r < nets_.size(); ++r) {
    const PoseNumbers inputs = numbers(r, poses, workspace);
    workspace.open_[r] = 0;
    if (inputs.count == 0 || !(regions.empty() || regions[r] != 0)) continue;
    float gate_value[poses];
    std::fill_n(gate_value, poses, 1.0f);
    if (slopes_[r] != 0) {
      const PoseNumbers watched = numbers(gate_list(r), poses, workspace);
      float sum[poses] = {}, most[poses] = {};
      for (std::size_t i = 0; i < watched.count; ++i)
        for (std::size_t p = 0; p < poses; ++p) {
          const float size = std::fabs(watched.values[i * poses + p]);
          sum[p] += size;
          most[p] = size > most[p] ? size : most[p];
        }
      for (std::size_t p = 0; p < poses; ++p) {
        const float gate = slopes_[r] * (sum[p] - most[p]);
        gate_value[p] = gate > 0 ? (gate < 1 ? gate : 1) : 0;
      }
    }
    if (std::all_of(gate_value, gate_value + poses, [](float o) { return o == 0; })) continue;
    workspace.open_[r] = 1;
    float* coefficients = workspace.coefficients_.data() + first_coefficient_[r] * poses;
    nets_[r].run(kernels_, inputs, poses, workspace.layers_.data(), workspace.layer_inputs_, coefficients);
    for (std::size_t i = 0; i < nets_[r].output_count(); ++i)
      for (std::size_t p = 0; p < poses; ++p, ++coefficients)
        *coefficients = zero_unless(gate_value[p] != 0, *coefficients * gate_value[p]);
  }
}

template <std::size_t poses>
void Evaluator::round_summands(std::size_t c, Workspace& workspace, std::int16_t* quantised,
                               Quantized& summands) const {
  const RowBlockMatrix& chunk = chunks_[c];
  PoseNumbers list = numbers(chunk_list(c), poses, workspace);
  for (std::uint32_t u = chunk_regions_begin_[c]; u < chunk_regions_begin_[c + 1]; ++u) {
    const auto [region, begin, end] = chunk_regions_[u];
    if (!workspace.open_[region]) continue;
    chunk.weigh<poses>({begin, end}, workspace.coefficients_.data(), list.values + list.count * poses);
    for (std::uint32_t s = begin; s < end; ++s) list.places[list.count++] = s;
  }
  summands.count = 0;
  chunk.fetch(list.places, list.count);
  if (list.count > 0) quantize(kernels_, list, chunk.limit(), poses, quantised, summands);
}

// Some chunks' summands are rounded before any of these are multiplied, so that the processor need not wait for one to
// begin the next, and not more than its caches hold.
template <std::size_t poses>
void Evaluator::run_chunks(float* const* rows, Workspace& workspace) const {
  const bool kept = rows[0] == workspace.rows_.data();
  Quantized rounded[some_chunks];
  for (std::size_t first = 0; first < chunks_.size(); first += some_chunks) {
    const std::size_t end = std::min(first + some_chunks, chunks_.size());
    for (std::size_t c = first; c < end; ++c) {
      const std::size_t place = first_in_list_[chunk_list(c)] - first_in_list_[chunk_list(first)];
      round_summands<poses>(c, workspace, workspace.quantised_.data() + place * poses, rounded[c - first]);
    }
    for (std::size_t c = first; c < end; ++c) {
      const RowBlockMatrix& chunk = chunks_[c];
      const Quantized& summands = rounded[c - first];
      const float* rest = rest_rows_.data() + chunk.first_row();
      float* to[poses];
      for (std::size_t p = 0; p < poses; ++p) to[p] = rows[p] + chunk.first_row();
      if (summands.count > 0) chunk.run(kernels_, summands, rest, to);
      for (std::size_t p = 0; p < poses; ++p) {
        std::uint8_t& was_moved = workspace.moved_[p * chunks_.size() + c];
        const bool moved = summands.count > 0 && summands.steps[p] != 0;
        if (!moved && !(kept && !was_moved)) std::copy_n(rest, chunk.row_count(), to[p]);
        if (kept) was_moved = moved;
      }
    }
  }
}

template <std::size_t poses>
void Evaluator::run_features_on(const PoseOutput* outputs, RegionMask regions, Workspace& workspace) const {
  gather_lists<poses>(workspace);
  run_regions<poses>(regions, workspace);
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
  workspace.clamped_ += graph_.run(kernels_, controls, 0, 1, workspace.features_);
  run_features_on<1>(&output, regions, workspace);
}

[[gnu::noinline]] void Evaluator::run_block(const float* controls, std::size_t stride,
                                            const PoseOutput (&outputs)[block_poses], RegionMask regions,
                                            Workspace& workspace) const {
  const std::uint64_t clamped = graph_.run(kernels_, controls, stride, block_poses, workspace.features_);
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
  workspace.clamped_ += graph_.run(kernels_, controls, 0, 1, workspace.features_);
  gather_lists<1>(workspace);
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

}  // namespace fb::runtime
