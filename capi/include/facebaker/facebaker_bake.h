/** @file
 * FaceBaker authoring: open rigs and recordings, sample them, bake faces, measure and pack them. C99; link
 * libfacebaker_bake, which holds the runtime too. The command line tool does everything through this header.
 *
 * Shape of use:
 *
 *     fb_source_open -> fb_bake(desc, &report) -> fb_report_json(report) -> fb_report_free, fb_source_close
 *     fb_archive_open -> fb_eval, fb_verify, fb_inspect -> fb_archive_close
 *
 * Statuses, fb_last_error, struct_size and the growth of structs are as facebaker.h describes them. Every description
 * (`fb_..._desc`) is filled with defaults by its `_init`, and so is every struct that a function fills (`_init` sets
 * its struct_size). Flags are uint32_t, 0 or 1. Strings are UTF-8 and zero-terminated.
 *
 * Threads: objects (fb_source, fb_archive, fb_report) may be read from any number of threads at once unless a function
 * says otherwise. Calls that evaluate a source (fb_source_read, fb_source_evaluate, fb_source_evaluate_block,
 * fb_sample, fb_bake, fb_compare, fb_eval) run on one source one at a time, unless its info has FB_RIG_THREAD_SAFE. A
 * call never depends in its results on the number of threads.
 *
 * Files: fb_sample, fb_bake, fb_compare and fb_pack lock what they write, archive and work folder or dataset folder
 * (FILE.facebaker-lock, FOLDER/.facebaker-lock), and fail with IO if another call or process has it; the message names
 * that process. Files appear complete or not at all, and are on the disk when a call returns. What a killed process
 * left behind is removed by the next call that writes there. Links are followed; a replaced file hands on its rights.
 *
 * Stability: declarations marked "Unstable" may still change in a minor version before 1.0; all others only grow.
 */
#ifndef FACEBAKER_FACEBAKER_BAKE_H
#define FACEBAKER_FACEBAKER_BAKE_H

#include <facebaker/facebaker.h>
#include <facebaker/facebaker_archive.h>
#include <facebaker/facebaker_bag.h>
#include <facebaker/facebaker_export.h>
#include <facebaker/facebaker_rig.h>
#include <facebaker/facebaker_sign.h>
#include <facebaker/facebaker_source.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Reports: what a call found out ------------------------------------------------------------------------------ */

/** The result of a call, as a JSON document and as structs. Immutable but for fb_report_details. All that its functions
 * give out is the report's and lives as long as it does. */
typedef struct fb_report fb_report;

/** Null is allowed. */
FB_API void fb_report_free(fb_report* report);

/** The call's document: indented JSON that ends in a newline. Keys are only ever added. Null of null. */
FB_API const char* fb_report_json(const fb_report* report);

/** Unstable. All that a page about faces shows, as JSON, of fb_bake, fb_compare and fb_eval (of fb_check see there);
 * docs/measuring.md explains the figures. {"name", "units", "diagonal", "rig_calls", "measured_split", "methods",
 * "failed"}; each method has what compare's document has, and besides "clips"[]: "frame_mse", "frame_max",
 * "frame_expected" (a number a frame), "quality": "vertex_rms" (a number a vertex), "vertex_region" (an index into
 * "region_names", or their count), "worst_frames"[]: {"clip" (index), "frame", "mse", "max", "vertex", "place"}, which
 * differ from each other, the worst first, "stats": {"notes", "regions"[] with "epochs"[], "learning"[], "coverage",
 * "stages"[]}. Figures that were not measured are null. The text is made by the first call; not thread-safe for one
 * report. */
FB_API fb_status fb_report_details(fb_report* report, const char** json);

/** Distances of vertices from the true rig, over the diagonal D of the rest mesh. This struct is part of others and
 * never changes. */
typedef struct fb_errors {
  uint64_t frames;      /**< measured; 0: nothing was, and the rest is 0 */
  double mse;           /**< mean of the squared distance over D^2, of all vertices and frames */
  double rms;           /**< its square root */
  double mean;          /**< mean distance */
  double p99;           /**< 99 % of all vertices are nearer */
  double max;           /**< worst vertex of all frames */
  double mfm;           /**< mean over frames of the frame's worst vertex */
  uint64_t worst_frame; /**< the frame of max, counted over what was measured */
} fb_errors;

/* What a face is for. */
#define FB_USE_VARIANT 0 /**< makes shots: none is trained on */
#define FB_USE_BACKLOT 1 /**< preserves a character whose shots exist: they are trained on */

/** A face that was baked or measured. */
typedef struct fb_method {
  uint32_t struct_size;
  int32_t use;            /**< FB_USE_... */
  const char* name;       /**< the recipe; of fb_eval the archive's */
  const void* archive;    /**< bytes of the .fbk; for fb_load_memory or fb_archive_open_memory */
  uint64_t archive_bytes; /**< of them */
  uint64_t poses;         /**< trained on; 0: not known */
  uint64_t parameters;    /**< trained numbers */
  uint64_t coefficients;  /**< columns of the basis */
  uint64_t rig_calls;     /**< poses evaluated besides the recorded ones */
  double train_seconds;   /**< basis and networks, without sampling */
  fb_errors unseen;       /**< on clips that were not trained on (fb_eval: on the clips asked for) */
  fb_errors dependency;   /**< on poses trained on */
  fb_errors quantisation; /**< fb_bake: of the packed face against that of floats */
  uint32_t clip_count;    /**< of fb_report_clip_at */
  uint32_t reserved;
} fb_method;

FB_API void fb_method_fill(fb_method* to, uint32_t struct_size);
static inline void fb_method_init(fb_method* to) {
  fb_method_fill(to, (uint32_t)sizeof *to);
}
/** Faces of the report: 1 of fb_bake and fb_eval, one for every method and use of fb_compare, else 0. */
FB_API uint32_t fb_report_method_count(const fb_report* report);
/** Fills *method for index < fb_report_method_count; its pointers are the report's. */
FB_API fb_status fb_report_method_at(const fb_report* report, uint32_t index, fb_method* method);

/** Errors on one clip. */
typedef struct fb_clip_errors {
  uint32_t struct_size;
  int32_t kind;  /**< FB_CLIP_... */
  int32_t split; /**< FB_SPLIT_... */
  uint32_t reserved;
  const char* name; /**< of the clip */
  fb_errors errors; /**< over its frames */
} fb_clip_errors;

FB_API void fb_clip_errors_fill(fb_clip_errors* to, uint32_t struct_size);
static inline void fb_clip_errors_init(fb_clip_errors* to) {
  fb_clip_errors_fill(to, (uint32_t)sizeof *to);
}
/** Errors of a method on its clip at index < clip_count, in the order of the source's clips. */
FB_API fb_status fb_report_clip_at(const fb_report* report, uint32_t method, uint32_t index, fb_clip_errors* clip);

/** A method of fb_compare that could not be baked or measured. */
typedef struct fb_failure {
  uint32_t struct_size;
  int32_t use;        /**< FB_USE_... */
  const char* name;   /**< of the method */
  const char* reason; /**< the message of its error */
} fb_failure;

FB_API void fb_failure_fill(fb_failure* to, uint32_t struct_size);
static inline void fb_failure_init(fb_failure* to) {
  fb_failure_fill(to, (uint32_t)sizeof *to);
}
/** Methods of fb_compare that failed. */
FB_API uint32_t fb_report_failure_count(const fb_report* report);
/** Fills *failure for index < fb_report_failure_count; its strings are the report's. */
FB_API fb_status fb_report_failure_at(const fb_report* report, uint32_t index, fb_failure* failure);

/** The recording that fb_compare made of a live rig, which has the clips that were measured on; null where those are
 * the source's own. Do not close it. Its frames are read from the work folder. */
FB_API fb_source* fb_report_source(const fb_report* report);

/* ---- Sampling ---------------------------------------------------------------------------------------------------- */

/** What to sample. */
typedef struct fb_sample_desc {
  uint32_t struct_size;
  uint32_t threads;         /**< at most 4,096; 0 (default): all */
  fb_source* source;        /**< a live one */
  const char* directory;    /**< the dataset folder to write; one begun with the same options is continued */
  uint64_t poses;           /**< new training poses; 0 (default): 20,000, or all of rig_budget */
  uint64_t seed;            /**< default 1 */
  const char* mix;          /**< how poses are spread over the kinds: "dense" (default) or "paper" */
  uint64_t rig_budget;      /**< different poses asked for at most in order to learn, at least the ends of all
                               ranges; `poses` is cut to that. Clips, test poses and poses evaluated again do not count. 0
                               (default): no limit */
  uint32_t shots;           /**< 1 (default): also the rig's own clips */
  uint32_t clip_count;      /**< of clips */
  const fb_rig_clip* clips; /**< more clips to evaluate; values beyond their range are clamped */
  uint32_t clip_stride;     /**< bytes from a clip to the next; default sizeof(fb_rig_clip) */
  uint32_t reserved;
  fb_callbacks callbacks;
  uint32_t skip_failing;  /**< 1: puts the rest pose in the place of drawn poses that the rig cannot evaluate, up to a
                             tenth of them, with a note on each; 0 (default): fail. Poses of clips, and of controls
                             moved alone, which the plan is made from, always have to succeed */
  uint32_t example_count; /**< of examples */
  const char* const* examples; /**< files of control curves near which a third of the poses that are not of single
                                  controls are sampled: .npy of frames x controls, .csv with named columns (such as
                                  takes of Live Link Face), dataset folders, but for their test clips. Frames of the
                                  source's own test clips are left out. Null (default): none */
  const char* schema; /**< of fb_plan, in place of source: a file like dataset.json, whose "rest" may be missing and
                         whose "clips" are not read (docs/datasets.md). Null (default): there is a source */
} fb_sample_desc;

FB_API void fb_sample_desc_fill(fb_sample_desc* to, uint32_t struct_size);
static inline void fb_sample_desc_init(fb_sample_desc* to) {
  fb_sample_desc_fill(to, (uint32_t)sizeof *to);
}
/** Plans and evaluates training poses and writes them as a dataset folder, shard by shard. `report` may be null. Fails
 * with INVALID_ARGUMENT on a recording, BAD_DATA on a folder that holds something else, RIG, NOT_FINITE, IO. */
FB_API fb_status fb_sample(const fb_sample_desc* desc, fb_report** report);

/** Plans the poses that some program is to evaluate and writes them as a dataset folder without points: controls,
 * dataset.json with the names of the files of points, and the rest mesh where it is known. The folder is complete when
 * the program has written these files; a clip can be read as soon as its own are there. Of a live source, the poses are
 * those of fb_sample, for which its controls are evaluated one by one; of a recording or a schema, those that follow
 * from its controls alone, with every control at the ends of its range where `poses` allows for that. Of the
 * description, rig_budget, skip_failing and shots of recordings have no effect. Where the source has no test clips, a
 * fifth of `poses`, at most 2,000, are drawn besides to test with; and the rest pose is a clip. A folder that holds the
 * same plan stays as it is. `report` may be null; fb_report_sample gives its poses. Fails with INVALID_ARGUMENT on a
 * folder that holds something else, and as fb_sample does. */
FB_API fb_status fb_plan(const fb_sample_desc* desc, fb_report** report);

/** What fb_sample did. */
typedef struct fb_sample_result {
  uint32_t struct_size;
  uint32_t reserved;
  uint64_t poses;     /**< in the dataset */
  uint64_t evaluated; /**< of those, in this call */
  uint64_t rig_calls; /**< poses evaluated in this call, for whatever reason */
  uint64_t asked; /**< different poses asked for in order to learn, what rig_budget limits: by interrupted calls too */
  uint64_t left_out; /**< of poses, those that failed and are the rest pose now, by interrupted calls too */
} fb_sample_result;

FB_API void fb_sample_result_fill(fb_sample_result* to, uint32_t struct_size);
static inline void fb_sample_result_init(fb_sample_result* to) {
  fb_sample_result_fill(to, (uint32_t)sizeof *to);
}
/** Refused with INVALID_ARGUMENT for the report of another call. */
FB_API fb_status fb_report_sample(const fb_report* report, fb_sample_result* result);

/* ---- Checking ---------------------------------------------------------------------------------------------------- */

/** What to check. */
typedef struct fb_check_desc {
  uint32_t struct_size;
  uint32_t threads;      /**< at most 4,096; 0 (default): all */
  const char* directory; /**< a dataset folder, whatever is wrong with it */
  fb_callbacks callbacks;
} fb_check_desc;

FB_API void fb_check_desc_fill(fb_check_desc* to, uint32_t struct_size);
static inline void fb_check_desc_init(fb_check_desc* to) {
  fb_check_desc_fill(to, (uint32_t)sizeof *to);
}
/** Reads a dataset folder, all of its points included, and finds everything that is wrong with it, and what its poses
 * cover. The document has "bakeable", "faults" and "warnings" (each "kind", "clip", "text"), "clips", "controls",
 * "active" and "pairs"; docs/datasets.md explains them. fb_report_details has besides "vertex_motion" (a number a
 * vertex), "pair_shares" (controls x controls numbers) and "largest_frames", for pictures. Faults are no failure of the
 * call, see fb_check_result. Fails with NOT_FOUND where there is no folder, INTERRUPTED, and with IO on one that is
 * being written. */
FB_API fb_status fb_check(const fb_check_desc* desc, fb_report** report);

/** What fb_check found. */
typedef struct fb_check_result {
  uint32_t struct_size;
  uint32_t bakeable;  /**< 1: there is no fault, and fb_bake takes the folder */
  uint64_t faults;    /**< that keep it from being baked */
  uint64_t warnings;  /**< that do not */
  uint64_t poses;     /**< of all clips */
  uint64_t evaluated; /**< of those, with points */
} fb_check_result;

FB_API void fb_check_result_fill(fb_check_result* to, uint32_t struct_size);
static inline void fb_check_result_init(fb_check_result* to) {
  fb_check_result_fill(to, (uint32_t)sizeof *to);
}
/** Refused with INVALID_ARGUMENT for the report of another call. */
FB_API fb_status fb_report_check(const fb_report* report, fb_check_result* result);

/* ---- Baking ------------------------------------------------------------------------------------------------------ */

/** Recipes that fb_bake and fb_compare know: "hero" and "compact", and those they are compared with ("paper", "linear",
 * ...). */
FB_API uint32_t fb_recipe_count(void);
/** The name of a recipe, in static storage; null for index >= fb_recipe_count. */
FB_API const char* fb_recipe_name(uint32_t index);

/* What the value of an option is. */
#define FB_OPTION_COUNT 0  /**< a whole number */
#define FB_OPTION_NUMBER 1 /**< a number with a point or without */
#define FB_OPTION_FLAG 2   /**< 0 or 1 */
#define FB_OPTION_WORD 3   /**< one of fb_option_info::words */
#define FB_OPTION_PATH 4   /**< of a file, UTF-8 */

/* What an option decides, and with that who takes it. */
#define FB_OPTION_SAMPLING 0 /**< which poses of a live source are learnt from: of fb_bake, fb_compare */
#define FB_OPTION_TRAINING 1 /**< how it is learnt: of fb_bake, fb_compare */
#define FB_OPTION_LIMITS 2   /**< what an archive may take: of fb_bake */
#define FB_OPTION_FACE 3     /**< everything else: of fb_bake */

/** An option of fb_bake and fb_compare, for programs that show or pass on all there are. Texts stay valid. */
typedef struct fb_option_info {
  uint32_t struct_size;
  int32_t kind;         /**< FB_OPTION_COUNT, ... */
  int32_t part;         /**< FB_OPTION_SAMPLING, ... */
  uint32_t reserved;    /**< 0 */
  const char* name;     /**< of the option, and of the field of descriptions that have one: "normal_weight" */
  const char* argument; /**< of the tool's command line, "--normal-weight"; "": the tool has another form of it */
  const char* value;    /**< what the tool's help calls the value, "W"; "" of flags and words */
  const char* standard; /**< the default, as a text that fb_bake_desc::options takes */
  const char* words;    /**< that a word may be, with commas between; "" of others */
  const char* since;    /**< version that had the option first */
  const char* help;     /**< an English sentence without its full stop */
  double least;         /**< of a number */
  double most;          /**< of a number; DBL_MAX where the type alone is the limit */
} fb_option_info;

FB_API void fb_option_info_fill(fb_option_info* to, uint32_t struct_size);
static inline void fb_option_info_init(fb_option_info* to) {
  fb_option_info_fill(to, (uint32_t)sizeof *to);
}
/** How many options there are. Thread-safe, as fb_option_at. */
FB_API uint32_t fb_option_count(void);
/** Describes an option; INVALID_ARGUMENT for index >= fb_option_count. */
FB_API fb_status fb_option_at(uint32_t index, fb_option_info* info);

/* What to measure; or-ed. */
#define FB_MEASURE_QUALITY \
  1u /**< normals, jitter, border jumps, contact, errors by region, control, vertex and frame */
#define FB_MEASURE_LOCALITY                                                                 \
  2u /**< whether controls move vertices that they do not move in the rig; of a live source \
        only, else left out */

/** What to bake. */
typedef struct fb_bake_desc {
  uint32_t struct_size;
  uint32_t threads;    /**< at most 4,096; 0 (default): all */
  fb_source* source;   /**< a live one is sampled first */
  const char* archive; /**< the .fbk to write: complete or not at all */
  const char* recipe;  /**< default "hero" */
  int32_t use;         /**< FB_USE_...; default FB_USE_BACKLOT */
  uint32_t epochs;     /**< passes over the training poses; 0 (default): the recipe's own */
  uint64_t poses;  /**< sampled from a live source; 0 (default): 20,000, or all of rig_budget, or 2,000 of a source that
                      is linear in its controls, as morph targets are, if the recipe analyses rigs and rig_budget is 0
                      or at least 10,000 */
  const char* mix; /**< of those: "dense" (default) or "paper" */
  uint64_t rig_budget; /**< different poses asked for at most in order to learn, see fb_sample_desc; measuring besides
                          the rig's own clips takes what is left. 0 (default): no limit */
  uint64_t seed;       /**< of everything random; default 1 */
  uint64_t max_bytes;  /**< of the archive: as precise as they allow; 0 (default): the recipe's precision */
  double max_error;    /**< largest distance of a vertex, over the diagonal, on any pose that nothing was fitted to: in
                          as few bytes as poses held back allow; 0 (default): none; max_bytes comes first */
  uint32_t force;      /**< 1: write the nearest face to what cannot be met; 0 (default): fail with LIMIT */
  uint32_t measure;    /**< FB_MEASURE_..., for the report: on clips of the split test, or of validation where there is
                          none, see fb_source_desc::clip_budget; locality within what rig_budget leaves. Default 0 */
  uint32_t learning_curve; /**< 1: bake on parts of the poses too, for the report; takes about as long again */
  uint32_t reserved;
  const char* licence; /**< text that goes into the archive; null (default): none */
  const char*
      created;      /**< a date for the provenance; null (default): none, so that the same seed gives the same bytes */
  const char* work; /**< folder that keeps what makes resuming possible; null (default): "<archive>.work". Once
                       the archive is whole, that is removed, and of one that is named stays what reuse and the same
                       bake with other exact poses need */
  fb_callbacks callbacks;
  const char* reuse; /**< work folder of an earlier bake, whose source was an earlier version of this one, with the same
                        polygons: what was evaluated then is taken over as far as it still holds, by the names of
                        controls, checked on a sample, and counts against no budget. Null (default), or a struct_size
                        that ends before it: none */
  uint32_t skip_failing;  /**< 1: leaves out what a live source cannot evaluate where that is possible, with a note:
                             drawn poses, see fb_sample_desc; the analysis of the rig, in place of which blendshapes are
                             fitted to the training poses; measuring. 0 (default): fail */
  uint32_t example_count; /**< of examples */
  const char* const* examples; /**< files of control curves near which a live source is sampled, see fb_sample_desc */
  double normal_weight; /**< how much errors of normals count beside distances when the face is rounded, 0 to 4: where
                           vertices lie densely, its values are finer in proportion to this power of their spacing, as
                           the same error turns normals more there. 0: distances alone; default 1 */
  uint64_t cache_bytes; /**< size that evaluations of a slow source, kept in the work folder until the bake is done, may
                           have: what is not kept is evaluated again after an interruption. What rig_budget counts, or
                           reuse takes over, is kept in any case. Default 8 GiB */
  const char* about;    /**< a JSON object that says whose the character is and what may be done with it, see
                           docs/characters.md: its fields come before those of the source, and null removes them. Null
                           (default): what the source says */
  const void* thumbnail;      /**< a PNG that shows the character: square, at most 512 pixels wide and 64 KiB; null
                                 (default): none, or what draw_thumbnail draws */
  uint64_t thumbnail_bytes;   /**< of thumbnail */
  const char* const* exact;   /**< poses that must come out as the source gives them, within rounding: "CLIP:FRAME",
                                 "CLIP:FRAME,FRAME,...", "CLIP" for all its frames, or, of a live source, a .csv or .npy
                                 of control values as in examples; 1,024 poses at most. Poses at rest are exact anyhow */
  uint32_t exact_count;       /**< of exact; default 0 */
  uint32_t reserved2;         /**< 0 */
  uint32_t level_share_count; /**< of level_shares; at most 15 */
  uint32_t level_mesh_count;  /**< of level_meshes; at most 15 */
  const double* level_shares; /**< levels of detail by simplifying: of about so many of the vertices, each share
                                 between 0 and the one before it, the first below 1. Not of the paper's recipes
                                 and baselines. Null (default): none */
  const char* const* level_meshes; /**< levels of detail as given: files .obj or .glb, the finest first, whose vertices
                                      are vertices of the source's rest mesh, up to 1e-4 of its diagonal; in place of
                                      level_shares. Null (default): none */
  const char* const* options; /**< options by name, "NAME=VALUE" each (fb_option_at lists them), over the fields of the
                                 same names; those that came after 0.9 have no field. Null (default): none */
  uint32_t option_count;      /**< of options */
  uint32_t reserved3;         /**< 0 */
  /** Draws the thumbnail of the baked face, in place of `thumbnail`, where that is null. archive has the bytes of the
   * .fbk without one, for fb_load_memory; they are valid during the call. png has room for FB_THUMBNAIL_BYTES, of which
   * *png_bytes, which is 0 before, receives how many are used; 0: the archive has no thumbnail. Called once, when all
   * else is done, on a thread that the call started or the calling one; meanwhile `callbacks` may be called on another.
   * Returns FB_OK, or an error after writing a sentence into message (message_size bytes, zero-terminated). After
   * FB_ERROR_INTERRUPTED and FB_ERROR_OUT_OF_MEMORY fb_bake fails with them, and the same call goes on from the work
   * folder. After other errors, what it throws, in C++, included, and with a picture that is no thumbnail or would make
   * the archive longer than max_bytes, the archive has none, and a note says why. Of max_bytes, a 24th is left for it,
   * but at least 8 KiB, at most 40 KiB, and never more than a quarter. Null (default): none is drawn */
  fb_status (*draw_thumbnail)(void* user, const void* archive, uint64_t archive_bytes, void* png, uint64_t* png_bytes,
                              char* message, uint32_t message_size);
  void* thumbnail_user; /**< passed to draw_thumbnail */
} fb_bake_desc;

FB_API void fb_bake_desc_fill(fb_bake_desc* to, uint32_t struct_size);
static inline void fb_bake_desc_init(fb_bake_desc* to) {
  fb_bake_desc_fill(to, (uint32_t)sizeof *to);
}
/** Samples a live source, trains, packs, measures and verifies a face and writes its archive. Interrupted, the same
 * call goes on from the work folder. `report` may be null. Fails with NOT_FOUND on a recipe there is not, LIMIT on a
 * size or error that cannot be met, BAD_DATA, RIG, NOT_FINITE, IO, INTERRUPTED; the archive is then as it was
 * before.
 */
FB_API fb_status fb_bake(const fb_bake_desc* desc, fb_report** report);

/* ---- Comparing --------------------------------------------------------------------------------------------------- */

/** What to compare. */
typedef struct fb_compare_desc {
  uint32_t struct_size;
  uint32_t threads;           /**< at most 4,096; 0 (default): all */
  fb_source* source;          /**< a live one, or a recording with clips of the split test */
  const char* const* methods; /**< recipes; null (default): "linear", "paper-tuned", "hero" */
  uint32_t method_count;      /**< of methods */
  uint32_t epochs;            /**< passes over the training poses; 0 (default): each recipe's own */
  uint64_t poses;             /**< sampled from a live source; 0 (default): 20,000, or all of rig_budget */
  const char* mix;            /**< of those: "dense" (default) or "paper" */
  uint64_t rig_budget;        /**< different poses asked for at most in order to learn, see fb_sample_desc; 0
                                 (default): no limit */
  uint64_t seed;              /**< default 1 */
  uint32_t learning_curve;    /**< 1: bake on parts of the poses too */
  uint32_t reserved;
  const char* work; /**< folder for intermediate files, kept so that the same call goes on; null (default): a temporary
                       one, removed by fb_report_free */
  fb_callbacks callbacks;
  const char* const* options; /**< as in fb_bake_desc, those of sampling and training; null (default): none */
  uint32_t option_count;      /**< of options */
  uint32_t reserved2;         /**< 0 */
} fb_compare_desc;

FB_API void fb_compare_desc_fill(fb_compare_desc* to, uint32_t struct_size);
static inline void fb_compare_desc_init(fb_compare_desc* to) {
  fb_compare_desc_fill(to, (uint32_t)sizeof *to);
}
/** Bakes several methods on the same poses and measures them, with quality and, of a live source, locality, on the same
 * clips. A method that fails is among the report's failures; if all fail, the first error is the call's. */
FB_API fb_status fb_compare(const fb_compare_desc* desc, fb_report** report);

/* ---- Inspecting, measuring, verifying ------------------------------------------------------------------------------
 */

/** Everything worth knowing of an archive as the document of `inspect`. */
FB_API fb_status fb_inspect(const fb_archive* archive, fb_report** report);

/** What to measure. */
typedef struct fb_eval_desc {
  uint32_t struct_size;
  uint32_t threads;          /**< at most 4,096; 0 (default): all */
  const fb_archive* archive; /**< the face */
  fb_source* source;         /**< of the same face: same controls, same rest mesh */
  int32_t split;             /**< which clips: FB_SPLIT_...; default FB_SPLIT_TEST */
  uint32_t measure;          /**< besides errors: FB_MEASURE_...; default 0 */
  fb_callbacks callbacks;
} fb_eval_desc;

FB_API void fb_eval_desc_fill(fb_eval_desc* to, uint32_t struct_size);
static inline void fb_eval_desc_init(fb_eval_desc* to) {
  fb_eval_desc_fill(to, (uint32_t)sizeof *to);
}
/** Compares an archive, evaluated by the runtime that ships, with the true rig. Fails with BAD_DATA on another face or
 * where there is no such clip. */
FB_API fb_status fb_eval(const fb_eval_desc* desc, fb_report** report);

/** What has changed between two archives of one character, as the document of `diff`: controls, mesh, texts, and, where
 * both have as many vertices, distances at rest, of each common control alone and in random poses, with places. */
FB_API fb_status fb_diff(const fb_archive* before, const fb_archive* now, fb_report** report);

/** Evaluates the poses of the archive's proof and compares them bit for bit. Fails with CORRUPT, naming pose and
 * vertex. `report` may be null. An archive without a proof is whole, with 0 poses in the report. */
FB_API fb_status fb_verify(const fb_archive* archive, fb_report** report);

/** What fb_verify compared. */
typedef struct fb_verify_result {
  uint32_t struct_size;
  uint32_t reserved;
  uint64_t bytes;    /**< of the archive */
  uint64_t poses;    /**< evaluated */
  uint64_t vertices; /**< of each */
} fb_verify_result;

FB_API void fb_verify_result_fill(fb_verify_result* to, uint32_t struct_size);
static inline void fb_verify_result_init(fb_verify_result* to) {
  fb_verify_result_fill(to, (uint32_t)sizeof *to);
}
/** Refused with INVALID_ARGUMENT for the report of another call. */
FB_API fb_status fb_report_verify(const fb_report* report, fb_verify_result* result);

/* ---- Packing ----------------------------------------------------------------------------------------------------- */

/** What to pack. */
typedef struct fb_pack_desc {
  uint32_t struct_size;
  uint32_t force;      /**< 1: write a face that does not meet max_bytes or max_error; 0 (default): fail with LIMIT */
  const char* path;    /**< the archive to pack */
  const void* bytes;   /**< in place of path: the archive in memory */
  uint64_t byte_count; /**< of bytes */
  const char* out;     /**< the .fbk to write: complete or not at all; may be path; null: only into the report */
  uint64_t seed;       /**< of the poses that precision is measured on, and of a new proof; default 1 */
  uint64_t max_bytes;  /**< of the new archive: in the smallest quantisation steps within them; 0 (default): any */
  double max_error;    /**< largest displacement of a vertex, over the diagonal. Alone: in as few bytes as it allows;
                          with max_bytes: a limit. 0 (default): none, or with max_bytes the largest error that the
                          certificate states */
  const char* licence; /**< text in place of the archive's; null (default): kept */
  fb_callbacks callbacks;
  const char* about; /**< fields to put over what the archive says of the character, see fb_bake_desc; null (default):
                        kept as it is */
  const void* thumbnail;    /**< in place of the archive's, see fb_bake_desc; null (default): kept */
  uint64_t thumbnail_bytes; /**< of thumbnail */
  const char* sockets;      /**< a JSON array of sockets, see docs/characters.md, which are added to the archive's, or
                               replace those of the same names. Its proof is made anew. Null (default): none */
} fb_pack_desc;

FB_API void fb_pack_desc_fill(fb_pack_desc* to, uint32_t struct_size);
static inline void fb_pack_desc_init(fb_pack_desc* to) {
  fb_pack_desc_fill(to, (uint32_t)sizeof *to);
}
/** Packs an archive again, without training: into this version of the format, into fewer bytes, with another licence.
 * Without a target the face poses as it did, to the last bit, and its proof is kept. `report` may be null. Fails as
 * fb_archive_open does, and with LIMIT, saying what could be met, on a target that cannot be. */
FB_API fb_status fb_pack(const fb_pack_desc* desc, fb_report** report);

/** What fb_pack made. */
typedef struct fb_pack_result {
  uint32_t struct_size;
  uint32_t within_limits; /**< 0 with force only: a target was not met */
  const void* archive;    /**< bytes of the new archive */
  uint64_t archive_bytes; /**< of them */
  uint64_t bytes_before;  /**< of the archive that was packed */
  uint32_t format_before; /**< format version, major * 1,000 + minor */
  uint32_t format;        /**< of the new archive */
  double step_factor;     /**< of the basis' quantisation steps; 1: as they were */
  double max_error;       /**< the limit of the displacement that held, over the diagonal; 0: none did */
  fb_errors displacement; /**< of vertices from where they were, on seeded poses; frames 0: none */
} fb_pack_result;

FB_API void fb_pack_result_fill(fb_pack_result* to, uint32_t struct_size);
static inline void fb_pack_result_init(fb_pack_result* to) {
  fb_pack_result_fill(to, (uint32_t)sizeof *to);
}
/** Refused with INVALID_ARGUMENT for the report of another call. */
FB_API fb_status fb_report_pack(const fb_report* report, fb_pack_result* result);

#ifdef __cplusplus
}
#endif
#endif
