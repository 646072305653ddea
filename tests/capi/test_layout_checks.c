/* The layout of the structs of fb_check and of archives on 64-bit systems, as test_layout.c has it of the others. */
#include "capi_test.h"

#include <facebaker/facebaker_bake.h>

#define assert_at(type, field, offset) assert_int_equal(offsetof(type, field), offset)

static void layout_of_checks(void** state) {
  (void)state;
  assert_int_equal(sizeof(fb_check_desc), 40);
  assert_at(fb_check_desc, struct_size, 0);
  assert_at(fb_check_desc, threads, 4);
  assert_at(fb_check_desc, directory, 8);
  assert_at(fb_check_desc, callbacks, 16);

  assert_int_equal(sizeof(fb_check_result), 40);
  assert_at(fb_check_result, struct_size, 0);
  assert_at(fb_check_result, bakeable, 4);
  assert_at(fb_check_result, faults, 8);
  assert_at(fb_check_result, warnings, 16);
  assert_at(fb_check_result, poses, 24);
  assert_at(fb_check_result, evaluated, 32);
}

static void layout_of_archives(void** state) {
  (void)state;
  assert_int_equal(sizeof(fb_archive_info), 152);
  assert_at(fb_archive_info, struct_size, 0);
  assert_at(fb_archive_info, format_version, 4);
  assert_at(fb_archive_info, bytes, 8);
  assert_at(fb_archive_info, byte_count, 16);
  assert_at(fb_archive_info, name, 24);
  assert_at(fb_archive_info, recipe, 32);
  assert_at(fb_archive_info, licence, 40);
  assert_at(fb_archive_info, certificate, 48);
  assert_at(fb_archive_info, provenance, 56);
  assert_at(fb_archive_info, certificate_summary, 64);
  assert_at(fb_archive_info, section_count, 72);
  assert_at(fb_archive_info, note_count, 76);
  assert_at(fb_archive_info, proof_poses, 80);
  assert_at(fb_archive_info, proof_vertices, 84);
  assert_at(fb_archive_info, vertex_count, 88);
  assert_at(fb_archive_info, control_count, 92);
  assert_at(fb_archive_info, feature_count, 96);
  assert_at(fb_archive_info, direct_count, 100);
  assert_at(fb_archive_info, region_count, 104);
  assert_at(fb_archive_info, coefficient_count, 108);
  assert_at(fb_archive_info, parameter_count, 112);
  assert_at(fb_archive_info, value_count, 120);
  assert_at(fb_archive_info, about, 128);
  assert_at(fb_archive_info, thumbnail, 136);
  assert_at(fb_archive_info, thumbnail_bytes, 144);

  assert_int_equal(sizeof(fb_section), 32);
  assert_at(fb_section, struct_size, 0);
  assert_at(fb_section, name, 8);
  assert_at(fb_section, stored_bytes, 16);
  assert_at(fb_section, unpacked_bytes, 24);

  assert_int_equal(sizeof(fb_region), 40);
  assert_at(fb_region, struct_size, 0);
  assert_at(fb_region, layer_count, 4);
  assert_at(fb_region, name, 8);
  assert_at(fb_region, inputs, 16);
  assert_at(fb_region, input_count, 24);
  assert_at(fb_region, gate_count, 28);
  assert_at(fb_region, gate_inputs, 32);

  assert_int_equal(sizeof(fb_layer), 24);
  assert_at(fb_layer, struct_size, 0);
  assert_at(fb_layer, inputs, 4);
  assert_at(fb_layer, outputs, 8);
  assert_at(fb_layer, activation, 12);
  assert_at(fb_layer, skip, 16);
  assert_at(fb_layer, bits, 20);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(layout_of_checks), cmocka_unit_test(layout_of_archives)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
