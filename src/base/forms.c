/* SPDX-License-Identifier: MIT */
/* The forms of the structs of mlrt.h: see forms.h. */
#include "base/forms.h"

#define RULE(form, type, field, kind, most) #field, offsetof(type, field), most, MLRT_FIELD_##kind, MLRT_##form

/* In the order of forms, with one of no form at the end. */
static const struct mlrt_field rules[] = {
    {RULE(STRUCT_HOST, mlrt_host, reserved, COUNT, 0)},
    {RULE(STRUCT_TREE_OPTIONS, mlrt_tree_options, preset, INTEGER, MLRT_TREE_BEST)},
    {RULE(STRUCT_TREE_OPTIONS, mlrt_tree_options, traversal_cost, COST, 1)},
    {RULE(STRUCT_TREE_OPTIONS, mlrt_tree_options, intersection_cost, COST, 1)},
    {RULE(STRUCT_LOAD_OPTIONS, mlrt_load_options, flags, COUNT, MLRT_LOAD_IN_PLACE)},
    {RULE(STRUCT_POOL_OPTIONS, mlrt_pool_options, thread_count, COUNT, MLRT_THREAD_LIMIT)},
    {RULE(STRUCT_COUNTERS, mlrt_counters, reserved, COUNT, 0)},
    {RULE(STRUCT_TRACE_OPTIONS, mlrt_trace_options, query, INTEGER, MLRT_QUERY_ANY)},
    {RULE(STRUCT_TRACE_OPTIONS, mlrt_trace_options, method, INTEGER, MLRT_METHOD_TILE)},
    {RULE(STRUCT_TRACE_OPTIONS, mlrt_trace_options, isa, INTEGER, MLRT_ISA_NEON)},
    {RULE(STRUCT_TRACE_OPTIONS, mlrt_trace_options, culling, INTEGER, MLRT_CULLING_DIRECT)},
    {RULE(STRUCT_TRACE_OPTIONS, mlrt_trace_options, culling_check, COUNT, 1)},
    {RULE(STRUCT_TRACE_OPTIONS, mlrt_trace_options, outputs, COUNT, 63)},
    {RULE(STRUCT_TRACE_OPTIONS, mlrt_trace_options, shortcuts_off, COUNT, 7)},
    {RULE(STRUCT_TRACE_OPTIONS, mlrt_trace_options, light_count, COUNT, MLRT_LIGHT_LIMIT)},
    {RULE(STRUCT_TRACE_OPTIONS, mlrt_trace_options, reserved, COUNT, 0)},
    {RULE(STRUCT_HITS, mlrt_hits, reserved, COUNT, 0)},
    {RULE(STRUCT_HITS, mlrt_hits, t, OUTPUT, 4)},
    {RULE(STRUCT_HITS, mlrt_hits, u, OUTPUT, 4)},
    {RULE(STRUCT_HITS, mlrt_hits, v, OUTPUT, 4)},
    {RULE(STRUCT_HITS, mlrt_hits, mesh, OUTPUT, 4)},
    {RULE(STRUCT_HITS, mlrt_hits, triangle, OUTPUT, 4)},
    {RULE(STRUCT_HITS, mlrt_hits, facing, OUTPUT, 4)},
    {RULE(STRUCT_HITS, mlrt_hits, occluded, OUTPUT, 1)},
    {RULE(STRUCT_RAYS, mlrt_rays, reserved, COUNT, 0)},
    {RULE(STRUCT_RAYS, mlrt_rays, count, SIZE, 0)},
    {RULE(STRUCT_RAYS, mlrt_rays, origins, INPUT, 0)},
    {RULE(STRUCT_RAYS, mlrt_rays, directions, INPUT, 0)},
    {RULE(STRUCT_RAYS, mlrt_rays, t_min, INPUT, 0)},
    {RULE(STRUCT_RAYS, mlrt_rays, t_max, INPUT, 0)},
    {RULE(STRUCT_RAYS, mlrt_rays, skip, INPUT, 0)},
    {RULE(STRUCT_RAYS, mlrt_rays, mask, INPUT, 0)},
    {RULE(STRUCT_RAY, mlrt_ray, flags, COUNT, MLRT_RAY_SKIP)},
    {RULE(STRUCT_HIT_LISTS, mlrt_hit_lists, t, OUTPUT, 4)},
    {RULE(STRUCT_HIT_LISTS, mlrt_hit_lists, u, OUTPUT, 4)},
    {RULE(STRUCT_HIT_LISTS, mlrt_hit_lists, v, OUTPUT, 4)},
    {RULE(STRUCT_HIT_LISTS, mlrt_hit_lists, mesh, OUTPUT, 4)},
    {RULE(STRUCT_HIT_LISTS, mlrt_hit_lists, triangle, OUTPUT, 4)},
    {RULE(STRUCT_HIT_LISTS, mlrt_hit_lists, facing, OUTPUT, 4)},
    {RULE(STRUCT_HIT_LISTS, mlrt_hit_lists, crossing, OUTPUT, 1)},
    {RULE(STRUCT_HIT_LISTS, mlrt_hit_lists, total, OUTPUT, 4)},
    {RULE(STRUCT_HIT_LISTS, mlrt_hit_lists, crossing_total, OUTPUT, 4)},
    {RULE(STRUCT_CAMERA, mlrt_camera, projection, INTEGER, MLRT_PROJECTION_PARALLEL)},
    {RULE(STRUCT_LIGHT, mlrt_light, kind, INTEGER, MLRT_LIGHT_DIRECTIONAL)},
    {RULE(STRUCT_LIGHT, mlrt_light, position, FINITE, 3)},
    {RULE(STRUCT_POINTS, mlrt_points, count, SIZE, 0)},
    {RULE(STRUCT_POINTS, mlrt_points, positions, INPUT, 0)},
    {RULE(STRUCT_POINTS, mlrt_points, skip, INPUT, 0)},
    {RULE(STRUCT_KDTREE_OPTIONS, mlrt_kdtree_options, preset, INTEGER, MLRT_KDTREE_TUNED)},
    {RULE(STRUCT_KDTREE_OPTIONS, mlrt_kdtree_options, max_depth, COUNT, MLRT_DEPTH_LIMIT)},
    {RULE(STRUCT_KDTREE_OPTIONS, mlrt_kdtree_options, rules_off, COUNT, 31)},
    {RULE(STRUCT_KDTREE_OPTIONS, mlrt_kdtree_options, traversal_cost, COST, 1)},
    {RULE(STRUCT_KDTREE_OPTIONS, mlrt_kdtree_options, intersection_cost, COST, 1)},
    {RULE(FORM_DIRECTION, mlrt_camera, direction, FINITE, 3)},
    {RULE(FORM_VIEW, mlrt_camera, d00, FINITE, 3)},
    {RULE(FORM_VIEW, mlrt_camera, dx, FINITE, 3)},
    {RULE(FORM_VIEW, mlrt_camera, dy, FINITE, 3)},
    {RULE(FORM_VIEW, mlrt_camera, sample_x, FINITE, 1)},
    {RULE(FORM_VIEW, mlrt_camera, sample_y, FINITE, 1)},
    {RULE(FORM_VIEW, mlrt_camera, t_min, NUMBER, 1)},
    {RULE(FORM_VIEW, mlrt_camera, t_max, NUMBER, 1)},
    {RULE(FORM_EYE, mlrt_camera, eye, FINITE, 3)},
    {"", 0, 12, MLRT_FIELD_OUTPUT, MLRT_FORM_VECTORS},
    {"", 0, 1, MLRT_FIELD_OUTPUT, MLRT_FORM_BYTES},
    {"", 0, 1, MLRT_FIELD_FINITE, MLRT_FORM_FLOAT},
    {"", 0, 0, 0, MLRT_FORM_COUNT},
};

const struct mlrt_field *mlrt_rules_of(int form)
{
    const struct mlrt_field *rule = rules;
    while (rule->form < form) ++rule;
    return rule;
}

/* `last` is the last field that the shortest struct of the form must have. */
#define SIZES(type, last) offsetof(type, last) + sizeof(((type *)0)->last), sizeof(type), __alignof__(type)

const struct mlrt_form mlrt_forms[] = {
    [MLRT_STRUCT_HOST] = {SIZES(mlrt_host, progress)},
    [MLRT_STRUCT_MESH] = {SIZES(mlrt_mesh, mask)},
    [MLRT_STRUCT_TREE_OPTIONS] = {SIZES(mlrt_tree_options, pool)},
    [MLRT_STRUCT_TREE_INFO] = {SIZES(mlrt_tree_info, reserved)},
    [MLRT_STRUCT_MEMORY_ESTIMATE] = {SIZES(mlrt_memory_estimate, peak_memory_size)},
    [MLRT_STRUCT_LOAD_OPTIONS] = {SIZES(mlrt_load_options, host)},
    [MLRT_STRUCT_POOL_OPTIONS] = {SIZES(mlrt_pool_options, finish)},
    [MLRT_STRUCT_COUNTERS] = {SIZES(mlrt_counters, exact_order_count)},
    [MLRT_STRUCT_TRACE_OPTIONS] = {SIZES(mlrt_trace_options, counters)},
    [MLRT_STRUCT_ARRAY] = {SIZES(mlrt_array, row_stride)},
    [MLRT_STRUCT_HITS] = {SIZES(mlrt_hits, occluded)},
    [MLRT_STRUCT_CONST_ARRAY] = {SIZES(mlrt_const_array, stride)},
    [MLRT_STRUCT_RAYS] = {SIZES(mlrt_rays, skip)},
    [MLRT_STRUCT_RAY] = {SIZES(mlrt_ray, skip_triangle)},
    [MLRT_STRUCT_HIT] = {SIZES(mlrt_hit, occluded)},
    [MLRT_STRUCT_HIT_LISTS] = {SIZES(mlrt_hit_lists, crossing_total)},
    [MLRT_STRUCT_CAMERA] = {SIZES(mlrt_camera, t_max)},
    [MLRT_STRUCT_TILE] = {SIZES(mlrt_tile, occluded)},
    [MLRT_STRUCT_LIGHT] = {SIZES(mlrt_light, position)},
    [MLRT_STRUCT_POINTS] = {SIZES(mlrt_points, skip)},
    [MLRT_STRUCT_KDTREE_OPTIONS] = {SIZES(mlrt_kdtree_options, rules_off)},
    [MLRT_FORM_FRAME] = {SIZES(mlrt_hits, occluded)},
};
