/* SPDX-License-Identifier: MIT */
/*
 * The step of many lanes in double between the float filters and the judge of one ray (src/hits/close_calls.h): its
 * answers are the judge's, in every instruction set, and its bounds of t are bounds.
 */
#include "support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "close/close.h"
#include "hard_scenes.h"
#include "exact/nearest.h"
#include "hostile_rays.h"
#include "base/progress.h"
#include "job/stop.h"
#include "hits/undecided.h"

static uint32_t lanes_left; /* to the judge, since the last time that this was 0 */

uint32_t decide_rest(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes, uint32_t inside,
                     struct mlrt_packet *packet, struct mlrt_worker *worker, mlrt_counters *counters)
{
    lanes_left += mlrt_count_bits(lanes);
    return mlrt_decide_lanes(tree, number, lanes, inside, packet, worker, counters);
}

/* ---- packets ----------------------------------------------------------------------------------------------------- */

/* Sixteen rays, and a worker that remembers planes. */
struct bench {
    struct mlrt_packet packet;
    struct mlrt_worker worker;
    struct mlrt_known_plane planes[1u << MLRT_FEW_PLANE_BITS];
    struct mlrt_ray_segment rays[MLRT_PACKET_RAYS];
    uint32_t valid;
};

static void begin_bench(struct bench *bench)
{
    memset(bench, 0, sizeof *bench);
    bench->worker.known.planes = bench->planes;
    mlrt_forget_planes(MLRT_FEW_PLANE_BITS, &bench->worker);
}

static void set_lane(struct bench *bench, uint32_t lane, const float origin[3], const float direction[3], float t_min,
                     float t_max)
{
    struct mlrt_packet *packet = &bench->packet;
    struct mlrt_ray_segment *ray = &bench->rays[lane];
    bench->valid &= ~(1u << lane);
    for (int k = 0; k < 3; k++) packet->origin[k][lane] = packet->direction[k][lane] = 1;
    if (!mlrt_make_segment(origin, direction, t_min, t_max, ray) || !mlrt_is_safe_ray(ray)) return;
    bench->valid |= 1u << lane;
    for (int k = 0; k < 3; k++) {
        packet->origin[k][lane] = ray->origin[k];
        packet->direction[k][lane] = ray->direction[k];
    }
    packet->t_min[lane] = ray->t_min;
    packet->t_max[lane] = packet->nearest.lo[lane] = packet->nearest.hi[lane] = ray->t_max;
    packet->nearest.triangle[lane] = MLRT_NONE;
}

/* Gives all rays the origin of the first. */
static void set_apex(struct bench *bench)
{
    if (!bench->valid) return;
    const uint32_t first = mlrt_lowest_bit(bench->valid);
    memcpy(bench->packet.apex, bench->rays[first].origin, sizeof bench->packet.apex);
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane++) {
        memcpy(bench->rays[lane].origin, bench->packet.apex, sizeof bench->packet.apex);
        for (int k = 0; k < 3; k++) bench->packet.origin[k][lane] = NAN;
    }
    bench->packet.has.apex = 1;
}

/* Is the ray inside the edges, as a float filter may know? Not if any edge is touched, which it cannot. */
static int is_inside(const struct bench *bench, const struct mlrt_tree *tree, uint32_t number, uint32_t lane)
{
    struct mlrt_ray_segment ray = bench->rays[lane];
    ray.t_min = 0;
    ray.t_max = INFINITY;
    const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, number);
    return mlrt_hits_triangle(&ray, &triangle, NULL) && mlrt_crosses_triangle(&ray, &triangle);
}

/* t is certainly above lo, unless that is 0, and no more than hi. */
static void check_bounds(const struct bench *bench, const struct mlrt_tree *tree, uint32_t lane)
{
    const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, bench->packet.nearest.triangle[lane]);
    struct mlrt_ray_segment above = bench->rays[lane], below = bench->rays[lane];
    above.t_min = bench->packet.nearest.lo[lane];
    above.t_max = INFINITY;
    below.t_min = 0;
    below.t_max = bench->packet.nearest.hi[lane];
    assert_true(bench->packet.nearest.lo[lane] >= 0);
    assert_true(mlrt_hits_triangle(&above, &triangle, NULL));
    assert_true(mlrt_hits_triangle(&below, &triangle, NULL));
}

/* What float filters know of a nearest hit is less than what double does. */
static void widen_bounds(struct bench *bench, struct random *random, uint32_t lanes)
{
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        const float width = (float)draw_below(random, 40) * 0x1p-24f;
        bench->packet.nearest.lo[lane] *= 1 - width;
        bench->packet.nearest.hi[lane] *= 1 + width;
    }
}

/*
 * Offers a triangle to lanes, by the step and ray by ray by the judge, and compares. Returns the lanes that got to the
 * judge from the step.
 */
static uint32_t offer(decide_function *decide, struct bench *bench, const struct mlrt_tree *tree, uint32_t number,
                      uint32_t lanes, struct random *random)
{
    struct mlrt_packet *packet = &bench->packet;
    struct mlrt_nearest expected[MLRT_PACKET_RAYS];
    uint32_t inside = 0, hit = 0, was_none = 0;
    lanes &= bench->valid;
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane++) {
        expected[lane] =
            (struct mlrt_nearest){packet->nearest.triangle[lane], packet->nearest.lo[lane], packet->nearest.hi[lane]};
        if (packet->nearest.triangle[lane] == number) lanes &= ~(1u << lane);
        if (!(lanes >> lane & 1)) continue;
        was_none |= (uint32_t)(packet->nearest.triangle[lane] == MLRT_NONE) << lane;
        if (is_inside(bench, tree, number, lane)) inside |= 1u << lane;
        if (mlrt_offer_triangle(&tree->by_number, &bench->rays[lane], number, &expected[lane], NULL)) hit |= 1u << lane;
    }
    if (!lanes) return 0;
    inside &= draw_bits(random);
    lanes_left = 0;
    const uint32_t found = decide(tree, number, lanes, inside, packet, &bench->worker, NULL);
    assert_int_equal(found & ~hit, 0);
    assert_int_equal(hit & was_none & ~found, 0);
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane++) {
        if (!(bench->valid >> lane & 1)) continue;
        if (packet->nearest.triangle[lane] != expected[lane].triangle) {
            const struct mlrt_ray_segment *ray = &bench->rays[lane];
            fail_msg("lane %u, triangle %u: %u in place of %u; ray %a %a %a, %a %a %a", (unsigned)lane,
                     (unsigned)number, (unsigned)packet->nearest.triangle[lane], (unsigned)expected[lane].triangle,
                     (double)ray->origin[0], (double)ray->origin[1], (double)ray->origin[2], (double)ray->direction[0],
                     (double)ray->direction[1], (double)ray->direction[2]);
        }
        if (hit >> lane & 1) check_bounds(bench, tree, lane);
    }
    widen_bounds(bench, random, found);
    return lanes_left;
}

static decide_function *const functions[] = {decide_close_scalar,
#if MLRT_SSE_KERNELS
                                             decide_close_sse, decide_close_avx2, decide_close_avx512
#elif MLRT_NEON_KERNELS
                                             decide_close_neon
#endif
};
static const int32_t isas[] = {MLRT_ISA_SCALAR, MLRT_NEON_KERNELS ? MLRT_ISA_NEON : MLRT_ISA_SSE, MLRT_ISA_AVX2,
                               MLRT_ISA_AVX512};

#define FUNCTION_COUNT (sizeof functions / sizeof *functions)

/* ---- triangles that are close ------------------------------------------------------------------------------------ */

#define SHEET_COUNT 24

/* Triangles whose corners are those of the first, a few floats off, or other corners of nearly the same plane. */
static void add_sheets(struct soup *soup, struct random *random)
{
    float corner[4][3];
    const float extent = ldexpf(1, (int)draw_below(random, 40) - 20), from = draw_range(random, -1, 1) * 4 * extent;
    const uint32_t flat = draw_below(random, 6); // an axis, half of the time
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) corner[i][k] = draw_range(random, from - extent, from + extent);
        if (flat < 3) corner[i][flat] = from;
    }
    for (int k = 0; k < 3; k++) corner[3][k] = corner[1][k] + (corner[2][k] - corner[0][k]);
    for (int n = 0; n < SHEET_COUNT; n++) {
        float moved[3][3];
        const uint32_t first = draw_below(random, 4), steps = draw_below(random, 4);
        for (uint32_t i = 0; i < 3; i++) {
            for (int k = 0; k < 3; k++) {
                const int by = (int)draw_below(random, 2 * steps + 1) - (int)steps;
                moved[i][k] = next_float(corner[(first + i) % 4][k], by);
            }
        }
        soup_add_triangle(soup, moved[0], moved[1], moved[2]);
    }
}

/* Rays to corners, points of edges and inner points of triangles. */
static void aim(struct bench *bench, struct random *random, const struct mlrt_tree *tree)
{
    float origin[3];
    const struct mlrt_triangle base = mlrt_triangle_at(&tree->by_number, 0);
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane++) {
        const struct mlrt_triangle to = mlrt_triangle_at(&tree->by_number, draw_below(random, tree->triangle_count));
        float direction[3], target[3];
        const uint32_t kind = draw_below(random, 4);
        float a = kind == 0 ? 0 : draw_range(random, 0, 1), b = kind <= 1 ? 0 : draw_range(random, 0, 1 - a);
        if (lane == 0 || !bench->packet.has.apex) {
            for (int k = 0; k < 3; k++) {
                const float size = fabsf(base.v[0][k] - base.v[1][k]) + fabsf(base.v[0][k] - base.v[2][k]);
                origin[k] = base.v[0][k] + 8 * size * draw_range(random, -1, 1);
            }
            if (draw_below(random, 8) == 0) memcpy(origin, to.v[draw_below(random, 3)], sizeof origin);
        }
        for (int k = 0; k < 3; k++) {
            target[k] = to.v[0][k] + a * (to.v[1][k] - to.v[0][k]) + b * (to.v[2][k] - to.v[0][k]);
            direction[k] = target[k] - origin[k];
        }
        const float t_max = draw_below(random, 3) ? INFINITY : next_float(1, (int)draw_below(random, 5) - 2);
        const float t_min = draw_below(random, 3) ? 0 : next_float(1, (int)draw_below(random, 5) - 2);
        set_lane(bench, lane, origin, direction, t_min, t_max);
    }
}

static void sheets_that_nearly_coincide(void **state)
{
    (void)state;
    struct random random = {1};
    uint64_t offered = 0, left = 0;
    for (size_t round = 0; round < scaled(300); round++) {
        struct soup soup = {0};
        add_sheets(&soup, &random);
        const mlrt_mesh mesh = soup_mesh(&soup);
        mlrt_tree *tree = NULL;
        assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
        for (size_t i = 0; i < FUNCTION_COUNT; i++) {
            if (!isa_is_supported(isas[i])) continue;
            struct bench own, *bench = &own;
            begin_bench(bench);
            aim(bench, &random, tree);
            if (draw_below(&random, 2)) set_apex(bench);
            for (int n = 0; n < 2 * SHEET_COUNT; n++) {
                const uint32_t lanes = draw_below(&random, 4) ? 0xFFFF : draw_bits(&random) & 0xFFFF;
                left += offer(functions[i], bench, tree, draw_below(&random, SHEET_COUNT), lanes, &random);
                offered += mlrt_count_bits(lanes & bench->valid);
            }
        }
        mlrt_destroy_tree(tree);
        free_soup(&soup);
    }
    assert_true(left * 4 < offered); // exact ties, shared edges and corners
}

/* ---- hard scenes and hostile rays -------------------------------------------------------------------------------- */

#define OFFER_LIMIT 96

static void offer_scene(decide_function *decide, struct bench *bench, const struct mlrt_tree *tree,
                        struct random *random)
{
    const uint32_t count = tree->triangle_count < OFFER_LIMIT ? tree->triangle_count : OFFER_LIMIT;
    for (uint32_t n = 0; n < count; n++) {
        uint32_t number = draw_below(random, tree->triangle_count);
        const struct mlrt_triangle triangle = mlrt_triangle_at(&tree->by_number, number);
        if (mlrt_triangle_is_finite(&triangle) && mlrt_triangle_has_area(&triangle)) {
            offer(decide, bench, tree, number, 0xFFFF, random);
        }
    }
}

static void hostile_rays_in_hard_scenes(void **state)
{
    (void)state;
    struct random random = {2};
    struct bench own, *bench = &own;
    for (size_t scene = 0; scene < hard_scene_count(); scene++) {
        struct fixture fixture = make_hard_scene(scene);
        if (fixture.tree->triangle_count == 0) {
            free_fixture(&fixture);
            continue;
        }
        for (size_t kind = 0; kind < hostile_kind_count(); kind++) {
            struct ray_list list = {0};
            add_hostile_rays(&list, &random, &fixture, kind, 16);
            for (size_t i = 0; i < FUNCTION_COUNT; i++) {
                if (!isa_is_supported(isas[i])) continue;
                begin_bench(bench);
                for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane++) {
                    const struct reference_ray *ray = &list.rays[lane % list.count];
                    set_lane(bench, lane, ray->origin, ray->direction, ray->t_min, ray->t_max);
                }
                if (draw_below(&random, 2)) set_apex(bench);
                offer_scene(functions[i], bench, fixture.tree, &random);
            }
            free_rays(&list);
        }
        free_fixture(&fixture);
    }
}

/* ---- what stays away from the judge ------------------------------------------------------------------------------ */

/* A wall that is there twice, floats apart and cut differently, and a triangle with a vertex where a ray goes. */
static void what_double_decides_is_not_judged(void **state)
{
    (void)state;
    static const float a[3] = {-4, -3, 5}, b[3] = {4, -3, 5.5f}, c[3] = {4, 3, 6}, d[3] = {-4, 3, 5.5f};
    struct random random = {3};
    struct soup soup = {0};
    float moved[4][3];
    const float *const corners[4] = {a, b, c, d};
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 3; k++) moved[i][k] = next_float(corners[i][k], 2 * (k == 2));
    }
    soup_add_triangle(&soup, a, b, c);
    soup_add_triangle(&soup, moved[0], moved[1], moved[3]);
    const mlrt_mesh mesh = soup_mesh(&soup);
    mlrt_tree *tree = NULL;
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
    for (size_t i = 0; i < FUNCTION_COUNT; i++) {
        if (!isa_is_supported(isas[i])) continue;
        for (uint32_t order = 0; order < 2; order++) {
            struct bench own, *bench = &own;
            begin_bench(bench);
            for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane++) {
                const float direction[3] = {0.5f - 0.0625f * (float)lane, -0.25f, 5};
                set_lane(bench, lane, (const float[3]){0.125f, 0.0625f, 0}, direction, 0, INFINITY);
            }
            assert_int_equal(offer(functions[i], bench, tree, order, 0xFFFF, &random), 0);
            assert_int_equal(offer(functions[i], bench, tree, 1 - order, 0xFFFF, &random), 0);
            for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane++) {
                assert_int_not_equal(bench->packet.nearest.triangle[lane], MLRT_NONE);
            }
        }
    }
    mlrt_destroy_tree(tree);
    free_soup(&soup);
}

/* Rays that end in a wall across an axis, or so little before or behind it that the distance to it rounds to theirs. */
static void ends_of_rays_at_walls(void **state)
{
    (void)state;
    struct random random = {4};
    for (int turn = 0; turn < 6; turn++) {
        const float side = turn < 3 ? 1 : -1;
        struct soup soup = {0};
        soup_add_triangle(&soup, (const float[3]){-4, -4, side}, (const float[3]){4, -4, side},
                          (const float[3]){0, 4, side});
        swap_axes(&soup, turn % 3);
        const mlrt_mesh mesh = soup_mesh(&soup);
        mlrt_tree *tree = NULL;
        assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
        for (size_t i = 0; i < FUNCTION_COUNT; i++) {
            if (!isa_is_supported(isas[i])) continue;
            struct bench own, *bench = &own;
            begin_bench(bench);
            for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane++) {
                const int axis = (2 + turn) % 3, kind = (int)lane % 4;
                float origin[3] = {0.0625f, 0.125f, 0.1875f}, direction[3] = {0.25f, 0.125f, 0.0625f};
                origin[axis] = side * (kind == 0 ? 0 : kind == 1 ? 0x1p-58f : kind == 2 ? -0x1p-58f : 0.5f);
                direction[axis] = side * (kind == 3 ? 0.5f : 1);
                set_lane(bench, lane, origin, direction, 0, 1);
            }
            assert_int_equal(offer(functions[i], bench, tree, 0, 0xFFFF, &random), 0);
            for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane++) {
                assert_int_equal(bench->packet.nearest.triangle[lane], lane % 4 == 2 ? MLRT_NONE : 0);
            }
        }
        mlrt_destroy_tree(tree);
        free_soup(&soup);
    }
}

/*
 * Two triangles a few times 2^-83 in front of the origins, met by directions of length 2^60: t is between 2^-143 and
 * 2^-142, where floats are 2^-149 apart, and differs by less than half of that from one triangle to the other. So where
 * bounds of t are rounded to floats, a share of t is no margin.
 */
static void distances_that_are_denormal(void **state)
{
    (void)state;
    struct random random = {5};
    const float z[3] = {0x1p-60f + 0x1p-83f, 0x1p-60f + 0x1p-82f, 0x1p-60f + 0x1.8p-82f};
    struct soup soup = {0};
    mlrt_tree *tree = NULL;
    soup_add_triangle(&soup, (const float[3]){0, 0, z[0]}, (const float[3]){1, 0, z[1]}, (const float[3]){0, 1, z[0]});
    soup_add_triangle(&soup, (const float[3]){0, 0, z[0]}, (const float[3]){1, 0, z[1]}, (const float[3]){0, 1, z[2]});
    const mlrt_mesh mesh = soup_mesh(&soup);
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
    for (size_t i = 0; i < FUNCTION_COUNT; i++) {
        if (!isa_is_supported(isas[i])) continue;
        for (uint32_t turn = 0; turn < 40; turn++) {
            struct bench own, *bench = &own;
            begin_bench(bench);
            for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane++) {
                const float origin[3] = {draw_range(&random, 0.0625f, 0.9375f), draw_range(&random, 0, 0x1p-9f),
                                         0x1p-60f};
                set_lane(bench, lane, origin, (const float[3]){0, 0, 0x1p60f}, 0, INFINITY);
            }
            offer(functions[i], bench, tree, turn % 2, 0xFFFF, &random);
            offer(functions[i], bench, tree, 1 - turn % 2, 0xFFFF, &random);
            for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane++)
                assert_int_equal(bench->packet.nearest.triangle[lane], 0);
        }
    }
    mlrt_destroy_tree(tree);
    free_soup(&soup);
}

/* ---- thousands of triangles in one plane ------------------------------------------------------------------------- */

#define NEST_COUNT 2000

/* Each around the next smaller one, all in the plane x = z, as every ray meets them. */
static mlrt_tree *make_nest(void)
{
    struct soup soup = {0};
    mlrt_tree *tree = NULL;
    for (int i = 0; i < NEST_COUNT; i++) {
        const float s = 0.0001f + (float)i / (2.0f * NEST_COUNT);
        const float a[3] = {0.5f - s, 0.5f - s, 0.5f - s}, b[3] = {0.5f + s, 0.5f - s, 0.5f + s};
        soup_add_triangle(&soup, a, b, (const float[3]){0.5f, 0.5f + s, 0.5f});
    }
    const mlrt_mesh mesh = soup_mesh(&soup);
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
    free_soup(&soup);
    return tree;
}

static int32_t count_call(void *user, double fraction)
{
    (void)fraction;
    ++*(int *)user;
    return 0;
}

static int32_t count_call_and_stop(void *user, double fraction)
{
    count_call(user, fraction);
    return 1;
}

static void aim_at_nest(struct bench *bench)
{
    begin_bench(bench);
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane++) {
        const float direction[3] = {-0.75f + 0.001f * (float)lane, 0.0625f, 0.75f};
        set_lane(bench, lane, (const float[3]){1.25f, 0.4375f, -0.25f}, direction, 0, INFINITY);
    }
    set_apex(bench);
}

/* Each triangle of a plane is compared once, whatever lies nearest then: not once for each pair, nor each packet. */
static void planes_are_asked_for_once(void **state)
{
    (void)state;
    mlrt_tree *tree = make_nest();
    struct mlrt_known_plane *planes = allocate_or_fail(1u << MLRT_KNOWN_PLANE_BITS, sizeof *planes);
    struct mlrt_progress progress = {0}; // tells nobody
    struct bench own, *bench = &own;
    aim_at_nest(bench);
    bench->worker.known.planes = planes;
    mlrt_forget_planes(MLRT_KNOWN_PLANE_BITS, &bench->worker);
    bench->worker.watch.progress = &progress;
    for (uint32_t nearest = 0; nearest < NEST_COUNT; nearest += 97) {
        for (uint32_t number = 0; number < NEST_COUNT; number++) {
            if (number != nearest) assert_true(mlrt_have_one_plane(tree, number, nearest, &bench->worker));
        }
    }
    assert_int_equal(bench->worker.watch.slow_steps, NEST_COUNT - 1);
    free(planes);
    mlrt_destroy_tree(tree);
}

/* So many triangles a packet is offered at most until the host is asked; and nothing happens after it said stop. */
static void close_calls_are_stopped(void **state)
{
    (void)state;
    mlrt_tree *tree = make_nest();
    for (size_t i = 0; i < FUNCTION_COUNT; i++) {
        if (!isa_is_supported(isas[i])) continue;
        int call_count = 0;
        const mlrt_host host = {.struct_size = sizeof host, .user = &call_count, .progress = count_call_and_stop};
        struct mlrt_progress progress;
        struct bench own, *bench = &own;
        uint32_t number = NEST_COUNT - 1;
        aim_at_nest(bench);
        mlrt_begin_progress(&host, 1, &progress);
        bench->worker.watch.progress = &progress;
        mlrt_enter_fp_environment(&bench->worker.watch.environment);
        for (; number > 0 && !bench->worker.watch.stopped; number--) {
            functions[i](tree, number, 0xFFFF, 0xFFFF, &bench->packet, &bench->worker, NULL);
        }
        assert_int_equal(call_count, 1);
        assert_true(NEST_COUNT - number <= MLRT_SLOW_STEPS + 1);
        const struct mlrt_packet before = bench->packet;
        assert_int_equal(functions[i](tree, 0, 0xFFFF, 0xFFFF, &bench->packet, &bench->worker, NULL), 0);
        assert_memory_equal(before.nearest.triangle, bench->packet.nearest.triangle, sizeof before.nearest.triangle);
        mlrt_leave_fp_environment(&bench->worker.watch.environment);
        mlrt_end_progress(&progress, MLRT_ERROR_CANCELLED);
    }
    mlrt_destroy_tree(tree);
}

static int32_t count_tile(void *user, const mlrt_tile *tile)
{
    (void)tile;
    ++*(int *)user;
    return 0;
}

/* A picture of one tile for the callback: it is told of before that is done, and then ended within it. */
static void check_stop_within_an_item(mlrt_tree *tree)
{
    const mlrt_camera camera =
        look_at((const float[3]){1.25f, 0.4375f, -0.25f}, (const float[3]){0.5f, 0.5f, 0.5f}, 1, 128, 128);
    for (int stops = 0; stops < 2; stops++) {
        int call_count = 0, tile_count = 0;
        const mlrt_host host = {
            .struct_size = sizeof host, .user = &call_count, .progress = stops ? count_call_and_stop : count_call};
        const mlrt_trace_options options = {
            .struct_size = sizeof options, .initial_tile_size = 1024, .outputs = MLRT_OUTPUT_T, .host = &host};
        const int32_t status = mlrt_render_tiles(tree, &camera, &options, NULL, count_tile, &tile_count);
        assert_int_equal(status, stops ? MLRT_ERROR_CANCELLED : MLRT_OK);
        assert_int_equal(tile_count, !stops);
        assert_true(stops ? call_count == 1 : call_count >= 2); // in the item, or later; and 1 at the end
    }
    mlrt_destroy_tree(tree);
}

static void a_render_is_stopped_within_an_item(void **state)
{
    (void)state;
    struct soup soup = {0};
    mlrt_tree *tree = NULL;
    soup_add_icosphere(&soup, 3, 0.75f);
    const mlrt_mesh mesh = soup_mesh(&soup);
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
    check_stop_within_an_item(tree);
    check_stop_within_an_item(make_nest());
    free_soup(&soup);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sheets_that_nearly_coincide),       cmocka_unit_test(hostile_rays_in_hard_scenes),
        cmocka_unit_test(what_double_decides_is_not_judged), cmocka_unit_test(ends_of_rays_at_walls),
        cmocka_unit_test(distances_that_are_denormal),       cmocka_unit_test(planes_are_asked_for_once),
        cmocka_unit_test(close_calls_are_stopped),           cmocka_unit_test(a_render_is_stopped_within_an_item)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
