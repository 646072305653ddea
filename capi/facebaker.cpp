#include <facebaker/facebaker.h>

#include <atomic>
#include <cstdio>
#include <memory>
#include <span>
#include <utility>

#include "abi_guard.h"
#include "archive/reader.h"
#include "base/mapped_file.h"
#include "base/memory_budget.h"
#include "base/shown_path.h"
#include "base/visible_text.h"
#include "batch_reader.h"
#include "control_struct.h"
#include "loaded_model.h"
#include "runtime/float_mode.h"
#include "scratch.h"
#include "stream_reader.h"
#include "version.h"

using fb::fail;
using fb::Status;
using fb::capi::abi_guard;
using fb::capi::fill_struct;
using fb::capi::read_struct;
using fb::capi::release;
using fb::capi::require;
using fb::capi::retain;
using fb::capi::ScratchUse;

namespace {

thread_local char last_error[2048];

// read(budget) returns the archive, in memory charged to the budget.
template <class Read>
fb_model* load(const fb_load_desc& desc, Read&& read) {
  std::unique_ptr<fb_model> model;
  std::vector<std::string> notes;
  fb::runtime::with_float_mode([&] {
    // Outlives the archive, whether the model is made or not.
    const auto memory = std::make_shared<fb::capi::LoadMemory>(desc);
    fb::archive::Archive archive = read(memory->budget);
    notes = std::move(archive.notes);
    model = std::make_unique<fb_model>(std::move(archive), desc, memory);
  });
  if (desc.log)
    for (const std::string& note : notes) desc.log(desc.log_user, note.c_str());
  return model.release();
}

fb::archive::Archive read_bytes(std::span<const std::byte> bytes, const fb_load_desc& desc, fb::MemoryBudget& budget) {
  const fb::archive::ReadLimits limits = {desc.max_model_bytes, desc.max_name_bytes, desc.max_vertices,
                                          desc.max_polygons, desc.max_features};
  const fb::Parallel parallel = {static_cast<int>(std::min<std::uint32_t>(desc.threads, INT32_MAX)), desc.parallel_for,
                                 desc.parallel_user};
  return fb::archive::read_archive(bytes, limits, fb::archive::Parts::all, budget, parallel);
}

fb_load_desc read_load_desc(const fb_load_desc* given) {
  fb_load_desc desc;
  fb_load_desc_init(&desc);
  if (given) desc = read_struct(*given, fb_load_desc_init, "fb_load_desc");
  if (!desc.allocator.allocate != !desc.allocator.release)
    fail(Status::invalid_argument, "fb_load_desc: an allocator needs both functions or none");
  return desc;
}

[[noreturn]] void fail_unknown_control(const fb::RigSchema& schema, std::string_view name) {
  std::string message = "there is no control \"" + fb::shown(name) + "\"";
  const std::string_view closest = schema.closest(name);
  if (!closest.empty()) message += "; the closest is \"" + fb::shown(closest) + "\"";
  fail(Status::not_found, "%s", message.c_str());
}

const fb::runtime::RowBlockMatrix& row_block_at(const fb_model* model, std::uint32_t index) {
  require(model, "model");
  const std::span<const fb::runtime::RowBlockMatrix> blocks = model->evaluator.row_blocks();
  if (index >= blocks.size()) fail(Status::invalid_argument, "row block %u of %zu", index, blocks.size());
  return blocks[index];
}

}  // namespace

fb_status fb::capi::report(Status status, const char* message) noexcept {
  char visible[sizeof last_error];  // the message may be the last one
  const std::size_t length =
      fb::write_visible_text(message, fb::Layout::kept, std::span(visible).first(sizeof visible - 1));
  std::memcpy(last_error, visible, length);
  last_error[length] = '\0';
  return static_cast<fb_status>(status);
}

extern "C" {

// ---- Status and version ----

const char* fb_status_name(fb_status status) {
  switch (status) {
    case FB_OK:
      return "FB_OK";
    case FB_ERROR_INVALID_ARGUMENT:
      return "FB_ERROR_INVALID_ARGUMENT";
    case FB_ERROR_NOT_FOUND:
      return "FB_ERROR_NOT_FOUND";
    case FB_ERROR_IO:
      return "FB_ERROR_IO";
    case FB_ERROR_NOT_AN_ARCHIVE:
      return "FB_ERROR_NOT_AN_ARCHIVE";
    case FB_ERROR_CORRUPT:
      return "FB_ERROR_CORRUPT";
    case FB_ERROR_UNSUPPORTED:
      return "FB_ERROR_UNSUPPORTED";
    case FB_ERROR_LIMIT:
      return "FB_ERROR_LIMIT";
    case FB_ERROR_OUT_OF_MEMORY:
      return "FB_ERROR_OUT_OF_MEMORY";
    case FB_ERROR_NOT_FINITE:
      return "FB_ERROR_NOT_FINITE";
    case FB_ERROR_BAD_DATA:
      return "FB_ERROR_BAD_DATA";
    case FB_ERROR_RIG:
      return "FB_ERROR_RIG";
    case FB_ERROR_INTERRUPTED:
      return "FB_ERROR_INTERRUPTED";
    case FB_ERROR_INTERNAL:
      return "FB_ERROR_INTERNAL";
    default:
      return "unknown status";
  }
}

const char* fb_last_error(void) {
  return last_error;
}

const char* fb_version_string(void) {
  return FB_VERSION_STRING;
}

uint32_t fb_version(void) {
  return FB_VERSION_MAJOR * 1000000u + FB_VERSION_MINOR * 1000u + FB_VERSION_PATCH;
}

uint32_t fb_format_version(void) {
  return fb::archive::archive_format_version();
}

// ---- Loading ----

void fb_load_desc_fill(fb_load_desc* to, uint32_t struct_size) {
  fb_load_desc defaults = {};
  const fb::archive::ReadLimits limits;
  defaults.max_file_bytes = defaults.max_model_bytes = limits.max_model_bytes;
  defaults.max_name_bytes = limits.max_name_bytes;
  defaults.max_vertices = limits.max_vertices;
  defaults.max_polygons = limits.max_polygons;
  defaults.max_features = limits.max_features;
  defaults.threads = 1;
  fill_struct(to, struct_size, defaults);
}

fb_status fb_load(const char* path, const fb_load_desc* desc, fb_model** model) {
  return abi_guard([&] {
    require(path, "path");
    require(model, "model");
    const fb_load_desc known = read_load_desc(desc);
    const fb::InputFile file(reinterpret_cast<const char8_t*>(path), known.max_file_bytes);
    const auto read = [&](fb::MemoryBudget& budget) {
      if (known.map_file) return read_bytes(fb::MappedFile(file).bytes(), known, budget);
      std::pmr::vector<std::byte> bytes(&budget);
      file.read_all(bytes);
      return read_bytes(bytes, known, budget);
    };
    *model = fb::with_path(file.path(), [&] { return load(known, read); });
  });
}

fb_status fb_load_memory(const void* bytes, size_t size, const fb_load_desc* desc, fb_model** model) {
  return abi_guard([&] {
    require(bytes, "bytes");
    require(model, "model");
    const fb_load_desc known = read_load_desc(desc);
    *model = load(known, [&](fb::MemoryBudget& budget) {
      return read_bytes({static_cast<const std::byte*>(bytes), size}, known, budget);
    });
  });
}

fb_status fb_load_stream(fb_read read, void* user, const fb_load_desc* desc, fb_model** model) {
  return abi_guard([&] {
    if (!read) fail(Status::invalid_argument, "read is null");
    require(model, "model");
    const fb_load_desc known = read_load_desc(desc);
    *model = load(known, [&](fb::MemoryBudget& budget) {
      return read_bytes(fb::capi::read_stream(read, user, known.max_file_bytes, budget), known, budget);
    });
  });
}

void fb_retain(fb_model* model) {
  if (model) retain(model);
}

void fb_release(fb_model* model) {
  if (model) release(model);
}

// ---- Contents ----

uint32_t fb_vertex_count(const fb_model* model) {
  return model ? static_cast<uint32_t>(model->evaluator.vertex_count()) : 0;
}

uint32_t fb_control_count(const fb_model* model) {
  return model ? static_cast<uint32_t>(model->evaluator.control_count()) : 0;
}

uint32_t fb_coefficient_count(const fb_model* model) {
  return model ? static_cast<uint32_t>(model->evaluator.coefficient_count()) : 0;
}

const char* fb_name(const fb_model* model) {
  return model ? model->evaluator.schema().name.c_str() : nullptr;
}

const char* fb_units(const fb_model* model) {
  return model ? model->evaluator.schema().units.c_str() : nullptr;
}

const char* fb_up_axis(const fb_model* model) {
  return model ? model->evaluator.schema().up_axis.c_str() : nullptr;
}

const char* fb_provenance(const fb_model* model) {
  return model ? model->provenance.c_str() : nullptr;
}

void fb_control_fill(fb_control* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_control_at(const fb_model* model, uint32_t index, fb_control* control) {
  return abi_guard([&] {
    require(model, "model");
    require(control, "control");
    fb::capi::require_size(control->struct_size, "fb_control");
    const auto& controls = model->evaluator.schema().controls;
    if (index >= controls.size()) fail(Status::invalid_argument, "control %u of %zu", index, controls.size());
    fb_control full = fb::capi::control_struct(model->evaluator.schema(), index);
    full.struct_size = control->struct_size;
    std::memcpy(control, &full, std::min<std::size_t>(control->struct_size, sizeof full));
  });
}

fb_status fb_find_control(const fb_model* model, const char* name, uint32_t* index) {
  return abi_guard([&] {
    require(model, "model");
    require(name, "name");
    require(index, "index");
    const fb::RigSchema& schema = model->evaluator.schema();
    const auto found = schema.find(name);
    if (!found) fail_unknown_control(schema, name);
    *index = static_cast<uint32_t>(*found);
  });
}

const float* fb_rest_controls(const fb_model* model) {
  return model ? model->rest_pose.data() : nullptr;
}

const float* fb_rest_positions(const fb_model* model) {
  return model ? model->evaluator.rest_positions().data() : nullptr;
}

double fb_diagonal(const fb_model* model) {
  return model ? model->diagonal : 0;
}

uint32_t fb_polygon_count(const fb_model* model) {
  return model ? static_cast<uint32_t>(model->polygon_sizes.size()) : 0;
}

const uint32_t* fb_polygon_sizes(const fb_model* model) {
  return model ? model->polygon_sizes.data() : nullptr;
}

uint32_t fb_polygon_corner_count(const fb_model* model) {
  return model ? static_cast<uint32_t>(model->polygon_corners.size()) : 0;
}

const uint32_t* fb_polygon_corners(const fb_model* model) {
  return model ? model->polygon_corners.data() : nullptr;
}

uint32_t fb_uv_count(const fb_model* model) {
  return model ? static_cast<uint32_t>(model->uvs.size() / 2) : 0;
}

const float* fb_uvs(const fb_model* model) {
  return model ? model->uvs.data() : nullptr;
}

const uint32_t* fb_uv_corners(const fb_model* model) {
  return model ? model->uv_corners.data() : nullptr;
}

const float* fb_tangent_signs(const fb_model* model) {
  return model && fb_uv_count(model) > 0 ? model->evaluator.tangent_signs().data() : nullptr;
}

uint64_t fb_runtime_bytes(const fb_model* model) {
  return model ? model->evaluator.bytes() : 0;
}

const char* fb_instruction_set(const fb_model* model) {
  return model ? model->evaluator.kernels().name : nullptr;
}

uint32_t fb_region_count(const fb_model* model) {
  return model ? static_cast<uint32_t>(model->evaluator.region_names().size()) : 0;
}

const char* fb_region_name(const fb_model* model, uint32_t index) {
  return index < fb_region_count(model) ? model->evaluator.region_names()[index].c_str() : nullptr;
}

// ---- The basis ----

const uint32_t* fb_vertex_order(const fb_model* model) {
  return model && !model->evaluator.order().empty() ? model->evaluator.order().data() : nullptr;
}

void fb_row_block_fill(fb_row_block* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

uint32_t fb_row_block_count(const fb_model* model) {
  return model ? static_cast<uint32_t>(model->evaluator.row_blocks().size()) : 0;
}

fb_status fb_row_block_at(const fb_model* model, uint32_t index, fb_row_block* block) {
  return abi_guard([&] {
    require(block, "block");
    fb::capi::require_size(block->struct_size, "fb_row_block");
    const fb::runtime::RowBlockMatrix& found = row_block_at(model, index);
    const fb_row_block full = {block->struct_size, found.first_row(), found.row_count(),
                               static_cast<std::uint32_t>(found.column_count()),
                               static_cast<std::uint32_t>(found.input_count())};
    std::memcpy(block, &full, std::min<std::size_t>(block->struct_size, sizeof full));
  });
}

fb_status fb_row_block_values(const fb_model* model, uint32_t index, uint32_t* columns, float* values) {
  return abi_guard([&] {
    require(columns, "columns");
    require(values, "values");
    const fb::runtime::RowBlockMatrix& found = row_block_at(model, index);
    fb::runtime::with_float_mode([&] {
      for (std::size_t c = 0; c < found.column_count(); ++c) {
        columns[c] = found.column(c);
        found.displacements(c, values + c * found.row_count());
      }
    });
  });
}

fb_status fb_row_block_digits(const fb_model* model, uint32_t index, uint32_t* columns, float* scales, int8_t* digits) {
  return abi_guard([&] {
    require(columns, "columns");
    require(scales, "scales");
    require(digits, "digits");
    const fb::runtime::RowBlockMatrix& found = row_block_at(model, index);
    for (std::size_t c = 0; c < found.input_count(); ++c) {
      columns[c] = found.column(c);
      scales[c] = found.scale(c);
      for (std::uint32_t r = 0; r < found.row_count(); ++r) *digits++ = static_cast<int8_t>(found.digit(r, c));
    }
  });
}

// ---- Posing ----

static fb_status create_scratch(const fb_model* model, uint32_t workers, std::size_t poses, fb_scratch** scratch) {
  return abi_guard([&] {
    require(model, "model");
    require(scratch, "scratch");
    if (workers == 0) fail(Status::invalid_argument, "workers is 0");
    *scratch = new fb_scratch(model, workers, poses);
  });
}

fb_status fb_scratch_create(const fb_model* model, uint32_t workers, fb_scratch** scratch) {
  return create_scratch(model, workers, fb::runtime::poses_per_block, scratch);
}

fb_status fb_scratch_create_single(const fb_model* model, uint32_t workers, fb_scratch** scratch) {
  return create_scratch(model, workers, 1, scratch);
}

void fb_scratch_destroy(fb_scratch* scratch) {
  delete scratch;
}

fb_status fb_evaluate(const fb_model* model, fb_scratch* scratch, const float* controls, float* positions) {
  return abi_guard([&] {
    require(model, "model");
    require(scratch, "scratch");
    require(controls, "controls");
    require(positions, "positions");
    const ScratchUse use(scratch, model);
    model->evaluator.evaluate(controls, positions, scratch->workspaces[0]);
    scratch->clamped = scratch->workspaces[0].clamped();
  });
}

fb_status fb_evaluate_coefficients(const fb_model* model, fb_scratch* scratch, const float* controls,
                                   float* coefficients) {
  return abi_guard([&] {
    require(model, "model");
    require(scratch, "scratch");
    require(controls, "controls");
    require(coefficients, "coefficients");
    const ScratchUse use(scratch, model);
    model->evaluator.coefficients(controls, coefficients, scratch->workspaces[0]);
    scratch->clamped = scratch->workspaces[0].clamped();
  });
}

uint32_t fb_digit_column_count(const fb_model* model) {
  return model ? static_cast<uint32_t>(model->evaluator.digit_column_count()) : 0;
}

void fb_quantised_desc_fill(fb_quantised_desc* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_evaluate_quantised(const fb_model* model, fb_scratch* scratch, const fb_quantised_desc* desc) {
  return abi_guard([&] {
    require(model, "model");
    require(scratch, "scratch");
    require(desc, "desc");
    const ScratchUse use(scratch, model);
    fb::capi::evaluate_quantised(*scratch, *desc);
  });
}

fb_status fb_expected_error(const fb_model* model, fb_scratch* scratch, const float* controls, float* errors,
                            uint32_t* outside) {
  return abi_guard([&] {
    require(model, "model");
    require(scratch, "scratch");
    require(controls, "controls");
    const ScratchUse use(scratch, model);
    model->evaluator.expected_errors(controls, errors, outside, scratch->workspaces[0]);
  });
}

uint64_t fb_clamped_count(const fb_scratch* scratch) {
  return scratch ? scratch->clamped.load() : 0;
}

void fb_batch_desc_fill(fb_batch_desc* to, uint32_t struct_size) {
  fill_struct(to, struct_size, {});
}

fb_status fb_evaluate_batch(const fb_model* model, fb_scratch* scratch, const fb_batch_desc* desc) {
  return abi_guard([&] {
    require(model, "model");
    require(scratch, "scratch");
    require(desc, "desc");
    const ScratchUse use(scratch, model);
    scratch->clamped = fb::capi::evaluate_batch(fb::capi::ScratchPart(*scratch), fb::capi::read_batch_desc(*desc));
  });
}

}  // extern "C"
