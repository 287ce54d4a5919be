/* SPDX-License-Identifier: MIT */
/*
 * mlrt_trace_ray: what one ray reports, field by field, and the forms in which triangles come in.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

static const float corner_a[3] = {0, 0, 5}, corner_b[3] = {1, 0, 5}, corner_c[3] = {0, 1, 5};

static mlrt_tree *tree_of(const mlrt_mesh *meshes, size_t count)
{
    mlrt_tree *tree = NULL;
    assert_int_equal(mlrt_build_tree(meshes, count, NULL, &tree), MLRT_OK);
    assert_non_null(tree);
    return tree;
}

static mlrt_tree *one_triangle(void)
{
    struct soup soup = {0};
    soup_add_triangle(&soup, corner_a, corner_b, corner_c);
    mlrt_mesh mesh = soup_mesh(&soup);
    mlrt_tree *tree = tree_of(&mesh, 1);
    free_soup(&soup);
    return tree;
}

static mlrt_ray ray_up(float x, float y)
{
    mlrt_ray ray = {.struct_size = sizeof ray, .origin = {x, y, 0}, .direction = {0, 0, 1}};
    return ray;
}

static mlrt_hit trace(const mlrt_tree *tree, const mlrt_ray *ray)
{
    mlrt_hit hit = {.struct_size = sizeof hit};
    assert_int_equal(mlrt_trace_ray(tree, ray, NULL, &hit), MLRT_OK);
    return hit;
}

static mlrt_hit trace_and_destroy(mlrt_tree *tree, const mlrt_ray *ray)
{
    mlrt_hit hit = trace(tree, ray);
    mlrt_destroy_tree(tree);
    return hit;
}

static void assert_miss(mlrt_hit hit)
{
    assert_true(isinf(hit.t) && hit.t > 0);
    assert_int_equal(bits_of_float(hit.u), 0);
    assert_int_equal(bits_of_float(hit.v), 0);
    assert_int_equal(hit.mesh, MLRT_NONE);
    assert_int_equal(hit.triangle, MLRT_NONE);
    assert_int_equal(hit.facing, 0);
    assert_int_equal(hit.occluded, 0);
}

static void a_hit_has_all_its_fields(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.25f, 0.5f);
    mlrt_hit hit = trace_and_destroy(one_triangle(), &ray);
    assert_true(hit.t == 5 && hit.u == 0.25f && hit.v == 0.5f);
    assert_int_equal(hit.mesh, 0);
    assert_int_equal(hit.triangle, 0);
    assert_int_equal(hit.facing, 1);
    assert_int_equal(hit.occluded, 1);
}

static void a_miss_has_all_its_fields(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.75f, 0.75f);
    assert_miss(trace_and_destroy(one_triangle(), &ray));
}

static void struct_size_of_the_hit_stays(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    assert_int_equal(trace_and_destroy(one_triangle(), &ray).struct_size, sizeof(mlrt_hit));
}

static void triangles_have_two_sides(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    ray.origin[2] = 6;
    ray.direction[2] = -1;
    mlrt_hit hit = trace_and_destroy(one_triangle(), &ray);
    assert_true(hit.t == 1);
    assert_int_equal(hit.facing, -1);
}

static void t_counts_in_lengths_of_the_direction(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    ray.direction[2] = 0.125f;
    assert_true(trace_and_destroy(one_triangle(), &ray).t == 40);
}

static void t_max_of_zero_is_no_limit(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    ray.t_max = 0;
    ray.direction[2] = 1e-30f;
    mlrt_hit hit = trace_and_destroy(one_triangle(), &ray);
    assert_int_equal(hit.triangle, 0);
}

static void t_max_of_minus_zero_is_no_limit(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    ray.t_max = -0.0f;
    assert_int_equal(trace_and_destroy(one_triangle(), &ray).triangle, 0);
}

static void t_max_is_inside_the_interval(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    ray.t_max = 5;
    assert_int_equal(trace_and_destroy(one_triangle(), &ray).triangle, 0);
}

static void below_t_max_by_one_float_is_a_miss(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    ray.t_max = next_float(5, -1);
    assert_miss(trace_and_destroy(one_triangle(), &ray));
}

static void t_min_is_outside_the_interval(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    ray.t_min = 5;
    assert_miss(trace_and_destroy(one_triangle(), &ray));
}

static void a_negative_t_min_counts_as_zero(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    ray.origin[2] = 6;
    ray.t_min = -10;
    assert_miss(trace_and_destroy(one_triangle(), &ray));
}

static void an_origin_on_the_triangle_does_not_hit_it(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    ray.origin[2] = 5;
    assert_miss(trace_and_destroy(one_triangle(), &ray));
}

static void a_negative_t_max_hits_nothing(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    ray.t_min = -20;
    ray.t_max = -1;
    ray.direction[2] = -1;
    assert_miss(trace_and_destroy(one_triangle(), &ray));
}

static void skip_needs_its_flag(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    ray.skip_mesh = 0;
    ray.skip_triangle = 0;
    assert_int_equal(trace_and_destroy(one_triangle(), &ray).triangle, 0);
}

static void skip_passes_the_triangle(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    ray.flags = MLRT_RAY_SKIP;
    assert_miss(trace_and_destroy(one_triangle(), &ray));
}

static void skip_of_none_skips_nothing(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    ray.flags = MLRT_RAY_SKIP;
    ray.skip_mesh = MLRT_NONE;
    ray.skip_triangle = MLRT_NONE;
    assert_int_equal(trace_and_destroy(one_triangle(), &ray).triangle, 0);
}

static void skip_of_a_triangle_that_does_not_exist_skips_nothing(void **state)
{
    (void)state;
    static const uint32_t names[][2] = {{0, 1}, {1, 0}, {0, MLRT_NONE}, {MLRT_NONE, 0}, {7, 7}, {0, 0x80000000u}};
    mlrt_tree *tree = one_triangle();
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        mlrt_ray ray = ray_up(0.25f, 0.25f);
        ray.flags = MLRT_RAY_SKIP;
        ray.skip_mesh = names[i][0];
        ray.skip_triangle = names[i][1];
        assert_int_equal(trace(tree, &ray).triangle, 0);
    }
    mlrt_destroy_tree(tree);
}

static void any_hit_writes_only_occluded(void **state)
{
    (void)state;
    mlrt_tree *tree = one_triangle();
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    mlrt_trace_options options = {.struct_size = sizeof options, .query = MLRT_QUERY_ANY};
    mlrt_hit hit = {sizeof hit, -1, -2, -3, 11, 12, 13, 14};
    assert_int_equal(mlrt_trace_ray(tree, &ray, &options, &hit), MLRT_OK);
    assert_true(hit.t == -1 && hit.u == -2 && hit.v == -3);
    assert_int_equal(hit.mesh, 11);
    assert_int_equal(hit.triangle, 12);
    assert_int_equal(hit.facing, 13);
    assert_int_equal(hit.occluded, 1);
    ray.direction[2] = -1;
    assert_int_equal(mlrt_trace_ray(tree, &ray, &options, &hit), MLRT_OK);
    assert_int_equal(hit.occluded, 0);
    mlrt_destroy_tree(tree);
}

static void invalid_rays_miss(void **state)
{
    (void)state;
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    mlrt_tree *tree = one_triangle();
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            mlrt_ray ray = ray_up(0.25f, 0.25f);
            ray.origin[k] = bad[i];
            assert_miss(trace(tree, &ray));
            ray = ray_up(0.25f, 0.25f);
            ray.direction[k] = bad[i];
            assert_miss(trace(tree, &ray));
        }
    }
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    ray.direction[2] = -0.0f;
    assert_miss(trace(tree, &ray));
    mlrt_destroy_tree(tree);
}

static void invalid_ranges_miss(void **state)
{
    (void)state;
    static const float ranges[][2] = {{NAN, 10}, {0, NAN}, {6, 4}, {5, 5}, {INFINITY, INFINITY}, {0, -INFINITY}};
    mlrt_tree *tree = one_triangle();
    for (size_t i = 0; i < sizeof ranges / sizeof ranges[0]; i++) {
        mlrt_ray ray = ray_up(0.25f, 0.25f);
        ray.t_min = ranges[i][0];
        ray.t_max = ranges[i][1];
        assert_miss(trace(tree, &ray));
    }
    mlrt_destroy_tree(tree);
}

static void t_min_of_minus_infinity_counts_as_zero(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    ray.t_min = -INFINITY;
    ray.t_max = INFINITY;
    assert_true(trace_and_destroy(one_triangle(), &ray).t == 5);
}

/* t beyond the largest float is still a hit: only its rounded number is infinite. */
static void a_hit_can_round_to_infinity(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    ray.direction[2] = float_of_bits(1);
    mlrt_hit hit = trace_and_destroy(one_triangle(), &ray);
    assert_true(isinf(hit.t));
    assert_int_equal(hit.triangle, 0);
    assert_int_equal(hit.facing, 1);
    assert_int_equal(hit.occluded, 1);
    assert_true(hit.u == 0.25f && hit.v == 0.25f);
}

static void a_hit_can_round_to_zero(void **state)
{
    (void)state;
    const float low = float_of_bits(1), a[3] = {0, 0, low}, b[3] = {1, 0, low}, c[3] = {0, 1, low};
    struct soup soup = {0};
    soup_add_triangle(&soup, a, b, c);
    struct fixture fixture = fixture_of_soup("t = 2^-249", 0, &soup);
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    ray.direction[2] = 1.2676506e30f; // 2^100
    mlrt_hit hit = trace(fixture.tree, &ray);
    assert_int_equal(bits_of_float(hit.t), 0);
    assert_int_equal(hit.triangle, 0);
    free_fixture(&fixture);
}

/*
 * Rays through the first vertex of the triangle, on an edge of the scene's box: they enter the box along x at the t at
 * which they leave it along y, which is some hundred to some million times the least float. There the two distances are
 * rounded apart by more than the slack that is a share of t.
 */
static void rays_through_an_edge_of_the_scene_at_a_denormal_t(void **state)
{
    (void)state;
    const float a = 0x1.8p-60f;
    const float corners[9] = {a, a, 0, 1, -1, 1, 1, -1, -1};
    const mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = corners, .vertex_count = 3, .triangle_count = 1};
    struct random random = {64};
    mlrt_tree *tree = build_structure(&mesh, 1, MLRT_STRUCTURE_BVH);
    for (int i = 0; i < 20000; i++) {
        const float step = (float)(1 + draw_below(&random, 1 << 13)) * 0x1p-83f; // floats are 2^-83 apart here
        const float d = (float)(0x100000 + draw_below(&random, 0x100000)) * 0x1p37f;
        const mlrt_ray ray = {
            .struct_size = sizeof ray, .origin = {a - 3 * step, a - step, 0}, .direction = {3 * d, d, 0}};
        const mlrt_hit hit = trace(tree, &ray);
        assert_true(hit.t > 0 && hit.t < 0x1p-126f);
        assert_int_equal(hit.triangle, 0);
    }
    mlrt_destroy_tree(tree);
}

static void weights_that_are_zero_have_no_sign(void **state)
{
    (void)state;
    mlrt_tree *tree = one_triangle();
    mlrt_ray ray = ray_up(0, 0);
    ray.origin[2] = 9;
    ray.direction[2] = -1;
    mlrt_hit hit = trace(tree, &ray);
    assert_int_equal(bits_of_float(hit.u), 0);
    assert_int_equal(bits_of_float(hit.v), 0);
    ray = ray_up(-0.0f, -0.0f);
    hit = trace_and_destroy(tree, &ray);
    assert_int_equal(bits_of_float(hit.u), 0);
    assert_int_equal(bits_of_float(hit.v), 0);
}

/* ---- forms of meshes --------------------------------------------------------------------------------------------- */

static void an_empty_tree_is_missed(void **state)
{
    (void)state;
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    assert_miss(trace_and_destroy(tree_of(NULL, 0), &ray));
}

static void a_mesh_without_triangles_is_missed(void **state)
{
    (void)state;
    mlrt_mesh mesh = {.struct_size = sizeof mesh};
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    assert_miss(trace_and_destroy(tree_of(&mesh, 1), &ray));
}

static void meshes_may_be_changed_after_the_build(void **state)
{
    (void)state;
    float corners[9] = {0, 0, 5, 1, 0, 5, 0, 1, 5};
    mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = corners, .vertex_count = 3, .triangle_count = 1};
    mlrt_tree *tree = tree_of(&mesh, 1);
    memset(corners, 0xFF, sizeof corners);
    memset(&mesh, 0xFF, sizeof mesh);
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    assert_true(trace_and_destroy(tree, &ray).t == 5);
}

static void positions_are_ids_if_all_ids_are_zero(void **state)
{
    (void)state;
    float low[9] = {0, 0, 5, 1, 0, 5, 0, 1, 5}, high[9] = {0, 0, 4, 1, 0, 4, 0, 1, 4};
    mlrt_mesh meshes[3] = {{.struct_size = sizeof meshes[0], .vertices = low, .vertex_count = 3, .triangle_count = 1},
                           {.struct_size = sizeof meshes[0]},
                           {.struct_size = sizeof meshes[0], .vertices = high, .vertex_count = 3, .triangle_count = 1}};
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    assert_int_equal(trace_and_destroy(tree_of(meshes, 3), &ray).mesh, 2);
}

static void ids_are_reported(void **state)
{
    (void)state;
    float low[9] = {0, 0, 5, 1, 0, 5, 0, 1, 5}, high[9] = {0, 0, 4, 1, 0, 4, 0, 1, 4};
    mlrt_mesh meshes[2] = {
        {.struct_size = sizeof meshes[0], .id = 0, .vertices = low, .vertex_count = 3, .triangle_count = 1},
        {.struct_size = sizeof meshes[0], .id = 4000000000u, .vertices = high, .vertex_count = 3, .triangle_count = 1}};
    mlrt_tree *tree = tree_of(meshes, 2);
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    assert_int_equal(trace(tree, &ray).mesh, 4000000000u);
    ray.flags = MLRT_RAY_SKIP;
    ray.skip_mesh = 4000000000u;
    assert_int_equal(trace_and_destroy(tree, &ray).mesh, 0);
}

/* The tie goes by position in the array; the ids run the other way. */
static void ties_go_to_the_first_mesh_not_to_the_smallest_id(void **state)
{
    (void)state;
    float corners[9] = {0, 0, 5, 1, 0, 5, 0, 1, 5};
    mlrt_mesh meshes[2] = {
        {.struct_size = sizeof meshes[0], .id = 9, .vertices = corners, .vertex_count = 3, .triangle_count = 1},
        {.struct_size = sizeof meshes[0], .id = 3, .vertices = corners, .vertex_count = 3, .triangle_count = 1}};
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    assert_int_equal(trace_and_destroy(tree_of(meshes, 2), &ray).mesh, 9);
}

static void left_out_triangles_keep_the_numbers_of_the_others(void **state)
{
    (void)state;
    const float bad[3] = {NAN, 0, 0};
    struct soup soup = {0};
    soup_add_triangle(&soup, corner_a, corner_b, bad);
    soup_add_triangle(&soup, corner_a, corner_b, corner_a);
    soup_add_triangle(&soup, corner_a, corner_b, corner_c);
    struct fixture fixture = fixture_of_soup("two left out", 0, &soup);
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    assert_int_equal(trace(fixture.tree, &ray).triangle, 2);
    free_fixture(&fixture);
}

struct packed_vertex {
    uint32_t before;
    float position[3];
    uint32_t after[3];
};

/* Vertices inside bigger records that lie at 4 mod 8, index triples inside bigger records: all sizes and strides. */
static void trace_strided(uint32_t index_size)
{
    struct random random = {index_size};
    enum { VERTICES = 40, TRIANGLES = 120 };
    struct packed_vertex *vertices = allocate_or_fail(VERTICES + 1, sizeof *vertices);
    unsigned char *indices = allocate_or_fail(TRIANGLES, 5 * index_size);
    struct packed_vertex *odd = (struct packed_vertex *)((unsigned char *)vertices + 4);
    for (int i = 0; i < VERTICES; i++) draw_point(&random, -1, 1, odd[i].position);
    for (size_t i = 0; i < TRIANGLES; i++) {
        for (size_t c = 0; c < 5; c++) {
            uint32_t wide = c < 3 ? draw_below(&random, VERTICES) : 0xFFFFFFFFu;
            uint16_t narrow = (uint16_t)wide;
            if (index_size == 2)
                memcpy(indices + (5 * i + c) * 2, &narrow, 2);
            else
                memcpy(indices + (5 * i + c) * 4, &wide, 4);
        }
    }
    mlrt_mesh mesh = {.struct_size = sizeof mesh,
                      .vertices = odd[0].position,
                      .vertex_count = VERTICES,
                      .vertex_stride = sizeof *odd,
                      .indices = indices,
                      .triangle_count = TRIANGLES,
                      .triangle_stride = 5 * index_size,
                      .index_size = index_size};
    struct fixture fixture = make_fixture("strided mesh", index_size, &mesh, 1);
    struct ray_list list = {0};
    add_mixed_rays(&list, &random, &fixture, 600, -2, 2);
    check_rays_quickly(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
    free(vertices);
    free(indices);
}

static void indices_of_16_bits_with_strides(void **state)
{
    (void)state;
    trace_strided(2);
}

static void indices_of_32_bits_with_strides(void **state)
{
    (void)state;
    trace_strided(4);
}

/* A page that must not be touched begins right behind the vertices, and one behind the indices. */
static void nothing_behind_a_mesh_is_read(void **state)
{
    (void)state;
    enum { VERTICES = 5, TRIANGLES = 7 };
    struct random random = {3};
    float *vertices = allocate_guarded(VERTICES * 12);
    uint16_t *narrow = allocate_guarded(TRIANGLES * 6);
    uint32_t *wide = allocate_guarded(TRIANGLES * 12);
    for (int i = 0; i < 3 * VERTICES; i++) vertices[i] = draw_range(&random, -1, 1);
    for (int i = 0; i < 3 * TRIANGLES; i++) narrow[i] = (uint16_t)(wide[i] = draw_below(&random, VERTICES));
    mlrt_mesh meshes[3] = {
        {.struct_size = sizeof meshes[0],
         .vertices = vertices,
         .vertex_count = VERTICES,
         .indices = narrow,
         .triangle_count = TRIANGLES,
         .index_size = 2},
        {.struct_size = sizeof meshes[0],
         .vertices = vertices,
         .vertex_count = VERTICES,
         .indices = wide,
         .triangle_count = TRIANGLES},
        {.struct_size = sizeof meshes[0], .vertices = vertices + 6, .vertex_count = 3, .triangle_count = 1}};
    mlrt_destroy_tree(tree_of(meshes, 3));
    free_guarded(vertices, VERTICES * 12);
    free_guarded(narrow, TRIANGLES * 6);
    free_guarded(wide, TRIANGLES * 12);
}

/* With a stride larger than an element, the last element ends the array: its padding is not there. */
static void padding_of_the_last_element_is_not_read(void **state)
{
    (void)state;
    enum { STRIDE = 32 };
    unsigned char *vertices = allocate_guarded(2 * STRIDE + 12);
    unsigned char *indices = allocate_guarded(STRIDE + 12);
    const float corners[3][3] = {{0, 0, 5}, {1, 0, 5}, {0, 1, 5}};
    const uint32_t triples[2][3] = {{0, 1, 2}, {2, 1, 0}};
    for (int i = 0; i < 3; i++) memcpy(vertices + STRIDE * i, corners[i], 12);
    for (int i = 0; i < 2; i++) memcpy(indices + STRIDE * i, triples[i], 12);
    mlrt_mesh mesh = {.struct_size = sizeof mesh,
                      .vertices = vertices,
                      .vertex_count = 3,
                      .vertex_stride = STRIDE,
                      .indices = indices,
                      .triangle_count = 2,
                      .triangle_stride = STRIDE};
    mlrt_ray ray = ray_up(0.25f, 0.25f);
    assert_true(trace_and_destroy(tree_of(&mesh, 1), &ray).t == 5);
    free_guarded(vertices, 2 * STRIDE + 12);
    free_guarded(indices, STRIDE + 12);
}

static void several_meshes_match_the_reference(void **state)
{
    (void)state;
    struct random random = {77};
    struct soup soups[3] = {{0}, {0}, {0}};
    soup_add_random(&soups[0], &random, 60, 1, 0.5f);
    soup_add_icosphere(&soups[1], 1, 1);
    soup_add_icosphere(&soups[2], 1, 1); // every triangle ties with one of the mesh before
    mlrt_mesh meshes[4];
    for (int i = 0; i < 3; i++) meshes[i] = soup_mesh(&soups[i]);
    meshes[3] = soup_mesh(&soups[0]);
    meshes[0].id = 500;
    meshes[1].id = 20;
    meshes[2].id = 10;
    meshes[3].id = 0;
    struct fixture fixture = make_fixture("several meshes", 77, meshes, 4);
    struct ray_list list = {0};
    add_mixed_rays(&list, &random, &fixture, scaled(3000), -2, 2);
    check_rays(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
    for (int i = 0; i < 3; i++) free_soup(&soups[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_hit_has_all_its_fields),
        cmocka_unit_test(a_miss_has_all_its_fields),
        cmocka_unit_test(struct_size_of_the_hit_stays),
        cmocka_unit_test(triangles_have_two_sides),
        cmocka_unit_test(t_counts_in_lengths_of_the_direction),
        cmocka_unit_test(t_max_of_zero_is_no_limit),
        cmocka_unit_test(t_max_of_minus_zero_is_no_limit),
        cmocka_unit_test(t_max_is_inside_the_interval),
        cmocka_unit_test(below_t_max_by_one_float_is_a_miss),
        cmocka_unit_test(t_min_is_outside_the_interval),
        cmocka_unit_test(a_negative_t_min_counts_as_zero),
        cmocka_unit_test(an_origin_on_the_triangle_does_not_hit_it),
        cmocka_unit_test(a_negative_t_max_hits_nothing),
        cmocka_unit_test(skip_needs_its_flag),
        cmocka_unit_test(skip_passes_the_triangle),
        cmocka_unit_test(skip_of_none_skips_nothing),
        cmocka_unit_test(skip_of_a_triangle_that_does_not_exist_skips_nothing),
        cmocka_unit_test(any_hit_writes_only_occluded),
        cmocka_unit_test(invalid_rays_miss),
        cmocka_unit_test(invalid_ranges_miss),
        cmocka_unit_test(t_min_of_minus_infinity_counts_as_zero),
        cmocka_unit_test(a_hit_can_round_to_infinity),
        cmocka_unit_test(a_hit_can_round_to_zero),
        cmocka_unit_test(rays_through_an_edge_of_the_scene_at_a_denormal_t),
        cmocka_unit_test(weights_that_are_zero_have_no_sign),
        cmocka_unit_test(an_empty_tree_is_missed),
        cmocka_unit_test(a_mesh_without_triangles_is_missed),
        cmocka_unit_test(meshes_may_be_changed_after_the_build),
        cmocka_unit_test(positions_are_ids_if_all_ids_are_zero),
        cmocka_unit_test(ids_are_reported),
        cmocka_unit_test(ties_go_to_the_first_mesh_not_to_the_smallest_id),
        cmocka_unit_test(left_out_triangles_keep_the_numbers_of_the_others),
        cmocka_unit_test(indices_of_16_bits_with_strides),
        cmocka_unit_test(indices_of_32_bits_with_strides),
        cmocka_unit_test(nothing_behind_a_mesh_is_read),
        cmocka_unit_test(padding_of_the_last_element_is_not_read),
        cmocka_unit_test(several_meshes_match_the_reference),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
