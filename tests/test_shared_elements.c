/* SPDX-License-Identifier: MIT */
/*
 * Elements that serve several rays: arrays with MLRT_STRIDE_ALL, and rays_per_origin. The answers must be, bit for bit,
 * those of the arrays written out in full, by every way of tracing, with nothing read behind the last element.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

enum { ORIGINS, DIRECTIONS, T_MIN, T_MAX, SKIP, MASK, ARRAY_COUNT };
enum { WORDS = 6, CAPACITY = 3, MESH_COUNT = 3 };

static const size_t element_sizes[ARRAY_COUNT] = {12, 12, 4, 4, 8, 4};

/* ---- rays in two forms ------------------------------------------------------------------------------------------- */

struct form {
    size_t count;
    uint32_t rays_per_origin;
    uint32_t row_length;
    uint32_t given;  /* bit k: array k is there */
    uint32_t shared; /* bit k: array k has MLRT_STRIDE_ALL */
    size_t gap;      /* bytes between elements */
};

/* The arrays of a form, which end with their memory, and the same written out in full. */
struct arrays {
    unsigned char *own[ARRAY_COUNT];
    size_t own_size[ARRAY_COUNT];
    unsigned char *full[ARRAY_COUNT];
    mlrt_rays rays;
    mlrt_rays full_rays;
};

static size_t rays_per_element(const struct form *form, int k)
{
    if (form->shared >> k & 1) return form->count;
    return form->rays_per_origin && (k == ORIGINS || k == T_MIN || k == SKIP) ? form->rays_per_origin : 1;
}

static void draw_element(struct random *random, int k, const mlrt_tree *tree, size_t i, uint32_t coherent,
                         void *element)
{
    float vector[3];
    mlrt_hit hit = {.struct_size = sizeof hit};
    mlrt_ray ray = {.struct_size = sizeof ray};
    switch (k) {
    case ORIGINS:
        draw_point(random, -1.6f, 1.6f, vector);
        memcpy(element, vector, 12);
        break;
    case DIRECTIONS:
        draw_point(random, -1, 1, vector);
        if (coherent) {
            vector[0] = 0.02f * (float)(i % 10) - 0.1f;
            vector[1] = 1;
            vector[2] = 0.03f * (float)(i / 10 % 16) - 0.3f;
        }
        memcpy(element, vector, 12);
        break;
    case SKIP: /* often something that a ray from outside hits */
        draw_point(random, -2, 2, ray.origin);
        for (int axis = 0; axis < 3; axis++) ray.direction[axis] = -ray.origin[axis];
        assert_int_equal(mlrt_trace_ray(tree, &ray, NULL, &hit), MLRT_OK);
        memcpy(element, (uint32_t[]){hit.mesh, hit.triangle}, 8);
        break;
    case MASK:
        memcpy(element, (uint32_t[]){draw_below(random, 1u << MESH_COUNT)}, 4);
        break;
    default: /* ranges */
        vector[0] = draw_below(random, 3) ? draw_range(random, 0, 1) + (k == T_MAX) : k == T_MAX ? INFINITY : 0;
        memcpy(element, vector, 4);
    }
}

static mlrt_const_array *array_of(mlrt_rays *rays, int k)
{
    mlrt_const_array *const arrays[ARRAY_COUNT] = {&rays->origins, &rays->directions, &rays->t_min,
                                                   &rays->t_max,   &rays->skip,       &rays->mask};
    return arrays[k];
}

static struct arrays make_arrays(struct random *random, const mlrt_tree *tree, const struct form *form)
{
    const mlrt_rays rays = {.struct_size = sizeof rays, .row_length = form->row_length, .count = form->count};
    struct arrays arrays = {.rays = rays, .full_rays = rays};
    const uint32_t coherent = draw_below(random, 2);
    arrays.rays.rays_per_origin = form->rays_per_origin;
    for (int k = 0; k < ARRAY_COUNT; k++) {
        if (!(form->given >> k & 1)) continue;
        const size_t size = element_sizes[k], stride = size + form->gap, each = rays_per_element(form, k);
        const size_t element_count = form->count / each;
        arrays.own_size[k] = (element_count - 1) * stride + size;
        arrays.own[k] = allocate_guarded(arrays.own_size[k]);
        arrays.full[k] = allocate_or_fail(form->count, size);
        for (size_t i = 0; i < element_count; i++) {
            draw_element(random, k, tree, i, coherent, arrays.own[k] + i * stride);
        }
        for (size_t i = 0; i < form->count; i++) {
            memcpy(arrays.full[k] + i * size, arrays.own[k] + i / each * stride, size);
        }
        *array_of(&arrays.rays, k) =
            (mlrt_const_array){arrays.own[k], form->shared >> k & 1 ? MLRT_STRIDE_ALL : stride};
        *array_of(&arrays.full_rays, k) = (mlrt_const_array){arrays.full[k], 0};
    }
    return arrays;
}

static void free_arrays(struct arrays *arrays)
{
    for (int k = 0; k < ARRAY_COUNT; k++) {
        if (arrays->own[k]) free_guarded(arrays->own[k], arrays->own_size[k]);
        free(arrays->full[k]);
    }
}

/* ---- what is found ----------------------------------------------------------------------------------------------- */

/* The results of so many rays: closest, any and all hits. */
struct results {
    size_t size; /* bytes of data */
    unsigned char *data;
    mlrt_hits closest;
    mlrt_hits any;
    mlrt_hit_lists all;
};

static struct results make_results(size_t count)
{
    struct results results = {.size = count * (4 * (WORDS + 2 * CAPACITY + 2) + 1 + CAPACITY)};
    unsigned char *data = results.data = allocate_or_fail(results.size, 1);
    mlrt_hits *closest = &results.closest, *any = &results.any;
    mlrt_hit_lists *all = &results.all;
    memset(data, 0xA5, results.size);
    closest->struct_size = any->struct_size = sizeof *closest;
    all->struct_size = sizeof *all;
    all->capacity = CAPACITY;
    mlrt_array *const words[] = {&closest->t,        &closest->u,      &closest->v, &closest->mesh,
                                 &closest->triangle, &closest->facing, &all->total, &all->crossing_total};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++, data += 4 * count) words[i]->data = data;
    all->t.data = data;
    all->triangle.data = data + 4 * count * CAPACITY;
    all->crossing.data = data + 8 * count * CAPACITY;
    any->occluded.data = data + 9 * count * CAPACITY;
    return results;
}

static void check_same(const struct results *expected, const struct results *got, const char *what,
                       const struct form *form)
{
    for (size_t i = 0; i < expected->size; i++) {
        if (expected->data[i] == got->data[i]) continue;
        fail_msg("%s: byte %zu of the results of %zu rays differs (rays_per_origin %u, row_length %u, given %x, shared "
                 "%x, gap %zu)",
                 what, i, form->count, (unsigned)form->rays_per_origin, (unsigned)form->row_length,
                 (unsigned)form->given, (unsigned)form->shared, form->gap);
    }
}

static void trace_both(const mlrt_tree *tree, const mlrt_rays *rays, const mlrt_trace_options *options,
                       const struct results *results)
{
    mlrt_trace_options any = *options;
    any.query = MLRT_QUERY_ANY;
    assert_int_equal(mlrt_trace_packet(tree, rays, options, &results->closest), MLRT_OK);
    assert_int_equal(mlrt_trace_packet(tree, rays, &any, &results->any), MLRT_OK);
}

static void check_all_hits(const mlrt_tree *tree, const struct arrays *arrays, const struct form *form)
{
    struct results expected = make_results(form->count), got = make_results(form->count);
    assert_int_equal(mlrt_trace_all_hits(tree, &arrays->full_rays, NULL, &expected.all), MLRT_OK);
    assert_int_equal(mlrt_trace_all_hits(tree, &arrays->rays, NULL, &got.all), MLRT_OK);
    check_same(&expected, &got, "all hits", form);
    free(expected.data);
    free(got.data);
}

static void check_form(const struct fixture *fixture, struct random *random, const struct form *form, int probes_only)
{
    struct arrays arrays = make_arrays(random, fixture->tree, form);
    struct results expected = make_results(form->count), got = make_results(form->count);
    const mlrt_trace_options one_by_one = {.struct_size = sizeof one_by_one, .method = MLRT_METHOD_RAY};
    trace_both(fixture->tree, &arrays.full_rays, &one_by_one, &expected);
    for (size_t v = first_variant(); v < variant_count(); v += variant_step()) {
        const struct variant *variant = variant_at(v);
        if (probes_only && !variant->probe) continue;
        char text[200];
        mlrt_trace_options options = variant->options;
        options.pool = shared_pool(variant->threads);
        memset(got.data, 0xA5, got.size);
        trace_both(variant_tree(variant, fixture), &arrays.rays, &options, &got);
        describe("trace_packet", &options, variant->threads, text, sizeof text);
        check_same(&expected, &got, text, form);
    }
    check_all_hits(fixture->tree, &arrays, form);
    free(expected.data);
    free(got.data);
    free_arrays(&arrays);
}

/* ---- scenes and forms -------------------------------------------------------------------------------------------- */

/* A torus of three meshes, with masks or without. */
static struct fixture make_torus(int has_masks)
{
    struct soup soup = {0};
    soup_add_torus(&soup, 24, 12, 1, 0.4f);
    mlrt_mesh meshes[MESH_COUNT];
    const size_t third = soup.count / MESH_COUNT;
    for (uint32_t i = 0; i < MESH_COUNT; i++) {
        meshes[i] = soup_mesh(&soup);
        meshes[i].id = 70 - 30 * i;
        meshes[i].mask = has_masks ? 1u << i : 0;
        meshes[i].vertices = soup.corners + 9 * third * i;
        meshes[i].triangle_count = i + 1 < MESH_COUNT ? third : soup.count - (MESH_COUNT - 1) * third;
        meshes[i].vertex_count = 3 * meshes[i].triangle_count;
    }
    struct fixture fixture = make_fixture(has_masks ? "masked torus" : "torus", 2301, meshes, MESH_COUNT);
    free_soup(&soup);
    return fixture;
}

/* Arrays of any kind: most are there, and one in three is shared. */
static struct form draw_form(struct random *random, uint32_t rays_per_origin, size_t count)
{
    struct form form = {.count = count, .rays_per_origin = rays_per_origin, .given = 1u << ORIGINS | 1u << DIRECTIONS};
    for (int k = 0; k < ARRAY_COUNT; k++) {
        if (draw_below(random, 3)) form.given |= 1u << k;
        if (draw_below(random, 3) == 0) form.shared |= 1u << k;
    }
    if (draw_below(random, 2)) form.given &= ~(1u << MASK); /* rays with masks take ways of their own */
    form.row_length = draw_below(random, 2) ? 0 : 1 + draw_below(random, 40);
    form.gap = draw_below(random, 3) * 4;
    return form;
}

static void check_forms(uint32_t rays_per_origin, size_t form_count, size_t origin_limit, int probes_only)
{
    for (int has_masks = 0; has_masks < 2; has_masks++) {
        struct fixture fixture = make_torus(has_masks);
        struct random random = {2302 + rays_per_origin};
        for (size_t i = 0; i < form_count; i++) {
            const size_t origin_count = 1 + draw_below(&random, (uint32_t)origin_limit);
            const size_t count = (rays_per_origin ? rays_per_origin : 1) * origin_count;
            const struct form form = draw_form(&random, rays_per_origin, count);
            check_form(&fixture, &random, &form, probes_only);
        }
        free_fixture(&fixture);
    }
}

static void one_element_for_all_rays(void **state)
{
    (void)state;
    check_forms(0, scaled(70), 90, 1);
    check_forms(1, scaled(14), 1500, 1);
    check_forms(0, scaled(8), 70, 0);
}

static void several_rays_of_one_origin(void **state)
{
    (void)state;
    static const uint32_t counts[] = {2, 3, 4, 5, 7, 15, 16, 17, 33, 64, 256, 999};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        check_forms(counts[i], scaled(10), 1 + 160 / counts[i], 1);
        check_forms(counts[i], 2, 1 + 160 / counts[i], 0);
    }
    check_forms(16, scaled(8), 300, 1);
}

/* Each array alone: none of the others hides what is wrong with it. */
static void each_array_alone(void **state)
{
    (void)state;
    struct fixture fixture = make_torus(1);
    struct random random = {2303};
    assert_true(MLRT_STRIDE_ALL == SIZE_MAX); /* languages that cannot read the header rely on it */
    for (int k = 0; k < ARRAY_COUNT; k++) {
        for (uint32_t rays_per_origin = 0; rays_per_origin <= 4; rays_per_origin += 4) {
            const struct form form = {.count = 68,
                                      .rays_per_origin = rays_per_origin,
                                      .row_length = 17,
                                      .given = 1u << ORIGINS | 1u << DIRECTIONS | 1u << k,
                                      .shared = 1u << k};
            check_form(&fixture, &random, &form, 0);
        }
    }
    free_fixture(&fixture);
}

/* ---- points ------------------------------------------------------------------------------------------------------ */

static void check_points_of(const struct fixture *fixture, struct random *random, const mlrt_light *light,
                            uint32_t shared)
{
    enum { COUNT = 77 };
    const struct form form = {.count = COUNT, .given = 1u << ORIGINS | 1u << SKIP, .shared = shared};
    struct arrays arrays = make_arrays(random, fixture->tree, &form);
    const mlrt_points full = {.struct_size = sizeof full,
                              .count = COUNT,
                              .positions = arrays.full_rays.origins,
                              .skip = arrays.full_rays.skip};
    mlrt_points points = full;
    points.positions = arrays.rays.origins;
    points.skip = arrays.rays.skip;
    for (size_t v = 0; v < variant_count(); v++) {
        const struct variant *variant = variant_at(v);
        const mlrt_tree *tree = variant_tree(variant, fixture);
        uint8_t expected[COUNT], got[COUNT];
        const mlrt_array to_expected = {expected, 0, 0}, to_got = {got, 0, 0};
        assert_int_equal(mlrt_occluded_points(tree, &full, light, &variant->options, &to_expected), MLRT_OK);
        assert_int_equal(mlrt_occluded_points(tree, &points, light, &variant->options, &to_got), MLRT_OK);
        assert_memory_equal(expected, got, COUNT);
    }
    free_arrays(&arrays);
}

static void points_that_share_elements(void **state)
{
    (void)state;
    const mlrt_light near_light = light_at(0.5f, -3, 0.75f), sun = light_from(0.25f, -1, 0.5f);
    struct fixture fixture = make_torus(0);
    struct random random = {2304};
    for (int i = 0; i < 6; i++) {
        check_points_of(&fixture, &random, &near_light, 1u << SKIP | (i & 1) << ORIGINS);
        check_points_of(&fixture, &random, &sun, 1u << SKIP | (i & 1) << ORIGINS);
    }
    free_fixture(&fixture);
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

struct lines {
    int count;
    char last[256];
};

static void take_line(void *user, int32_t level, const char *message)
{
    struct lines *lines = user;
    assert_int_equal(level, MLRT_LOG_ERROR);
    lines->count++;
    snprintf(lines->last, sizeof lines->last, "%s", message);
}

static void groups_must_divide_the_count(void **state)
{
    (void)state;
    struct fixture fixture = make_torus(0);
    struct random random = {2305};
    struct lines lines = {0};
    const mlrt_host host = {.struct_size = sizeof host, .user = &lines, .log = take_line};
    const mlrt_trace_options options = {.struct_size = sizeof options, .host = &host};
    const struct form form = {.count = 100, .given = 1u << ORIGINS | 1u << DIRECTIONS};
    struct arrays arrays = make_arrays(&random, fixture.tree, &form);
    struct results results = make_results(form.count);
    arrays.rays.rays_per_origin = 16;
    assert_int_equal(mlrt_trace_packet(fixture.tree, &arrays.rays, NULL, &results.closest), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_trace_packet(fixture.tree, &arrays.rays, &options, &results.closest), MLRT_ERROR_ARGUMENT);
    assert_string_equal(lines.last, "rays.rays_per_origin: 16 does not divide count 100");
    assert_int_equal(mlrt_trace_all_hits(fixture.tree, &arrays.rays, &options, &results.all), MLRT_ERROR_ARGUMENT);
    assert_int_equal(lines.count, 2);
    arrays.rays.rays_per_origin = 101;
    assert_int_equal(mlrt_trace_packet(fixture.tree, &arrays.rays, NULL, &results.closest), MLRT_ERROR_ARGUMENT);
    for (arrays.rays.count = 98; arrays.rays.count <= 100; arrays.rays.count++) {
        for (uint32_t k = 1; k <= 7; k++) {
            arrays.rays.rays_per_origin = k;
            assert_int_equal(mlrt_trace_packet(fixture.tree, &arrays.rays, NULL, &results.closest),
                             arrays.rays.count % k ? MLRT_ERROR_ARGUMENT : MLRT_OK);
        }
    }
    arrays.rays.count = 0;
    assert_int_equal(mlrt_trace_packet(fixture.tree, &arrays.rays, NULL, &results.closest), MLRT_OK);
    arrays.rays.count = 100;
    arrays.rays.rays_per_origin = 100;
    assert_int_equal(mlrt_trace_packet(fixture.tree, &arrays.rays, NULL, &results.closest), MLRT_OK);
    arrays.rays.reserved = 1;
    assert_int_equal(mlrt_trace_packet(fixture.tree, &arrays.rays, NULL, &results.closest), MLRT_ERROR_ARGUMENT);
    free(results.data);
    free_arrays(&arrays);
    free_fixture(&fixture);
}

/* A caller of the version before does not have the field: whatever lies behind its struct is not looked at. */
static void shorter_structs_have_rays_of_their_own(void **state)
{
    (void)state;
    struct fixture fixture = make_torus(0);
    struct random random = {2306};
    const struct form form = {.count = 100, .given = 1u << ORIGINS | 1u << DIRECTIONS};
    struct arrays arrays = make_arrays(&random, fixture.tree, &form);
    struct results expected = make_results(form.count), got = make_results(form.count);
    arrays.rays.struct_size = (uint32_t)offsetof(mlrt_rays, rays_per_origin);
    arrays.rays.rays_per_origin = 16;
    arrays.rays.reserved = 16;
    const mlrt_trace_options options = {.struct_size = sizeof options};
    trace_both(fixture.tree, &arrays.full_rays, &options, &expected);
    trace_both(fixture.tree, &arrays.rays, &options, &got);
    check_same(&expected, &got, "shorter struct", &form);
    free(expected.data);
    free(got.data);
    free_arrays(&arrays);
    free_fixture(&fixture);
}

static void results_need_elements(void **state)
{
    (void)state;
    struct fixture fixture = make_torus(0);
    struct random random = {2307};
    const struct form form = {.count = 5, .given = 1u << ORIGINS | 1u << DIRECTIONS};
    struct arrays arrays = make_arrays(&random, fixture.tree, &form);
    struct results results = make_results(form.count);
    mlrt_array *const closest[] = {&results.closest.t,    &results.closest.u,        &results.closest.v,
                                   &results.closest.mesh, &results.closest.triangle, &results.closest.facing};
    mlrt_array *const lists_of_hits[] = {&results.all.t, &results.all.triangle, &results.all.crossing,
                                         &results.all.total, &results.all.crossing_total};
    static const char *const closest_names[] = {"t", "u", "v", "mesh", "triangle", "facing"};
    static const char *const list_names[] = {"t", "triangle", "crossing", "total", "crossing_total"};
    const char *const rest = ": stride MLRT_STRIDE_ALL is only for arrays of rays and points";
    char line[256];
    struct lines lines = {0};
    const mlrt_host host = {.struct_size = sizeof host, .user = &lines, .log = take_line};
    const mlrt_trace_options options = {.struct_size = sizeof options, .host = &host};
    const mlrt_trace_options any = {.struct_size = sizeof any, .query = MLRT_QUERY_ANY, .host = &host};
    for (size_t i = 0; i < sizeof closest / sizeof *closest; i++) {
        closest[i]->stride = MLRT_STRIDE_ALL;
        assert_int_equal(mlrt_trace_packet(fixture.tree, &arrays.rays, &options, &results.closest),
                         MLRT_ERROR_ARGUMENT);
        closest[i]->stride = 0;
        snprintf(line, sizeof line, "hits.%s%s", closest_names[i], rest);
        assert_string_equal(lines.last, line);
    }
    for (size_t i = 0; i < sizeof lists_of_hits / sizeof *lists_of_hits; i++) {
        lists_of_hits[i]->stride = MLRT_STRIDE_ALL;
        assert_int_equal(mlrt_trace_all_hits(fixture.tree, &arrays.rays, &options, &results.all), MLRT_ERROR_ARGUMENT);
        lists_of_hits[i]->stride = 0;
        snprintf(line, sizeof line, "lists.%s%s", list_names[i], rest);
        assert_string_equal(lines.last, line);
    }
    const mlrt_light light = light_at(0, -3, 0);
    const mlrt_points points = {.struct_size = sizeof points, .count = 5, .positions = arrays.rays.origins};
    results.any.occluded.stride = MLRT_STRIDE_ALL;
    assert_int_equal(mlrt_trace_packet(fixture.tree, &arrays.rays, &any, &results.any), MLRT_ERROR_ARGUMENT);
    assert_int_equal(strncmp(lines.last, "hits.occluded:", 14), 0);
    assert_int_equal(mlrt_occluded_points(fixture.tree, &points, &light, &options, &results.any.occluded),
                     MLRT_ERROR_ARGUMENT);
    assert_int_equal(strncmp(lines.last, "occluded:", 9), 0);
    const float eye[3] = {0, -3, 0}, target[3] = {0, 0, 0};
    const mlrt_camera camera = look_at(eye, target, 1, 5, 1);
    assert_int_equal(mlrt_render_tiles(fixture.tree, &camera, &any, &results.any, NULL, NULL), MLRT_ERROR_ARGUMENT);
    results.any.occluded.stride = 0;
    assert_int_equal(mlrt_render_tiles(fixture.tree, &camera, &any, &results.any, NULL, NULL), MLRT_OK);
    free(results.data);
    free_arrays(&arrays);
    free_fixture(&fixture);
}

static void meshes_and_cameras_need_elements(void **state)
{
    (void)state;
    const float corners[9] = {0, 0, 5, 1, 0, 5, 0, 1, 5};
    const uint32_t indices[3] = {0, 1, 2};
    const float eye[3] = {0, 0, 0}, target[3] = {0, 0, 1};
    const mlrt_camera camera = look_at(eye, target, 1, 1, 1);
    const mlrt_array vectors = {(float[3]){0}, MLRT_STRIDE_ALL, 0};
    mlrt_tree *tree = NULL;
    mlrt_mesh mesh = {.struct_size = sizeof mesh,
                      .vertices = corners,
                      .vertex_count = 3,
                      .vertex_stride = MLRT_STRIDE_ALL,
                      .indices = indices,
                      .triangle_count = 1};
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_ERROR_ARGUMENT);
    assert_string_equal(mlrt_last_message(),
                        "meshes[0].vertices: stride MLRT_STRIDE_ALL is only for arrays of rays and points");
    mesh.vertex_stride = 0;
    mesh.triangle_stride = MLRT_STRIDE_ALL;
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &tree), MLRT_ERROR_ARGUMENT);
    assert_string_equal(mlrt_last_message(),
                        "meshes[0].indices: stride MLRT_STRIDE_ALL is only for arrays of rays and points");
    assert_int_equal(mlrt_camera_rays(&camera, &vectors, NULL), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_camera_rays(&camera, NULL, &vectors), MLRT_ERROR_ARGUMENT);
}

/*
 * Packets whose rays all start at one point a few floats before or behind a triangle: those that start where the first
 * one does, and others between them, all in one bundle.
 */
static void origins_near_a_plane(void **state)
{
    (void)state;
    enum { ORIGIN_COUNT = 12, EACH = 16 };
    const float direction[3] = {1, -1, 3};
    for (uint64_t seed = 1; seed <= scaled(60); seed++) {
        struct random random = {seed};
        struct soup soup = {0};
        float corners[3][3] = {{96, 256, -256}, {98, 259, -257}, {95, 258, -256}}, origins[ORIGIN_COUNT][3];
        const float other = ldexpf(1, (int)draw_below(&random, 7) - 20);
        for (int i = 0; i < 9; i++) corners[i / 3][i % 3] += draw_range(&random, 0, 1) * other;
        soup_add_triangle(&soup, corners[0], corners[1], corners[2]);
        struct fixture fixture = fixture_of_soup("origins near a plane", seed, &soup);
        for (uint32_t i = 0; i < ORIGIN_COUNT; i++) {
            const int steps = i == 0 || draw_below(&random, 2) ? 2 : (int)draw_below(&random, 13) - 6;
            for (int k = 0; k < 3; k++) origins[i][k] = (corners[0][k] + corners[1][k] + corners[2][k]) * (1.0f / 3);
            origins[i][1] = next_float(origins[i][1], steps * (seed % 2 ? 1 : -1));
        }
        mlrt_rays rays = {.struct_size = sizeof rays,
                          .count = (size_t)ORIGIN_COUNT * EACH,
                          .rays_per_origin = EACH,
                          .origins = {origins, 0},
                          .directions = {direction, MLRT_STRIDE_ALL}};
        uint8_t expected[ORIGIN_COUNT * EACH], got[ORIGIN_COUNT * EACH];
        mlrt_hits hits = {.struct_size = sizeof hits, .occluded = {expected, 0, 0}};
        mlrt_trace_options options = {.struct_size = sizeof options, .query = MLRT_QUERY_ANY};
        options.method = MLRT_METHOD_RAY;
        assert_int_equal(mlrt_trace_packet(fixture.tree, &rays, &options, &hits), MLRT_OK);
        hits.occluded.data = got;
        options.method = MLRT_METHOD_TILE;
        for (int32_t isa = MLRT_ISA_SCALAR; isa <= MLRT_ISA_NEON; isa++) {
            options.isa = isa;
            if (!isa_is_supported(isa)) continue;
            assert_int_equal(mlrt_trace_packet(fixture.tree, &rays, &options, &hits), MLRT_OK);
            assert_memory_equal(expected, got, sizeof got);
        }
        free_fixture(&fixture);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_element_for_all_rays),
        cmocka_unit_test(several_rays_of_one_origin),
        cmocka_unit_test(origins_near_a_plane),
        cmocka_unit_test(each_array_alone),
        cmocka_unit_test(points_that_share_elements),
        cmocka_unit_test(groups_must_divide_the_count),
        cmocka_unit_test(shorter_structs_have_rays_of_their_own),
        cmocka_unit_test(results_need_elements),
        cmocka_unit_test(meshes_and_cameras_need_elements),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
