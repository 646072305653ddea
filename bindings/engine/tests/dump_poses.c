/* Poses archives by the C interface and writes what comes out, for the tests of bindings to compare with:
 *
 *     dump_poses FACE.fbk OUT.poses
 *
 * OUT: seven uint32 (poses, controls, vertices, socket floats, channels, 1 with tangents, floats of driven joints),
 * then for each pose as floats its controls, positions, normals, tangents, sockets, channels and frames of driven
 * joints. Poses are random, from a fixed seed; the first is at rest. */
#include <facebaker/facebaker_character.h>
#include <stdio.h>
#include <stdlib.h>

enum { POSES = 8 };

static uint64_t state = 1;

static float next_random(void) {
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (float)(uint32_t)(state >> 40) / 16777216.0f;
}

static float* floats(uint64_t count) {
  float* made = calloc(count + 1, sizeof(float));
  if (!made) exit(2);
  return made;
}

static int check(fb_status status) {
  if (status) fprintf(stderr, "dump_poses: %s\n", fb_last_error());
  return status != FB_OK;
}

static int dump(const fb_model* face, fb_scratch* scratch, FILE* file) {
  const uint32_t controls = fb_control_count(face), vertices = fb_vertex_count(face), channels = fb_channel_count(face);
  const uint32_t sockets = FB_FRAME_FLOATS * fb_socket_count(face), tangents = fb_tangent_signs(face) ? 1 : 0;
  const uint32_t joints = FB_FRAME_FLOATS * fb_driven_joint_count(face);
  const uint32_t header[7] = {POSES, controls, vertices, sockets, channels, tangents, joints};
  float* pose = floats(controls);
  float* out = floats(9u * (uint64_t)vertices + sockets + channels + joints);
  fwrite(header, sizeof header, 1, file);
  for (uint32_t p = 0; p < POSES; ++p) {
    for (uint32_t c = 0; c < controls; ++c) {
      fb_control control;
      fb_control_init(&control);
      if (check(fb_control_at(face, c, &control))) return 1;
      const float at = next_random();
      pose[c] = p == 0 ? control.rest : control.minimum + at * (control.maximum - control.minimum) * 1.1f;
    }
    fb_batch_desc desc;
    fb_batch_desc_init(&desc);
    desc.poses = 1, desc.controls = pose, desc.control_floats = controls;
    desc.positions = out, desc.position_floats = 3u * (uint64_t)vertices;
    float* next = out + desc.position_floats;
    desc.normals = next, desc.normal_numbers = desc.position_floats, next += desc.position_floats;
    if (tangents) desc.tangents = next, desc.tangent_numbers = desc.position_floats, next += desc.position_floats;
    if (sockets) desc.sockets = next, desc.socket_floats = sockets, next += sockets;
    if (channels) desc.channels = next, desc.channel_floats = channels, next += channels;
    if (joints) desc.joints = next, desc.joint_floats = joints, next += joints;
    if (check(fb_evaluate_batch(face, scratch, &desc))) return 1;
    fwrite(pose, sizeof(float), controls, file);
    fwrite(out, sizeof(float), (size_t)(next - out), file);
  }
  free(pose), free(out);
  return 0;
}

int main(int count, char** arguments) {
  fb_model* face;
  fb_scratch* scratch;
  if (count != 3) return fputs("usage: dump_poses FACE.fbk OUT.poses\n", stderr), 2;
  if (check(fb_load(arguments[1], NULL, &face)) || check(fb_scratch_create(face, 1, &scratch))) return 1;
  FILE* file = fopen(arguments[2], "wb");
  if (!file) return perror(arguments[2]), 1;
  const int failed = dump(face, scratch, file);
  fb_scratch_destroy(scratch);
  fb_release(face);
  return fclose(file) != 0 || failed;
}
