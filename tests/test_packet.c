/* SPDX-License-Identifier: MIT */
/*
 * mlrt_trace_packet: every way of tracing against the reference, and the layouts of rays and results.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support.h"

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

static void check_mixed(struct fixture *fixture, size_t count, float lo, float hi)
{
    struct random random = {fixture->seed + 1000};
    struct ray_list list = {0};
    add_mixed_rays(&list, &random, fixture, scaled(count), lo, hi);
    check_rays(fixture, &list);
    free_rays(&list);
    free_fixture(fixture);
}

static void check_soup(const char *name, uint64_t seed, struct soup *soup, float lo, float hi)
{
    struct fixture fixture = fixture_of_soup(name, seed, soup);
    check_mixed(&fixture, 450, lo, hi);
}

static void random_soup(uint64_t seed, size_t count, float size)
{
    struct random random = {seed};
    struct soup soup = {0};
    soup_add_random(&soup, &random, count, 1, size);
    check_soup("random triangles", seed, &soup, -2, 2);
}

static void small_triangles(void **state)
{
    (void)state;
    random_soup(1, 2000, 0.03f);
}

static void medium_triangles(void **state)
{
    (void)state;
    random_soup(2, 500, 0.2f);
}

static void large_triangles(void **state)
{
    (void)state;
    random_soup(3, 60, 3);
}

static void few_triangles(void **state)
{
    (void)state;
    for (uint64_t count = 1; count <= 5; count++) random_soup(10 + count, (size_t)count, 1);
}

static void needles_of_aspect_100(void **state)
{
    (void)state;
    struct random random = {4};
    struct soup soup = {0};
    soup_add_needles(&soup, &random, 80, 1e2f);
    check_soup("needles 1e2", 4, &soup, -2, 2);
}

static void needles_of_aspect_1e6(void **state)
{
    (void)state;
    struct random random = {5};
    struct soup soup = {0};
    soup_add_needles(&soup, &random, 80, 1e6f);
    check_soup("needles 1e6", 5, &soup, -2, 2);
}

static void coplanar_grids_on_each_axis(void **state)
{
    (void)state;
    for (int axis = 0; axis < 3; axis++) {
        struct soup soup = {0};
        soup_add_grid(&soup, axis, 0, 8);
        soup_add_grid(&soup, axis, 4, 8);
        soup_add_grid(&soup, axis, 4, 8);
        check_soup("coplanar grids", (uint64_t)axis, &soup, -2, 10);
    }
}

static void a_lattice_of_grids(void **state)
{
    (void)state;
    struct soup soup = {0};
    for (int axis = 0; axis < 3; axis++) {
        for (int level = 0; level <= 6; level += 2) soup_add_grid(&soup, axis, (float)level, 6);
    }
    check_soup("lattice", 6, &soup, -1, 7);
}

static void boxes_that_share_faces(void **state)
{
    (void)state;
    struct soup soup = {0};
    for (int i = 0; i < 27; i++) {
        float lo[3] = {(float)(i % 3), (float)(i / 3 % 3), (float)(i / 9)};
        float hi[3] = {lo[0] + 1, lo[1] + 1, lo[2] + 1};
        soup_add_box(&soup, lo, hi);
    }
    check_soup("boxes", 7, &soup, -1, 4);
}

static void a_sphere(void **state)
{
    (void)state;
    struct soup soup = {0};
    soup_add_icosphere(&soup, 3, 1);
    check_soup("icosphere", 8, &soup, -1, 1);
}

static void a_torus(void **state)
{
    (void)state;
    struct soup soup = {0};
    soup_add_torus(&soup, 40, 20, 1, 0.25f);
    check_soup("torus", 9, &soup, -1.5f, 1.5f);
}

static void equal_triangles(void **state)
{
    (void)state;
    const float a[3] = {0, 0, 0}, b[3] = {1, 0.25f, 0}, c[3] = {0.25f, 1, 0.5f};
    struct soup soup = {0};
    for (int i = 0; i < 50; i++) soup_add_triangle(&soup, i % 3 ? a : b, i % 3 ? b : a, c);
    check_soup("equal triangles", 10, &soup, -1, 2);
}

static void triangles_around_one_point(void **state)
{
    (void)state;
    const float centre[3] = {0.25f, 0.5f, 0.125f};
    struct random random = {12};
    struct soup soup = {0};
    for (int i = 0; i < 100; i++) {
        float a[3], b[3];
        draw_point(&random, -1, 1, a);
        draw_point(&random, -1, 1, b);
        soup_add_triangle(&soup, centre, a, b);
    }
    check_soup("around one point", 12, &soup, -1, 1);
}

static void the_room(void **state)
{
    (void)state;
    struct fixture fixture = fixture_of_example("room");
    check_mixed(&fixture, 300, 0, 4);
}

static void draw_whole_point(struct random *random, uint32_t greatest, float point[3])
{
    for (int k = 0; k < 3; k++) point[k] = (float)draw_below(random, 2 * greatest + 1) - (float)greatest;
}

/* Triangles whose corners are whole numbers, most of them across an axis: flat[i], or 3. */
enum { WHOLE_TRIANGLES = 300, LANE_RAYS = (SANITIZED ? 64 : 512) * 256 };

static void draw_whole_triangles(struct random *random, float (*corner)[3][3], uint32_t *flat)
{
    for (int i = 0; i < WHOLE_TRIANGLES; i++) {
        float middle[3];
        flat[i] = draw_below(random, 4);
        draw_whole_point(random, 30, middle);
        for (int j = 0; j < 3; j++) {
            draw_whole_point(random, 2, corner[i][j]);
            for (int k = 0; k < 3; k++) corner[i][j][k] += middle[k];
            if (flat[i] < 3) corner[i][j][flat[i]] = corner[i][0][flat[i]];
        }
    }
}

static struct fixture fixture_of_corners(const char *name, uint64_t seed, float (*corner)[3][3])
{
    struct soup soup = {0};
    for (int i = 0; i < WHOLE_TRIANGLES; i++) soup_add_triangle(&soup, corner[i][0], corner[i][1], corner[i][2]);
    return fixture_of_soup(name, seed, &soup);
}

/* Where the ray of a lane lies if packets are 4x4 rays of rows of 16. */
static size_t ray_of_lane(size_t packet, size_t lane)
{
    return packet / 4 * 64 + packet % 4 * 4 + lane / 4 * 16 + lane % 4;
}

/* The first of eight tiles has random rays, so that the others go lane by lane. */
static int has_random_rays(size_t packet)
{
    return packet / 16 % 8 == 0;
}

/* Compares LANE_RAYS rays as tiles with the same rays one by one. */
static void check_lanes_of_tiles(const mlrt_tree *tree, const mlrt_rays *rays)
{
    static uint32_t expected[LANE_RAYS], found[LANE_RAYS];
    mlrt_trace_options options = {.struct_size = sizeof options, .method = MLRT_METHOD_RAY};
    mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {expected, 0, 0}};
    assert_int_equal(mlrt_trace_packet(tree, rays, &options, &hits), MLRT_OK);
    hits.triangle.data = found;
    options.method = MLRT_METHOD_TILE;
    for (options.isa = MLRT_ISA_SCALAR; options.isa <= MLRT_ISA_NEON; options.isa++) {
        if (!isa_is_supported(options.isa)) continue;
        assert_int_equal(mlrt_trace_packet(tree, rays, &options, &hits), MLRT_OK);
        assert_memory_equal(found, expected, sizeof expected);
    }
}

/*
 * Packets of one ray each, through a corner or the middle of an edge: what bounds all lanes bounds nothing but this
 * ray, and must not be rounded past it.
 */
static void packets_of_one_ray(void **state)
{
    (void)state;
    static float origins[LANE_RAYS][3], directions[LANE_RAYS][3], corner[WHOLE_TRIANGLES][3][3];
    static uint32_t flat[WHOLE_TRIANGLES];
    const mlrt_rays rays = {.struct_size = sizeof rays,
                            .row_length = 16,
                            .count = LANE_RAYS,
                            .origins = {origins, 0},
                            .directions = {directions, 0}};
    for (uint64_t seed = 0; seed < 2 + scaled(2); seed++) {
        struct random random = {160 + seed};
        draw_whole_triangles(&random, corner, flat);
        struct fixture fixture = fixture_of_corners("whole numbers", seed, corner);
        for (size_t packet = 0; packet < LANE_RAYS / 16; packet++) {
            float(*const of)[3] = corner[draw_below(&random, WHOLE_TRIANGLES)];
            const uint32_t j = draw_below(&random, 3), other = draw_below(&random, 2) ? j : (j + 1) % 3;
            float origin[3];
            draw_whole_point(&random, 30, origin);
            for (size_t lane = 0; lane < 16; lane++) {
                const size_t i = ray_of_lane(packet, lane);
                if (has_random_rays(packet)) {
                    draw_point(&random, -30, 30, origins[i]);
                    draw_point(&random, -1, 1, directions[i]);
                    continue;
                }
                for (int k = 0; k < 3; k++) {
                    origins[i][k] = origin[k];
                    directions[i][k] = 0.5f * (of[j][k] + of[other][k]) - origin[k];
                }
            }
        }
        check_lanes_of_tiles(fixture.tree, &rays);
        free_fixture(&fixture);
    }
}

/* One coordinate of a ray that ends behind a plane, by less than the roundings of where it ends. */
struct short_end {
    float origin;
    float direction;
    float t_max;
};

/*
 * Draws a ray from far away that reaches a plane although origin + t_max * direction, in float, lies before it. This
 * needs a plane that is nearly 2^-7 beside a whole number: products are rounded to multiples of 2^-6.
 */
static struct short_end draw_short_end(struct random *random, float plane)
{
    for (;;) {
        const float side = draw_below(random, 2) ? 1 : -1;
        struct short_end ray = {side * draw_range(random, 0x1p17f, 0x1.1p17f), -side * draw_range(random, 0.5f, 2), 0};
        ray.t_max = (plane - ray.origin) / ray.direction;
        const volatile float way = ray.t_max * ray.direction, end = ray.origin + way;
        const double exact = ray.origin + (double)ray.t_max * ray.direction;
        if ((exact - plane) * side <= 0 && (end - plane) * side > 0) return ray;
    }
}

/*
 * Packets of one ray each but for one lane, which goes the other way along one axis: so the rays are bounded there by
 * where they end. Computed with roundings, they end before the triangle that they hit, by a share of a float.
 */
static void packets_that_end_at_a_triangle(void **state)
{
    (void)state;
    static float origins[LANE_RAYS][3], directions[LANE_RAYS][3], t_max[LANE_RAYS], corner[WHOLE_TRIANGLES][3][3];
    static uint32_t flat[WHOLE_TRIANGLES];
    const mlrt_rays rays = {.struct_size = sizeof rays,
                            .row_length = 16,
                            .count = LANE_RAYS,
                            .origins = {origins, 0},
                            .directions = {directions, 0},
                            .t_max = {t_max, 0}};
    for (uint64_t seed = 0; seed < 1 + scaled(1); seed++) {
        struct random random = {170 + seed};
        draw_whole_triangles(&random, corner, flat);
        for (int i = 0; i < WHOLE_TRIANGLES; i++) {
            const float moved = draw_below(&random, 2) ? 0x1.ep-8f : -0x1.ep-8f;
            for (int j = 0; j < 3 && flat[i] < 3; j++) corner[i][j][flat[i]] += moved;
        }
        struct fixture fixture = fixture_of_corners("moved whole numbers", seed, corner);
        for (size_t packet = 0; packet < LANE_RAYS / 16; packet++) {
            uint32_t triangle = draw_below(&random, WHOLE_TRIANGLES);
            while (flat[triangle] == 3) triangle = draw_below(&random, WHOLE_TRIANGLES);
            float(*const of)[3] = corner[triangle], origin[3], direction[3];
            const uint32_t axis = flat[triangle];
            const struct short_end along = draw_short_end(&random, of[0][axis]);
            draw_whole_point(&random, 30, origin);
            for (int k = 0; k < 3; k++) {
                direction[k] = ((of[0][k] + of[1][k] + of[2][k]) / 3 - origin[k]) / along.t_max;
            }
            origin[axis] = along.origin;
            direction[axis] = along.direction;
            for (size_t lane = 0; lane < 16; lane++) {
                const size_t i = ray_of_lane(packet, lane);
                t_max[i] = has_random_rays(packet) ? 100 : along.t_max;
                for (int k = 0; k < 3; k++) origins[i][k] = origin[k], directions[i][k] = direction[k];
                if (lane == packet % 16) directions[i][axis] *= -1;
                if (!has_random_rays(packet)) continue;
                draw_point(&random, -30, 30, origins[i]);
                draw_point(&random, -1, 1, directions[i]);
            }
        }
        check_lanes_of_tiles(fixture.tree, &rays);
        free_fixture(&fixture);
    }
}

/*
 * Tiles of parallel rays that begin before walls, by less than float tells apart at their waist, which is in the middle
 * of a deep scene. Walls lie closer together than that as well. A hit must not end a ray before a nearer wall.
 */
static void walls_close_to_origins(void **state)
{
    (void)state;
    enum { WALLS = 1000 };
    static float origins[LANE_RAYS][3], directions[LANE_RAYS][3];
    const float level = 1.5f * 0x1p-14f, step = 0x1p-20f; /* depths at the waist are multiples of 2^-14 */
    const mlrt_rays rays = {.struct_size = sizeof rays,
                            .row_length = 16,
                            .count = LANE_RAYS,
                            .origins = {origins, 0},
                            .directions = {directions, 0}};
    for (uint64_t seed = 0; seed < 1 + scaled(1); seed++) {
        struct random random = {180 + seed};
        struct soup soup = {0};
        soup_add_triangle(&soup, (float[]){0, 0, 1200}, (float[]){1, 0, 1200}, (float[]){0, 1, 1200});
        for (int i = 0; i < WALLS; i++) {
            const float z = level + step * (float)(1 + draw_below(&random, 8)), size = draw_range(&random, 0.0625f, 2);
            float corner[3][3], middle[3];
            draw_point(&random, 0, 16, middle);
            for (int j = 0; j < 3; j++) {
                draw_point(&random, -size, size, corner[j]);
                for (int k = 0; k < 2; k++) corner[j][k] += middle[k];
                corner[j][2] = z;
            }
            soup_add_triangle(&soup, corner[0], corner[1], corner[2]);
        }
        struct fixture fixture = fixture_of_soup("walls", seed, &soup);
        for (size_t tile = 0; tile < LANE_RAYS / 256; tile++) {
            const float apart = draw_range(&random, 0.0625f, 0.5f);
            const float z = level - step * (float)(1 + draw_below(&random, 8));
            float corner[3], direction[3];
            draw_point(&random, 0, 16 - 8 * apart, corner);
            draw_point(&random, -0.25f, 0.25f, direction);
            for (size_t i = 256 * tile; i < 256 * tile + 256; i++) {
                for (int k = 0; k < 2; k++) {
                    origins[i][k] = corner[k] + apart * (float)(k ? i / 16 % 16 : i % 16);
                    directions[i][k] = direction[k];
                }
                origins[i][2] = z;
                directions[i][2] = 1;
            }
        }
        check_lanes_of_tiles(fixture.tree, &rays);
        free_fixture(&fixture);
    }
}

/* Rays that are not alike are slow in a large scene: a few of them, and a picture. */
static void the_office(void **state)
{
    (void)state;
    enum { SIDE = SANITIZED ? 12 : 32 };
    const float eye[3] = {0, 1.5f, 0}, target[3] = {1, 1, 1};
    struct random random = {15};
    struct ray_list list = {0};
    struct fixture fixture = fixture_of_example("office");
    mlrt_camera camera = look_at(eye, target, 1.3f, SIDE, SIDE);
    add_mixed_rays(&list, &random, &fixture, scaled(100), -2, 3);
    add_camera_rays(&list, &camera);
    list.row_length = 0;
    check_rays_quickly(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

static void the_scan(void **state)
{
    (void)state;
    struct fixture fixture = fixture_of_example("scan:20000");
    check_mixed(&fixture, 200, -1, 1);
}

static void every_preset_and_rule(void **state)
{
    (void)state;
    for (uint32_t off = 0; off < 64; off += 3) {
        struct random random = {off};
        struct soup soup = {0};
        struct ray_list list = {0};
        soup_add_random(&soup, &random, 60, 1, 0.25f);
        soup_add_grid(&soup, 1, 0.5f, 3);
        soup_add_grid(&soup, 2, 0, 3);
        mlrt_mesh mesh = soup_mesh(&soup);
        mlrt_kdtree_options options = {.struct_size = sizeof options, .rules_off = off & 31};
        options.preset = off & 32 ? MLRT_KDTREE_PAPER : MLRT_KDTREE_TUNED;
        struct fixture fixture = make_fixture_with("rules", off, &mesh, 1, &options);
        add_mixed_rays(&list, &random, &fixture, scaled(200), -1, 3);
        check_rays_quickly(&fixture, &list);
        free_rays(&list);
        free_fixture(&fixture);
        free_soup(&soup);
    }
}

static void every_depth_limit(void **state)
{
    (void)state;
    for (uint32_t depth = 1; depth <= 60; depth = depth < 6 ? depth + 1 : depth * 3 / 2) {
        struct random random = {depth};
        struct soup soup = {0};
        struct ray_list list = {0};
        soup_add_random(&soup, &random, 200, 1, 0.1f);
        mlrt_mesh mesh = soup_mesh(&soup);
        mlrt_kdtree_options options = {.struct_size = sizeof options,
                                       .max_depth = depth,
                                       .preset = MLRT_KDTREE_PAPER,
                                       .traversal_cost = 0.01f,
                                       .intersection_cost = 100};
        struct fixture fixture = make_fixture_with("depth", depth, &mesh, 1, &options);
        add_mixed_rays(&list, &random, &fixture, scaled(200), -2, 2);
        check_rays_quickly(&fixture, &list);
        free_rays(&list);
        free_fixture(&fixture);
        free_soup(&soup);
    }
}

/* ---- numbers ----------------------------------------------------------------------------------------------------- */

static void check_scaled(float scale, uint64_t seed)
{
    const float zero[3] = {0, 0, 0};
    struct random random = {seed};
    struct soup soup = {0};
    soup_add_random(&soup, &random, 100, 1, 0.3f);
    soup_add_icosphere(&soup, 1, 0.5f);
    move_soup(&soup, scale, zero);
    struct fixture fixture = fixture_of_soup("scaled", seed, &soup);
    check_mixed(&fixture, 300, -2 * scale, 2 * scale);
}

static void tiny_scales(void **state)
{
    (void)state;
    static const float scales[] = {1e-44f, 1e-41f, 1e-38f, 1e-30f, 1e-20f, 1e-18f};
    for (uint64_t i = 0; i < sizeof scales / sizeof scales[0]; i++) check_scaled(scales[i], 100 + i);
}

static void huge_scales(void **state)
{
    (void)state;
    static const float scales[] = {1e18f, 1e20f, 1e30f, 1e37f, 1e38f};
    for (uint64_t i = 0; i < sizeof scales / sizeof scales[0]; i++) check_scaled(scales[i], 200 + i);
}

static void mixed_scales(void **state)
{
    (void)state;
    static const float scales[] = {1e-38f, 1e-20f, 1e-3f, 1, 1e5f, 1e20f, 1e37f};
    struct random random = {300};
    struct soup soup = {0};
    struct ray_list list = {0};
    for (size_t i = 0; i < sizeof scales / sizeof scales[0]; i++)
        soup_add_random(&soup, &random, 30, scales[i], scales[i] * 0.4f);
    struct fixture fixture = fixture_of_soup("mixed scales", 300, &soup);
    for (size_t i = 0; i < sizeof scales / sizeof scales[0]; i++)
        add_mixed_rays(&list, &random, &fixture, scaled(60), -2 * scales[i], 2 * scales[i]);
    check_rays(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

static void far_from_the_origin(void **state)
{
    (void)state;
    static const float offsets[] = {1e3f, 1e5f, 1e7f, 1e9f};
    for (uint64_t i = 0; i < sizeof offsets / sizeof offsets[0]; i++) {
        const float offset[3] = {offsets[i], -offsets[i], offsets[i] * 0.5f};
        struct random random = {400 + i};
        struct soup soup = {0};
        struct ray_list list = {0};
        soup_add_icosphere(&soup, 2, offsets[i] * 1e-6f < 1 ? 1 : offsets[i] * 1e-6f);
        move_soup(&soup, 1, offset);
        struct fixture fixture = fixture_of_soup("far away", 400 + i, &soup);
        add_aimed_rays(&list, &random, &fixture, scaled(150), -offsets[i], offsets[i]);
        add_axis_rays(&list, &random, &fixture, scaled(150));
        add_surface_rays(&list, &random, &fixture, scaled(150));
        check_rays(&fixture, &list);
        free_rays(&list);
        free_fixture(&fixture);
    }
}

static void arbitrary_bits(void **state)
{
    (void)state;
    struct random random = {500};
    struct soup soup = {0};
    struct ray_list list = {0};
    for (int i = 0; i < 60; i++) {
        float p[3][3];
        for (int k = 0; k < 9; k++) p[k / 3][k % 3] = draw_finite(&random);
        soup_add_triangle(&soup, p[0], p[1], p[2]);
    }
    struct fixture fixture = fixture_of_soup("arbitrary bits", 500, &soup);
    for (size_t i = 0; i < scaled(80); i++) {
        float p[2][3];
        for (int k = 0; k < 6; k++) p[k / 3][k % 3] = draw_finite(&random);
        add_ray(&list, p[0], p[1]);
    }
    add_aimed_rays(&list, &random, &fixture, scaled(80), -1e38f, 1e38f);
    add_aimed_rays(&list, &random, &fixture, scaled(80), -1, 1);
    check_rays(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

/* The largest coordinates there are, where differences no longer fit into float. */
static void the_largest_floats(void **state)
{
    (void)state;
    const float m = float_of_bits(0x7F7FFFFF);
    const float lo[3] = {-m, -m, -m}, hi[3] = {m, m, m};
    struct random random = {501};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_box(&soup, lo, hi);
    struct fixture fixture = fixture_of_soup("largest box", 501, &soup);
    add_aimed_rays(&list, &random, &fixture, scaled(250), -1e38f, 1e38f);
    add_aimed_rays(&list, &random, &fixture, scaled(250), -1, 1);
    add_axis_rays(&list, &random, &fixture, scaled(250));
    add_random_rays(&list, &random, scaled(250), -m / 2, m / 2);
    check_rays(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

static void directions_of_every_length(void **state)
{
    (void)state;
    static const float lengths[] = {1e-44f, 1e-38f, 1e-20f, 1e-5f, 1e5f, 1e20f, 1e38f};
    struct random random = {502};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_random(&soup, &random, 100, 1, 0.4f);
    struct fixture fixture = fixture_of_soup("lengths", 502, &soup);
    for (size_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++) {
        for (size_t n = 0; n < scaled(150); n++) {
            float origin[3], direction[3];
            draw_point(&random, -2, 2, origin);
            draw_point(&random, -lengths[i], lengths[i], direction);
            add_ray(&list, origin, direction);
        }
    }
    check_rays(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

/* Components of one direction that differ by up to 80 powers of ten. */
static void directions_with_mixed_magnitudes(void **state)
{
    (void)state;
    struct random random = {503};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_random(&soup, &random, 100, 1, 0.8f);
    struct fixture fixture = fixture_of_soup("mixed directions", 503, &soup);
    for (size_t n = 0; n < scaled(400); n++) {
        float origin[3], direction[3];
        draw_point(&random, -1, 1, origin);
        for (int k = 0; k < 3; k++) direction[k] = draw_finite(&random);
        add_ray(&list, origin, direction);
    }
    check_rays(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

/* ---- bad rays among good ones ------------------------------------------------------------------------------------ */

static void spoil(struct reference_ray *ray, uint32_t how)
{
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    switch (how % 6) {
    case 0:
        ray->origin[how / 6 % 3] = bad[how / 18 % 3];
        break;
    case 1:
        ray->direction[how / 6 % 3] = bad[how / 18 % 3];
        break;
    case 2:
        memset(ray->direction, 0, sizeof ray->direction);
        break;
    case 3:
        ray->t_min = NAN;
        break;
    case 4:
        ray->t_max = NAN;
        break;
    default:
        ray->t_min = ray->t_max;
        break;
    }
}

static void bad_rays_do_not_touch_their_neighbours(void **state)
{
    (void)state;
    struct random random = {600};
    struct soup soup = {0};
    soup_add_icosphere(&soup, 2, 1);
    struct fixture fixture = fixture_of_soup("bad neighbours", 600, &soup);
    for (uint32_t every = 1; every <= 17; every += 4) {
        struct ray_list list = {0};
        add_aimed_rays(&list, &random, &fixture, scaled(250), -0.25f, 0.25f);
        for (size_t i = 0; i < list.count; i += every) spoil(&list.rays[i], draw_bits(&random) >> 8);
        check_rays(&fixture, &list);
        free_rays(&list);
    }
    free_fixture(&fixture);
}

/* The same in packets that are otherwise coherent: a pinhole picture. */
static void bad_rays_in_coherent_packets(void **state)
{
    (void)state;
    const float eye[3] = {0, -4, 0.5f}, target[3] = {0, 0, 0};
    struct random random = {601};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_torus(&soup, 24, 12, 1, 0.4f);
    struct fixture fixture = fixture_of_soup("bad and coherent", 601, &soup);
    mlrt_camera camera = look_at(eye, target, 0.8f, 48, 40);
    add_camera_rays(&list, &camera);
    for (size_t i = 0; i < list.count; i += 1 + draw_below(&random, 40)) spoil(&list.rays[i], draw_bits(&random) >> 8);
    check_rays(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

/* ---- coherent rays ----------------------------------------------------------------------------------------------- */

static struct fixture torus_fixture(void)
{
    struct soup soup = {0};
    soup_add_torus(&soup, 24, 12, 1, 0.4f);
    return fixture_of_soup("torus", 700, &soup);
}

static void pictures_as_lists_of_rays(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {{1, 1}, {4, 4}, {5, 3}, {16, 16}, {33, 17}, {64, 64}, {100, 3}, {3, 100}};
    const float eye[3] = {0.1f, -3, 0.7f}, target[3] = {0, 0, 0};
    struct fixture fixture = torus_fixture();
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        struct ray_list list = {0};
        mlrt_camera camera = look_at(eye, target, 0.9f, sizes[i][0], sizes[i][1]);
        add_camera_rays(&list, &camera);
        check_rays(&fixture, &list);
        free_rays(&list);
    }
    free_fixture(&fixture);
}

/* row_length is a hint: any value gives the same answers. */
static void every_row_length(void **state)
{
    (void)state;
    static const uint32_t rows[] = {0, 1, 2, 3, 4, 5, 7, 15, 16, 17, 31, 64, 1000, 1999, 2000, 100000, 0xFFFFFFFFu};
    const float eye[3] = {0.1f, -3, 0.7f}, target[3] = {0, 0, 0};
    struct fixture fixture = torus_fixture();
    struct ray_list list = {0};
    mlrt_camera camera = look_at(eye, target, 0.9f, 50, 40);
    add_camera_rays(&list, &camera);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        list.row_length = rows[i];
        check_rays_quickly(&fixture, &list);
    }
    free_rays(&list);
    free_fixture(&fixture);
}

static void every_count_up_to_70(void **state)
{
    (void)state;
    struct random random = {701};
    struct fixture fixture = torus_fixture();
    struct ray_list list = {0};
    add_mixed_rays(&list, &random, &fixture, 78, -1, 1);
    for (size_t count = 0; count <= 70; count++) {
        list.count = count;
        list.row_length = count % 3 ? 0 : 5;
        check_rays_quickly(&fixture, &list);
    }
    free_rays(&list);
    free_fixture(&fixture);
}

static void order_does_not_matter(void **state)
{
    (void)state;
    const float eye[3] = {0.1f, -3, 0.7f}, target[3] = {0, 0, 0};
    struct random random = {702};
    struct fixture fixture = torus_fixture();
    struct ray_list list = {0};
    mlrt_camera camera = look_at(eye, target, 0.9f, 40, 40);
    add_camera_rays(&list, &camera);
    for (size_t i = list.count - 1; i > 0; i--) {
        size_t j = draw_below(&random, (uint32_t)i + 1);
        struct reference_ray swapped = list.rays[i];
        list.rays[i] = list.rays[j];
        list.rays[j] = swapped;
    }
    check_rays(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

/* Packets from several points, near each other and in turn: what was worked out for one must not serve the next. */
static void eyes_in_turn(void **state)
{
    (void)state;
    struct fixture fixture = torus_fixture();
    struct ray_list list = {0};
    for (int round = 0; round < 8; round++) {
        const float eye[3] = {3, 0.25f * (float)(round % 3), 0.5f - 0.3f * (float)(round % 3)};
        for (int i = 0; i < 64; i++) {
            const float target[3] = {1.2f, 0.05f * (float)(i % 8) - 0.17f, 0.05f * (float)(i / 8) - 0.19f};
            add_ray_towards(&list, eye, target);
        }
    }
    check_rays_quickly(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

static void parallel_rays(void **state)
{
    (void)state;
    const float centre[3] = {0, -2, 0}, along[3] = {0.1f, 1, 0.2f}, axis[3] = {0, 1, 0};
    struct fixture fixture = torus_fixture();
    struct ray_list list = {0};
    mlrt_camera camera = look_along(centre, along, 3, 40, 40);
    add_camera_rays(&list, &camera);
    camera = look_along(centre, axis, 3, 40, 40);
    add_camera_rays(&list, &camera);
    check_rays(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

/* t ranges and skips that differ from ray to ray of a coherent packet. */
static void ranges_and_skips_in_coherent_packets(void **state)
{
    (void)state;
    const float eye[3] = {0.1f, -3, 0.7f}, target[3] = {0, 0, 0};
    struct random random = {703};
    struct fixture fixture = torus_fixture();
    struct ray_list list = {0};
    mlrt_camera camera = look_at(eye, target, 0.9f, 40, 40);
    add_camera_rays(&list, &camera);
    for (size_t i = 0; i < list.count; i++) {
        struct reference_ray *ray = &list.rays[i];
        struct reference_hit hit;
        reference_trace(fixture.reference, ray, &hit);
        if (draw_below(&random, 2)) ray->t_min = draw_range(&random, -1, 3);
        if (draw_below(&random, 2)) ray->t_max = draw_range(&random, -1, 4);
        if (draw_below(&random, 2)) memcpy(ray->skip, &hit.mesh, sizeof ray->skip[0]);
        ray->skip[1] = hit.triangle;
    }
    check_rays(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

/* ---- layouts ----------------------------------------------------------------------------------------------------- */

enum { RAYS = 45, GUARD = 0xA5 };

struct layout {
    struct fixture fixture;
    struct ray_list list;
    struct reference_hit expected[RAYS];
};

static void make_layout(struct layout *layout)
{
    struct random random = {800};
    memset(layout, 0, sizeof *layout);
    layout->fixture = torus_fixture();
    add_aimed_rays(&layout->list, &random, &layout->fixture, RAYS, -3, 3);
    trace_reference(&layout->fixture, &layout->list, layout->expected);
}

static void free_layout(struct layout *layout)
{
    free_rays(&layout->list);
    free_fixture(&layout->fixture);
}

/* Field `field` of a hit, counted as in mlrt_hits. */
static uint32_t field_of(const struct reference_hit *hit, int field)
{
    switch (field) {
    case 0:
        return bits_of_float(hit->t);
    case 1:
        return bits_of_float(hit->u);
    case 2:
        return bits_of_float(hit->v);
    case 3:
        return hit->mesh;
    case 4:
        return hit->triangle;
    default:
        return (uint32_t)hit->facing;
    }
}

static mlrt_array *array_of(mlrt_hits *hits, int field)
{
    mlrt_array *const arrays[] = {&hits->t, &hits->u, &hits->v, &hits->mesh, &hits->triangle, &hits->facing};
    return arrays[field];
}

/* Traces with one output at `stride` bytes, starting 4 bytes into a block, and looks at every byte of the block. */
static void trace_one_output(const struct layout *layout, int field, size_t stride, const struct variant *variant)
{
    size_t step = stride ? stride : 4, size = 4 + RAYS * step;
    unsigned char *block = allocate_or_fail(size, 1);
    memset(block, GUARD, size);
    mlrt_rays rays = public_rays(&layout->list);
    mlrt_hits hits = {.struct_size = sizeof hits};
    *array_of(&hits, field) = (mlrt_array){block + 4, stride, 0};
    const mlrt_tree *tree = variant_tree(variant, &layout->fixture);
    assert_int_equal(mlrt_trace_packet(tree, &rays, &variant->options, &hits), MLRT_OK);
    for (size_t i = 0; i < size; i++) {
        size_t element = i < 4 ? RAYS : (i - 4) / step, byte = i < 4 ? 4 : (i - 4) % step;
        if (byte >= 4) {
            assert_int_equal(block[i], GUARD);
            continue;
        }
        unsigned char wanted[4];
        uint32_t value = field_of(&layout->expected[element], field);
        memcpy(wanted, &value, 4);
        assert_int_equal(block[i], wanted[byte]);
    }
    free(block);
}

static void each_output_alone_at_each_stride(void **state)
{
    (void)state;
    static const size_t strides[] = {0, 4, 8, 12, 20, 64, 100};
    struct layout layout;
    make_layout(&layout);
    for (size_t v = 0; v < variant_count(); v++) {
        if (!variant_at(v)->probe) continue;
        for (int field = 0; field < 6; field++) {
            for (size_t i = 0; i < sizeof strides / sizeof strides[0]; i++)
                trace_one_output(&layout, field, strides[i], variant_at(v));
        }
    }
    free_layout(&layout);
}

static void occluded_at_each_stride(void **state)
{
    (void)state;
    static const size_t strides[] = {0, 1, 2, 3, 7, 64};
    struct layout layout;
    make_layout(&layout);
    for (size_t s = 0; s < sizeof strides / sizeof strides[0]; s++) {
        size_t step = strides[s] ? strides[s] : 1, size = RAYS * step + 2;
        unsigned char *block = allocate_or_fail(size, 1);
        memset(block, GUARD, size);
        mlrt_rays rays = public_rays(&layout.list);
        mlrt_hits hits = {.struct_size = sizeof hits, .occluded = {block + 1, strides[s], 0}};
        mlrt_trace_options options = {.struct_size = sizeof options, .query = MLRT_QUERY_ANY};
        assert_int_equal(mlrt_trace_packet(layout.fixture.tree, &rays, &options, &hits), MLRT_OK);
        for (size_t i = 0; i < size; i++) {
            int is_element = i >= 1 && (i - 1) % step == 0 && (i - 1) / step < RAYS;
            int wanted = is_element ? layout.expected[(i - 1) / step].mesh != MLRT_NONE : GUARD;
            assert_int_equal(block[i], wanted);
        }
        free(block);
    }
    free_layout(&layout);
}

/* A call that would write nothing is a mistake, unless it counts, or there are no rays. */
static void no_output_at_all(void **state)
{
    (void)state;
    struct layout layout;
    make_layout(&layout);
    mlrt_rays rays = public_rays(&layout.list);
    mlrt_hits hits = {.struct_size = sizeof hits};
    mlrt_counters counters = {.struct_size = sizeof counters};
    const mlrt_trace_options any = {.struct_size = sizeof any, .query = MLRT_QUERY_ANY};
    const mlrt_trace_options counting = {.struct_size = sizeof counting, .counters = &counters};
    assert_int_equal(mlrt_trace_packet(layout.fixture.tree, &rays, NULL, &hits), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_trace_packet(layout.fixture.tree, &rays, &any, &hits), MLRT_ERROR_ARGUMENT);
    assert_int_equal(mlrt_trace_packet(layout.fixture.tree, &rays, &counting, &hits), MLRT_OK);
    assert_int_equal(counters.ray_count, rays.count);
    rays.count = 0;
    assert_int_equal(mlrt_trace_packet(layout.fixture.tree, &rays, NULL, &hits), MLRT_OK);
    free_layout(&layout);
}

/* All inputs packed, each in a block that ends where a page begins that must not be touched. */
static void inputs_are_not_read_beyond_their_ends(void **state)
{
    (void)state;
    struct layout layout;
    make_layout(&layout);
    for (size_t count = 1; count <= RAYS; count += 3) {
        float *origins = allocate_guarded(12 * count), *directions = allocate_guarded(12 * count);
        float *t_min = allocate_guarded(4 * count), *t_max = allocate_guarded(4 * count);
        uint32_t *skip = allocate_guarded(8 * count), *triangles = allocate_guarded(4 * count);
        for (size_t i = 0; i < count; i++) {
            const struct reference_ray *ray = &layout.list.rays[i];
            memcpy(origins + 3 * i, ray->origin, 12);
            memcpy(directions + 3 * i, ray->direction, 12);
            memcpy(skip + 2 * i, ray->skip, 8);
            t_min[i] = ray->t_min;
            t_max[i] = ray->t_max;
        }
        for (size_t v = 0; v < variant_count(); v++) {
            mlrt_rays rays = {.struct_size = sizeof rays,
                              .count = count,
                              .origins = {origins, 0},
                              .directions = {directions, 0},
                              .t_min = {t_min, 0},
                              .t_max = {t_max, 0},
                              .skip = {skip, 0}};
            mlrt_hits hits = {.struct_size = sizeof hits, .triangle = {triangles, 0, 0}};
            const mlrt_tree *tree = variant_tree(variant_at(v), &layout.fixture);
            assert_int_equal(mlrt_trace_packet(tree, &rays, &variant_at(v)->options, &hits), MLRT_OK);
            for (size_t i = 0; i < count; i++) assert_int_equal(triangles[i], layout.expected[i].triangle);
        }
        free_guarded(origins, 12 * count);
        free_guarded(directions, 12 * count);
        free_guarded(t_min, 4 * count);
        free_guarded(t_max, 4 * count);
        free_guarded(skip, 8 * count);
        free_guarded(triangles, 4 * count);
    }
    free_layout(&layout);
}

/* Only origins and directions are given. */
static void missing_arrays_mean_no_limits(void **state)
{
    (void)state;
    struct layout layout;
    struct reference_hit got[RAYS];
    make_layout(&layout);
    mlrt_rays rays = public_rays(&layout.list);
    rays.t_min.data = NULL;
    rays.t_max.data = NULL;
    rays.skip.data = NULL;
    mlrt_hits hits = {.struct_size = sizeof hits, .t = {&got[0].t, sizeof got[0], 0}};
    assert_int_equal(mlrt_trace_packet(layout.fixture.tree, &rays, NULL, &hits), MLRT_OK);
    for (size_t i = 0; i < RAYS; i++) assert_int_equal(bits_of_float(got[i].t), bits_of_float(layout.expected[i].t));
    free_layout(&layout);
}

/* In arrays 0 means 0, unlike in a single ray. */
static void a_t_max_of_zero_in_an_array_is_literal(void **state)
{
    (void)state;
    struct layout layout;
    make_layout(&layout);
    for (size_t i = 0; i < RAYS; i += 2) layout.list.rays[i].t_max = i % 4 ? -0.0f : 0.0f;
    check_rays(&layout.fixture, &layout.list);
    free_layout(&layout);
}

static void an_empty_tree(void **state)
{
    (void)state;
    struct random random = {801};
    struct ray_list list = {0};
    struct fixture fixture = make_fixture("empty", 801, NULL, 0);
    add_random_rays(&list, &random, 100, -1, 1);
    check_rays(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

static void a_tree_of_left_out_triangles(void **state)
{
    (void)state;
    struct random random = {802};
    const float a[3] = {0, 0, 0}, b[3] = {1, 1, 1}, c[3] = {2, 2, 2}, bad[3] = {0, INFINITY, 0};
    struct soup soup = {0};
    struct ray_list list = {0};
    soup_add_triangle(&soup, a, b, c);
    soup_add_triangle(&soup, a, b, bad);
    struct fixture fixture = fixture_of_soup("all left out", 802, &soup);
    add_random_rays(&list, &random, 100, -1, 1);
    check_rays(&fixture, &list);
    free_rays(&list);
    free_fixture(&fixture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(small_triangles),
        cmocka_unit_test(medium_triangles),
        cmocka_unit_test(large_triangles),
        cmocka_unit_test(few_triangles),
        cmocka_unit_test(needles_of_aspect_100),
        cmocka_unit_test(needles_of_aspect_1e6),
        cmocka_unit_test(coplanar_grids_on_each_axis),
        cmocka_unit_test(a_lattice_of_grids),
        cmocka_unit_test(boxes_that_share_faces),
        cmocka_unit_test(a_sphere),
        cmocka_unit_test(a_torus),
        cmocka_unit_test(equal_triangles),
        cmocka_unit_test(triangles_around_one_point),
        cmocka_unit_test(the_room),
        cmocka_unit_test(packets_of_one_ray),
        cmocka_unit_test(packets_that_end_at_a_triangle),
        cmocka_unit_test(walls_close_to_origins),
        cmocka_unit_test(the_office),
        cmocka_unit_test(the_scan),
        cmocka_unit_test(every_preset_and_rule),
        cmocka_unit_test(every_depth_limit),
        cmocka_unit_test(tiny_scales),
        cmocka_unit_test(huge_scales),
        cmocka_unit_test(mixed_scales),
        cmocka_unit_test(far_from_the_origin),
        cmocka_unit_test(arbitrary_bits),
        cmocka_unit_test(the_largest_floats),
        cmocka_unit_test(directions_of_every_length),
        cmocka_unit_test(directions_with_mixed_magnitudes),
        cmocka_unit_test(bad_rays_do_not_touch_their_neighbours),
        cmocka_unit_test(bad_rays_in_coherent_packets),
        cmocka_unit_test(pictures_as_lists_of_rays),
        cmocka_unit_test(every_row_length),
        cmocka_unit_test(every_count_up_to_70),
        cmocka_unit_test(order_does_not_matter),
        cmocka_unit_test(eyes_in_turn),
        cmocka_unit_test(parallel_rays),
        cmocka_unit_test(ranges_and_skips_in_coherent_packets),
        cmocka_unit_test(each_output_alone_at_each_stride),
        cmocka_unit_test(occluded_at_each_stride),
        cmocka_unit_test(no_output_at_all),
        cmocka_unit_test(inputs_are_not_read_beyond_their_ends),
        cmocka_unit_test(missing_arrays_mean_no_limits),
        cmocka_unit_test(a_t_max_of_zero_in_an_array_is_literal),
        cmocka_unit_test(an_empty_tree),
        cmocka_unit_test(a_tree_of_left_out_triangles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
