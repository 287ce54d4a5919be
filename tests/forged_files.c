/* SPDX-License-Identifier: MIT */
/*
 * Files of saved trees that someone made to look whole: see forged_files.h.
 */
#define _POSIX_C_SOURCE 200809L
#include "forged_files.h"

#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "support.h"

unsigned char *allocate_file(size_t size, void **block)
{
    const size_t room = size > 0 ? (size + 63) / 64 * 64 : 64;
    assert_int_equal(posix_memalign(block, 64, room), 0);
    return (unsigned char *)*block + (room - size);
}

void repair_hash(unsigned char *data, size_t size)
{
    struct mlrt_hash hash;
    memset(data + FILE_HASH, 0, 8);
    mlrt_start_hash(&hash);
    mlrt_add_words(&hash, data, size / 4);
    const uint64_t value = mlrt_finish_hash(&hash);
    memcpy(data + FILE_HASH, &value, 8);
}

enum { SIDE = 20, RAYS = SIDE * SIDE, LIST = 4 };

struct results {
    struct reference_hit hits[RAYS];
    uint8_t occluded[RAYS];
};

static mlrt_hits closest_hits(struct results *results)
{
    return public_hits(results->hits, 0);
}

static mlrt_hits any_hits(struct results *results)
{
    return (mlrt_hits){.struct_size = sizeof(mlrt_hits), .occluded = {results->occluded, 0, 0}};
}

static void assert_traced(int32_t status)
{
    assert_true(status == MLRT_OK || status == MLRT_ERROR_UNSUPPORTED || status == MLRT_ERROR_CAMERA);
}

/* Of the methods that the tree has. */
static mlrt_trace_options draw_options(struct random *random, const mlrt_tree_info *info)
{
    static const int32_t of_boxes[3] = {MLRT_METHOD_DEFAULT, MLRT_METHOD_RAY, MLRT_METHOD_TILE};
    const int is_bvh = info->structure == MLRT_STRUCTURE_BVH;
    return (mlrt_trace_options){.struct_size = sizeof(mlrt_trace_options),
                                .query = draw_below(random, 3) == 0 ? MLRT_QUERY_ANY : MLRT_QUERY_CLOSEST,
                                .method = is_bvh ? of_boxes[draw_below(random, 3)] : (int32_t)draw_below(random, 5),
                                .isa = (int32_t)draw_below(random, 5),
                                .culling = (int32_t)draw_below(random, 2),
                                .culling_check = draw_below(random, 2),
                                .shortcuts_off = draw_below(random, 8)};
}

/* A place in the bounds, or around them. */
static void draw_place(struct random *random, const mlrt_tree_info *info, float point[3])
{
    const float around = draw_below(random, 2) ? 1 : 0;
    for (int k = 0; k < 3; k++) {
        const float lo = info->bounds_min[k], hi = info->bounds_max[k], f = draw_range(random, -around, 1 + around);
        point[k] = lo * (1 - f) + hi * f;
    }
}

static void trace_arrays(const mlrt_tree *tree, const mlrt_tree_info *info, struct random *random,
                         struct results *results)
{
    float origins[RAYS][3], directions[RAYS][3], apex[3];
    const uint32_t skip[2] = {0, draw_below(random, 8)};
    const int has_apex = (int)draw_below(random, 2);
    draw_place(random, info, apex);
    for (int i = 0; i < RAYS; i++) {
        float target[3];
        draw_place(random, info, origins[i]);
        draw_place(random, info, target);
        if (has_apex) memcpy(origins[i], apex, sizeof apex);
        for (int k = 0; k < 3; k++) directions[i][k] = target[k] - origins[i][k];
    }
    mlrt_trace_options options = draw_options(random, info);
    const mlrt_rays rays = {.struct_size = sizeof rays,
                            .row_length = draw_below(random, 2) ? SIDE : 0,
                            .count = RAYS,
                            .origins = {origins, 0},
                            .directions = {directions, 0}};
    const mlrt_hits hits = options.query == MLRT_QUERY_ANY ? any_hits(results) : closest_hits(results);
    assert_traced(mlrt_trace_packet(tree, &rays, &options, &hits));

    uint32_t total[RAYS], triangle[RAYS * LIST];
    const mlrt_hit_lists lists = {
        .struct_size = sizeof lists, .capacity = LIST, .triangle = {triangle, 0, 0}, .total = {total, 0, 0}};
    mlrt_rays some = rays;
    some.count = 40;
    assert_traced(mlrt_trace_all_hits(tree, &some, NULL, &lists));

    mlrt_light light = {.struct_size = sizeof light, .kind = (int32_t)draw_below(random, 2)};
    memcpy(light.position, apex, sizeof apex);
    const mlrt_points points = {.struct_size = sizeof points,
                                .count = RAYS,
                                .positions = {origins, 0},
                                .skip = {draw_below(random, 2) ? skip : NULL, 0}};
    const mlrt_array occluded = {results->occluded, 0, 0};
    mlrt_points lone = points;
    if (points.skip.data) lone.count = 1;
    options.query = MLRT_QUERY_CLOSEST;
    assert_traced(mlrt_occluded_points(tree, &lone, &light, &options, &occluded));

    for (int i = 0; i < 8; i++) {
        mlrt_ray ray = {.struct_size = sizeof ray, .flags = MLRT_RAY_SKIP, .skip_triangle = (uint32_t)i};
        mlrt_hit hit = {.struct_size = sizeof hit};
        memcpy(ray.origin, origins[i], sizeof ray.origin);
        memcpy(ray.direction, directions[i], sizeof ray.direction);
        if (i % 2) ray.flags = 0;
        assert_traced(mlrt_trace_ray(tree, &ray, NULL, &hit));
        if (hit.triangle != MLRT_NONE) {
            float point[3];
            mlrt_offset_point(tree, hit.mesh, hit.triangle, 0.25f, 0.25f, 1, point);
        }
    }
}

static void trace_picture(const mlrt_tree *tree, const mlrt_tree_info *info, struct random *random,
                          struct results *results)
{
    float eye[3], target[3];
    draw_place(random, info, eye);
    draw_place(random, info, target);
    if (memcmp(eye, target, sizeof eye) == 0) eye[2] -= 1;
    const mlrt_camera camera = look_at(eye, target, draw_below(random, 2) ? 1 : 0.01f, SIDE, SIDE);
    const mlrt_trace_options options = draw_options(random, info);
    const mlrt_hits hits = options.query == MLRT_QUERY_ANY ? any_hits(results) : closest_hits(results);
    assert_traced(mlrt_render_tiles(tree, &camera, &options, &hits, NULL, NULL));
}

void exercise_tree(const mlrt_tree *tree, uint64_t seed)
{
    struct random random = {seed};
    struct results *results = allocate_or_fail(1, sizeof *results);
    mlrt_tree_info info = {.struct_size = sizeof info};
    assert_int_equal(mlrt_get_tree_info(tree, &info), MLRT_OK);
    for (int i = 0; i < 2; i++) {
        trace_arrays(tree, &info, &random, results);
        trace_picture(tree, &info, &random, results);
    }
    free(results);
}

int load_and_exercise(const unsigned char *data, size_t size, int in_place, uint64_t seed)
{
    const mlrt_load_options options = {.struct_size = sizeof options, .flags = in_place ? MLRT_LOAD_IN_PLACE : 0};
    mlrt_tree *tree = (mlrt_tree *)(uintptr_t)16;
    const int32_t status = mlrt_load_tree(data, size, &options, &tree);
    if (status != MLRT_OK) {
        assert_true(status == MLRT_ERROR_DATA);
        assert_null(tree);
        return 0;
    }
    exercise_tree(tree, seed);
    mlrt_destroy_tree(tree);
    return 1;
}
