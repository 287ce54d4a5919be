/* SPDX-License-Identifier: MIT */
/*
 * Hits at exactly the same distance, in packets: walls of one plane that are drawn more than once and cut into
 * triangles in different ways, fans around a corner that rays go through, and things that only seem to tie. And rays
 * from anywhere in one direction, which packets must not make slow.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

/* ---- walls ------------------------------------------------------------------------------------------------------- */

/* A parallelogram at `corner` along two sides. All coordinates are small multiples of 1/64, so its points are exact. */
struct wall {
    float corner[3];
    float side[2][3];
};

/* Oblique to all axes. */
static const struct wall oblique = {{-4, -3, -2}, {{1, 0.25f, 0.5f}, {-0.25f, 1, 0.75f}}};
/* The same plane z = x / 2, seen as a slope. */
static const struct wall slope = {{-4, -4, -2}, {{1, 0, 0.5f}, {0, 1, 0}}};

static void point_of_wall(const struct wall *wall, float i, float j, float point[3])
{
    for (int k = 0; k < 3; k++) point[k] = wall->corner[k] + i * wall->side[0][k] + j * wall->side[1][k];
}

/* How a wall is cut into triangles: cells of size x size, the diagonal, the side that normals are on. */
struct cut {
    int size;
    int other_diagonal;
    int reverse;
};

static void add_part(struct soup *soup, float corner[4][3], const struct cut *cut, int a, int b, int c)
{
    soup_add_triangle(soup, corner[a], corner[cut->reverse ? c : b], corner[cut->reverse ? b : c]);
}

#define WALL_SIZE 8

static void add_wall(struct soup *soup, const struct wall *wall, const struct cut *cut)
{
    for (int j = 0; j < WALL_SIZE; j += cut->size) {
        for (int i = 0; i < WALL_SIZE; i += cut->size) {
            float corner[4][3];
            for (int n = 0; n < 4; n++) {
                const int along = n == 1 || n == 2, across = n >= 2;
                point_of_wall(wall, (float)(i + along * cut->size), (float)(j + across * cut->size), corner[n]);
            }
            const int first = cut->other_diagonal;
            add_part(soup, corner, cut, first, first + 1, first + 2);
            add_part(soup, corner, cut, first, first + 2, (first + 3) % 4);
        }
    }
}

/* Rays at points of the wall: corners, points of edges and diagonals, and inner points, in rows like pixels. */
static void aim_at_wall(struct ray_list *list, const struct wall *wall, const float eye[3], float step, float from)
{
    const int count = (int)((WALL_SIZE - 2 * from) / step) + 1;
    for (int j = 0; j < count; j++) {
        for (int i = 0; i < count; i++) {
            float point[3];
            point_of_wall(wall, from + (float)i * step, from + (float)j * step, point);
            add_ray_towards(list, eye, point);
        }
    }
    list->row_length = (uint32_t)count;
}

/* The same points from origins that differ, all in one direction. */
static void aim_along(struct ray_list *list, const struct wall *wall, const float direction[3], float step)
{
    const int count = (int)(WALL_SIZE / step) + 1;
    for (int j = 0; j < count; j++) {
        for (int i = 0; i < count; i++) {
            float point[3];
            point_of_wall(wall, (float)i * step, (float)j * step, point);
            for (int k = 0; k < 3; k++) point[k] -= 8 * direction[k];
            add_ray(list, point, direction);
        }
    }
    list->row_length = (uint32_t)count;
}

/* Lets some rays pass what they would hit, and ends others there. */
static void restrict_at_hits(const struct fixture *fixture, struct ray_list *list, uint32_t seed)
{
    struct random random = {seed};
    struct reference_hit *hits = allocate_or_fail(list->count, sizeof *hits);
    trace_reference(fixture, list, hits);
    for (size_t i = 0; i < list->count; i++) {
        struct reference_ray *ray = &list->rays[i];
        if (hits[i].mesh == MLRT_NONE) continue;
        switch (draw_below(&random, 4)) {
        case 0:
            ray->skip[0] = hits[i].mesh;
            ray->skip[1] = hits[i].triangle;
            break;
        case 1:
            ray->t_max = hits[i].t;
            break;
        case 2:
            ray->t_min = next_float(hits[i].t, -1);
            break;
        default:
            break;
        }
    }
    free(hits);
}

static const float eye_at_wall[3] = {3, -6, 5};

static void check_walls(const struct wall *wall, const struct cut *cuts, int cut_count, int thorough)
{
    struct soup soup = {0};
    struct ray_list list = {0};
    for (int i = 0; i < cut_count; i++) add_wall(&soup, wall, &cuts[i]);
    struct fixture fixture = fixture_of_soup("walls", 1, &soup);
    aim_at_wall(&list, wall, eye_at_wall, 0.5f, 0);
    (thorough ? check_rays : check_rays_quickly)(&fixture, &list);
    restrict_at_hits(&fixture, &list, 1);
    check_rays_quickly(&fixture, &list);
    free_rays(&list);
    aim_at_wall(&list, wall, eye_at_wall, 0.375f, 0.0625f); // inside: mostly
    check_rays_quickly(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

static void walls_cut_in_two_ways(void **state)
{
    (void)state;
    static const struct cut cuts[][2] = {{{1, 0, 0}, {1, 1, 0}}, {{1, 1, 1}, {4, 0, 0}}, {{8, 0, 0}, {2, 1, 1}}};
    for (int i = 0; i < 3; i++) check_walls(i == 1 ? &slope : &oblique, cuts[i], 2, i == 2);
}

static void walls_cut_in_four_ways(void **state)
{
    (void)state;
    static const struct cut cuts[4] = {{2, 0, 1}, {1, 1, 0}, {8, 0, 0}, {4, 1, 1}};
    struct cut backwards[4];
    for (int i = 0; i < 4; i++) backwards[i] = cuts[3 - i];
    check_walls(&oblique, cuts, 4, 0);
    check_walls(&slope, backwards, 4, 0);
}

static void walls_from_scattered_origins(void **state)
{
    (void)state;
    static const struct cut cuts[2] = {{1, 0, 0}, {4, 1, 1}};
    static const float directions[][3] = {{0, 0, -1}, {-0.25f, 0.5f, 1}, {1, 0, 0}};
    for (int order = 0; order < 2; order++) {
        struct soup soup = {0};
        struct ray_list list = {0};
        for (int i = 0; i < 2; i++) add_wall(&soup, &oblique, &cuts[order ? 1 - i : i]);
        struct fixture fixture = fixture_of_soup("walls", 2, &soup);
        for (int i = 0; i < 3; i++) aim_along(&list, &oblique, directions[i], 0.5f);
        restrict_at_hits(&fixture, &list, 2);
        check_rays_quickly(&fixture, &list);
        free_rays(&list);
        free_fixture(&fixture);
    }
}

/* Walls in a row, one float apart or not at all: which two share a plane changes from one triangle to the next. */
static void walls_that_only_seem_to_tie(void **state)
{
    (void)state;
    struct random random = {3};
    struct soup soup = {0};
    struct ray_list list = {0};
    for (int i = 0; i < 6; i++) {
        const struct cut cut = {1 << i % 4, i / 2 % 2, i % 2};
        const size_t first = soup.count;
        add_wall(&soup, &oblique, &cut);
        for (size_t n = 9 * first; n < 9 * soup.count; n++) {
            if (draw_below(&random, 12) == 0)
                soup.corners[n] = next_float(soup.corners[n], draw_below(&random, 2) ? 1 : -1);
        }
    }
    struct fixture fixture = fixture_of_soup("walls that seem to tie", 3, &soup);
    aim_at_wall(&list, &oblique, eye_at_wall, 0.3125f, 0.125f);
    check_rays_quickly(&fixture, &list);
    restrict_at_hits(&fixture, &list, 3);
    check_rays_quickly(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

/*
 * A large triangle against many small ones of its plane and many beside it, numbered so that remembered answers for
 * pairs (table of a power of two, by numbers) are for other pairs most of the time.
 */
static void many_pairs_of_planes(void **state)
{
    (void)state;
    struct soup soup = {0};
    struct ray_list list = {0};
    const struct cut whole = {8, 0, 0}, small = {1, 1, 0};
    struct wall behind = oblique, before = oblique;
    behind.corner[2] = next_float(behind.corner[2], 1);
    before.corner[2] = next_float(before.corner[2], -1);
    add_wall(&soup, &oblique, &small);
    add_wall(&soup, &behind, &small);
    add_wall(&soup, &oblique, &whole);
    add_wall(&soup, &before, &whole);
    add_wall(&soup, &oblique, &small);
    struct fixture fixture = fixture_of_soup("many pairs", 4, &soup);
    aim_at_wall(&list, &oblique, eye_at_wall, 0.25f, 0.0625f);
    check_rays_quickly(&fixture, &list);
    free_rays(&list);
    const float other_eye[3] = {-3, 5, -6};
    aim_at_wall(&list, &oblique, other_eye, 0.25f, 0.0625f);
    check_rays_quickly(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

/* The same planes in trees traced in turn: what was remembered of one is not true of the next. */
static void trees_in_turn(void **state)
{
    (void)state;
    struct fixture fixtures[2];
    struct ray_list list = {0};
    for (int t = 0; t < 2; t++) {
        const struct cut cut = {2, 0, 0}, other_cut = {2, 1, 0};
        struct wall second = oblique;
        struct soup soup = {0};
        if (t) second.corner[0] = next_float(second.corner[0], 1);
        add_wall(&soup, &oblique, &cut);
        add_wall(&soup, &second, &other_cut);
        fixtures[t] = fixture_of_soup("in turn", (uint64_t)t, &soup);
    }
    aim_at_wall(&list, &oblique, eye_at_wall, 0.5f, 0.25f);
    for (int turn = 0; turn < 4; turn++) check_rays_quickly(&fixtures[turn % 2], &list);
    free_rays(&list);
    for (int t = 0; t < 2; t++) free_fixture(&fixtures[t]);
}

/* ---- corners ----------------------------------------------------------------------------------------------------- */

/* Triangles around a corner, like an umbrella; twice = once more, from another triangle on and with other vertices
 * first. */
static void add_fan(struct soup *soup, const float corner[3], int spokes, float depth, int twice)
{
    for (int n = 0; n < (twice ? 2 * spokes : spokes); n++) {
        float p[2][3];
        for (int side = 0; side < 2; side++) {
            const int spoke = (n + side + n / spokes * 3) % spokes;
            static const float x[8] = {1, 0.75f, 0, -0.625f, -1, -0.75f, 0, 0.5f},
                               y[8] = {0, 0.75f, 1.25f, 0.5f, 0, -0.5f, -1, -0.75f};
            p[side][0] = corner[0] + x[spoke % 8];
            p[side][1] = corner[1] + y[spoke % 8];
            p[side][2] = corner[2] + depth * (1 + 0.25f * (float)(spoke % 3));
        }
        if (n < spokes) {
            soup_add_triangle(soup, corner, p[0], p[1]);
        } else {
            soup_add_triangle(soup, p[1], p[0], corner);
        }
    }
}

/* Fans on a lattice, pointed at the eye and away from it, and rays through every corner and near it. */
static void fans_around_corners(void **state)
{
    (void)state;
    static const float eyes[][3] = {{0.5f, -0.25f, -7}, {-3, 2, 6}, {4, 4, 0}};
    for (int twice = 0; twice < 2; twice++) {
        struct soup soup = {0};
        struct ray_list list = {0};
        for (int n = 0; n < 9; n++) {
            const float corner[3] = {2.5f * (float)(n % 3 - 1), 2.5f * (float)(n / 3 - 1), 0.25f * (float)n};
            add_fan(&soup, corner, 8, n % 2 ? 0.5f : -0.5f, twice);
        }
        struct fixture fixture = fixture_of_soup("fans", 5, &soup);
        for (int e = 0; e < 3; e++) {
            for (int n = 0; n < 9 * 16; n++) {
                const int fan = n / 16;
                const float target[3] = {2.5f * (float)(fan % 3 - 1) + 0x1p-12f * (float)(n % 4 == 3),
                                         2.5f * (float)(fan / 3 - 1) + 0x1p-23f * (float)(n % 8 == 4),
                                         0.25f * (float)fan};
                add_ray_towards(&list, eyes[e], target);
            }
        }
        restrict_at_hits(&fixture, &list, 5);
        check_rays_quickly(&fixture, &list);
        free_rays(&list);
        free_fixture(&fixture);
    }
}

/* ---- everything more than once ----------------------------------------------------------------------------------- */

/* The soup again, `copies` times in all, with other vertices first, other windings and, each second time, backwards. */
static void multiply_soup(struct soup *soup, int copies)
{
    const size_t count = soup->count;
    for (int copy = 1; copy < copies; copy++) {
        for (size_t i = 0; i < count; i++) {
            float corner[3][3];
            memcpy(corner, soup->corners + 9 * (copy % 2 ? count - 1 - i : i), sizeof corner);
            const int first = (int)(i % 3), step = copy == 2 ? 2 : 1;
            soup_add_triangle(soup, corner[first], corner[(first + step) % 3], corner[(first + 2 * step) % 3]);
        }
    }
}

static void everything_more_than_once(void **state)
{
    (void)state;
    static const float eye[3] = {0.3f, -3, 0.5f}, target[3] = {0, 0, 0}, lo[3] = {-1, -0.5f, -0.75f},
                       hi[3] = {0.5f, 0.25f, 1};
    for (int copies = 2; copies <= 4; copies++) {
        struct random random = {6};
        struct soup soup = {0};
        struct ray_list list = {0};
        if (copies != 3) soup_add_torus(&soup, 12, 8, 1, 0.4f);
        if (copies == 3) soup_add_random(&soup, &random, 60, 1, 0.8f);
        soup_add_box(&soup, lo, hi);
        multiply_soup(&soup, copies);
        struct fixture fixture = fixture_of_soup("more than once", 6, &soup);
        mlrt_camera camera = look_at(eye, target, 1, 20, 20);
        add_camera_rays(&list, &camera);
        add_aimed_rays(&list, &random, &fixture, scaled(200), -2, 2);
        check_rays_quickly(&fixture, &list);
        restrict_at_hits(&fixture, &list, 6);
        check_rays_quickly(&fixture, &list);
        check_camera_quickly(&fixture, &camera);
        free_rays(&list);
        free_fixture(&fixture);
    }
}

/* Eyes in the planes of triangles and one float beside them, with rays to both sides of these and at others. */
static void eyes_in_planes(void **state)
{
    (void)state;
    static const struct cut cuts[2] = {{1, 0, 0}, {2, 1, 1}};
    struct soup soup = {0};
    for (int i = 0; i < 2; i++) add_wall(&soup, &oblique, &cuts[i]);
    for (int i = 0; i < 2; i++) add_wall(&soup, &slope, &cuts[i]);
    struct fixture fixture = fixture_of_soup("walls that cross", 7, &soup);
    for (int e = 0; e < 9; e++) {
        static const float along[3] = {0.25f, 0.5f, -1}, at[3] = {-0.25f, 0.125f, 1};
        struct ray_list list = {0};
        float eye[3];
        point_of_wall(&slope, 1.5f + (float)(e / 3), e / 3 == 2 ? -4 : 2.75f, eye);
        eye[2] = next_float(eye[2], e % 3 - 1);
        aim_at_wall(&list, &oblique, eye, 0.5f, 0);
        for (int n = 0; n < 128; n++) {
            float direction[3];
            for (int k = 0; k < 3; k++)
                direction[k] = (n / 16 % 2 ? along : at)[k] + 0x1p-6f * (float)(n * (k + 3) % 7);
            add_ray(&list, eye, direction);
        }
        check_rays_quickly(&fixture, &list);
        free_rays(&list);
    }
    free_fixture(&fixture);
}

/* Packets of one eye after those of another, in one call: nothing that was set up for an eye is good for the next. */
static void eyes_in_turn(void **state)
{
    (void)state;
    static const struct cut cuts[2] = {{4, 0, 0}, {8, 1, 1}};
    struct soup soup = {0};
    struct ray_list list = {0};
    for (int i = 0; i < 2; i++) add_wall(&soup, &oblique, &cuts[i]);
    for (int i = 0; i < 2; i++) add_wall(&soup, &slope, &cuts[i]);
    struct fixture fixture = fixture_of_soup("eyes in turn, walls", 10, &soup);
    for (int n = 0; n < 40 * 16; n++) {
        const float side = (float)(n / 16 % 5), eye[3] = {side, -0.5f * side, 9 + 0.25f * side};
        const float target[3] = {0.125f * (float)(n % 4) + 0.25f * (float)(n / 80), 0.125f * (float)(n / 4 % 4) - 1, 0};
        add_ray_towards(&list, eye, target);
    }
    check_rays_quickly(&fixture, &list);
    free_fixture(&fixture);
    add_part(&soup, (float[4][3]){{-4, -4, -2}, {8, -4, 4}, {-4, 8, -2}, {0, 0, 0}}, &cuts[0], 0, 1, 2);
    fixture = fixture_of_soup("eyes in turn, one triangle", 10, &soup);
    check_rays_quickly(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

/*
 * A large triangle with a vertex close to the eye, which is a little off its plane: where rays meet it, if they do, is
 * decided by directions that differ from the plane's in their last bits.
 */
static void rays_nearly_in_a_plane(void **state)
{
    (void)state;
    struct random random = {11};
    for (int n = 0; n < 60; n++) {
        struct soup soup = {0};
        struct ray_list list = {0};
        float corner[3][3], eye[3], normal[3];
        draw_point(&random, -0x1p-6f, 0x1p-6f, corner[0]);
        draw_point(&random, -64, 64, corner[1]);
        draw_point(&random, -64, 64, corner[2]);
        soup_add_triangle(&soup, corner[0], corner[1], corner[2]);
        for (int k = 0; k < 3; k++) {
            const int i = (k + 1) % 3, j = (k + 2) % 3;
            normal[k] = (corner[1][i] * corner[2][j] - corner[1][j] * corner[2][i]) * 0x1p-12f;
        }
        const int exponent = -18 - (int)draw_below(&random, 8);
        const float height = ldexpf(draw_below(&random, 2) ? 1 : -1, exponent);
        for (int k = 0; k < 3; k++) eye[k] = corner[0][k] + 0x1p-11f * corner[1][k] + height * normal[k];
        struct fixture fixture = fixture_of_soup("nearly in a plane", 11, &soup);
        for (int r = 0; r < 64; r++) {
            const float u = draw_range(&random, 0, 0.5f), v = draw_range(&random, 0, 0.5f);
            float target[3];
            for (int k = 0; k < 3; k++)
                target[k] = corner[0][k] + u * (corner[1][k] - corner[0][k]) + v * (corner[2][k] - corner[0][k]);
            add_ray_towards(&list, eye, target);
        }
        check_rays_quickly(&fixture, &list);
        free_rays(&list);
        free_fixture(&fixture);
    }
}

/* ---- counting ---------------------------------------------------------------------------------------------------- */

static mlrt_counters count_work(const struct fixture *fixture, const struct ray_list *list, int32_t method, int32_t isa)
{
    mlrt_counters counters = {.struct_size = sizeof counters};
    mlrt_trace_options options = {.struct_size = sizeof options, .method = method, .isa = isa, .counters = &counters};
    struct reference_hit *expected = allocate_or_fail(list->count, sizeof *expected);
    struct reference_hit *got = allocate_or_fail(list->count, sizeof *got);
    mlrt_rays rays = public_rays(list);
    mlrt_hits hits = public_hits(got, 0);
    const mlrt_tree *tree = method == MLRT_METHOD_TILE ? fixture->tree : fixture->kdtree;
    trace_reference(fixture, list, expected);
    assert_int_equal(mlrt_trace_packet(tree, &rays, &options, &hits), MLRT_OK);
    for (size_t i = 0; i < list->count; i++) check_hit(fixture, "counting", i, &list->rays[i], &expected[i], &got[i]);
    free(expected);
    free(got);
    return counters;
}

/*
 * Walls drawn twice: packets settle nearly all of it without the judge, and methods that count give the same answers.
 */
static void ties_rarely_go_to_the_judge(void **state)
{
    (void)state;
    static const struct cut cuts[2] = {{4, 0, 0}, {1, 1, 1}};
    static const int32_t methods[] = {MLRT_METHOD_PACKET2, MLRT_METHOD_PACKET4, MLRT_METHOD_MULTILEVEL};
    struct soup soup = {0};
    struct ray_list list = {0};
    for (int i = 0; i < 2; i++) add_wall(&soup, &oblique, &cuts[i]);
    struct fixture fixture = fixture_of_soup("walls", 8, &soup);
    aim_at_wall(&list, &oblique, eye_at_wall, 0.125f, 0.046875f);
    for (int m = 0; m < 3; m++) {
        for (int32_t isa = MLRT_ISA_AUTO; isa <= MLRT_ISA_NEON; isa++) {
            if (!isa_is_supported(isa)) continue;
            const mlrt_counters counters = count_work(&fixture, &list, methods[m], isa);
            assert_int_equal(counters.ray_count, list.count);
            assert_true(counters.tie_lane_count >= list.count / 2);
            assert_true(counters.judged_lane_count <= list.count / 4);
            assert_true(counters.lane_test_count >= counters.tie_lane_count + counters.judged_lane_count);
            assert_int_equal(counters.exact_order_count, 0);
        }
    }
    free_rays(&list);
    free_fixture(&fixture);
}

/* Rays from anywhere in one direction have nothing but that in common: a packet of them must not visit all between. */
static void scattered_origins_are_not_slow(void **state)
{
    (void)state;
    static const float directions[][3] = {{0, 0, 1}, {-1, 0, 0}, {0.25f, -1, 0.5f}, {1, 1, 1}};
    static const int32_t methods[] = {MLRT_METHOD_PACKET4, MLRT_METHOD_MULTILEVEL};
    struct random random = {9};
    struct soup soup = {0};
    soup_add_icosphere(&soup, 4, 1);
    struct fixture fixture = fixture_of_soup("sphere", 9, &soup);
    for (int i = 0; i < 4; i++) {
        struct ray_list list = {0};
        for (size_t n = 0; n < scaled(1024); n++) {
            float point[3];
            draw_point(&random, -1, 1, point);
            for (int k = 0; k < 3; k++) point[k] -= 3 * directions[i][k];
            add_ray(&list, point, directions[i]);
        }
        const mlrt_counters single = count_work(&fixture, &list, MLRT_METHOD_RAY, MLRT_ISA_AUTO);
        for (int m = 0; m < 2; m++) {
            const mlrt_counters counters = count_work(&fixture, &list, methods[m], MLRT_ISA_AUTO);
            assert_true(counters.triangle_test_count <= 2 * single.triangle_test_count);
            assert_true(counters.cell_count <= 4 * single.cell_count);
        }
        if (i % 2 == 0) check_rays_quickly(&fixture, &list);
        free_rays(&list);
    }
    free_fixture(&fixture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(walls_cut_in_two_ways),
        cmocka_unit_test(walls_cut_in_four_ways),
        cmocka_unit_test(walls_from_scattered_origins),
        cmocka_unit_test(walls_that_only_seem_to_tie),
        cmocka_unit_test(many_pairs_of_planes),
        cmocka_unit_test(trees_in_turn),
        cmocka_unit_test(fans_around_corners),
        cmocka_unit_test(everything_more_than_once),
        cmocka_unit_test(eyes_in_planes),
        cmocka_unit_test(eyes_in_turn),
        cmocka_unit_test(rays_nearly_in_a_plane),
        cmocka_unit_test(ties_rarely_go_to_the_judge),
        cmocka_unit_test(scattered_origins_are_not_slow),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
