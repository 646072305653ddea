/** @file
 * From a face back to its controls: how points of a face move with its controls, and the controls that bring points
 * where they should be. C99; statuses and fb_model are those of facebaker.h, functions are in libfacebaker.
 * docs/solving.md explains the method and when it fails.
 *
 * Everything is computed as floats in one order: the same bits on every machine.
 */
#ifndef FACEBAKER_FACEBAKER_SOLVE_H
#define FACEBAKER_FACEBAKER_SOLVE_H

#include <facebaker/facebaker.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- What is followed -------------------------------------------------------------------------------------------- */

/** What solving and derivatives need to know of points of a face, and their working memory. One thread at a time. */
typedef struct fb_solver fb_solver;

/** The points, frames and distances that a solver follows. Arrays are copied. */
typedef struct fb_solver_desc {
  uint32_t struct_size;
  uint32_t point_count;           /**< with point_vertices; may be 0 */
  const uint32_t* point_vertices; /**< three vertices a point, in the source's order; null (default): every vertex is a
                                     point, in the source's order, and point_count is not read */
  const float* point_weights;     /**< three a point, finite: where a point is, is the sum of weight x vertex. A vertex
                                     with a weight of 0 does not count. Null: 1, 0 and 0 */
  const uint32_t* pairs;          /**< two points each, whose distance may have a target. Null: none */
  uint32_t pair_count;            /**< with pairs */
  uint32_t socket_count;          /**< with sockets */
  const uint32_t* sockets;        /**< whose frames are followed (facebaker_character.h). Null: none */
  const uint32_t* joints;         /**< driven joints whose frames are followed. Null: none */
  uint32_t joint_count;           /**< with joints */
  float lod;                      /**< level of detail, as in fb_batch_desc; default 0, the whole */
} fb_solver_desc;

FB_API void fb_solver_desc_fill(fb_solver_desc* to, uint32_t struct_size);
static inline void fb_solver_desc_init(fb_solver_desc* to) {
  fb_solver_desc_fill(to, (uint32_t)sizeof *to);
}
/** Makes a solver of a face, which it retains, in memory from the model's allocator; takes some milliseconds, and a
 * tenth of a second for all vertices of a large face. desc null: all vertices. Fails with FB_ERROR_INVALID_ARGUMENT,
 * naming field and index, on vertices, points, sockets and joints that there are not, and on weights that are not
 * finite. */
FB_API fb_status fb_solver_create(const fb_model* model, const fb_solver_desc* desc, fb_solver** solver);
/** Frees a solver. Null is allowed. */
FB_API void fb_solver_destroy(fb_solver* solver);
/** Its points. */
FB_API uint32_t fb_solver_point_count(const fb_solver* solver);
/** The numbers that it follows: 3 a point, then 12 a frame, of sockets and then of joints. */
FB_API uint32_t fb_solver_row_count(const fb_solver* solver);

/* ---- Derivatives ------------------------------------------------------------------------------------------------- */

/** A pose, and where the derivatives of what is followed by its controls are written. */
typedef struct fb_jacobian_desc {
  uint32_t struct_size;
  uint32_t chosen_count;      /**< with chosen */
  const float* controls;      /**< fb_control_count floats; clamped to their ranges */
  const uint32_t* chosen;     /**< indices of controls, ascending. Null (default): all controls */
  const uint8_t* downwards;   /**< one a control, 1: where the pose bends, as at rest or where a corrective begins, the
                                 derivative is that of moving it down. Null (default): of moving it up, but down at
                                 its maximum */
  float* values;              /**< the numbers that are followed, fb_solver_row_count floats. Null: no output */
  float* derivatives;         /**< dense: row after row, a float for each chosen control. Null: no output */
  uint64_t derivative_floats; /**< size of that buffer */
  uint64_t* column_starts;    /**< sparse: where the entries of each chosen control begin, and of how many there are in
                                 all: one more than chosen. Null: no output */
  uint32_t* column_rows;      /**< rows of entries that are not 0, ascending in each column. Null: they are counted */
  float* column_values;       /**< their derivatives; with column_rows */
  uint64_t column_entries;    /**< size of these two buffers, in entries */
} fb_jacobian_desc;

FB_API void fb_jacobian_desc_fill(fb_jacobian_desc* to, uint32_t struct_size);
static inline void fb_jacobian_desc_init(fb_jacobian_desc* to) {
  fb_jacobian_desc_fill(to, (uint32_t)sizeof *to);
}
/** Finds the derivatives of what is followed by the controls, in fb_units a unit of the control: of the pose that is
 * evaluated, through clamping, curves, correctives, networks, exact poses, levels of detail and driven joints, but for
 * the rounding of fb_evaluate. That of a control outside of its range is 0. Allocates nothing. Fails with
 * FB_ERROR_NOT_FINITE, naming the control, on NaN; with FB_ERROR_INVALID_ARGUMENT on a buffer too small for the dense
 * output; with FB_ERROR_LIMIT on one too small for the sparse output, whose column_starts are written then. */
FB_API fb_status fb_jacobian(fb_solver* solver, const fb_jacobian_desc* desc);

/* ---- Solving ----------------------------------------------------------------------------------------------------- */

/** What a pose should come to, what it should be like beside, and where the answer goes. What is minimised is the sum
 * of ((difference / noise)^2 / 2) x weight over points, distances and frames, and of what nearness, sparsity,
 * smoothness and symmetry say, with controls in units of their ranges. Weights are 0 or more; null: 1. A target that
 * has a NaN counts as one with a weight of 0. */
typedef struct fb_solve_desc {
  uint32_t struct_size;
  uint32_t max_iterations;       /**< how often derivatives are found, at most; default 20 */
  const float* points;           /**< where points should be: 3 floats a point. Null: they have no targets */
  const float* point_weights;    /**< one a point */
  const float* distances;        /**< one a pair, in fb_units. Null: none have targets */
  const float* distance_weights; /**< one a pair */
  const float* frames;           /**< 12 floats a frame, row after row. Null: none have targets. Axes count as points a
                                    quarter of fb_diagonal from the origin */
  const float* frame_weights;    /**< one a frame */
  uint32_t relative;             /**< 1: points are told as how far they should be from where they are at rest; 0
                                    (default): where they should be */
  uint32_t find_motion;          /**< 1: where the head is, is found too, see motion; 0 (default) */
  float to_face[12];             /**< takes targets of points and frames to the space and units of the face, a matrix of
                                    three rows and four columns, row after row, that turns, mirrors and scales alike in
                                    all directions; default: the identity */
  float noise;                   /**< what a point's target is off by itself, in fb_units, above 0; default (0): half a
                                    millimetre, or a thousandth of fb_diagonal where the unit is not known */
  float nearness;                /**< x (control - near)^2 / 2; default 0.1. With less than 0.0001, that: what nothing
                                    else decides goes there */
  float sparsity;                /**< x |control - rest|: few controls rather than many; default 0.1 */
  float smoothness;              /**< x (control - before)^2 / 2; default 0 */
  float symmetry;                /**< x (control - its mirror's)^2 / 2, both from rest; default 0 */
  float tolerance;               /**< it ends where an iteration lowers the sum by less than this share; default 0.01 */
  const float* near_controls;    /**< fb_control_count floats; null: rest */
  const float* before;           /**< the controls of the frame before; null: smoothness does not count */
  const uint8_t* movable;        /**< one a control, 0: it stays where it starts. Null: all move */
  float* controls;               /**< fb_control_count floats: in, where it starts, best the frame before; out, what was
                                    found, within ranges */
  float* motion;                 /**< 12 floats, in and out: the face's space, moved and turned by it, is that of the
                                    targets as to_face leaves them. Null without find_motion; not read if it is all 0 */
  float* decided;                /**< one a control: the share of what decides it that comes from the targets, from 0,
                                    nothing but preferences, to 1. Null: no output, which saves time */
  float* point_differences;      /**< one a point: how far it is from its target, in fb_units; NaN without one. Null: no
                                    output */
} fb_solve_desc;

FB_API void fb_solve_desc_fill(fb_solve_desc* to, uint32_t struct_size);
static inline void fb_solve_desc_init(fb_solve_desc* to) {
  fb_solve_desc_fill(to, (uint32_t)sizeof *to);
}

/** How a solution came out. */
typedef struct fb_solve_result {
  uint32_t struct_size;
  uint32_t iterations;  /**< how often derivatives were found */
  uint32_t converged;   /**< 0: it ended because of max_iterations */
  uint32_t point_count; /**< with targets */
  uint32_t worst_point; /**< farthest from its target; 0 without any */
  float rms_difference; /**< root mean square distance of these points from their targets, in fb_units */
  float max_difference; /**< of the worst point */
  float reserved;       /**< 0 */
  double objective;     /**< what was minimised */
} fb_solve_result;

FB_API void fb_solve_result_fill(fb_solve_result* to, uint32_t struct_size);
static inline void fb_solve_result_init(fb_solve_result* to) {
  fb_solve_result_fill(to, (uint32_t)sizeof *to);
}
/** Finds controls for targets: damped Gauss-Newton steps with bounds from where it starts, so that a clip is solved
 * frame after frame. *result is filled up to its struct_size, or null. The answer is always within the ranges of the
 * controls. Allocates nothing. Fails with FB_ERROR_NOT_FINITE, naming field and index, on infinite targets and NaN in
 * controls; with FB_ERROR_INVALID_ARGUMENT on weights and preferences that are negative or not finite, targets farther
 * than 10^6 of fb_diagonal, and a to_face that does not scale alike in all directions. Nothing is written then. */
FB_API fb_status fb_solve(fb_solver* solver, const fb_solve_desc* desc, fb_solve_result* result);

#ifdef __cplusplus
}
#endif
#endif
