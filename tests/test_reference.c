/* SPDX-License-Identifier: MIT */
/*
 * The oracle itself: answers worked out by hand, rounding against the machine's own, and its three ways against each
 * other on the inputs that the other tests use. Nothing of the library is called here but its tree, which the fixtures
 * build along.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

static const float corner_a[3] = {0, 0, 5}, corner_b[3] = {1, 0, 5}, corner_c[3] = {0, 1, 5};

static struct reference_scene *one_triangle(void)
{
    struct reference_triangle triangle = {.mesh = 7, .triangle = 3};
    memcpy(triangle.corner[0], corner_a, 12);
    memcpy(triangle.corner[1], corner_b, 12);
    memcpy(triangle.corner[2], corner_c, 12);
    return reference_create(&triangle, 1);
}

/* Traces o + t d by all three ways, which must agree. */
static struct reference_hit trace(struct reference_scene *scene, float ox, float oy, float oz, float dx, float dy,
                                  float dz, float t_min, float t_max)
{
    struct reference_ray ray = {{ox, oy, oz}, {dx, dy, dz}, t_min, t_max, {REFERENCE_NONE, REFERENCE_NONE}};
    struct reference_hit plain, filtered, searched;
    reference_trace_plain(scene, &ray, &plain);
    reference_trace_filtered(scene, &ray, &filtered);
    reference_trace(scene, &ray, &searched);
    assert_memory_equal(&plain, &filtered, sizeof plain);
    assert_memory_equal(&plain, &searched, sizeof plain);
    return plain;
}

static struct reference_hit trace_down(float x, float y)
{
    struct reference_scene *scene = one_triangle();
    struct reference_hit hit = trace(scene, x, y, 0, 0, 0, 1, 0, INFINITY);
    reference_destroy(scene);
    return hit;
}

static void assert_miss(struct reference_hit hit)
{
    assert_true(isinf(hit.t) && hit.t > 0);
    assert_int_equal(hit.mesh, REFERENCE_NONE);
    assert_int_equal(hit.triangle, REFERENCE_NONE);
    assert_int_equal(hit.facing, 0);
    assert_true(hit.u == 0 && hit.v == 0);
}

static void reports_t_u_v_ids_and_facing(void **state)
{
    (void)state;
    struct reference_hit hit = trace_down(0.25f, 0.5f);
    assert_true(hit.t == 5 && hit.u == 0.25f && hit.v == 0.5f);
    assert_int_equal(hit.mesh, 7);
    assert_int_equal(hit.triangle, 3);
    assert_int_equal(hit.facing, 1);
}

static void facing_is_negative_against_the_normal(void **state)
{
    (void)state;
    struct reference_scene *scene = one_triangle();
    struct reference_hit hit = trace(scene, 0.25f, 0.25f, 9, 0, 0, -2, 0, INFINITY);
    assert_int_equal(hit.facing, -1);
    assert_true(hit.t == 2);
    reference_destroy(scene);
}

static void edges_and_vertices_belong_to_the_triangle(void **state)
{
    (void)state;
    assert_true(trace_down(0.5f, 0).t == 5);
    assert_true(trace_down(0, 0.5f).t == 5);
    assert_true(trace_down(0.5f, 0.5f).t == 5);
    assert_true(trace_down(0, 0).t == 5);
    assert_true(trace_down(1, 0).u == 1);
    assert_true(trace_down(0, 1).v == 1);
}

static void one_float_outside_is_outside(void **state)
{
    (void)state;
    assert_miss(trace_down(0.5f, next_float(0.0f, -1)));
    assert_miss(trace_down(next_float(0.5f, 1), 0.5f));
    assert_miss(trace_down(next_float(1.0f, 1), 0));
}

static void the_interval_is_half_open(void **state)
{
    (void)state;
    struct reference_scene *scene = one_triangle();
    assert_miss(trace(scene, 0.25f, 0.25f, 0, 0, 0, 1, 5, INFINITY));
    assert_true(trace(scene, 0.25f, 0.25f, 0, 0, 0, 1, next_float(5, -1), 5).t == 5);
    assert_miss(trace(scene, 0.25f, 0.25f, 0, 0, 0, 1, 0, next_float(5, -1)));
    assert_miss(trace(scene, 0.25f, 0.25f, 5, 0, 0, 1, 0, INFINITY));
    assert_miss(trace(scene, 0.25f, 0.25f, 5, 0, 0, 1, -1, INFINITY));
    reference_destroy(scene);
}

static void a_ray_in_the_plane_misses(void **state)
{
    (void)state;
    struct reference_scene *scene = one_triangle();
    assert_miss(trace(scene, -1, 0.25f, 5, 1, 0, 0, 0, INFINITY));
    assert_miss(trace(scene, 0.25f, 0.25f, 5, 1, 1, 0, 0, INFINITY));
    reference_destroy(scene);
}

static void invalid_rays_miss(void **state)
{
    (void)state;
    struct reference_scene *scene = one_triangle();
    assert_miss(trace(scene, 0.25f, 0.25f, 0, 0, 0, 0, 0, INFINITY));
    assert_miss(trace(scene, 0.25f, 0.25f, 0, 0, NAN, 1, 0, INFINITY));
    assert_miss(trace(scene, 0.25f, 0.25f, 0, 0, 0, INFINITY, 0, INFINITY));
    assert_miss(trace(scene, 0.25f, -INFINITY, 0, 0, 0, 1, 0, INFINITY));
    assert_miss(trace(scene, 0.25f, 0.25f, 0, 0, 0, 1, NAN, INFINITY));
    assert_miss(trace(scene, 0.25f, 0.25f, 0, 0, 0, 1, 0, NAN));
    assert_miss(trace(scene, 0.25f, 0.25f, 0, 0, 0, 1, INFINITY, INFINITY));
    assert_miss(trace(scene, 0.25f, 0.25f, 0, 0, 0, 1, 0, 0));
    assert_true(trace(scene, 0.25f, 0.25f, 0, 0, 0, 1, -INFINITY, INFINITY).t == 5);
    reference_destroy(scene);
}

static void of_equal_distances_the_first_wins(void **state)
{
    (void)state;
    struct soup soup = {0};
    soup_add_triangle(&soup, corner_b, corner_c, corner_a);
    soup_add_triangle(&soup, corner_a, corner_c, corner_b);
    soup_add_triangle(&soup, corner_a, corner_b, corner_c);
    struct fixture fixture = fixture_of_soup("three equal triangles", 0, &soup);
    struct reference_hit hit = trace(fixture.reference, 0.25f, 0.25f, 0, 0, 0, 1, 0, INFINITY);
    assert_int_equal(hit.triangle, 0);
    free_fixture(&fixture);
}

static void skip_passes_one_triangle(void **state)
{
    (void)state;
    struct reference_scene *scene = one_triangle();
    struct reference_ray ray = {{0.25f, 0.25f, 0}, {0, 0, 1}, 0, INFINITY, {7, 3}};
    struct reference_hit hit;
    reference_trace(scene, &ray, &hit);
    assert_miss(hit);
    ray.skip[1] = 2;
    reference_trace(scene, &ray, &hit);
    assert_true(hit.t == 5);
    reference_destroy(scene);
}

static void unusable_triangles_are_counted_and_never_hit(void **state)
{
    (void)state;
    const float middle[3] = {0.5f, 0, 5}, bad[3] = {0, NAN, 5}, far[3] = {0, INFINITY, 5};
    struct soup soup = {0};
    soup_add_triangle(&soup, corner_a, middle, corner_b);
    soup_add_triangle(&soup, corner_a, corner_a, corner_b);
    soup_add_triangle(&soup, corner_a, corner_b, bad);
    soup_add_triangle(&soup, corner_a, corner_b, far);
    struct fixture fixture = fixture_of_soup("unusable triangles", 0, &soup);
    assert_int_equal(reference_zero_area_count(fixture.reference), 2);
    assert_int_equal(reference_non_finite_count(fixture.reference), 2);
    assert_miss(trace(fixture.reference, 0.25f, 0, 0, 0, 0, 1, 0, INFINITY));
    free_fixture(&fixture);
}

/* ---- rounding ---------------------------------------------------------------------------------------------------- */

static float quotient_of(double numerator, double denominator, int shift)
{
    mpz_t a, b;
    mpz_init_set_d(a, numerator);
    mpz_init_set_d(b, denominator);
    if (shift >= 0)
        mpz_mul_2exp(a, a, (mp_bitcnt_t)shift);
    else
        mpz_mul_2exp(b, b, (mp_bitcnt_t)-shift);
    float quotient = reference_quotient(a, b);
    mpz_clear(a);
    mpz_clear(b);
    return quotient;
}

static void quotients_round_as_the_machine_divides(void **state)
{
    (void)state;
    struct random random = {11};
    for (int i = 0; i < 20000; i++) {
        // Integers of 24 bits: the machine's float quotient is correctly rounded.
        float a = (float)((int)draw_below(&random, 1u << 24) - (1 << 23)),
              b = (float)(1 + draw_below(&random, 1u << 24));
        assert_int_equal(bits_of_float(quotient_of((double)a, (double)b, 0)), bits_of_float(a == 0 ? 0.0f : a / b));
    }
}

static void quotients_halfway_go_to_even(void **state)
{
    (void)state;
    assert_true(quotient_of(33554433, 2, 0) == 16777216);     // 2^24 + 1/2
    assert_true(quotient_of(33554435, 2, 0) == 16777218);     // 2^24 + 3/2
    assert_true(quotient_of(67108867, 4, 0) == 16777216 + 0); // 2^24 + 3/4 lies below the middle of 0 and 2
    assert_true(quotient_of(-33554435, 2, 0) == -16777218);
}

static void quotients_reach_denormals_and_zero(void **state)
{
    (void)state;
    assert_int_equal(bits_of_float(quotient_of(1, 1, -149)), 1);
    assert_int_equal(bits_of_float(quotient_of(1, 1, -150)), 0);
    assert_int_equal(bits_of_float(quotient_of(3, 2, -150)), 1);
    assert_int_equal(bits_of_float(quotient_of(3, 1, -150)), 2);
    assert_int_equal(bits_of_float(quotient_of(16777215, 1, -150)), 0x00800000);
}

static void quotients_overflow_to_infinity(void **state)
{
    (void)state;
    assert_true(isinf(quotient_of(1, 1, 128)));
    assert_true(isinf(quotient_of(33554431, 1, 103)));
    assert_true(quotient_of(33554430, 1, 103) == float_of_bits(0x7F7FFFFF));
    assert_true(isinf(quotient_of(-1, 1, 500)) && quotient_of(-1, 1, 500) < 0);
}

/* ---- all hits ---------------------------------------------------------------------------------------------------- */

static struct reference_totals count_all(const struct fixture *fixture, float ox, float oy, float oz, float dx,
                                         float dy, float dz)
{
    struct reference_ray ray = {{ox, oy, oz}, {dx, dy, dz}, 0, INFINITY, {REFERENCE_NONE, REFERENCE_NONE}};
    struct reference_totals plain = reference_trace_all_plain(fixture->reference, &ray, NULL, 0);
    struct reference_totals searched = reference_trace_all(fixture->reference, &ray, NULL, 0);
    assert_int_equal(plain.hit_count, searched.hit_count);
    assert_int_equal(plain.crossing_count, searched.crossing_count);
    return plain;
}

/* A cube, through the inside of faces, an edge, a diagonal of a face, a corner: what belongs to several is crossed
 * once. */
static void crossings_of_a_cube(void **state)
{
    (void)state;
    const float lo[3] = {0, 0, 0}, hi[3] = {4, 4, 4};
    struct soup soup = {0};
    soup_add_box(&soup, lo, hi);
    struct fixture fixture = fixture_of_soup("cube", 0, &soup);
    struct reference_totals face = count_all(&fixture, 1, 2, 2, 1, 0.25f, 0.125f);
    assert_int_equal(face.hit_count, 1);
    assert_int_equal(face.crossing_count, 1);
    struct reference_totals diagonal = count_all(&fixture, 2, 2, 2, 1, 0, 0);
    assert_int_equal(diagonal.hit_count, 2);
    assert_int_equal(diagonal.crossing_count, 1);
    struct reference_totals edge = count_all(&fixture, 2, 2, 1, 1, 1, 0);
    assert_int_equal(edge.crossing_count, 1);
    assert_true(edge.hit_count >= 2);
    struct reference_totals corner = count_all(&fixture, 2, 2, 2, -1, 1, 1);
    assert_int_equal(corner.crossing_count, 1);
    assert_true(corner.hit_count >= 3);
    assert_int_equal(count_all(&fixture, -1, 2, 2, 1, 0, 0).crossing_count, 2);
    assert_int_equal(count_all(&fixture, -1, -1, -1, 1, 1, 1).crossing_count, 2);
    // It touches an edge from outside.
    assert_int_equal(count_all(&fixture, -2, 2, 1, 1, 1, 0).crossing_count % 2, 0);
    assert_true(count_all(&fixture, -2, 2, 1, 1, 1, 0).hit_count > 0);
    // In the plane of a face, and along an edge.
    assert_int_equal(count_all(&fixture, -1, 2, 4, 1, 0, 0).crossing_count % 2, 0);
    assert_int_equal(count_all(&fixture, -1, 0, 0, 1, 0, 0).crossing_count % 2, 0);
    free_fixture(&fixture);
}

static void all_hits_are_in_order(void **state)
{
    (void)state;
    struct soup soup = {0};
    struct reference_list_hit hits[8];
    for (int i = 0; i < 4; i++) soup_add_grid(&soup, 2, (float)(i < 2 ? 3 - i : 2), 1); // at 3, 2, 2, 2
    struct fixture fixture = fixture_of_soup("levels", 0, &soup);
    struct reference_ray ray = {{0.75f, 0.5f, 0}, {0, 0, 1}, 0, 2.5f, {REFERENCE_NONE, REFERENCE_NONE}};
    assert_int_equal(reference_trace_all(fixture.reference, &ray, hits, 8).hit_count, 3);
    for (int i = 0; i < 3; i++) assert_int_equal(hits[i].hit.triangle, 2 + 2 * i);
    ray.t_max = INFINITY;
    assert_int_equal(reference_trace_all(fixture.reference, &ray, hits, 2).hit_count, 4);
    assert_int_equal(hits[1].hit.triangle, 4);
    free_fixture(&fixture);
}

/* ---- one way against the other ----------------------------------------------------------------------------------- */

static void assert_all_ways_agree(const struct fixture *fixture, const struct ray_list *list)
{
    for (size_t i = 0; i < list->count; i++) {
        struct reference_hit plain, filtered, searched;
        reference_trace_plain(fixture->reference, &list->rays[i], &plain);
        reference_trace_filtered(fixture->reference, &list->rays[i], &filtered);
        reference_trace(fixture->reference, &list->rays[i], &searched);
        check_hit(fixture, "reference, filtered", i, &list->rays[i], &plain, &filtered);
        check_hit(fixture, "reference, searched", i, &list->rays[i], &plain, &searched);
    }
}

enum { LIST_CAPACITY = 400 };

static void assert_lists_agree(const struct fixture *fixture, const struct ray_list *list)
{
    struct reference_list_hit plain[LIST_CAPACITY], searched[LIST_CAPACITY];
    for (size_t i = 0; i < list->count; i++) {
        const struct reference_ray *ray = &list->rays[i];
        struct reference_hit closest;
        struct reference_totals all = reference_trace_all_plain(fixture->reference, ray, plain, LIST_CAPACITY);
        struct reference_totals same = reference_trace_all(fixture->reference, ray, searched, LIST_CAPACITY);
        if (all.hit_count != same.hit_count || all.crossing_count != same.crossing_count)
            fail_msg("%s, ray %zu: %zu hits and %zu crossings, or %zu and %zu", fixture->name, i, all.hit_count,
                     all.crossing_count, same.hit_count, same.crossing_count);
        assert_true(all.crossing_count <= all.hit_count && all.hit_count <= LIST_CAPACITY);
        for (size_t j = 0; j < all.hit_count; j++) {
            check_hit(fixture, "reference, all hits", i, ray, &plain[j].hit, &searched[j].hit);
            assert_int_equal(plain[j].crossing, searched[j].crossing);
            assert_true(j == 0 || plain[j - 1].hit.t <= plain[j].hit.t);
        }
        reference_trace_plain(fixture->reference, ray, &closest);
        if (all.hit_count)
            check_hit(fixture, "reference, first of all", i, ray, &closest, &plain[0].hit);
        else
            assert_miss(closest);
    }
}

static void compare_ways(const char *name, struct soup *soup, float lo, float hi)
{
    struct random random = {21};
    struct ray_list list = {0};
    struct fixture fixture = fixture_of_soup(name, 21, soup);
    add_mixed_rays(&list, &random, &fixture, scaled(300), lo, hi);
    assert_all_ways_agree(&fixture, &list);
    if (list.count > 120) list.count = 120;
    assert_lists_agree(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

static void all_ways_agree_on_random_triangles(void **state)
{
    (void)state;
    struct soup soup = {0};
    struct random random = {1};
    soup_add_random(&soup, &random, 200, 1, 0.5f);
    compare_ways("random", &soup, -2, 2);
}

static void all_ways_agree_on_needles(void **state)
{
    (void)state;
    struct soup soup = {0};
    struct random random = {2};
    soup_add_needles(&soup, &random, 100, 1e6f);
    compare_ways("needles", &soup, -2, 2);
}

static void all_ways_agree_on_coplanar_grids(void **state)
{
    (void)state;
    struct soup soup = {0};
    soup_add_grid(&soup, 2, 0, 6);
    soup_add_grid(&soup, 2, 0, 6);
    soup_add_grid(&soup, 0, 3, 6);
    compare_ways("grids", &soup, -2, 8);
}

static void all_ways_agree_far_from_the_origin(void **state)
{
    (void)state;
    const float offset[3] = {1e7f, -1e7f, 1e7f};
    struct soup soup = {0};
    soup_add_icosphere(&soup, 1, 8);
    move_soup(&soup, 1, offset);
    compare_ways("far away", &soup, -1e7f, 1e7f);
}

static void all_ways_agree_at_every_scale(void **state)
{
    (void)state;
    static const float scales[] = {1e-38f, 1e-30f, 1e-10f, 1e10f, 1e30f, 1e38f};
    for (size_t i = 0; i < sizeof scales / sizeof scales[0]; i++) {
        const float zero[3] = {0, 0, 0};
        struct soup soup = {0};
        struct random random = {i};
        soup_add_random(&soup, &random, 60, 1, 0.5f);
        move_soup(&soup, scales[i], zero);
        compare_ways("scaled", &soup, -2 * scales[i], 2 * scales[i]);
    }
}

static void all_ways_agree_on_arbitrary_bits(void **state)
{
    (void)state;
    struct random random = {3};
    struct soup soup = {0};
    struct ray_list list = {0};
    for (int i = 0; i < 60; i++) {
        float p[3][3];
        for (int k = 0; k < 9; k++) p[k / 3][k % 3] = draw_finite(&random);
        soup_add_triangle(&soup, p[0], p[1], p[2]);
    }
    struct fixture fixture = fixture_of_soup("arbitrary bits", 3, &soup);
    for (size_t i = 0; i < scaled(300); i++) {
        float p[2][3];
        for (int k = 0; k < 6; k++) p[k / 3][k % 3] = draw_finite(&random);
        add_ray(&list, p[0], p[1]);
    }
    add_aimed_rays(&list, &random, &fixture, scaled(300), -1e38f, 1e38f);
    assert_all_ways_agree(&fixture, &list);
    assert_lists_agree(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

static void no_ray_leaves_a_closed_mesh_unnoticed(void **state)
{
    (void)state;
    struct random random = {4};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_icosphere(&soup, 3, 1);
    struct fixture fixture = fixture_of_soup("icosphere", 4, &soup);
    add_aimed_rays(&list, &random, &fixture, scaled(8000), -0.25f, 0.25f);
    for (size_t i = 0; i < list.count; i++) {
        struct reference_hit hit;
        reference_trace(fixture.reference, &list.rays[i], &hit);
        assert_int_not_equal(hit.mesh, REFERENCE_NONE);
    }
    free_rays(&list);
    free_fixture(&fixture);
}

static void pixel_vectors_are_rounded_step_by_step(void **state)
{
    (void)state;
    struct random random = {5};
    for (int i = 0; i < 5000; i++) {
        float v[4][3], got[3];
        uint32_t column = draw_below(&random, 8192), row = draw_below(&random, 8192);
        for (int k = 0; k < 12; k++) v[k / 3][k % 3] = draw_range(&random, -2, 2);
        reference_pixel_vector(v[0], v[1], v[2], column, row, v[3][0], v[3][1], got);
        for (int k = 0; k < 3; k++) {
            volatile float x = (float)column + v[3][0], y = (float)row + v[3][1];
            volatile float along = x * v[1][k], down = y * v[2][k];
            volatile float sum = v[0][k] + along;
            sum = sum + down;
            assert_true(got[k] == sum);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reports_t_u_v_ids_and_facing),
        cmocka_unit_test(facing_is_negative_against_the_normal),
        cmocka_unit_test(edges_and_vertices_belong_to_the_triangle),
        cmocka_unit_test(one_float_outside_is_outside),
        cmocka_unit_test(the_interval_is_half_open),
        cmocka_unit_test(a_ray_in_the_plane_misses),
        cmocka_unit_test(invalid_rays_miss),
        cmocka_unit_test(of_equal_distances_the_first_wins),
        cmocka_unit_test(skip_passes_one_triangle),
        cmocka_unit_test(unusable_triangles_are_counted_and_never_hit),
        cmocka_unit_test(quotients_round_as_the_machine_divides),
        cmocka_unit_test(quotients_halfway_go_to_even),
        cmocka_unit_test(quotients_reach_denormals_and_zero),
        cmocka_unit_test(quotients_overflow_to_infinity),
        cmocka_unit_test(crossings_of_a_cube),
        cmocka_unit_test(all_hits_are_in_order),
        cmocka_unit_test(all_ways_agree_on_random_triangles),
        cmocka_unit_test(all_ways_agree_on_needles),
        cmocka_unit_test(all_ways_agree_on_coplanar_grids),
        cmocka_unit_test(all_ways_agree_far_from_the_origin),
        cmocka_unit_test(all_ways_agree_at_every_scale),
        cmocka_unit_test(all_ways_agree_on_arbitrary_bits),
        cmocka_unit_test(no_ray_leaves_a_closed_mesh_unnoticed),
        cmocka_unit_test(pixel_vectors_are_rounded_step_by_step),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
