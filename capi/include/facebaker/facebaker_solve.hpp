/** @file
 * Derivatives and solving for C++17: the solver of facebaker_solve.h as an object, its statuses as exceptions. Header
 * only, without an ABI of its own; what facebaker_solve.h says of shapes, units, threads and errors holds here too.
 */
#ifndef FACEBAKER_FACEBAKER_SOLVE_HPP
#define FACEBAKER_FACEBAKER_SOLVE_HPP

#include <facebaker/facebaker_solve.h>
#include <facebaker/facebaker.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace facebaker {

/** Derivatives by columns: what sparse matrices of other libraries are made of. */
struct SparseColumns {
  std::vector<std::uint64_t> starts;  ///< of each chosen control, and how many entries there are: one more than chosen
  std::vector<std::uint32_t> rows;    ///< of entries that are not 0, ascending in each column
  std::vector<float> values;          ///< their derivatives
};

/** Points, sockets and joints of a face that are followed, with working memory, one object for each thread; keeps its
 * face loaded. */
class Solver {
 public:
  /** Of all vertices, or of what `desc` says; see fb_solver_create. */
  explicit Solver(const Model& model, const fb_solver_desc* desc = nullptr) : model_(model) {
    check(fb_solver_create(model_.get(), desc, &handle_));
  }
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;
  ~Solver() { fb_solver_destroy(handle_); }

  /** The face. */
  const Model& model() const noexcept { return model_; }
  /** Its points. */
  std::uint32_t point_count() const { return fb_solver_point_count(handle_); }
  /** The numbers that it follows: 3 a point, then 12 a frame, of sockets and then of joints. */
  std::uint32_t row_count() const { return fb_solver_row_count(handle_); }

  /** Derivatives with all that can be said of them; allocates nothing. See fb_jacobian. */
  void jacobian(const fb_jacobian_desc& desc) { check(fb_jacobian(handle_, &desc)); }
  /** Of all controls, dense. controls: control_count() floats of the model; derivatives: row_count() rows of as many.
   */
  void jacobian(const float* controls, float* derivatives) {
    fb_jacobian_desc desc;
    fb_jacobian_desc_init(&desc);
    desc.controls = controls;
    desc.derivatives = derivatives;
    desc.derivative_floats = std::uint64_t(row_count()) * model_.control_count();
    jacobian(desc);
  }
  /** The same by columns, of the pose and the chosen controls of `desc`; `columns` is resized, and best used again for
   * the next pose, as it then mostly has room. */
  void jacobian(fb_jacobian_desc desc, SparseColumns& columns) {
    columns.starts.resize(1 + std::size_t(desc.chosen ? desc.chosen_count : model_.control_count()));
    columns.rows.resize(columns.rows.capacity());
    columns.values.resize(columns.rows.size());
    desc.column_starts = columns.starts.data();
    fb_status status = run_columns(desc, columns);
    if (status == FB_ERROR_LIMIT) {
      columns.rows.resize(static_cast<std::size_t>(columns.starts.back()));
      columns.values.resize(columns.rows.size());
      status = run_columns(desc, columns);
    }
    check(status);
    columns.rows.resize(static_cast<std::size_t>(columns.starts.back()));
    columns.values.resize(columns.rows.size());
  }

  /** Controls for targets; allocates nothing. See fb_solve. */
  fb_solve_result solve(const fb_solve_desc& desc) {
    fb_solve_result result;
    fb_solve_result_init(&result);
    check(fb_solve(handle_, &desc, &result));
    return result;
  }
  /** Controls for targets of all points, with the defaults of everything else. points: 3 x point_count() floats;
   * controls: control_count() floats of the model, in, where it starts, and out. */
  fb_solve_result solve(const float* points, float* controls) {
    fb_solve_desc desc;
    fb_solve_desc_init(&desc);
    desc.points = points;
    desc.controls = controls;
    return solve(desc);
  }

  /** For what has no member here. */
  fb_solver* get() const noexcept { return handle_; }

 private:
  fb_status run_columns(fb_jacobian_desc& desc, SparseColumns& columns) {
    const bool room = !columns.rows.empty();
    desc.column_rows = room ? columns.rows.data() : nullptr;
    desc.column_values = room ? columns.values.data() : nullptr;
    desc.column_entries = columns.rows.size();
    const fb_status status = fb_jacobian(handle_, &desc);
    // Without room they are counted, which is no error.
    return status == FB_OK && !room && columns.starts.back() > 0 ? FB_ERROR_LIMIT : status;
  }

  Model model_;
  fb_solver* handle_ = nullptr;
};

}  // namespace facebaker

#endif
