/* A small nonlinear rig for tests: a 7 x 7 sheet of quads, a stray vertex and a triangle that uses it.
 * Region "brow" has a two-sided twist and a control whose rest value is not its minimum; region "mouth" opens by a
 * rotation, and opening and pressing together meet in a corrective. Two short shots, one of them for tests. */
#include <facebaker/facebaker_rig.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { side = 7, vertices = side * side + 1, quads = (side - 1) * (side - 1), polygons = quads + 1, controls = 6 };
enum { shot_frames = 12, shots = 2 };

typedef struct toy {
  float rest[3 * vertices];
  uint32_t sizes[polygons];
  uint32_t corners[4 * quads + 3];
  float shot_controls[shots][shot_frames * controls];
  fb_rig_clip clips[shots];
} toy;

static const fb_rig_control toy_controls[controls] = {
    {"browRaise", "brow", 0.0f, 1.0f, 0.0f, 0}, {"browTwist", "brow", -1.0f, 1.0f, 0.0f, 0},
    {"browLift", "brow", 0.0f, 2.0f, 0.5f, 0},  {"jawOpen", "mouth", 0.0f, 1.0f, 0.0f, 0},
    {"lipPress", "mouth", 0.0f, 1.0f, 0.0f, 0}, {"mouthWide", "mouth", 0.0f, 1.0f, 0.0f, 0},
};

static void pose_vertex(const float* c, int row, int column, float* out) {
  const float u = (float)column / (side - 1) * 2 - 1, v = (float)row / (side - 1) * 2 - 1;
  const float brow = v > 0 ? v * v : 0, mouth = v < 0 ? v * v : 0;
  float x = 5 * u, y = 6 * v, z = 2 - u * u - v * v;
  /* brow: a bulge that grows faster the further it is raised, and a twist about the vertical */
  y += brow * (0.8f * c[0] + 0.4f * c[0] * c[0] + 0.3f * c[2]);
  const float twist = 0.4f * brow * c[1];
  const float tx = x * cosf(twist) + z * sinf(twist), tz = z * cosf(twist) - x * sinf(twist);
  /* mouth: the jaw turns about an axis behind the sheet, lips press inwards, most of all while the jaw is open */
  const float open = 0.6f * mouth * c[3], reach = tz + 4;
  const float both = c[3] < c[4] ? c[3] : c[4];
  out[0] = tx * (1 + 0.2f * mouth * c[5]);
  out[1] = y * cosf(open) - reach * sinf(open);
  out[2] = reach * cosf(open) + y * sinf(open) - 4 - mouth * (0.3f * c[4] + 0.5f * both);
}

static fb_status toy_evaluate(void* user, uint64_t poses, const float* values, float* positions, char* message,
                              uint32_t message_size) {
  (void)user;
  (void)message;
  (void)message_size;
  for (uint64_t p = 0; p < poses; ++p, values += controls) {
    for (int i = 0; i < side * side; ++i, positions += 3) pose_vertex(values, i / side, i % side, positions);
    positions[0] = 0, positions[1] = -8 - values[3], positions[2] = 1; /* the stray vertex follows the jaw */
    positions += 3;
  }
  return FB_OK;
}

static void fill_mesh(toy* t) {
  uint32_t* corner = t->corners;
  for (int p = 0; p < quads; ++p) {
    const uint32_t first = (uint32_t)(p / (side - 1) * side + p % (side - 1));
    const uint32_t quad[4] = {first, first + 1, first + side + 1, first + side};
    memcpy(corner, quad, sizeof quad);
    corner += 4;
    t->sizes[p] = 4;
  }
  corner[0] = 3, corner[1] = 2, corner[2] = side * side;
  t->sizes[quads] = 3;
  float rest[controls];
  for (int c = 0; c < controls; ++c) rest[c] = toy_controls[c].rest;
  toy_evaluate(NULL, 1, rest, t->rest, NULL, 0);
}

static void fill_shots(toy* t) {
  static const char* const names[shots] = {"talk", "frown"};
  for (int s = 0; s < shots; ++s) {
    for (int f = 0; f < shot_frames; ++f)
      for (int c = 0; c < controls; ++c) {
        const fb_rig_control* control = toy_controls + c;
        const float wave = 0.5f + 0.5f * sinf(0.5f * (float)f + 1.3f * (float)c + 2.0f * (float)s);
        t->shot_controls[s][f * controls + c] = control->minimum + (control->maximum - control->minimum) * wave;
      }
    const fb_rig_clip clip = {names[s], FB_CLIP_SHOT,       s == 0 ? FB_SPLIT_TRAIN : FB_SPLIT_TEST, 24.0, shot_frames,
                              0,        t->shot_controls[s]};
    t->clips[s] = clip;
  }
}

FB_API fb_status fb_rig_open(const char* path, fb_rig* rig, char* message, uint32_t message_size);

FB_API fb_status fb_rig_open(const char* path, fb_rig* rig, char* message, uint32_t message_size) {
  (void)path;
  toy* t = calloc(1, sizeof *t);
  if (!t) {
    strncpy(message, "no memory for the toy rig", message_size);
    return FB_ERROR_OUT_OF_MEMORY;
  }
  fill_mesh(t);
  fill_shots(t);
  fb_rig_init(rig);
  rig->name = "toy";
  rig->units = "cm";
  rig->up_axis = "y";
  rig->flags = FB_RIG_THREAD_SAFE;
  rig->control_count = controls;
  rig->controls = toy_controls;
  rig->vertex_count = vertices;
  rig->polygon_count = polygons;
  rig->rest_positions = t->rest;
  rig->polygon_sizes = t->sizes;
  rig->polygon_corners = t->corners;
  rig->clip_count = shots;
  rig->clips = t->clips;
  rig->user = t;
  rig->evaluate = toy_evaluate;
  rig->destroy = free;
  return FB_OK;
}
