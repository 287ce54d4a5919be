/* SPDX-License-Identifier: MIT */
/*
 * mlrt_offset_point: strictly on its side, close by, and no ray to the same side, or along the plane, hits the
 * triangle.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

/* All promises for one point: the side exactly, and rays against the reference. */
static void check_offset(const struct fixture *fixture, size_t position, float u, float v, int side,
                         struct random *random)
{
    const struct reference_triangle *triangle = reference_triangle_at(fixture->reference, position);
    float point[3];
    int32_t status = mlrt_offset_point(fixture->tree, triangle->mesh, triangle->triangle, u, v, side, point);
    assert_int_equal(status, MLRT_OK);
    if (reference_side(triangle, point) != side) {
        print_error("%s: triangle (%a, %a, %a) (%a, %a, %a) (%a, %a, %a), u = %a, v = %a, side %d: (%a, %a, %a)\n",
                    fixture->name, (double)triangle->corner[0][0], (double)triangle->corner[0][1],
                    (double)triangle->corner[0][2], (double)triangle->corner[1][0], (double)triangle->corner[1][1],
                    (double)triangle->corner[1][2], (double)triangle->corner[2][0], (double)triangle->corner[2][1],
                    (double)triangle->corner[2][2], (double)u, (double)v, side, (double)point[0], (double)point[1],
                    (double)point[2]);
        fail();
    }
    for (int i = 0; i < 8; i++) {
        float direction[3];
        draw_point(random, -1, 1, direction);
        if (reference_facing(triangle, direction) == -side) {
            for (int k = 0; k < 3; k++) direction[k] = -direction[k];
        }
        mlrt_ray ray = {.struct_size = sizeof ray};
        memcpy(ray.origin, point, sizeof ray.origin);
        memcpy(ray.direction, direction, sizeof ray.direction);
        mlrt_hit hit = {.struct_size = sizeof hit};
        assert_int_equal(mlrt_trace_ray(fixture->tree, &ray, NULL, &hit), MLRT_OK);
        assert_false(hit.mesh == triangle->mesh && hit.triangle == triangle->triangle);
    }
}

static void check_all(struct soup *soup, const char *name, uint64_t seed)
{
    struct random random = {seed};
    struct fixture fixture = fixture_of_soup(name, seed, soup);
    size_t count = reference_triangle_count(fixture.reference);
    for (size_t i = 0; i < scaled(300); i++) {
        float u = draw_range(&random, 0, 1), v = draw_range(&random, 0, 1 - u);
        if (i % 5 == 0) u = v = 0;
        if (i % 5 == 1) u = 1 - v;
        size_t position = draw_below(&random, (uint32_t)count);
        check_offset(&fixture, position, u, v, 1, &random);
        check_offset(&fixture, position, u, v, -1, &random);
    }
    free_fixture(&fixture);
}

static void random_triangles(void **state)
{
    (void)state;
    struct random random = {1};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 100, 1, 0.5f);
    check_all(&soup, "random", 1);
}

static void needles(void **state)
{
    (void)state;
    struct random random = {2};
    struct soup soup = {0};
    soup_add_needles(&soup, &random, 100, 1e6f);
    check_all(&soup, "needles", 2);
}

static void axis_parallel_triangles(void **state)
{
    (void)state;
    struct soup soup = {0};
    for (int axis = 0; axis < 3; axis++) {
        soup_add_grid(&soup, axis, 0, 3);
        soup_add_grid(&soup, axis, 5, 3);
    }
    check_all(&soup, "grids", 3);
}

static void triangles_far_from_the_origin(void **state)
{
    (void)state;
    const float offset[3] = {1e7f, -1e7f, 1e7f};
    struct soup soup = {0};
    soup_add_icosphere(&soup, 1, 50);
    move_soup(&soup, 1, offset);
    check_all(&soup, "far away", 4);
}

static void triangles_of_every_scale(void **state)
{
    (void)state;
    static const float scales[] = {1e-44f, 1e-38f, 1e-30f, 1e-10f, 1e10f, 1e30f, 1e37f};
    for (uint64_t i = 0; i < sizeof scales / sizeof scales[0]; i++) {
        const float zero[3] = {0, 0, 0};
        struct random random = {10 + i};
        struct soup soup = {0}, usable = {0};
        soup_add_random(&soup, &random, 60, 20, 10);
        move_soup(&soup, scales[i], zero);
        for (size_t t = 0; t < soup.count; t++) {
            const float *c = soup.corners + 9 * t;
            struct reference_triangle triangle;
            memcpy(triangle.corner, c, sizeof triangle.corner);
            struct reference_scene *scene = reference_create(&triangle, 1);
            if (reference_zero_area_count(scene) == 0) soup_add_triangle(&usable, c, c + 3, c + 6);
            reference_destroy(scene);
        }
        free_soup(&soup);
        check_all(&usable, "scaled", 10 + i);
    }
}

static void the_point_is_next_to_the_surface(void **state)
{
    (void)state;
    const float a[3] = {3, 1, 2}, b[3] = {4, 1.5f, 2}, c[3] = {3.25f, 2, 2.5f};
    struct soup soup = {0};
    struct random random = {5};
    soup_add_triangle(&soup, a, b, c);
    struct fixture fixture = fixture_of_soup("one triangle", 5, &soup);
    for (int i = 0; i < 200; i++) {
        float u = draw_range(&random, 0, 1), v = draw_range(&random, 0, 1 - u), point[3];
        assert_int_equal(mlrt_offset_point(fixture.tree, 0, 0, u, v, i % 2 ? 1 : -1, point), MLRT_OK);
        for (int k = 0; k < 3; k++) {
            double on =
                (1.0 - (double)u - (double)v) * (double)a[k] + (double)u * (double)b[k] + (double)v * (double)c[k];
            assert_true(fabs((double)point[k] - on) < 1e-5);
        }
    }
    free_fixture(&fixture);
}

static void rays_in_the_plane_do_not_hit(void **state)
{
    (void)state;
    struct soup soup = {0};
    struct random random = {6};
    soup_add_random(&soup, &random, 50, 1, 0.5f);
    struct fixture fixture = fixture_of_soup("along the plane", 6, &soup);
    for (size_t i = 0; i < 50; i++) {
        const struct reference_triangle *triangle = reference_triangle_at(fixture.reference, i);
        float point[3], target[3];
        assert_int_equal(mlrt_offset_point(fixture.tree, 0, (uint32_t)i, 0.25f, 0.5f, 1, point), MLRT_OK);
        for (int corner = 0; corner < 3; corner++) {
            reference_difference(triangle->corner[(corner + 1) % 3], triangle->corner[corner], target);
            struct reference_ray ray = {
                {point[0], point[1], point[2]}, {target[0], target[1], target[2]}, 0, INFINITY, {MLRT_NONE, MLRT_NONE}};
            if (reference_facing(triangle, ray.direction) < 0) continue;
            struct reference_hit hit = trace_one(fixture.tree, &ray, NULL);
            assert_int_not_equal(hit.triangle, i);
        }
    }
    free_fixture(&fixture);
}

/* u and v of real hits are as the library rounds them; the side is the one that the ray came from. */
static void offsets_of_hits_do_not_shade_themselves(void **state)
{
    (void)state;
    struct random random = {7};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_icosphere(&soup, 2, 1);
    struct fixture fixture = fixture_of_soup("convex", 7, &soup);
    add_aimed_rays(&list, &random, &fixture, scaled(500), -3, 3);
    for (size_t i = 0; i < list.count; i++) {
        struct reference_hit hit = trace_one(fixture.tree, &list.rays[i], NULL);
        if (hit.mesh == MLRT_NONE) continue;
        float point[3];
        int32_t status = mlrt_offset_point(fixture.tree, hit.mesh, hit.triangle, hit.u, hit.v, -hit.facing, point);
        assert_int_equal(status, MLRT_OK);
        struct reference_ray back = {{point[0], point[1], point[2]}, {0}, 0, INFINITY, {MLRT_NONE, MLRT_NONE}};
        for (int k = 0; k < 3; k++) back.direction[k] = -list.rays[i].direction[k];
        struct reference_hit again = trace_one(fixture.tree, &back, NULL);
        assert_int_not_equal(again.triangle, hit.triangle);
    }
    free_rays(&list);
    free_fixture(&fixture);
}

static void the_unit_triangle(mlrt_tree **tree)
{
    const float corners[18] = {0, 0, 5, 1, 0, 5, 0, 1, 5, 0, 0, 0, 1, 1, 1, 2, 2, 2};
    mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = corners, .vertex_count = 6, .triangle_count = 2};
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, tree), MLRT_OK);
}

static void triangles_that_do_not_exist_are_errors(void **state)
{
    (void)state;
    mlrt_tree *tree;
    float p[3];
    the_unit_triangle(&tree);
    assert_int_equal(mlrt_offset_point(tree, 1, 0, 0.25f, 0.25f, 1, p), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_offset_point(tree, 0, 2, 0.25f, 0.25f, 1, p), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_offset_point(tree, MLRT_NONE, MLRT_NONE, 0.25f, 0.25f, 1, p), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_offset_point(tree, 0, MLRT_NONE, 0.25f, 0.25f, 1, p), MLRT_ERROR_ARGUMENT);
    mlrt_destroy_tree(tree);
}

static void left_out_triangles_are_errors(void **state)
{
    (void)state;
    mlrt_tree *tree;
    float p[3];
    the_unit_triangle(&tree);
    assert_int_equal(mlrt_offset_point(tree, 0, 1, 0.25f, 0.25f, 1, p), MLRT_ERROR_ARGUMENT);
    mlrt_destroy_tree(tree);
}

static void weights_that_are_not_finite_are_errors(void **state)
{
    (void)state;
    mlrt_tree *tree;
    float p[3];
    the_unit_triangle(&tree);
    assert_int_equal(mlrt_offset_point(tree, 0, 0, NAN, 0.25f, 1, p), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_offset_point(tree, 0, 0, 0.25f, INFINITY, 1, p), MLRT_ERROR_ARGUMENT);
    mlrt_destroy_tree(tree);
}

static void points_beyond_the_range_of_float_are_errors(void **state)
{
    (void)state;
    const float m = float_of_bits(0x7F7FFFFF);
    const float corners[9] = {m, m, m, m, -m, m, m, m, -m};
    mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = corners, .vertex_count = 3, .triangle_count = 1};
    mlrt_tree *tree;
    float p[3];
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_OK);
    // One side has no room, the other does.
    int32_t first = mlrt_offset_point(tree, 0, 0, 0.25f, 0.25f, 1, p);
    int32_t second = mlrt_offset_point(tree, 0, 0, 0.25f, 0.25f, -1, p);
    assert_int_equal(first == MLRT_OK ? second : first, MLRT_ERROR_ARGUMENT);
    assert_true(first == MLRT_OK || second == MLRT_OK);
    mlrt_destroy_tree(tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_triangles),
        cmocka_unit_test(needles),
        cmocka_unit_test(axis_parallel_triangles),
        cmocka_unit_test(triangles_far_from_the_origin),
        cmocka_unit_test(triangles_of_every_scale),
        cmocka_unit_test(the_point_is_next_to_the_surface),
        cmocka_unit_test(rays_in_the_plane_do_not_hit),
        cmocka_unit_test(offsets_of_hits_do_not_shade_themselves),
        cmocka_unit_test(triangles_that_do_not_exist_are_errors),
        cmocka_unit_test(left_out_triangles_are_errors),
        cmocka_unit_test(weights_that_are_not_finite_are_errors),
        cmocka_unit_test(points_beyond_the_range_of_float_are_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
