/* SPDX-License-Identifier: MIT */
/*
 * Rays of one origin, or one direction, in packed arrays without limits, which are read in one go (read_arrays.h): with
 * a ray here and there that does not belong, of which the others of its block must not notice anything. And what is
 * kept of the triangles that they hit (hit_terms.h), where places are taken and origins change.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "run/dispatch.h"
#include "job/job.h"
#include "rays/source.h"
#include "support.h"
#include "read/read.h"
#include "trace/ray_tile.h"
#include "scene/masks.h"

enum { WIDTH = 23, HEIGHT = 21, COUNT = WIDTH * HEIGHT };

static const uint32_t ROW_LENGTHS[] = {WIDTH, 0, 16, 32, 5, 100};

struct packed {
    float (*origins)[3];
    float (*directions)[3];
    uint32_t (*skip)[2];
    float (*points)[3]; /* of a point light */
};

static struct packed pack(const struct ray_list *list)
{
    struct packed packed = {allocate_guarded(list->count * 12), allocate_guarded(list->count * 12),
                            allocate_guarded(list->count * 8), allocate_guarded(list->count * 12)};
    for (size_t i = 0; i < list->count; i++) {
        memcpy(packed.origins[i], list->rays[i].origin, 12);
        memcpy(packed.directions[i], list->rays[i].direction, 12);
        memcpy(packed.skip[i], list->rays[i].skip, 8);
    }
    return packed;
}

static void free_packed(struct packed *packed, size_t count)
{
    free_guarded(packed->origins, count * 12);
    free_guarded(packed->directions, count * 12);
    free_guarded(packed->skip, count * 8);
    free_guarded(packed->points, count * 12);
}

static void check_hits(const struct fixture *fixture, const struct ray_list *list, int has_skips)
{
    struct reference_hit *expected = allocate_or_fail(list->count, sizeof *expected);
    struct reference_hit *got = allocate_or_fail(list->count, sizeof *got);
    uint8_t *occluded = allocate_or_fail(list->count, 1);
    struct packed packed = pack(list);
    trace_reference(fixture, list, expected);
    mlrt_rays rays = {.struct_size = sizeof rays,
                      .count = list->count,
                      .origins = {packed.origins, 0},
                      .directions = {packed.directions, 0}};
    if (has_skips) rays.skip.data = packed.skip;
    for (size_t v = first_variant(); v < variant_count() * (sizeof ROW_LENGTHS / sizeof ROW_LENGTHS[0]);
         v += variant_step()) {
        const struct variant *variant = variant_at(v % variant_count());
        const mlrt_tree *tree = variant_tree(variant, fixture);
        mlrt_trace_options options = variant->options;
        mlrt_hits hits = public_hits(got, 0);
        rays.row_length = ROW_LENGTHS[v / variant_count()];
        if (!variant->probe) continue;
        memset(got, 0x77, list->count * sizeof *got);
        assert_int_equal(mlrt_trace_packet(tree, &rays, &options, &hits), MLRT_OK);
        hits = (mlrt_hits){.struct_size = sizeof hits, .occluded = {occluded, 0, 0}};
        options.query = MLRT_QUERY_ANY;
        assert_int_equal(mlrt_trace_packet(tree, &rays, &options, &hits), MLRT_OK);
        for (size_t i = 0; i < list->count; i++) {
            check_hit(fixture, "packed rays", i, &list->rays[i], &expected[i], &got[i]);
            assert_int_equal(occluded[i], expected[i].mesh != MLRT_NONE);
        }
    }
    free_packed(&packed, list->count);
    free(occluded);
    free(got);
    free(expected);
}

/* A number that float arithmetic carries with care, or not at all. */
static float draw_odd(struct random *random, float from)
{
    const float odd[] = {from,     next_float(from, 1), -from,   0.0f,     -0.0f,     0x1p-60f,
                         0x1p60f,  0x1.8p-61f,          0x1p61f, -0x1p70f, 0x1p-140f, -0x1p-80f,
                         INFINITY, -INFINITY,           NAN,     1.5f};
    return odd[draw_below(random, sizeof odd / sizeof odd[0])];
}

/* Changes one number of a ray, all of its direction, or its origin. */
static void spoil_ray(struct reference_ray *ray, struct random *random)
{
    float *origin = ray->origin, *direction = ray->direction;
    const uint32_t k = draw_below(random, 3);
    switch (draw_below(random, 5)) {
    case 0:
        origin[k] = draw_odd(random, origin[k]);
        break;
    case 1:
        direction[k] = draw_odd(random, direction[k]);
        break;
    case 2:
        draw_point(random, -3, 3, origin);
        break;
    case 3:
        memset(direction, 0, 3 * sizeof *direction);
        break;
    default:
        for (int j = 0; j < 3; j++) direction[j] = draw_odd(random, 0);
    }
}

/* One in `rarity`. */
static void spoil(struct ray_list *list, struct random *random, uint32_t rarity)
{
    for (size_t i = 0; i < list->count; i++) {
        if (!draw_below(random, rarity)) spoil_ray(&list->rays[i], random);
    }
}

static struct fixture make_scene(uint64_t seed)
{
    struct soup soup = {0};
    struct random random = {seed};
    soup_add_torus(&soup, 24, 12, 1, 0.4f);
    soup_add_random(&soup, &random, 60, 1.5f, 0.7f);
    return fixture_of_soup("torus and triangles", seed, &soup);
}

static void add_view(struct ray_list *list, const float eye[3], float field)
{
    const float target[3] = {0.1f, 0, 0};
    const mlrt_camera camera = look_at(eye, target, field, WIDTH, HEIGHT);
    add_camera_rays(list, &camera);
}

/* Rays of one direction from a grid of points around the scene, on the side that they come from. */
static void add_parallel_view(struct ray_list *list, const float direction[3])
{
    const float eye[3] = {0, 0, 0};
    const mlrt_camera camera = look_at(eye, direction, 1, WIDTH, HEIGHT);
    for (int i = 0; i < COUNT; i++) {
        float origin[3];
        const float across = (float)(i % WIDTH) - 0.5f * WIDTH, down = (float)(i / WIDTH) - 0.5f * HEIGHT;
        for (int k = 0; k < 3; k++) origin[k] = 3 * (across * camera.dx[k] + down * camera.dy[k]) - 2 * direction[k];
        add_ray(list, origin, direction);
    }
}

static const float DIRECTIONS[][3] = {{0.25f, 1, -0.5f}, {0, 0, -1}, {-0.0f, 1.5f, 0.75f}, {-0x1p-50f, 0x1p-51f, 0}};

enum { DIRECTION_COUNT = sizeof DIRECTIONS / sizeof DIRECTIONS[0] };

static void add_skips(const struct fixture *fixture, struct random *random, struct ray_list *list)
{
    for (size_t i = 0; i < list->count; i++) {
        struct reference_hit hit;
        reference_trace(fixture->reference, &list->rays[i], &hit);
        list->rays[i].skip[0] = draw_below(random, 4) ? hit.mesh : MLRT_NONE;
        list->rays[i].skip[1] = hit.triangle + (draw_below(random, 8) == 0);
    }
}

static void some_rays_do_not_belong(void **state)
{
    (void)state;
    static const float eyes[][3] = {{0.1f, -3, 0.7f}, {0, 0, 0}, {-0.0f, 2, 0}};
    static const uint32_t rarities[] = {200, 24, 5};
    for (size_t e = 0; e < sizeof eyes / sizeof eyes[0]; e++) {
        struct fixture fixture = make_scene(2100 + e);
        for (size_t r = 0; r < sizeof rarities / sizeof rarities[0]; r++) {
            struct random random = {2110 + 10 * e + r};
            struct ray_list list = {0};
            add_view(&list, eyes[e], 0.9f);
            spoil(&list, &random, rarities[r]);
            check_hits(&fixture, &list, 0);
            add_skips(&fixture, &random, &list);
            check_hits(&fixture, &list, 1);
            free_rays(&list);
        }
        free_fixture(&fixture);
    }
}

static void some_are_not_parallel(void **state)
{
    (void)state;
    static const uint32_t rarities[] = {300, 40, 6};
    struct fixture fixture = make_scene(2140);
    for (int d = 0; d < DIRECTION_COUNT; d++) {
        for (size_t r = 0; r < sizeof rarities / sizeof rarities[0]; r++) {
            struct random random = {2141 + 10 * (uint64_t)d + r};
            struct ray_list list = {0};
            add_parallel_view(&list, DIRECTIONS[d]);
            spoil(&list, &random, rarities[r]);
            check_hits(&fixture, &list, 0);
            add_skips(&fixture, &random, &list);
            check_hits(&fixture, &list, 1);
            free_rays(&list);
        }
    }
    free_fixture(&fixture);
}

/* All rays have the same odd number in their origins, or, if they are parallel, in their directions, so that blocks
 * agree about one that float cannot carry, or that no ray has. */
static void check_odd_views(uint64_t seed, int is_parallel)
{
    static const float eye[3] = {0.1f, -3, 0.7f};
    struct random random = {seed};
    struct fixture fixture = make_scene(seed + 1);
    for (size_t i = 0; i < scaled(14); i++) {
        struct ray_list list = {0};
        if (is_parallel) {
            add_parallel_view(&list, DIRECTIONS[0]);
        } else {
            add_view(&list, eye, 0.9f);
        }
        const uint32_t k = draw_below(&random, 3);
        const float odd = draw_odd(&random, (is_parallel ? DIRECTIONS[0] : eye)[k]);
        const float others = is_parallel && draw_below(&random, 2) == 0 ? 0.0f : 1.0f;
        for (size_t j = 0; j < list.count; j++) {
            float *numbers = is_parallel ? list.rays[j].direction : list.rays[j].origin;
            for (int l = 0; l < 3; l++) numbers[l] *= others;
            numbers[k] = odd;
        }
        check_hits(&fixture, &list, 0);
        free_rays(&list);
    }
    free_fixture(&fixture);
}

static void directions_that_are_none(void **state)
{
    (void)state;
    check_odd_views(2190, 1);
}

static void origins_that_are_no_places(void **state)
{
    (void)state;
    check_odd_views(2150, 0);
}

static void points_of_a_light(void **state)
{
    (void)state;
    struct fixture fixture = make_scene(2160);
    static const float lights[][3] = {{0.125f, -3, 0.75f}, {0, 0, 0}, {0x1p70f, 0, 0}, {0, 0x1p-80f, 2}};
    for (size_t l = 0; l < 2 * sizeof lights / sizeof lights[0]; l++) {
        struct random random = {2170 + l};
        mlrt_light light = {.struct_size = sizeof light, .kind = l % 2 ? MLRT_LIGHT_DIRECTIONAL : MLRT_LIGHT_POINT};
        memcpy(light.position, lights[l / 2], sizeof light.position);
        float positions[COUNT][3];
        uint32_t skip[COUNT][2];
        for (int i = 0; i < COUNT; i++) {
            positions[i][0] = -1.5f + 3 * (float)(i % WIDTH) / WIDTH;
            positions[i][1] = 0.4f;
            positions[i][2] = -1.5f + 3 * (float)(i / WIDTH) / HEIGHT;
            if (draw_below(&random, 40) == 0)
                positions[i][draw_below(&random, 3)] = draw_odd(&random, lights[l / 2][0]);
            skip[i][0] = draw_below(&random, 9) ? 0 : MLRT_NONE;
            skip[i][1] = draw_below(&random, 100);
        }
        for (size_t r = 0; r < sizeof ROW_LENGTHS / sizeof ROW_LENGTHS[0]; r++) {
            check_points(&fixture, positions[0], (l / 2 + r) % 2 ? skip[0] : NULL, COUNT, ROW_LENGTHS[r], &light);
        }
    }
    free_fixture(&fixture);
}

/* Sixteen triangles a row, so that a triangle and the one below it have the same place. */
static void triangles_of_one_place(void **state)
{
    (void)state;
    struct soup soup = {0};
    soup_add_grid(&soup, 2, 0, 8);
    struct fixture fixture = fixture_of_soup("grid", 2180, &soup);
    const float eye[3] = {4.03f, 3.9f, 9}, target[3] = {4.01f, 4.02f, 0};
    for (uint32_t size = 24; size < 72; size += 7) {
        const mlrt_camera camera = look_at(eye, target, 0.9f, size, size);
        struct ray_list list = {0};
        add_camera_rays(&list, &camera);
        check_hits(&fixture, &list, 0);
        check_camera_quickly(&fixture, &camera);
        free_rays(&list);
    }
    free_fixture(&fixture);
}

/* From tile to tile, the same triangles and another origin. */
static void origins_in_turn(void **state)
{
    (void)state;
    static const float eyes[][3] = {{0.1f, -3, 0.7f}, {0.1f, -3, 0.75f}, {0.1f, -3, -0.0f}, {0.1f, -3, 0}};
    struct soup soup = {0};
    const float lo[3] = {-1, -1, -1}, hi[3] = {1, 1, 1};
    soup_add_box(&soup, lo, hi);
    struct fixture fixture = fixture_of_soup("box", 2190, &soup);
    struct ray_list list = {0};
    for (int i = 0; i < 12; i++) {
        const float target[3] = {0, 0, 0};
        const mlrt_camera camera = look_at(eyes[i % 4], target, 0.8f, 16, 16);
        add_camera_rays(&list, &camera);
    }
    check_hits(&fixture, &list, 0);
    free_rays(&list);
    free_fixture(&fixture);
}

/* ---- tiles ---------------------------------------------------------------------------------------------------- */

enum { TILES_WIDTH = 48, TILES_HEIGHT = 34, TILES_COUNT = TILES_WIDTH * TILES_HEIGHT };

/* Answers about a picture of rays, and about the points where they end. */
struct tile_answers {
    uint32_t triangle[TILES_COUNT];
    float t[TILES_COUNT];
    uint8_t occluded[TILES_COUNT];
    uint8_t dark[TILES_COUNT];
};

static void trace_tiles(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_points *points,
                        const mlrt_light *light, mlrt_trace_options options, struct tile_answers *answers)
{
    mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {answers->triangle, 0, 0}, .t = {answers->t, 0, 0}};
    const mlrt_array dark = {answers->dark, 0, 0};
    memset(answers, 0x77, sizeof *answers);
    assert_int_equal(mlrt_trace_packet(tree, rays, &options, &hits), MLRT_OK);
    options.query = MLRT_QUERY_ANY;
    hits = (mlrt_hits){.struct_size = sizeof hits, .occluded = {answers->occluded, 0, 0}};
    assert_int_equal(mlrt_trace_packet(tree, rays, &options, &hits), MLRT_OK);
    options.query = MLRT_QUERY_CLOSEST;
    assert_int_equal(mlrt_occluded_points(tree, points, light, &options, &dark), MLRT_OK);
}

/* Walls that cover whole tiles, in part twice, and something small in the room. */
static struct fixture make_room(struct random *random, uint64_t seed)
{
    struct soup soup = {0};
    const float lo[3] = {-4, -4, -4}, hi[3] = {4, 4, 4}, low[3] = {-1, -1, -1}, high[3] = {0.5f, 1, 0.25f};
    soup_add_box(&soup, lo, hi);
    if (seed % 2) soup_add_box(&soup, low, high);
    if (seed % 3 == 0) soup_add_box(&soup, lo, hi);
    if (seed % 5 < 2) soup_add_random(&soup, random, 3, 2.0f, 0.5f);
    return fixture_of_soup("room", seed, &soup);
}

/* Something that must keep a ray from going with the others, though it is seen where they are. */
static void set_ray_apart(struct reference_ray *ray, struct random *random)
{
    const uint32_t k = draw_below(random, 3);
    switch (draw_below(random, 5)) {
    case 0:
        ray->direction[k] = NAN;
        break;
    case 1:
        for (int j = 0; j < 3; j++) ray->direction[j] = -ray->direction[j];
        break;
    case 2:
        ray->skip[0] ^= 1 + draw_below(random, 3);
        break;
    case 3:
        ray->skip[1] ^= 1 + draw_below(random, 3);
        break;
    default:
        spoil_ray(ray, random);
    }
}

/* Rays of one apex to walls; all pass one triangle, or none, and one of them all is something else. */
static void one_ray_of_a_tile(void **state)
{
    (void)state;
    static struct tile_answers expected, got;
    size_t uniform = 0;
    for (uint64_t seed = 0; seed < scaled(160); seed++) {
        struct random random = {2300 + seed};
        struct fixture fixture = make_room(&random, seed);
        struct ray_list list = {0};
        float eye[3], target[3];
        draw_point(&random, -3.5f, 3.5f, eye);
        draw_point(&random, -4, 4, target);
        const mlrt_camera camera = look_at(eye, target, draw_range(&random, 0.05f, 0.45f), TILES_WIDTH, TILES_HEIGHT);
        add_camera_rays(&list, &camera);
        const size_t other = draw_below(&random, TILES_COUNT);
        const uint32_t one = draw_below(&random, 24), skips = draw_below(&random, 3);
        for (size_t i = 0; i < list.count; i++) {
            struct reference_hit hit;
            reference_trace(fixture.reference, &list.rays[i], &hit);
            list.rays[i].skip[0] = skips == 2 ? hit.mesh : 0;
            list.rays[i].skip[1] = skips == 2 ? hit.triangle : one;
        }
        float(*points)[3] = allocate_or_fail(list.count, sizeof *points);
        const float reach = draw_range(&random, 0.5f, 6.5f);
        for (int again = 0; again < 2; again++) {
            struct packed packed = pack(&list);
            for (size_t i = 0; i < list.count; i++) {
                for (int k = 0; k < 3; k++) {
                    points[i][k] = eye[k] + reach * list.rays[i].direction[k];
                }
            }
            if (again && draw_below(&random, 2)) points[other][draw_below(&random, 3)] = draw_odd(&random, eye[0]);
            mlrt_rays rays = {.struct_size = sizeof rays,
                              .row_length = TILES_WIDTH,
                              .count = list.count,
                              .origins = {packed.origins, 0},
                              .directions = {packed.directions, 0}};
            mlrt_points ends = {
                .struct_size = sizeof ends, .row_length = TILES_WIDTH, .count = list.count, .positions = {points, 0}};
            if (skips) rays.skip.data = ends.skip.data = packed.skip;
            mlrt_light light = {.struct_size = sizeof light, .kind = MLRT_LIGHT_POINT};
            memcpy(light.position, eye, sizeof eye);
            if (seed % 16 == 15) light.position[seed / 16 % 3] = draw_odd(&random, eye[0]);
            for (int k = 0; k < 3; k++) {
                if (!(fabsf(light.position[k]) < INFINITY)) light.position[k] = 0;
            }
            mlrt_trace_options options = {.struct_size = sizeof options, .method = MLRT_METHOD_RAY};
            trace_tiles(fixture.tree, &rays, &ends, &light, options, &expected);
            options.method = MLRT_METHOD_TILE;
            for (options.isa = MLRT_ISA_SCALAR; options.isa <= MLRT_ISA_NEON; options.isa++) {
                if (!mlrt_select_kernels(&mlrt_structure_bvh, options.isa, MLRT_METHOD_TILE, 0)) continue;
                trace_tiles(fixture.tree, &rays, &ends, &light, options, &got);
                for (size_t i = 0; i < list.count; i++) {
                    if (got.triangle[i] == expected.triangle[i] && memcmp(&got.t[i], &expected.t[i], 4) == 0 &&
                        got.occluded[i] == expected.occluded[i] && got.dark[i] == expected.dark[i]) {
                        continue;
                    }
                    fail_msg("seed %u, isa %d, ray %u of %u, other %u, again %d: triangle %u, not %u; any %d, not %d; "
                             "dark %d, not %d",
                             (unsigned)seed, (int)options.isa, (unsigned)i, (unsigned)list.count, (unsigned)other,
                             again, got.triangle[i], expected.triangle[i], got.occluded[i], expected.occluded[i],
                             got.dark[i], expected.dark[i]);
                }
            }
            uniform += memchr(expected.dark, !expected.dark[0], 16) == NULL;
            free_packed(&packed, list.count);
            set_ray_apart(&list.rays[other], &random);
        }
        free(points);
        free_rays(&list);
        free_fixture(&fixture);
    }
    assert_true(uniform > scaled(200));
}

/* ---- packets ----------------------------------------------------------------------------------------------------- */

static void compare_lanes(const char *what, uint32_t place, uint32_t lanes, const void *one, const void *other)
{
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        const uint32_t a = ((const uint32_t *)one)[lane], b = ((const uint32_t *)other)[lane];
        if (a != b) fail_msg("%s of lane %u of packet %u is %08x, not %08x", what, lane, place, a, b);
    }
}

/* Rays as they were read, unchecked. Lanes that do not exist hold anything. */
static void compare_packets(uint32_t place, uint32_t lanes, const struct mlrt_packet *one,
                            const struct mlrt_packet *other)
{
    static const char *const components[] = {"x", "y", "z"};
    assert_int_equal(one->active, lanes);
    assert_int_equal(one->has.apex, other->has.apex);
    assert_int_equal(one->has.skip, other->has.skip);
    assert_int_equal(one->has.limits, other->has.limits);
    assert_int_equal(one->has.masks, other->has.masks);
    if (one->has.apex) assert_memory_equal(one->apex, other->apex, sizeof one->apex);
    for (int k = 0; k < 3; k++) compare_lanes(components[k], place, lanes, one->direction[k], other->direction[k]);
    for (int k = 0; !one->has.apex && k < 3; k++) {
        compare_lanes("an origin", place, lanes, one->origin[k], other->origin[k]);
    }
    compare_lanes("t_min", place, lanes, one->t_min, other->t_min);
    compare_lanes("t_max", place, lanes, one->t_max, other->t_max);
    if (one->has.skip) compare_lanes("the skip", place, lanes, one->skip, other->skip);
}

/* Which lanes of a block can hit something, and which of them float carries, as it is said of one ray. */
static void check_lanes_of(const struct mlrt_source *source, const struct mlrt_rectangle *block, uint32_t lanes,
                           const struct mlrt_packet *packet)
{
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane++) {
        struct mlrt_ray_segment ray;
        uint32_t skip, valid = 0, safe = 0;
        const uint32_t x = block->x + (uint32_t)mlrt_lane_x[lane], y = block->y + (uint32_t)mlrt_lane_y[lane];
        if (lanes >> lane & 1) valid = (uint32_t)mlrt_get_ray(source, y * source->width + x, &ray, &skip);
        if (valid) safe = (uint32_t)mlrt_is_safe_ray(&ray);
        if (valid && packet->has.skip) assert_int_equal(packet->skip[lane], skip);
        if ((packet->active >> lane & 1) != (valid & safe) || (packet->in_double >> lane & 1) != (valid & ~safe & 1)) {
            fail_msg("lane %u of the block at %u, %u: valid %u, safe %u", lane, block->x, block->y, valid, safe);
        }
    }
}

/* All packets of a source at once by vectors, and one by one. Returns how many there are. */
static uint32_t compare_tiles(const struct mlrt_source *source, const struct readers *readers)
{
    struct mlrt_ray_tile tile;
    uint32_t count = 0;
    for (uint32_t y = 0; y < source->height; y += 16) {
        for (uint32_t x = 0; x < source->width; x += 16) {
            const struct mlrt_rectangle whole = {0, 0, source->width, source->height};
            const struct mlrt_rectangle area = mlrt_cut_piece(&whole, x, y, 16);
            mlrt_begin_tile(&area, 0, &tile);
            readers->read_packets(source, &tile);
            for (uint32_t place = 0; place < MLRT_BUNDLE_PACKETS; place++) {
                if (!(tile.blocks >> place & 1)) continue;
                struct mlrt_packet packet;
                const struct mlrt_rectangle block = mlrt_block_of_tile(&tile, place);
                const uint32_t lanes = mlrt_existing_lanes(source, &block);
                readers->fetch_block(source, &block, lanes, &packet);
                compare_packets(place, lanes, &tile.packets[place], &packet);
                readers->check_block(source, lanes, &packet);
                check_lanes_of(source, &block, lanes, &packet);
                ++count;
            }
        }
    }
    return count;
}

/* A list as rays, and its directions as points of lights of both kinds. */
static uint32_t compare_sources(const struct fixture *fixture, const struct ray_list *list, int has_skips,
                                const float light_position[3], const struct readers *readers)
{
    struct mlrt_source source;
    struct packed packed = pack(list);
    mlrt_rays rays = {.struct_size = sizeof rays,
                      .count = list->count,
                      .row_length = WIDTH,
                      .origins = {packed.origins, 0},
                      .directions = {packed.directions, 0}};
    if (has_skips) rays.skip.data = packed.skip;
    mlrt_make_ray_source(fixture->tree, &rays, &source);
    mlrt_set_masks(fixture->tree, MLRT_MASK_ALL, &source);
    const uint32_t count = compare_tiles(&source, readers);
    const mlrt_points points = {.struct_size = sizeof points,
                                .row_length = WIDTH,
                                .count = list->count,
                                .positions = {packed.directions, 0},
                                .skip = rays.skip};
    mlrt_light light = {.struct_size = sizeof light};
    memcpy(light.position, light_position, sizeof light.position);
    for (light.kind = MLRT_LIGHT_POINT; light.kind <= MLRT_LIGHT_DIRECTIONAL; light.kind++) {
        mlrt_make_light_source(fixture->tree, &points, &light, &source);
        mlrt_set_masks(fixture->tree, MLRT_MASK_ALL, &source);
        compare_tiles(&source, readers);
    }
    free_packed(&packed, list->count);
    return count;
}

static void packets_are_the_same(void **state)
{
    (void)state;
    struct fixture fixture = make_scene(2200);
    const float eye[3] = {0.1f, -3, 0.7f};
    uint32_t alike = 0, rounds = 0;
    for (int32_t isa = MLRT_ISA_SCALAR; isa <= MLRT_ISA_NEON; isa++) {
        const struct readers *readers = readers_of(isa);
        if (!readers) continue;
        for (uint32_t i = 0; i < 60; i++) {
            struct random random = {2210 + i};
            struct ray_list list = {0};
            float light[3] = {0.5f, 0.25f, 0};
            if (i % 2) {
                add_view(&list, eye, 0.9f);
            } else {
                add_parallel_view(&list, DIRECTIONS[i / 2 % DIRECTION_COUNT]);
            }
            spoil(&list, &random, 1 + draw_below(&random, 60));
            if (i % 3 == 0) add_skips(&fixture, &random, &list);
            for (size_t j = 0; i % 5 == 0 && j < list.count; j++) {
                (i % 2 ? list.rays[j].origin : list.rays[j].direction)[i % 3] = draw_odd(&random, 0);
            }
            if (i % 4 == 0) light[i % 3] = i % 8 ? 0x1p61f : -0.0f;
            if (i % 20 == 0) light[0] = light[1] = light[2] = 0;
            alike += compare_sources(&fixture, &list, i % 3 == 0, light, readers);
            rounds++;
            free_rays(&list);
        }
    }
    assert_true(alike > 4 * rounds);
    free_fixture(&fixture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(some_rays_do_not_belong), cmocka_unit_test(origins_that_are_no_places),
        cmocka_unit_test(some_are_not_parallel),   cmocka_unit_test(directions_that_are_none),
        cmocka_unit_test(points_of_a_light),       cmocka_unit_test(triangles_of_one_place),
        cmocka_unit_test(origins_in_turn),         cmocka_unit_test(one_ray_of_a_tile),
        cmocka_unit_test(packets_are_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
