/** @file
 * What a character has besides positions: its meshes, materials, images, sockets, channels, joints and skin, and levels
 * of detail, and what is said about it. C99; statuses and fb_model are those of facebaker.h, functions are in
 * libfacebaker. The same structs describe a loaded face here and a rig in facebaker_rig.h.
 *
 * All functions are thread-safe. Structs, strings and arrays that are filled point into the model and live as long as
 * it does. A count of a null model is 0.
 */
#ifndef FACEBAKER_FACEBAKER_CHARACTER_H
#define FACEBAKER_FACEBAKER_CHARACTER_H

#include <facebaker/facebaker.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Meshes ------------------------------------------------------------------------------------------------------ */

#define FB_NO_MATERIAL 0xffffffffu /**< in fb_material_run: these polygons have none */

/** Consecutive polygons of a mesh that have one material. Never grows. */
typedef struct fb_material_run {
  uint32_t polygon_count; /**< at least 1 */
  uint32_t material;      /**< index of a material, or FB_NO_MATERIAL */
} fb_material_run;

/** One of the meshes of a character. All share one pool of vertices, polygons and polygon corners, which fb_evaluate
 * poses as a whole: those of a mesh follow those of the mesh before it, and its polygons have vertices of its own only.
 * The first_ fields and the number of corners are filled by fb_mesh_at, and not read from a rig. */
typedef struct fb_mesh {
  uint32_t struct_size;
  uint32_t run_count;          /**< of runs; 0 in a rig: no materials */
  const char* name;            /**< unique; "" for the one mesh of a face whose source names none */
  const fb_material_run* runs; /**< they have all polygons of the mesh, in order */
  uint32_t vertex_count;       /**< at least 1 */
  uint32_t polygon_count;      /**< may be 0 */
  uint32_t first_vertex;       /**< index of its first vertex, as in positions */
  uint32_t first_polygon;      /**< index of its first polygon, as in fb_polygon_sizes */
  uint32_t first_corner;       /**< index of its first corner, as in fb_polygon_corners and fb_uv_corners */
  uint32_t corner_count;       /**< corners of all its polygons */
} fb_mesh;

FB_API void fb_mesh_fill(fb_mesh* to, uint32_t struct_size);
static inline void fb_mesh_init(fb_mesh* to) {
  fb_mesh_fill(to, (uint32_t)sizeof *to);
}
/** Meshes of the face, at least 1. */
FB_API uint32_t fb_mesh_count(const fb_model* model);
/** Fills *mesh, up to its struct_size, for index < fb_mesh_count. */
FB_API fb_status fb_mesh_at(const fb_model* model, uint32_t index, fb_mesh* mesh);
/** Finds a mesh by its exact name; FB_ERROR_NOT_FOUND names those there are. */
FB_API fb_status fb_find_mesh(const fb_model* model, const char* name, uint32_t* index);

/* ---- Materials --------------------------------------------------------------------------------------------------- */

/* What a texture is to a material, as in glTF 2.0. */
#define FB_TEXTURE_BASE_COLOUR 0        /**< sRGB colour and alpha */
#define FB_TEXTURE_METALLIC_ROUGHNESS 1 /**< roughness in green, metallic in blue */
#define FB_TEXTURE_NORMAL 2             /**< tangent space */
#define FB_TEXTURE_OCCLUSION 3          /**< in red */
#define FB_TEXTURE_EMISSIVE 4           /**< sRGB colour */

/* How a texture goes on beyond its borders. */
#define FB_WRAP_REPEAT 0 /**< the texture begins again */
#define FB_WRAP_CLAMP 1  /**< to the edge */
#define FB_WRAP_MIRROR 2 /**< the texture goes back */

/* What alpha means. */
#define FB_ALPHA_OPAQUE 0 /**< nothing */
#define FB_ALPHA_MASK 1   /**< transparent below alpha_cutoff */
#define FB_ALPHA_BLEND 2  /**< how much of the surface covers what is behind it */

/** A texture of a material, mapped by the texture coordinates of the mesh. Never grows. */
typedef struct fb_texture {
  uint32_t slot;   /**< FB_TEXTURE_...; at most one texture a slot */
  uint32_t image;  /**< index of an image */
  uint32_t wrap_u; /**< FB_WRAP_... */
  uint32_t wrap_v; /**< FB_WRAP_... */
  float scale;     /**< of a normal texture; strength of an occlusion texture; 1 in other slots */
} fb_texture;

/** A material, with the meaning that glTF 2.0 gives to these fields. */
typedef struct fb_material {
  uint32_t struct_size;
  uint32_t alpha_mode;        /**< FB_ALPHA_... */
  const char* name;           /**< may be "" */
  float base_colour[4];       /**< linear red, green and blue, alpha */
  float metallic;             /**< 0 to 1 */
  float roughness;            /**< 0 to 1 */
  float emissive[3];          /**< linear red, green and blue */
  float alpha_cutoff;         /**< of FB_ALPHA_MASK */
  uint32_t double_sided;      /**< 0 or 1 */
  uint32_t texture_count;     /**< of textures */
  const fb_texture* textures; /**< null if there are none */
} fb_material;

/** Defaults are those of glTF 2.0: white, metallic and roughness 1, opaque. */
FB_API void fb_material_fill(fb_material* to, uint32_t struct_size);
static inline void fb_material_init(fb_material* to) {
  fb_material_fill(to, (uint32_t)sizeof *to);
}
/** Materials of the face; may be 0. */
FB_API uint32_t fb_material_count(const fb_model* model);
/** Fills *material, up to its struct_size, for index < fb_material_count. */
FB_API fb_status fb_material_at(const fb_model* model, uint32_t index, fb_material* material);

/** A picture file as it is, such as a texture. */
typedef struct fb_image {
  uint32_t struct_size;
  uint32_t reserved;
  const char* name;       /**< may be "" */
  const char* media_type; /**< "image/png", "image/jpeg", "image/ktx2", ... */
  const void* bytes;      /**< the file's bytes */
  uint64_t byte_count;    /**< of bytes; below 2^32 */
} fb_image;

FB_API void fb_image_fill(fb_image* to, uint32_t struct_size);
static inline void fb_image_init(fb_image* to) {
  fb_image_fill(to, (uint32_t)sizeof *to);
}
/** Images of the face; may be 0. */
FB_API uint32_t fb_image_count(const fb_model* model);
/** Fills *image, up to its struct_size, for index < fb_image_count. */
FB_API fb_status fb_image_at(const fb_model* model, uint32_t index, fb_image* image);

/* ---- Sockets ----------------------------------------------------------------------------------------------------- */

/** Floats of a frame: the upper three rows of a 4 x 4 matrix, row after row. Its last column is the origin. */
#define FB_FRAME_FLOATS 12

/** A named frame that follows the surface, for what hangs on it: glasses, hair, an earring, the centre of an eye. In a
 * pose it moves with its vertices as a rigid body does: by the rotation and translation that fit their posed positions
 * best, by weighted squared distances. fb_batch_desc::sockets gives the frames of poses. */
typedef struct fb_socket {
  uint32_t struct_size;
  uint32_t vertex_count;        /**< at least 3 */
  const char* name;             /**< unique, not empty */
  const uint32_t* vertices;     /**< of one mesh, and not on one line: a frame could turn around it */
  const float* weights;         /**< of each vertex, above 0; null in a rig: all 1 */
  float frame[FB_FRAME_FLOATS]; /**< at rest; all 0 in a rig: the axes, at the weighted centre of the vertices */
} fb_socket;

FB_API void fb_socket_fill(fb_socket* to, uint32_t struct_size);
static inline void fb_socket_init(fb_socket* to) {
  fb_socket_fill(to, (uint32_t)sizeof *to);
}
/** Sockets of the face; may be 0. */
FB_API uint32_t fb_socket_count(const fb_model* model);
/** Fills *socket, up to its struct_size, for index < fb_socket_count. */
FB_API fb_status fb_socket_at(const fb_model* model, uint32_t index, fb_socket* socket);
/** Finds a socket by its exact name; FB_ERROR_NOT_FOUND names those there are. */
FB_API fb_status fb_find_socket(const fb_model* model, const char* name, uint32_t* index);

/* ---- Channels ---------------------------------------------------------------------------------------------------- */

/** A named number that a rig gives with each pose, beside positions: the weight of a wrinkle map, the turn of an eye.
 * It depends on the controls as positions do, and is baked and evaluated like them. fb_batch_desc::channels gives the
 * values of poses, which are within the range. */
typedef struct fb_channel {
  uint32_t struct_size;
  uint32_t reserved;
  const char* name; /**< unique, not empty */
  const char* unit; /**< of its values, such as "degrees"; may be "", in a rig null */
  float minimum;    /**< minimum < maximum, both finite */
  float maximum;    /**< the other end of the range; errors are told over its length */
  float rest;       /**< value in the rest pose, within the range */
} fb_channel;

FB_API void fb_channel_fill(fb_channel* to, uint32_t struct_size);
static inline void fb_channel_init(fb_channel* to) {
  fb_channel_fill(to, (uint32_t)sizeof *to);
}
/** Channels of the face; may be 0. */
FB_API uint32_t fb_channel_count(const fb_model* model);
/** Fills *channel, up to its struct_size, for index < fb_channel_count. */
FB_API fb_status fb_channel_at(const fb_model* model, uint32_t index, fb_channel* channel);
/** Finds a channel by its exact name; FB_ERROR_NOT_FOUND names those there are. */
FB_API fb_status fb_find_channel(const fb_model* model, const char* name, uint32_t* index);

/* ---- Exact poses ------------------------------------------------------------------------------------------------- */

/** A pose that comes out as the rig gave it, within rounding: what the basis gives is corrected there, with a weight
 * that fades with the distance of the controls, to 0 at rest and at every other such pose. fb_evaluate and
 * fb_evaluate_batch do so by themselves, whatever regions are left out; coefficients (fb_evaluate_coefficients) are
 * without it. */
typedef struct fb_exact_pose {
  uint32_t struct_size;
  uint32_t control_count; /**< of controls: fb_control_count */
  const char* name;       /**< unique, not empty: "CLIP:FRAME" */
  const float* controls;  /**< the values of the pose, each within its range */
} fb_exact_pose;

FB_API void fb_exact_pose_fill(fb_exact_pose* to, uint32_t struct_size);
static inline void fb_exact_pose_init(fb_exact_pose* to) {
  fb_exact_pose_fill(to, (uint32_t)sizeof *to);
}
/** Exact poses of the face; may be 0. */
FB_API uint32_t fb_exact_pose_count(const fb_model* model);
/** Fills *pose, up to its struct_size, for index < fb_exact_pose_count. */
FB_API fb_status fb_exact_pose_at(const fb_model* model, uint32_t index, fb_exact_pose* pose);
/** Writes by how much the exact pose at `index` corrects the rows of a row block (fb_row_block_at) at a weight of 1,
 * fb_row_block::row_count floats, for hosts that pose by themselves (fb_evaluate_quantised). *corrects: 1, or 0 where
 * it leaves the row block alone, and then every correction is 0. Either may be null. Fails with
 * FB_ERROR_INVALID_ARGUMENT for an index of none. Thread-safe. */
FB_API fb_status fb_exact_corrections(const fb_model* model, uint32_t index, uint32_t row_block, float* corrections,
                                      uint32_t* corrects);
/* ---- Joints and skin --------------------------------------------------------------------------------------------- */

#define FB_NO_JOINT 0xffffffffu /**< in fb_joint::parent: it has none */
/** Influences that a vertex has at most. */
#define FB_MOST_INFLUENCES 32u

/** A joint of the skeleton that carries the face: of a neck, a head, an eye. Positions are those before skinning, in
 * the bind pose: a host poses the face first, and then moves each vertex by the sum over its influences of weight *
 * (where the joint is) * inverse_bind. Sockets, bounds and normals are before skinning, too. Joints come after their
 * parents. */
typedef struct fb_joint {
  uint32_t struct_size;
  uint32_t parent;                     /**< index of its parent, less than its own, or FB_NO_JOINT */
  const char* name;                    /**< unique, not empty */
  float rest[FB_FRAME_FLOATS];         /**< at rest, as a frame in its parent; of a joint without one, in the space that
                                          the skin takes vertices to */
  float inverse_bind[FB_FRAME_FLOATS]; /**< from the space of positions to the joint's; all 0 in a rig: the inverse of
                                          where the joint is at rest */
} fb_joint;

/** No parent, at its origin, with an inverse bind matrix of 0. */
FB_API void fb_joint_fill(fb_joint* to, uint32_t struct_size);
static inline void fb_joint_init(fb_joint* to) {
  fb_joint_fill(to, (uint32_t)sizeof *to);
}
/** Joints of the face; may be 0. */
FB_API uint32_t fb_joint_count(const fb_model* model);
/** Fills *joint, up to its struct_size, for index < fb_joint_count. */
FB_API fb_status fb_joint_at(const fb_model* model, uint32_t index, fb_joint* joint);
/** Finds a joint by its exact name; FB_ERROR_NOT_FOUND names those there are. */
FB_API fb_status fb_find_joint(const fb_model* model, const char* name, uint32_t* index);

/** Influences of each vertex in the two arrays below, at most FB_MOST_INFLUENCES; 0 if the face has no skin. */
FB_API uint32_t fb_skin_influences(const fb_model* model);
/** The joints that each vertex follows: fb_vertex_count x fb_skin_influences indices, in the source's vertex order.
 * Null without a skin. */
FB_API const uint16_t* fb_skin_joints(const fb_model* model);
/** The weight of each, 0 to 1. Those of a vertex sum to 1, to a thousandth, and those that are 0 come last; or all are
 * 0, for every vertex of a mesh that follows no joint. Null without a skin. */
FB_API const float* fb_skin_weights(const fb_model* model);

/* ---- Driven joints ----------------------------------------------------------------------------------------------- */

/* How a driven joint moves, along the axes of its own frame at rest. What a rig moves beyond what it declares is left
 * to displacements of vertices. A rig declares no pivots, which frames of a pose do not tell from moves: a bake finds
 * them. */
#define FB_JOINT_ROTATE_X 1u   /**< turns about its x axis */
#define FB_JOINT_ROTATE_Y 2u   /**< turns about its y axis */
#define FB_JOINT_ROTATE_Z 4u   /**< turns about its z axis */
#define FB_JOINT_ROTATE 7u     /**< all three; by less than a half turn */
#define FB_JOINT_MOVE_X 8u     /**< moves along its x axis */
#define FB_JOINT_MOVE_Y 16u    /**< moves along its y axis */
#define FB_JOINT_MOVE_Z 32u    /**< moves along its z axis */
#define FB_JOINT_MOVE 56u      /**< all three */
#define FB_JOINT_SCALE_X 64u   /**< is longer or shorter along its x axis */
#define FB_JOINT_SCALE_Y 128u  /**< is longer or shorter along its y axis */
#define FB_JOINT_SCALE_Z 256u  /**< is longer or shorter along its z axis */
#define FB_JOINT_SCALE 448u    /**< all three */
#define FB_JOINT_PIVOT_X 512u  /**< turns about a point that moves along its x axis */
#define FB_JOINT_PIVOT_Y 1024u /**< turns about a point that moves along its y axis */
#define FB_JOINT_PIVOT_Z 2048u /**< turns about a point that moves along its z axis */
#define FB_JOINT_PIVOT 3584u   /**< all three; from its origin */

/** A joint that the controls move: of a jaw, a tongue, an eye. It is a part of the face, inside of the skeleton above:
 * positions, normals, tangents, bounds and sockets of a pose have it in them, unless fb_batch_desc asks for what is
 * before it. Where it is in a pose, fb_batch_desc::joints gives. Joints come after their parents. */
typedef struct fb_driven_joint {
  uint32_t struct_size;
  uint32_t parent;             /**< index of its parent among these, less than its own, or FB_NO_JOINT */
  const char* name;            /**< unique, not empty */
  uint32_t numbers;            /**< FB_JOINT_... or-ed: how controls move it within its parent; 0: with that only */
  uint32_t outer_rotations;    /**< how many rotations it turns by beside its first, each after those before it */
  float rest[FB_FRAME_FLOATS]; /**< its frame at rest, in the space of positions, not of its parent */
} fb_driven_joint;

/** No parent, at the origin, without numbers and outer rotations. */
FB_API void fb_driven_joint_fill(fb_driven_joint* to, uint32_t struct_size);
static inline void fb_driven_joint_init(fb_driven_joint* to) {
  fb_driven_joint_fill(to, (uint32_t)sizeof *to);
}
/** Driven joints of the face; may be 0. */
FB_API uint32_t fb_driven_joint_count(const fb_model* model);
/** Fills *joint, up to its struct_size, for index < fb_driven_joint_count. */
FB_API fb_status fb_driven_joint_at(const fb_model* model, uint32_t index, fb_driven_joint* joint);
/** Finds a driven joint by its exact name; FB_ERROR_NOT_FOUND names those there are. */
FB_API fb_status fb_find_driven_joint(const fb_model* model, const char* name, uint32_t* index);

/** Influences of each vertex in the two arrays below, at most FB_MOST_INFLUENCES; 0 if the face has no driven joints.
 */
FB_API uint32_t fb_driven_influences(const fb_model* model);
/** The driven joints that each vertex follows: fb_vertex_count x fb_driven_influences indices, in the source's vertex
 * order. Null without driven joints. */
FB_API const uint16_t* fb_driven_skin_joints(const fb_model* model);
/** The weight of each, 0 to 1. Those of a vertex sum to at most 1: what is missing stays with what does not move. Those
 * that are 0 come last. A host that skins by itself takes a vertex from where it is before joints move it, at p, to p +
 * the sum of weight * (frame * (inverse of rest) * p - p). Null without driven joints. */
FB_API const float* fb_driven_skin_weights(const fb_model* model);

/* ---- Levels of detail -------------------------------------------------------------------------------------------- */

/** A level of detail: the character at fewer vertices and with fewer coefficients. Level 0 is the whole. The vertices
 * of a level are some of the level before it: the first vertex_count in baked order (fb_vertex_order).
 * fb_batch_desc::lod chooses the level that is posed; the certificate (fb_archive, `facebaker inspect`) has the errors
 * of each. */
typedef struct fb_level {
  uint32_t struct_size;
  uint32_t vertex_count;           /**< the first so many in baked order */
  uint32_t polygon_count;          /**< of polygon_sizes */
  uint32_t corner_count;           /**< of polygon_corners and uv_corners */
  const uint32_t* polygon_sizes;   /**< corners of each polygon, >= 3; may be null where there are no polygons */
  const uint32_t* polygon_corners; /**< vertex indices below fb_vertex_count, in the source's order, of this level's
                                      vertices only; may be null likewise */
  const uint32_t* uv_corners; /**< for each corner the index of its pair in fb_uvs; null without texture coordinates */
  const fb_mesh* meshes;      /**< fb_mesh_count of them: polygons, corners and runs are those of the level;
                                 names and vertices are those of fb_mesh_at, not all of which the level has */
  uint32_t coefficient_count; /**< that move its vertices; fb_coefficient_count at level 0 */
  uint32_t reserved;          /**< 0 */
} fb_level;

FB_API void fb_level_fill(fb_level* to, uint32_t struct_size);
static inline void fb_level_init(fb_level* to) {
  fb_level_fill(to, (uint32_t)sizeof *to);
}
/** Levels of detail of the face with level 0, at least 1. */
FB_API uint32_t fb_level_count(const fb_model* model);
/** Fills *level, up to its struct_size, for index < fb_level_count. */
FB_API fb_status fb_level_at(const fb_model* model, uint32_t index, fb_level* level);

/* ---- About the character ----------------------------------------------------------------------------------------- */

/** Bytes that fb_about has at most, without the zero at its end. */
#define FB_ABOUT_BYTES 65536u
/** Bytes that fb_thumbnail has at most. */
#define FB_THUMBNAIL_BYTES 65536u

/** A JSON object that says whose the character is and what may be done with it: author, rig, rights, ... FORMAT.md has
 * its fields. UTF-8; whether it is JSON is not checked. "" if the archive says nothing. */
FB_API const char* fb_about(const fb_model* model);
/** A picture of the character, a square PNG file of *byte_count bytes, which nothing here decodes; null, and 0 bytes,
 * if there is none. */
FB_API const void* fb_thumbnail(const fb_model* model, uint64_t* byte_count);

#ifdef __cplusplus
}
#endif
#endif
