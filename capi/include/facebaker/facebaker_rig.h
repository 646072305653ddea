/** @file
 * A rig as FaceBaker sees it: what a plugin (librig_NAME.so) fills and exports, and what a host fills for
 * fb_source_open. C99; a plugin links no library. Statuses are those of facebaker.h.
 *
 * samples/sample_face/plugin.cpp is a complete plugin.
 */
#ifndef FACEBAKER_FACEBAKER_RIG_H
#define FACEBAKER_FACEBAKER_RIG_H

#include <facebaker/facebaker_character.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Version of fb_rig and of what it points to. Changes only when an older plugin could not be used any more: a rig of
 * another version is refused with FB_ERROR_UNSUPPORTED. */
#define FB_RIG_ABI 2

/** A control of a rig. An array of these has its stride in fb_rig, so that it may grow. */
typedef struct fb_rig_control {
  const char* name;  /**< unique, not empty */
  const char* group; /**< the control group ("brows", "mouth"); null or "": none. Sampling combines groups. */
  float minimum;     /**< minimum < maximum, both finite */
  float maximum;     /**< the other end of the range */
  float rest;        /**< value in the rest pose, within the range */
  uint32_t reserved; /**< 0 */
} fb_rig_control;

/** What a control means, beside its name. Null or "": nothing is known. */
typedef struct fb_rig_labels {
  const char* arkit;  /**< name among the face blendshapes of ARKit; no two controls have the same */
  const char* facs;   /**< action unit in the Facial Action Coding System; no two controls have the same */
  const char* unit;   /**< of its values, such as "degrees" */
  const char* mirror; /**< name of the control that does the same on the other side, and names this one */
} fb_rig_labels;

/* Kinds of clips. */
#define FB_CLIP_SHOT 0         /**< animation: consecutive frames */
#define FB_CLIP_EXCITATION 1   /**< one control at a time */
#define FB_CLIP_REGIONAL 2     /**< combinations of the expressions of control groups */
#define FB_CLIP_CALISTHENICS 3 /**< random controls, about a dozen at once */
#define FB_CLIP_DENSE 4        /**< many controls of many groups at once */

/* What a clip may be used for. */
#define FB_SPLIT_ALL (-1)     /**< in fb_eval_desc only: every clip */
#define FB_SPLIT_TRAIN 0      /**< training */
#define FB_SPLIT_VALIDATION 1 /**< choices during training */
#define FB_SPLIT_TEST 2       /**< measuring; never used for training or for any choice */

/** Controls over time. An array of these has a stride beside it, so that it may grow. */
typedef struct fb_rig_clip {
  const char* name;      /**< unique, not empty */
  int32_t kind;          /**< FB_CLIP_... */
  int32_t split;         /**< FB_SPLIT_TRAIN, _VALIDATION or _TEST */
  double fps;            /**< frames a second, > 0 */
  uint32_t frames;       /**< at least 1 */
  uint32_t reserved;     /**< 0 */
  const float* controls; /**< frames x control_count */
} fb_rig_clip;

#define FB_RIG_THREAD_SAFE 1u /**< fb_rig::evaluate may be called from several threads at once */
/** fb_rig::evaluate_skinned is called, whose positions have the motion of the joints in them. A bake takes it out
 * again, so that archives hold positions before skinning. Without this flag, positions of a rig with joints are those.
 */
#define FB_RIG_SKINNED 2u

/** A rig: anything that can say which controls it has, what its rest mesh is, and where the vertices are in a pose. A
 * plugin (librig_NAME.so, which exports fb_rig_open) or a host fills it; begin with fb_rig_init. All pointers are owned
 * by the rig and stay valid and unchanged until destroy. */
typedef struct fb_rig {
  uint32_t struct_size;            /**< sizeof(fb_rig) as the plugin was compiled */
  uint32_t abi;                    /**< FB_RIG_ABI as the plugin was compiled */
  const char* name;                /**< of the character */
  const char* units;               /**< of positions: "cm", "m", ... */
  const char* up_axis;             /**< "y" or "z" */
  uint32_t flags;                  /**< FB_RIG_..., or-ed */
  uint32_t control_count;          /**< at least 1 */
  const fb_rig_control* controls;  /**< control_count of them; their order is the order of every pose */
  uint32_t control_stride;         /**< bytes from a control to the next: sizeof(fb_rig_control) as compiled */
  uint32_t clip_stride;            /**< bytes from a clip to the next: sizeof(fb_rig_clip) as compiled */
  uint32_t vertex_count;           /**< at least 1 */
  uint32_t polygon_count;          /**< 0: a set of points, which have no normals */
  const float* rest_positions;     /**< 3 x vertex_count: what evaluate gives with all controls at rest, to 1e-5 of the
                                      diagonal of their bounding box, which is 1e-25 to 1e25; no coordinate is beyond
                                      1e25 */
  const uint32_t* polygon_sizes;   /**< corners of each polygon, >= 3 */
  const uint32_t* polygon_corners; /**< vertex indices, polygon after polygon */
  uint32_t clip_count;             /**< the rig's own animation; may be 0 */
  uint32_t reserved;               /**< 0 */
  const fb_rig_clip* clips;        /**< clip_count of them, all values within their ranges */
  void* user;                      /**< passed to evaluate and destroy */
  /** Evaluates a block of poses: controls is poses x control_count, positions receives poses x 3 x vertex_count floats,
   * finite, object space, in `units`, none further than 10,000 diagonals from its rest position along an axis. Values
   * of controls are always within their ranges. The same controls give the same positions whenever they are evaluated;
   * a bake evaluates some poses twice and warns where they differ. Returns FB_OK, or an error after writing a sentence
   * into message (message_size bytes, zero-terminated). What it throws, in C++, is an error too: FB_ERROR_RIG. */
  fb_status (*evaluate)(void* user, uint64_t poses, const float* controls, float* positions, char* message,
                        uint32_t message_size);
  /** Frees everything the rig owns; may be null. */
  void (*destroy)(void* user);
  uint32_t uv_count;            /**< texture coordinates; 0, or a struct_size that ends before them: none */
  uint32_t reserved_uv;         /**< 0 */
  const float* uvs;             /**< 2 x uv_count: u and v interleaved, v growing upwards */
  const uint32_t* uv_corners;   /**< for each of polygon_corners its pair of uvs, < uv_count */
  uint32_t preferred_block;     /**< poses that a call of evaluate should have, for a rig that works on several at once,
                                   such as several processes behind one plugin; more than 4,096 are 4,096. Calls have as
                                   many, even if they take seconds; a user can stop only between them. 0, or a shorter
                                   struct: any number will do, and calls of slow rigs take a fifth of a second */
  uint32_t reserved_block;      /**< 0 */
  const char* version;          /**< a text that changes when evaluate gives other positions, because of data beside a
                                   plugin or a server behind it. A plugin's own file is known by its bytes. Null, or a
                                   struct_size that ends before it: none */
  uint32_t mesh_count;          /**< 0, or a struct_size that ends before `sockets`: one mesh, without a name */
  uint32_t mesh_stride;         /**< bytes from a mesh to the next: sizeof(fb_mesh) as compiled */
  const fb_mesh* meshes;        /**< mesh_count of them, with names; they have all vertices and polygons */
  uint32_t material_count;      /**< may be 0 */
  uint32_t material_stride;     /**< bytes from a material to the next: sizeof(fb_material) as compiled */
  const fb_material* materials; /**< material_count of them */
  uint32_t image_count;         /**< may be 0 */
  uint32_t image_stride;        /**< bytes from an image to the next: sizeof(fb_image) as compiled */
  const fb_image* images;       /**< image_count of them */
  uint32_t label_stride;        /**< bytes from one to the next: sizeof(fb_rig_labels) as compiled */
  uint32_t reserved_labels;     /**< 0 */
  const fb_rig_labels* labels;  /**< of each control, control_count of them; null: none */
  uint32_t socket_count;        /**< may be 0 */
  uint32_t socket_stride;       /**< bytes from a socket to the next: sizeof(fb_socket) as compiled */
  const fb_socket* sockets;     /**< socket_count of them */
  const char* about;          /**< a JSON object, see docs/characters.md; null, or a shorter struct: nothing is said */
  uint32_t channel_count;     /**< 0, or a struct_size that ends before `evaluate_all`: none */
  uint32_t channel_stride;    /**< bytes from a channel to the next: sizeof(fb_channel) as compiled */
  const fb_channel* channels; /**< channel_count of them */
  /** Evaluates like evaluate, and is called in its place, where there are channels; evaluate may then be null. channels
   * receives poses x channel_count floats, finite; values outside a channel's range are clamped to it. */
  fb_status (*evaluate_all)(void* user, uint64_t poses, const float* controls, float* positions, float* channels,
                            char* message, uint32_t message_size);
  uint32_t joint_count;        /**< 0, or a struct_size that ends before `evaluate_skinned`: none */
  uint32_t joint_stride;       /**< bytes from a joint to the next: sizeof(fb_joint) as compiled */
  const fb_joint* joints;      /**< joint_count of them */
  uint32_t skin_influences;    /**< of each vertex, at most FB_MOST_INFLUENCES; 0: no skin */
  uint32_t reserved_skin;      /**< 0 */
  const uint16_t* skin_joints; /**< vertex_count x skin_influences indices of joints */
  const float* skin_weights;   /**< of each, 0 or more; those of a vertex sum to 1, to a thousandth, or are all 0, which
                                  then holds for every vertex of its mesh. Where all joints are driven
                                  (`joint_numbers`), they sum to at most 1: what is missing stays where it is */
  /** Evaluates like evaluate_all, and is called in its place, with FB_RIG_SKINNED; the others may then be null.
   * positions and rest_positions are after skinning, at rest with the joints as fb_joint::rest says. joints receives
   * poses x joint_count frames of FB_FRAME_FLOATS floats: where each joint is in the pose, in the space of the
   * positions, not of its parent. channels is null where there are none. Fails the pose where the blend of a vertex
   * cannot be inverted. */
  fb_status (*evaluate_skinned)(void* user, uint64_t poses, const float* controls, float* positions, float* channels,
                                float* joints, char* message, uint32_t message_size);
  const uint32_t* joint_numbers; /**< of each joint, FB_JOINT_... or-ed: how the controls move it within its parent.
                                    Such a *driven* joint becomes a part of the baked face. 0: the joint is moved by a
                                    host, and its motion is taken out, unless it is below a driven one, with
                                    which it then moves. Null, or
                                    a struct_size that ends before it: all are the host's */
} fb_rig;

/** Zeros *rig and sets struct_size, abi and the strides to those of this header. Inline: a plugin links no library. */
static inline void fb_rig_init(fb_rig* rig) {
  memset(rig, 0, sizeof *rig);
  rig->struct_size = (uint32_t)sizeof *rig;
  rig->abi = FB_RIG_ABI;
  rig->control_stride = (uint32_t)sizeof(fb_rig_control);
  rig->clip_stride = (uint32_t)sizeof(fb_rig_clip);
  rig->label_stride = (uint32_t)sizeof(fb_rig_labels);
  rig->mesh_stride = (uint32_t)sizeof(fb_mesh);
  rig->material_stride = (uint32_t)sizeof(fb_material);
  rig->image_stride = (uint32_t)sizeof(fb_image);
  rig->socket_stride = (uint32_t)sizeof(fb_socket);
  rig->channel_stride = (uint32_t)sizeof(fb_channel);
  rig->joint_stride = (uint32_t)sizeof(fb_joint);
}

/** Fills *rig: the one symbol that a plugin exports, under the name fb_rig_open. `path` is the plugin's own file, so
 * that data beside it can be found. *rig comes zeroed, with room for a struct up to four times as long. On failure
 * writes a sentence into message (message_size bytes, zero-terminated) and leaves nothing to destroy. */
typedef fb_status (*fb_rig_open_function)(const char* path, fb_rig* rig, char* message, uint32_t message_size);
/** The name of that symbol. */
#define FB_RIG_OPEN_SYMBOL "fb_rig_open"

#ifdef __cplusplus
}
#endif
#endif
