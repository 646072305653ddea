/** @file
 * FaceBaker archives as objects: everything that a .fbk holds, for measuring, inspecting and exporting. C99; in
 * libfacebaker_bake. facebaker_bake.h, which includes this, has the rules that hold for all of it; for posing use
 * fb_load of facebaker.h.
 */
#ifndef FACEBAKER_FACEBAKER_ARCHIVE_H
#define FACEBAKER_FACEBAKER_ARCHIVE_H

#include <facebaker/facebaker.h>

#ifdef __cplusplus
extern "C" {
#endif

/** An archive read with everything in it, for measuring and inspecting; for posing load it with fb_load. Immutable. */
typedef struct fb_archive fb_archive;

/** Reads the archive at `path`. Files may come from anyone: every size is checked before it is believed. *archive is
 * owned by the caller. Fails as fb_load does. */
FB_API fb_status fb_archive_open(const char* path, fb_archive** archive);
/** The same from memory, which is copied. `name` (null: "memory") stands for the path in reports. */
FB_API fb_status fb_archive_open_memory(const void* bytes, uint64_t size, const char* name, fb_archive** archive);
/** Null is allowed. */
FB_API void fb_archive_close(fb_archive* archive);

/** What an archive holds. Strings and arrays are the archive's; texts it has not are "". */
typedef struct fb_archive_info {
  uint32_t struct_size;
  uint32_t format_version;         /**< major * 1,000 + minor */
  const void* bytes;               /**< of the file; for fb_load_memory */
  uint64_t byte_count;             /**< of bytes */
  const char* name;                /**< of the character */
  const char* recipe;              /**< from the provenance */
  const char* licence;             /**< text */
  const char* certificate;         /**< a JSON object: the errors measured when the face was baked; see FORMAT.md */
  const char* provenance;          /**< a JSON object: how the face was made */
  const char* certificate_summary; /**< its main figures in words: up to four lines, each with its newline */
  uint32_t section_count;          /**< of fb_archive_section_at */
  uint32_t note_count;             /**< of fb_archive_note_at */
  uint32_t proof_poses;            /**< that fb_verify evaluates again */
  uint32_t proof_vertices;         /**< whose positions are kept beside the hashes of all */
  uint32_t vertex_count;           /**< of the mesh */
  uint32_t control_count;          /**< floats in a pose */
  uint32_t feature_count;          /**< of fb_archive_features */
  uint32_t direct_count;           /**< features that are coefficients themselves */
  uint32_t region_count;           /**< of fb_archive_region_at */
  uint32_t coefficient_count;      /**< columns of the basis */
  uint64_t parameter_count;        /**< weights and biases of the networks */
  uint64_t value_count;            /**< numbers of the basis */
  const char* about;               /**< a JSON object about the character, see fb_about */
  const void* thumbnail;           /**< a PNG, see fb_thumbnail; null if there is none */
  uint64_t thumbnail_bytes;        /**< of thumbnail */
} fb_archive_info;

FB_API void fb_archive_info_fill(fb_archive_info* to, uint32_t struct_size);
static inline void fb_archive_info_init(fb_archive_info* to) {
  fb_archive_info_fill(to, (uint32_t)sizeof *to);
}
/** Fills *info. */
FB_API fb_status fb_archive_describe(const fb_archive* archive, fb_archive_info* info);

struct fb_report;

/** What the rights in what an archive says about its character come to on a day. about: of fb_archive_info or fb_about;
 * a host that only poses asks this library, too. Rights are read whatever they are: what is not as TEXTS.md has it is
 * taken for the strictest that it could mean. Where fields disagree the stricter holds. Nothing of the libraries acts
 * on it but fb_bake, which refuses to train where learning is not allowed; what a host does with it is its own. on:
 * "2031-12-31", of UTC; null: today. The document of `report`: {"on", "expired", "last_day", "learning", "ai_training",
 * "ai_generative_training", "data_mining", "suspendable", "binding"[], "unread"[]}; what nothing is said about is
 * missing. Fails with INVALID_ARGUMENT where `on` is no day. Thread-safe. */
FB_API fb_status fb_rights(const char* about, const char* on, struct fb_report** report);

/* How far something is permitted: the stricter is the greater. */
#define FB_PERMISSION_UNSTATED 0    /**< nothing is said */
#define FB_PERMISSION_ALLOWED 1     /**< without a condition */
#define FB_PERMISSION_CONSTRAINED 2 /**< on conditions, which the rights have in words */
#define FB_PERMISSION_NOT_ALLOWED 3 /**< forbidden, or nothing that can be read as more */

/** What binds of rights. Strings are the report's. */
typedef struct fb_rights_result {
  uint32_t struct_size;
  uint32_t stated;                /**< 1: there are rights */
  uint32_t expired;               /**< 1: they have ended */
  int32_t learning;               /**< from the character: FB_PERMISSION_..., the strictest of it and the next two */
  int32_t ai_training;            /**< of models: FB_PERMISSION_..., at least as strict as `learning` is said to be */
  int32_t ai_generative_training; /**< of models that generate, likewise */
  int32_t data_mining;            /**< FB_PERMISSION_... */
  uint32_t suspendable;           /**< 1: the consent can be suspended */
  const char* last_day;           /**< on which they hold, "2031-12-31"; "" where no date is said */
  const char* binding;            /**< in words: a line for each that binds, with its newline; expiry first */
} fb_rights_result;

FB_API void fb_rights_result_fill(fb_rights_result* to, uint32_t struct_size);
static inline void fb_rights_result_init(fb_rights_result* to) {
  fb_rights_result_fill(to, (uint32_t)sizeof *to);
}
/** Refused with INVALID_ARGUMENT for the report of another call. */
FB_API fb_status fb_report_rights(const struct fb_report* report, fb_rights_result* result);

/** A section of an archive. */
typedef struct fb_section {
  uint32_t struct_size;
  uint32_t reserved;
  const char* name;        /**< see FORMAT.md */
  uint64_t stored_bytes;   /**< in the file */
  uint64_t unpacked_bytes; /**< in memory, before the model is made of it */
} fb_section;

FB_API void fb_section_fill(fb_section* to, uint32_t struct_size);
static inline void fb_section_init(fb_section* to) {
  fb_section_fill(to, (uint32_t)sizeof *to);
}
/** Fills *section for index < section_count; its name is the archive's. */
FB_API fb_status fb_archive_section_at(const fb_archive* archive, uint32_t index, fb_section* section);
/** What was odd but harmless, such as an optional section that was skipped; null for index >= note_count. */
FB_API const char* fb_archive_note_at(const fb_archive* archive, uint32_t index);

/** Bytes of the model that each of these poses reads, which is what its speed comes from; controls: poses x
 * control_count, bytes: a number a pose. docs/measuring.md has the rule, which does not depend on the processor. */
FB_API fb_status fb_archive_pose_bytes(const fb_archive* archive, const float* controls, uint64_t poses,
                                       uint64_t* bytes);

/* The networks in floats, for those who evaluate a face by other means. Unstable. */

/** Unstable. The value of every feature in a pose (control_count values, within their ranges): feature_count floats. */
FB_API fb_status fb_archive_features(const fb_archive* archive, const float* controls, float* features);
/** Unstable. Indices of the features that are coefficients, the first direct_count ones. */
FB_API const uint32_t* fb_archive_direct(const fb_archive* archive);

/** Unstable. A region: a network that gives the next layer[last].outputs coefficients, after the direct ones and those
 * of the regions before it, less what it gives at rest. */
typedef struct fb_region {
  uint32_t struct_size;
  uint32_t layer_count;        /**< of fb_archive_layer_at */
  const char* name;            /**< as fb_region_name has it */
  const uint32_t* inputs;      /**< indices of its input features */
  uint32_t input_count;        /**< of inputs */
  uint32_t gate_count;         /**< 0: no gate */
  const uint32_t* gate_inputs; /**< the coefficients are 0 while all but one of these features are 0 */
} fb_region;

FB_API void fb_region_fill(fb_region* to, uint32_t struct_size);
static inline void fb_region_init(fb_region* to) {
  fb_region_fill(to, (uint32_t)sizeof *to);
}
/** Unstable. Fills *region for index < region_count; its pointers are the archive's. */
FB_API fb_status fb_archive_region_at(const fb_archive* archive, uint32_t index, fb_region* region);

/* Activations. */
#define FB_ACTIVATION_LINEAR 0 /**< x */
#define FB_ACTIVATION_RELU 1   /**< max(x, 0) */
#define FB_ACTIVATION_TANH 2   /**< the rational function of EVALUATION.md that is near tanh(x) */
#define FB_ACTIVATION_SILU 3   /**< x times its sigmoid, by that tanh */

/** Unstable. y = activation(W x + bias), plus x with `skip`. */
typedef struct fb_layer {
  uint32_t struct_size;
  uint32_t inputs;    /**< length of x */
  uint32_t outputs;   /**< length of y */
  int32_t activation; /**< FB_ACTIVATION_... */
  uint32_t skip;      /**< 1: x is added; inputs and outputs are as many */
  uint32_t bits;      /**< of a stored weight: 8 or 16 */
} fb_layer;

FB_API void fb_layer_fill(fb_layer* to, uint32_t struct_size);
static inline void fb_layer_init(fb_layer* to) {
  fb_layer_fill(to, (uint32_t)sizeof *to);
}
/** Unstable. Fills *to for a layer of a region, layer < layer_count. */
FB_API fb_status fb_archive_layer_at(const fb_archive* archive, uint32_t region, uint32_t layer, fb_layer* to);
/** Unstable. weights: outputs x inputs floats, a row an output; bias: outputs floats. */
FB_API fb_status fb_archive_layer_values(const fb_archive* archive, uint32_t region, uint32_t layer, float* weights,
                                         float* bias);

#ifdef __cplusplus
}
#endif
#endif
