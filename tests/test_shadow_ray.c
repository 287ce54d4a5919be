/* SPDX-License-Identifier: MIT */
/*
 * mlrt_shadow_ray: its promises, in exact arithmetic. The end of the ray lies strictly on the side that the picture's
 * ray came from, and next to the hit; the light counts exactly if it is on that side; what lies in the plane, or behind
 * it, shades nothing.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "hard_scenes.h"
#include "hostile_rays.h"
#include "support.h"

/* ---- one ray ----------------------------------------------------------------------------------------------------- */

/* What is known of a hit and a light. */
struct question {
    const struct fixture *fixture;
    const struct reference_triangle *triangle;
    struct reference_ray ray;
    struct reference_hit hit;
    mlrt_light light;
};

static size_t faced, unfaced, ordinary;

static void fail_question(const struct question *question, const char *what, const mlrt_ray *shadow)
{
    const struct reference_ray *ray = &question->ray;
    const float *l = question->light.position;
    print_error("%s, seed %llu: %s\n  o = (%a, %a, %a), d = (%a, %a, %a)\n", question->fixture->name,
                (unsigned long long)question->fixture->seed, what, (double)ray->origin[0], (double)ray->origin[1],
                (double)ray->origin[2], (double)ray->direction[0], (double)ray->direction[1],
                (double)ray->direction[2]);
    for (int i = 0; i < 3; i++) {
        const float *p = question->triangle->corner[i];
        print_error("  corner (%a, %a, %a)\n", (double)p[0], (double)p[1], (double)p[2]);
    }
    print_error("  light %s (%a, %a, %a)\n", question->light.kind == MLRT_LIGHT_POINT ? "at" : "from", (double)l[0],
                (double)l[1], (double)l[2]);
    print_error("  shadow ray: o = (%a, %a, %a), d = (%a, %a, %a)\n", (double)shadow->origin[0],
                (double)shadow->origin[1], (double)shadow->origin[2], (double)shadow->direction[0],
                (double)shadow->direction[1], (double)shadow->direction[2]);
    fail();
}

static double greatest_of(const double v[3])
{
    return fmax(fmax(fabs(v[0]), fabs(v[1])), fabs(v[2]));
}

static double size_of(const double v[3])
{
    return fabs(v[0]) + fabs(v[1]) + fabs(v[2]);
}

static double dot_of(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The numbers of the rule in double: the normal's greatest component is 1. */
struct numbers {
    double normal[3], to_plane[3], direction[3];
    double roundness; /* of the normal before that, relative to the edges */
    double steepness; /* d . normal */
    double size;  /* greatest coordinate relative to the eye and the light, or 1/32 of the triangle's from the eye */
    double scale; /* all that coordinates are about */
};

static struct numbers work_out(const struct question *question)
{
    struct numbers n = {.scale = 0};
    const int is_point = question->light.kind == MLRT_LIGHT_POINT;
    double ab[3], ac[3], on_ray[3], from_light[3];
    for (int k = 0; k < 3; k++) {
        ab[k] = (double)question->triangle->corner[1][k] - (double)question->triangle->corner[0][k];
        ac[k] = (double)question->triangle->corner[2][k] - (double)question->triangle->corner[0][k];
        n.to_plane[k] = (double)question->triangle->corner[0][k] - (double)question->ray.origin[k];
        n.direction[k] = (double)question->ray.direction[k];
    }
    for (int k = 0; k < 3; k++) n.normal[k] = ab[(k + 1) % 3] * ac[(k + 2) % 3] - ab[(k + 2) % 3] * ac[(k + 1) % 3];
    const double greatest = greatest_of(n.normal);
    n.roundness = greatest / (size_of(ab) * size_of(ac));
    for (int k = 0; k < 3; k++) n.normal[k] /= greatest;
    n.steepness = dot_of(n.direction, n.normal);
    const double t = dot_of(n.to_plane, n.normal) / n.steepness;
    for (int k = 0; k < 3; k++) {
        const double origin = (double)question->ray.origin[k];
        on_ray[k] = t * n.direction[k];
        from_light[k] = origin + on_ray[k] - (is_point ? (double)question->light.position[k] : 0);
        n.scale = fmax(n.scale, fmax(fabs(origin), fabs((double)question->triangle->corner[0][k])));
        if (is_point) n.scale = fmax(n.scale, fabs((double)question->light.position[k]));
    }
    n.size = fmax(fmax(greatest_of(on_ray), greatest_of(from_light)), greatest_of(n.to_plane) / 32);
    n.scale += size_of(ab) + size_of(ac) + greatest_of(on_ray);
    return n;
}

/*
 * hits/shadow_ray.h: the step of 2^-22 size, rounding to float, the error of t, which moves the point along the ray.
 * The bounds of "ordinary" are a little more than there, so that roundings here do not matter.
 */
static void check_place(const struct question *question, const mlrt_ray *shadow)
{
    const struct numbers n = work_out(question);
    const int is_point = question->light.kind == MLRT_LIGHT_POINT;
    const float zero[3] = {0, 0, 0}, *by = is_point ? shadow->direction : shadow->origin;
    double distance[3];
    reference_distance_to_hit(question->triangle, &question->ray, is_point ? shadow->origin : zero, by, distance);
    const double e = greatest_of(n.direction), p = greatest_of(n.to_plane), size = n.size;
    const double t = fabs(dot_of(n.to_plane, n.normal) / n.steepness);
    double height[3], to_light[3];
    for (int k = 0; k < 3; k++) {
        const double l = (double)question->light.position[k];
        to_light[k] = is_point ? (double)question->triangle->corner[0][k] - l : l;
    }
    const int is_ordinary = n.roundness > 0x1.01p-16 && fabs(n.steepness) > 0x1.01p-14 * size_of(n.direction) &&
                            fabs(dot_of(to_light, n.normal)) > 0x1.01p-32 * size_of(to_light) && size > 0x1.01p-100 &&
                            size < 0x1p100;
    if (is_ordinary) {
        ordinary++;
        const double along = 3.2 * 0x1p-34 * (p + t * e) * e / fabs(n.steepness);
        for (int k = 0; k < 3; k++) {
            const double bound = 1.001 * (0x1p-22 * size + 0x1p-24 * fabs((double)by[k]) + along);
            if (!(fabs(distance[k]) <= bound)) fail_question(question, "not next to the hit", shadow);
            height[k] = distance[k] * n.normal[k];
        }
        // What is left of the step after all that it is for, and what it may become.
        const double off = fabs(height[0] + height[1] + height[2]);
        if (!(off > 0.8 * 0x1p-24 * size && off < 7.2 * 0x1p-24 * size * size_of(n.normal)))
            fail_question(question, "not as far off as it should be", shadow);
    } else if (n.roundness > 0x1p-16 && n.scale > 0x1p-120) { // by rounded u and v, and some floats along the normal
        double bound = 0x1p-48 * n.scale;
        for (int k = 0; k < 3; k++) {
            const double a = (double)question->triangle->corner[0][k];
            bound += 0x1p-20 * (fabs((double)question->hit.u * ((double)question->triangle->corner[1][k] - a)) +
                                fabs((double)question->hit.v * ((double)question->triangle->corner[2][k] - a)) +
                                fabs((double)by[k]));
        }
        if (!(greatest_of(distance) <= bound)) fail_question(question, "far from the hit", shadow);
    }
}

/* All that is promised for a ray that hits the triangle. */
static void check_question(const struct question *question)
{
    const struct reference_triangle *triangle = question->triangle;
    const struct reference_ray *given = &question->ray;
    const mlrt_light *light = &question->light;
    mlrt_ray ray = {.struct_size = sizeof ray, .t_min = given->t_min, .t_max = given->t_max}, shadow;
    const mlrt_hit hit = {.struct_size = sizeof hit, .mesh = triangle->mesh, .triangle = triangle->triangle};
    const float zero[3] = {0, 0, 0};
    int32_t faces = 77;
    memcpy(ray.origin, given->origin, sizeof ray.origin);
    memcpy(ray.direction, given->direction, sizeof ray.direction);
    memset(&shadow, 0xA5, sizeof shadow);
    shadow.struct_size = sizeof shadow;
    const int32_t status = mlrt_shadow_ray(question->fixture->tree, &ray, &hit, light, &shadow, &faces);
    if (status != MLRT_OK) fail_question(question, mlrt_status_string(status), &shadow);
    const int is_point = light->kind == MLRT_LIGHT_POINT;
    const int side = -reference_facing(triangle, given->direction);
    const int light_side =
        is_point ? reference_side(triangle, light->position) : reference_facing(triangle, light->position);
    // Where no float leads from the light to the hit, it counts as one on the other side.
    const int is_beyond_float = !(work_out(question).size < 0x1.fffffp127);
    if (faces != (light_side == side) && !(is_beyond_float && !faces))
        fail_question(question, "wrong side of the light", &shadow);
    if (shadow.struct_size != sizeof shadow || shadow.flags != MLRT_RAY_SKIP || shadow.skip_mesh != triangle->mesh ||
        shadow.skip_triangle != triangle->triangle || shadow.t_min != 0)
        fail_question(question, "wrong skip or range", &shadow);
    if (!faces) {
        unfaced++;
        if (memcmp(shadow.direction, zero, sizeof zero) != 0) fail_question(question, "a ray for no light", &shadow);
        return;
    }
    faced++;
    if (is_point && shadow.direction[0] == 0 && shadow.direction[1] == 0 && shadow.direction[2] == 0) {
        // The light is where the end of the ray would be.
        memcpy(shadow.origin, light->position, sizeof shadow.origin);
        check_place(question, &shadow);
        return;
    }
    if (shadow.t_max != (is_point ? 1.0f : 0.0f)) fail_question(question, "wrong t_max", &shadow);
    for (int k = 0; k < 3; k++) {
        if ((is_point ? shadow.origin : shadow.direction)[k] != light->position[k])
            fail_question(question, "not the light", &shadow);
    }
    const int end_side = is_point ? reference_side_of_sum(triangle, shadow.origin, shadow.direction)
                                  : reference_side(triangle, shadow.origin);
    if (end_side != side) fail_question(question, "the end is on the wrong side", &shadow);
    check_place(question, &shadow);
    mlrt_hit found = {.struct_size = sizeof found}, again = {.struct_size = sizeof again};
    const mlrt_trace_options any = {.struct_size = sizeof any, .query = MLRT_QUERY_ANY};
    assert_int_equal(mlrt_trace_ray(question->fixture->tree, &shadow, &any, &found), MLRT_OK);
    shadow.flags = 0;
    assert_int_equal(mlrt_trace_ray(question->fixture->tree, &shadow, &any, &again), MLRT_OK);
    if (found.occluded != again.occluded) fail_question(question, "the triangle shades itself", &shadow);
}

/* The first hit of a ray and a light, if there is one. Not every ray is valid. */
static void ask(const struct fixture *fixture, const struct reference_ray *ray, const mlrt_light *light)
{
    struct question question = {.fixture = fixture, .ray = *ray, .light = *light};
    struct reference_hit hit;
    if (ray->t_max == 0) return; // a single ray cannot say this
    reference_trace(fixture->reference, ray, &hit);
    if (hit.mesh == MLRT_NONE) return;
    question.hit = hit;
    question.triangle = reference_find(fixture->reference, hit.mesh, hit.triangle);
    check_question(&question);
}

/* Asks about rays of all kinds, and checks that there was something to check. */
static void ask_about(const struct fixture *fixture, struct random *random, size_t count, float extent,
                      const mlrt_light *lights, size_t light_count, size_t least)
{
    struct ray_list list = {0};
    faced = unfaced = ordinary = 0;
    add_aimed_rays(&list, random, fixture, count / 2, -extent, extent);
    add_mixed_rays(&list, random, fixture, count / 2, -extent, extent);
    for (size_t i = 0; i < list.count; i++) ask(fixture, &list.rays[i], &lights[i % light_count]);
    for (size_t i = 0; i < list.count; i++) {
        const mlrt_light light = draw_hostile_light(random, fixture);
        ask(fixture, &list.rays[i], &light);
    }
    assert_true(faced >= scaled(least));
    assert_true(unfaced >= scaled(least / 4));
    free_rays(&list);
}

/* ---- ordinary scenes --------------------------------------------------------------------------------------------- */

static void random_triangles(void **state)
{
    (void)state;
    struct random random = {1};
    struct soup soup = {0};
    const mlrt_light lights[] = {light_at(1, 2, 3), light_at(-0.5f, 0.1f, 0.2f), light_from(1, 2, 3),
                                 light_from(-1, 0, 0), light_at(1e6f, -1e5f, 3e6f)};
    soup_add_random(&soup, &random, 100, 1, 0.5f);
    struct fixture fixture = fixture_of_soup("random triangles", 1, &soup);
    ask_about(&fixture, &random, scaled(2400), 3, lights, 5, 1000);
    assert_true(ordinary >= scaled(1000));
    free_fixture(&fixture);
}

static void planes_across_axes(void **state)
{
    (void)state;
    struct random random = {2};
    struct soup soup = {0};
    const mlrt_light lights[] = {light_at(1, 1, 1), light_at(0, 0, 7), light_from(0, 0, 1), light_from(-1, -0.0f, 0),
                                 light_at(2, 2, 5)};
    for (int axis = 0; axis < 3; axis++) {
        soup_add_grid(&soup, axis, 0, 3);
        soup_add_grid(&soup, axis, 5, 3);
    }
    struct fixture fixture = fixture_of_soup("grids", 2, &soup);
    ask_about(&fixture, &random, scaled(1200), 4, lights, 5, 400);
    assert_true(ordinary >= scaled(400));
    free_fixture(&fixture);
}

static void triangles_far_from_the_origin(void **state)
{
    (void)state;
    struct random random = {3};
    const float offset[3] = {1e6f, -1e6f, 1e6f};
    const mlrt_light lights[] = {light_at(1e6f, -1e6f, 1e6f + 99), light_from(1, 2, 3), light_at(0, 0, 0)};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_icosphere(&soup, 1, 50);
    move_soup(&soup, 1, offset);
    struct fixture fixture = fixture_of_soup("far away", 3, &soup);
    faced = ordinary = 0;
    for (size_t i = 0; i < scaled(800); i++) {
        float origin[3], target[3];
        draw_point(&random, -90, 90, origin);
        draw_point(&random, -30, 30, target);
        for (int k = 0; k < 3; k++) {
            origin[k] += offset[k];
            target[k] += offset[k];
        }
        ask(&fixture, add_ray_towards(&list, origin, target), &lights[i % 3]);
    }
    assert_true(faced >= scaled(300) && ordinary >= scaled(300));
    free_rays(&list);
    free_fixture(&fixture);
}

/* ---- hostile ones ------------------------------------------------------------------------------------------------ */

static void slivers(void **state)
{
    (void)state;
    static const float aspects[] = {1e3f, 1e5f, 1e6f, 1e7f};
    const mlrt_light lights[] = {light_at(1, 2, 3), light_from(1, -2, 0.5f), light_at(0, 0.1f, 0)};
    for (uint64_t i = 0; i < 4; i++) {
        struct random random = {10 + i};
        struct soup soup = {0};
        soup_add_needles(&soup, &random, 50, aspects[i]);
        struct fixture fixture = fixture_of_soup("needles", 10 + i, &soup);
        ask_about(&fixture, &random, scaled(1000), 2, lights, 3, 100);
        free_fixture(&fixture);
    }
}

/* Rays and lights that nearly lie in the plane of what they hit. */
static void grazing_rays_and_lights(void **state)
{
    (void)state;
    struct random random = {20};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 40, 2, 1.5f);
    soup_add_grid(&soup, 0, 0.25f, 1);
    soup_add_grid(&soup, 2, 0, 1);
    struct fixture fixture = fixture_of_soup("grazing", 20, &soup);
    faced = unfaced = 0;
    for (size_t i = 0; i < scaled(4000); i++) {
        struct ray_list list = {0};
        const uint32_t number = draw_below(&random, (uint32_t)reference_triangle_count(fixture.reference));
        const struct reference_triangle *triangle = reference_triangle_at(fixture.reference, number);
        const double height = pow(10, -1 - 7 * (double)draw_range(&random, 0, 1));
        float eye[3], target[3], light[3];
        for (int k = 0; k < 3; k++) {
            const double a = (double)triangle->corner[0][k], ab = (double)triangle->corner[1][k] - a;
            const double ac = (double)triangle->corner[2][k] - a;
            target[k] = (float)(a + 0.3 * ab + 0.3 * ac);
            eye[k] = (float)(a - 2 * ab + 1.5 * ac + height * (double)draw_range(&random, -1, 1));
            light[k] = (float)(a + 3 * ab - 1 * ac + height * (double)draw_range(&random, -1, 1));
        }
        mlrt_light lights[2] = {light_at(light[0], light[1], light[2]), light_from(1, 0, 0)};
        reference_difference(light, target, lights[1].position);
        ask(&fixture, add_ray_towards(&list, eye, target), &lights[i % 2]);
        free_rays(&list);
    }
    assert_true(faced >= scaled(500) && unfaced >= scaled(500));
    free_fixture(&fixture);
}

/* Lights exactly in the plane, on vertices, at the eye: on no side, or in the way of nothing. */
static void lights_in_planes_on_vertices_and_at_eyes(void **state)
{
    (void)state;
    struct random random = {30};
    struct soup soup = {0};
    struct ray_list list = {0};
    const float lo[3] = {-1, -1, -1}, hi[3] = {1, 1, 1};
    soup_add_box(&soup, lo, hi);
    soup_add_random(&soup, &random, 20, 1, 0.5f);
    struct fixture fixture = fixture_of_soup("lights in planes", 30, &soup);
    add_aimed_rays(&list, &random, &fixture, scaled(600), -3, 3);
    faced = unfaced = 0;
    for (size_t i = 0; i < list.count; i++) {
        const struct reference_ray *ray = &list.rays[i];
        const float *o = ray->origin;
        struct reference_hit hit;
        reference_trace(fixture.reference, ray, &hit);
        if (hit.mesh == MLRT_NONE) continue;
        const struct reference_triangle *triangle = reference_find(fixture.reference, hit.mesh, hit.triangle);
        const float *a = triangle->corner[0], *b = triangle->corner[1];
        const mlrt_light at_vertex = light_at(a[0], a[1], a[2]), at_eye = light_at(o[0], o[1], o[2]);
        const mlrt_light at_other = light_at(b[0] + b[0] - a[0], b[1] + b[1] - a[1], b[2] + b[2] - a[2]);
        const size_t before = unfaced;
        ask(&fixture, ray, &at_vertex);
        assert_int_equal(unfaced, before + 1);
        ask(&fixture, ray, &at_other);
        const size_t faced_before = faced;
        ask(&fixture, ray, &at_eye);
        assert_int_equal(faced, faced_before + 1);
        mlrt_light along = light_from(0, 0, 0); // no side at all
        ask(&fixture, ray, &along);
        reference_difference(triangle->corner[1], triangle->corner[2], along.position);
        ask(&fixture, ray, &along);
        for (int k = 0; k < 3; k++) along.position[k] = -ray->direction[k];
        ask(&fixture, ray, &along);
        mlrt_light close = at_vertex;
        for (int k = 0; k < 3; k++) {
            close.position[k] = (float)((double)o[k] + (double)hit.t * (double)ray->direction[k]);
            close.position[k] = next_float(close.position[k], (int)draw_below(&random, 5) - 2);
        }
        ask(&fixture, ray, &close); // next to the hit itself, on either side
    }
    assert_true(faced >= scaled(600) && unfaced >= scaled(600));
    free_rays(&list);
    free_fixture(&fixture);
}

/* `soup` without the triangles that are never hit, all times 2^exponent. */
static struct fixture scaled_fixture(uint64_t seed, int exponent)
{
    struct random random = {seed};
    struct soup soup = {0};
    const float zero[3] = {0, 0, 0};
    soup_add_random(&soup, &random, 60, 20, 10);
    move_soup(&soup, (float)ldexp(1, exponent), zero);
    return fixture_of_soup("scaled", seed, &soup);
}

static void triangles_of_every_scale(void **state)
{
    (void)state;
    static const int exponents[] = {-145, -140, -126, -115, -103, -99, -60, 60, 94, 97, 101, 110, 120};
    for (uint64_t i = 0; i < sizeof exponents / sizeof exponents[0]; i++) {
        struct random random = {50 + i};
        const float scale = (float)ldexp(1, exponents[i]);
        struct fixture fixture = scaled_fixture(40 + i, exponents[i]);
        const mlrt_light lights[] = {light_at(40 * scale, 30 * scale, 20 * scale), light_from(1, 2, 3),
                                     light_at(3 * scale, -2 * scale, scale), light_at(1, 2, 3),
                                     light_from(scale, -scale, 2 * scale)};
        ask_about(&fixture, &random, scaled(400), 40 * scale, lights, 5, 60);
        free_fixture(&fixture);
    }
}

/* Asks about a triangle that is alone, a ray towards a point of it, and a light. */
static void ask_about_one(const char *name, uint64_t seed, float corner[3][3], const float eye[3],
                          const float target[3], const mlrt_light *light)
{
    const mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = corner, .vertex_count = 3, .triangle_count = 1};
    struct fixture fixture = {.name = name, .seed = seed};
    struct reference_triangle triangle = {.mesh = 0, .triangle = 0};
    struct ray_list list = {0};
    memcpy(triangle.corner, corner, sizeof triangle.corner);
    fixture.reference = reference_create(&triangle, 1);
    assert_int_equal(mlrt_build_tree(&mesh, 1, NULL, &fixture.tree), MLRT_OK);
    ask(&fixture, add_ray_towards(&list, eye, target), light);
    free_rays(&list);
    free_fixture(&fixture);
}

/* The eye, the triangle and the light are of very different sizes. */
static void scales_that_do_not_mix(void **state)
{
    (void)state;
    static const int exponents[] = {-149, -130, -100, -70, -30, 0, 30, 70, 100, 120};
    struct random random = {70};
    faced = 0;
    for (size_t i = 0; i < scaled(3000); i++) {
        float p[5][3], target[3];
        for (int n = 0; n < 5; n++) {
            const float scale = (float)ldexp(1, exponents[draw_below(&random, 10)]);
            draw_point(&random, -1, 1, p[n]);
            for (int k = 0; k < 3; k++) p[n][k] *= n < 3 && i % 4 ? 1 : scale;
        }
        const mlrt_light light = {
            .struct_size = sizeof light, .kind = (int32_t)(i % 2), .position = {p[4][0], p[4][1], p[4][2]}};
        for (int k = 0; k < 3; k++) target[k] = (float)(((double)p[0][k] + (double)p[1][k] + (double)p[2][k]) / 3);
        ask_about_one("scales that do not mix", i, p, p[3], target, &light);
    }
    assert_true(faced >= scaled(500));
}

/*
 * One corner is far away, the others are near each other and near 0: coordinates relative to the far one have too many
 * digits for products in double, and the triangle is so thin that these are all that is left of its normal. Eyes are
 * near, and some of them nearly in the plane.
 */
static void thin_triangles_with_a_far_corner(void **state)
{
    (void)state;
    struct random random = {80};
    faced = unfaced = 0;
    for (size_t i = 0; i < scaled(6000); i++) {
        float p[3][3], along[3], across[3], off[3], eye[3], target[3], light[3];
        const double far = ldexp(1, (int)draw_below(&random, 9) + 2), near = (double)draw_range(&random, 0.05f, 0.5f);
        const double thin = ldexp(1, -(int)draw_below(&random, 34)), w = near * (double)draw_range(&random, 0, 1);
        const double distance = ldexp(1, -(int)draw_below(&random, 8)), flat = ldexp(1, -(int)draw_below(&random, 30));
        draw_point(&random, -0.2f, 0.2f, p[1]);
        draw_point(&random, -1, 1, along);
        draw_point(&random, -1, 1, across);
        draw_point(&random, -1, 1, off);
        draw_point(&random, -1, 1, light);
        for (int k = 0; k < 3; k++) {
            const double b = (double)p[1][k], e = (double)along[k], f = (double)across[k];
            p[0][k] = (float)(b + far * e);
            p[2][k] = (float)(b - near * e + thin * f);
            const double c = (double)p[2][k], middle = b + w / near * (c - b) * 0.9;
            target[k] = (float)(middle + 0x1p-13 * ((double)p[0][k] - middle));
            eye[k] = (float)((double)target[k] + distance * (0.7 * e - 0.6 * f + flat * (double)off[k]));
            light[k] = (float)((double)target[k] + (i % 3 ? (double)light[k] : f - 0.4 * e + flat * (double)off[k]));
        }
        mlrt_light lights[2] = {light_at(light[0], light[1], light[2]), light_from(1, 0, 0)};
        reference_difference(light, target, lights[1].position);
        float corner[3][3];
        for (int n = 0; n < 3; n++) memcpy(corner[n], p[((size_t)n + i / 2) % 3], sizeof corner[n]);
        ask_about_one("thin, with a far corner", i, corner, eye, target, &lights[i % 2]);
    }
    assert_true(faced >= scaled(400) && unfaced >= scaled(400));
}

/*
 * Rays that rise from the plane of the triangle by as little as floats allow. All coordinates are whole numbers or
 * halves, and n_z is 1: as sides (1, 0) and (0, 1) of a square, to which one another is added over and over, span an
 * area of 1. So the direction, which is a sum of sides and (0, 0, 1) or (0, 0, -1), has d . n = 1 or -1, though the
 * three products in it are of the order of 2^60. In double, its sign is one of rounding errors.
 */
static void rays_that_nearly_lie_in_the_plane(void **state)
{
    (void)state;
    struct random random = {90};
    faced = unfaced = 0;
    for (size_t i = 0; i < scaled(400); i++) {
        int32_t side[2][3] = {{1, 0, 0}, {0, 1, 0}};
        float corner[3][3] = {{0}}, eye[3], target[3], light[3];
        do {
            const uint32_t n = draw_below(&random, 2);
            for (int k = 0; k < 2; k++) side[n][k] += side[1 - n][k];
        } while (side[0][0] + side[0][1] < 1 << 19 || side[1][0] + side[1][1] < 1 << 19);
        for (int n = 0; n < 2; n++) side[n][2] = (int32_t)draw_below(&random, 1 << 20) - (1 << 19);
        const int32_t first = (int32_t)draw_below(&random, 3) + 1, second = (int32_t)draw_below(&random, 3) + 1;
        draw_point(&random, -0x1p20f, 0x1p20f, light);
        for (int k = 0; k < 3; k++) {
            const int32_t rise = k < 2 ? 0 : i % 2 ? 1 : -1;
            corner[1][k] = (float)side[0][k];
            corner[2][k] = (float)side[1][k];
            target[k] = i % 3 ? (float)(side[0][k] + side[1][k]) / 2 : 0; // on an edge, or a corner
            eye[k] = target[k] - (float)(first * side[0][k] + second * side[1][k] + rise);
        }
        mlrt_light lights[2] = {light_at(light[0], light[1], light[2]), light_from(light[0], light[1], light[2])};
        ask_about_one("nearly in the plane", i, corner, eye, target, &lights[i / 2 % 2]);
    }
    assert_true(faced >= scaled(100) && unfaced >= scaled(100));
}

static void hostile_rays_in_hard_scenes(void **state)
{
    (void)state;
    faced = unfaced = 0;
    for (size_t i = 0; i < hard_scene_count(); i++) {
        struct random random = {100 + i};
        struct ray_list list = {0};
        struct fixture fixture = make_hard_scene(i);
        for (size_t kind = 0; kind < hostile_kind_count(); kind++)
            add_hostile_rays(&list, &random, &fixture, kind, scaled(16));
        for (size_t j = 0; j < list.count; j += 7) {
            const mlrt_light light = draw_hostile_light(&random, &fixture);
            ask(&fixture, &list.rays[j], &light);
        }
        free_rays(&list);
        free_fixture(&fixture);
    }
    assert_true(faced >= scaled(800) && unfaced >= scaled(500));
}

/* ---- what shades, and what does not ------------------------------------------------------------------------------ */

/* All triangles lie in the plane, or behind it: whoever faces the light is lit. */
static void planes_do_not_shade_themselves(void **state)
{
    (void)state;
    for (uint64_t seed = 200; seed < 200 + scaled(40); seed++) {
        struct random random = {seed};
        struct soup soup = {0};
        float p[3][3], side[3], other_side[3];
        for (int i = 0; i < 3; i++) draw_point(&random, -2, 2, p[i]);
        if (seed % 3 == 0) p[1][2] = p[2][2] = p[0][2];
        for (int k = 0; k < 3; k++) { // on a grid, so that sums are exact and all of it is in one plane
            for (int i = 0; i < 3; i++) p[i][k] = (float)(floor((double)p[i][k] * 4096) / 4096);
            side[k] = p[1][k] - p[0][k];
            other_side[k] = p[2][k] - p[0][k];
        }
        for (int i = 0; i < 3; i++) {
            soup_add_triangle(&soup, p[0], p[1], p[2]);
            soup_add_quad(&soup, p[0], side, other_side);
        }
        struct fixture fixture = fixture_of_soup("one plane", seed, &soup);
        for (int i = 0; i < 100; i++) {
            struct ray_list list = {0};
            float eye[3], target[3], light[3];
            const float u = draw_range(&random, 0, 1), v = draw_range(&random, 0, 1 - u);
            draw_point(&random, -4, 4, eye);
            draw_point(&random, -4, 4, light);
            for (int k = 0; k < 3; k++) target[k] = p[0][k] + u * side[k] + v * other_side[k];
            struct reference_ray *ray = add_ray_towards(&list, eye, target);
            const struct reference_hit found = trace_one(fixture.tree, ray, NULL);
            const mlrt_light lights[2] = {light_at(light[0], light[1], light[2]),
                                          light_from(light[0], light[1], light[2])};
            mlrt_ray given = {.struct_size = sizeof given}, shadow = {.struct_size = sizeof shadow};
            mlrt_hit hit = {.struct_size = sizeof hit, .mesh = found.mesh, .triangle = found.triangle};
            int32_t faces = 0;
            memcpy(given.origin, ray->origin, sizeof given.origin);
            memcpy(given.direction, ray->direction, sizeof given.direction);
            if (found.mesh != MLRT_NONE)
                assert_int_equal(mlrt_shadow_ray(fixture.tree, &given, &hit, &lights[i % 2], &shadow, &faces), MLRT_OK);
            shadow.flags = 0;
            if (faces) assert_int_equal(mlrt_trace_ray(fixture.tree, &shadow, NULL, &hit), MLRT_OK);
            if (faces) assert_int_equal(hit.occluded, 0);
            free_rays(&list);
        }
        free_fixture(&fixture);
    }
}

/* The ray's length, and the sign of zeros, are no matter of the light's. */
static void faces_does_not_depend_on_lengths(void **state)
{
    (void)state;
    static const float lengths[] = {1e-44f, 1e-38f, 1e-20f, 1, 1e20f, 1e38f};
    struct random random = {300};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_random(&soup, &random, 60, 1, 0.5f);
    struct fixture fixture = fixture_of_soup("lengths", 300, &soup);
    add_aimed_rays(&list, &random, &fixture, scaled(200), -3, 3);
    for (size_t i = 0; i < list.count; i++) {
        for (int j = 0; j < 6; j++) {
            struct reference_ray ray = list.rays[i];
            const mlrt_light light = light_from(lengths[j], -2 * lengths[j], 0.5f * lengths[5 - j]);
            for (int k = 0; k < 3; k++) ray.direction[k] *= lengths[5 - j] * 0.25f;
            ask(&fixture, &ray, &light);
        }
    }
    free_rays(&list);
    free_fixture(&fixture);
}

/* Whether the picture's ray hits from in front or from behind, and how the triangle is wound, the point is the same. */
static void windings_do_not_matter(void **state)
{
    (void)state;
    const float a[3] = {-1, -1, 2}, b[3] = {3, -1, 2.5f}, c[3] = {-1, 3, 1.5f};
    struct soup soups[2] = {{0}, {0}};
    soup_add_triangle(&soups[0], a, b, c);
    soup_add_triangle(&soups[1], a, c, b);
    struct fixture fixtures[2] = {fixture_of_soup("one way", 310, &soups[0]),
                                  fixture_of_soup("the other", 311, &soups[1])};
    const mlrt_ray ray = {.struct_size = sizeof ray, .direction = {0.1f, 0.2f, 1}};
    const mlrt_hit hit = {.struct_size = sizeof hit};
    const mlrt_light lights[3] = {light_at(1, 1, -1), light_at(1, 1, 7), light_from(0, 1, -1)};
    for (int i = 0; i < 3; i++) {
        mlrt_ray shadows[2] = {{.struct_size = sizeof(mlrt_ray)}, {.struct_size = sizeof(mlrt_ray)}};
        int32_t faces[2];
        for (int j = 0; j < 2; j++)
            assert_int_equal(mlrt_shadow_ray(fixtures[j].tree, &ray, &hit, &lights[i], &shadows[j], &faces[j]),
                             MLRT_OK);
        assert_int_equal(faces[0], i != 1);
        assert_int_equal(faces[1], faces[0]);
        assert_memory_equal(&shadows[0], &shadows[1], sizeof shadows[0]);
    }
    free_fixture(&fixtures[0]);
    free_fixture(&fixtures[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_triangles),
        cmocka_unit_test(planes_across_axes),
        cmocka_unit_test(triangles_far_from_the_origin),
        cmocka_unit_test(slivers),
        cmocka_unit_test(grazing_rays_and_lights),
        cmocka_unit_test(lights_in_planes_on_vertices_and_at_eyes),
        cmocka_unit_test(triangles_of_every_scale),
        cmocka_unit_test(scales_that_do_not_mix),
        cmocka_unit_test(thin_triangles_with_a_far_corner),
        cmocka_unit_test(rays_that_nearly_lie_in_the_plane),
        cmocka_unit_test(hostile_rays_in_hard_scenes),
        cmocka_unit_test(planes_do_not_shade_themselves),
        cmocka_unit_test(faces_does_not_depend_on_lengths),
        cmocka_unit_test(windings_do_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
