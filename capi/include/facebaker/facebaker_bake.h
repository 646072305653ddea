/* FaceBaker authoring: describe a rig, sample it, bake it. C99; link libfacebaker_bake (which holds the runtime too).
 *
 * A rig is anything that can say which controls it has, what its rest mesh is, and where the vertices go for a pose:
 * a plugin (librig_NAME.so exporting fb_rig_open) or an fb_rig filled by the host itself.
 * Statuses and fb_last_error are those of facebaker.h.
 */
#ifndef FACEBAKER_FACEBAKER_BAKE_H
#define FACEBAKER_FACEBAKER_BAKE_H

#include <facebaker/facebaker.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- A rig ------------------------------------------------------------------------------------------------------- */

#define FB_RIG_ABI 1 /* changes only when an older plugin could not be used any more */

typedef struct fb_rig_control {
  const char* name;  /* UTF-8, unique, not empty */
  const char* group; /* the region it belongs to ("brows", "mouth"); null or "": none. Sampling combines regions. */
  float minimum, maximum;
  float rest; /* value in the rest pose, within the range */
} fb_rig_control;

#define FB_CLIP_SHOT 0       /* animation: consecutive frames */
#define FB_CLIP_EXCITATION 1 /* one control at a time */
#define FB_CLIP_REGIONAL 2   /* combinations of regional expressions */
#define FB_CLIP_CALISTHENICS 3
#define FB_CLIP_DENSE 4 /* many controls of many regions at once */

#define FB_SPLIT_TRAIN 0
#define FB_SPLIT_VALIDATION 1
#define FB_SPLIT_TEST 2 /* never used for training or for any choice */

/* Controls over time that belong to the rig: its shots. */
typedef struct fb_rig_clip {
  const char* name;
  int32_t kind;  /* FB_CLIP_... */
  int32_t split; /* FB_SPLIT_... */
  double fps;    /* frames a second, > 0 */
  uint32_t frames;
  uint32_t reserved;
  const float* controls; /* frames x control_count */
} fb_rig_clip;

#define FB_RIG_THREAD_SAFE 1u /* evaluate may be called from several threads at once */

/* All pointers are owned by the rig and stay valid and unchanged until destroy. */
typedef struct fb_rig {
  uint32_t struct_size; /* sizeof(fb_rig) as the plugin was compiled */
  uint32_t abi;         /* FB_RIG_ABI */
  const char* name;     /* of the character */
  const char* units;    /* "cm", "m", ... */
  const char* up_axis;  /* "y" or "z" */
  uint32_t flags;       /* FB_RIG_... */
  uint32_t control_count;
  const fb_rig_control* controls;
  uint32_t vertex_count;
  uint32_t polygon_count;
  const float* rest_positions;     /* 3 x vertex_count, what evaluate gives with all controls at rest */
  const uint32_t* polygon_sizes;   /* corners of each polygon, >= 3 */
  const uint32_t* polygon_corners; /* vertex indices, polygon after polygon */
  uint32_t clip_count;             /* may be 0 */
  uint32_t reserved;
  const fb_rig_clip* clips;
  void* user;
  /* Evaluates a block of poses: controls is poses x control_count, positions receives poses x 3 x vertex_count.
   * Returns FB_OK, or an error after writing a sentence into message (message_size bytes, zero-terminated). Values
   * are always within their ranges. */
  fb_status (*evaluate)(void* user, uint64_t poses, const float* controls, float* positions, char* message,
                        uint32_t message_size);
  /* Frees everything the rig owns; may be null. */
  void (*destroy)(void* user);
  /* Texture coordinates, kept for who poses the face: 2 x uv_count floats, u and v, v growing upwards; and for each of
   * polygon_corners which of them it has, below uv_count. 0, or a struct_size that ends before them: none. */
  uint32_t uv_count;
  uint32_t reserved_uv;
  const float* uvs;
  const uint32_t* uv_corners;
} fb_rig;

/* Fills *rig. The one symbol a plugin exports, under the name fb_rig_open. `path` is the plugin's own file, so that
 * data beside it can be found. *rig comes zeroed, with room for a struct up to four times as long. On failure writes a
 * sentence into message and leaves nothing to destroy. */
typedef fb_status (*fb_rig_open_function)(const char* path, fb_rig* rig, char* message, uint32_t message_size);
#define FB_RIG_OPEN_SYMBOL "fb_rig_open"

/* ---- Sampling and baking ----------------------------------------------------------------------------------------- */

/* Called now and then from the calling thread with the stage ("training") and its progress; return non-zero to stop
 * with FB_ERROR_INTERRUPTED, keeping what is done. */
typedef int32_t (*fb_progress)(void* user, const char* stage, uint64_t done, uint64_t total);

/* Where poses come from: a path (dataset folder, rig plugin, .glb, .gltf or "sample") or a rig the host filled. */
typedef struct fb_source {
  const char* path;  /* null if rig is given */
  const fb_rig* rig; /* borrowed for the call; destroy is not called */
} fb_source;

typedef struct fb_sample_desc {
  uint32_t struct_size;
  uint32_t threads; /* at most 4,096; 0: all */
  fb_source source;
  const char* directory; /* the dataset folder to write; what is already sampled there is kept and continued */
  uint64_t poses;        /* default 20,000 */
  uint64_t seed;         /* default 1 */
  const char* mix;       /* "paper" or "dense" (default): how poses are spread over the kinds */
  fb_progress progress;  /* may be null */
  void* progress_user;
} fb_sample_desc;

FB_API void fb_sample_desc_fill(fb_sample_desc* to, uint32_t struct_size);
static inline void fb_sample_desc_init(fb_sample_desc* to) {
  fb_sample_desc_fill(to, (uint32_t)sizeof *to);
}
/* Plans and evaluates training poses and writes them as a dataset folder. */
FB_API fb_status fb_sample(const fb_sample_desc* desc);

typedef struct fb_bake_desc {
  uint32_t struct_size;
  uint32_t threads;         /* at most 4,096; 0: all */
  const fb_source* sources; /* datasets of one character together, or one rig */
  uint32_t source_count;
  uint32_t reserved;
  const char* archive;  /* the .fbk to write; "<archive>.work" beside it keeps what is done until it is whole */
  const char* recipe;   /* "hero" (default), "compact", or one of those to compare with: "paper", "linear", ... */
  const char* use;      /* "variant" (no shots in training) or "backlot" (default) */
  uint64_t poses;       /* sampled when the source is a rig; default 20,000 */
  uint64_t seed;        /* default 1 */
  fb_progress progress; /* may be null */
  void* progress_user;
} fb_bake_desc;

FB_API void fb_bake_desc_fill(fb_bake_desc* to, uint32_t struct_size);
static inline void fb_bake_desc_init(fb_bake_desc* to) {
  fb_bake_desc_fill(to, (uint32_t)sizeof *to);
}
/* Trains, packs and verifies; the archive appears complete or not at all. */
FB_API fb_status fb_bake(const fb_bake_desc* desc);

#ifdef __cplusplus
}
#endif
#endif
