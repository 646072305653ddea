/* A rig of 64 vertices whose controls jump, take few values, oscillate, or are smooth: an 8 x 8 sheet of quads. Every
 * control moves a bump of the sheet of its own by up to a twelfth of the diagonal; bumps overlap. It has no clips. */
#include <facebaker/facebaker_rig.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { side = 8, vertices = side * side, polygons = (side - 1) * (side - 1), controls = 13 };

typedef struct steps {
  float rest[3 * vertices];
  uint32_t sizes[polygons];
  uint32_t corners[4 * polygons];
} steps;

static const fb_rig_control steps_controls[controls] = {
    {"stepHalf", "step", 0.0f, 1.0f, 0.0f, 0},        /* one jump, on a value that sampling meets */
    {"stepBoth", "step", -1.0f, 1.0f, 0.0f, 0},       /* a jump on either side of rest */
    {"stepOnSlope", "step", 0.0f, 2.0f, 0.5f, 0},     /* a jump on a straight line */
    {"stepAtRest", "step", 0.0f, 1.0f, 0.0f, 0},      /* jumps as soon as it leaves rest */
    {"floorFive", "integer", 0.0f, 5.0f, 0.0f, 0},    /* rounded down to whole numbers */
    {"floorEighths", "integer", 0.0f, 1.0f, 0.0f, 0}, /* jumps at all eighths of the range, and nowhere else */
    {"kind", "enum", 0.0f, 3.0f, 0.0f, 0},            /* rounded; each value has a shape of its own */
    {"wave", "wave", 0.0f, 1.0f, 0.0f, 0},            /* sin(40 c) */
    {"bulge", "smooth", 0.0f, 1.0f, 0.0f, 0},         /* grows with the square */
    {"lift", "smooth", -1.0f, 1.0f, 0.0f, 0},         /* straight */
    {"turn", "smooth", -1.0f, 1.0f, 0.0f, 0},         /* a rotation */
    {"mode", "switch", 0.0f, 1.0f, 0.0f, 0},          /* from one half on, turns what "amount" does */
    {"amount", "switch", 0.0f, 1.0f, 0.0f, 0},
};

/* Where control c moves the vertex at (u, v), each from -1 to 1: 1 at the centre of its bump. */
static float bump(int c, float u, float v) {
  const float du = u - ((float)(c % 4) / 1.5f - 1), dv = v - ((float)(c / 4) / 1.5f - 1);
  const float near = 1 - (du * du + dv * dv);
  return near > 0 ? near * near : 0;
}

static void pose_vertex(const float* c, int row, int column, float* out) {
  const float u = (float)column / (side - 1) * 2 - 1, v = (float)row / (side - 1) * 2 - 1;
  float x = 5 * u, y = 6 * v, z = 2 - u * u - v * v;
  z += 1.2f * bump(0, u, v) * (c[0] >= 0.5f);
  y += 1.2f * bump(1, u, v) * (float)((c[1] > 0.137f) - (c[1] < -0.61f));
  x += bump(2, u, v) * (0.5f * (c[2] - 0.5f) + 0.8f * (c[2] > 1.2345f) - 0.4f * (c[2] < 0.21f));
  z += 0.8f * bump(3, u, v) * (c[3] > 0);
  y += 0.24f * bump(4, u, v) * floorf(c[4]);
  x -= 1.2f * bump(5, u, v) * floorf(8 * c[5]) / 8;
  const int kind = (int)(c[6] + 0.5f);
  if (kind == 1) z += 1.1f * bump(6, u, v);
  if (kind == 2) x += 0.9f * bump(6, v, u);
  if (kind == 3) y -= 0.7f * bump(6, u, -v);
  z += 1.1f * bump(7, u, v) * sinf(40 * c[7]);
  z += 1.2f * bump(8, u, v) * c[8] * c[8];
  y += bump(9, u, v) * c[9];
  const float angle = 0.4f * bump(10, u, v) * c[10], turned = x * cosf(angle) + z * sinf(angle);
  z = z * cosf(angle) - x * sinf(angle);
  x = turned;
  if (c[11] >= 0.5f)
    x += 1.1f * bump(12, u, v) * c[12];
  else
    z += 1.1f * bump(12, u, v) * c[12];
  out[0] = x, out[1] = y, out[2] = z;
}

static fb_status steps_evaluate(void* user, uint64_t poses, const float* values, float* positions, char* message,
                                uint32_t message_size) {
  (void)user;
  (void)message;
  (void)message_size;
  for (uint64_t p = 0; p < poses; ++p, values += controls)
    for (int i = 0; i < vertices; ++i, positions += 3) pose_vertex(values, i / side, i % side, positions);
  return FB_OK;
}

static void fill_mesh(steps* s) {
  uint32_t* corner = s->corners;
  for (int p = 0; p < polygons; ++p, corner += 4) {
    const uint32_t first = (uint32_t)(p / (side - 1) * side + p % (side - 1));
    corner[0] = first, corner[1] = first + 1, corner[2] = first + side + 1, corner[3] = first + side;
    s->sizes[p] = 4;
  }
  float rest[controls];
  for (int c = 0; c < controls; ++c) rest[c] = steps_controls[c].rest;
  steps_evaluate(NULL, 1, rest, s->rest, NULL, 0);
}

FB_API fb_status fb_rig_open(const char* path, fb_rig* rig, char* message, uint32_t message_size);

FB_API fb_status fb_rig_open(const char* path, fb_rig* rig, char* message, uint32_t message_size) {
  (void)path;
  steps* s = calloc(1, sizeof *s);
  if (!s) {
    strncpy(message, "no memory for the rig of steps", message_size);
    return FB_ERROR_OUT_OF_MEMORY;
  }
  fill_mesh(s);
  fb_rig_init(rig);
  rig->name = "steps";
  rig->units = "cm";
  rig->up_axis = "y";
  rig->flags = FB_RIG_THREAD_SAFE;
  rig->control_count = controls;
  rig->controls = steps_controls;
  rig->vertex_count = vertices;
  rig->polygon_count = polygons;
  rig->rest_positions = s->rest;
  rig->polygon_sizes = s->sizes;
  rig->polygon_corners = s->corners;
  rig->user = s;
  rig->evaluate = steps_evaluate;
  rig->destroy = free;
  return FB_OK;
}
