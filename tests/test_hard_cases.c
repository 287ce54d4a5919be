/* SPDX-License-Identifier: MIT */
/*
 * Inputs on which ray tracers of this kind have failed, one test each: shared edges and vertices, grazing rays, rays in
 * split planes, cells without thickness, beams whose corner rays tell nothing, and so on. Whatever the library answers
 * is compared with the reference by every way of tracing; where geometry alone says what must come out, that is checked
 * too.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

/* Compares, and frees both. */
static void finish(struct fixture *fixture, struct ray_list *list)
{
    check_rays(fixture, list);
    free_rays(list);
    free_fixture(fixture);
}

static void finish_quickly(struct fixture *fixture, struct ray_list *list)
{
    check_rays_quickly(fixture, list);
    free_rays(list);
    free_fixture(fixture);
}

/* Every ray must hit something, by each of the fast ways. */
static void assert_all_hit(const struct fixture *fixture, const struct ray_list *list)
{
    uint32_t *triangles = allocate_or_fail(list->count, sizeof *triangles);
    for (size_t v = 0; v < variant_count(); v++) {
        mlrt_rays rays = public_rays(list);
        mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {triangles, 0, 0}};
        if (!variant_at(v)->probe) continue;
        assert_int_equal(mlrt_trace_packet(variant_tree(variant_at(v), fixture), &rays, &variant_at(v)->options, &hits),
                         MLRT_OK);
        for (size_t i = 0; i < list->count; i++) {
            if (triangles[i] != MLRT_NONE) continue;
            const struct reference_ray *ray = &list->rays[i];
            fail_msg("%s: variant %zu: ray %zu leaks: o = (%a, %a, %a), d = (%a, %a, %a)", fixture->name, v, i,
                     (double)ray->origin[0], (double)ray->origin[1], (double)ray->origin[2], (double)ray->direction[0],
                     (double)ray->direction[1], (double)ray->direction[2]);
        }
    }
    free(triangles);
}

/* ---- rays and triangles ------------------------------------------------------------------------------------------ */

static void an_edge_shared_by_two_triangles(void **state)
{
    (void)state;
    struct random random = {1};
    struct soup soup = {0};
    struct ray_list list = {0};
    float p[4][3];
    for (int i = 0; i < 4; i++) draw_point(&random, -1, 1, p[i]);
    soup_add_triangle(&soup, p[0], p[1], p[2]);
    soup_add_triangle(&soup, p[0], p[1], p[3]); // the other winding along the edge
    struct fixture fixture = fixture_of_soup("shared edge", 1, &soup);
    for (size_t i = 0; i < scaled(1000); i++) {
        float origin[3], target[3], t = draw_range(&random, 0, 1);
        draw_point(&random, -3, 3, origin);
        for (int k = 0; k < 3; k++) target[k] = p[0][k] + t * (p[1][k] - p[0][k]);
        add_ray_towards(&list, origin, target);
    }
    finish(&fixture, &list);
}

/*
 * Integer coordinates: the rays pass through the vertex exactly. Closed fans around it, seen from where all is closed.
 */
static void a_vertex_of_a_fan(void **state)
{
    (void)state;
    struct random random = {2};
    for (int blades = 3; blades <= 64; blades = blades * 3 / 2) {
        struct soup soup = {0};
        struct ray_list list = {0};
        const float centre[3] = {0, 0, 0};
        float rim[64][3];
        for (int i = 0; i < blades; i++) {
            double angle = 6.28318530717958647692 * i / blades;
            rim[i][0] = (float)(10 * cos(angle));
            rim[i][1] = (float)(10 * sin(angle));
            rim[i][2] = draw_range(&random, -1, 1);
        }
        for (int i = 0; i < blades; i++) soup_add_triangle(&soup, centre, rim[i], rim[(i + 1) % blades]);
        struct fixture fixture = fixture_of_soup("fan", 2, &soup);
        for (size_t i = 0; i < scaled(100); i++) {
            float origin[3] = {(float)draw_below(&random, 9) - 4, (float)draw_below(&random, 9) - 4, 20};
            add_ray_towards(&list, origin, centre);
        }
        assert_all_hit(&fixture, &list);
        finish_quickly(&fixture, &list);
    }
}

static void outer_corners_of_an_open_mesh(void **state)
{
    (void)state;
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_grid(&soup, 2, 0, 4);
    struct fixture fixture = fixture_of_soup("open grid", 3, &soup);
    for (int x = -1; x <= 9; x++) {
        for (int y = -1; y <= 9; y++) {
            for (int n = -1; n <= 1; n++) {
                const float origin[3] = {next_float(0.5f * (float)x, n), 0.5f * (float)y, 3}, down[3] = {0, 0, -1};
                add_ray(&list, origin, down);
            }
        }
    }
    finish(&fixture, &list);
}

static void needles_that_share_edges(void **state)
{
    (void)state;
    struct random random = {4};
    struct soup soup = {0};
    struct ray_list list = {0};
    // A strip of 100 needles, 1 long and 1e-6 wide.
    for (int i = 0; i < 100; i++) {
        const float a[3] = {0, (float)i * 1e-6f, 0}, b[3] = {1, (float)i * 1e-6f, 0};
        const float c[3] = {0, (float)(i + 1) * 1e-6f, 0}, d[3] = {1, (float)(i + 1) * 1e-6f, 0};
        soup_add_triangle(&soup, a, b, c);
        soup_add_triangle(&soup, b, d, c);
    }
    struct fixture fixture = fixture_of_soup("strip of needles", 4, &soup);
    for (size_t i = 0; i < scaled(750); i++) {
        const float target[3] = {draw_range(&random, 0.01f, 0.99f), draw_range(&random, 1e-6f, 9.9e-5f), 0};
        const float origin[3] = {target[0], target[1], draw_range(&random, 0.5f, 2)};
        add_ray_towards(&list, origin, target);
    }
    assert_all_hit(&fixture, &list);
    add_aimed_rays(&list, &random, &fixture, scaled(250), -1, 1);
    finish(&fixture, &list);
}

/* A hit is never farther away than the triangle is. */
static void grazing_rays_at_skinny_triangles(void **state)
{
    (void)state;
    struct random random = {5};
    const float a[3] = {0, 0, 0}, b[3] = {500, 0.001f, 0}, c[3] = {500, -0.001f, 0.0001f};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_triangle(&soup, a, b, c);
    struct fixture fixture = fixture_of_soup("grazing", 5, &soup);
    for (size_t i = 0; i < scaled(750); i++) {
        const float origin[3] = {-50, 0, draw_range(&random, -0.5f, 0.5f)};
        const float target[3] = {draw_range(&random, 0, 500), draw_range(&random, -0.001f, 0.001f), 0};
        add_ray_towards(&list, origin, target);
        struct reference_hit hit = trace_one(fixture.tree, &list.rays[i], NULL);
        if (hit.mesh == MLRT_NONE) continue;
        double x = (double)origin[0] + (double)hit.t * (double)list.rays[i].direction[0];
        assert_true(x >= -1e-3 && x <= 500 + 1e-3);
    }
    finish(&fixture, &list);
}

static void short_segments_far_before_a_triangle(void **state)
{
    (void)state;
    struct random random = {6};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_random(&soup, &random, 50, 1, 1);
    struct fixture fixture = fixture_of_soup("short segments", 6, &soup);
    add_aimed_rays(&list, &random, &fixture, scaled(500), -1e4f, 1e4f);
    for (size_t i = 0; i < list.count; i++) list.rays[i].t_max = draw_range(&random, 0, 1.001f);
    finish(&fixture, &list);
}

/* Where coordinates are large, N overflows in float, and so does t_min D, though t_min is less than t by far. */
static void ranges_that_begin_far_away(void **state)
{
    (void)state;
    struct random random = {46};
    for (int exponent = 30; exponent <= 59; exponent++) {
        const float size = ldexpf(1, exponent), a[3] = {0, 0, 0}, b[3] = {size, 0, 0}, c[3] = {0, size, 0};
        struct soup soup = {0};
        struct ray_list list = {0};
        soup_add_triangle(&soup, a, b, c);
        struct fixture fixture = fixture_of_soup("far away", (uint64_t)exponent, &soup);
        for (size_t i = 0; i < scaled(64); i++) {
            const float origin[3] = {0.25f * size, 0.25f * size, draw_range(&random, 0.5f, 1) * size};
            const float length = ldexpf(1, -(int)draw_below(&random, 56));
            float direction[3] = {0.1f * length, 0.2f * length, -length};
            struct reference_ray *ray = add_ray(&list, origin, direction);
            ray->t_min = ldexpf(origin[2] / length, -(int)draw_below(&random, 40));
        }
        finish_quickly(&fixture, &list);
    }
}

static void coplanar_rays(void **state)
{
    (void)state;
    struct random random = {7};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_grid(&soup, 2, 1, 6);
    struct fixture fixture = fixture_of_soup("coplanar rays", 7, &soup);
    for (size_t i = 0; i < scaled(300); i++) {
        const float origin[3] = {0.5f * (float)draw_below(&random, 16) - 1, 0.5f * (float)draw_below(&random, 16) - 1,
                                 1};
        const float direction[3] = {draw_range(&random, -1, 1), draw_range(&random, -1, 1), 0};
        add_ray(&list, origin, direction);
        struct reference_hit hit = trace_one(fixture.tree, &list.rays[i], NULL);
        assert_int_equal(hit.mesh, MLRT_NONE);
    }
    finish(&fixture, &list);
}

static void origins_within_an_ulp_of_a_triangle(void **state)
{
    (void)state;
    struct random random = {8};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_random(&soup, &random, 40, 1, 1);
    struct fixture fixture = fixture_of_soup("ulp before and behind", 8, &soup);
    add_surface_rays(&list, &random, &fixture, scaled(500));
    for (size_t i = 0; i < list.count; i++) {
        float *x = &list.rays[i].origin[i % 3];
        *x = next_float(*x, (int)(i / 3 % 3) - 1);
    }
    finish(&fixture, &list);
}

static void t_exactly_at_both_ends(void **state)
{
    (void)state;
    struct soup soup = {0};
    struct ray_list list = {0};
    for (int i = 1; i <= 8; i++) soup_add_grid(&soup, 2, (float)i, 2);
    struct fixture fixture = fixture_of_soup("integer distances", 9, &soup);
    for (int from = 0; from <= 8; from++) {
        for (int to = 0; to <= 9; to++) {
            for (int n = -1; n <= 1; n++) {
                const float origin[3] = {0.75f, 1.25f, 0}, up[3] = {0, 0, 1};
                struct reference_ray *ray = add_ray(&list, origin, up);
                ray->t_min = next_float((float)from, n);
                ray->t_max = next_float((float)to, n);
            }
        }
    }
    finish(&fixture, &list);
}

/*
 * Triangles beyond what float carries make boxes that have no end, so hits may lie behind 2^126, from where on nothing
 * else has any, and behind all floats. Rays begin about there.
 */
static void begins_behind_all_boxes(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 4 + scaled(8); seed++) {
        struct random random = {4600 + seed};
        struct soup soup = {0};
        struct ray_list list = {0};
        const int axis = (int)draw_below(&random, 3);
        const int exponent = 60 + (int)draw_below(&random, 60);
        const float far = ldexpf(draw_range(&random, 0.5f, 1), exponent);
        float corner[3][3] = {{-far, -far, far}, {far, -far, far}, {0, far, far}};
        for (int i = 0; i < 3; i++) {
            const float z = corner[i][2];
            corner[i][2] = corner[i][axis];
            corner[i][axis] = z;
        }
        soup_add_triangle(&soup, corner[0], corner[1], corner[2]);
        soup_add_random(&soup, &random, 30, 1, 0.5f);
        struct fixture fixture = fixture_of_soup("far", seed, &soup);
        for (size_t i = 0; i < scaled(300); i++) {
            float origin[3], direction[3];
            draw_point(&random, -1, 1, origin);
            draw_point(&random, -0.5f, 0.5f, direction);
            direction[axis] = 1;
            /* The distance to the plane is about 2^120 to 2^135. */
            const int e = ilogbf(far) - 120 - (int)draw_below(&random, 16);
            for (int k = 0; k < 3; k++) direction[k] = ldexpf(direction[k], e);
            struct reference_ray *ray = add_ray(&list, origin, direction);
            ray->t_min = FLT_MAX;
            if (draw_below(&random, 4)) {
                const int power = 124 + (int)draw_below(&random, 5);
                ray->t_min = ldexpf(draw_range(&random, 0.9f, 1), power);
            }
            if (draw_below(&random, 3) == 0) ray->t_max = ldexpf(draw_range(&random, 0.5f, 1), 128);
        }
        finish(&fixture, &list);
    }
}

/* A begin whose product with the length of the ray underflows is no begin at 0. */
static void begins_that_underflow(void **state)
{
    (void)state;
    struct soup soup = {0};
    struct ray_list list = {.row_length = 16};
    const float k = 0x1p-120f, a[3] = {-k, 1, -1}, b[3] = {-k, 1, 1}, c[3] = {k, -1, 0};
    const float far_corner[3] = {9, 9, 9}, up[3] = {0, 0.5f, 0}, away[3] = {0, 0, 0.5f};
    soup_add_triangle(&soup, a, b, c);
    soup_add_quad(&soup, far_corner, up, away);
    struct fixture fixture = fixture_of_soup("begins that underflow", 10, &soup);
    const float begins[] = {0x1p-95f, 0x1p-107f, 0};
    for (int i = 0; i < 768; i++) {
        const float origin[3] = {0, -0x1p-46f, 0}, direction[3] = {0x1p-60f, 0, 0};
        add_ray(&list, origin, direction)->t_min = begins[i / 256];
    }
    finish(&fixture, &list);
}

static void coincident_triangles_in_both_windings(void **state)
{
    (void)state;
    struct random random = {10};
    struct soup soup = {0}, copy = {0};
    struct ray_list list = {0};
    soup_add_random(&soup, &random, 30, 1, 0.7f);
    for (size_t i = 0; i < soup.count; i++) {
        const float *c = soup.corners + 9 * i;
        soup_add_triangle(&copy, c + 6, c + 3, c);
        soup_add_triangle(&copy, c, c + 3, c + 6);
        soup_add_triangle(&copy, c + 3, c + 6, c);
    }
    free_soup(&soup);
    struct fixture fixture = fixture_of_soup("coincident", 10, &copy);
    add_mixed_rays(&list, &random, &fixture, scaled(750), -2, 2);
    finish(&fixture, &list);
}

static void parallel_quads_one_float_apart(void **state)
{
    (void)state;
    struct random random = {11};
    struct soup soup = {0};
    struct ray_list list = {0};
    for (int i = 3; i >= -3; i--) soup_add_grid(&soup, 1, next_float(1, i), 3);
    struct fixture fixture = fixture_of_soup("one float apart", 11, &soup);
    add_mixed_rays(&list, &random, &fixture, scaled(750), -1, 4);
    finish(&fixture, &list);
}

static void triangles_without_area_among_others(void **state)
{
    (void)state;
    struct random random = {12};
    struct soup soup = {0};
    struct ray_list list = {0};
    for (int i = 0; i < 60; i++) {
        float p[3][3];
        for (int c = 0; c < 3; c++) draw_point(&random, -1, 1, p[c]);
        if (i % 3 == 0) memcpy(p[2], p[i % 2], sizeof p[2]);
        if (i % 9 == 1) {
            for (int k = 0; k < 3; k++) p[2][k] = -p[1][k], p[0][k] = 0;
        }
        if (i % 9 == 2) p[i % 3][i % 2] = i % 2 ? NAN : INFINITY;
        soup_add_triangle(&soup, p[0], p[1], p[2]);
    }
    struct fixture fixture = fixture_of_soup("without area", 12, &soup);
    for (size_t i = 0; i < scaled(500); i++) {
        float origin[3], target[3] = {0, 0, 0};
        draw_point(&random, -2, 2, origin);
        if (i % 2) draw_point(&random, -1, 1, target);
        add_ray_towards(&list, origin, target);
    }
    finish(&fixture, &list);
}

static void nearly_collinear_vertices(void **state)
{
    (void)state;
    struct random random = {13};
    struct soup soup = {0};
    struct ray_list list = {0};
    for (int i = 0; i < 80; i++) {
        float a[3], side[3], b[3], c[3];
        draw_point(&random, -1, 1, a);
        draw_point(&random, -1, 1, side);
        for (int k = 0; k < 3; k++) {
            b[k] = a[k] + side[k];
            c[k] = a[k] + 0.3f * side[k]; // off the line by a rounding
        }
        soup_add_triangle(&soup, a, b, c);
    }
    struct fixture fixture = fixture_of_soup("nearly collinear", 13, &soup);
    add_mixed_rays(&list, &random, &fixture, scaled(750), -2, 2);
    finish(&fixture, &list);
}

static void large_coordinates_with_small_features(void **state)
{
    (void)state;
    const float offset[3] = {1e6f, 1e6f, -1e6f};
    struct random random = {14};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_random(&soup, &random, 100, 1, 0.2f);
    move_soup(&soup, 1, offset); // 1/16 is the spacing of floats there
    struct fixture fixture = fixture_of_soup("small features", 14, &soup);
    add_mixed_rays(&list, &random, &fixture, scaled(750), 999000, 1001000);
    finish(&fixture, &list);
}

/* ---- closed meshes ----------------------------------------------------------------------------------------------- */

/* From inside towards every vertex, every middle of an edge, axes and diagonals: each must hit. */
static void check_closed(const char *name, struct soup *soup, const float inside[3])
{
    const size_t step = SANITIZED ? 16 : 1;
    struct random random = {20};
    struct ray_list list = {0};
    struct fixture fixture = fixture_of_soup(name, 20, soup);
    size_t count = reference_triangle_count(fixture.reference);
    for (size_t i = 0; i < count; i += step) {
        const struct reference_triangle *triangle = reference_triangle_at(fixture.reference, i);
        for (int c = 0; c < 3; c++) {
            const float *a = triangle->corner[c], *b = triangle->corner[(c + 1) % 3];
            const float middle[3] = {0.5f * a[0] + 0.5f * b[0], 0.5f * a[1] + 0.5f * b[1], 0.5f * a[2] + 0.5f * b[2]};
            add_ray_towards(&list, inside, a);
            add_ray_towards(&list, inside, middle);
        }
    }
    for (int x = -1; x <= 1; x++) {
        for (int y = -1; y <= 1; y++) {
            for (int z = -1; z <= 1; z++) {
                const float direction[3] = {(float)x, (float)y, z ? (float)z : -0.0f};
                if (x || y || z) add_ray(&list, inside, direction);
            }
        }
    }
    for (size_t i = 0; i < scaled(2000); i++) {
        float direction[3];
        draw_point(&random, -1, 1, direction);
        add_ray(&list, inside, direction);
    }
    assert_all_hit(&fixture, &list);
    if (list.count > scaled(1000)) list.count = scaled(1000);
    finish_quickly(&fixture, &list);
}

static void no_leak_from_a_sphere(void **state)
{
    (void)state;
    const float inside[3] = {0.1f, -0.2f, 0.3f};
    struct soup soup = {0};
    soup_add_icosphere(&soup, 5, 1);
    check_closed("sphere", &soup, inside);
}

static void no_leak_from_a_shifted_sphere(void **state)
{
    (void)state;
    static const float shifts[] = {1e3f, 1e5f};
    for (int i = 0; i < 2; i++) {
        const float offset[3] = {shifts[i], shifts[i], -shifts[i]};
        struct soup soup = {0};
        soup_add_icosphere(&soup, 3, 1);
        move_soup(&soup, 1, offset);
        check_closed("shifted sphere", &soup, offset);
    }
}

static void no_leak_from_a_scaled_sphere(void **state)
{
    (void)state;
    static const float scales[] = {1e-36f, 1e-20f, 1e-6f, 1e6f, 1e20f, 1e37f};
    for (size_t i = 0; i < sizeof scales / sizeof scales[0]; i++) {
        const float zero[3] = {0, 0, 0}, inside[3] = {0.1f * scales[i], -0.2f * scales[i], 0.3f * scales[i]};
        struct soup soup = {0};
        soup_add_icosphere(&soup, 3, 1);
        move_soup(&soup, scales[i], zero);
        check_closed("scaled sphere", &soup, inside);
    }
}

static void no_leak_from_a_cube(void **state)
{
    (void)state;
    const float lo[3] = {-1, -1, -1}, hi[3] = {1, 1, 1}, centre[3] = {0, 0, 0}, off[3] = {0.3f, -0.7f, 0.1f};
    struct soup soup = {0};
    soup_add_box(&soup, lo, hi);
    check_closed("cube from its centre", &soup, centre);
    soup_add_box(&soup, lo, hi);
    check_closed("cube", &soup, off);
}

static void no_leak_from_a_torus(void **state)
{
    (void)state;
    const float inside[3] = {1, 0, 0};
    struct soup soup = {0};
    soup_add_torus(&soup, 60, 30, 1, 0.25f);
    check_closed("torus", &soup, inside);
}

/* ---- planes, cells and the tree ---------------------------------------------------------------------------------- */

/* A lattice of quads: split planes are where the quads are. */
static struct fixture lattice(void)
{
    struct soup soup = {0};
    for (int axis = 0; axis < 3; axis++) {
        for (int level = 0; level <= 4; level++) soup_add_grid(&soup, axis, (float)level, 4);
    }
    return fixture_of_soup("lattice", 30, &soup);
}

static void zeros_of_both_signs_are_the_same(void **state)
{
    (void)state;
    struct fixture fixture = lattice();
    struct ray_list list = {0};
    for (int axis = 0; axis < 3; axis++) {
        for (int signs = 0; signs < 8; signs++) {
            for (int place = 0; place < 27; place++) {
                // Inside, on and outside the slabs of the box.
                const float places[3] = {-1, 0, 1.5f};
                const float origin[3] = {places[place % 3], places[place / 3 % 3], places[place / 9]};
                float direction[3];
                for (int k = 0; k < 3; k++) direction[k] = signs >> k & 1 ? -0.0f : 0.0f;
                direction[axis] = signs >> axis & 1 ? -1.0f : 1.0f;
                add_ray(&list, origin, direction);
            }
        }
    }
    finish(&fixture, &list);
}

static void rays_in_split_planes(void **state)
{
    (void)state;
    struct random random = {31};
    struct fixture fixture = lattice();
    struct ray_list list = {0};
    for (size_t i = 0; i < scaled(750); i++) {
        float origin[3], direction[3];
        draw_point(&random, -1, 5, origin);
        draw_point(&random, -1, 1, direction);
        int axis = (int)draw_below(&random, 3);
        origin[axis] = (float)draw_below(&random, 5);
        direction[axis] = draw_below(&random, 2) ? 0.0f : -0.0f;
        add_ray(&list, origin, direction);
    }
    finish(&fixture, &list);
}

static void rays_along_edges_of_cells(void **state)
{
    (void)state;
    struct random random = {32};
    struct fixture fixture = lattice();
    struct ray_list list = {0};
    for (size_t i = 0; i < scaled(500); i++) {
        float origin[3], direction[3] = {0, 0, 0};
        int axis = (int)draw_below(&random, 3);
        for (int k = 0; k < 3; k++) origin[k] = (float)draw_below(&random, 5);
        origin[axis] = draw_range(&random, -2, 5);
        direction[axis] = draw_below(&random, 2) ? 1.0f : -1.0f;
        add_ray(&list, origin, direction);
    }
    finish(&fixture, &list);
}

/* Diagonals from lattice point to lattice point: through the corners of cells. */
static void rays_through_corners_of_cells(void **state)
{
    (void)state;
    struct random random = {33};
    struct fixture fixture = lattice();
    struct ray_list list = {0};
    for (size_t i = 0; i < scaled(750); i++) {
        float origin[3], direction[3];
        for (int k = 0; k < 3; k++) {
            origin[k] = (float)draw_below(&random, 7) - 1;
            direction[k] = (float)draw_below(&random, 5) - 2;
        }
        add_ray(&list, origin, direction);
    }
    finish(&fixture, &list);
}

static void origins_in_split_planes(void **state)
{
    (void)state;
    struct random random = {34};
    struct fixture fixture = lattice();
    struct ray_list list = {0};
    for (size_t i = 0; i < scaled(750); i++) {
        float origin[3], direction[3];
        draw_point(&random, -1, 5, origin);
        draw_point(&random, -1, 1, direction);
        origin[draw_below(&random, 3)] = (float)draw_below(&random, 5);
        add_ray(&list, origin, direction);
    }
    finish(&fixture, &list);
}

static void triangles_in_split_planes_from_both_sides(void **state)
{
    (void)state;
    struct random random = {35};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_grid(&soup, 0, 0, 8);
    soup_add_random(&soup, &random, 100, 3, 0.1f); // something to split for on both sides
    struct fixture fixture = fixture_of_soup("wall in a plane", 35, &soup);
    for (size_t i = 0; i < scaled(750); i++) {
        const float target[3] = {0, draw_range(&random, 0, 8), draw_range(&random, 0, 8)};
        float origin[3] = {i % 2 ? 2.0f : -2.0f, draw_range(&random, 0, 8), draw_range(&random, 0, 8)};
        if (i % 3 == 0) memcpy(origin + 1, target + 1, 8);
        add_ray_towards(&list, origin, target);
    }
    finish(&fixture, &list);
}

static void flat_scenes(void **state)
{
    (void)state;
    for (int axis = 0; axis < 3; axis++) {
        for (int sheets = 1; sheets <= 2; sheets++) {
            struct random random = {36};
            struct soup soup = {0};
            struct ray_list list = {0};
            for (int i = 0; i < sheets; i++) soup_add_grid(&soup, axis, -3, 1 + 5 * i);
            struct fixture fixture = fixture_of_soup("flat", 36, &soup);
            add_mixed_rays(&list, &random, &fixture, scaled(300), -5, 5);
            finish(&fixture, &list);
        }
    }
}

static void two_parallel_quads(void **state)
{
    (void)state;
    for (int axis = 0; axis < 3; axis++) {
        struct random random = {37};
        struct soup soup = {0};
        struct ray_list list = {0};
        soup_add_grid(&soup, axis, 0, 1);
        soup_add_grid(&soup, axis, 1, 1);
        struct fixture fixture = fixture_of_soup("two quads", 37, &soup);
        add_mixed_rays(&list, &random, &fixture, scaled(300), -2, 2);
        finish(&fixture, &list);
    }
}

static void a_single_axis_parallel_triangle(void **state)
{
    (void)state;
    const float a[3] = {0, 0, 0}, b[3] = {1, 0, 0}, c[3] = {0, 1, 0};
    struct random random = {38};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_triangle(&soup, a, b, c);
    struct fixture fixture = fixture_of_soup("one triangle", 38, &soup);
    add_mixed_rays(&list, &random, &fixture, scaled(500), -1, 2);
    finish(&fixture, &list);
}

/* Nothing separates them: the builder must come to an end, and every ray to the first of them. */
static void many_identical_triangles(void **state)
{
    (void)state;
    const float a[3] = {0, 0, 0}, b[3] = {1, 0.5f, 0}, c[3] = {0, 1, 0.25f}, up[3] = {0, 0, 1};
    struct soup soup = {0};
    size_t count = scaled(100000);
    for (size_t i = 0; i < count; i++) soup_add_triangle(&soup, a, b, c);
    mlrt_mesh mesh = soup_mesh(&soup);
    mlrt_tree_info info = {.struct_size = sizeof info};
    struct fixture fixture = {.tree = build_structure(&mesh, 1, MLRT_STRUCTURE_BVH),
                              .kdtree = build_structure(&mesh, 1, MLRT_STRUCTURE_KDTREE)};
    assert_int_equal(mlrt_get_tree_info(fixture.kdtree, &info), MLRT_OK);
    assert_true(info.reference_count <= 8 * count + 1024);
    for (size_t v = 0; v < variant_count(); v++) {
        if (!variant_at(v)->probe) continue;
        struct reference_ray ray = {{0.25f, 0.5f, -3}, {up[0], up[1], up[2]}, 0, INFINITY, {MLRT_NONE, MLRT_NONE}};
        assert_int_equal(trace_one(variant_tree(variant_at(v), &fixture), &ray, &variant_at(v)->options).triangle, 0);
    }
    mlrt_destroy_tree(fixture.tree);
    mlrt_destroy_tree(fixture.kdtree);
    free_soup(&soup);
}

static void one_huge_triangle_over_many_small_ones(void **state)
{
    (void)state;
    const float a[3] = {-1000, -1000, 0.01f}, b[3] = {1000, -900, 0}, c[3] = {0, 1500, -0.01f};
    struct random random = {39};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_random(&soup, &random, 500, 1, 0.05f);
    soup_add_triangle(&soup, a, b, c);
    struct fixture fixture = fixture_of_soup("one huge", 39, &soup);
    add_mixed_rays(&list, &random, &fixture, scaled(750), -2, 2);
    finish(&fixture, &list);
}

/* Vertices at neighbouring floats: split planes as close to the bounds of cells, and to each other, as can be. */
static void planes_at_neighbouring_floats(void **state)
{
    (void)state;
    struct random random = {40};
    struct soup soup = {0};
    struct ray_list list = {0};
    for (int i = 0; i < 120; i++) {
        float p[3][3];
        for (int n = 0; n < 9; n++) p[n / 3][n % 3] = next_float(1, (int)draw_below(&random, 7) - 3);
        soup_add_triangle(&soup, p[0], p[1], p[2]);
    }
    struct fixture fixture = fixture_of_soup("neighbouring floats", 40, &soup);
    add_mixed_rays(&list, &random, &fixture, scaled(750), 0, 2);
    finish(&fixture, &list);
}

/* Triangles that touch the planes of others with a vertex or an edge only. */
static void triangles_that_touch_planes(void **state)
{
    (void)state;
    struct random random = {41};
    struct soup soup = {0};
    struct ray_list list = {0};
    for (int i = 0; i < 200; i++) {
        float p[3][3];
        for (int n = 0; n < 9; n++) p[n / 3][n % 3] = (float)draw_below(&random, 5);
        soup_add_triangle(&soup, p[0], p[1], p[2]);
    }
    struct fixture fixture = fixture_of_soup("small integers", 41, &soup);
    add_mixed_rays(&list, &random, &fixture, scaled(750), -1, 5);
    for (size_t i = 0; i < scaled(300); i++) {
        float origin[3], target[3];
        for (int k = 0; k < 3; k++) {
            origin[k] = (float)draw_below(&random, 9) - 2;
            target[k] = (float)draw_below(&random, 5);
        }
        add_ray_towards(&list, origin, target);
    }
    finish(&fixture, &list);
}

static void origins_everywhere(void **state)
{
    (void)state;
    static const float distances[] = {0, 1, 1e3f, 1e6f, 1e12f};
    struct random random = {42};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_icosphere(&soup, 2, 1);
    struct fixture fixture = fixture_of_soup("origins everywhere", 42, &soup);
    for (size_t d = 0; d < sizeof distances / sizeof distances[0]; d++) {
        for (size_t i = 0; i < scaled(150); i++) {
            float origin[3], target[3];
            draw_point(&random, -1, 1, origin);
            draw_point(&random, -1, 1, target);
            for (int k = 0; k < 3; k++) origin[k] *= distances[d];
            if (i % 4 == 0) origin[i / 4 % 3] = i % 8 ? 1.0f : -1.0f;
            add_ray_towards(&list, origin, target);
        }
    }
    finish(&fixture, &list);
}

/* The hit of a large triangle lies in a farther cell than the one in which it is found first. */
static void the_nearer_hit_in_the_next_cell(void **state)
{
    (void)state;
    struct random random = {43};
    struct soup soup = {0};
    struct ray_list list = {0};
    const float a[3] = {-4, -4, -1}, b[3] = {-4, 4, -1}, c[3] = {8, 0, 5};
    soup_add_triangle(&soup, a, b, c);
    for (int i = 0; i < 200; i++) {
        float p[3][3], centre[3] = {draw_range(&random, 0, 6), draw_range(&random, -1, 1), 0};
        centre[2] = 0.5f * centre[0] + 1 - draw_range(&random, -0.1f, 0.2f);
        for (int n = 0; n < 9; n++) p[n / 3][n % 3] = centre[n % 3] + draw_range(&random, -0.1f, 0.1f);
        soup_add_triangle(&soup, p[0], p[1], p[2]);
    }
    struct fixture fixture = fixture_of_soup("next cell", 43, &soup);
    for (size_t i = 0; i < scaled(750); i++) {
        const float origin[3] = {-3, draw_range(&random, -1, 1), draw_range(&random, -1, 3)};
        const float target[3] = {draw_range(&random, 0, 7), draw_range(&random, -1, 1), draw_range(&random, 1, 4)};
        add_ray_towards(&list, origin, target);
    }
    finish(&fixture, &list);
}

static void the_deepest_trees(void **state)
{
    (void)state;
    struct random random = {44};
    struct soup soup = {0};
    struct ray_list list = {0};
    // Sizes that halve again and again towards one corner.
    for (int i = 0; i < 120; i++) {
        float p[3][3], size = ldexpf(1, -i);
        for (int n = 0; n < 9; n++) p[n / 3][n % 3] = size * draw_range(&random, 0.5f, 1);
        soup_add_triangle(&soup, p[0], p[1], p[2]);
    }
    mlrt_mesh mesh = soup_mesh(&soup);
    mlrt_kdtree_options options = {.struct_size = sizeof options,
                                   .preset = MLRT_KDTREE_PAPER,
                                   .rules_off = MLRT_RULE_MINIMUM_CELL | MLRT_RULE_RETRACTION,
                                   .max_depth = 60,
                                   .traversal_cost = 1e-3f,
                                   .intersection_cost = 1e3f};
    struct fixture fixture = make_fixture_with("deep", 44, &mesh, 1, &options);
    free_soup(&soup);
    add_mixed_rays(&list, &random, &fixture, scaled(400), -1, 1);
    for (int i = 0; i < 120; i++) {
        float origin[3] = {2, 2, 2}, target[3];
        draw_point(&random, 0.5f, 1, target);
        for (int k = 0; k < 3; k++) target[k] = ldexpf(target[k], -i), origin[k] = target[k] * (i % 2 ? 3.0f : -1.0f);
        add_ray_towards(&list, origin, target);
    }
    finish(&fixture, &list);
}

/* ---- beams ------------------------------------------------------------------------------------------------------- */

static void check_view(struct fixture *fixture, const float eye[3], const float target[3], float field, uint32_t size)
{
    mlrt_camera camera = look_at(eye, target, field, size, size);
    check_camera(fixture, &camera);
}

/* The corner rays of the tile all miss what pokes into it from a side, and what stands in its middle. */
static void corner_rays_that_see_nothing(void **state)
{
    (void)state;
    const float eye[3] = {0, -10, 0}, target[3] = {0, 0, 0};
    const float a[3] = {-20, 0, 0.1f}, b[3] = {0.5f, 0.1f, 0}, c[3] = {-20, 0, -0.1f};
    struct random random = {50};
    struct soup soup = {0};
    soup_add_triangle(&soup, a, b, c);
    soup_add_random(&soup, &random, 30, 0.2f, 0.05f);
    struct fixture fixture = fixture_of_soup("poking in", 50, &soup);
    check_view(&fixture, eye, target, 0.4f, 64);
    free_fixture(&fixture);
}

/* The tile contains the lines where a component of the direction is 0; one pixel is exactly an axis. */
static void tiles_around_axes(void **state)
{
    (void)state;
    struct random random = {51};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 300, 4, 0.7f);
    struct fixture fixture = fixture_of_soup("around axes", 51, &soup);
    for (int axis = 0; axis < 3; axis++) {
        for (int shift = 0; shift < 3; shift++) {
            mlrt_camera camera = {.struct_size = sizeof camera, .width = 32, .height = 32};
            camera.d00[axis] = shift == 1 ? -1.0f : 1.0f;
            camera.d00[(axis + 1) % 3] = shift == 2 ? 0.0f : -1.0f;
            camera.d00[(axis + 2) % 3] = -1;
            camera.dx[(axis + 1) % 3] = 0.0625f;
            camera.dy[(axis + 2) % 3] = 0.0625f;
            check_camera(&fixture, &camera);
        }
    }
    free_fixture(&fixture);
}

/* Triangles far smaller than a pixel, some of them hit exactly by one ray of the tile. */
static void triangles_smaller_than_a_pixel(void **state)
{
    (void)state;
    struct random random = {52};
    struct soup soup = {0};
    mlrt_camera camera = {.struct_size = sizeof camera,
                          .width = 64,
                          .height = 64,
                          .d00 = {-1, -1, 1},
                          .dx = {0.03125f, 0, 0},
                          .dy = {0, 0.03125f, 0}};
    for (int i = 0; i < 150; i++) {
        float p[3][3], at[3] = {-8, -8, 8};
        at[0] += 0.25f * (float)draw_below(&random, 64);
        at[1] += 0.25f * (float)draw_below(&random, 64);
        for (int n = 0; n < 9; n++) p[n / 3][n % 3] = at[n % 3] + draw_range(&random, -1e-4f, 1e-4f);
        if (i % 2) memcpy(p[i % 3], at, sizeof at); // the ray goes through the vertex
        soup_add_triangle(&soup, p[0], p[1], p[2]);
    }
    struct fixture fixture = fixture_of_soup("smaller than a pixel", 52, &soup);
    check_camera(&fixture, &camera);
    free_fixture(&fixture);
}

/* Triangles that cover a tile but for its last pixel, by a float more or less. */
static void triangles_that_nearly_cover_a_tile(void **state)
{
    (void)state;
    for (int n = -2; n <= 2; n++) {
        struct soup soup = {0};
        mlrt_camera camera = {.struct_size = sizeof camera,
                              .width = 64,
                              .height = 64,
                              .d00 = {-1, -1, 1},
                              .dx = {0.03125f, 0, 0},
                              .dy = {0, 0.03125f, 0}};
        const float edge = next_float(0.96875f, n); // the last column and row at distance 1
        const float a[3] = {-9, -9, 1}, b[3] = {edge, -9, 1}, c[3] = {edge, edge, 1}, d[3] = {-9, edge, 1};
        soup_add_triangle(&soup, a, b, c);
        soup_add_triangle(&soup, a, c, d);
        const float far_a[3] = {-90, -90, 5}, far_b[3] = {90, -90, 5}, far_c[3] = {0, 180, 5};
        soup_add_triangle(&soup, far_a, far_b, far_c);
        struct fixture fixture = fixture_of_soup("nearly covered", (uint64_t)(n + 2), &soup);
        check_camera(&fixture, &camera);
        free_fixture(&fixture);
    }
}

/* Large triangles that intersect inside a tile. */
static void covering_triangles_that_intersect(void **state)
{
    (void)state;
    const float eye[3] = {0, 0, -5}, target[3] = {0.1f, 0.05f, 0};
    struct random random = {54};
    struct soup soup = {0};
    for (int i = 0; i < 6; i++) {
        float p[3][3] = {{-30, -30, 0}, {30, -30, 0}, {0, 40, 0}};
        for (int c = 0; c < 3; c++) p[c][2] = draw_range(&random, -3, 3);
        soup_add_triangle(&soup, p[0], p[1], p[2]);
    }
    soup_add_random(&soup, &random, 100, 1, 0.3f);
    struct fixture fixture = fixture_of_soup("intersecting", 54, &soup);
    check_view(&fixture, eye, target, 1, 64);
    free_fixture(&fixture);
}

static void eyes_in_planes_of_triangles_and_at_vertices(void **state)
{
    (void)state;
    struct fixture fixture = lattice();
    const float eyes[][3] = {{2, 2, 2}, {2, 1.5f, 1.5f}, {2, 2, 1.5f}, {0, 0, 0}, {4, 2.5f, 4}, {2, -3, 2}};
    for (size_t i = 0; i < sizeof eyes / sizeof eyes[0]; i++) {
        const float target[3] = {2.6f, 3.1f, 1.7f};
        check_view(&fixture, eyes[i], target, 1.5f, 40);
    }
    free_fixture(&fixture);
}

/* Rays in any order, any grouping: what one ray gets is its own. */
static void permuted_rays(void **state)
{
    (void)state;
    struct random random = {56};
    struct fixture fixture = lattice();
    struct ray_list list = {0}, permuted = {0};
    add_mixed_rays(&list, &random, &fixture, scaled(400), -1, 5);
    for (size_t i = 0; i < list.count; i++) {
        const struct reference_ray *ray = &list.rays[(i * 7919) % list.count];
        *add_ray(&permuted, ray->origin, ray->direction) = *ray;
    }
    check_rays(&fixture, &list);
    check_rays(&fixture, &permuted);
    free_rays(&list);
    finish(&fixture, &permuted);
}

/* Many small things in sight of every tile: more than any list or stack of fixed size should hold. */
static void more_subtrees_than_any_list_holds(void **state)
{
    (void)state;
    const float eye[3] = {0, -6, 0}, target[3] = {0, 0, 0};
    struct random random = {57};
    struct soup soup = {0};
    soup_add_random(&soup, &random, scaled(8000), 2, 0.01f);
    struct fixture fixture = fixture_of_soup("dust", 57, &soup);
    mlrt_camera camera = look_at(eye, target, 1, 64, 64);
    check_camera_quickly(&fixture, &camera);
    free_fixture(&fixture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_edge_shared_by_two_triangles),
        cmocka_unit_test(a_vertex_of_a_fan),
        cmocka_unit_test(outer_corners_of_an_open_mesh),
        cmocka_unit_test(needles_that_share_edges),
        cmocka_unit_test(grazing_rays_at_skinny_triangles),
        cmocka_unit_test(short_segments_far_before_a_triangle),
        cmocka_unit_test(ranges_that_begin_far_away),
        cmocka_unit_test(coplanar_rays),
        cmocka_unit_test(origins_within_an_ulp_of_a_triangle),
        cmocka_unit_test(t_exactly_at_both_ends),
        cmocka_unit_test(begins_that_underflow),
        cmocka_unit_test(begins_behind_all_boxes),
        cmocka_unit_test(coincident_triangles_in_both_windings),
        cmocka_unit_test(parallel_quads_one_float_apart),
        cmocka_unit_test(triangles_without_area_among_others),
        cmocka_unit_test(nearly_collinear_vertices),
        cmocka_unit_test(large_coordinates_with_small_features),
        cmocka_unit_test(no_leak_from_a_sphere),
        cmocka_unit_test(no_leak_from_a_shifted_sphere),
        cmocka_unit_test(no_leak_from_a_scaled_sphere),
        cmocka_unit_test(no_leak_from_a_cube),
        cmocka_unit_test(no_leak_from_a_torus),
        cmocka_unit_test(zeros_of_both_signs_are_the_same),
        cmocka_unit_test(rays_in_split_planes),
        cmocka_unit_test(rays_along_edges_of_cells),
        cmocka_unit_test(rays_through_corners_of_cells),
        cmocka_unit_test(origins_in_split_planes),
        cmocka_unit_test(triangles_in_split_planes_from_both_sides),
        cmocka_unit_test(flat_scenes),
        cmocka_unit_test(two_parallel_quads),
        cmocka_unit_test(a_single_axis_parallel_triangle),
        cmocka_unit_test(many_identical_triangles),
        cmocka_unit_test(one_huge_triangle_over_many_small_ones),
        cmocka_unit_test(planes_at_neighbouring_floats),
        cmocka_unit_test(triangles_that_touch_planes),
        cmocka_unit_test(origins_everywhere),
        cmocka_unit_test(the_nearer_hit_in_the_next_cell),
        cmocka_unit_test(the_deepest_trees),
        cmocka_unit_test(corner_rays_that_see_nothing),
        cmocka_unit_test(tiles_around_axes),
        cmocka_unit_test(triangles_smaller_than_a_pixel),
        cmocka_unit_test(triangles_that_nearly_cover_a_tile),
        cmocka_unit_test(covering_triangles_that_intersect),
        cmocka_unit_test(eyes_in_planes_of_triangles_and_at_vertices),
        cmocka_unit_test(permuted_rays),
        cmocka_unit_test(more_subtrees_than_any_list_holds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
