/** @file
 * FaceBaker faces in other forms: as an ONNX model, and as joints with skin weights. C99; in libfacebaker_bake.
 * facebaker_bake.h, which includes this, has the rules that hold for all of it.
 */
#ifndef FACEBAKER_FACEBAKER_EXPORT_H
#define FACEBAKER_FACEBAKER_EXPORT_H

#include <facebaker/facebaker_archive.h>
#include <facebaker/facebaker_source.h>

#ifdef __cplusplus
extern "C" {
#endif

struct fb_report;

/** Writes a face as an ONNX model of operator set 13: input "controls", float32 [n, controls], which are clamped to
 * their ranges inside; output "positions", float32 [n, vertices, 3]; where the face has channels also "channels",
 * float32 [n, channels]; where it has driven joints also "joints", float32 [n, joints, 3, 4], as fb_batch_desc::joints
 * has them. It computes what fb_evaluate does at level of detail 0, rounding included: positions are its own to some
 * 1e-7 of the diagonal (docs/export.md has figures). The model's properties say which controls, units and licence it
 * has. The file appears complete or not at all. The document of `report`, which may be null: {"file", "nodes",
 * "parameters"}. Fails with LIMIT beyond the 2 GB of an ONNX file, and
 * with IO. Thread-safe. */
FB_API fb_status fb_export_onnx(const fb_archive* archive, const char* path, struct fb_report** report);

/** Joints with skin weights that move a face nearly as it moves; immutable. */
typedef struct fb_decomposition fb_decomposition;

/** What to decompose. */
typedef struct fb_decompose_desc {
  uint32_t struct_size;
  uint32_t threads;          /**< at most 4,096; 0 (default): all */
  const fb_archive* archive; /**< the face, whose rest mesh it is; not kept */
  const float* positions;    /**< poses x 3 x vertices of the face; not kept */
  uint64_t poses;            /**< at least 1; a few hundred are enough */
  uint32_t joints;           /**< at most, 1 to 1,024; joints that no vertex follows are dropped. Default 32 */
  uint32_t reserved;
  fb_callbacks callbacks;
} fb_decompose_desc;

FB_API void fb_decompose_desc_fill(fb_decompose_desc* to, uint32_t struct_size);
static inline void fb_decompose_desc_init(fb_decompose_desc* to) {
  fb_decompose_desc_fill(to, (uint32_t)sizeof *to);
}
/** Finds joints and weights that reproduce the poses as well as so many can, each with one rigid transform a pose:
 * vertices are clustered by common motion, then transforms and weights are fitted in turn (Le, Deng, "Smooth Skinning
 * Decomposition with Rigid Bones", SIGGRAPH Asia 2012, with a term that smooths weights along edges). Deterministic for
 * any number of threads. *decomposition is owned by the caller. Fails with INVALID_ARGUMENT, NOT_FINITE on positions
 * that are not finite, INTERRUPTED. */
FB_API fb_status fb_decompose(const fb_decompose_desc* desc, fb_decomposition** decomposition);
/** Null is allowed. */
FB_API void fb_decomposition_free(fb_decomposition* decomposition);

/** Joints and weights; arrays are the decomposition's. */
typedef struct fb_decomposition_info {
  uint32_t struct_size;
  uint32_t joint_count;   /**< at most fb_decompose_desc::joints */
  uint32_t influences;    /**< of a vertex: 4 */
  uint32_t vertex_count;  /**< of the face */
  const float* centres;   /**< 3 a joint: where it is at rest, unrotated */
  const uint16_t* joints; /**< vertices x influences: joints that a vertex follows, by falling weight */
  const float* weights; /**< vertices x influences, at least 0, with sum 1 for each vertex; those that are 0 are last */
} fb_decomposition_info;

FB_API void fb_decomposition_info_fill(fb_decomposition_info* to, uint32_t struct_size);
static inline void fb_decomposition_info_init(fb_decomposition_info* to) {
  fb_decomposition_info_fill(to, (uint32_t)sizeof *to);
}
/** Fills *info. */
FB_API fb_status fb_decomposition_describe(const fb_decomposition* decomposition, fb_decomposition_info* info);
/** Where the joints have to be so that the skin comes closest to poses (poses x 3 x vertices): poses x joint_count x 12
 * floats in `frames`, each a rotation and an origin, the upper rows of a 4 x 4 matrix, row after row. A vertex at rest
 * at v goes to the sum over its influences of weight * (rotation * (v - centre) + origin). Poses are fitted one by one;
 * the number of threads (0: all) changes nothing. Thread-safe. Fails with INVALID_ARGUMENT on null, NOT_FINITE. */
FB_API fb_status fb_decomposition_fit(const fb_decomposition* decomposition, const float* positions, uint64_t poses,
                                      uint32_t threads, float* frames);

#ifdef __cplusplus
}
#endif
#endif
