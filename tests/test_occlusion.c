/* SPDX-License-Identifier: MIT */
/*
 * mlrt_occluded_points: points and lights against the shadow rays that they stand for.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

enum { GUARD = 0xA5 };

struct points {
    float *positions;
    uint32_t *skip;
    size_t count;
    uint32_t row_length;
};

static struct points make_points(size_t count)
{
    struct points points = {allocate_or_fail(count, 12), allocate_or_fail(count, 8), count, 0};
    for (size_t i = 0; i < 2 * count; i++) points.skip[i] = MLRT_NONE;
    return points;
}

static void free_points(struct points *points)
{
    free(points->positions);
    free(points->skip);
}

static void check(const struct fixture *fixture, const struct points *points, const mlrt_light *light)
{
    check_points(fixture, points->positions, points->skip, points->count, points->row_length, light);
}

/* Compares rays that have one origin, or one direction, in the tile method with each of them alone. */
static void check_shared_vector(const struct fixture *fixture, const struct points *points, const float one[3],
                                int is_origin)
{
    const mlrt_const_array all = {one, MLRT_STRIDE_ALL}, each = {points->positions, 0};
    const mlrt_rays rays = {.struct_size = sizeof rays,
                            .count = points->count,
                            .row_length = points->row_length,
                            .origins = is_origin ? all : each,
                            .directions = is_origin ? each : all,
                            .skip = {points->skip, 0}};
    mlrt_trace_options options = {.struct_size = sizeof options, .query = MLRT_QUERY_ANY, .method = MLRT_METHOD_RAY};
    uint8_t *expected = allocate_or_fail(points->count, 1), *got = allocate_or_fail(points->count, 1);
    mlrt_hits hits = {.struct_size = sizeof hits, .occluded = {expected, 0, 0}};
    assert_int_equal(mlrt_trace_packet(fixture->tree, &rays, &options, &hits), MLRT_OK);
    hits.occluded.data = got;
    options.method = MLRT_METHOD_TILE;
    for (int32_t isa = MLRT_ISA_SCALAR; isa <= MLRT_ISA_NEON; isa++) {
        options.isa = isa;
        if (isa_is_supported(isa)) {
            assert_int_equal(mlrt_trace_packet(fixture->tree, &rays, &options, &hits), MLRT_OK);
            assert_memory_equal(expected, got, points->count);
        }
    }
    free(expected);
    free(got);
}

static struct fixture boxes(void)
{
    struct random random = {2};
    struct soup soup = {0};
    const float lo[3] = {-4, -4, -1}, hi[3] = {4, 4, 4};
    soup_add_box(&soup, lo, hi);
    for (int i = 0; i < 24; i++) {
        float from[3], to[3];
        for (int k = 0; k < 3; k++) {
            from[k] = (float)draw_below(&random, 6) - 3;
            to[k] = from[k] + 0.5f + 0.25f * (float)draw_below(&random, 4);
        }
        soup_add_box(&soup, from, to);
    }
    return fixture_of_soup("boxes", 2, &soup);
}

/* What a picture sees: hit points moved off their surfaces, the surfaces in `skip`. Misses become points far away. */
static struct points seen_points(const struct fixture *fixture, const mlrt_camera *camera)
{
    struct ray_list list = {0};
    add_camera_rays(&list, camera);
    struct points points = make_points(list.count);
    points.row_length = list.row_length;
    for (size_t i = 0; i < list.count; i++) {
        struct reference_hit hit;
        float *point = points.positions + 3 * i;
        reference_trace(fixture->reference, &list.rays[i], &hit);
        for (int k = 0; k < 3; k++) point[k] = 1000 * list.rays[i].direction[k];
        if (hit.mesh == MLRT_NONE) continue;
        int32_t status = mlrt_offset_point(fixture->tree, hit.mesh, hit.triangle, hit.u, hit.v, -hit.facing, point);
        assert_int_equal(status, MLRT_OK);
        points.skip[2 * i] = hit.mesh;
        points.skip[2 * i + 1] = hit.triangle;
    }
    free_rays(&list);
    return points;
}

static struct points points_of_boxes(const struct fixture *fixture, uint32_t width, uint32_t height)
{
    const float eye[3] = {-3.5f, -3.25f, 2.5f}, target[3] = {1, 1, 0};
    mlrt_camera camera = look_at(eye, target, 1.3f, width, height);
    return seen_points(fixture, &camera);
}

static void point_lights_inside_the_scene(void **state)
{
    (void)state;
    struct random random = {3};
    struct fixture fixture = boxes();
    struct points points = points_of_boxes(&fixture, 48, 40);
    for (size_t i = 0; i < scaled(8); i++) {
        float position[3];
        draw_point(&random, -3.9f, 3.9f, position);
        mlrt_light light = light_at(position[0], position[1], position[2]);
        check(&fixture, &points, &light);
    }
    free_points(&points);
    free_fixture(&fixture);
}

static void point_lights_outside_the_scene(void **state)
{
    (void)state;
    struct fixture fixture = boxes();
    struct points points = points_of_boxes(&fixture, 40, 40);
    mlrt_light lights[] = {light_at(0, 0, 10), light_at(100, 3, 0), light_at(1e6f, 1e6f, 1e6f), light_at(-1e30f, 0, 5)};
    for (size_t i = 0; i < sizeof lights / sizeof lights[0]; i++) check(&fixture, &points, &lights[i]);
    free_points(&points);
    free_fixture(&fixture);
}

static void lights_on_planes_edges_and_vertices(void **state)
{
    (void)state;
    struct fixture fixture = boxes();
    struct points points = points_of_boxes(&fixture, 40, 30);
    mlrt_light lights[] = {light_at(0, 0, 4), light_at(4, 4, 4),    light_at(4, 0, 4),
                           light_at(1, 1, 1), light_at(0, 0.5f, 0), light_at(-0.0f, 0.0f, -0.0f)};
    for (size_t i = 0; i < sizeof lights / sizeof lights[0]; i++) check(&fixture, &points, &lights[i]);
    free_points(&points);
    free_fixture(&fixture);
}

static void directional_lights(void **state)
{
    (void)state;
    struct random random = {4};
    struct fixture fixture = boxes();
    struct points points = points_of_boxes(&fixture, 40, 40);
    for (size_t i = 0; i < scaled(6); i++) {
        float direction[3];
        draw_point(&random, -1, 1, direction);
        mlrt_light light = light_from(direction[0], direction[1], direction[2]);
        check(&fixture, &points, &light);
    }
    free_points(&points);
    free_fixture(&fixture);
}

static void directional_lights_along_axes(void **state)
{
    (void)state;
    struct fixture fixture = boxes();
    struct points points = points_of_boxes(&fixture, 33, 33);
    for (int axis = 0; axis < 3; axis++) {
        for (int back = 0; back < 2; back++) {
            mlrt_light light = light_from(-0.0f, 0.0f, -0.0f);
            light.position[axis] = back ? -1.0f : 1.0f;
            check(&fixture, &points, &light);
        }
    }
    free_points(&points);
    free_fixture(&fixture);
}

static void the_length_of_a_light_direction_does_not_matter(void **state)
{
    (void)state;
    static const float lengths[] = {1e-44f, 1e-38f, 1e-20f, 1e20f, 1e38f};
    struct fixture fixture = boxes();
    struct points points = points_of_boxes(&fixture, 20, 20);
    for (size_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++) {
        mlrt_light light = light_from(0.5f * lengths[i], 0.25f * lengths[i], lengths[i]);
        check(&fixture, &points, &light);
    }
    free_points(&points);
    free_fixture(&fixture);
}

/* Points on vertices and edges themselves, and on a lattice that faces run through. */
static void points_on_surfaces(void **state)
{
    (void)state;
    struct random random = {5};
    struct fixture fixture = boxes();
    size_t triangle_count = reference_triangle_count(fixture.reference);
    struct points points = make_points(600);
    for (size_t i = 0; i < points.count; i++) {
        uint32_t number = draw_below(&random, (uint32_t)triangle_count);
        const struct reference_triangle *triangle = reference_triangle_at(fixture.reference, number);
        float *point = points.positions + 3 * i;
        memcpy(point, triangle->corner[i % 3], 12);
        if (i % 2) {
            points.skip[2 * i] = triangle->mesh;
            points.skip[2 * i + 1] = triangle->triangle;
        }
        if (i % 5 == 0) {
            for (int k = 0; k < 3; k++) point[k] = 0.25f * (float)draw_below(&random, 32) - 4;
        }
    }
    mlrt_light lights[] = {light_at(0.5f, 0.5f, 3.5f), light_at(0, 0, 0), light_from(0, 0, 1), light_from(1, 1, 0)};
    for (size_t i = 0; i < sizeof lights / sizeof lights[0]; i++) check(&fixture, &points, &lights[i]);
    free_points(&points);
    free_fixture(&fixture);
}

static void a_point_at_the_light_is_lit(void **state)
{
    (void)state;
    struct fixture fixture = boxes();
    struct points points = points_of_boxes(&fixture, 20, 20);
    for (size_t i = 0; i < points.count; i += 7) {
        float *point = points.positions + 3 * i;
        point[0] = 1.5f;
        point[1] = 0.5f;
        point[2] = 3.5f;
    }
    mlrt_light light = light_at(1.5f, 0.5f, 3.5f);
    check(&fixture, &points, &light);
    free_points(&points);
    free_fixture(&fixture);
}

static void points_that_are_not_finite_are_lit(void **state)
{
    (void)state;
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    struct fixture fixture = boxes();
    struct points points = points_of_boxes(&fixture, 24, 24);
    for (size_t i = 0; i < points.count; i += 5) points.positions[3 * i + i % 3] = bad[i % 3];
    mlrt_light lights[] = {light_at(0.3f, 0.2f, 3), light_from(0.3f, 0.2f, 3)};
    check(&fixture, &points, &lights[0]);
    check(&fixture, &points, &lights[1]);
    free_points(&points);
    free_fixture(&fixture);
}

/* P - light overflows float: the direction is infinite, so the ray hits nothing. */
static void directions_that_overflow_are_lit(void **state)
{
    (void)state;
    struct fixture fixture = boxes();
    struct points points = points_of_boxes(&fixture, 12, 12);
    for (size_t i = 0; i < points.count; i += 3) points.positions[3 * i] = 3e38f;
    mlrt_light light = light_at(-3e38f, 0, 0);
    check(&fixture, &points, &light);
    free_points(&points);
    free_fixture(&fixture);
}

/* Differences of points and the middle of the scene overflow float, those of rays and triangles do not. */
static void points_far_beyond_a_distant_scene(void **state)
{
    (void)state;
    const float x = -0x1p110f, sun[3] = {-1, 0, 0};
    const float corner[3] = {x, -1e30f, -1e30f}, side[3] = {0, 3e30f, 0}, other_side[3] = {0, 0, 3e30f};
    struct soup soup = {0};
    soup_add_quad(&soup, corner, side, other_side);
    struct fixture fixture = fixture_of_soup("a distant wall", 8, &soup);
    struct points points = make_points(4096);
    points.row_length = 64;
    for (size_t i = 0; i < points.count; i++) {
        points.positions[3 * i] = FLT_MAX;
        points.positions[3 * i + 1] = (float)(i % 64) * 1e27f;
        points.positions[3 * i + 2] = (float)(i / 64) * 1e27f;
    }
    const mlrt_light light = light_from(sun[0], sun[1], sun[2]);
    check(&fixture, &points, &light);
    check_shared_vector(&fixture, &points, sun, 0);
    free_points(&points);
    free_fixture(&fixture);
}

/* The end of the interval belongs to it: a surface through the point itself is in the way unless it is skipped. */
static void a_surface_at_the_point_shades_it_unless_skipped(void **state)
{
    (void)state;
    const float a[3] = {0, 0, 1}, b[3] = {4, 0, 1}, c[3] = {0, 4, 1};
    struct soup soup = {0};
    soup_add_triangle(&soup, a, b, c);
    struct fixture fixture = fixture_of_soup("one triangle", 0, &soup);
    const float position[3] = {1, 1, 1};
    uint32_t skip[2] = {0, 0};
    uint8_t got = 9;
    mlrt_light light = light_at(1, 1, 0);
    mlrt_points points = {.struct_size = sizeof points, .count = 1, .positions = {position, 0}};
    mlrt_array out = {&got, 0, 0};
    assert_int_equal(mlrt_occluded_points(fixture.tree, &points, &light, NULL, &out), MLRT_OK);
    assert_int_equal(got, 1);
    points.skip.data = skip;
    assert_int_equal(mlrt_occluded_points(fixture.tree, &points, &light, NULL, &out), MLRT_OK);
    assert_int_equal(got, 0);
    free_fixture(&fixture);
}

static void a_surface_at_the_light_does_not_shade(void **state)
{
    (void)state;
    const float a[3] = {0, 0, 1}, b[3] = {4, 0, 1}, c[3] = {0, 4, 1};
    struct soup soup = {0};
    soup_add_triangle(&soup, a, b, c);
    struct fixture fixture = fixture_of_soup("light on a triangle", 0, &soup);
    struct points points = make_points(64);
    struct random random = {6};
    for (size_t i = 0; i < points.count; i++) draw_point(&random, -1, 3, points.positions + 3 * i);
    mlrt_light light = light_at(1, 1, 1);
    check(&fixture, &points, &light);
    free_points(&points);
    free_fixture(&fixture);
}

/* A square of points over x and y, `step` apart, in rows. */
static struct points make_square(uint32_t side, float step)
{
    struct points points = make_points((size_t)side * side);
    points.row_length = side;
    for (size_t i = 0; i < points.count; i++) {
        points.positions[3 * i] = step * (float)(i % side);
        points.positions[3 * i + 1] = step * (float)(i / side);
    }
    return points;
}

static void points_behind_and_before_a_depth_step(void **state)
{
    (void)state;
    struct soup soup = {0};
    soup_add_grid(&soup, 2, 0, 8);
    soup_add_grid(&soup, 2, 4, 3);
    struct fixture fixture = fixture_of_soup("a step", 0, &soup);
    struct points points = make_square(40, 0.2f);
    for (size_t i = 0; i < points.count; i++) {
        points.positions[3 * i + 2] = (i % 40 + i / 40) % 3 ? 0 : 4;
        if (i % 4 == 0) points.positions[3 * i + 2] = next_float(points.positions[3 * i + 2], 1);
    }
    mlrt_light lights[] = {light_at(1.5f, 1.5f, 9), light_at(4, 4, 2), light_at(3, 3, 4), light_from(0.1f, 0, 1)};
    for (size_t i = 0; i < sizeof lights / sizeof lights[0]; i++) check(&fixture, &points, &lights[i]);
    free_points(&points);
    free_fixture(&fixture);
}

/* A triangle covers whole packets as seen from the light, but only some of their points are behind it. */
static void points_on_both_sides_of_one_triangle(void **state)
{
    (void)state;
    const float a[3] = {-9, -9, 1}, b[3] = {9, -9, 1}, c[3] = {0, 18, 1};
    struct random random = {7};
    struct soup soup = {0};
    soup_add_triangle(&soup, a, b, c);
    struct fixture fixture = fixture_of_soup("one triangle", 7, &soup);
    struct points points = make_square(32, 0.01f);
    for (size_t i = 0; i < points.count; i++) {
        points.positions[3 * i + 2] = draw_below(&random, 3) ? draw_range(&random, 0.99f, 1.01f) : 1.01f;
    }
    const mlrt_light lights[] = {light_at(0.1f, 0.2f, 0), light_from(0.1f, 0.2f, 1), light_from(0.1f, 0.2f, -1)};
    for (size_t i = 0; i < sizeof lights / sizeof lights[0]; i++) check(&fixture, &points, &lights[i]);
    free_points(&points);
    free_fixture(&fixture);
}

static void scenes_of_every_scale(void **state)
{
    (void)state;
    static const float scales[] = {1e-38f, 1e-30f, 1e-10f, 1e10f, 1e30f, 1e37f};
    for (uint64_t i = 0; i < sizeof scales / sizeof scales[0]; i++) {
        const float zero[3] = {0, 0, 0};
        struct random random = {70 + i};
        struct soup soup = {0};
        soup_add_random(&soup, &random, 150, 1, 0.3f);
        move_soup(&soup, scales[i], zero);
        struct fixture fixture = fixture_of_soup("scaled", 70 + i, &soup);
        struct points points = make_points(scaled(400));
        for (size_t p = 0; p < points.count; p++) draw_point(&random, -scales[i], scales[i], points.positions + 3 * p);
        mlrt_light lights[] = {light_at(0.1f * scales[i], 0.2f * scales[i], 2 * scales[i]), light_from(1, -2, 0.5f)};
        check(&fixture, &points, &lights[0]);
        check(&fixture, &points, &lights[1]);
        free_points(&points);
        free_fixture(&fixture);
    }
}

static void every_count_up_to_40(void **state)
{
    (void)state;
    struct fixture fixture = boxes();
    struct points points = points_of_boxes(&fixture, 40, 1);
    mlrt_light light = light_at(0.5f, 0.25f, 3.5f);
    for (points.count = 0; points.count <= 40; points.count++) {
        points.row_length = (uint32_t)(points.count % 3) * 4;
        check(&fixture, &points, &light);
    }
    free_points(&points);
    free_fixture(&fixture);
}

static void the_room_with_its_light(void **state)
{
    (void)state;
    const float eye[3] = {1, 1, 1.5f}, target[3] = {2, 2.5f, 1};
    struct fixture fixture = fixture_of_example("room");
    mlrt_camera camera = look_at(eye, target, 1.3f, 64, 48);
    struct points points = seen_points(&fixture, &camera);
    mlrt_light light = light_at(2, 2, 2.2f);
    check(&fixture, &points, &light);
    free_points(&points);
    free_fixture(&fixture);
}

static void an_empty_tree_shades_nothing(void **state)
{
    (void)state;
    struct fixture fixture = make_fixture("empty", 0, NULL, 0);
    struct points points = make_points(30);
    mlrt_light light = light_at(1, 2, 3);
    check(&fixture, &points, &light);
    free_points(&points);
    free_fixture(&fixture);
}

static void strides_of_points_and_results(void **state)
{
    (void)state;
    struct fixture fixture = boxes();
    struct points points = points_of_boxes(&fixture, 12, 10);
    uint8_t packed[120];
    mlrt_light light = light_at(0.5f, 0.25f, 3.5f);
    mlrt_points in = {
        .struct_size = sizeof in, .count = 120, .positions = {points.positions, 0}, .skip = {points.skip, 0}};
    mlrt_array out = {packed, 0, 0};
    assert_int_equal(mlrt_occluded_points(fixture.tree, &in, &light, NULL, &out), MLRT_OK);

    // Records of 28 bytes, at 4 mod 8: skip before position; results 5 bytes apart.
    unsigned char *records = allocate_or_fail(4 + 120 * 28, 1), results[5 * 120 + 3];
    for (size_t i = 0; i < 120; i++) {
        memcpy(records + 4 + 28 * i, points.skip + 2 * i, 8);
        memcpy(records + 4 + 28 * i + 12, points.positions + 3 * i, 12);
    }
    memset(results, GUARD, sizeof results);
    in.positions = (mlrt_const_array){records + 4 + 12, 28};
    in.skip = (mlrt_const_array){records + 4, 28};
    out = (mlrt_array){results + 1, 5, 0};
    assert_int_equal(mlrt_occluded_points(fixture.tree, &in, &light, NULL, &out), MLRT_OK);
    for (size_t i = 0; i < sizeof results; i++) {
        int is_element = i >= 1 && (i - 1) % 5 == 0 && (i - 1) / 5 < 120;
        assert_int_equal(results[i], is_element ? packed[(i - 1) / 5] : GUARD);
    }
    free(records);
    free_points(&points);
    free_fixture(&fixture);
}

enum { WALL_WIDTH = 150, WALL_HEIGHT = 131 };

/*
 * Points in rows over a wall, many to a triangle, so that whole tiles of them are seen from a light as one cell: lit,
 * behind one triangle, or none of them finite.
 */
static struct points points_of_wall(float height)
{
    struct points points = make_points((size_t)WALL_WIDTH * WALL_HEIGHT);
    points.row_length = WALL_WIDTH;
    for (size_t i = 0; i < points.count; i++) {
        const size_t x = i % WALL_WIDTH, y = i / WALL_WIDTH;
        float *point = points.positions + 3 * i;
        point[0] = (float)x / 16 - 4.5f;
        point[1] = (float)y / 16 - 4;
        point[2] = height;
        if (x >= 96 && y >= 96) point[y % 3] = x % 2 ? NAN : INFINITY;
        if (i % 7001 == 0) point[0] = NAN;
        points.skip[2 * i] = 0;
        points.skip[2 * i + 1] = x < 72 ? 0 : 2;
    }
    return points;
}

/* The wall is there twice, and points lie before it, in it or behind it: only one of its triangles is skipped. */
static void squares_of_points(void **state)
{
    (void)state;
    const float corner[3] = {-9, -9, 0}, side[3] = {18, 0, 0}, other_side[3] = {0, 18, 0}, tilted[3] = {0, 18, 0.25f};
    const float lo[3] = {-3, -3, 1}, hi[3] = {0, -1, 1.5f};
    const float heights[] = {0.001f, 0, -0.001f, 2};
    struct soup soup = {0};
    soup_add_quad(&soup, corner, side, other_side);
    soup_add_quad(&soup, corner, other_side, side);
    soup_add_quad(&soup, corner, side, tilted);
    soup_add_box(&soup, lo, hi);
    struct fixture fixture = fixture_of_soup("a doubled wall", 7, &soup);
    for (size_t i = 0; i < sizeof heights / sizeof heights[0]; i++) {
        struct points points = points_of_wall(heights[i]);
        const mlrt_light lights[] = {light_at(-1, -2, 3),       light_from(0.25f, 0.5f, 1), light_at(40, 1, 0.5f),
                                     light_at(0.5f, 0.25f, -4), light_from(0, 0, -1e-30f),  light_from(1, 0.5f, 0.01f)};
        for (size_t l = i % 2; l < 2 * scaled(3); l += 2) {
            if ((i + l) / 2 % 2) { /* nothing is skipped */
                check_points(&fixture, points.positions, NULL, points.count, points.row_length, &lights[l]);
            } else {
                check(&fixture, &points, &lights[l]);
            }
            check_shared_vector(&fixture, &points, lights[l].position, lights[l].kind == MLRT_LIGHT_POINT);
        }
        free_points(&points);
    }
    free_fixture(&fixture);
}

/* Points in a wall, of which those in one square skip different triangles: the wall shades those that skip another. */
static void squares_that_skip_two_triangles(void **state)
{
    (void)state;
    const float corner[3] = {-9, -9, 0}, side[3] = {18, 0, 0}, other_side[3] = {0, 18, 0};
    struct soup soup = {0};
    soup_add_quad(&soup, corner, side, other_side);
    struct fixture fixture = fixture_of_soup("a wall", 7, &soup);
    struct points points = points_of_wall(0);
    const mlrt_light lights[] = {light_at(-1, -2, 3), light_from(0.25f, 0.5f, 1)};
    for (size_t l = 0; l < sizeof lights / sizeof lights[0]; l++) check(&fixture, &points, &lights[l]);
    free_points(&points);
    free_fixture(&fixture);
}

/*
 * Points in the shadow of a wall. Of each square of sixteen all points of some blocks of 4x4 are not finite: of the
 * last ones, the first ones, or any, while the others are behind the wall.
 */
static void squares_of_which_whole_blocks_are_not_finite(void **state)
{
    (void)state;
    static const uint32_t blocks_of[] = {0x8000, 0xFFFE, 0x0001, 0x7FFF, 0xF000, 0x0F0F, 0x5A5A};
    const float corner[3] = {-90, -90, 0}, side[3] = {180, 0, 0}, other_side[3] = {0, 180, 0};
    struct soup soup = {0};
    soup_add_quad(&soup, corner, side, other_side);
    struct fixture fixture = fixture_of_soup("a wall", 7, &soup);
    const mlrt_light lights[] = {light_at(-1, -2, 3), light_from(0.25f, 0.5f, 1)};
    for (size_t i = 0; i < sizeof blocks_of / sizeof *blocks_of; i++) {
        struct points points = points_of_wall(-2);
        for (size_t k = 0; k < points.count; k++) {
            const size_t block = k % WALL_WIDTH % 16 / 4 + k / WALL_WIDTH % 16 / 4 * 4;
            points.skip[2 * k] = MLRT_NONE;
            if (blocks_of[i] >> block & 1) points.positions[3 * k + k % 3] = k % 2 ? NAN : INFINITY;
        }
        for (size_t l = 0; l < sizeof lights / sizeof *lights; l++) {
            check(&fixture, &points, &lights[l]);
            check_shared_vector(&fixture, &points, lights[l].position, lights[l].kind == MLRT_LIGHT_POINT);
        }
        free_points(&points);
    }
    free_fixture(&fixture);
}

enum { PLASTER_WIDTH = 64, PLASTER_HEIGHT = 48 };

static float moved_by_floats(float x, int32_t steps)
{
    int32_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits += steps;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* A parallelogram, and once more, cut along its other diagonal, with each coordinate up to `most` floats away. */
static void add_doubled_wall(struct soup *soup, struct random *random, const float corner[3], const float side[3],
                             const float other_side[3], uint32_t most)
{
    float corners[4][3];
    for (int k = 0; k < 3; k++) {
        corners[0][k] = corner[k];
        corners[1][k] = corner[k] + side[k];
        corners[2][k] = corner[k] + side[k] + other_side[k];
        corners[3][k] = corner[k] + other_side[k];
    }
    for (int copy = 0; copy < 2; copy++) {
        soup_add_triangle(soup, corners[copy], corners[copy + 1], corners[copy + 2]);
        soup_add_triangle(soup, corners[copy], corners[copy + 2], corners[(copy + 3) % 4]);
        for (int i = 0; i < 12; i++) {
            corners[i / 3][i % 3] =
                moved_by_floats(corners[i / 3][i % 3], (int32_t)draw_below(random, 2 * most + 1) - (int32_t)most);
        }
    }
}

/*
 * Points a few floats before and behind such a wall, many to a triangle, that skip one copy, the other, both by turns,
 * or none. So a square of them may be decided as a whole, or one point may be the exception.
 */
static struct points points_of_plaster(struct random *random, const float corner[3], const float side[3],
                                       const float other_side[3], float width)
{
    struct points points = make_points((size_t)PLASTER_WIDTH * PLASTER_HEIGHT);
    const float u = 0.1f + 0.5f * draw_range(random, 0, 1), v = 0.1f + 0.5f * draw_range(random, 0, 1);
    const int32_t height = ((int32_t)draw_below(random, 13) - 6) * (draw_below(random, 2) ? 1 : 12),
                  axis = (int32_t)draw_below(random, 3);
    const uint32_t wobble = draw_below(random, 3), skipping = draw_below(random, 5), rare = draw_below(random, 2);
    points.row_length = PLASTER_WIDTH;
    for (size_t i = 0; i < points.count; i++) {
        const float x = u + width * (float)(i % PLASTER_WIDTH), y = v + width * (float)(i / PLASTER_WIDTH);
        float *point = points.positions + 3 * i;
        for (int k = 0; k < 3; k++) point[k] = corner[k] + x * side[k] + y * other_side[k];
        const int32_t steps = height + (int32_t)draw_below(random, 2 * wobble + 1) - (int32_t)wobble;
        point[axis] = moved_by_floats(point[axis], rare && draw_below(random, 500) == 0 ? -steps : steps);
        if (skipping == 0) continue;
        points.skip[2 * i] = 0;
        points.skip[2 * i + 1] = skipping == 1   ? draw_below(random, 4)
                                 : skipping == 2 ? i / 7 % 2 * 2
                                 : skipping == 3 ? 1
                                                 : 4 * (draw_below(random, 200) == 0); /* what stands before the wall */
    }
    return points;
}

static void points_between_doubled_walls(void **state)
{
    (void)state;
    static const uint32_t mosts[] = {0, 1, 2, 3, 60, 1000};
    for (uint64_t seed = 1; seed <= scaled(28); seed++) {
        struct random random = {seed};
        struct soup soup = {0};
        float corner[3], side[3] = {0}, other_side[3] = {0}, chip[3][3], middle[3];
        const uint32_t axis = draw_below(&random, 3), is_tilted = draw_below(&random, 2);
        for (uint32_t k = 0; k < 3; k++) {
            corner[k] = draw_range(&random, 2, 12);
            if (is_tilted) side[k] = draw_range(&random, -1, 1), other_side[k] = draw_range(&random, -1, 1);
        }
        side[axis] += 6;
        other_side[(axis + 1) % 3] += 5;
        add_doubled_wall(&soup, &random, corner, side, other_side, mosts[draw_below(&random, 6)]);
        struct points points =
            points_of_plaster(&random, corner, side, other_side, draw_below(&random, 2) ? 0.0005f : 0.004f);
        for (int k = 0; k < 3; k++) middle[k] = points.positions[3 * (points.count / 2) + (size_t)k];
        const float far = draw_below(&random, 2) ? 3 : -3, chip_size = draw_below(&random, 2) ? 0.02f : 0.5f;
        mlrt_light lights[] = {light_at(middle[0], middle[1], middle[2]), light_from(0, 0, 0)};
        for (uint32_t k = 0; k < 3; k++) {
            lights[1].position[k] = (k == (axis + 2) % 3 ? far : 0) + draw_range(&random, -1, 1);
            lights[0].position[k] += lights[1].position[k];
            for (int i = 0; i < 3; i++) {
                const float across = chip_size * (float)(i - 1), along = chip_size * (i == 1 ? 1 : -1);
                chip[i][k] = middle[k] + 0.25f * lights[1].position[k] + across * side[k] + along * other_side[k];
            }
        }
        if (draw_below(&random, 2)) soup_add_triangle(&soup, chip[0], chip[1], chip[2]);
        struct fixture fixture = fixture_of_soup("plaster", seed, &soup);
        for (size_t l = 0; l < 2; l++) check(&fixture, &points, &lights[l]);
        free_points(&points);
        free_fixture(&fixture);
    }
}

enum { SCREEN_CELLS = 4, SCREEN_SIDE = 64, SCREEN_PITCH = 16 };

/*
 * A triangle of a screen. Few are as their neighbours expect: there twice, left out, or with one corner elsewhere: one
 * float, a few rays, or so far that the triangle is folded over one of its neighbours.
 */
static void add_part_of_screen(struct soup *soup, struct random *random, float (*corners)[3])
{
    const uint32_t flaw = draw_below(random, 24), corner = draw_below(random, 3), axis = draw_below(random, 3);
    const int turned = draw_below(random, 4) == 0;
    float *x = &corners[corner][axis];
    if (flaw == 0) *x = moved_by_floats(*x, draw_below(random, 2) ? 1 : -1);
    if (flaw == 1) *x += (float)draw_below(random, 5) - 2;
    if (flaw == 2) *x += 1.75f * SCREEN_PITCH * (draw_below(random, 2) ? 1 : -1);
    for (uint32_t i = 0; i < (flaw == 3 ? 0 : flaw == 4 ? 2u : 1u); i++)
        soup_add_triangle(soup, corners[turned], corners[!turned], corners[2]);
}

/* A screen of triangles with common edges before a wall, over two axes, at height 40 or so over the third. */
static void add_screen(struct soup *soup, struct random *random, const uint32_t axes[3])
{
    float grid[SCREEN_CELLS + 1][SCREEN_CELLS + 1][3];
    const float bent = draw_below(random, 2) ? 0 : draw_range(random, 0, 9), shifted = (float)draw_below(random, 9) - 4;
    for (int i = 0; i <= SCREEN_CELLS; i++) {
        for (int j = 0; j <= SCREEN_CELLS; j++) {
            grid[i][j][axes[0]] = (float)(i * SCREEN_PITCH + (int)draw_below(random, 9)) + shifted;
            grid[i][j][axes[1]] = (float)(j * SCREEN_PITCH + (int)draw_below(random, 9)) + shifted;
            grid[i][j][axes[2]] = 40 + bent * draw_range(random, -1, 1);
        }
    }
    for (int i = 0; i < SCREEN_CELLS; i++) {
        for (int j = 0; j < SCREEN_CELLS; j++) {
            const int is_other = (int)draw_below(random, 2);
            for (int half = 0; half < 2; half++) {
                float corners[3][3];
                if (!is_other) {
                    memcpy(corners[0], grid[i][j], 12);
                    memcpy(corners[1], grid[i + 1][j + half], 12);
                    memcpy(corners[2], grid[i + half][j + 1], 12);
                } else {
                    memcpy(corners[0], grid[i + 1][j], 12);
                    memcpy(corners[1], half ? grid[i + 1][j + 1] : grid[i][j + 1], 12);
                    memcpy(corners[2], half ? grid[i][j + 1] : grid[i][j], 12);
                }
                add_part_of_screen(soup, random, corners);
            }
        }
    }
}

/*
 * Points behind a screen, as a light sees them, many to a triangle: squares of them are hidden by several triangles
 * together, or nearly so. A sun along the axis shines exactly at vertices and along edges.
 */
static void points_behind_a_screen(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= scaled(14); seed++) {
        struct random random = {seed};
        struct soup soup = {0};
        const uint32_t first = draw_below(&random, 3), axes[3] = {first, (first + 1) % 3, (first + 2) % 3};
        const float side = draw_below(&random, 2) ? 1 : -1, far = draw_below(&random, 2) ? 1e3f : 90;
        const int is_slanted = (int)draw_below(&random, 2), skips = (int)draw_below(&random, 2);
        add_screen(&soup, &random, axes);
        struct points points = make_points((size_t)SCREEN_SIDE * SCREEN_SIDE);
        points.row_length = SCREEN_SIDE;
        for (size_t i = 0; i < points.count; i++) {
            float *point = points.positions + 3 * i;
            point[axes[0]] = (float)(i % SCREEN_SIDE);
            point[axes[1]] = (float)(i / SCREEN_SIDE);
            point[axes[2]] = 40 - 10 * side;
            if (draw_below(&random, 2000) == 0) point[axes[2]] = 40 + 20 * side;
            if (skips && draw_below(&random, 40) == 0) { /* of what hides the point, if that is a triangle's number */
                const size_t cell = SCREEN_CELLS * (i % SCREEN_SIDE / SCREEN_PITCH) + i / SCREEN_SIDE / SCREEN_PITCH;
                points.skip[2 * i] = 0;
                points.skip[2 * i + 1] = 2 * (uint32_t)cell + draw_below(&random, 2);
            }
        }
        mlrt_light lights[] = {light_at(0, 0, 0), light_from(0, 0, 0)};
        for (uint32_t k = 0; k < 3; k++) {
            lights[1].position[axes[k]] = k == 2 ? side : is_slanted ? draw_range(&random, -0.25f, 0.25f) : 0;
            lights[0].position[axes[k]] =
                (k == 2 ? 40 + far * side : 32) + (is_slanted ? draw_range(&random, -9, 9) : 0);
        }
        struct fixture fixture = fixture_of_soup("a screen", seed, &soup);
        for (size_t l = 0; l < 2; l++) {
            check(&fixture, &points, &lights[l]);
            check_shared_vector(&fixture, &points, lights[l].position, lights[l].kind == MLRT_LIGHT_POINT);
        }
        free_points(&points);
        free_fixture(&fixture);
    }
}

/*
 * Points behind triangles of a few corners, whose edges many share, in either order: in fans, folds and fins. The sun
 * and the light see corners exactly before some of the points.
 */
static void points_behind_triangles_of_few_corners(void **state)
{
    (void)state;
    enum { MOST_CORNERS = 9 };
    for (uint64_t seed = 1; seed <= scaled(14); seed++) {
        struct random random = {seed};
        struct soup soup = {0};
        float corners[MOST_CORNERS][3];
        const uint32_t first = draw_below(&random, 3), axes[3] = {first, (first + 1) % 3, (first + 2) % 3};
        const uint32_t corner_count = 4 + draw_below(&random, MOST_CORNERS - 3), is_flat = draw_below(&random, 3) == 0;
        const float side = draw_below(&random, 2) ? 1 : -1, tilt = draw_below(&random, 2) ? 0 : 0.25f;
        for (uint32_t i = 0; i < corner_count; i++) {
            corners[i][axes[0]] = (float)(24 * (int)draw_below(&random, 5) - 16);
            corners[i][axes[1]] = (float)(24 * (int)draw_below(&random, 5) - 16);
            corners[i][axes[2]] = 40 + (is_flat ? 0 : draw_range(&random, -4, 4));
        }
        for (uint32_t i = 6 + draw_below(&random, 40); i-- > 0;) {
            const uint32_t a = draw_below(&random, corner_count), b = draw_below(&random, corner_count);
            soup_add_triangle(&soup, corners[a], corners[b], corners[draw_below(&random, corner_count)]);
        }
        struct fixture fixture = fixture_of_soup("few corners", seed, &soup);
        for (uint32_t kind = 0; kind < 2; kind++) {
            struct points points = make_points((size_t)SCREEN_SIDE * SCREEN_SIDE);
            mlrt_light light = kind ? light_from(0, 0, 0) : light_at(0, 0, 0);
            const uint32_t stretch = 1u << draw_below(&random, 3); /* so many squares of 64 columns */
            points.row_length = SCREEN_SIDE * stretch;
            for (size_t i = 0; i < points.count; i++) {
                float *point = points.positions + 3 * i;
                const float x = (float)(i % points.row_length) / (float)stretch,
                            y = (float)(i / points.row_length * stretch);
                point[axes[0]] = kind ? x : 2 * x - 32;
                point[axes[1]] = kind ? y : 2 * y - 32;
                point[axes[2]] = 40 - 10 * side;
            }
            for (uint32_t k = 0; k < 3; k++) {
                const float aside = draw_range(&random, -tilt, tilt);
                light.position[axes[k]] = kind ? (k == 2 ? side : aside) : (k == 2 ? 40 + 10 * side : 32 + aside);
            }
            check(&fixture, &points, &light);
            check_shared_vector(&fixture, &points, light.position, !kind);
            free_points(&points);
        }
        free_fixture(&fixture);
    }
}

/*
 * Triangles that hide a square of points together leave no ray to be tested, however their corners are ordered, and
 * from whichever side they are seen; but if a ray skips one of them, they do.
 */
static void triangles_that_hide_a_square_together(void **state)
{
    (void)state;
    enum { PANES = 3, PANE_SIDE = 36 };
    for (uint32_t seed = 0; seed < 24; seed++) {
        struct random random = {seed};
        struct soup soup = {0};
        const uint32_t first = seed % 3, axes[3] = {first, (first + 1) % 3, (first + 2) % 3}, kind = seed / 3 % 2;
        const float side = seed / 6 % 2 ? 1 : -1;
        for (uint32_t i = 0; i < PANES * PANES; i++) {
            float corners[4][3];
            for (uint32_t j = 0; j < 4; j++) {
                corners[j][axes[0]] = (float)((i % PANES + j % 2) * PANE_SIDE) - 20;
                corners[j][axes[1]] = (float)((i / PANES + j / 2) * PANE_SIDE) - 20;
                corners[j][axes[2]] = 40;
            }
            for (uint32_t j = 0; j < 2; j++) {
                const uint32_t turned = draw_below(&random, 2);
                soup_add_triangle(&soup, corners[3 * j], corners[1 + turned], corners[2 - turned]);
            }
        }
        struct fixture fixture = fixture_of_soup("panes", seed, &soup);
        struct points points = make_points((size_t)SCREEN_SIDE * SCREEN_SIDE);
        mlrt_light light = kind ? light_from(0, 0, 0) : light_at(0, 0, 0);
        for (uint32_t k = 0; k < 3; k++) {
            light.position[axes[k]] = kind ? (k == 2 ? side : 0.02f) : (k == 2 ? 40 + 1000 * side : 31);
        }
        for (size_t i = 0; i < points.count; i++) {
            points.positions[3 * i + axes[0]] = (float)(i % SCREEN_SIDE);
            points.positions[3 * i + axes[1]] = (float)(i / SCREEN_SIDE);
            points.positions[3 * i + axes[2]] = 40 - 10 * side;
        }
        mlrt_counters counters = {.struct_size = sizeof counters};
        const mlrt_trace_options options = {
            .struct_size = sizeof options, .method = MLRT_METHOD_TILE, .counters = &counters};
        const mlrt_points all = {.struct_size = sizeof all,
                                 .count = points.count,
                                 .row_length = SCREEN_SIDE,
                                 .positions = {points.positions, 0},
                                 .skip = {points.skip, 0}};
        uint8_t *got = allocate_or_fail(points.count, 1);
        const mlrt_array occluded = {got, 0, 0};
        assert_int_equal(mlrt_occluded_points(fixture.tree, &all, &light, &options, &occluded), MLRT_OK);
        assert_int_equal(counters.lane_test_count, 0);
        for (size_t i = 0; i < points.count; i++) assert_int_equal(got[i], 1);
        points.skip[0] = 0;
        points.skip[1] = 1; /* the one that alone hides the first point */
        assert_int_equal(mlrt_occluded_points(fixture.tree, &all, &light, &options, &occluded), MLRT_OK);
        assert_true(counters.lane_test_count > 0);
        for (size_t i = 0; i < points.count; i++) assert_int_equal(got[i], i > 0);
        free(got);
        free_points(&points);
        free_fixture(&fixture);
    }
}

/* Points behind two triangles as large as floats allow, with a gap between them: leaves do not have their corners. */
static void points_behind_a_gap_between_large_triangles(void **state)
{
    (void)state;
    enum { SIDE = 32 };
    for (int turned = 0; turned < 4; turned++) {
        const float far = 0x1p70f, from[3] = {-9, -9, -90}, to[3] = {9, 9, -80};
        const float left[3][3] = {{0, -far, 40}, {0, far, 40}, {-far, 0, 40}};
        const float right[3][3] = {{0.5f, far, 40}, {0.5f, -far, 40}, {far, 0, 40}};
        struct soup soup = {0};
        soup_add_box(&soup, from, to);
        soup_add_triangle(&soup, left[turned & 1], left[!(turned & 1)], left[2]);
        soup_add_triangle(&soup, right[turned >> 1], right[!(turned >> 1)], right[2]);
        struct fixture fixture = fixture_of_soup("a gap", (uint64_t)turned, &soup);
        struct points points = make_square(SIDE, 0.25f);
        for (size_t i = 0; i < points.count; i++) points.positions[3 * i] -= 3;
        const mlrt_light lights[] = {light_from(0.001f, 0.01f, 1), light_at(0.5f, 4, 90)};
        for (size_t l = 0; l < 2; l++) check(&fixture, &points, &lights[l]);
        free_points(&points);
        free_fixture(&fixture);
    }
}

/*
 * Parallel rays that begin in all corners of a scene as large as floats allow, but one. In that corner a triangle lies
 * so far behind all of them that the distance is no float; another triangle lies before some.
 */
static void points_farther_apart_than_a_float(void **state)
{
    (void)state;
    enum { WIDTH = 16 };
    const float end = 0x1.fp127f;
    for (int form = 0; form < 16; form++) {
        const float size = form & 1 ? -end : end;
        const float begins[3][3] = {{-size, 0.9f * size, 0.9f * size}, /* of rays along the first axis */
                                    {size, -0.9f * size, 0.9f * size},
                                    {size, 0.9f * size, -0.9f * size}};
        const float behind[3][3] = {
            {-size, -size, -0.5f * size}, {-size, -0.5f * size, -size}, {-0.5f * size, -size, -size}};
        const float before[3][3] = {{-0.5f * size, 0.5f * size, 0.5f * size},
                                    {-0.5f * size, 0.99f * size, 0.9f * size},
                                    {-0.5f * size, 0.9f * size, 0.99f * size}};
        const float beside[3][3] = {{size, size, size}, {size, 0.97f * size, size}, {size, size, 0.97f * size}};
        struct soup soup = {0};
        for (int i = 0; i < 2; i++) {
            const float(*corners)[3] = (form >> 1 & 1) == i ? behind : before;
            const int turned = form >> (2 + i) & 1;
            soup_add_triangle(&soup, corners[turned], corners[!turned], corners[2]);
        }
        soup_add_triangle(&soup, beside[0], beside[1], beside[2]);
        struct fixture fixture = fixture_of_soup("as large as floats allow", (uint64_t)form, &soup);
        struct points points = make_points((size_t)WIDTH * WIDTH);
        points.row_length = WIDTH;
        for (size_t i = 0; i < points.count; i++) memcpy(points.positions + 3 * i, begins[i % 3], sizeof begins[0]);
        const mlrt_light light = light_from(form & 1 ? -1 : 1, 0, 0);
        check(&fixture, &points, &light);
        free_points(&points);
        free_fixture(&fixture);
    }
}

/* Squares that begin behind the end of the last row, which is short. Nothing is read there. */
static void points_in_a_short_last_row(void **state)
{
    (void)state;
    enum { WIDTH = 640, LAST = 16 };
    struct fixture fixture = boxes();
    for (size_t rows = 1; rows <= 65; rows += 32) {
        const size_t count = (rows - 1) * WIDTH + LAST;
        struct random random = {rows};
        struct points points = {allocate_guarded(12 * count), allocate_guarded(8 * count), count, WIDTH};
        for (size_t i = 0; i < count; i++) {
            draw_point(&random, -4, 4, points.positions + 3 * i);
            points.skip[2 * i] = points.skip[2 * i + 1] = MLRT_NONE;
        }
        const mlrt_light light = light_at(0, 0, 3.5f);
        check(&fixture, &points, &light);
        free_guarded(points.positions, 12 * count);
        free_guarded(points.skip, 8 * count);
    }
    free_fixture(&fixture);
}

/*
 * Before each square of 16x16 points, a chip far smaller than the gaps between points shades one of those at its edge.
 * The hull of the square must have that ray, too.
 */
static void a_chip_before_the_edge_of_each_square(void **state)
{
    (void)state;
    const mlrt_light lights[] = {light_at(-1, -2, 3), light_at(0.5f, 0.25f, -4), light_at(40, 1, 0.5f),
                                 light_from(0.25f, 0.5f, 1), light_from(2, -1, -3)};
    for (size_t e = 0; e < sizeof lights / sizeof lights[0]; e++) {
        const int is_point = lights[e].kind == MLRT_LIGHT_POINT;
        struct points points = points_of_wall(0);
        struct soup soup = {0};
        size_t square = e;
        for (size_t y = 0; y + 16 <= 96; y += 16) {
            for (size_t x = 0; x + 16 <= WALL_WIDTH; x += 16, square++) {
                static const size_t edge[8][2] = {{0, 0}, {15, 15}, {15, 0}, {0, 15}, {0, 7}, {15, 8}, {7, 0}, {8, 15}};
                const size_t i = (y + edge[square % 8][1]) * WALL_WIDTH + x + edge[square % 8][0];
                float corners[3][3];
                for (int c = 0; c < 3; c++) {
                    for (int k = 0; k < 3; k++) {
                        const float point = points.positions[3 * i + (size_t)k], at = lights[e].position[k];
                        const float middle = is_point ? 0.5f * (point + at) : point + at;
                        corners[c][k] = middle + (c == k ? 0.0005f : -0.0005f);
                    }
                }
                soup_add_triangle(&soup, corners[0], corners[1], corners[2]);
            }
        }
        struct fixture fixture = fixture_of_soup("chips", 9, &soup);
        check_points(&fixture, points.positions, NULL, points.count, points.row_length, &lights[e]);
        free_points(&points);
        free_fixture(&fixture);
    }
}

static void the_query_option_is_ignored(void **state)
{
    (void)state;
    struct fixture fixture = boxes();
    struct points points = points_of_boxes(&fixture, 10, 10);
    mlrt_light light = light_at(0.5f, 0.25f, 3.5f);
    uint8_t results[2][100];
    mlrt_points in = {.struct_size = sizeof in, .count = 100, .positions = {points.positions, 0}};
    for (int32_t query = 0; query < 2; query++) {
        mlrt_trace_options options = {.struct_size = sizeof options, .query = query};
        mlrt_array out = {results[query], 0, 0};
        assert_int_equal(mlrt_occluded_points(fixture.tree, &in, &light, &options, &out), MLRT_OK);
    }
    assert_memory_equal(results[0], results[1], 100);
    free_points(&points);
    free_fixture(&fixture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(point_lights_inside_the_scene),
        cmocka_unit_test(point_lights_outside_the_scene),
        cmocka_unit_test(lights_on_planes_edges_and_vertices),
        cmocka_unit_test(directional_lights),
        cmocka_unit_test(directional_lights_along_axes),
        cmocka_unit_test(the_length_of_a_light_direction_does_not_matter),
        cmocka_unit_test(points_on_surfaces),
        cmocka_unit_test(a_point_at_the_light_is_lit),
        cmocka_unit_test(points_that_are_not_finite_are_lit),
        cmocka_unit_test(directions_that_overflow_are_lit),
        cmocka_unit_test(points_far_beyond_a_distant_scene),
        cmocka_unit_test(a_surface_at_the_point_shades_it_unless_skipped),
        cmocka_unit_test(a_surface_at_the_light_does_not_shade),
        cmocka_unit_test(points_behind_and_before_a_depth_step),
        cmocka_unit_test(points_on_both_sides_of_one_triangle),
        cmocka_unit_test(scenes_of_every_scale),
        cmocka_unit_test(every_count_up_to_40),
        cmocka_unit_test(the_room_with_its_light),
        cmocka_unit_test(an_empty_tree_shades_nothing),
        cmocka_unit_test(strides_of_points_and_results),
        cmocka_unit_test(squares_of_points),
        cmocka_unit_test(squares_that_skip_two_triangles),
        cmocka_unit_test(squares_of_which_whole_blocks_are_not_finite),
        cmocka_unit_test(points_between_doubled_walls),
        cmocka_unit_test(points_behind_a_screen),
        cmocka_unit_test(points_behind_triangles_of_few_corners),
        cmocka_unit_test(triangles_that_hide_a_square_together),
        cmocka_unit_test(points_behind_a_gap_between_large_triangles),
        cmocka_unit_test(points_farther_apart_than_a_float),
        cmocka_unit_test(points_in_a_short_last_row),
        cmocka_unit_test(a_chip_before_the_edge_of_each_square),
        cmocka_unit_test(the_query_option_is_ignored),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
