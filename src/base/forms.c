/* SPDX-License-Identifier: MIT */
/* The forms of the structs of mlrt.h: see forms.h. */
#include "base/forms.h"

#define RULE(type, field, kind, most) #field, offsetof(type, field), most, MLRT_FIELD_##kind
#define END                           "", 0, 0, MLRT_FIELD_END

static const struct mlrt_field no_rules[] = {{END}};
static const struct mlrt_field host_rules[] = {{RULE(mlrt_host, reserved, COUNT, 0)}, {END}};
static const struct mlrt_field tree_options_rules[] = {
    {RULE(mlrt_tree_options, preset, INTEGER, MLRT_TREE_BEST)},
    {RULE(mlrt_tree_options, traversal_cost, COST, 1)},
    {RULE(mlrt_tree_options, intersection_cost, COST, 1)},
    {END},
};
static const struct mlrt_field load_options_rules[] = {
    {RULE(mlrt_load_options, flags, COUNT, MLRT_LOAD_IN_PLACE)},
    {END},
};
static const struct mlrt_field pool_options_rules[] = {
    {RULE(mlrt_pool_options, thread_count, COUNT, MLRT_THREAD_LIMIT)},
    {END},
};
static const struct mlrt_field counters_rules[] = {{RULE(mlrt_counters, reserved, COUNT, 0)}, {END}};
static const struct mlrt_field trace_options_rules[] = {
    {RULE(mlrt_trace_options, query, INTEGER, MLRT_QUERY_ANY)},
    {RULE(mlrt_trace_options, method, INTEGER, MLRT_METHOD_TILE)},
    {RULE(mlrt_trace_options, isa, INTEGER, MLRT_ISA_NEON)},
    {RULE(mlrt_trace_options, culling, INTEGER, MLRT_CULLING_DIRECT)},
    {RULE(mlrt_trace_options, culling_check, COUNT, 1)},
    {RULE(mlrt_trace_options, outputs, COUNT, 63)},
    {RULE(mlrt_trace_options, shortcuts_off, COUNT, 7)},
    {RULE(mlrt_trace_options, light_count, COUNT, MLRT_LIGHT_LIMIT)},
    {RULE(mlrt_trace_options, reserved, COUNT, 0)},
    {END},
};
static const struct mlrt_field hits_rules[] = {
    {RULE(mlrt_hits, reserved, COUNT, 0)},
    {RULE(mlrt_hits, t, OUTPUT, 4)},
    {RULE(mlrt_hits, u, OUTPUT, 4)},
    {RULE(mlrt_hits, v, OUTPUT, 4)},
    {RULE(mlrt_hits, mesh, OUTPUT, 4)},
    {RULE(mlrt_hits, triangle, OUTPUT, 4)},
    {RULE(mlrt_hits, facing, OUTPUT, 4)},
    {RULE(mlrt_hits, occluded, OUTPUT, 1)},
    {END},
};
static const struct mlrt_field rays_rules[] = {
    {RULE(mlrt_rays, reserved, COUNT, 0)},   {RULE(mlrt_rays, count, SIZE, 0)},  {RULE(mlrt_rays, origins, INPUT, 0)},
    {RULE(mlrt_rays, directions, INPUT, 0)}, {RULE(mlrt_rays, t_min, INPUT, 0)}, {RULE(mlrt_rays, t_max, INPUT, 0)},
    {RULE(mlrt_rays, skip, INPUT, 0)},       {RULE(mlrt_rays, mask, INPUT, 0)},  {END},
};
static const struct mlrt_field ray_rules[] = {{RULE(mlrt_ray, flags, COUNT, MLRT_RAY_SKIP)}, {END}};
static const struct mlrt_field hit_lists_rules[] = {
    {RULE(mlrt_hit_lists, t, OUTPUT, 4)},
    {RULE(mlrt_hit_lists, u, OUTPUT, 4)},
    {RULE(mlrt_hit_lists, v, OUTPUT, 4)},
    {RULE(mlrt_hit_lists, mesh, OUTPUT, 4)},
    {RULE(mlrt_hit_lists, triangle, OUTPUT, 4)},
    {RULE(mlrt_hit_lists, facing, OUTPUT, 4)},
    {RULE(mlrt_hit_lists, crossing, OUTPUT, 1)},
    {RULE(mlrt_hit_lists, total, OUTPUT, 4)},
    {RULE(mlrt_hit_lists, crossing_total, OUTPUT, 4)},
    {END},
};
static const struct mlrt_field camera_rules[] = {
    {RULE(mlrt_camera, projection, INTEGER, MLRT_PROJECTION_PARALLEL)},
    {END},
};
static const struct mlrt_field light_rules[] = {
    {RULE(mlrt_light, kind, INTEGER, MLRT_LIGHT_DIRECTIONAL)},
    {RULE(mlrt_light, position, FINITE, 3)},
    {END},
};
static const struct mlrt_field points_rules[] = {
    {RULE(mlrt_points, count, SIZE, 0)},
    {RULE(mlrt_points, positions, INPUT, 0)},
    {RULE(mlrt_points, skip, INPUT, 0)},
    {END},
};
static const struct mlrt_field kdtree_options_rules[] = {
    {RULE(mlrt_kdtree_options, preset, INTEGER, MLRT_KDTREE_TUNED)},
    {RULE(mlrt_kdtree_options, max_depth, COUNT, MLRT_DEPTH_LIMIT)},
    {RULE(mlrt_kdtree_options, rules_off, COUNT, 31)},
    {RULE(mlrt_kdtree_options, traversal_cost, COST, 1)},
    {RULE(mlrt_kdtree_options, intersection_cost, COST, 1)},
    {END},
};
static const struct mlrt_field direction_rules[] = {{RULE(mlrt_camera, direction, FINITE, 3)}, {END}};
static const struct mlrt_field view_rules[] = {
    {RULE(mlrt_camera, d00, FINITE, 3)},      {RULE(mlrt_camera, dx, FINITE, 3)},
    {RULE(mlrt_camera, dy, FINITE, 3)},       {RULE(mlrt_camera, sample_x, FINITE, 1)},
    {RULE(mlrt_camera, sample_y, FINITE, 1)}, {RULE(mlrt_camera, t_min, NUMBER, 1)},
    {RULE(mlrt_camera, t_max, NUMBER, 1)},    {END},
};
static const struct mlrt_field eye_rules[] = {{RULE(mlrt_camera, eye, FINITE, 3)}, {END}};
static const struct mlrt_field vectors_rules[] = {{"", 0, 12, MLRT_FIELD_OUTPUT}, {END}};
static const struct mlrt_field bytes_rules[] = {{"", 0, 1, MLRT_FIELD_OUTPUT}, {END}};
static const struct mlrt_field float_rules[] = {{"", 0, 1, MLRT_FIELD_FINITE}, {END}};

/* `last` is the last field that the shortest struct of the form must have. */
#define SIZES(type, last) offsetof(type, last) + sizeof(((type *)0)->last), sizeof(type), __alignof__(type)

const struct mlrt_form mlrt_forms[] = {
    [MLRT_STRUCT_HOST] = {SIZES(mlrt_host, progress), host_rules},
    [MLRT_STRUCT_MESH] = {SIZES(mlrt_mesh, mask), no_rules},
    [MLRT_STRUCT_TREE_OPTIONS] = {SIZES(mlrt_tree_options, pool), tree_options_rules},
    [MLRT_STRUCT_TREE_INFO] = {SIZES(mlrt_tree_info, reserved), no_rules},
    [MLRT_STRUCT_MEMORY_ESTIMATE] = {SIZES(mlrt_memory_estimate, peak_memory_size), no_rules},
    [MLRT_STRUCT_LOAD_OPTIONS] = {SIZES(mlrt_load_options, host), load_options_rules},
    [MLRT_STRUCT_POOL_OPTIONS] = {SIZES(mlrt_pool_options, finish), pool_options_rules},
    [MLRT_STRUCT_COUNTERS] = {SIZES(mlrt_counters, exact_order_count), counters_rules},
    [MLRT_STRUCT_TRACE_OPTIONS] = {SIZES(mlrt_trace_options, counters), trace_options_rules},
    [MLRT_STRUCT_ARRAY] = {SIZES(mlrt_array, row_stride), no_rules},
    [MLRT_STRUCT_HITS] = {SIZES(mlrt_hits, occluded), hits_rules},
    [MLRT_STRUCT_CONST_ARRAY] = {SIZES(mlrt_const_array, stride), no_rules},
    [MLRT_STRUCT_RAYS] = {SIZES(mlrt_rays, skip), rays_rules},
    [MLRT_STRUCT_RAY] = {SIZES(mlrt_ray, skip_triangle), ray_rules},
    [MLRT_STRUCT_HIT] = {SIZES(mlrt_hit, occluded), no_rules},
    [MLRT_STRUCT_HIT_LISTS] = {SIZES(mlrt_hit_lists, crossing_total), hit_lists_rules},
    [MLRT_STRUCT_CAMERA] = {SIZES(mlrt_camera, t_max), camera_rules},
    [MLRT_STRUCT_TILE] = {SIZES(mlrt_tile, occluded), no_rules},
    [MLRT_STRUCT_LIGHT] = {SIZES(mlrt_light, position), light_rules},
    [MLRT_STRUCT_POINTS] = {SIZES(mlrt_points, skip), points_rules},
    [MLRT_STRUCT_KDTREE_OPTIONS] = {SIZES(mlrt_kdtree_options, rules_off), kdtree_options_rules},
    [MLRT_FORM_FRAME] = {SIZES(mlrt_hits, occluded), hits_rules},
    [MLRT_FORM_DIRECTION] = {.rules = direction_rules},
    [MLRT_FORM_VIEW] = {.rules = view_rules},
    [MLRT_FORM_EYE] = {.rules = eye_rules},
    [MLRT_FORM_VECTORS] = {.rules = vectors_rules},
    [MLRT_FORM_BYTES] = {.rules = bytes_rules},
    [MLRT_FORM_FLOAT] = {.rules = float_rules},
};
