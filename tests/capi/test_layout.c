/* The layout of every struct that crosses the boundary, on 64-bit systems: a change here breaks hosts. */
#include "capi_test.h"

#include <facebaker/facebaker_bake.h>
#include <stdlib.h>
#include <string.h>

#define assert_at(type, field, offset) assert_int_equal(offsetof(type, field), offset)

static void layout_of_runtime_structs(void** state) {
  (void)state;
  assert_int_equal(sizeof(fb_allocator), 24);
  assert_at(fb_allocator, user, 0);
  assert_at(fb_allocator, allocate, 8);
  assert_at(fb_allocator, release, 16);

  assert_int_equal(sizeof(fb_load_desc), 136);
  assert_at(fb_load_desc, struct_size, 0);
  assert_at(fb_load_desc, max_file_bytes, 8);
  assert_at(fb_load_desc, max_model_bytes, 16);
  assert_at(fb_load_desc, allocator, 24);
  assert_at(fb_load_desc, log, 48);
  assert_at(fb_load_desc, log_user, 56);
  assert_at(fb_load_desc, instruction_set, 64);
  assert_at(fb_load_desc, map_file, 72);
  assert_at(fb_load_desc, reserved_number, 76);
  assert_at(fb_load_desc, max_name_bytes, 80);
  assert_at(fb_load_desc, max_vertices, 88);
  assert_at(fb_load_desc, max_polygons, 96);
  assert_at(fb_load_desc, max_features, 104);
  assert_at(fb_load_desc, parallel_for, 112);
  assert_at(fb_load_desc, parallel_user, 120);
  assert_at(fb_load_desc, threads, 128);
  assert_at(fb_load_desc, reserved_threads, 132);

  assert_int_equal(sizeof(fb_control), 64);
  assert_at(fb_control, struct_size, 0);
  assert_at(fb_control, name, 8);
  assert_at(fb_control, group, 16);
  assert_at(fb_control, minimum, 24);
  assert_at(fb_control, maximum, 28);
  assert_at(fb_control, rest, 32);
  assert_at(fb_control, mirror, 36);
  assert_at(fb_control, arkit, 40);
  assert_at(fb_control, facs, 48);
  assert_at(fb_control, unit, 56);

  assert_int_equal(sizeof(fb_row_block), 20);
  assert_at(fb_row_block, struct_size, 0);
  assert_at(fb_row_block, first_row, 4);
  assert_at(fb_row_block, row_count, 8);
  assert_at(fb_row_block, column_count, 12);
  assert_at(fb_row_block, digit_column_count, 16);

  assert_int_equal(sizeof(fb_batch_desc), 312);
  assert_at(fb_batch_desc, struct_size, 0);
  assert_at(fb_batch_desc, threads, 4);
  assert_at(fb_batch_desc, poses, 8);
  assert_at(fb_batch_desc, controls, 16);
  assert_at(fb_batch_desc, control_floats, 24);
  assert_at(fb_batch_desc, control_stride, 32);
  assert_at(fb_batch_desc, positions, 40);
  assert_at(fb_batch_desc, position_floats, 48);
  assert_at(fb_batch_desc, pose_stride, 56);
  assert_at(fb_batch_desc, vertex_stride, 64);
  assert_at(fb_batch_desc, parallel_for, 72);
  assert_at(fb_batch_desc, parallel_user, 80);
  assert_at(fb_batch_desc, vertex_order, 88);
  assert_at(fb_batch_desc, format, 92);
  assert_at(fb_batch_desc, normals, 96);
  assert_at(fb_batch_desc, normal_numbers, 104);
  assert_at(fb_batch_desc, normal_pose_stride, 112);
  assert_at(fb_batch_desc, normal_vertex_stride, 120);
  assert_at(fb_batch_desc, regions, 128);
  assert_at(fb_batch_desc, region_count, 136);
  assert_at(fb_batch_desc, tangents, 144);
  assert_at(fb_batch_desc, tangent_numbers, 152);
  assert_at(fb_batch_desc, tangent_pose_stride, 160);
  assert_at(fb_batch_desc, tangent_vertex_stride, 168);
  assert_at(fb_batch_desc, meshes, 176);
  assert_at(fb_batch_desc, mesh_count, 184);
  assert_at(fb_batch_desc, sockets, 192);
  assert_at(fb_batch_desc, socket_floats, 200);
  assert_at(fb_batch_desc, socket_pose_stride, 208);
  assert_at(fb_batch_desc, channels, 216);
  assert_at(fb_batch_desc, channel_floats, 224);
  assert_at(fb_batch_desc, channel_pose_stride, 232);
  assert_at(fb_batch_desc, expected_errors, 240);
  assert_at(fb_batch_desc, expected_error_floats, 248);
  assert_at(fb_batch_desc, expected_error_pose_stride, 256);
  assert_at(fb_batch_desc, outside, 264);
  assert_at(fb_batch_desc, displacements, 272);
  assert_at(fb_batch_desc, bounds, 280);
  assert_at(fb_batch_desc, bounds_floats, 288);
  assert_at(fb_batch_desc, bounds_pose_stride, 296);
  assert_at(fb_batch_desc, lod, 304);
  assert_at(fb_batch_desc, level_only, 308);

  assert_int_equal(sizeof(fb_many_item), 24);
  assert_at(fb_many_item, model, 0);
  assert_at(fb_many_item, scratch, 8);
  assert_at(fb_many_item, batch, 16);

  assert_int_equal(sizeof(fb_many_desc), 40);
  assert_at(fb_many_desc, threads, 4);
  assert_at(fb_many_desc, items, 8);
  assert_at(fb_many_desc, item_count, 16);
  assert_at(fb_many_desc, parallel_for, 24);
  assert_at(fb_many_desc, parallel_user, 32);
}

static void layout_of_characters(void** state) {
  (void)state;
  assert_int_equal(sizeof(fb_material_run), 8);
  assert_at(fb_material_run, polygon_count, 0);
  assert_at(fb_material_run, material, 4);

  assert_int_equal(sizeof(fb_mesh), 48);
  assert_at(fb_mesh, run_count, 4);
  assert_at(fb_mesh, name, 8);
  assert_at(fb_mesh, runs, 16);
  assert_at(fb_mesh, vertex_count, 24);
  assert_at(fb_mesh, polygon_count, 28);
  assert_at(fb_mesh, first_vertex, 32);
  assert_at(fb_mesh, first_polygon, 36);
  assert_at(fb_mesh, first_corner, 40);
  assert_at(fb_mesh, corner_count, 44);

  assert_int_equal(sizeof(fb_texture), 20);
  assert_at(fb_texture, slot, 0);
  assert_at(fb_texture, image, 4);
  assert_at(fb_texture, wrap_u, 8);
  assert_at(fb_texture, wrap_v, 12);
  assert_at(fb_texture, scale, 16);

  assert_int_equal(sizeof(fb_material), 72);
  assert_at(fb_material, alpha_mode, 4);
  assert_at(fb_material, name, 8);
  assert_at(fb_material, base_colour, 16);
  assert_at(fb_material, metallic, 32);
  assert_at(fb_material, roughness, 36);
  assert_at(fb_material, emissive, 40);
  assert_at(fb_material, alpha_cutoff, 52);
  assert_at(fb_material, double_sided, 56);
  assert_at(fb_material, texture_count, 60);
  assert_at(fb_material, textures, 64);

  assert_int_equal(sizeof(fb_image), 40);
  assert_at(fb_image, name, 8);
  assert_at(fb_image, media_type, 16);
  assert_at(fb_image, bytes, 24);
  assert_at(fb_image, byte_count, 32);

  assert_int_equal(sizeof(fb_socket), 80);
  assert_at(fb_socket, vertex_count, 4);
  assert_at(fb_socket, name, 8);
  assert_at(fb_socket, vertices, 16);
  assert_at(fb_socket, weights, 24);
  assert_at(fb_socket, frame, 32);

  assert_int_equal(sizeof(fb_exact_pose), 24);
  assert_at(fb_exact_pose, struct_size, 0);
  assert_at(fb_exact_pose, control_count, 4);
  assert_at(fb_exact_pose, name, 8);
  assert_at(fb_exact_pose, controls, 16);

  assert_int_equal(sizeof(fb_channel), 40);
  assert_at(fb_channel, name, 8);
  assert_at(fb_channel, unit, 16);
  assert_at(fb_channel, minimum, 24);
  assert_at(fb_channel, maximum, 28);
  assert_at(fb_channel, rest, 32);

  assert_int_equal(sizeof(fb_joint), 112);
  assert_at(fb_joint, parent, 4);
  assert_at(fb_joint, name, 8);
  assert_at(fb_joint, rest, 16);
  assert_at(fb_joint, inverse_bind, 64);
}

static void layout_of_rigs(void** state) {
  (void)state;
  assert_int_equal(sizeof(fb_rig_control), 32);
  assert_int_equal(sizeof(fb_rig_labels), 32);
  assert_at(fb_rig_labels, arkit, 0);
  assert_at(fb_rig_labels, facs, 8);
  assert_at(fb_rig_labels, unit, 16);
  assert_at(fb_rig_labels, mirror, 24);
  assert_at(fb_rig_control, name, 0);
  assert_at(fb_rig_control, group, 8);
  assert_at(fb_rig_control, minimum, 16);
  assert_at(fb_rig_control, maximum, 20);
  assert_at(fb_rig_control, rest, 24);

  assert_int_equal(sizeof(fb_rig_clip), 40);
  assert_at(fb_rig_clip, name, 0);
  assert_at(fb_rig_clip, kind, 8);
  assert_at(fb_rig_clip, split, 12);
  assert_at(fb_rig_clip, fps, 16);
  assert_at(fb_rig_clip, frames, 24);
  assert_at(fb_rig_clip, controls, 32);

  assert_int_equal(sizeof(fb_rig), 328);
  assert_at(fb_rig, struct_size, 0);
  assert_at(fb_rig, abi, 4);
  assert_at(fb_rig, name, 8);
  assert_at(fb_rig, units, 16);
  assert_at(fb_rig, up_axis, 24);
  assert_at(fb_rig, flags, 32);
  assert_at(fb_rig, control_count, 36);
  assert_at(fb_rig, controls, 40);
  assert_at(fb_rig, control_stride, 48);
  assert_at(fb_rig, clip_stride, 52);
  assert_at(fb_rig, vertex_count, 56);
  assert_at(fb_rig, polygon_count, 60);
  assert_at(fb_rig, rest_positions, 64);
  assert_at(fb_rig, polygon_sizes, 72);
  assert_at(fb_rig, polygon_corners, 80);
  assert_at(fb_rig, clip_count, 88);
  assert_at(fb_rig, clips, 96);
  assert_at(fb_rig, user, 104);
  assert_at(fb_rig, evaluate, 112);
  assert_at(fb_rig, destroy, 120);
  assert_at(fb_rig, uv_count, 128);
  assert_at(fb_rig, uvs, 136);
  assert_at(fb_rig, uv_corners, 144);
  assert_at(fb_rig, preferred_block, 152);
  assert_at(fb_rig, version, 160);
  assert_at(fb_rig, mesh_count, 168);
  assert_at(fb_rig, mesh_stride, 172);
  assert_at(fb_rig, meshes, 176);
  assert_at(fb_rig, material_count, 184);
  assert_at(fb_rig, material_stride, 188);
  assert_at(fb_rig, materials, 192);
  assert_at(fb_rig, image_count, 200);
  assert_at(fb_rig, image_stride, 204);
  assert_at(fb_rig, images, 208);
  assert_at(fb_rig, label_stride, 216);
  assert_at(fb_rig, labels, 224);
  assert_at(fb_rig, socket_count, 232);
  assert_at(fb_rig, socket_stride, 236);
  assert_at(fb_rig, sockets, 240);
  assert_at(fb_rig, about, 248);
  assert_at(fb_rig, channel_count, 256);
  assert_at(fb_rig, channel_stride, 260);
  assert_at(fb_rig, channels, 264);
  assert_at(fb_rig, evaluate_all, 272);
  assert_at(fb_rig, joint_count, 280);
  assert_at(fb_rig, joint_stride, 284);
  assert_at(fb_rig, joints, 288);
  assert_at(fb_rig, skin_influences, 296);
  assert_at(fb_rig, skin_joints, 304);
  assert_at(fb_rig, skin_weights, 312);
  assert_at(fb_rig, evaluate_skinned, 320);
}

static void layout_of_sources(void** state) {
  (void)state;
  assert_int_equal(sizeof(fb_callbacks), 24);
  assert_at(fb_callbacks, user, 0);
  assert_at(fb_callbacks, progress, 8);
  assert_at(fb_callbacks, note, 16);

  assert_int_equal(sizeof(fb_source_desc), 112);
  assert_at(fb_source_desc, struct_size, 0);
  assert_at(fb_source_desc, path_count, 4);
  assert_at(fb_source_desc, paths, 8);
  assert_at(fb_source_desc, rig, 16);
  assert_at(fb_source_desc, callbacks, 24);
  assert_at(fb_source_desc, workers, 48);
  assert_at(fb_source_desc, host, 56);
  assert_at(fb_source_desc, pose_seconds, 64);
  assert_at(fb_source_desc, clip_budget, 72);
  assert_at(fb_source_desc, joints, 80);
  assert_at(fb_source_desc, control_joint_count, 84);
  assert_at(fb_source_desc, control_joints, 88);
  assert_at(fb_source_desc, test_poses, 96);
  assert_at(fb_source_desc, skip_broken, 104);

  assert_int_equal(sizeof(fb_source_info), 120);
  assert_at(fb_source_info, struct_size, 0);
  assert_at(fb_source_info, flags, 4);
  assert_at(fb_source_info, name, 8);
  assert_at(fb_source_info, units, 16);
  assert_at(fb_source_info, up_axis, 24);
  assert_at(fb_source_info, diagonal, 32);
  assert_at(fb_source_info, control_count, 40);
  assert_at(fb_source_info, clip_count, 44);
  assert_at(fb_source_info, vertex_count, 48);
  assert_at(fb_source_info, polygon_count, 52);
  assert_at(fb_source_info, polygon_corner_count, 56);
  assert_at(fb_source_info, uv_count, 60);
  assert_at(fb_source_info, rest_positions, 64);
  assert_at(fb_source_info, polygon_sizes, 72);
  assert_at(fb_source_info, polygon_corners, 80);
  assert_at(fb_source_info, uvs, 88);
  assert_at(fb_source_info, uv_corners, 96);
  assert_at(fb_source_info, identity, 104);
  assert_at(fb_source_info, channel_count, 112);
  assert_at(fb_source_info, preferred_block, 116);

  assert_int_equal(sizeof(fb_clip), 48);
  assert_at(fb_clip, struct_size, 0);
  assert_at(fb_clip, kind, 4);
  assert_at(fb_clip, split, 8);
  assert_at(fb_clip, readable, 12);
  assert_at(fb_clip, name, 16);
  assert_at(fb_clip, fps, 24);
  assert_at(fb_clip, frames, 32);
  assert_at(fb_clip, controls, 40);
}

static void layout_of_requests(void** state) {
  (void)state;
  assert_int_equal(sizeof(fb_sample_desc), 128);
  assert_at(fb_sample_desc, struct_size, 0);
  assert_at(fb_sample_desc, threads, 4);
  assert_at(fb_sample_desc, source, 8);
  assert_at(fb_sample_desc, directory, 16);
  assert_at(fb_sample_desc, poses, 24);
  assert_at(fb_sample_desc, seed, 32);
  assert_at(fb_sample_desc, mix, 40);
  assert_at(fb_sample_desc, rig_budget, 48);
  assert_at(fb_sample_desc, shots, 56);
  assert_at(fb_sample_desc, clip_count, 60);
  assert_at(fb_sample_desc, clips, 64);
  assert_at(fb_sample_desc, clip_stride, 72);
  assert_at(fb_sample_desc, callbacks, 80);
  assert_at(fb_sample_desc, skip_failing, 104);
  assert_at(fb_sample_desc, example_count, 108);
  assert_at(fb_sample_desc, examples, 112);
  assert_at(fb_sample_desc, schema, 120);

  assert_int_equal(sizeof(fb_bake_desc), 256);
  assert_at(fb_bake_desc, struct_size, 0);
  assert_at(fb_bake_desc, threads, 4);
  assert_at(fb_bake_desc, source, 8);
  assert_at(fb_bake_desc, archive, 16);
  assert_at(fb_bake_desc, recipe, 24);
  assert_at(fb_bake_desc, use, 32);
  assert_at(fb_bake_desc, epochs, 36);
  assert_at(fb_bake_desc, poses, 40);
  assert_at(fb_bake_desc, mix, 48);
  assert_at(fb_bake_desc, rig_budget, 56);
  assert_at(fb_bake_desc, seed, 64);
  assert_at(fb_bake_desc, max_bytes, 72);
  assert_at(fb_bake_desc, max_error, 80);
  assert_at(fb_bake_desc, force, 88);
  assert_at(fb_bake_desc, measure, 92);
  assert_at(fb_bake_desc, learning_curve, 96);
  assert_at(fb_bake_desc, licence, 104);
  assert_at(fb_bake_desc, created, 112);
  assert_at(fb_bake_desc, work, 120);
  assert_at(fb_bake_desc, callbacks, 128);
  assert_at(fb_bake_desc, reuse, 152);
  assert_at(fb_bake_desc, skip_failing, 160);
  assert_at(fb_bake_desc, example_count, 164);
  assert_at(fb_bake_desc, examples, 168);
  assert_at(fb_bake_desc, normal_weight, 176);
  assert_at(fb_bake_desc, cache_bytes, 184);
  assert_at(fb_bake_desc, about, 192);
  assert_at(fb_bake_desc, thumbnail, 200);
  assert_at(fb_bake_desc, thumbnail_bytes, 208);
  assert_at(fb_bake_desc, exact, 216);
  assert_at(fb_bake_desc, exact_count, 224);
  assert_at(fb_bake_desc, level_share_count, 232);
  assert_at(fb_bake_desc, level_mesh_count, 236);
  assert_at(fb_bake_desc, level_shares, 240);
  assert_at(fb_bake_desc, level_meshes, 248);

  assert_int_equal(sizeof(fb_compare_desc), 104);
  assert_at(fb_compare_desc, struct_size, 0);
  assert_at(fb_compare_desc, threads, 4);
  assert_at(fb_compare_desc, source, 8);
  assert_at(fb_compare_desc, methods, 16);
  assert_at(fb_compare_desc, method_count, 24);
  assert_at(fb_compare_desc, epochs, 28);
  assert_at(fb_compare_desc, poses, 32);
  assert_at(fb_compare_desc, mix, 40);
  assert_at(fb_compare_desc, rig_budget, 48);
  assert_at(fb_compare_desc, seed, 56);
  assert_at(fb_compare_desc, learning_curve, 64);
  assert_at(fb_compare_desc, work, 72);
  assert_at(fb_compare_desc, callbacks, 80);

  assert_int_equal(sizeof(fb_eval_desc), 56);
  assert_at(fb_eval_desc, struct_size, 0);
  assert_at(fb_eval_desc, threads, 4);
  assert_at(fb_eval_desc, archive, 8);
  assert_at(fb_eval_desc, source, 16);
  assert_at(fb_eval_desc, split, 24);
  assert_at(fb_eval_desc, measure, 28);
  assert_at(fb_eval_desc, callbacks, 32);

  assert_int_equal(sizeof(fb_pack_desc), 128);
  assert_at(fb_pack_desc, struct_size, 0);
  assert_at(fb_pack_desc, force, 4);
  assert_at(fb_pack_desc, path, 8);
  assert_at(fb_pack_desc, bytes, 16);
  assert_at(fb_pack_desc, byte_count, 24);
  assert_at(fb_pack_desc, out, 32);
  assert_at(fb_pack_desc, seed, 40);
  assert_at(fb_pack_desc, max_bytes, 48);
  assert_at(fb_pack_desc, max_error, 56);
  assert_at(fb_pack_desc, licence, 64);
  assert_at(fb_pack_desc, callbacks, 72);
  assert_at(fb_pack_desc, about, 96);
  assert_at(fb_pack_desc, thumbnail, 104);
  assert_at(fb_pack_desc, thumbnail_bytes, 112);
  assert_at(fb_pack_desc, sockets, 120);
}

static void layout_of_results(void** state) {
  (void)state;
  assert_int_equal(sizeof(fb_errors), 64);
  assert_at(fb_errors, frames, 0);
  assert_at(fb_errors, mse, 8);
  assert_at(fb_errors, rms, 16);
  assert_at(fb_errors, mean, 24);
  assert_at(fb_errors, p99, 32);
  assert_at(fb_errors, max, 40);
  assert_at(fb_errors, mfm, 48);
  assert_at(fb_errors, worst_frame, 56);

  assert_int_equal(sizeof(fb_method), 272);
  assert_at(fb_method, struct_size, 0);
  assert_at(fb_method, use, 4);
  assert_at(fb_method, name, 8);
  assert_at(fb_method, archive, 16);
  assert_at(fb_method, archive_bytes, 24);
  assert_at(fb_method, poses, 32);
  assert_at(fb_method, parameters, 40);
  assert_at(fb_method, coefficients, 48);
  assert_at(fb_method, rig_calls, 56);
  assert_at(fb_method, train_seconds, 64);
  assert_at(fb_method, unseen, 72);
  assert_at(fb_method, dependency, 136);
  assert_at(fb_method, quantisation, 200);
  assert_at(fb_method, clip_count, 264);

  assert_int_equal(sizeof(fb_clip_errors), 88);
  assert_at(fb_clip_errors, struct_size, 0);
  assert_at(fb_clip_errors, kind, 4);
  assert_at(fb_clip_errors, split, 8);
  assert_at(fb_clip_errors, name, 16);
  assert_at(fb_clip_errors, errors, 24);

  assert_int_equal(sizeof(fb_failure), 24);
  assert_at(fb_failure, struct_size, 0);
  assert_at(fb_failure, use, 4);
  assert_at(fb_failure, name, 8);
  assert_at(fb_failure, reason, 16);

  assert_int_equal(sizeof(fb_sample_result), 48);
  assert_at(fb_sample_result, struct_size, 0);
  assert_at(fb_sample_result, poses, 8);
  assert_at(fb_sample_result, evaluated, 16);
  assert_at(fb_sample_result, rig_calls, 24);
  assert_at(fb_sample_result, asked, 32);
  assert_at(fb_sample_result, left_out, 40);

  assert_int_equal(sizeof(fb_verify_result), 32);
  assert_at(fb_verify_result, struct_size, 0);
  assert_at(fb_verify_result, bytes, 8);
  assert_at(fb_verify_result, poses, 16);
  assert_at(fb_verify_result, vertices, 24);

  assert_int_equal(sizeof(fb_pack_result), 120);
  assert_at(fb_pack_result, struct_size, 0);
  assert_at(fb_pack_result, within_limits, 4);
  assert_at(fb_pack_result, archive, 8);
  assert_at(fb_pack_result, archive_bytes, 16);
  assert_at(fb_pack_result, bytes_before, 24);
  assert_at(fb_pack_result, format_before, 32);
  assert_at(fb_pack_result, format, 36);
  assert_at(fb_pack_result, step_factor, 40);
  assert_at(fb_pack_result, max_error, 48);
  assert_at(fb_pack_result, displacement, 56);
}

static void init_functions_set_sizes_and_defaults(void** state) {
  (void)state;
  fb_load_desc load;
  fb_load_desc_init(&load);
  assert_int_equal(load.struct_size, sizeof load);
  assert_true(load.max_file_bytes == (uint64_t)4 << 30);
  assert_true(load.max_model_bytes == (uint64_t)4 << 30);
  assert_true(load.max_name_bytes == (uint64_t)16 << 20 && load.max_vertices == (uint64_t)4 << 20);
  assert_true(load.max_polygons == (uint64_t)8 << 20 && load.max_features == (uint64_t)1 << 20);
  assert_true(load.allocator.allocate == NULL && load.log == NULL && load.map_file == 0);
  assert_true(load.threads == 1 && load.parallel_for == NULL);
  fb_control control;
  fb_control_init(&control);
  assert_int_equal(control.struct_size, sizeof control);
  fb_batch_desc batch;
  fb_batch_desc_init(&batch);
  assert_int_equal(batch.struct_size, sizeof batch);
  assert_true(batch.poses == 0 && batch.controls == NULL);
  fb_row_block group;
  fb_row_block_init(&group);
  assert_int_equal(group.struct_size, sizeof group);
  assert_true(group.first_row == 0 && group.row_count == 0 && group.column_count == 0);
  fb_row_block_init(NULL);
  fb_load_desc_init(NULL);
  fb_control_init(NULL);
  fb_batch_desc_init(NULL);
}

static void structs_of_other_headers_are_filled_to_their_size(void** state) {
  (void)state;
  fb_load_desc older;
  memset(&older, 0x5a, sizeof older);
  fb_load_desc_fill(&older, offsetof(fb_load_desc, allocator));
  assert_int_equal(older.struct_size, offsetof(fb_load_desc, allocator));
  assert_true(older.max_model_bytes == (uint64_t)4 << 30);
  const unsigned char* beyond = (const unsigned char*)&older.allocator;
  for (size_t i = 0; i < sizeof older - offsetof(fb_load_desc, allocator); ++i) assert_int_equal(beyond[i], 0x5a);

  struct {
    fb_batch_desc batch;
    uint64_t later;
  } newer;
  memset(&newer, 0x5a, sizeof newer);
  fb_batch_desc_fill(&newer.batch, sizeof newer);
  assert_int_equal(newer.batch.struct_size, sizeof newer);
  assert_true(newer.batch.poses == 0 && newer.later == 0);
}

static void statuses_have_names(void** state) {
  (void)state;
  assert_string_equal(fb_status_name(FB_OK), "FB_OK");
  assert_string_equal(fb_status_name(FB_ERROR_INVALID_ARGUMENT), "FB_ERROR_INVALID_ARGUMENT");
  assert_string_equal(fb_status_name(FB_ERROR_INTERNAL), "FB_ERROR_INTERNAL");
  for (fb_status status = 0; status <= FB_ERROR_INTERNAL; ++status)
    assert_memory_equal(fb_status_name(status), "FB_", 3);
  assert_string_equal(fb_status_name(-1), "unknown status");
  assert_string_equal(fb_status_name(FB_ERROR_INTERNAL + 1), "unknown status");
}

static void version_as_string_and_number_agree(void** state) {
  (void)state;
  const unsigned version = fb_version();
  unsigned parts[3];
  char* next = (char*)fb_version_string();
  for (int i = 0; i < 3; ++i) {
    parts[i] = (unsigned)strtoul(next, &next, 10);
    next += *next == '.';
  }
  assert_int_equal(*next, '\0');
  assert_int_equal(version, parts[0] * 1000000 + parts[1] * 1000 + parts[2]);
  assert_true(fb_format_version() > 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(layout_of_runtime_structs),
      cmocka_unit_test(layout_of_characters),
      cmocka_unit_test(layout_of_rigs),
      cmocka_unit_test(layout_of_sources),
      cmocka_unit_test(layout_of_requests),
      cmocka_unit_test(layout_of_results),
      cmocka_unit_test(init_functions_set_sizes_and_defaults),
      cmocka_unit_test(structs_of_other_headers_are_filled_to_their_size),
      cmocka_unit_test(statuses_have_names),
      cmocka_unit_test(version_as_string_and_number_agree),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
