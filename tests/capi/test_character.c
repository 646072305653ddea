/* What a face says about its meshes, materials and images. */
#include "capi_test.h"

#include <facebaker/facebaker_character.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static fb_model *character, *tiny;

static int load(void** state) {
  (void)state;
  return fb_load(FB_CHARACTER, NULL, &character) != FB_OK || fb_load(FB_FIXTURE, NULL, &tiny) != FB_OK;
}

static int release(void** state) {
  (void)state;
  fb_release(character);
  fb_release(tiny);
  return 0;
}

static fb_mesh mesh_of(const fb_model* model, uint32_t index) {
  fb_mesh mesh;
  fb_mesh_init(&mesh);
  assert_ok(fb_mesh_at(model, index, &mesh));
  return mesh;
}

static void meshes_divide_the_pool(void** state) {
  (void)state;
  assert_int_equal(fb_mesh_count(character), 2);
  const fb_mesh head = mesh_of(character, 0), teeth = mesh_of(character, 1);
  assert_string_equal(head.name, "head");
  assert_int_equal(head.first_vertex, 0);
  assert_int_equal(head.vertex_count, 18);
  assert_int_equal(head.polygon_count, 10);
  assert_int_equal(head.corner_count, 40);
  assert_int_equal(head.run_count, 2);
  assert_int_equal(head.runs[0].polygon_count, 6);
  assert_int_equal(head.runs[0].material, 0);
  assert_int_equal(head.runs[1].polygon_count, 4);
  assert_int_equal(head.runs[1].material, FB_NO_MATERIAL);
  assert_string_equal(teeth.name, "teeth");
  assert_int_equal(teeth.first_vertex, 18);
  assert_int_equal(teeth.vertex_count, 12);
  assert_int_equal(teeth.first_polygon, 10);
  assert_int_equal(teeth.first_corner, 40);
  for (uint32_t c = 0; c < fb_polygon_corner_count(character); ++c)
    assert_int_equal(fb_polygon_corners(character)[c] >= teeth.first_vertex, c >= teeth.first_corner);
}

static void a_face_without_meshes_is_one_without_a_name(void** state) {
  (void)state;
  assert_int_equal(fb_mesh_count(tiny), 1);
  const fb_mesh mesh = mesh_of(tiny, 0);
  assert_string_equal(mesh.name, "");
  assert_int_equal(mesh.vertex_count, fb_vertex_count(tiny));
  assert_int_equal(mesh.polygon_count, fb_polygon_count(tiny));
  assert_int_equal(mesh.corner_count, fb_polygon_corner_count(tiny));
  assert_int_equal(mesh.run_count, 1);
  assert_int_equal(mesh.runs[0].material, FB_NO_MATERIAL);
  assert_int_equal(fb_material_count(tiny), 0);
  assert_int_equal(fb_image_count(tiny), 0);
}

static void meshes_are_found_by_name(void** state) {
  (void)state;
  uint32_t index = 7;
  assert_ok(fb_find_mesh(character, "teeth", &index));
  assert_int_equal(index, 1);
  assert_int_equal(fb_find_mesh(character, "tooth", &index), FB_ERROR_NOT_FOUND);
  assert_non_null(strstr(fb_last_error(), "there is no mesh \"tooth\"; there are \"head\", \"teeth\""));
  assert_int_equal(index, 1);
  assert_int_equal(fb_find_mesh(NULL, "teeth", &index), FB_ERROR_INVALID_ARGUMENT);
}

static void materials_and_images_are_those_of_the_source(void** state) {
  (void)state;
  fb_material material;
  fb_material_init(&material);
  assert_true(material.base_colour[3] == 1 && material.metallic == 1 && material.alpha_cutoff == 0.5f);
  assert_int_equal(fb_material_count(character), 2);
  assert_ok(fb_material_at(character, 0, &material));
  assert_string_equal(material.name, "skin");
  assert_true(material.base_colour[1] == 0.25f && material.roughness == 0.75f && material.emissive[1] == 0.5f);
  assert_int_equal(material.alpha_mode, FB_ALPHA_MASK);
  assert_true(material.alpha_cutoff == 0.25f);
  assert_int_equal(material.double_sided, 1);
  assert_int_equal(material.texture_count, 2);
  assert_int_equal(material.textures[1].slot, FB_TEXTURE_NORMAL);
  assert_int_equal(material.textures[1].image, 1);
  assert_int_equal(material.textures[1].wrap_u, FB_WRAP_CLAMP);
  assert_int_equal(material.textures[1].wrap_v, FB_WRAP_MIRROR);
  assert_true(material.textures[1].scale == 0.5f);
  assert_ok(fb_material_at(character, 1, &material));
  assert_int_equal(material.alpha_mode, FB_ALPHA_BLEND);
  assert_null(material.textures);
  fb_image image;
  fb_image_init(&image);
  assert_int_equal(fb_image_count(character), 3);
  assert_ok(fb_image_at(character, 1, &image));
  assert_string_equal(image.name, "bumps");
  assert_string_equal(image.media_type, "image/jpeg");
  assert_int_equal(image.byte_count, 7);
  assert_int_equal(((const unsigned char*)image.bytes)[6], 0x89);
}

static void what_is_said_about_a_character_is_handed_over(void** state) {
  (void)state;
  assert_string_equal(fb_about(character),
                      "{\"author\":\"Ren\xc3\xa9"
                      "e\",\"rights\":{\"learning\":\"forbidden\"},\"shelf\":7}");
  uint64_t bytes = 0;
  const unsigned char* png = fb_thumbnail(character, &bytes);
  assert_non_null(png);
  assert_int_equal(bytes, 67);
  assert_memory_equal(png + 1, "PNG", 3);
  assert_ptr_equal(fb_thumbnail(character, NULL), png);
  assert_string_equal(fb_about(tiny), "");
  assert_null(fb_thumbnail(tiny, &bytes));
  assert_int_equal(bytes, 0);
  assert_null(fb_about(NULL));
  assert_null(fb_thumbnail(NULL, &bytes));
}

enum { VERTICES = 30, HEAD = 18, POSES = 9, FLOATS = 3 * VERTICES };

/* Some poses, as random as they need to be. */
static void fill_controls(float* controls, uint32_t width) {
  for (uint32_t i = 0; i < POSES * width; ++i) controls[i] = (float)(i * 37 % 101) / 101;
}

/* Positions, normals and tangents of poses in one buffer; what is not written keeps its value. */
static void pose(float* out, const float* controls, const uint32_t* meshes, uint64_t count, uint32_t order) {
  fb_scratch* scratch;
  assert_ok(fb_scratch_create(character, 1, &scratch));
  fb_batch_desc desc;
  fb_batch_desc_init(&desc);
  desc.poses = POSES;
  desc.controls = controls;
  desc.control_floats = POSES * fb_control_count(character);
  desc.positions = out;
  desc.normals = out + POSES * FLOATS;
  desc.tangents = out + 2 * POSES * FLOATS;
  desc.position_floats = desc.normal_numbers = desc.tangent_numbers = POSES * FLOATS;
  desc.vertex_order = order;
  /* Before, others are posed with the same scratch. */
  assert_ok(fb_evaluate_batch(character, scratch, &desc));
  for (int i = 0; i < 3 * POSES * FLOATS; ++i) out[i] = 77;
  desc.meshes = meshes;
  desc.mesh_count = count;
  assert_ok(fb_evaluate_batch(character, scratch, &desc));
  fb_scratch_destroy(scratch);
}

static void chosen_meshes_alone_are_posed(void** state) {
  (void)state;
  static float whole[3 * POSES * FLOATS], some[3 * POSES * FLOATS];
  float controls[POSES * 5];
  assert_int_equal(fb_control_count(character), 5);
  fill_controls(controls, 5);
  const uint32_t head = 0, teeth = 1, both[] = {1, 0};
  for (uint32_t order = FB_ORDER_SOURCE; order <= FB_ORDER_BAKED; ++order) {
    pose(whole, controls, NULL, 0, order);
    pose(some, controls, both, 2, order);
    assert_memory_equal(whole, some, sizeof whole);
    for (int mesh = 0; mesh < 2; ++mesh) {
      pose(some, controls, mesh == 0 ? &head : &teeth, 1, order);
      for (int i = 0; i < 3 * POSES * FLOATS; ++i) /* the baked order keeps the meshes apart, too */
        assert_true(some[i] == ((i % FLOATS / 3 >= HEAD) == mesh ? whole[i] : 77));
    }
    pose(some, controls, both, 0, order);
    for (int i = 0; i < 3 * POSES * FLOATS; ++i) assert_true(some[i] == 77);
  }
}

static void masks_of_meshes_work_with_halves_strides_and_threads(void** state) {
  (void)state;
  enum { stride = 5 };
  static uint16_t halves[2][POSES * VERTICES * stride];
  float controls[POSES * 5];
  fill_controls(controls, 5);
  fb_scratch* scratch;
  assert_ok(fb_scratch_create(character, 2, &scratch));
  const uint32_t teeth = 1, missing = 2;
  fb_batch_desc desc;
  fb_batch_desc_init(&desc);
  desc.poses = POSES;
  desc.controls = controls;
  desc.control_floats = POSES * 5;
  desc.position_floats = POSES * VERTICES * stride;
  desc.vertex_stride = stride;
  desc.format = FB_FLOAT16;
  desc.positions = halves[0];
  assert_ok(fb_evaluate_batch(character, scratch, &desc));
  desc.positions = halves[1];
  desc.meshes = &teeth;
  desc.mesh_count = 1;
  assert_ok(fb_evaluate_batch(character, scratch, &desc));
  for (int v = 0; v < POSES * VERTICES; ++v)
    for (int axis = 0; axis < 3; ++axis)
      assert_int_equal(halves[1][v * stride + axis], v % VERTICES < HEAD ? 0 : halves[0][v * stride + axis]);
  desc.meshes = &missing;
  assert_int_equal(fb_evaluate_batch(character, scratch, &desc), FB_ERROR_INVALID_ARGUMENT);
  assert_string_equal(fb_last_error(), "fb_batch_desc: mesh 2 of 2");
  fb_scratch_destroy(scratch);
}

static void controls_say_what_they_mean_and_are_found_by_it(void** state) {
  (void)state;
  uint32_t index = 7;
  fb_control control;
  fb_control_init(&control);
  assert_ok(fb_control_at(character, 0, &control));
  assert_string_equal(control.name, "jaw_open");
  assert_string_equal(control.arkit, "jawOpen");
  assert_string_equal(control.facs, "AU26");
  assert_string_equal(control.unit, "degrees");
  assert_int_equal(control.mirror, FB_NO_CONTROL);
  assert_ok(fb_control_at(character, 3, &control));
  assert_int_equal(control.mirror, 2);
  assert_string_equal(control.facs, "");
  assert_ok(fb_find_control(character, "jawOpen", &index));
  assert_int_equal(index, 0);
  assert_ok(fb_find_control(character, "eyeBlinkLeft", &index));
  assert_int_equal(index, 3);
  assert_ok(fb_find_control(character, "AU26", &index));
  assert_int_equal(index, 0);
  assert_int_equal(fb_find_control(character, "", &index), FB_ERROR_NOT_FOUND);
  assert_int_equal(fb_find_control(tiny, "jawOpen", &index), FB_ERROR_NOT_FOUND);
  assert_ok(fb_control_at(tiny, 0, &control));
  assert_string_equal(control.arkit, "");
  assert_int_equal(control.mirror, FB_NO_CONTROL);
}

static void channels_are_those_of_the_source(void** state) {
  (void)state;
  uint32_t index = 9;
  fb_channel channel;
  fb_channel_init(&channel);
  assert_int_equal(fb_channel_count(character), 4);
  assert_ok(fb_find_channel(character, "eye_turn", &index));
  assert_int_equal(index, 2);
  assert_ok(fb_channel_at(character, index, &channel));
  assert_string_equal(channel.name, "eye_turn");
  assert_string_equal(channel.unit, "degrees");
  assert_true(channel.minimum == -30 && channel.maximum == 30 && channel.rest == 0);
  assert_int_equal(fb_channel_at(character, 4, &channel), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_find_channel(tiny, "eye_turn", &index), FB_ERROR_NOT_FOUND);
  assert_int_equal(fb_channel_count(NULL), 0);
  assert_int_equal(fb_vertex_count(character), 30);
}

/* Channels alone, beside positions and with meshes left out, in batches of any stride: the same bits, within range. */
static void channels_of_a_batch_are_those_of_each_pose(void** state) {
  (void)state;
  enum { POSES = 11, CHANNELS = 4, STRIDE = 6 };
  float controls[POSES * 5], alone[POSES * CHANNELS], found[POSES * STRIDE];
  static float positions[POSES * 90], plain[POSES * 90];
  for (int i = 0; i < POSES * 5; ++i) controls[i] = i < 5 ? fb_rest_controls(character)[i] : (float)(i * 7 % 11) / 10;
  fb_scratch* scratch = NULL;
  assert_ok(fb_scratch_create(character, 2, &scratch));
  fb_batch_desc desc;
  fb_batch_desc_init(&desc);
  desc.poses = POSES;
  desc.controls = controls;
  desc.control_floats = POSES * 5;
  desc.channels = alone;
  desc.channel_floats = POSES * CHANNELS;
  assert_ok(fb_evaluate_batch(character, scratch, &desc));
  int at_an_end = 0;
  for (int i = 0; i < POSES * CHANNELS; ++i) {
    fb_channel channel;
    fb_channel_init(&channel);
    assert_ok(fb_channel_at(character, (uint32_t)i % CHANNELS, &channel));
    assert_true(alone[i] >= channel.minimum && alone[i] <= channel.maximum);
    if (i < CHANNELS) assert_true(alone[i] == channel.rest);
    at_an_end += alone[i] == channel.minimum || alone[i] == channel.maximum;
  }
  assert_true(at_an_end > 0 && at_an_end < POSES * CHANNELS);
  desc.channels = NULL;
  desc.positions = plain;
  desc.position_floats = POSES * 90;
  assert_ok(fb_evaluate_batch(character, scratch, &desc));
  const uint32_t none = 0;
  for (int with_meshes = 0; with_meshes < 2; ++with_meshes) {
    desc.positions = positions;
    desc.channels = found;
    desc.channel_floats = POSES * STRIDE;
    desc.channel_pose_stride = STRIDE;
    desc.meshes = with_meshes ? NULL : &none;
    desc.mesh_count = 0;
    memset(found, 0, sizeof found);
    assert_ok(fb_evaluate_batch(character, scratch, &desc));
    for (int p = 0; p < POSES; ++p)
      assert_memory_equal(found + p * STRIDE, alone + p * CHANNELS, CHANNELS * sizeof(float));
  }
  assert_memory_equal(positions, plain, sizeof plain);
  desc.channel_floats = POSES * STRIDE - 3;
  assert_int_equal(fb_evaluate_batch(character, scratch, &desc), FB_ERROR_INVALID_ARGUMENT);
  assert_string_equal(fb_last_error(), "11 poses need 64 floats of channels; the buffer has 63");
  desc.channel_pose_stride = 3;
  assert_int_equal(fb_evaluate_batch(character, scratch, &desc), FB_ERROR_INVALID_ARGUMENT);
  fb_scratch_destroy(scratch);
}

static void sockets_are_those_of_the_source(void** state) {
  (void)state;
  uint32_t index = 7;
  fb_socket socket;
  fb_socket_init(&socket);
  assert_int_equal(fb_socket_count(character), 2);
  assert_ok(fb_find_socket(character, "tooth", &index));
  assert_ok(fb_socket_at(character, index, &socket));
  assert_string_equal(socket.name, "tooth");
  assert_int_equal(socket.vertex_count, 3);
  assert_int_equal(socket.vertices[0], 29);
  assert_true(socket.weights[2] == 1 && socket.frame[11] == -4);
  assert_int_equal(fb_socket_at(character, 2, &socket), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_find_socket(tiny, "tooth", &index), FB_ERROR_NOT_FOUND);
  assert_string_equal(fb_last_error(), "there is no socket \"tooth\"; there are none");
  assert_int_equal(fb_socket_count(NULL), 0);
}

/* Sockets of poses: beside positions in any order, alone, one by one, with meshes left out. */
static void frames_are_the_same_with_any_other_output(void** state) {
  (void)state;
  enum { frames = 2 * FB_FRAME_FLOATS, stride = frames + 3 };
  float positions[POSES * FLOATS], expected[POSES * frames], found[POSES * stride];
  float controls[POSES * 5];
  fill_controls(controls, 5);
  for (int i = 0; i < 5; ++i) controls[i] = fb_rest_controls(character)[i];
  fb_scratch* scratch;
  assert_ok(fb_scratch_create(character, 2, &scratch));
  fb_batch_desc desc;
  fb_batch_desc_init(&desc);
  desc.poses = POSES;
  desc.controls = controls;
  desc.control_floats = POSES * 5;
  desc.sockets = expected;
  desc.socket_floats = POSES * frames;
  assert_ok(fb_evaluate_batch(character, scratch, &desc));
  for (uint32_t s = 0; s < 2; ++s) { /* exact at rest */
    fb_socket socket;
    fb_socket_init(&socket);
    assert_ok(fb_socket_at(character, s, &socket));
    assert_memory_equal(expected + s * FB_FRAME_FLOATS, socket.frame, sizeof socket.frame);
  }
  for (uint32_t order = FB_ORDER_SOURCE; order <= FB_ORDER_BAKED; ++order)
    for (uint64_t poses = 1; poses <= POSES; poses += POSES - 1) {
      desc.vertex_order = order;
      desc.positions = positions;
      desc.position_floats = POSES * FLOATS;
      desc.sockets = found;
      desc.socket_floats = POSES * stride;
      desc.socket_pose_stride = stride;
      desc.poses = poses;
      for (int i = 0; i < POSES * stride; ++i) found[i] = 77;
      for (uint64_t p = 0; p < POSES; p += poses) {
        desc.controls = controls + 5 * p;
        desc.control_floats = poses * 5;
        desc.sockets = found + p * stride;
        desc.socket_floats = (POSES - p) * stride;
        assert_ok(fb_evaluate_batch(character, scratch, &desc));
      }
      for (int p = 0; p < POSES; ++p) {
        assert_memory_equal(found + p * stride, expected + p * frames, frames * sizeof(float));
        for (int i = frames; i < stride; ++i) assert_true(found[p * stride + i] == 77);
      }
    }
  const uint32_t teeth = 1;
  desc.meshes = &teeth;
  desc.mesh_count = 1;
  desc.poses = 1;
  desc.controls = controls + 5;
  for (int i = 0; i < frames; ++i) found[i] = 77;
  desc.sockets = found;
  assert_ok(fb_evaluate_batch(character, scratch, &desc));
  assert_true(found[0] == 77 && found[FB_FRAME_FLOATS - 1] == 77);
  assert_memory_equal(found + FB_FRAME_FLOATS, expected + frames + FB_FRAME_FLOATS, FB_FRAME_FLOATS * sizeof(float));
  desc.socket_floats = frames - 1;
  assert_int_equal(fb_evaluate_batch(character, scratch, &desc), FB_ERROR_INVALID_ARGUMENT);
  fb_scratch_destroy(scratch);
}

static void wrong_use_is_refused(void** state) {
  (void)state;
  fb_mesh mesh;
  fb_mesh_init(&mesh);
  assert_int_equal(fb_mesh_at(character, 2, &mesh), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_mesh_at(character, 0, NULL), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_mesh_at(NULL, 0, &mesh), FB_ERROR_INVALID_ARGUMENT);
  mesh.struct_size = 0;
  assert_int_equal(fb_mesh_at(character, 0, &mesh), FB_ERROR_INVALID_ARGUMENT);
  fb_material material;
  fb_material_init(&material);
  assert_int_equal(fb_material_at(character, 2, &material), FB_ERROR_INVALID_ARGUMENT);
  fb_image image;
  fb_image_init(&image);
  assert_int_equal(fb_image_at(tiny, 0, &image), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_mesh_count(NULL), 0);
  assert_int_equal(fb_material_count(NULL), 0);
  assert_int_equal(fb_image_count(NULL), 0);
}

static void an_older_host_gets_the_fields_it_knows(void** state) {
  (void)state;
  fb_mesh mesh;
  memset(&mesh, 0x5a, sizeof mesh);
  mesh.struct_size = offsetof(fb_mesh, vertex_count);
  assert_ok(fb_mesh_at(character, 1, &mesh));
  assert_int_equal(mesh.struct_size, offsetof(fb_mesh, vertex_count));
  assert_string_equal(mesh.name, "teeth");
  assert_int_equal(mesh.vertex_count, 0x5a5a5a5a);
}

static void expected_errors_come_with_their_regions(void** state) {
  (void)state;
  assert_int_equal(fb_error_region_count(character), 2);
  assert_string_equal(fb_error_region_name(character, 1), "brows, upper left");
  assert_null(fb_error_region_name(character, 2));
  uint32_t counts[2] = {0, 0};
  for (uint32_t v = 0; v < fb_vertex_count(character); ++v) ++counts[fb_error_vertex_regions(character)[v]];
  assert_int_equal(counts[0], 18);
  assert_int_equal(counts[1], 12);
  fb_scratch* scratch = NULL;
  assert_ok(fb_scratch_create(character, 1, &scratch));
  float controls[5] = {0.5f, 0.5f, 0.25f, 0, 0}, errors[3], batch_errors[3];
  uint32_t outside = 77, batch_outside = 77;
  assert_ok(fb_expected_error(character, scratch, controls, errors, &outside));
  assert_int_equal(outside, 2);
  assert_true(errors[0] > 0 && errors[1] > 0 && errors[2] > 0);
  assert_ok(fb_expected_error(character, scratch, controls, NULL, NULL));
  fb_batch_desc batch;
  fb_batch_desc_init(&batch);
  batch.poses = 1;
  batch.controls = controls;
  batch.control_floats = 5;
  batch.expected_errors = batch_errors;
  batch.expected_error_floats = 3;
  batch.outside = &batch_outside;
  assert_ok(fb_evaluate_batch(character, scratch, &batch));
  assert_memory_equal(errors, batch_errors, sizeof errors);
  assert_int_equal(batch_outside, 2);
  batch.expected_error_floats = 2;
  assert_int_equal(fb_evaluate_batch(character, scratch, &batch), FB_ERROR_INVALID_ARGUMENT);
  controls[4] = NAN;
  assert_int_equal(fb_expected_error(character, scratch, controls, errors, &outside), FB_ERROR_NOT_FINITE);
  fb_scratch_destroy(scratch);
  assert_int_equal(fb_error_region_count(NULL), 0);
  assert_int_equal(fb_error_region_count(tiny), 0);
  assert_null(fb_error_vertex_regions(tiny));
  assert_ok(fb_scratch_create(tiny, 1, &scratch));
  controls[4] = 0;
  assert_int_equal(fb_expected_error(tiny, scratch, controls, errors, &outside), FB_ERROR_INVALID_ARGUMENT);
  fb_scratch_destroy(scratch);
}

static void exact_poses_are_told_and_corrected(void** state) {
  (void)state;
  fb_model* exact = NULL;
  assert_ok(fb_load(FB_EXACT, NULL, &exact));
  assert_int_equal(fb_exact_pose_count(exact), 2);
  assert_int_equal(fb_exact_pose_count(character), 0);
  assert_int_equal(fb_exact_pose_count(NULL), 0);
  fb_exact_pose pose;
  fb_exact_pose_init(&pose);
  assert_int_equal(pose.struct_size, sizeof pose);
  assert_ok(fb_exact_pose_at(exact, 1, &pose));
  assert_string_equal(pose.name, "frown:0");
  assert_ok(fb_exact_pose_at(exact, 0, &pose));
  assert_string_equal(pose.name, "smile:12");
  assert_int_equal(pose.control_count, fb_control_count(exact));
  assert_int_equal(fb_exact_pose_at(exact, 2, &pose), FB_ERROR_INVALID_ARGUMENT);
  assert_int_equal(fb_exact_pose_at(exact, 0, NULL), FB_ERROR_INVALID_ARGUMENT);
  const size_t size = 3 * fb_vertex_count(exact) * sizeof(float);
  float *corrected = malloc(size), *plain = malloc(size);
  fb_scratch *scratch = NULL, *other = NULL;
  assert_ok(fb_scratch_create(exact, 1, &scratch));
  assert_ok(fb_scratch_create(character, 1, &other));
  assert_ok(fb_evaluate(exact, scratch, pose.controls, corrected));
  assert_ok(fb_evaluate(character, other, pose.controls, plain));
  assert_memory_not_equal(corrected, plain, size);
  const float rest[5] = {0, 0, 0.25f, 0, 0};
  assert_ok(fb_evaluate(exact, scratch, rest, corrected));
  assert_ok(fb_evaluate(character, other, rest, plain));
  assert_memory_equal(corrected, plain, size);
  free(corrected);
  free(plain);
  fb_scratch_destroy(scratch);
  fb_scratch_destroy(other);
  fb_release(exact);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(meshes_divide_the_pool),
      cmocka_unit_test(a_face_without_meshes_is_one_without_a_name),
      cmocka_unit_test(meshes_are_found_by_name),
      cmocka_unit_test(materials_and_images_are_those_of_the_source),
      cmocka_unit_test(what_is_said_about_a_character_is_handed_over),
      cmocka_unit_test(chosen_meshes_alone_are_posed),
      cmocka_unit_test(masks_of_meshes_work_with_halves_strides_and_threads),
      cmocka_unit_test(controls_say_what_they_mean_and_are_found_by_it),
      cmocka_unit_test(sockets_are_those_of_the_source),
      cmocka_unit_test(channels_are_those_of_the_source),
      cmocka_unit_test(channels_of_a_batch_are_those_of_each_pose),
      cmocka_unit_test(frames_are_the_same_with_any_other_output),
      cmocka_unit_test(expected_errors_come_with_their_regions),
      cmocka_unit_test(exact_poses_are_told_and_corrected),
      cmocka_unit_test(wrong_use_is_refused),
      cmocka_unit_test(an_older_host_gets_the_fields_it_knows),
  };
  return cmocka_run_group_tests(tests, load, release);
}
