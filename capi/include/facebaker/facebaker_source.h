/** @file
 * FaceBaker sources: where the poses of a bake come from, rigs and recordings, and how a call that takes long reports
 * to its host. C99; in libfacebaker_bake. facebaker_bake.h, which includes this, has the rules that hold for all of it.
 */
#ifndef FACEBAKER_FACEBAKER_SOURCE_H
#define FACEBAKER_FACEBAKER_SOURCE_H

#include <facebaker/facebaker.h>
#include <facebaker/facebaker_rig.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Progress, notes, cancelling --------------------------------------------------------------------------------- */

/** How a call that takes long reports to its host. Either function may be null. They are called from the calling thread
 * or from one that the call started, never two at once; they must not throw and must not call the same source. This
 * struct is part of others and never changes. */
typedef struct fb_callbacks {
  void* user; /**< passed to both */
  /** `done` of `total` steps of a stage ("training") are complete; a stage begins with done = 0, and 0 may come more
   * than once. Called at least twice a second, but for the time that a single call of the rig takes. Return non-zero to
   * stop: the call ends with FB_ERROR_INTERRUPTED at the next point where nothing is lost, and the same call goes on
   * from there where a work folder or dataset keeps what is done. */
  int32_t (*progress)(void* user, const char* stage, uint64_t done, uint64_t total);
  /** A sentence that is no error: a clip left out, a value clamped, what analysis found. Valid during the call. */
  void (*note)(void* user, const char* sentence);
} fb_callbacks;

/* What a stage belongs to, in the order of a bake, which may come back to an earlier one. */
#define FB_PHASE_SAMPLING 0  /**< poses of a source are evaluated */
#define FB_PHASE_ANALYSIS 1  /**< curves and correctives are looked for */
#define FB_PHASE_TRAINING 2  /**< local blendshapes and networks are trained */
#define FB_PHASE_PACKING 3   /**< values are rounded and coded */
#define FB_PHASE_MEASURING 4 /**< errors are measured, datasets checked */
#define FB_PHASE_WRITING 5   /**< other forms of a face are written */

/** The phase, FB_PHASE_..., of the stage that fb_callbacks::progress is called for: to be asked within it, on its
 * thread. Before any such call, FB_PHASE_SAMPLING. */
FB_API int32_t fb_progress_phase(void);

/* ---- Sources: where poses come from ------------------------------------------------------------------------------ */

/** An opened rig or recording. Immutable but for what its rig keeps. */
typedef struct fb_source fb_source;

/* What the joints of a glTF file are; fb_source_desc::joints. */
/** Controls where the file has no morph targets and its animations move joints; otherwise ignored. */
#define FB_JOINTS_AUTO 0u
/** The skeleton that carries the face: positions are before skinning, and the archive has joints and skin. */
#define FB_JOINTS_IGNORE 1u
/** Controls, behind the morph targets: "NAME.tx", ".ty", ".tz", added to the translation of the joint at rest, in
 * metres; "NAME.rx", ".ry", ".rz", a rotation vector in degrees, in the joint at rest; "NAME.sx", ".sy", ".sz", added
 * to its scale. All rest at 0. Their ranges are those of the file's animations. Positions are after skinning, and the
 * archive has neither joints nor skin. */
#define FB_JOINTS_CONTROLS 2u

/** What to open. */
typedef struct fb_source_desc {
  uint32_t struct_size;
  uint32_t path_count;      /**< of paths; 0 with a rig */
  const char* const* paths; /**< each a dataset folder, a rig plugin (.so), a .glb, .gltf or .vrm file, "exec:COMMAND"
                               for a program that speaks the rig protocol (docs/rig-protocol.md), run by /bin/sh, or
                               "sample" for the built-in face; several are one character: same controls, same rest
                               mesh */
  const fb_rig* rig;        /**< in place of paths: a rig that the host filled. Borrowed until fb_source_close, which
                               does not call destroy. */
  fb_callbacks callbacks;   /**< note: what was found while opening; progress: while child processes start */
  uint32_t workers; /**< at most 256 child processes that run the rigs of paths at once, to be killed and started
                       again where they crash or hang; results do not depend on it. 0 (default): rigs run in
                       this process, a command in one child */
  uint32_t reserved;
  const char* host;     /**< with workers: the program that serves a rig in a child, run as `HOST rig-host SOURCE`; null
                           (default): "facebaker", found in PATH */
  double pose_seconds;  /**< a pose that takes a child longer hangs; starting may take five times as long. Above 0;
                           default 60 */
  uint64_t clip_budget; /**< frames of a live rig's own clips that are used at most, of each split: where it has more,
                           stretches of about 32 frames, evenly spaced over every clip, are clips in their place, called
                           "CLIP [FIRST-LAST]". 0 (default): all */
  /** FB_JOINTS_..., of glTF files, of which paths must have one unless it is FB_JOINTS_AUTO (default). */
  uint32_t joints;
  uint32_t control_joint_count; /**< of control_joints; above 0: joints are controls. Fails with FB_JOINTS_IGNORE */
  /** Names of the joints, or other nodes, of a glTF file that are controls, in place of all that its animations move;
   * one that no animation turns turns by 30 degrees either way around each axis. */
  const char* const* control_joints;
  /** Where a live source has no clips, so many poses, at most 2^20, are drawn as clips of split test, always the same:
   * "random_15" and "random_35", every control active with a probability of 0.15 or 0.35, and "synthetic_shots". 0
   * (default): none. */
  uint64_t test_poses;
  uint32_t skip_broken; /**< 1: meshes and animations of a glTF file that cannot be read are left out, each with a note
                           that says why; 0 (default): the file is refused. Of paths one must be a glTF file */
  uint32_t reserved_broken; /**< 0 */
} fb_source_desc;

FB_API void fb_source_desc_fill(fb_source_desc* to, uint32_t struct_size);
static inline void fb_source_desc_init(fb_source_desc* to) {
  fb_source_desc_fill(to, (uint32_t)sizeof *to);
}

/** Opens a source and checks everything it declares; a rig's rest pose is evaluated once. *source is owned by the
 * caller. Fails with NOT_FOUND, IO, BAD_DATA, NOT_FINITE, RIG or UNSUPPORTED and a message that names the file, field,
 * control, clip or frame; with INTERRUPTED where progress stops it. Files may come from anyone; a plugin is code that
 * runs in this process, a command one that runs as this user. Children lead process groups of their own, print on
 * standard error, and end when the source is closed. A dataset that is being
 * sampled at that moment is refused with IO, naming the process. */
FB_API fb_status fb_source_open(const fb_source_desc* desc, fb_source** source);
/** Null is allowed. No call may be using the source. */
FB_API void fb_source_close(fb_source* source);

/** Opens a live source and serves it as a child process over the rig protocol (docs/rig-protocol.md): answers what
 * comes on the descriptor `requests` on the descriptor `answers`, until the parent says bye or closes its end. Where it
 * cannot be opened, the parent is told why instead, and the call succeeds. Fails with RIG on what is no request, and
 * IO. A program whose main() calls this is a source for another process: "exec:PROGRAM". */
FB_API fb_status fb_source_serve(const fb_source_desc* desc, int32_t requests, int32_t answers);

#define FB_SOURCE_LIVE 2u /**< new poses can be evaluated; without it the source is a recording */

/** What a source is. Strings and arrays are the source's and live as long as it does. */
typedef struct fb_source_info {
  uint32_t struct_size;
  uint32_t flags;         /**< FB_SOURCE_LIVE, FB_RIG_THREAD_SAFE */
  const char* name;       /**< of the character */
  const char* units;      /**< of positions */
  const char* up_axis;    /**< "y" or "z" */
  double diagonal;        /**< of the rest mesh's bounding box, in units: what every reported error is divided by */
  uint32_t control_count; /**< of fb_source_control_at; floats in a pose */
  uint32_t clip_count;    /**< of fb_source_clip_at */
  uint32_t vertex_count;  /**< of the mesh */
  uint32_t polygon_count; /**< of polygon_sizes */
  uint32_t polygon_corner_count;   /**< of polygon_corners */
  uint32_t uv_count;               /**< 0: no texture coordinates */
  const float* rest_positions;     /**< 3 x vertex_count, xyz interleaved */
  const uint32_t* polygon_sizes;   /**< corners of each polygon */
  const uint32_t* polygon_corners; /**< vertex indices, polygon after polygon */
  const float* uvs;                /**< 2 x uv_count, v growing upwards */
  const uint32_t* uv_corners;      /**< polygon_corner_count indices of pairs; null without texture coordinates */
  const char* identity;     /**< a text that two live sources have in common if their poses may be mixed: of the same
                               controls, rest mesh, declared version and program; "" of a recording */
  uint32_t channel_count;   /**< numbers that come with each pose; may be 0 */
  uint32_t preferred_block; /**< poses that keep all that evaluates a live source at work, such as its child processes;
                               0: any number will do */
  uint32_t number_count;    /**< what a pose of fb_pose_block has beside positions: its channels, and then how driven
                               joints have moved */
  uint32_t reserved_number; /**< 0 */
} fb_source_info;

FB_API void fb_source_info_fill(fb_source_info* to, uint32_t struct_size);
static inline void fb_source_info_init(fb_source_info* to) {
  fb_source_info_fill(to, (uint32_t)sizeof *to);
}
/** Fills *info. */
FB_API fb_status fb_source_describe(const fb_source* source, fb_source_info* info);

/** Fills *control for index < control_count; see fb_control_at. Its strings are the source's. */
FB_API fb_status fb_source_control_at(const fb_source* source, uint32_t index, fb_control* control);

/** A clip of a source. */
typedef struct fb_clip {
  uint32_t struct_size;
  int32_t kind;          /**< FB_CLIP_... */
  int32_t split;         /**< FB_SPLIT_... */
  uint32_t readable;     /**< 0: a plan, controls without recorded positions */
  const char* name;      /**< unique in the source */
  double fps;            /**< frames a second */
  uint64_t frames;       /**< at least 1 */
  const float* controls; /**< frames x control_count */
} fb_clip;

FB_API void fb_clip_fill(fb_clip* to, uint32_t struct_size);
static inline void fb_clip_init(fb_clip* to) {
  fb_clip_fill(to, (uint32_t)sizeof *to);
}
/** Fills *clip for index < clip_count; its pointers are the source's. */
FB_API fb_status fb_source_clip_at(const fb_source* source, uint32_t index, fb_clip* clip);

/** Positions of frames [first, first + count) of a clip: count x 3 x vertex_count floats, object space, in units.
 * Recorded frames are read, a live rig's are evaluated. `position_floats`: size of the buffer, checked. Fails by clip,
 * frame and vertex on what is not finite. */
FB_API fb_status fb_source_read(fb_source* source, uint32_t clip, uint64_t first, uint64_t count, float* positions,
                                uint64_t position_floats);

/** Positions of new poses of a live source: controls is poses x control_count, all within their ranges, positions is
 * poses x 3 x vertex_count floats; `position_floats`: size of that buffer, checked. On `threads` threads (at most
 * 4,096; 0: all) if the source is thread-safe. Fails with INVALID_ARGUMENT on a recording, and by pose on what cannot
 * be evaluated. */
FB_API fb_status fb_source_evaluate(fb_source* source, const float* controls, uint64_t poses, uint32_t threads,
                                    float* positions, uint64_t position_floats);

/* ---- Evaluating elsewhere ---------------------------------------------------------------------------------------- */

/** Poses of a live source to evaluate at once. */
typedef struct fb_pose_block {
  uint32_t struct_size;
  uint32_t threads; /**< of fb_source_evaluate_block, if the source is thread-safe: at most 4,096; 0 (default): all */
  uint64_t poses;   /**< how many */
  const float* controls; /**< poses x control_count, within their ranges */
  float* positions;      /**< receives poses x 3 x vertex_count floats: of a rig with joints, those before a host's
                            joints move them, and after driven ones have */
  float* channels;    /**< receives poses x number_count floats, as fb_source_info has it; null where there are none */
  uint8_t* answered;  /**< receives 1 for every pose that has its positions when the call ends, and 0 for the others */
  uint64_t evaluated; /**< receives how often a pose was evaluated, failed ones and those tried again included */
  uint64_t failed;    /**< receives the first pose that cannot be evaluated, where the status says that there is one,
                         and else `poses` */
  fb_callbacks callbacks; /**< progress: called several times a second by whoever evaluates, with any stage; non-zero:
                             the block ends with FB_ERROR_INTERRUPTED */
} fb_pose_block;

FB_API void fb_pose_block_fill(fb_pose_block* to, uint32_t struct_size);
static inline void fb_pose_block_init(fb_pose_block* to) {
  fb_pose_block_fill(to, (uint32_t)sizeof *to);
}

/** Evaluates a block. A pose that fails is tried once more; then the call fails with RIG or NOT_FINITE, block->failed
 * is the pose, and fb_last_error the reason. What was answered until then is flagged. Fails with INVALID_ARGUMENT on a
 * recording, and with INTERRUPTED. */
FB_API fb_status fb_source_evaluate_block(fb_source* source, fb_pose_block* block);

/** How a host evaluates the poses of a source: on other machines, say, each of which has opened the same source and
 * calls fb_source_evaluate_block. */
typedef struct fb_spreader {
  uint32_t struct_size;
  uint32_t preferred_block; /**< poses that keep all that evaluates at work, which blocks have where there are as many;
                               0: 1 */
  void* user;               /**< passed to both functions */
  /** Fills a block as fb_source_evaluate_block does, the same controls always with the same positions, whoever
   * evaluates them. Called by one thread at a time, which need not be the same; it may call the block's progress from
   * any of its own. On failure writes the reason into message (message_size bytes, zero-terminated). What it throws, in
   * C++, is an error too: FB_ERROR_RIG. */
  fb_status (*evaluate)(void* user, fb_pose_block* block, char* message, uint32_t message_size);
  /** Called by fb_source_close before the source below is closed; may be null. */
  void (*close)(void* user);
} fb_spreader;

FB_API void fb_spreader_fill(fb_spreader* to, uint32_t struct_size);
static inline void fb_spreader_init(fb_spreader* to) {
  fb_spreader_fill(to, (uint32_t)sizeof *to);
}

/** A live source like `source`, whose poses are evaluated by a host. It counts, caches and orders them like any other,
 * and archives are the same. Takes `source` over, which is closed with *spread; until then the host may evaluate it,
 * also while it evaluates a block. On failure `source` stays the caller's. Fails with INVALID_ARGUMENT on a recording.
 */
FB_API fb_status fb_source_spread(fb_source* source, const fb_spreader* spreader, fb_source** spread);

/** Fails with BAD_DATA, saying where they differ, unless the model has the source's controls (names, order, ranges) and
 * number of vertices. */
FB_API fb_status fb_source_check_model(const fb_source* source, const fb_model* model);

/** Frames of an animation in a NumPy file (.npy, version 1 or 2, little-endian, C order) of shape frames x
 * control_count. Reads the header only. Fails with NOT_FOUND, IO or BAD_DATA, naming the file. */
FB_API fb_status fb_clip_file_frames(const char* path, uint32_t control_count, uint64_t* frames);
/** Reads frames [first, first + count) of such a file into count x control_count floats. Values are as the file has
 * them: neither clamped nor checked. */
FB_API fb_status fb_clip_file_read(const char* path, uint32_t control_count, uint64_t first, uint64_t count,
                                   float* controls);

/** Frames and points of a file of positions, by the end of its name: a point cache, .mdd (LightWave) or .pc2 (3ds Max),
 * or else a NumPy file of frames x points x 3. Reads the header only. Fails with NOT_FOUND, IO or BAD_DATA, naming the
 * file. */
FB_API fb_status fb_point_file_size(const char* path, uint64_t* frames, uint64_t* points);
/** Reads frames [first, first + count) of such a file into count x points x 3 floats, as the file has them.
 * `position_floats`: size of the buffer, checked. */
FB_API fb_status fb_point_file_read(const char* path, uint64_t first, uint64_t count, float* positions,
                                    uint64_t position_floats);

#ifdef __cplusplus
}
#endif
#endif
