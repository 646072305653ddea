/** @file
 * FaceBaker runtime: load a baked face (.fbk) and pose it. C99, no dependencies; link libfacebaker.
 *
 * Shape of use:
 *
 *     fb_load -> fb_scratch_create (one per thread) -> fb_evaluate, again and again -> fb_scratch_destroy, fb_release.
 *
 * Every function that can fail returns an fb_status; fb_last_error() then holds a sentence about the calling thread's
 * last failure that names the field, control or byte offset. Output parameters are written only on FB_OK.
 * No exception, abort or assert leaves this library. Pointers must be valid; null where it is not allowed is refused
 * with FB_ERROR_INVALID_ARGUMENT.
 *
 * Threads: an fb_model never changes after loading; any number of threads may use one model at once. An fb_scratch
 * belongs to one call at a time: another call with it meanwhile is refused with FB_ERROR_INVALID_ARGUMENT. An
 * evaluation that succeeds allocates nothing, waits for nothing and logs nothing; it takes no lock but one atomic flag
 * of its scratch. The floating-point mode of a thread changes no result, and is left as it was. This library creates no
 * thread, except in fb_evaluate_batch, and where loading is allowed more than one thread, if the host gives no
 * parallel_for: there OpenMP does, and keeps the threads for the next batch of the calling thread. OpenMP would end the
 * process if it could not create a thread. So before a batch that needs more threads than the calling thread's last,
 * they are created for trial, and the batch runs on as many as there are. What cannot be excluded: that something else
 * takes the last threads or the last memory in that moment, that the host's own OpenMP code has given the calling
 * thread's threads back since its last batch, or that OMP_STACKSIZE asks for larger stacks than the system's default.
 * Hosts that live near such limits give a parallel_for, or a library built without OpenMP (FB_OPENMP=OFF), which
 * creates no threads at all.
 *
 * Fork: in a child of fork(), models and scratches that no call was using work as before. Its batches run on threads
 * made for each, instead of OpenMP's, whose threads and locks a child has lost, or on those of its parallel_for.
 *
 * Signals: no call installs a handler or changes a mask, and none may be made from a signal handler. Threads that
 * OpenMP creates have the signal mask of the thread that made the batch. Loading goes on after an interrupted system
 * call.
 *
 * Reload: the library stays in memory when a host closes it (dlclose), because OpenMP's idle threads go on; opening it
 * again finds the same library. A face's file may be replaced, changed or cut short at any time, while it is loaded
 * too, unless fb_load_desc::map_file is set: the call then loads it, or fails.
 *
 * SECURITY.md says what is promised for archives from strangers, and names the test that holds each of these promises.
 *
 * Growth: structs begin with struct_size, are filled by their fb_..._init and only ever grow at the end. A field is
 * read or written only if struct_size covers it, and _init passes the size the host was built with to the exported
 * fb_..._fill (which writes that size into struct_size, defaults, and zeros in what the library does not know; null
 * does nothing). So hosts built against older and newer headers work. Exports are only ever added.
 */
#ifndef FACEBAKER_FACEBAKER_H
#define FACEBAKER_FACEBAKER_H

#include <stddef.h>
#include <stdint.h>

#if defined(FB_STATIC) /* libfacebaker.a: nothing is exported from the program or library that links it */
#define FB_API
#elif defined(_WIN32)
#ifdef FB_BUILDING
#define FB_API __declspec(dllexport)
#else
#define FB_API __declspec(dllimport)
#endif
#elif defined(__GNUC__)
#define FB_API __attribute__((visibility("default")))
#else
#define FB_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Status ------------------------------------------------------------------------------------------------------ */

/** What a call that can fail returns: FB_OK, or FB_ERROR_... with pinned numbers. */
typedef int32_t fb_status;
#define FB_OK 0                     /**< success */
#define FB_ERROR_INVALID_ARGUMENT 1 /**< null pointer, wrong buffer size, index out of range */
#define FB_ERROR_NOT_FOUND 2        /**< no such file or control */
#define FB_ERROR_IO 3               /**< the system refused a read or a write; a directory in place of a file */
#define FB_ERROR_NOT_AN_ARCHIVE 4   /**< not an .fbk */
#define FB_ERROR_CORRUPT 5          /**< an .fbk that is truncated or damaged */
#define FB_ERROR_UNSUPPORTED 6      /**< an .fbk of another format version, or with parts this library does not know */
#define FB_ERROR_LIMIT 7            /**< larger than a limit the caller set, or than sizes can be */
#define FB_ERROR_OUT_OF_MEMORY 8    /**< an allocation failed */
#define FB_ERROR_NOT_FINITE 9       /**< NaN or infinity where a number is needed */
#define FB_ERROR_BAD_DATA 10        /**< inconsistent data */
#define FB_ERROR_RIG 11             /**< a rig plugin failed or broke its contract */
#define FB_ERROR_INTERRUPTED 12     /**< the host stopped the call */
#define FB_ERROR_INTERNAL 13        /**< an error of this library */

/** The constant's name ("FB_ERROR_CORRUPT"); "unknown status" for other numbers. Static storage. */
FB_API const char* fb_status_name(fb_status status);

/** The message of this thread's last failed call, "" if there was none. UTF-8, at most 2,047 bytes, owned by the
 * library, valid until the next failing call on this thread. */
FB_API const char* fb_last_error(void);

/* ---- Version ----------------------------------------------------------------------------------------------------- */

/** The library's version, "major.minor.patch". Static storage. */
FB_API const char* fb_version_string(void);
/** The same as a number: major * 1,000,000 + minor * 1,000 + patch. */
FB_API uint32_t fb_version(void);
/** The .fbk format this library reads: major * 1,000 + minor. While major is 0, it reads no other. */
FB_API uint32_t fb_format_version(void);
/** What the library was built with, for reports of faults: one line each of its version, the format, the compiler,
 * OpenMP, the instruction sets it has, with the one that poses are evaluated with on this machine, and the libraries
 * that are linked into it, as "NAME: VALUE". The names and their order may change. UTF-8, static storage. Thread-safe.
 */
FB_API const char* fb_build_info(void);

/* ---- Loading ----------------------------------------------------------------------------------------------------- */

typedef struct fb_model fb_model;     /**< a loaded face; immutable, reference counted */
typedef struct fb_scratch fb_scratch; /**< working memory of evaluations */

/** A host's allocator. allocate returns `bytes` bytes aligned to `alignment` (a power of two) or null; release frees
 * memory from allocate. Both must be callable from any thread. */
typedef struct fb_allocator {
  void* user;                                                                /**< passed to both */
  void* (*allocate)(void* user, size_t bytes, size_t alignment);             /**< null: malloc */
  void (*release)(void* user, void* memory, size_t bytes, size_t alignment); /**< null: free */
} fb_allocator;

/** Receives a warning that is not an error, such as an optional section that was skipped. Called on the loading thread
 * after the model is complete; message is valid during the call. */
typedef void (*fb_log)(void* user, const char* message);

/** A task that a host's scheduler, fb_parallel_for, calls: task(context, index, worker) once for every
 * index < count with worker < workers, never two at once with the same worker, from any threads. The scheduler returns
 * when all calls have. */
typedef void (*fb_task)(void* context, uint32_t index, uint32_t worker);
/** See fb_task. `user` is the parallel_user beside it. */
typedef void (*fb_parallel_for)(void* user, uint32_t count, uint32_t workers, fb_task task, void* context);

/** How a face is loaded. */
typedef struct fb_load_desc {
  uint32_t struct_size;
  uint32_t reserved;
  uint64_t max_file_bytes;  /**< larger files are refused with FB_ERROR_LIMIT; default 4 GiB */
  uint64_t max_model_bytes; /**< limit of the memory that the call takes at any time: the file's bytes, unless they
                               are mapped or the caller's, what is unpacked from them, temporaries, names and the model
                               itself; beyond it FB_ERROR_LIMIT; default 4 GiB. Scratches are not part of it. */
  fb_allocator allocator;   /**< for the blocks of the model (weights, basis, mesh), its scratches and what loading
                               takes meanwhile; null functions: malloc. Names, handles, what the decoders of the mesh
                               take and other small things use malloc: docs/c-and-cpp.md says how much. */
  fb_log log;               /**< null: silent */
  void* log_user;           /**< passed to log */
  const char* instruction_set; /**< for tests: the fastest instruction set to use, from "scalar" on; null: no limit. The
                                  environment variable FB_INSTRUCTION_SET limits it likewise. Results are the same.
                                  Fails with FB_ERROR_INVALID_ARGUMENT, listing the names, on an unknown name. */
  uint32_t map_file;           /**< 1: fb_load maps the file instead of reading it, which saves memory while large
                                  archives are loaded. The file must not be cut short or overwritten during the call: the
                                  system would end the process (SIGBUS). Replacing it by renaming is safe. Default 0. */
  uint32_t reserved_number;    /**< 0 */
  uint64_t max_name_bytes;     /**< limit of the bytes of all names and texts in the archive; default 16 MiB */
  uint64_t max_vertices;       /**< limit of the vertices; default 4 Mi (2^22) */
  uint64_t max_polygons;       /**< limit of the polygons; default 8 Mi */
  uint64_t max_features; /**< limit of the features, functions of the controls that networks and sparse blendshapes
                            are made of; default 1 Mi. Beyond any of these: FB_ERROR_LIMIT. */
  fb_parallel_for parallel_for; /**< decodes the basis, in up to 4 tasks; null: OpenMP if the library has it, else the
                                   calling thread. Not called with one thread. One that calls too few, too many or
                                   invalid tasks makes the call fail with FB_ERROR_INVALID_ARGUMENT. */
  void* parallel_user;          /**< passed to parallel_for */
  uint32_t threads;             /**< that decode the basis, at most; default 1; 0: as many as OpenMP would use, 1 with
                                   a parallel_for. Each takes some memory, at most 32 bytes a vertex. */
  uint32_t reserved_threads;    /**< 0 */
} fb_load_desc;

FB_API void fb_load_desc_fill(fb_load_desc* to, uint32_t struct_size);
static inline void fb_load_desc_init(fb_load_desc* to) {
  fb_load_desc_fill(to, (uint32_t)sizeof *to);
}

/** Loads the archive at `path` (UTF-8). desc may be null for defaults. *model is owned by the caller, with one
 * reference. Untrusted files are safe: every size is validated before it is used. Only regular files are read; pipes
 * and devices are refused with IO at once, and loaded by fb_load_stream. The file is read into memory and closed; see
 * fb_load_desc::map_file. Fails with NOT_FOUND, IO, NOT_AN_ARCHIVE, CORRUPT, UNSUPPORTED, LIMIT or OUT_OF_MEMORY. */
FB_API fb_status fb_load(const char* path, const fb_load_desc* desc, fb_model** model);
/** The same from memory, which is not needed after the call. */
FB_API fb_status fb_load_memory(const void* bytes, size_t size, const fb_load_desc* desc, fb_model** model);

/** Reads the next bytes of a host's stream: writes up to `bytes` (>= 1) of them to `to` and returns how many it wrote,
 * which may be fewer; 0 at the end of the stream, a negative number if reading failed. Called on the loading thread. */
typedef int64_t (*fb_read)(void* user, void* to, uint64_t bytes);
/** The same from a host's stream, such as an entry of a packed, compressed game archive: read(user, ...) is called
 * until the archive is complete, front to back. An archive says itself how long it is, so its size is not asked for,
 * and no byte behind it is read: the stream may go on with something else. Fails with IO, too, if read does. */
FB_API fb_status fb_load_stream(fb_read read, void* user, const fb_load_desc* desc, fb_model** model);

/** Adds a reference. Null is allowed. Thread-safe. */
FB_API void fb_retain(fb_model* model);
/** Releases a reference; the last one frees the model. Null is allowed. Thread-safe. Scratches hold a reference of
 * their own. */
FB_API void fb_release(fb_model* model);

/* ---- Contents ---------------------------------------------------------------------------------------------------- */
/* All of these are thread-safe; strings and arrays are owned by the model and live as long as it does.
 * A null model gives 0 or null. */

FB_API uint32_t fb_vertex_count(const fb_model* model);      /**< vertices of the mesh */
FB_API uint32_t fb_control_count(const fb_model* model);     /**< floats in a pose */
FB_API uint32_t fb_coefficient_count(const fb_model* model); /**< columns of the basis */

FB_API const char* fb_name(const fb_model* model);       /**< of the character */
FB_API const char* fb_units(const fb_model* model);      /**< of positions: "cm", "m", ... */
FB_API const char* fb_up_axis(const fb_model* model);    /**< "y" or "z" */
FB_API const char* fb_provenance(const fb_model* model); /**< a JSON object, as stored in the archive; "" if none */

#define FB_NO_CONTROL 0xffffffffu /**< no control, where one could be */

/** A control of a face. Its own name is what it is called by; ARKit and FACS names stand beside it. */
typedef struct fb_control {
  uint32_t struct_size;
  uint32_t reserved;
  const char* name;  /**< unique, not empty */
  const char* group; /**< the control group it belongs to; "" if it has none */
  float minimum;     /**< lower end of its range */
  float maximum;     /**< upper end of its range */
  float rest;        /**< value in the rest pose */
  uint32_t mirror;   /**< index of the control that does the same on the other side; FB_NO_CONTROL: none is known */
  const char* arkit; /**< its name among the face blendshapes of ARKit, such as "jawOpen"; "" if it has none */
  const char* facs;  /**< its action unit in the Facial Action Coding System, such as "AU26"; "" if it has none */
  const char* unit;  /**< of its values, such as "degrees"; "" if it has none */
} fb_control;

FB_API void fb_control_fill(fb_control* to, uint32_t struct_size);
static inline void fb_control_init(fb_control* to) {
  fb_control_fill(to, (uint32_t)sizeof *to);
}
/** Fills *control, up to its struct_size, for the control at index < fb_control_count; the model owns its strings.
 * Poses list controls in this order. */
FB_API fb_status fb_control_at(const fb_model* model, uint32_t index, fb_control* control);
/** Finds a control by its exact name, or else by its ARKit name, or else by its FACS name; on FB_ERROR_NOT_FOUND the
 * message names the closest one. */
FB_API fb_status fb_find_control(const fb_model* model, const char* name, uint32_t* index);
/** The hash of a name, for code that would rather hold a number than a text: XXH64 with seed 0 of its bytes without the
 * closing 0, the same in every version. Null is "". `facebaker header` writes those of a face's controls as constants.
 */
FB_API uint64_t fb_name_hash(const char* name);
/** Finds a control by the hash of its own name. Fails with FB_ERROR_NOT_FOUND. */
FB_API fb_status fb_find_control_hash(const fb_model* model, uint64_t hash, uint32_t* index);
/** The controls of the rest pose: fb_control_count floats. */
FB_API const float* fb_rest_controls(const fb_model* model);

/** Blends two poses as their controls, without posing them: (1 - share) x from + share x to of each, clamped to its
 * range; exactly `from` at share 0 and `to` at 1 where those are within. Any finite share. to: null is the mirror of
 * `from`, in which partners (fb_control::mirror) have each other's values, as far on the way from rest to the end of
 * their range, and other controls keep theirs. All are fb_control_count floats; blended may be `from` or `to`. Fails
 * with FB_ERROR_NOT_FINITE, naming the control, on NaN; then nothing is written. Thread-safe. */
FB_API fb_status fb_blend_controls(const fb_model* model, const float* from, const float* to, float share,
                                   float* blended);

/** The rest mesh in the source's vertex order: 3 x fb_vertex_count floats, xyz interleaved, in fb_units. */
FB_API const float* fb_rest_positions(const fb_model* model);
/** Length of the diagonal of the rest mesh's bounding box, in fb_units. */
FB_API double fb_diagonal(const fb_model* model);
/** Polygons, as the source had them; there may be none. */
FB_API uint32_t fb_polygon_count(const fb_model* model);
/** Corners of each polygon, >= 3. May be null where there are no polygons. */
FB_API const uint32_t* fb_polygon_sizes(const fb_model* model);
/** Corners of all polygons. */
FB_API uint32_t fb_polygon_corner_count(const fb_model* model);
/** Vertex indices, polygon after polygon. May be null where there are no polygons. */
FB_API const uint32_t* fb_polygon_corners(const fb_model* model);
/** Pairs of texture coordinates; 0 if the source had none. */
FB_API uint32_t fb_uv_count(const fb_model* model);
/** Texture coordinates: 2 x fb_uv_count floats, u and v interleaved, v pointing up from the lower edge of the
 * image. May be null without any. */
FB_API const float* fb_uvs(const fb_model* model);
/** For each polygon corner the index of its pair; a vertex on a seam has several. May be null without any. */
FB_API const uint32_t* fb_uv_corners(const fb_model* model);
/** For shading with the tangents of fb_evaluate_batch: one a vertex, in the source's order, -1 where the texture is
 * mirrored and 1 elsewhere. The bitangent, along growing v, is the sign times the cross product of normal and tangent.
 * Null without texture coordinates. */
FB_API const float* fb_tangent_signs(const fb_model* model);
/** Bytes of memory that the model takes to evaluate poses, without scratches. */
FB_API uint64_t fb_runtime_bytes(const fb_model* model);
/** The instruction set that poses are evaluated with, such as "avx2". Static storage. */
FB_API const char* fb_instruction_set(const fb_model* model);

/** Regions: the parts of the face that have a network of their own. There may be none. Direct coefficients belong to no
 * region. */
FB_API uint32_t fb_region_count(const fb_model* model);
/** The name of a region; null for index >= fb_region_count. */
FB_API const char* fb_region_name(const fb_model* model, uint32_t index);

/* ---- The basis ----------------------------------------------------------------------------------------------------
 */
/** For hosts whose GPU moves the vertices: displacements are the basis times the coefficients of a pose
 * (fb_evaluate_coefficients). Row 3 i + axis of the basis is coordinate `axis` of vertex i in baked order, in which
 * vertices that use the same coefficients are contiguous. The basis is stored in row blocks, each of which uses some of
 * the coefficients. Such displacements differ from fb_evaluate's by rounding, and are 0 at rest; "Poses for a GPU" says
 * how to have the same bits. Of a face with driven joints they are those before the joints move the vertices, see
 * fb_batch_desc::joints. */

/** Baked order: the source index of each vertex, fb_vertex_count numbers; null if it is the source's order. */
FB_API const uint32_t* fb_vertex_order(const fb_model* model);

/** Consecutive rows of the basis that use the same coefficients. */
typedef struct fb_row_block {
  uint32_t struct_size;
  uint32_t first_row;          /**< row blocks follow each other without gaps, and cover 3 x fb_vertex_count rows */
  uint32_t row_count;          /**< rows in it */
  uint32_t column_count;       /**< coefficients it uses */
  uint32_t digit_column_count; /**< columns of fb_row_block_digits; column_count or more */
} fb_row_block;

FB_API void fb_row_block_fill(fb_row_block* to, uint32_t struct_size);
static inline void fb_row_block_init(fb_row_block* to) {
  fb_row_block_fill(to, (uint32_t)sizeof *to);
}
/** Row blocks of the basis. */
FB_API uint32_t fb_row_block_count(const fb_model* model);
/** Fills *block, up to its struct_size, for index < fb_row_block_count. */
FB_API fb_status fb_row_block_at(const fb_model* model, uint32_t index, fb_row_block* block);
/** Writes the contents of the row block at `index`: columns, column_count indices below fb_coefficient_count,
 * ascending; and values, column-major, row_count floats a column: the displacements for one unit of the coefficient. */
FB_API fb_status fb_row_block_values(const fb_model* model, uint32_t index, uint32_t* columns, float* values);
/** Writes the row block at `index` as it is kept, a byte a number, for GPUs that multiply it themselves:
 * fb_row_block::digit_column_count columns, each of one coefficient, `columns`, below fb_coefficient_count; `scales`,
 * one a column; and `digits`, column-major, row_count a column, -128 to 127. The displacement of row r is the sum over
 * the columns of coefficient columns[c] * scales[c] * digits[c * row_count + r]. Most coefficients have one column;
 * those that are kept more finely have a second one, of high digits, behind all the first ones. Fails with
 * FB_ERROR_INVALID_ARGUMENT for an index of none. Thread-safe. */
FB_API fb_status fb_row_block_digits(const fb_model* model, uint32_t index, uint32_t* columns, float* scales,
                                     int8_t* digits);

/* ---- Posing ------------------------------------------------------------------------------------------------------ */

/** Working memory for `workers` (>= 1) concurrent poses of this model: 1 for fb_evaluate, one per thread that
 * fb_evaluate_batch may use. From the model's allocator. Calls with another model fail with
 * FB_ERROR_INVALID_ARGUMENT. */
FB_API fb_status fb_scratch_create(const fb_model* model, uint32_t workers, fb_scratch** scratch);
/** The same for single poses, in about a quarter of the memory: a batch is evaluated pose after pose, with the same
 * bits, where fb_scratch_create has room to evaluate several poses together, which takes less time. */
FB_API fb_status fb_scratch_create_single(const fb_model* model, uint32_t workers, fb_scratch** scratch);
/** Frees a scratch. Null is allowed. */
FB_API void fb_scratch_destroy(fb_scratch* scratch);

/** One pose, on the calling thread. controls: fb_control_count floats in control order. positions: 3 x fb_vertex_count
 * floats, xyz interleaved, in the archive's units and vertex order; may not overlap controls.
 * Values outside a control's range, including infinities, are clamped to it and counted by fb_clamped_count. NaN fails
 * with FB_ERROR_NOT_FINITE, naming the control; positions are not written then. Controls at rest give exactly the rest
 * mesh. */
FB_API fb_status fb_evaluate(const fb_model* model, fb_scratch* scratch, const float* controls, float* positions);

/** The coefficients alone, fb_coefficient_count floats, all 0 at rest; controls as for fb_evaluate. */
FB_API fb_status fb_evaluate_coefficients(const fb_model* model, fb_scratch* scratch, const float* controls,
                                          float* coefficients);

/** Control values that the scratch's last successful evaluation clamped, over all poses of a batch. */
FB_API uint64_t fb_clamped_count(const fb_scratch* scratch);

/* Orders of vertices; baked order is quicker to write. */
#define FB_ORDER_SOURCE 0 /**< the source's */
#define FB_ORDER_BAKED 1  /**< see fb_vertex_order */
/* Formats of numbers. */
#define FB_FLOAT32 0 /**< float */
#define FB_FLOAT16 1 /**< IEEE 754 binary16 in uint16_t, rounded to nearest */

/** Poses of a batch and where they are written. "In numbers" counts floats, or uint16_t with FB_FLOAT16. */
typedef struct fb_batch_desc {
  uint32_t struct_size;
  uint32_t threads;      /**< at most the scratch's workers; 0: all of them, or as many as OpenMP would use if fewer */
  uint64_t poses;        /**< may be 0 */
  const float* controls; /**< pose p begins at controls + p * control_stride */
  uint64_t control_floats;  /**< size of that buffer, in floats */
  uint64_t control_stride;  /**< in floats; 0: fb_control_count */
  void* positions;          /**< vertex v of pose p begins at positions + p * pose_stride + v * vertex_stride; may be
                               null if normals, tangents, sockets, channels or
                               bounds are given */
  uint64_t position_floats; /**< size of that buffer, in numbers */
  uint64_t pose_stride;     /**< in numbers; 0: vertex_stride * fb_vertex_count */
  uint64_t vertex_stride;   /**< in numbers, >= 3; 0: 3. Gaps between vertices are not written. */
  fb_parallel_for parallel_for;  /**< null: OpenMP if the library has it, else the calling thread. Not called where one
                                    thread is enough. */
  void* parallel_user;           /**< passed to parallel_for */
  uint32_t vertex_order;         /**< FB_ORDER_...; default FB_ORDER_SOURCE */
  uint32_t format;               /**< FB_FLOAT...: of positions and normals; default FB_FLOAT32 */
  void* normals;                 /**< unit normals of the posed mesh, laid out like positions; null: no output. A vertex
                                    normal is the normalised sum of the area vectors of the polygons around it; for a
                                    quad, planar or not, half the cross product of its diagonals. Null vectors where
                                    there is no area. The same bits on every machine, like positions. */
  uint64_t normal_numbers;       /**< size of that buffer, in numbers */
  uint64_t normal_pose_stride;   /**< as for positions */
  uint64_t normal_vertex_stride; /**< as for positions */
  const uint32_t* regions;       /**< indices of the regions whose networks run; the others keep their coefficients at
                                    rest, 0. Null: all run. */
  uint64_t region_count;         /**< of that list; with a list, 0 is none */
  void* tangents; /**< unit tangents of the posed mesh, 3 numbers a vertex like positions: the direction in which u
                     grows, perpendicular to the normal; see fb_tangent_signs. Null vectors where there is none.
                     Refused for a model without texture coordinates. The same bits on every machine. Null: no
                     output. */
  uint64_t tangent_numbers;       /**< size of that buffer, in numbers */
  uint64_t tangent_pose_stride;   /**< as for positions */
  uint64_t tangent_vertex_stride; /**< as for positions */
  const uint32_t* meshes;         /**< indices of the meshes that are posed (facebaker_character.h); vertices of the
                                     others are not written, and networks that move none of them do not run. Null: all
                                     are posed */
  uint64_t mesh_count;            /**< of that list; with a list, 0 is none */
  float* sockets;                 /**< frames of the sockets (facebaker_character.h), 12 floats each, in their order;
                                     those of meshes that are not posed are not written. The same bits on every
                                     machine; about a microsecond each. Refused for a face without sockets. Null: no
                                     output. */
  uint64_t socket_floats;         /**< size of that buffer, in floats */
  uint64_t socket_pose_stride;    /**< in floats; 0: 12 * fb_socket_count */
  float* channels;                /**< values of the channels (facebaker_character.h), one float each, in their order,
                                     whichever meshes are posed. The same bits on every machine. Refused for a face
                                     without channels. Null: no output. */
  uint64_t channel_floats;        /**< size of that buffer, in floats */
  uint64_t channel_pose_stride;   /**< in floats; 0: fb_channel_count */
  float* expected_errors; /**< as fb_expected_error gives them, 1 + fb_error_region_count floats a pose; null: no
                             output. Refused for a face without expected errors, as is outside. */
  uint64_t expected_error_floats;      /**< size of that buffer, in floats */
  uint64_t expected_error_pose_stride; /**< in floats; 0: 1 + fb_error_region_count */
  uint32_t* outside;                   /**< as fb_expected_error gives it, one number a pose; null: no output */
  uint32_t displacements; /**< 1: positions receives displacements instead, position less rest position, before driven
                             joints, which are 0 where a pose is at rest, but for vertices that lod moves; 0:
                             positions */
  uint32_t reserved_displacements; /**< 0 */
  float* bounds; /**< of each pose, 6 floats: the smallest x, y and z, then the largest, of the positions of the
                    vertices of the meshes that are posed, before any skin; 0 where none is posed. The same whatever
                    format and displacements are, and the same bits on every machine. Null: no output */
  uint64_t bounds_floats;      /**< size of that buffer, in floats */
  uint64_t bounds_pose_stride; /**< in floats; 0: 6 */
  float lod;                   /**< level of detail: 0 (default) is the whole, 1, 2, ... are the levels of fb_level_at
                                    (facebaker_character.h). Positions are continuous in it: between whole numbers, the
                                    vertices that only the finer level has slide to where they lie on the surface of the
                                    coarser one. All vertices are written: those that a level does not have lie on its
                                    surface, so that polygons of finer levels stay whole. Normals and tangents are
                                    continuous in it, too: at a whole number they are of the level's polygons, between two
                                    the blend of both; a vertex that a level does not have has those of the corners around
                                    it, interpolated. Beyond the last level it is that one; a face without levels
                                    is always whole. Refused below 0. */
  uint32_t level_only; /**< 1: of positions, normals, tangents and bounds only the vertices of the level that lod is
                          rounded down to are written, the first fb_level::vertex_count in baked order, and buffers need
                          have no others; needs FB_ORDER_BAKED. 0 (default): all */
  float* joints;       /**< frames of the driven joints (facebaker_character.h), 12 floats each, in their order, in the
                          space of positions, whichever meshes are posed. The same bits on every machine. Refused for a
                          face without driven joints. Null: no output */
  uint64_t joint_floats;      /**< size of that buffer, in floats */
  uint64_t joint_pose_stride; /**< in floats; 0: 12 * fb_driven_joint_count */
  uint32_t unskinned; /**< 1: positions, normals and tangents are those before driven joints move the vertices, as
                         displacements always are, for a host that skins by itself; bounds and sockets are always of
                         what is seen. 0 (default): after */
  uint32_t spread;    /**< 1: where there are fewer poses than threads, all threads share each pose of a face of
                         50,000 vertices or more, with several calls of parallel_for a pose. Pays with normals, and
                         from some hundred thousand vertices, where threads wait actively for the next call. 0
                         (default): a pose runs on one thread */
} fb_batch_desc;

FB_API void fb_batch_desc_fill(fb_batch_desc* to, uint32_t struct_size);
static inline void fb_batch_desc_init(fb_batch_desc* to) {
  fb_batch_desc_fill(to, (uint32_t)sizeof *to);
}

/** Many poses, or one with more options. Each pose has the same bits as with fb_evaluate, for any batch, order, strides
 * and threads. A single pose runs on the calling thread, unless it is spread. Outputs of some megabytes without gaps
 * are written with non-temporal stores. Before anything is written, fails with FB_ERROR_INVALID_ARGUMENT on a level of
 * detail below 0, buffers too small for their poses and strides, overlapping poses, and unknown regions, orders and
 * formats, and with FB_ERROR_NOT_FINITE, naming pose and control, on NaN. Buffers may not overlap each other. 0 poses
 * need no buffers. A parallel_for that calls too few, too many or invalid tasks fails with FB_ERROR_INVALID_ARGUMENT
 * afterwards. */
FB_API fb_status fb_evaluate_batch(const fb_model* model, fb_scratch* scratch, const fb_batch_desc* desc);

/* ---- Poses for a GPU ----------------------------------------------------------------------------------------------
 */
/* For hosts whose GPU is to give fb_evaluate's very bits. Coefficients are quantised to whole numbers, those that a row
 * block uses with one step, so that the sums of the basis are whole numbers within 32 bits, the same in whatever order
 * they are taken. Of row r of the row block b (fb_row_block_digits) the position in a pose is
 *
 *     the rest position                                                                            if steps[b] is 0
 *     the rest position + steps[b] * f32(sum over its columns c of quantised[c] * digits[c][r])    otherwise
 *
 * and then, for each exact pose e in order whose weight is not 0 and which corrects the row block
 * (fb_exact_corrections), position + exact_weights[e] * corrections[r]. All of these are floats, each operation
 * rounded to the nearest, never fused, with denormals kept. A displacement is the position less the rest position.
 * Driven joints then move the vertices: docs/characters.md. */

/** Digit columns of all row blocks together: the sum of their fb_row_block::digit_column_count. Null model: 0. */
FB_API uint32_t fb_digit_column_count(const fb_model* model);

/** Poses to be quantised and where that is written. */
typedef struct fb_quantised_desc {
  uint32_t struct_size;
  uint32_t reserved;       /**< 0 */
  uint64_t poses;          /**< may be 0 */
  const float* controls;   /**< as in fb_batch_desc */
  uint64_t control_floats; /**< size of that buffer, in floats */
  uint64_t control_stride; /**< in floats; 0: fb_control_count */
  int16_t* quantised;      /**< of each pose, the quantised coefficient of each digit column, row block after row block:
                              -32,512 to 32,512, 0 where the column moves nothing. Null: no output */
  uint64_t quantised_numbers;        /**< size of that buffer, in numbers */
  uint64_t quantised_pose_stride;    /**< in numbers; 0: fb_digit_column_count */
  float* steps;                      /**< of each pose, the step of each row block; 0: it is at rest. Null: no output */
  uint64_t step_floats;              /**< size of that buffer, in floats */
  uint64_t step_pose_stride;         /**< in floats; 0: fb_row_block_count */
  float* exact_weights;              /**< of each pose, the weight of each exact pose (facebaker_character.h), 0 to 1.
                                        Refused for a face without exact poses. Null: no output */
  uint64_t exact_weight_floats;      /**< size of that buffer, in floats */
  uint64_t exact_weight_pose_stride; /**< in floats; 0: fb_exact_pose_count */
  float* joints;                     /**< frames of the driven joints, as in fb_batch_desc. Null: no output */
  uint64_t joint_floats;             /**< size of that buffer, in floats */
  uint64_t joint_pose_stride;        /**< in floats; 0: 12 * fb_driven_joint_count */
} fb_quantised_desc;

FB_API void fb_quantised_desc_fill(fb_quantised_desc* to, uint32_t struct_size);
static inline void fb_quantised_desc_init(fb_quantised_desc* to) {
  fb_quantised_desc_fill(to, (uint32_t)sizeof *to);
}

/** Quantises the coefficients of many poses of the whole, level of detail 0, on the calling thread, in less time than
 * evaluating them takes. The same bits on every machine, for any batch and strides. Fails as fb_evaluate_batch does,
 * before anything is written, on buffers too small, overlapping poses and NaN. Allocates nothing unless it fails. */
FB_API fb_status fb_evaluate_quantised(const fb_model* model, fb_scratch* scratch, const fb_quantised_desc* desc);

/* ---- Expected errors ----------------------------------------------------------------------------------------------
 */
/* How far vertices are expected to be from where the rig has them, as the bake found on poses that it had held back.
 * docs/measuring.md says how well that holds. Faces without poses held back do not have it. The functions but the last
 * are thread-safe; what they return is owned by the model and lives as long as it does. */

/** Regions of the face that expected errors are given for; 0 if the face has none. They are not those of
 * fb_region_count. */
FB_API uint32_t fb_error_region_count(const fb_model* model);
/** The name of such a region, unique and not empty, such as "mouth, lower left"; null for index >=
 * fb_error_region_count. */
FB_API const char* fb_error_region_name(const fb_model* model, uint32_t index);
/** The region of each vertex, for a viewer's colours: fb_vertex_count indices below fb_error_region_count, in the
 * source's vertex order. Null if there are no expected errors. */
FB_API const uint32_t* fb_error_vertex_regions(const fb_model* model);

/** What to expect of a pose, without posing it; for less than a twentieth of the time. controls: as for fb_evaluate.
 * errors: 1 + fb_error_region_count floats, in fb_units, 0 or more: the root mean square distance over the vertices of
 * the whole face, then of each region. *outside: how many controls are outside of what was trained, by their own values
 * or together with another one, each beyond a quarter of its reach; there the errors may be larger than expected.
 * Either may be null. The same bits on every machine. Fails with FB_ERROR_INVALID_ARGUMENT if there are no expected
 * errors, with FB_ERROR_NOT_FINITE, naming the control, on NaN. */
FB_API fb_status fb_expected_error(const fb_model* model, fb_scratch* scratch, const float* controls, float* errors,
                                   uint32_t* outside);

/* ---- Many faces ---------------------------------------------------------------------------------------------------
 */

/** One of the faces that fb_evaluate_many poses. Never grows. */
typedef struct fb_many_item {
  const fb_model* model;      /**< several items may have the same */
  fb_scratch* scratch;        /**< of that model, and of no other item; one worker is enough. Null: that of its model
                                 among fb_many_desc::scratches, which takes least memory and time */
  const fb_batch_desc* batch; /**< its poses and where they are written; threads, parallel_for and parallel_user are not
                                 read. fb_batch_desc_init must have filled it */
} fb_many_item;

/** The faces that fb_evaluate_many poses, and on how many threads. */
typedef struct fb_many_desc {
  uint32_t struct_size;
  uint32_t threads;             /**< at most; 0: with a parallel_for one an item, else as many as OpenMP would use */
  const fb_many_item* items;    /**< no two of them write to the same memory */
  uint32_t item_count;          /**< may be 0 */
  uint32_t reserved;            /**< 0 */
  fb_parallel_for parallel_for; /**< as in fb_batch_desc: called once, with item_count tasks */
  void* parallel_user;          /**< passed to parallel_for */
  fb_scratch* const* scratches; /**< for items without a scratch of their own: one of each of their models, whose worker
                                   w poses what thread w takes. So each should have as many workers as there are
                                   threads: threads may not be more, and are not where it is 0. Faces need no memory of
                                   their own but their outputs. May be null */
  uint32_t scratch_count;       /**< of scratches */
  uint32_t reserved_scratches;  /**< 0 */
  uint64_t* clamped; /**< item_count numbers: how many control values of each item were clamped; 0 of those that failed.
                        Null: no output */
} fb_many_desc;

FB_API void fb_many_desc_fill(fb_many_desc* to, uint32_t struct_size);
static inline void fb_many_desc_init(fb_many_desc* to) {
  fb_many_desc_fill(to, (uint32_t)sizeof *to);
}

/** Poses faces of different models, each item on one thread, with the same bits as by fb_evaluate_batch one by one;
 * then fb_clamped_count of an item's scratch is that item's, and of one of fb_many_desc::scratches the sum over its
 * items. Threads take items in their order: those that take longest are best first. Fails with
 * FB_ERROR_INVALID_ARGUMENT, before anything is written, where an item lacks model, batch or a scratch in either place,
 * or a scratch is of another model, in use by another call or in the lists twice. Otherwise every
 * item is posed, whether others fail or not; one that fails, as fb_evaluate_batch does, writes nothing, and the error
 * of the first such item is returned. fb_last_error begins with "item I: ". *failed: that item, or item_count where
 * none failed or the error is of no item; may be null. A parallel_for that calls too few, too many or invalid tasks
 * fails with FB_ERROR_INVALID_ARGUMENT afterwards. Allocates nothing unless it fails. */
FB_API fb_status fb_evaluate_many(const fb_many_desc* desc, uint32_t* failed);

#ifdef __cplusplus
}
#endif
#endif
