#include "runtime/pose_execution.h"

#include <algorithm>
#include <cmath>

#include "model/feature_values.h"
#include "runtime/detail_vectors.h"

namespace fb::runtime {
namespace {

// Positions of faces of at least so many vertices are written block by block: by then rows, places and output do not
// fit a core's caches. At rest, 1,000,000 vertices in the source's order then took 4.4 to 4.5 ms, 5.0 to 7.2 ms
// gathered from all rows, on a machine that others used (`bench_growth --vertices 62000 250000 1000000`); smaller ones
// took longer.
constexpr std::size_t scattered_vertices = std::size_t(1) << 17;

// The places in an output of the vertices of a row block, which are to be written soon.
void prefetch_places(const EvaluationLayout& layout, const RowBlockMatrix& block, const VertexOutput& output) {
  if (!has_prefetch || output.order != VertexOrder::source || layout.order.empty()) return;
  const std::size_t number = output.format == NumberFormat::float16 ? sizeof(std::uint16_t) : sizeof(float);
  const std::uint32_t first = block.first_row() / 3;
  const std::uint32_t end = std::min(first + block.row_count() / 3, layout.meshes.surface_vertices);
  for (std::uint32_t v = first; v < end; ++v)
    __builtin_prefetch(static_cast<std::byte*>(output.first) + number * output.vertex_stride * layout.order[v], 1);
}

}  // namespace

// Writes the values of active features to the input lists; at a level, not to those of row blocks that it does not
// have.
template <std::size_t poses, bool at_level>
void PoseExecution::scatter_features() {
  using Entry = EvaluationLayout::ScatterEntry;
  constexpr std::size_t prefetch_distance = 8;  // in active features
  std::uint32_t* const ends = workspace_.list_ends_.data();
  std::copy_n(layout_.list_offsets.begin(), workspace_.list_ends_.size(), ends);
  float* const values = workspace_.list_values_.data();
  std::uint32_t* const columns = workspace_.list_columns_.data();
  const std::uint32_t* const offsets = layout_.scatter.row_offsets.data();
  const Entry* const entries = layout_.scatter.entries.data();
  const std::span<const std::uint32_t> active = workspace_.features_.active();
  const std::size_t left_out = at_level ? layout_.row_block_list(detail_.level->blocks) : 0;
  const std::size_t left_out_end =
      at_level ? layout_.row_block_list(with_carriers_ ? layout_.surface_blocks() : layout_.row_blocks.size()) : 0;
  for (std::size_t i = 0; i < active.size(); ++i) {
    if (i + prefetch_distance < active.size()) __builtin_prefetch(entries + offsets[active[i + prefetch_distance]]);
    float value[poses];
    std::copy_n(workspace_.features_[active[i]], poses, value);
    const Entry* const end = entries + offsets[active[i] + 1];
    for (const Entry* entry = entries + offsets[active[i]]; entry < end; ++entry) {
      if (at_level && entry->list >= left_out && entry->list < left_out_end) continue;
      const std::uint32_t at = ends[entry->list]++;
      columns[at] = entry->offset;
      for (std::size_t p = 0; p < poses; ++p) values[at * poses + p] = value[p] * entry->scale;
    }
  }
}

template <std::size_t poses>
void PoseExecution::find_gate_values(std::size_t region, float (&gates)[poses]) {
  std::fill_n(gates, poses, 1.0f);
  const float slope = layout_.gate_slopes[region];
  if (slope == 0) return;
  const MatrixInputs features = workspace_.list(layout_, layout_.gate_list(region), poses);
  float sum[poses] = {}, largest[poses] = {};
  for (std::size_t i = 0; i < features.count; ++i)
    for (std::size_t p = 0; p < poses; ++p) {
      const float size = std::fabs(features.values[i * poses + p]);
      sum[p] += size;
      largest[p] = size > largest[p] ? size : largest[p];
    }
  for (std::size_t p = 0; p < poses; ++p) {
    const float gate = slope * (sum[p] - largest[p]);
    gates[p] = gate > 0 ? (gate < 1 ? gate : 1) : 0;
  }
}

// Coefficients that the next level does not use come to 0 on the way there.
void PoseExecution::fade_coefficients(std::size_t region, std::size_t count, std::size_t poses) {
  const std::uint32_t first = layout_.coefficient_offsets[region];
  for (std::size_t c = first; c < first + count; ++c)
    for (std::size_t p = 0; !detail_.next->used[c] && p < poses; ++p)
      workspace_.coefficients_[c * poses + p] *= 1 - detail_.share;
}

template <std::size_t poses>
void PoseExecution::run_regions() {
  for (std::size_t r = 0; r < layout_.networks.size(); ++r) {
    const MatrixInputs inputs = workspace_.list(layout_, r, poses);
    workspace_.active_regions_[r] = 0;
    const RegionNetwork& network = layout_.networks[r];
    const std::size_t count = !detail_.level   ? network.output_count()
                              : with_carriers_ ? detail_.level->all_outputs[r]
                                               : detail_.level->outputs[r];
    if (inputs.count == 0 || count == 0 || !(regions_.empty() || regions_[r] != 0)) continue;
    float gates[poses];
    find_gate_values<poses>(r, gates);
    if (std::all_of(gates, gates + poses, [](float gate) { return gate == 0; })) continue;
    workspace_.active_regions_[r] = 1;
    float* coefficients = workspace_.coefficients_.data() + layout_.coefficient_offsets[r] * poses;
    network.run(layout_.kernels, inputs, poses, count, workspace_.layers_.data(), workspace_.layer_inputs_,
                coefficients);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t p = 0; p < poses; ++p, ++coefficients)
        *coefficients = zero_unless(gates[p] != 0, *coefficients * gates[p]);
    if (detail_.next) fade_coefficients(r, count, poses);
  }
}

// Appends the coefficients of active regions to the features in the row block's list, and quantises the list.
template <std::size_t poses>
void PoseExecution::quantise_inputs(std::size_t b, std::int16_t* to, QuantisedInputs& inputs) {
  const RowBlockMatrix& block = layout_.row_blocks[b];
  MatrixInputs list = workspace_.list(layout_, layout_.row_block_list(b), poses);
  for (const auto& [region, begin, end] :
       (detail_.level ? detail_.level->block_regions : layout_.row_block_regions).row(b)) {
    if (!workspace_.active_regions_[region]) continue;
    block.scale_coefficients<poses>({begin, end}, workspace_.coefficients_.data(), list.values + list.count * poses);
    for (std::uint32_t i = begin; i < end; ++i) list.offsets[list.count++] = block.offset(i);
  }
  inputs.count = 0;
  block.prefetch(list.offsets, list.count);
  if (list.count > 0) quantise(layout_.kernels, list, block.limit(), poses, to, nullptr, inputs);
}

// Adds the corrections of exact poses within reach to the rows of a block. Returns whether there are any. rest: copied
// to the rows first; null where they hold a pose.
bool PoseExecution::add_corrections(std::size_t pose, std::size_t b, const float* rest, float* rows) {
  if (layout_.exact.empty()) return false;
  const std::span<const ExactBlend::Weight> weights = layout_.exact.weights(pose, workspace_.exact_);
  if (weights.empty()) return false;
  if (rest) std::copy_n(rest, layout_.row_blocks[b].row_count(), rows);
  return layout_.exact.add(b, weights, rows);
}

// Writes the positions of a row block, whose rows are those of whole vertices.
void PoseExecution::scatter(std::size_t b, const float* rows, const PoseOutput& output) {
  const RowBlockMatrix& block = layout_.row_blocks[b];
  const std::uint32_t most = all_points_ ? layout_.meshes.vertices : layout_.meshes.surface_vertices;
  const VertexRange range = {block.first_row() / 3, std::min((block.first_row() + block.row_count()) / 3, most)};
  if (range.begin >= range.end) return;
  const bool to_source = output.positions.order == VertexOrder::source && !layout_.order.empty();
  scatter_vertices(layout_.kernels, rows, output.displacements ? layout_.rest_rows.data() + block.first_row() : nullptr,
                   range, to_source ? layout_.order.data() : nullptr, output.positions);
}

template <std::size_t poses>
void PoseExecution::run_row_block(std::size_t b, const QuantisedInputs& inputs, const RowTarget& target) {
  const RowBlockMatrix& block = layout_.row_blocks[b];
  const float* const rest = layout_.rest_rows.data() + block.first_row();
  float* to[poses];
  for (std::size_t p = 0; p < poses; ++p) to[p] = target.rows[p] + (target.of_one_block ? 0 : block.first_row());
  if (inputs.count > 0) block.run(inputs, rest, to);
  for (std::size_t p = 0; p < poses; ++p) {
    std::uint8_t& was_moved = workspace_.moved_[p * layout_.row_blocks.size() + b];
    bool moved = inputs.count > 0 && inputs.steps[p] != 0;
    if (!moved && !target.of_one_block && (inputs.count > 0 || was_moved || !target.in_workspace))
      std::copy_n(rest, block.row_count(), to[p]);
    if (add_corrections(p, b, target.of_one_block && !moved ? rest : nullptr, to[p])) moved = true;
    if (target.in_workspace) was_moved = moved;
    if (target.scattered) scatter(b, moved ? to[p] : rest, target.scattered[p]);
  }
}

// Row blocks first.. of a pass.
template <std::size_t poses>
void PoseExecution::run_pass(std::size_t first, std::int16_t* quantised, const RowTarget& target) {
  QuantisedInputs inputs[EvaluationLayout::row_blocks_per_pass];
  const std::size_t end = std::min(first + EvaluationLayout::row_blocks_per_pass, layout_.row_blocks.size());
  for (std::size_t b = first; b < end; ++b)
    if (is_posed(b))
      quantise_inputs<poses>(b, quantised + layout_.row_block_entries(first, b) * poses, inputs[b - first]);
  for (std::size_t b = first; b < end; ++b) {
    if (!is_posed(b)) continue;
    for (std::size_t p = 0; p < poses && target.scattered && b + 1 < end; ++p)
      prefetch_places(layout_, layout_.row_blocks[b + 1], target.scattered[p].positions);
    run_row_block<poses>(b, inputs[b - first], target);
  }
}

template <std::size_t poses>
void PoseExecution::run_row_blocks(const RowTarget& target) {
  constexpr std::size_t per_pass = EvaluationLayout::row_blocks_per_pass;
  const std::size_t passes = (layout_.row_blocks.size() + per_pass - 1) / per_pass;
  spread_.run(passes, [&](std::size_t pass, std::size_t worker) {
    Workspace& own = workspaces_[worker];
    RowTarget of_worker = target;
    float* const block_rows = own.block_rows_.data();
    if (target.of_one_block && worker > 0) of_worker.rows = &block_rows;  // one pose: others are not spread
    run_pass<poses>(pass * per_pass, own.quantised_.data(), of_worker);
  });
}

// The vertices that are written, as ranges in baked order.
template <class Visit>
void PoseExecution::visit_written(const Visit& visit) const {
  const std::uint32_t end = level_only_ && detail_.level ? detail_.level->vertices : layout_.meshes.surface().end;
  const auto visit_below = [&](VertexRange range) {
    range.end = std::min(range.end, end);
    if (range.begin < range.end) visit(range);
  };
  if (meshes_.empty()) visit_below(layout_.meshes.surface());
  for (std::size_t m = 0; m < meshes_.size(); ++m)
    if (meshes_[m])
      for (const VertexRange range : layout_.meshes.baked.row(m)) visit_below(range);
}

// `order`: of rows.
void PoseExecution::write(const float* rows, VertexOrder order, const VertexOutput& output, const float* rest) {
  const std::span<const std::uint32_t> other = order == VertexOrder::baked ? layout_.baked_index : layout_.order;
  const std::size_t vertices = level_only_ && detail_.level ? detail_.level->vertices
                               : all_points_                ? layout_.meshes.vertices
                                                            : layout_.vertex_count();
  const VertexWriter writer(layout_.kernels, {rows, 3 * vertices}, rest,
                            order == output.order ? std::span<const std::uint32_t>() : other, output,
                            workspace_.halves_.data());
  if (level_only_) return visit_written([&](VertexRange range) { write_range(writer, range); });
  if (meshes_.empty()) return write_range(writer, all_points_ ? layout_.meshes.all() : layout_.meshes.surface());
  for (std::size_t m = 0; m < meshes_.size(); ++m)
    if (meshes_[m]) {
      if (output.order == VertexOrder::source)
        write_range(writer, layout_.meshes.source[m]);
      else
        for (const VertexRange range : layout_.meshes.baked.row(m)) write_range(writer, range);
    }
}

void PoseExecution::write_range(const VertexWriter& writer, VertexRange range) const {
  spread_.run_ranges(range.end - range.begin, 256, [&](std::size_t begin, std::size_t end) {
    writer.write({static_cast<std::uint32_t>(range.begin + begin), static_cast<std::uint32_t>(range.begin + end)});
  });
}

// Whether all vertices of an output lie in memory as they do in an array of floats in this order.
bool PoseExecution::is_plain(const VertexOutput& output, VertexOrder order) const {
  return output.first && output.vertex_stride == 3 && !output.streamed && output.format == NumberFormat::float32 &&
         (layout_.baked_index.empty() || output.order == order);
}

// Whether positions are written block by block, while their rows are in the caches. At a level of detail they are not
// known before all rows are.
bool PoseExecution::scatters(const PoseOutput& output) const {
  return output.positions.first && !output.positions.streamed && !detail_.level && !detail_.next &&
         layout_.blocks_of_vertices && layout_.vertex_count() >= scattered_vertices;
}

void PoseExecution::write_bounds(const float* rows, float* bounds) const {
  bool empty = true;
  const auto add = [&](VertexRange range) {
    const float* const first = rows + 3 * std::size_t(range.begin);
    for (std::size_t axis = 0; axis < 3 && empty; ++axis) bounds[axis] = bounds[3 + axis] = first[axis];
    empty = false;
    for (const float *at = first, *end = rows + 3 * std::size_t(range.end); at < end; at += 3)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        bounds[axis] = at[axis] < bounds[axis] ? at[axis] : bounds[axis];
        bounds[3 + axis] = at[axis] > bounds[3 + axis] ? at[axis] : bounds[3 + axis];
      }
  };
  visit_written(add);
  if (empty) std::fill_n(bounds, bounds_floats, 0.0f);
}

void PoseExecution::write_channels(const float* rows, float* channels) const {
  rows += 3 * layout_.vertex_count();
  for (const Channel& channel : layout_.schema.channels) *channels++ = channel.value(*rows++);
}

// Moves the vertices of a pose to where they lie at the level of detail.
void PoseExecution::slide(std::size_t pose, float* rows, bool in_workspace) {
  const auto slide_range = [&](VertexRange range) {
    slide_vertices(layout_.details, detail_, range.begin, range.end, !level_only_, rows);
  };
  if (meshes_.empty()) slide_range(layout_.meshes.surface());
  for (std::size_t m = 0; m < meshes_.size(); ++m)
    if (meshes_[m])
      for (const VertexRange range : layout_.meshes.baked.row(m)) slide_range(range);
  const std::size_t first = (detail_.next ? detail_.next : detail_.level)->blocks, blocks = layout_.row_blocks.size();
  if (in_workspace)
    std::fill_n(workspace_.moved_.begin() + std::ptrdiff_t(pose * blocks + first), layout_.surface_blocks() - first,
                std::uint8_t(1));
}

void PoseExecution::write_outputs(std::size_t pose, const float* rows, const PoseOutput& output, bool positions) {
  if (positions && output.positions.first)
    write(rows, VertexOrder::baked, output.positions, output.displacements ? layout_.rest_rows.data() : nullptr);
  if (!output.normals.first && !output.tangents.first) return;
  const std::size_t blocks = layout_.row_blocks.size();
  const std::span<const std::uint8_t> moved = {workspace_.moved_.data() + pose * blocks, blocks};
  const auto compute = [&](const VertexNormals& normals, const VertexTangents& tangents,
                           PolygonGraph::State& of_normals, std::optional<PolygonGraph::State>& of_tangents) {
    normals.run(layout_.kernels, rows, moved, of_normals, spread_);
    if (output.tangents.first)
      tangents.run(layout_.kernels, rows, moved, normals, of_normals.results.data(), *of_tangents, spread_);
  };
  compute(detail_.level ? detail_.level->normals : layout_.normals,
          detail_.level ? detail_.level->tangents : layout_.tangents, workspace_.normals_, workspace_.tangents_);
  if (detail_.level || detail_.next) {
    if (detail_.next)
      compute(detail_.next->normals, detail_.next->tangents, *workspace_.next_normals_, workspace_.next_tangents_);
    return write_detail_vectors(output);
  }
  if (output.tangents.first) write(workspace_.tangents_->results.data(), VertexOrder::source, output.tangents);
  if (output.normals.first) write(workspace_.normals_.results.data(), VertexOrder::source, output.normals);
}

// Vectors of the whole are in the source's order, those of levels in baked order.
void PoseExecution::write_detail_vectors(const PoseOutput& output) {
  const std::span<const std::uint32_t> order = detail_.level ? std::span<const std::uint32_t>() : layout_.order;
  const auto blend = [&](const PolygonGraph::State& of_level, const PolygonGraph::State& of_next, const float* normals,
                         std::pmr::vector<float>& to) {
    blend_vectors(layout_.details, detail_, {of_level.results.data(), order, of_next.results.data()}, !level_only_,
                  normals, spread_, to.data());
  };
  std::pmr::vector<float>&normals = workspace_.detail_normals_, &tangents = workspace_.detail_tangents_;
  blend(workspace_.normals_, *workspace_.next_normals_, nullptr, normals);
  if (output.tangents.first) {
    blend(*workspace_.tangents_, *workspace_.next_tangents_, normals.data(), tangents);
    write(tangents.data(), VertexOrder::baked, output.tangents);
  }
  if (output.normals.first) write(normals.data(), VertexOrder::baked, output.normals);
}

// Moves vertices as the driven joints moved.
void PoseExecution::skin(std::size_t pose, float* rows) {
  const std::uint32_t end = level_only_ && detail_.level ? detail_.level->vertices : layout_.meshes.surface().end;
  std::uint8_t* const moved = workspace_.moved_.data() + pose * layout_.row_blocks.size();
  for (std::size_t i = 0; i < layout_.skin.blocks().size(); ++i) {
    const std::uint32_t b = layout_.skin.blocks()[i].number;
    if (!meshes_.empty() && !meshes_[layout_.meshes.row_block_meshes[b]]) continue;
    if (!layout_.skin.run(layout_.kernels, i, end, workspace_.skin_, rows)) continue;
    moved[b] = 1;
    if (!layout_.blocks_of_vertices && b + 1 < layout_.surface_blocks()) moved[b + 1] = 1;
  }
}

// attributes: whether positions, normals and tangents are still to be written; positions: whether positions are.
void PoseExecution::write_pose(std::size_t pose, float* rows, const PoseOutput& output, bool attributes,
                               bool positions) {
  const bool driven = !layout_.skin.empty(), unskinned = driven && (output.unskinned || output.displacements);
  if (output.channels) write_channels(rows, output.channels);
  if (unskinned) write_outputs(pose, rows, output, positions);
  if (driven) {
    layout_.skin.find_matrices(rows, workspace_.skin_);
    if (output.joints) layout_.skin.write_frames(workspace_.skin_, output.joints);
    if (!unskinned || output.sockets || output.bounds) skin(pose, rows);
  }
  if (output.sockets) layout_.sockets.run(rows, meshes_, output.sockets);
  if (output.bounds) write_bounds(rows, output.bounds);
  if (attributes && !unskinned) write_outputs(pose, rows, output, positions);
}

template <std::size_t poses>
void PoseExecution::run_features_on(const PoseOutput* outputs) {
  all_points_ = outputs[0].all_points;
  const bool driven = !layout_.skin.empty();
  with_carriers_ = outputs[0].channels || all_points_ || driven;
  detail_.level ? scatter_features<poses, true>() : scatter_features<poses, false>();
  run_regions<poses>();
  const PoseOutput& output = outputs[0];
  const bool attributes = output.normals.first || output.tangents.first;
  // Rows are written to the output itself if it has their order and format, and nothing else needs them.
  const bool direct = is_plain(output.positions, VertexOrder::baked) && !attributes && !output.channels &&
                      !output.displacements && !driven;
  const bool scattered = !direct && !driven && scatters(output);
  const bool kept = !scattered || attributes || output.sockets || output.channels || output.bounds;
  float* rows[poses];
  for (std::size_t p = 0; p < poses; ++p)
    rows[p] = direct ? static_cast<float*>(outputs[p].positions.first)
              : kept ? workspace_.rows_.data() + p * layout_.row_stride()
                     : workspace_.block_rows_.data() + p * layout_.max_block_rows;
  run_row_blocks<poses>({rows, kept && !direct, !kept, scattered ? outputs : nullptr});
  for (std::size_t p = 0; p < poses && (detail_.level || detail_.next); ++p) slide(p, rows[p], !direct);
  for (std::size_t p = 0; p < poses; ++p) write_pose(p, rows[p], outputs[p], !direct, !scattered);
}

void PoseExecution::run_pose(const float* controls, const PoseOutput& output) {
  workspace_.clamped_ += layout_.features.run(layout_.kernels, controls, 0, 1, workspace_.features_);
  layout_.exact.find_weights(controls, 0, workspace_.exact_);
  run_features_on<1>(&output);
}

void PoseExecution::run_block(const float* controls, std::size_t stride, const PoseOutput (&outputs)[poses_per_block]) {
  if (find_block_features(controls, stride)) return run_features_on<poses_per_block>(outputs);
  for (std::size_t p = 0; p < poses_per_block; ++p) run_pose(controls + p * stride, outputs[p]);
}

// Finds what poses_per_block poses are evaluated from. Returns whether they are to be evaluated together: a block
// evaluates the union of its poses' active features, at about a third of the time a feature. Unless poses share enough
// features, single poses are faster. See `facebaker bench`, "batch".
bool PoseExecution::find_block_features(const float* controls, std::size_t stride) {
  const std::uint64_t clamped =
      layout_.features.run(layout_.kernels, controls, stride, poses_per_block, workspace_.features_);
  if (workspace_.features_.active().size() * poses_per_block > 3 * workspace_.features_.nonzero_count()) return false;
  workspace_.clamped_ += clamped;
  for (std::size_t p = 0; p < poses_per_block; ++p)
    layout_.exact.find_weights(controls + p * stride, p, workspace_.exact_);
  return true;
}

// Driven joints are carried by row blocks behind those of the surface, which are multiplied here.
template <std::size_t poses>
void PoseExecution::run_quantised_on(const QuantisedOutput* outputs) {
  with_carriers_ = outputs[0].joints;
  scatter_features<poses, false>();
  run_regions<poses>();
  std::int16_t* const quantised = workspace_.quantised_.data();
  const std::size_t surface = layout_.surface_blocks();
  QuantisedInputs inputs;
  for (std::size_t b = 0, first = 0; b < surface; first += layout_.row_blocks[b++].input_count()) {
    const RowBlockMatrix& block = layout_.row_blocks[b];
    quantise_inputs<poses>(b, quantised, inputs);
    for (std::size_t p = 0; p < poses; ++p) {
      if (outputs[p].steps) outputs[p].steps[b] = inputs.count > 0 ? inputs.steps[p] : 0;
      if (!outputs[p].values) continue;
      std::int16_t* const values = outputs[p].values + first;
      std::fill_n(values, block.input_count(), std::int16_t(0));
      for (std::size_t i = 0; i < inputs.count && inputs.steps[p] != 0; ++i)
        if (const std::int16_t value = quantised[(i / 4 * poses + p) * 4 + i % 4]; value != 0)
          values[block.input_at(inputs.offsets[i])] = value;
    }
  }
  float* rows[poses];
  for (std::size_t p = 0; p < poses; ++p) rows[p] = workspace_.rows_.data() + p * layout_.row_stride();
  for (std::size_t b = surface; with_carriers_ && b < layout_.row_blocks.size(); ++b) {
    quantise_inputs<poses>(b, quantised, inputs);
    run_row_block<poses>(b, inputs, {rows, true});
  }
  for (std::size_t p = 0; p < poses; ++p) {
    layout_.exact.write_weights(p, workspace_.exact_, outputs[p].exact_weights);
    if (!outputs[p].joints) continue;
    layout_.skin.find_matrices(rows[p], workspace_.skin_);
    layout_.skin.write_frames(workspace_.skin_, outputs[p].joints);
  }
}

void PoseExecution::run_quantised(const float* controls, const QuantisedOutput& output) {
  workspace_.clamped_ += layout_.features.run(layout_.kernels, controls, 0, 1, workspace_.features_);
  layout_.exact.find_weights(controls, 0, workspace_.exact_);
  run_quantised_on<1>(&output);
}

void PoseExecution::run_quantised_block(const float* controls, std::size_t stride,
                                        const QuantisedOutput (&outputs)[poses_per_block]) {
  if (find_block_features(controls, stride)) return run_quantised_on<poses_per_block>(outputs);
  for (std::size_t p = 0; p < poses_per_block; ++p) run_quantised(controls + p * stride, outputs[p]);
}

void PoseExecution::run_coefficients(const float* controls, float* coefficients) {
  workspace_.clamped_ += layout_.features.run(layout_.kernels, controls, 0, 1, workspace_.features_);
  scatter_features<1, false>();
  run_regions<1>();
  for (std::size_t d = 0; d < layout_.direct.size(); ++d) coefficients[d] = *workspace_.features_[layout_.direct[d]];
  for (std::size_t r = 0; r < layout_.networks.size(); ++r)
    for (std::uint32_t c = layout_.coefficient_offsets[r]; c < layout_.coefficient_offsets[r + 1]; ++c)
      coefficients[c] = workspace_.active_regions_[r] ? workspace_.coefficients_[c] : 0;
}

}  // namespace fb::runtime
