/* SPDX-License-Identifier: MIT */
/* The forms of the structs of mlrt.h: see forms.h. */
#include "base/forms.h"

/* Bytes up to the end of a field: the size of the struct in a version whose last field it was. */
#define BYTES_UP_TO(type, field) (offsetof(type, field) + sizeof(((type *)0)->field))

#define FIELD_RULE(type, field, kind, most) #field, offsetof(type, field), most, MLRT_FIELD_##kind

const struct mlrt_rules mlrt_rules = {
    .options.host = {{FIELD_RULE(mlrt_host, reserved, COUNT, 0)}},
    .options.pool = {{FIELD_RULE(mlrt_pool_options, thread_count, COUNT, MLRT_THREAD_LIMIT)}},
    .options.tree = {{FIELD_RULE(mlrt_tree_options, preset, INTEGER, MLRT_TREE_BEST)},
                     {FIELD_RULE(mlrt_tree_options, traversal_cost, COST, 1)},
                     {FIELD_RULE(mlrt_tree_options, intersection_cost, COST, 1)}},
    .options.kdtree = {{FIELD_RULE(mlrt_kdtree_options, preset, INTEGER, MLRT_KDTREE_TUNED)},
                       {FIELD_RULE(mlrt_kdtree_options, max_depth, COUNT, MLRT_DEPTH_LIMIT)},
                       {FIELD_RULE(mlrt_kdtree_options, rules_off, COUNT, 31)},
                       {FIELD_RULE(mlrt_kdtree_options, traversal_cost, COST, 1)},
                       {FIELD_RULE(mlrt_kdtree_options, intersection_cost, COST, 1)}},
    .options.load = {{FIELD_RULE(mlrt_load_options, flags, COUNT, MLRT_LOAD_IN_PLACE)}},
    .options.trace = {{FIELD_RULE(mlrt_trace_options, query, INTEGER, MLRT_QUERY_ANY)},
                      {FIELD_RULE(mlrt_trace_options, method, INTEGER, MLRT_METHOD_TILE)},
                      {FIELD_RULE(mlrt_trace_options, isa, INTEGER, MLRT_ISA_NEON)},
                      {FIELD_RULE(mlrt_trace_options, culling, INTEGER, MLRT_CULLING_DIRECT)},
                      {FIELD_RULE(mlrt_trace_options, culling_check, COUNT, 1)},
                      {FIELD_RULE(mlrt_trace_options, outputs, COUNT, 63)},
                      {FIELD_RULE(mlrt_trace_options, shortcuts_off, COUNT, 7)},
                      {FIELD_RULE(mlrt_trace_options, light_count, COUNT, MLRT_LIGHT_LIMIT)},
                      {FIELD_RULE(mlrt_trace_options, reserved, COUNT, 0)}},
    .options.counters = {{FIELD_RULE(mlrt_counters, reserved, COUNT, 0)}},
    .rays.ray = {{FIELD_RULE(mlrt_ray, flags, COUNT, MLRT_RAY_SKIP)}},
    .rays.rays = {{FIELD_RULE(mlrt_rays, reserved, COUNT, 0)},
                  {FIELD_RULE(mlrt_rays, count, SIZE, 0)},
                  {FIELD_RULE(mlrt_rays, origins, INPUT, 0)},
                  {FIELD_RULE(mlrt_rays, directions, INPUT, 0)},
                  {FIELD_RULE(mlrt_rays, t_min, INPUT, 0)},
                  {FIELD_RULE(mlrt_rays, t_max, INPUT, 0)},
                  {FIELD_RULE(mlrt_rays, skip, INPUT, 0)},
                  {FIELD_RULE(mlrt_rays, mask, INPUT, 0)}},
    .rays.points = {{FIELD_RULE(mlrt_points, count, SIZE, 0)},
                    {FIELD_RULE(mlrt_points, positions, INPUT, 0)},
                    {FIELD_RULE(mlrt_points, skip, INPUT, 0)}},
    .rays.light = {{FIELD_RULE(mlrt_light, kind, INTEGER, MLRT_LIGHT_DIRECTIONAL)},
                   {FIELD_RULE(mlrt_light, position, FINITE, 3)}},
    .results.hits = {{FIELD_RULE(mlrt_hits, reserved, COUNT, 0)},
                     {FIELD_RULE(mlrt_hits, t, OUTPUT, 4)},
                     {FIELD_RULE(mlrt_hits, u, OUTPUT, 4)},
                     {FIELD_RULE(mlrt_hits, v, OUTPUT, 4)},
                     {FIELD_RULE(mlrt_hits, mesh, OUTPUT, 4)},
                     {FIELD_RULE(mlrt_hits, triangle, OUTPUT, 4)},
                     {FIELD_RULE(mlrt_hits, facing, OUTPUT, 4)},
                     {FIELD_RULE(mlrt_hits, occluded, OUTPUT, 1)}},
    .results.hit_lists = {{FIELD_RULE(mlrt_hit_lists, t, OUTPUT, 4)},
                          {FIELD_RULE(mlrt_hit_lists, u, OUTPUT, 4)},
                          {FIELD_RULE(mlrt_hit_lists, v, OUTPUT, 4)},
                          {FIELD_RULE(mlrt_hit_lists, mesh, OUTPUT, 4)},
                          {FIELD_RULE(mlrt_hit_lists, triangle, OUTPUT, 4)},
                          {FIELD_RULE(mlrt_hit_lists, facing, OUTPUT, 4)},
                          {FIELD_RULE(mlrt_hit_lists, crossing, OUTPUT, 1)},
                          {FIELD_RULE(mlrt_hit_lists, total, OUTPUT, 4)},
                          {FIELD_RULE(mlrt_hit_lists, crossing_total, OUTPUT, 4)}},
    .rays.camera = {{FIELD_RULE(mlrt_camera, projection, INTEGER, MLRT_PROJECTION_PARALLEL)}},
    .rays.view = {{FIELD_RULE(mlrt_camera, direction, FINITE, 3)}, /* of parallel cameras, which have no eye */
                  {FIELD_RULE(mlrt_camera, d00, FINITE, 3)},
                  {FIELD_RULE(mlrt_camera, dx, FINITE, 3)},
                  {FIELD_RULE(mlrt_camera, dy, FINITE, 3)},
                  {FIELD_RULE(mlrt_camera, sample_x, FINITE, 1)},
                  {FIELD_RULE(mlrt_camera, sample_y, FINITE, 1)},
                  {FIELD_RULE(mlrt_camera, t_min, NUMBER, 1)},
                  {FIELD_RULE(mlrt_camera, t_max, NUMBER, 1)},
                  {FIELD_RULE(mlrt_camera, eye, FINITE, 3)}}, /* of pinhole cameras, which have no direction */
    .arguments.vectors = {{"", 0, 12, MLRT_FIELD_OUTPUT}},
    .arguments.bytes = {{"", 0, 1, MLRT_FIELD_OUTPUT}},
    .arguments.number = {{"", 0, 1, MLRT_FIELD_FINITE}},
};

/* `last` is the last field that the shortest struct of the form must have. */
#define RULE_NUMBER(table) offsetof(struct mlrt_rules, table) / sizeof(struct mlrt_field)
#define RULE_COUNT(table)  sizeof mlrt_rules.table / sizeof *mlrt_rules.table
#define FORM_OF(type, last, table, status, has_rows)                                                                   \
    BYTES_UP_TO(type, last), sizeof(type), __alignof__(type), RULE_NUMBER(table), RULE_COUNT(table), status, has_rows
#define CHECKED_FORM(type, last, table) FORM_OF(type, last, table, MLRT_ERROR_ARGUMENT, 0)
#define PLAIN_FORM(type, last)          BYTES_UP_TO(type, last), sizeof(type), __alignof__(type), 0, 0, 0, 0
#define CAMERA_FORM(first)                                                                                             \
    BYTES_UP_TO(mlrt_camera, t_max), sizeof(mlrt_camera), __alignof__(mlrt_camera), RULE_NUMBER(rays.view) + first,    \
        RULE_COUNT(rays.view) - 1, MLRT_ERROR_CAMERA, 0

const struct mlrt_form mlrt_forms[MLRT_FORM_COUNT] = {
    [MLRT_STRUCT_HOST] = {CHECKED_FORM(mlrt_host, progress, options.host)},
    [MLRT_STRUCT_MESH] = {PLAIN_FORM(mlrt_mesh, mask)},
    [MLRT_STRUCT_TREE_OPTIONS] = {CHECKED_FORM(mlrt_tree_options, pool, options.tree)},
    [MLRT_STRUCT_TREE_INFO] = {PLAIN_FORM(mlrt_tree_info, reserved)},
    [MLRT_STRUCT_MEMORY_ESTIMATE] = {PLAIN_FORM(mlrt_memory_estimate, peak_memory_size)},
    [MLRT_STRUCT_LOAD_OPTIONS] = {CHECKED_FORM(mlrt_load_options, host, options.load)},
    [MLRT_STRUCT_POOL_OPTIONS] = {CHECKED_FORM(mlrt_pool_options, finish, options.pool)},
    [MLRT_STRUCT_COUNTERS] = {CHECKED_FORM(mlrt_counters, exact_order_count, options.counters)},
    [MLRT_STRUCT_TRACE_OPTIONS] = {CHECKED_FORM(mlrt_trace_options, counters, options.trace)},
    [MLRT_STRUCT_ARRAY] = {PLAIN_FORM(mlrt_array, row_stride)},
    [MLRT_STRUCT_HITS] = {CHECKED_FORM(mlrt_hits, occluded, results.hits)},
    [MLRT_STRUCT_CONST_ARRAY] = {PLAIN_FORM(mlrt_const_array, stride)},
    [MLRT_STRUCT_RAYS] = {CHECKED_FORM(mlrt_rays, skip, rays.rays)},
    [MLRT_STRUCT_RAY] = {CHECKED_FORM(mlrt_ray, skip_triangle, rays.ray)},
    [MLRT_STRUCT_HIT] = {PLAIN_FORM(mlrt_hit, occluded)},
    [MLRT_STRUCT_HIT_LISTS] = {CHECKED_FORM(mlrt_hit_lists, crossing_total, results.hit_lists)},
    [MLRT_STRUCT_CAMERA] = {CHECKED_FORM(mlrt_camera, t_max, rays.camera)},
    [MLRT_STRUCT_TILE] = {PLAIN_FORM(mlrt_tile, occluded)},
    [MLRT_STRUCT_LIGHT] = {CHECKED_FORM(mlrt_light, position, rays.light)},
    [MLRT_STRUCT_POINTS] = {CHECKED_FORM(mlrt_points, skip, rays.points)},
    [MLRT_STRUCT_KDTREE_OPTIONS] = {CHECKED_FORM(mlrt_kdtree_options, rules_off, options.kdtree)},
    [MLRT_FORM_FRAME] = {FORM_OF(mlrt_hits, occluded, results.hits, MLRT_ERROR_ARGUMENT, 1)},
    [MLRT_FORM_PARALLEL] = {CAMERA_FORM(0)},
    [MLRT_FORM_PINHOLE] = {CAMERA_FORM(1)},
    [MLRT_FORM_VECTORS] = {FORM_OF(mlrt_array, row_stride, arguments.vectors, MLRT_ERROR_ARGUMENT, 1)},
    [MLRT_FORM_BYTES] = {CHECKED_FORM(mlrt_array, row_stride, arguments.bytes)},
    [MLRT_FORM_FLOAT] = {sizeof(float), sizeof(float), sizeof(float), RULE_NUMBER(arguments.number), 1,
                         MLRT_ERROR_ARGUMENT, 0},
};
