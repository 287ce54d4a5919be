/* SPDX-License-Identifier: MIT */
/*
 * Bundles whose numbers are near the ends of what floats are: intercepts and depths that are denormal, directions of
 * which a component is tiny, whose slopes or reciprocals float does not carry. Every way of tracing against the
 * reference.
 *
 * And searches for the ray and triangle whose intercept, edge function, D or N comes closest to its bound
 * (docs/accuracy.md, "Bundles"), as in test_bounds.c. `test_bundle_bounds 100` searches 100 times as long.
 */
#include <gmp.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "search.h"

/* The kernels, one lane wide; they multiply and add with one rounding or two. */
#include "simd/scalar.h"

static int is_fused;
static int divisor_count;
static float divisors[4];

static float multiply_add(float a, float b, float c)
{
    return is_fused ? fmaf(a, b, c) : v_mul_add(a, b, c);
}

static float multiply_subtract(float a, float b, float c)
{
    return is_fused ? fmaf(a, b, -c) : v_mul_sub(a, b, c);
}

/* Keeps what the last terms were divided by: true values are in the same units. */
static float remembering_divide(float a, float b)
{
    divisors[divisor_count++ % 4] = b;
    return v_div(a, b);
}

#define v_mul_add      multiply_add
#define v_mul_sub      multiply_subtract
#define v_div          remembering_divide
#define BOX_KERNELS    bundle_bounds_kernels
#define KDTREE_KERNELS bundle_bounds_kernels_kdtree
#include "isa/kernels.h"

#define MLRT_QUAD_H /* the kernels have quads in plain C */

#undef v_mul_add
#undef v_mul_sub
#undef v_div

enum { SIDE = 16, RAY_COUNT = SIDE * SIDE };

static void add_triangle(struct soup *soup, float ax, float ay, float az, float bx, float by, float bz, float cx,
                         float cy, float cz)
{
    const float a[3] = {ax, ay, az}, b[3] = {bx, by, bz}, c[3] = {cx, cy, cz};
    soup_add_triangle(soup, a, b, c);
}

static void check(const char *name, uint64_t seed, struct soup *soup, struct ray_list *list)
{
    struct fixture fixture = fixture_of_soup(name, seed, soup);
    list->row_length = SIDE;
    check_rays_quickly(&fixture, list);
    free_rays(list);
    free_fixture(&fixture);
}

/* From one point with slopes of 0.45 * 2^-149, at a depth where that is more than the width of a triangle. */
static void slopes_may_underflow(void **state)
{
    (void)state;
    struct soup soup = {0};
    struct ray_list list = {0};
    const float origin[3] = {0, 0, 0};
    add_triangle(&soup, 0x1p-93f, -0x1p58f, 0x1p59f, 0x1p-89f, -0x1p58f, 0x1p59f, 0x1p-93f, 0x1p59f, 0x1p59f);
    add_triangle(&soup, -0x1p58f, -0x1p58f, 0x1p60f, 0x1p58f, -0x1p58f, 0x1p60f, 0, 0x1p59f, 0x1p60f);
    for (int i = 0; i < RAY_COUNT; i++) {
        const float direction[3] = {0x1.cp-91f, 0x1p50f * (float)(1 + i), 0x1p60f};
        add_ray(&list, origin, direction);
    }
    check("slopes that underflow", 0, &soup, &list);
}

/* Two planes at depths of less than 2^-149 from the origin, in either order: t tells which is nearer. */
static void depths_may_underflow(void **state)
{
    (void)state;
    for (int order = 0; order < 2; order++) {
        struct soup soup = {0};
        struct ray_list list = {0};
        const float origin[3] = {0, 0, 0}, start[2] = {order ? -0.7f : -0.9f, order ? -0.9f : -0.7f};
        for (int i = 0; i < 2; i++) add_triangle(&soup, start[i], -1, 0, start[i], 1, 0, 1, 0, 0x1p-149f);
        add_triangle(&soup, -1, -1, 1, 1, -1, 1, 0, 1, 1);
        for (int i = 0; i < RAY_COUNT; i++) {
            const float direction[3] = {0, 0, 0x1p-60f * (1 + (float)i / RAY_COUNT)};
            add_ray(&list, origin, direction);
        }
        check("depths that underflow", (uint64_t)order, &soup, &list);
    }
}

/*
 * Three planes like those, in different leaves, and so small that t is known to a few units in the last place. One ray
 * of a tile alone goes there: it is traced by itself, and what it finds is kept as tau until the next leaf.
 */
static void depths_of_few_rays_may_underflow(void **state)
{
    static const float ways[3][2] = {{0, 1}, {0, -1}, {1, 0}};
    (void)state;
    for (uint64_t seed = 0; seed < scaled(8); seed++) {
        struct random random = {seed * 0x10001 + 7};
        struct soup soup = {0};
        struct ray_list list = {0};
        const float size = ldexpf(1, -137 + (int)(seed % 4));
        for (int side = 0; side < 3; side++) {
            const float x = size * ways[side][0], y = size * ways[side][1], end = draw_range(&random, 0.3f, 1);
            add_triangle(&soup, -0.01f * x - 0.5f * y, -0.01f * y + 0.5f * x, 0x1p-149f, -0.01f * x + end * y,
                         -0.01f * y - end * x, 0, 4 * x, 4 * y, 0);
            for (int i = 0; i < 16; i++) {
                const float from = 1 + 0.2f * (float)i, to = from + 0.2f;
                add_triangle(&soup, from * x - 0.3f * y, from * y + 0.3f * x, 0, from * x + 0.3f * y,
                             from * y - 0.3f * x, 0, to * x, to * y, 0);
            }
        }
        for (int i = 0; i < RAY_COUNT; i++) {
            const float origin[3] = {10 * (float)(i % SIDE - 5), 10 * (float)(i / SIDE - 5), 0};
            const float direction[3] = {0, 0, 0x1p-60f * draw_range(&random, 1, 2)};
            add_ray(&list, origin, direction);
        }
        check("depths of few rays that underflow", seed, &soup, &list);
    }
}

/*
 * Origins 2^-131 from the waist, and a triangle four to five times 2^-149 beside it: roundings of an intercept there,
 * and of a slope times a depth, make more than 2^-149 together, and INTERCEPT_ERROR R A is less than that. The first
 * tile starts at 0 and so sets the waist, which the second one keeps. In that each packet has one ray, sixteen times;
 * that of packet 5 says which axis is the main one.
 */
static void places_may_underflow(void **state)
{
    const float origin[3] = {0, 0, 0}, beside[3] = {-271810 * 0x1p-149f, 0, -233378 * 0x1p-149f};
    const float direction[3] = {10406226 * 0x1p-23f, 0, 8934843 * 0x1p-23f};
    struct soup soup = {0};
    struct ray_list list = {0};
    (void)state;
    add_triangle(&soup, 0x4p-149f, -1, 0x3p-149f, 0x4p-149f, 1, 0x3p-149f, 0x5p-149f, 0, 0x3p-149f);
    add_triangle(&soup, -1, -1, 1, 1, -1, 1, 0, 1, 1);
    for (int i = 0; i < 2 * RAY_COUNT; i++) {
        const int column = i % SIDE / 4, row = i / SIDE % SIDE / 4;
        const float other[3] = {0.25f * (float)column, 0.25f * (float)row, 1};
        const int is_other = i < RAY_COUNT || (column == 1 && row == 1);
        add_ray(&list, is_other ? origin : beside, is_other ? other : direction);
    }
    check("intercepts that underflow", 0, &soup, &list);
}

/*
 * Directions of 2^-60 with a component of 2^-130, whose reciprocal is infinite, but not the t of what it leads to. One
 * packet is far wider than the others and so goes lane by lane.
 */
static void reciprocals_may_overflow(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < scaled(5); seed++) {
        struct random random = {seed * 0x10001 + 3};
        struct soup soup = {0};
        struct ray_list list = {0};
        for (int i = 0; i < 60; i++) {
            float centre[3], corner[3][3];
            draw_point(&random, -1, 1, centre);
            for (int j = 0; j < 3; j++) {
                corner[j][0] = 0x1p-12f * (0.5f * centre[0] + draw_range(&random, 0.5f, 0.8f));
                corner[j][1] = centre[1] + draw_range(&random, 0, 0.6f);
                corner[j][2] = 0x1p59f * (1 + 0.5f * centre[2]);
            }
            soup_add_triangle(&soup, corner[0], corner[1], corner[2]);
        }
        for (int i = 0; i < RAY_COUNT; i++) {
            const int is_wide = i % SIDE / 4 == 1 && i / SIDE / 4 == 1;
            const float width = is_wide ? 1 : 0.01f;
            const float origin[3] = {-0x1p-13f * draw_range(&random, 0.5f - 0.5f * width, 0.5f + 0.5f * width),
                                     draw_range(&random, -width, width), 0};
            const float direction[3] = {0x1p-130f * draw_range(&random, 1, 1 + width), 0, 0x1.8p-60f};
            add_ray(&list, origin, direction);
        }
        check("reciprocals that overflow", seed, &soup, &list);
    }
}

/*
 * A triangle 2^-80 beside the waist, in depth, and 2^50 aside: seen from there it has no slope that float carries, but
 * rays that begin as far aside hit it.
 */
static void slopes_of_triangles_may_overflow(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 4; seed++) {
        struct random random = {seed * 0x10001 + 11};
        struct soup soup = {0};
        struct ray_list list = {0};
        const float from_waist[3] = {0, 0, 0}, beside[3] = {seed & 1 ? -0x1p50f : 0x1p50f, 0, 0};
        const float depth = seed & 2 ? -0x1p-80f : 0x1p-80f, side = copysignf(1, beside[0]);
        add_triangle(&soup, side * 0x1p49f, -1, depth, side * 0x1p52f, -1, depth, side * 0x1p49f, 2, depth);
        const float lo[3] = {-1, -1, 4}, hi[3] = {1, 1, 5};
        soup_add_box(&soup, lo, hi); /* so that the unit is 1 */
        for (int i = 0; i < RAY_COUNT; i++) {
            const int x = i % 4, y = i / SIDE % 4, is_sample = x == y && x % 3 == 0; /* of those the waist is made */
            const float direction[3] = {draw_range(&random, -0.1f, 0.1f), draw_range(&random, -0.1f, 0.1f),
                                        depth < 0 ? -1 : 1};
            const float along[3] = {0, 0, direction[2]};
            add_ray(&list, is_sample ? from_waist : beside, is_sample ? direction : along);
        }
        check("slopes of triangles that overflow", seed, &soup, &list);
    }
}

/*
 * Tiles whose waist is one point: that of parallel rays of one direction, of another, and of rays that begin there.
 * What is kept of a leaf says where its triangles are seen along one direction.
 */
static void one_waist_has_many_slopes(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 8; seed++) {
        struct random random = {seed * 0x10001 + 13};
        struct soup soup = {0};
        struct ray_list list = {0};
        const float lo[3] = {-1, -1, -1}, hi[3] = {1, 1, 1};
        soup_add_box(&soup, lo, hi);
        soup_add_random(&soup, &random, 40, 0.9f, 0.2f);
        for (int number = 0; number < 6; number++) {
            const float slopes[2] = {0.25f * (float)draw_below(&random, 5) - 0.5f,
                                     0.25f * (float)draw_below(&random, 5) - 0.5f};
            for (int i = 0; i < RAY_COUNT; i++) {
                const uint32_t packet = (uint32_t)(i % SIDE / 4 + i / SIDE / 4 * 4);
                const float x = ((float)(i % SIDE) - 7.5f) * 0x1p-5f, y = ((float)(i / SIDE) - 7.5f) * 0x1p-5f;
                /* Samples of the waist lie evenly around the middle of the scene, the first one there. */
                const float a = packet == 15 ? 0.25f : packet == 0 ? -0.25f : 0;
                const float b = packet == 3 ? 0.25f : packet == 12 ? -0.25f : 0;
                const int is_sample = 0x9429u >> packet & 1, is_fan = number == (int)(seed % 6);
                const float origin[3] = {is_fan ? 0 : is_sample ? a : x, is_fan ? 0 : is_sample ? b : y, 0};
                const float direction[3] = {slopes[0] + (is_fan ? x : 0), slopes[1] + (is_fan ? y : 0), 1};
                add_ray(&list, origin, direction);
            }
        }
        check("one waist, many slopes", seed, &soup, &list);
    }
}

/* ---- searches ---------------------------------------------------------------------------------------------------- */

/*
 * Inputs: three corners, the waist, a number whose sign says whether products are fused, and one or two rays: origin
 * and direction.
 */
enum { WAIST = 9, FUSED = 12, RAY = 13, RAY_INPUTS = 6, INPUT_COUNT = 19, INPUT_COUNT_OF_TWO = 25 };
#define ORIGIN(ray)         (RAY + RAY_INPUTS * (ray))
#define DIRECTION(ray)      (ORIGIN(ray) + 3)
#define DIRECTIONS_ARE_SAFE (7u << DIRECTION(0) | 7u << DIRECTION(1))

static struct mlrt_ray_tile tile;
static struct mlrt_bundle bundle;
static struct mlrt_bundle_leaf leaf;
static struct mlrt_triangle triangles[1];
static const struct mlrt_tree tree_of_one = {.by_number.corners = triangles[0].v[0], .bvh.unit = 1};

/* Numbers without rounding: of these inputs none has more than 800 bits. */
#define EXACT_BITS 1280

struct vector {
    mpf_t x[3];
};

static mpf_t product, truth, value, scale, other;
/* By axis of the bundle, relative to the waist; what rays are, of two. */
static struct vector corner[3], edge[3], origin[2], direction[2], cross, seen;

static void init_vector(struct vector *a)
{
    for (int k = 0; k < 3; k++) mpf_init2(a->x[k], EXACT_BITS);
}

static void init_numbers(void)
{
    mpf_set_default_prec(EXACT_BITS);
    mpf_inits(product, truth, value, scale, other, NULL);
    for (int i = 0; i < 3; i++) {
        init_vector(&corner[i]);
        init_vector(&edge[i]);
    }
    for (int i = 0; i < 2; i++) {
        init_vector(&origin[i]);
        init_vector(&direction[i]);
    }
    init_vector(&cross);
    init_vector(&seen);
}

static void subtract_vectors(const struct vector *a, const struct vector *b, struct vector *result)
{
    for (int k = 0; k < 3; k++) mpf_sub(result->x[k], a->x[k], b->x[k]);
}

static void find_cross(const struct vector *a, const struct vector *b)
{
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        mpf_mul(cross.x[k], a->x[i], b->x[j]);
        mpf_mul(product, a->x[j], b->x[i]);
        mpf_sub(cross.x[k], cross.x[k], product);
    }
}

/* Sets `truth` to a . cross. */
static void find_dot(const struct vector *a)
{
    mpf_set_ui(truth, 0);
    for (int k = 0; k < 3; k++) {
        mpf_mul(product, a->x[k], cross.x[k]);
        mpf_add(truth, truth, product);
    }
}

/* (computed scale - truth) / (bound scale) */
static double error_over(double computed, double bound)
{
    long top, bottom;
    mpf_set_d(value, computed);
    mpf_mul(value, value, scale);
    mpf_sub(value, value, truth);
    const double error = mpf_get_d_2exp(&top, value);
    mpf_set_d(value, bound);
    mpf_mul(value, value, scale);
    const double most = mpf_get_d_2exp(&bottom, value);
    return error == 0 ? 0 : ldexp(error / most, (int)(top - bottom));
}

/* Of a number whose bounds are these: +-1 is at one of them. */
static double place_between(double lo, double hi)
{
    return error_over(0.5 * (lo + hi), 0.5 * (hi - lo));
}

/* How far `truth` is beyond an interval, over by how much it was moved apart. */
static double beyond(double lo, double hi, double moved)
{
    return fmax(error_over(lo, moved), -error_over(hi, moved));
}

static void set_scale(double a, double b)
{
    mpf_set_d(scale, a);
    mpf_set_d(product, b);
    mpf_mul(scale, scale, product);
}

/* Relative to the waist, with the sign of the main axis, which is the first one. */
static void load_exactly(const float *point, struct vector *result)
{
    for (int k = 0; k < 3; k++) {
        mpf_set_d(result->x[k], point[k]);
        mpf_set_d(product, bundle.waist.point[k]);
        mpf_sub(result->x[k], result->x[k], product);
    }
    if (bundle.waist.sign < 0) mpf_neg(result->x[0], result->x[0]);
}

/* A bundle of one packet, of rays like these; they begin at t = 0 and have no end. */
static void begin_bundle_of(const float *point, const float *const *origins, const float *const *directions, int count)
{
    struct mlrt_packet *packet = &tile.packets[0];
    bundle.tile = &tile;
    tile.made = 1;
    bundle.state.going = bundle.state.closed = 1;
    bundle.state.has_lanes = bundle.state.covered = bundle.state.apexes = 0;
    bundle.scene.unit = 1;
    bundle.scene.reach = MLRT_SAFE_MAX;
    bundle.scene.first = -INFINITY;
    bundle.scene.last = INFINITY;
    bundle.waist = (struct mlrt_waist){.sign = directions[0][0] < 0 ? -1.0f : 1.0f};
    memcpy(bundle.waist.point, point, sizeof bundle.waist.point);
    packet->active = (1u << count) - 1;
    packet->in_double = 0;
    packet->has.apex = packet->has.skip = packet->has.masks = packet->has.limits = 0;
    for (int lane = 0; lane < MLRT_PACKET_RAYS; lane++) {
        const int ray = lane < count ? lane : 0;
        packet->t_min[lane] = 0;
        packet->t_max[lane] = INFINITY;
        for (int k = 0; k < 3; k++) {
            packet->origin[k][lane] = origins[ray][k];
            packet->direction[k][lane] = directions[ray][k];
        }
    }
    for (int ray = 0; ray < count; ray++) {
        load_exactly(origins[ray], &origin[ray]);
        for (int k = 0; k < 3; k++) mpf_set_d(direction[ray].x[k], k ? directions[ray][k] : fabsf(directions[ray][k]));
    }
}

/* Makes the hull of the packet, and its numbers lane by lane. Returns whether float carries them. */
static int finish_bundle(int has_intercepts)
{
    bundle.has.intercepts = has_intercepts;
    bundle.has.apex = !has_intercepts && find_apex(&bundle, bundle.apex);
    const uint32_t fit = bound_rays(&bundle, 0), active = tile.packets[0].active;
    if ((fit & active) != active || !hulls_fit(&bundle, 1)) return 0;
    assert_int_equal(bundle.state.apexes, !has_intercepts);
    finish_depths(&bundle, 1, 0);
    finish_hulls(&bundle, 0);
    bundle.hulls.closed.cover_near[0] = INFINITY;
    bundle.hulls.closed.cover[0] = MLRT_NONE;
    make_lanes(&bundle, 0);
    return 1;
}

/* Of inputs; with intercepts from a waist of their own, else from their origin. */
static int bundle_of(const float *input, int count, int has_intercepts)
{
    const float *const origins[2] = {input + ORIGIN(0), has_intercepts ? input + ORIGIN(1) : input + ORIGIN(0)};
    const float *const directions[2] = {input + DIRECTION(0), input + DIRECTION(1)};
    is_fused = input[FUSED] < 0;
    begin_bundle_of(has_intercepts ? input + WAIST : input + ORIGIN(0), origins, directions, count);
    return finish_bundle(has_intercepts);
}

static void set_up_triangle(const float *input)
{
    static const uint32_t number = 0;
    struct bundle_corners corners;
    load_bundle_corners(&bundle.waist, input, 1, 0, &corners);
    leaf.state.flipped = leaf.state.fans = 0;
    leaf.state.there = leaf.state.from_waist = 1;
    leaf.numbers = &number;
    leaf.corners = input;
    leaf.row = 1;
    leaf.has_intercepts = bundle.has.intercepts;
    set_outlines(&bundle.waist, (const vf(*)[3])corners.to, 1, 0, &leaf);
    divisor_count = 0;
    set_up_vector_by(&corners, 0, bundle.has.intercepts, &leaf); /* divisors: of n, of edges ab, bc, ca */
    leaf.state.doubtful = doubtful_places(&leaf) & 1;
    memcpy(triangles[0].v, input, sizeof triangles[0].v);
    for (int i = 0; i < 3; i++) load_exactly(input + 3 * i, &corner[i]);
    for (int i = 0; i < 3; i++) subtract_vectors(&corner[(i + 1) % 3], &corner[i], &edge[i]);
}

#define NORMAL_DIVISOR  0
#define EDGE_DIVISOR(i) (1 + (i))

/* Terms of triangles may have the other sign. */
static void turn_as_leaf(void)
{
    if (leaf.state.flipped & 1) mpf_neg(truth, truth);
}

/* Set `truth` to the edge function, D and N of a ray, as they are: N from its origin. */
static void find_edge(int i, int ray)
{
    subtract_vectors(&corner[i], &origin[ray], &seen);
    find_cross(&seen, &edge[i]);
    find_dot(&direction[ray]);
}

static void find_d(int ray)
{
    find_cross(&edge[2], &edge[0]); /* (a - c) x (b - a) */
    find_dot(&direction[ray]);
}

static void find_n(int ray)
{
    subtract_vectors(&corner[0], &origin[ray], &seen);
    find_cross(&edge[2], &edge[0]);
    find_dot(&seen);
}

/*
 * 1 = the ray passes inside the triangle's edges and hits it, 0 = at an edge, -1 = it misses. With `line` it goes on
 * before its origin, too.
 */
static int find_hit(int ray, int is_line)
{
    int sign[3];
    for (int i = 0; i < 3; i++) {
        find_edge(i, ray);
        sign[i] = mpf_sgn(truth);
    }
    find_d(ray);
    const int d = mpf_sgn(truth);
    find_n(ray);
    if (d == 0 || (!is_line && d * mpf_sgn(truth) <= 0)) return -1;
    for (int i = 0; i < 3; i++) {
        if (sign[i] * d < 0) return -1;
    }
    return sign[0] && sign[1] && sign[2];
}

/* In units of 1 / |d_main|. */
static double attack_intercept(const float *input)
{
    double worst = 0;
    if (!bundle_of(input, 1, 1)) return -1;
    const float bound =
        INTERCEPT_ERROR * (bundle.hulls.filter.direction_size[0] * bundle.hulls.filter.away[0]) + INTERCEPT_FLOOR;
    set_scale(tile.rays[0].pace[0], 1);
    for (int side = 0; side < 2; side++) {
        mpf_mul(truth, origin[0].x[1 + side], direction[0].x[0]);
        mpf_mul(product, origin[0].x[0], direction[0].x[1 + side]);
        mpf_sub(truth, truth, product);
        worst = fmax(worst, fabs(error_over(tile.rays[0].term[MLRT_INTERCEPT_J + side][0], bound)));
    }
    return worst;
}

/*
 * The hull of two rays: how much of what slopes, intercepts and moments are moved apart by is used up. Of intercepts
 * 0.25 of INTERCEPT_ERROR and what middles and radii pay for; of a moment what intercepts may be off by. And A is no
 * less than it says.
 */
static double attack_hull(const float *input)
{
    double worst = 0;
    if (!bundle_of(input, 2, 1)) return -1;
    const struct mlrt_hulls *hulls = &bundle.hulls;
    const double direction_size = hulls->filter.direction_size[0],
                 error = INTERCEPT_ERROR * (direction_size * hulls->filter.away[0]) + INTERCEPT_FLOOR;
    double radius[2];
    for (int ray = 0; ray < 2; ray++) {
        set_scale(tile.rays[0].pace[ray], 1);
        for (int side = 0; side < 2; side++) {
            const struct mlrt_hull_row *slopes = &hulls->term[MLRT_SLOPE_J + side],
                                       *intercepts = &hulls->term[MLRT_INTERCEPT_J + side];
            const double middle = hulls->filter.middle[MLRT_SLOPE_J + side][0],
                         slope_size = fmax(fabs(slopes->lo[0]), fabs(slopes->hi[0]));
            const double at = hulls->filter.middle[MLRT_INTERCEPT_J + side][0],
                         size = fmax(fabs(intercepts->lo[0]), fabs(intercepts->hi[0]));
            mpf_set(truth, direction[ray].x[1 + side]);
            if (2 * slope_size > direction_size) return INFINITY;
            radius[side] = hulls->filter.radius[MLRT_SLOPE_J + side][0];
            worst = fmax(worst, beyond(slopes->lo[0], slopes->hi[0], 0x1p-21 * slope_size + 0x1p-140));
            worst = fmax(worst, fabs(error_over(middle, radius[side] + 0x1p-148)) > 1 ? INFINITY : 0);
            worst = fmax(worst,
                         beyond(hulls->moved[MLRT_SLOPE_J + side].lo[0], hulls->moved[MLRT_SLOPE_J + side].hi[0], 1) > 0
                             ? INFINITY
                             : 0);
            mpf_mul(truth, origin[ray].x[1 + side], direction[ray].x[0]);
            mpf_mul(product, origin[ray].x[0], direction[ray].x[1 + side]);
            mpf_sub(truth, truth, product);
            worst = fmax(worst, beyond(intercepts->lo[0], intercepts->hi[0], error));
            worst =
                fmax(worst,
                     fabs(error_over(at, hulls->filter.radius[MLRT_INTERCEPT_J + side][0] + error)) > 1 ? INFINITY : 0);
            worst = fmax(worst, beyond(hulls->moved[MLRT_INTERCEPT_J + side].lo[0],
                                       hulls->moved[MLRT_INTERCEPT_J + side].hi[0], 1) > 0
                                    ? INFINITY
                                    : 0);
            if (13 * 0x1p-24 * size > hulls->filter.blur[0]) return INFINITY;
        }
        /* m d_main^2 = d_l (x_j d_main) - d_j (x_l d_main), where x d_main = o d_main - o_main d: o_main drops out. */
        mpf_mul(truth, origin[ray].x[1], direction[ray].x[2]);
        mpf_mul(product, origin[ray].x[2], direction[ray].x[1]);
        mpf_sub(truth, truth, product);
        const double around = hulls->filter.radius[MLRT_MOMENT][0] + 1.001 * direction_size * error;
        worst = fmax(worst, fabs(error_over(hulls->filter.middle[MLRT_MOMENT][0], around)) > 1 ? INFINITY : 0);
        for (int k = 0; k < 3; k++) { /* o_main and twice the others as computed */
            mpf_abs(truth, origin[ray].x[k]);
            set_scale(1, 1);
            const double rounded = fabs((k ? 2 : 1) * tile.rays[0].to_waist[k][ray]);
            if (rounded > hulls->filter.away[0]) return INFINITY;
        }
    }
    return worst;
}

/* Inputs: the waist's depth, an origin's, |d_main|, t_min and t_max. Depths between which rays look, and all do. */
static double attack_depths(const float *input)
{
    const float point[3] = {input[0], 0, 0}, from[3] = {input[1], 0, 0}, along[3] = {input[2], 0, 0};
    const float *const origins[1] = {from}, *const directions[1] = {along};
    struct mlrt_packet *packet = &tile.packets[0];
    double worst = 0;
    if (input[2] == 0) return -1;
    is_fused = 0;
    begin_bundle_of(point, origins, directions, 1);
    packet->has.limits = 1;
    packet->t_min[0] = input[3];
    packet->t_max[0] = input[4] == 1 ? INFINITY : input[4];
    const float begin = fmaxf(input[3], 0), end = packet->t_max[0];
    const int is_none = !(begin < end), has_intercepts = memcmp(point, from, sizeof point) != 0;
    if (!finish_bundle(has_intercepts)) return -1;
    if (is_none) return INFINITY;
    const struct mlrt_hulls *hulls = &bundle.hulls;
    set_scale(1, 1);
    mpf_set_d(truth, begin);
    mpf_mul(truth, truth, direction[0].x[0]);
    if (mpf_cmp_d(truth, (double)hulls->begin[0] * (1 + 0x1p-23) + 0x1p-149) > 0) return INFINITY;
    mpf_add(truth, truth, origin[0].x[0]);
    const double away = fabs(mpf_get_d(truth)) + hulls->filter.away[0], moved = SLOPE_SLACK * away + HULL_FLOOR;
    worst = fmax(worst, error_over(hulls->first[0] + moved, moved));
    worst = fmax(worst, -error_over(hulls->closed.common_first[0] - moved, moved));
    if (isinf(end)) return hulls->last[0] == INFINITY ? worst : INFINITY;
    mpf_set_d(truth, end);
    mpf_mul(truth, truth, direction[0].x[0]);
    mpf_add(truth, truth, origin[0].x[0]);
    const double far = fabs(mpf_get_d(truth)) + hulls->filter.away[0], moved_end = SLOPE_SLACK * far + HULL_FLOOR;
    if (far > 0x1p120) return worst;
    worst = fmax(worst, -error_over(hulls->last[0] - moved_end, moved_end));
    return fmax(worst, error_over(hulls->closed.common_last[0] + moved_end, moved_end));
}

/* Any numbers of any size, as t_min and t_max near each other, of both signs. */
static void draw_depths(struct random *random, const struct bound *bound, float *input)
{
    const int size = (int)draw_below(random, 240) - 140;
    for (int i = 0; i < 5; i++) {
        const float a = draw_range(random, -1, 1);
        input[i] = draw_below(random, 6) ? ldexpf(a, i < 3 || draw_below(random, 2) ? size : 0) : 0;
        input[i] = clamp_input(input[i], (int)(bound->safe >> i & 1));
    }
    if (draw_below(random, 4) == 0) input[1] = input[0];
    if (draw_below(random, 2)) input[4] = draw_below(random, 2) ? 1 : fmaxf(input[3], 0) + ldexpf(1, size);
    if (draw_below(random, 8) == 0) input[3] = -0.0f;
    input[4] = clamp_input(input[4], 0);
}

/* Those of the first ray and a triangle. */
static void find_edges(const struct mlrt_bundle_leaf *of, int has_intercepts, struct edge_values *found)
{
    found->bound[0] = edge_bounds(&(struct hull_pairs){&bundle.hulls, of, 0, 0, 0, has_intercepts}, 1);
    if (has_intercepts) {
        find_edge_values(of, &tile.rays[0], &tile.packets[0], 1, 1, 0, 1, found);
    } else {
        find_edge_values(of, &tile.rays[0], &tile.packets[0], 1, 0, 0, 1, found);
    }
}

/* In units of size / |d_main|. One edge at a time is the least of the three, as only that is kept. */
static double edges_over(const float *input, int has_intercepts)
{
    static struct edge_values found;
    double worst = 0;
    if (!bundle_of(input, 1, has_intercepts)) return -1;
    set_up_triangle(input);
    for (int i = 0; i < 3; i++) {
        struct mlrt_bundle_leaf one = leaf;
        for (int j = 0; j < 3; j++) {
            if (j == i) continue;
            one.edges.constant[j][0] = FLT_MAX;
            memset(one.edges.coefficient[j], 0, sizeof one.edges.coefficient[j]);
        }
        find_edges(&one, has_intercepts, &found);
        find_edge(i, 0);
        turn_as_leaf();
        set_scale(divisors[EDGE_DIVISOR(i)], tile.rays[0].pace[0]);
        worst = fmax(worst, fabs(error_over(found.inner[0][0], found.bound[0])));
    }
    return worst;
}

static double attack_edge(const float *input)
{
    return edges_over(input, 1);
}

static double attack_apex_edge(const float *input)
{
    return edges_over(input, 0);
}

/*
 * How much of what hulls are moved apart by is used up where a ray is at the depth of a point. A corner of a box has
 * one rounding of its own, for which a sixteenth of that is left.
 */
static double attack_box(const float *input)
{
    double worst = 0;
    if (!bundle_of(input, 1, 1)) return -1;
    const struct mlrt_hulls *hulls = &bundle.hulls;
    const float depth = (input[0] - input[WAIST]) * bundle.waist.sign;
    const float intercept_bound =
        INTERCEPT_ERROR * (hulls->filter.direction_size[0] * hulls->filter.away[0]) + INTERCEPT_FLOOR;
    load_exactly(input, &corner[0]);
    set_scale(tile.rays[0].pace[0], 1);
    mpf_sub(corner[0].x[0], corner[0].x[0], origin[0].x[0]);
    for (int i = 0; i < 2; i++) {
        const double intercept = hulls->term[MLRT_INTERCEPT_J + i].lo[0], slope = hulls->term[MLRT_SLOPE_J + i].lo[0];
        const double moved = (fabs(intercept) + fabs(slope * depth)) * SLOPE_SLACK + intercept_bound + HULL_FLOOR;
        const float upper =
            greatest_across(depth, depth, hulls->moved[MLRT_SLOPE_J + i].lo[0], hulls->moved[MLRT_SLOPE_J + i].hi[0],
                            hulls->moved[MLRT_INTERCEPT_J + i].hi[0], 1);
        const float lower =
            least_across(depth, depth, hulls->moved[MLRT_SLOPE_J + i].lo[0], hulls->moved[MLRT_SLOPE_J + i].hi[0],
                         hulls->moved[MLRT_INTERCEPT_J + i].lo[0], 1);
        mpf_mul(truth, origin[0].x[1 + i], direction[0].x[0]);
        mpf_mul(product, direction[0].x[1 + i], corner[0].x[0]);
        mpf_add(truth, truth, product);
        const double used = fmax(-error_over(upper - moved, moved), error_over(lower + moved, moved));
        worst = fmax(worst, used * 16 / 15);
    }
    return worst;
}

/* Sets `truth` to the component of a ray over one axis: at the waist, or with the slope put aside at a depth. */
static void find_exact_place(int side, mpf_t depth)
{
    mpf_mul(truth, origin[0].x[0], direction[0].x[1 + side]);
    mpf_div(truth, truth, direction[0].x[0]);
    mpf_sub(truth, origin[0].x[1 + side], truth);
    if (!depth) return;
    mpf_mul(product, depth, direction[0].x[1 + side]);
    mpf_div(product, product, direction[0].x[0]);
    mpf_add(truth, truth, product);
}

/*
 * A box that the first ray meets at the depth of a point, as small as floats allow there, deeper than that or less deep
 * if other numbers say so: nobody may leave it out. Returns 0 if nobody does.
 */
static double boxes_over(const float *input, int count, int has_intercepts)
{
    static struct mlrt_bvh_node node;
    struct box_of_bundle box;
    float near[MLRT_BVH_WIDTH];
    if (!bundle_of(input, count, has_intercepts)) return -1;
    for (uint32_t i = 1; i < MLRT_BUNDLE_PACKETS; i++) leave_bundle(&bundle, i);
    sum_up_hulls(&bundle);
    load_exactly(input, &corner[0]);
    mpf_sub(other, corner[0].x[0], origin[0].x[0]);
    if (mpf_sgn(other) < 0) return -1;
    for (int i = 0; i < MLRT_BVH_WIDTH; i++) {
        for (int k = 0; k < 3; k++) {
            node.lo[k][i] = INFINITY;
            node.hi[k][i] = -INFINITY;
        }
    }
    node.lo[0][0] = fminf(input[0], input[3]);
    node.hi[0][0] = fmaxf(input[0], input[3]);
    for (int side = 0; side < 2; side++) {
        find_exact_place(side, corner[0].x[0]);
        mpf_set_d(product, bundle.waist.point[1 + side]);
        mpf_add(truth, truth, product);
        float at = (float)mpf_get_d(truth);
        if (!(fabsf(at) <= MLRT_SAFE_MAX)) return -1;
        if (mpf_cmp_d(truth, at) < 0) at = next_float(at, -1);
        node.lo[1 + side][0] = at;
        node.hi[1 + side][0] = mpf_cmp_d(truth, at) == 0 ? at : next_float(at, 1);
    }
    if (!(bundle_children_met(&bundle, &node, has_intercepts, near) & 1)) return INFINITY;
    see_bundle_box(&bundle.waist, &node, 0, &box);
    if (!packets_met(&bundle, &box, has_intercepts)) return INFINITY;
    return lanes_of_packet_met(&bundle, 0, &box) & 1 ? 0.001 : INFINITY;
}

static double attack_box_met(const float *input)
{
    return boxes_over(input, 2, 1);
}

static double attack_apex_box_met(const float *input)
{
    return boxes_over(input, 2, 0);
}

/*
 * Outlines of a point in the triangle's place: as fans, or as beams along any slope. How much is used of 2^-20 of all
 * that is added up, what intercepts may be off by, and the floor: where the ray passes the point by d, the comparison
 * must be closer to what is met than d.
 */
static double outlines_over(const float *input, int has_intercepts)
{
    double worst = 0;
    float point[9];
    struct mlrt_hull hull;
    if (!bundle_of(input, 1, has_intercepts)) return -1;
    for (int i = 0; i < 9; i++) point[i] = input[i % 3];
    bundle.waist.is_beam = fabsf(input[3]) > 1;
    for (int i = 0; i < 2; i++) bundle.waist.slope[i] = bundle.waist.is_beam ? fminf(fmaxf(input[4 + i], -2), 2) : 0;
    set_up_triangle(point);
    take_hull(&bundle, 0, &hull);
    const struct mlrt_hulls *hulls = &bundle.hulls;
    const double error =
        has_intercepts ? INTERCEPT_ERROR * (hulls->filter.direction_size[0] * hulls->filter.away[0]) + INTERCEPT_FLOOR
                       : 0;
    const double depth = fabs(mpf_get_d(corner[0].x[0]));
    set_scale(1, 1);
    for (int i = 0; i < 2; i++) {
        const double t = bundle.waist.slope[i], slope = tile.rays[0].term[MLRT_SLOPE_J + i][0];
        const int is_fan = leaf.state.fans & 1;
        find_exact_place(i, corner[0].x[0]);
        mpf_sub(other, corner[0].x[1 + i], truth); /* by which the ray passes */
        find_exact_place(i, NULL);
        const double x = fabs(mpf_get_d(truth)), p = fabs(mpf_get_d(corner[0].x[1 + i]));
        double size = (p + x + fabs(slope) * depth + fabs(t) * depth) * SLOPE_SLACK + error;
        if (is_fan) size /= depth;
        size += HULL_FLOOR;
        if (is_fan) mpf_div(other, other, corner[0].x[0]);
        mpf_set(truth, other);
        const vf slopes[2] = {v_set1(hull.lo[MLRT_SLOPE_J + i]), v_set1(hull.hi[MLRT_SLOPE_J + i])};
        const vf intercepts[2] = {v_set1(hull.lo[MLRT_INTERCEPT_J + i]), v_set1(hull.hi[MLRT_INTERCEPT_J + i])};
        MLRT_ALIGNED(64) float lower[VW], upper[VW];
        vf ends[2];
        find_outline_ends(&bundle.waist, i, v_set1(leaf.outline.weight[0]), m_from_bits(0), is_fan, slopes, intercepts,
                          has_intercepts, ends);
        v_store(lower, ends[0]);
        v_store(upper, ends[1]);
        /* What is compared, relative to the ray's own: lo - upper is not more than `truth`, hi - lower not less. */
        const double low = (double)leaf.outline.lo[i][0] - upper[0], high = (double)leaf.outline.hi[i][0] - lower[0];
        if (!(low <= INFINITY && high >= -INFINITY)) return INFINITY;
        if ((mpf_sgn(truth) <= 0 && low > 0) || (mpf_sgn(truth) >= 0 && high < 0)) return INFINITY;
        if (!has_intercepts && !is_fan && p < 0x1p-100) continue; /* what underflows keeps its order: nothing is used */
        worst = fmax(worst, 1 + error_over(fmax(low, -FLT_MAX), size));
        worst = fmax(worst, 1 - error_over(fmin(high, FLT_MAX), size));
    }
    return worst;
}

static double attack_outline(const float *input)
{
    return outlines_over(input, 1);
}

static double attack_apex_outline(const float *input)
{
    return outlines_over(input, 0);
}

/*
 * Edge functions between these are moved so that the least of them, in either sign, is just below 0. Is the edge open
 * then (find_open_edges, cover.h)? That is so if the bounds over the hull hold.
 */
static int is_open_if_moved(int i, double least, double greatest)
{
    const float constant = leaf.edges.constant[i][0];
    int is_open = 1;
    for (int sign = -1; sign < 2; sign += 2) {
        uint32_t open[3] = {0};
        leaf.edges.constant[i][0] = next_float((float)(constant - (sign < 0 ? greatest : least)), -sign);
        find_open_edges(&bundle, &leaf, 0, 0, (sign < 0) != (leaf.state.flipped & 1), open);
        is_open &= (int)(open[i] & 1);
    }
    leaf.edges.constant[i][0] = constant;
    return is_open;
}

/* How far outside the bounds over their hull the edge functions of two rays are. */
static double cuts_over(const float *input, int has_intercepts)
{
    double worst = 0;
    if (!bundle_of(input, 2, has_intercepts)) return -1;
    set_up_triangle(input);
    const struct hull_pairs pairs = {&bundle.hulls, &leaf, 0, 0, 0, has_intercepts};
    const float bound = edge_bounds(&pairs, 2);
    for (int i = 0; i < 3; i++) {
        float least, greatest;
        double ends[2];
        bound_edge(&pairs, i, &least, &greatest);
        for (int ray = 0; ray < 2; ray++) {
            find_edge(i, ray);
            turn_as_leaf();
            set_scale(divisors[EDGE_DIVISOR(i)], tile.rays[0].pace[ray]);
            worst = fmax(worst, beyond(least, greatest, bound));
            mpf_div(value, truth, scale);
            ends[ray] = mpf_get_d(value);
        }
        if (!is_open_if_moved(i, fmin(ends[0], ends[1]), fmax(ends[0], ends[1]))) return INFINITY;
    }
    const float width = 2 * PLANE_BOUND * bundle.hulls.filter.direction_size[0];
    float least, greatest;
    bound_over_hulls(&pairs, leaf.planes.normal[0], (const float(*)[MLRT_BVH_LEAF_LIMIT])leaf.planes.normal + 1, 2,
                     &least, &greatest);
    for (int ray = 0; ray < 2; ray++) {
        find_d(ray);
        turn_as_leaf();
        set_scale(divisors[NORMAL_DIVISOR], tile.rays[0].pace[ray]);
        worst = fmax(worst, beyond(least, greatest, width));
    }
    return worst;
}

static double attack_cut(const float *input)
{
    return cuts_over(input, 1);
}

static double attack_apex_cut(const float *input)
{
    return cuts_over(input, 0);
}

/* Is the triangle left out for the packet, by where it is seen or by its edges? */
static int is_cut(int has_intercepts)
{
    struct mlrt_hull hull;
    take_hull(&bundle, 0, &hull);
    if (!(outlines_met(&bundle, &leaf, &hull, has_intercepts, 1) & 1)) return 1;
    return !(triangles_within_edges(&bundle, &leaf, 0, has_intercepts, 1) & 1);
}

/* Tests the ray against the triangle as traversal does: 1 = hit, -1 = missed, 0 = undecided. */
static int test_ray(int has_intercepts, struct bundle_vector *of, struct plane_of_rays *plane)
{
    const struct mlrt_hulls *hulls = &bundle.hulls;
    const struct plane_bounds bounds = {PLANE_BOUND * hulls->filter.direction_size[0],
                                        has_intercepts ? hulls->filter.away[0] : 0, 0};
    static struct edge_values edges;
    static const uint32_t number = 7;
    leaf.numbers = &number;
    *of = (struct bundle_vector){.nearest = {INFINITY, INFINITY, 1, 1, MLRT_NONE}};
    for (int i = 0; i < 2; i++) of->slope[i] = tile.rays[0].term[i][0];
    for (int i = 0; i < 3; i++) of->to_waist[i] = has_intercepts ? tile.rays[0].to_waist[i][0] : 0;
    find_edges(&leaf, has_intercepts, &edges);
    if (!edges.of_vector[0]) return -1;
    const float inner = edges.inner[0][0], bound = edges.bound[0];
    const vm inside = v_gt(inner, bound), may = v_ge(inner, -bound);
    const uint32_t undecided =
        test_distances(&leaf, 0, &bounds, tile.rays[0].begin, has_intercepts, may, inside, of, plane);
    return of->nearest.triangle == number ? 1 : undecided ? 0 : -1;
}

/* Decisions about a ray, also where edges, D or N hardly differ from 0. */
static double decisions_over(const float *input, int has_intercepts)
{
    struct bundle_vector of;
    struct plane_of_rays plane;
    if (!bundle_of(input, 1, has_intercepts)) return -1;
    set_up_triangle(input);
    find_n(0);
    turn_as_leaf();
    const int side = mpf_sgn(truth);
    if (!has_intercepts) {
        if (!leaf.state.doubtful && side <= 0) return INFINITY;
        mlrt_settle_signs(&tree_of_one, &bundle.waist, &leaf);
        find_n(0);
        turn_as_leaf();
        if (mpf_sgn(truth) < 0 || leaf.state.doubtful || (leaf.state.from_waist & 1) != (mpf_sgn(truth) != 0))
            return INFINITY;
        if (!leaf.state.from_waist) return 0;
    }
    const int hit = find_hit(0, 0), decision = test_ray(has_intercepts, &of, &plane);
    if ((decision > 0 && hit <= 0) || (decision < 0 && hit >= 0)) return INFINITY;
    if (hit >= 0 && is_cut(has_intercepts)) return INFINITY;
    find_d(0);
    turn_as_leaf();
    set_scale(divisors[NORMAL_DIVISOR], tile.rays[0].pace[0]);
    return 0.5 * fabs(error_over(plane.backward ? -1 : 1, 1e30)) + 0.01 / (1 + fabs(error_over(0, 1e-4)));
}

static double attack_decisions(const float *input)
{
    return decisions_over(input, 1);
}

static double attack_apex_decisions(const float *input)
{
    return decisions_over(input, 0);
}

/* Bounds of D or of N as they are kept of a hit, in units of size / |d_main| or of size. */
static double ends_over(const float *input, int is_distance, int has_intercepts)
{
    struct bundle_vector of;
    struct plane_of_rays plane;
    if (!bundle_of(input, 1, has_intercepts)) return -1;
    set_up_triangle(input);
    const struct plane_bounds bounds = {PLANE_BOUND * bundle.hulls.filter.direction_size[0],
                                        has_intercepts ? bundle.hulls.filter.away[0] : 0, 0};
    (void)test_ray(has_intercepts, &of, &plane);
    of.nearest.least_n = of.nearest.greatest_n = INFINITY;
    of.nearest.triangle = MLRT_NONE;
    test_distances(&leaf, 0, &bounds, tile.rays[0].begin, has_intercepts, 1, 0xFFFFFFFFu, &of, &plane);
    if (of.nearest.triangle == MLRT_NONE) return -1;
    if (is_distance) {
        find_n(0);
    } else {
        find_d(0);
    }
    mpf_abs(truth, truth);
    set_scale(divisors[NORMAL_DIVISOR], is_distance ? 1 : tile.rays[0].pace[0]);
    const struct nearest_hits *hit = &of.nearest;
    return fabs(is_distance ? place_between(hit->least_n, hit->greatest_n)
                            : place_between(hit->least_d, hit->greatest_d));
}

static double attack_d(const float *input)
{
    return ends_over(input, 0, 1);
}

static double attack_n(const float *input)
{
    return ends_over(input, 1, 1);
}

static double attack_apex_d(const float *input)
{
    return ends_over(input, 0, 0);
}

static double attack_apex_n(const float *input)
{
    return ends_over(input, 1, 0);
}

/*
 * A closed packet of two rays, or of one, is offered a triangle: what becomes of it must be right for both, and depths
 * must be between the ends that are kept. Of one ray these are near enough to each other to say how much of them is
 * used.
 */
static double covers_over(const float *input, int has_intercepts)
{
    static struct mlrt_worker worker;
    static const struct mlrt_job job = {.tree = &tree_of_one, .any = 0};
    struct seen_pairs of;
    double worst = 0.001;
    const int count = input[FUSED] > 0 && bits_of_float(input[FUSED]) & 1 ? 2 : 1;
    if (!bundle_of(input, count, has_intercepts)) return -1;
    set_up_triangle(input);
    if (!has_intercepts) {
        mlrt_settle_signs(&tree_of_one, &bundle.waist, &leaf);
        if (!leaf.state.from_waist) return -1;
    }
    see_pairs(&(struct hull_pairs){&bundle.hulls, &leaf, 0, 0, 1, has_intercepts}, &of);
    bound_depths(&bundle.hulls, &leaf, 0, 0, has_intercepts, &of);
    tile.packets[0].nearest.triangle[0] = MLRT_NONE;
    const uint32_t may = offer_to_packets(&job, &worker, &bundle, &leaf, 0, 1);
    const int is_covered = bundle.hulls.closed.cover[0] == 0;
    if (may && is_covered) return INFINITY;
    if (of.out && (may || is_covered)) return INFINITY;
    for (int ray = 0; ray < count; ray++) {
        const int hit = find_hit(ray, 0), of_line = find_hit(ray, 1);
        if (of.out && (has_intercepts ? of_line : hit) >= 0) return INFINITY;
        if (of.inside && of_line <= 0) return INFINITY;
        if (is_covered && hit <= 0) return INFINITY;
        if (!may && !is_covered && hit >= 0) return INFINITY;
        if (hit >= 0 && bundle.state.going && is_cut(has_intercepts)) return INFINITY;
        if (!of.sure) continue;
        find_d(ray);
        turn_as_leaf();
        if (mpf_sgn(truth) != (of.backward ? -1 : 1)) return INFINITY;
        /* The depth: o_main + |d_main| N / D. */
        mpf_set(other, truth);
        find_n(ray);
        turn_as_leaf();
        mpf_div(truth, truth, other);
        mpf_mul(truth, truth, direction[ray].x[0]);
        mpf_add(truth, truth, origin[ray].x[0]);
        set_scale(1, 1);
        if (isinf(of.near) || isinf(of.far)) continue;
        worst = fmax(worst, fabs(place_between(of.near, of.far)));
        if (is_covered && (bundle.hulls.closed.cover_near[0] != of.near || bundle.hulls.last[0] > of.far))
            return INFINITY;
        if (count > 1 || hit < 0) continue;
        /* Where the packet looks no farther, or no nearer, than that the ray still hits it. */
        const float depth = (float)mpf_get_d(truth), last = mpf_cmp_d(truth, depth) > 0 ? next_float(depth, 1) : depth;
        const float first = mpf_cmp_d(truth, depth) < 0 ? next_float(depth, -1) : depth;
        for (int end = 0; end < 2 && fabsf(depth) < FLT_MAX; end++) {
            (void)finish_bundle(has_intercepts);
            bundle.state.going = bundle.state.closed = 1;
            if (end) bundle.hulls.last[0] = last;
            if (!end) bundle.hulls.first[0] = first;
            if (!offer_to_packets(&job, &worker, &bundle, &leaf, 0, 1) && bundle.hulls.closed.cover[0] != 0)
                return INFINITY;
        }
    }
    return count == 1 ? worst : worst > 1 ? worst : 0.01;
}

static double attack_cover(const float *input)
{
    return covers_over(input, 1);
}

static double attack_apex_cover(const float *input)
{
    return covers_over(input, 0);
}

/* ---- in double --------------------------------------------------------------------------------------------------- */

/* A packet of one ray, of these inputs, and what there is of it and the triangle without rounding. It ends at t_max. */
static void load_ray_and_triangle(const float *input)
{
    static const float no_waist[3];
    const float *const origins[1] = {input + ORIGIN(0)}, *const directions[1] = {input + DIRECTION(0)};
    begin_bundle_of(no_waist, origins, directions, 1);
    tile.packets[0].t_max[0] = fabsf(input[WAIST]);
    memcpy(triangles[0].v, input, sizeof triangles[0].v);
    for (int i = 0; i < 3; i++) load_exactly(input + 3 * i, &corner[i]);
    for (int i = 0; i < 3; i++) subtract_vectors(&corner[(i + 1) % 3], &corner[i], &edge[i]);
}

/* Determinants in the signs of the given axes, where the first may have been turned round; and in a sign besides. */
static void turn_back(double sign)
{
    if ((bundle.waist.sign < 0) != (sign < 0)) mpf_neg(truth, truth);
}

/* N, and N - t_max D, of a plane (plane_sides.h: find_sides_of_plane), over their bounds. */
static double attack_apart(const float *input)
{
    struct mlrt_plane plane;
    double worst = 0;
    load_ray_and_triangle(input);
    mlrt_set_plane(&triangles[0], &plane);
    set_scale(1, 1);
    for (int at_end = 0; at_end < 2; at_end++) {
        struct measured_lanes n, height;
        measure_n(&plane, &tile.packets[0], 0, &n);
        height = n;
        if (at_end) measure_end(&plane, &tile.packets[0], tile.packets[0].t_max, 0, &n, &height);
        find_d(0);
        mpf_set_d(other, at_end ? tile.packets[0].t_max[0] : 0);
        mpf_mul(other, other, truth);
        find_n(0);
        mpf_sub(truth, truth, other);
        turn_back(1);
        worst = fmax(worst, fabs(error_over(height.value, CLOSE_ERROR * height.size)));
        for (int sign = -1; sign < 2; sign += 2) {
            const float *t = at_end ? tile.packets[0].t_max : NULL;
            const struct sides_of_plane sides = find_sides_of_plane(&plane, &tile.packets[0], t, sign, &n);
            if (sides.before & 1 && mpf_sgn(truth) * sign <= 0) return INFINITY;
            if (sides.behind & 1 && mpf_sgn(truth) * sign >= 0) return INFINITY;
        }
    }
    return worst;
}

/* N, D and the edge functions of close_calls.h over their bounds. */
static double attack_close_call(const float *input)
{
    struct close_triangle triangle;
    struct close_bounds bounds;
    double value_of[3], bound[3];
    load_ray_and_triangle(input);
    set_close_triangle(&triangles[0], &tile.packets[0], &triangle);
    bound_quotient(&triangle, &tile.packets[0], 0, &bounds);
    bound_edges(&triangle, &bounds, &tile.packets[0], 0, value_of, bound);
    const double sign = copysign(1, bounds.d);
    set_scale(1, 1);
    find_d(0);
    turn_back(sign);
    double worst = fabs(place_between(bounds.least_d, bounds.greatest_d));
    find_n(0);
    turn_back(sign);
    worst = fmax(worst, fabs(place_between(bounds.least_n, bounds.greatest_n)));
    for (int i = 0; i < 3; i++) {
        find_edge(i, 0);
        turn_back(-sign);
        worst = fmax(worst, fabs(error_over(value_of[i], bound[i])));
    }
    return worst;
}

/* ---- lines of two planes ----------------------------------------------------------------------------------------- */

/* Inputs: as of one ray, and the corners of the second triangle. */
enum { SECOND = INPUT_COUNT, INPUT_COUNT_OF_PAIR = INPUT_COUNT + 9 };
#define DIRECTION_IS_SAFE (7u << DIRECTION(0))

/* n of a triangle, and N at the waist; N and D of the ray. */
struct exact_plane {
    struct vector normal;
    mpf_t v, n, d;
};

static void find_plane(const float *corners, struct exact_plane *plane)
{
    for (int i = 0; i < 3; i++) load_exactly(corners + 3 * i, &corner[i]);
    for (int i = 0; i < 3; i++) subtract_vectors(&corner[(i + 1) % 3], &corner[i], &edge[i]);
    find_d(0);
    mpf_set(plane->d, truth);
    for (int k = 0; k < 3; k++) mpf_set(plane->normal.x[k], cross.x[k]);
    find_dot(&corner[0]);
    mpf_set(plane->v, truth);
    find_n(0);
    mpf_set(plane->n, truth);
}

/* Sets `result` to a b - c e. */
static void subtract_products(const mpf_t a, const mpf_t b, const mpf_t c, const mpf_t e, mpf_t result)
{
    mpf_mul(other, a, b);
    mpf_mul(product, c, e);
    mpf_sub(result, other, product);
}

/* Are C and g 0? */
static int are_one_plane(const struct exact_plane *first, const struct exact_plane *second)
{
    int are_one = 1;
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        subtract_products(first->v, second->normal.x[k], second->v, first->normal.x[k], truth);
        are_one &= mpf_sgn(truth) == 0;
        subtract_products(second->normal.x[i], first->normal.x[j], second->normal.x[j], first->normal.x[i], truth);
        are_one &= mpf_sgn(truth) == 0;
    }
    return are_one;
}

/* n and V of a plane in double, as plane_order.c computes them but for signs. */
static void find_plane_in_double(const float *corners, double plane[4])
{
    double to[3], ab[3], ac[3];
    for (int k = 0; k < 3; k++) {
        const int axis = (bundle.waist.main_axis + k) % 3;
        to[k] = (double)corners[axis] - bundle.waist.point[axis];
        ab[k] = (double)corners[3 + axis] - corners[axis];
        ac[k] = (double)corners[6 + axis] - corners[axis];
    }
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        plane[k] = ab[i] * ac[j] - ab[j] * ac[i];
    }
    plane[3] = to[0] * plane[0] + to[1] * plane[1] + to[2] * plane[2];
}

/*
 * S of plane_order.c, as it is computed there: F is divided by that, and the sign of what is left is all that matters.
 * S itself may differ from it by 378 u, of which the bound of F / S knows nothing where G is large.
 */
static double size_of_line(const float *first, const float *second)
{
    double p[4], q[4], size = 0, length = 0;
    find_plane_in_double(first, p);
    find_plane_in_double(second, q);
    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        size += fabs(p[3] * q[k] - q[3] * p[k]) * (k ? 0.5 : 1);
        length += fabs(q[i] * p[j] - q[j] * p[i]);
    }
    return fmax(size, 0x1p-20 * length);
}

/* F of a ray over its bound, and the sides of the line that it is said to be on. */
static double lines_over(const float *input, int has_intercepts)
{
    static struct mlrt_worker worker;
    static struct mlrt_known_plane planes[1];
    static struct mlrt_bundle_cache cache;
    static struct mlrt_triangle both[2];
    static const struct mlrt_tree tree_of_two = {.by_number.corners = both[0].v[0], .bvh.unit = 1};
    static struct exact_plane first, second;
    struct mlrt_pair_line line;
    vf bound;
    vm above, below;
    if (!worker.known.planes) {
        struct exact_plane *const exact[2] = {&first, &second};
        for (int i = 0; i < 2; i++) {
            init_vector(&exact[i]->normal);
            mpf_inits(exact[i]->v, exact[i]->n, exact[i]->d, NULL);
        }
        worker.known.planes = planes;
    }
    if (!bundle_of(input, 1, has_intercepts)) return -1;
    memcpy(both[0].v, input, sizeof both[0].v);
    memcpy(both[1].v, input + SECOND, sizeof both[1].v);
    if (!mlrt_triangle_has_area(&both[0]) || !mlrt_triangle_has_area(&both[1])) return -1;
    mlrt_forget_planes(0, &worker);
    cache.waist = bundle.waist;
    mlrt_set_pair_line(&tree_of_two, &cache, 0, 1, &worker, &line);
    find_plane(input, &first);
    find_plane(input + SECOND, &second);
    if (line.kind == MLRT_ONE_PLANE) return are_one_plane(&first, &second) ? 0.01 : INFINITY;
    if (line.kind == MLRT_NO_LINE) return -1;
    mpf_set_d(scale, size_of_line(input, input + SECOND));
    mpf_set_d(product, tile.rays[0].pace[0]);
    mpf_mul(scale, scale, product);
    subtract_products(first.n, second.d, second.n, first.d, truth);
    find_line_sides(&line, &bundle, 0, 0, &above, &below);
    const int side = mpf_sgn(truth) * mpf_sgn(second.d);
    if ((above && side <= 0) || (below && side >= 0)) return INFINITY;
    const float f = find_line_values(&line, &bundle, 0, 0, &bound);
    return fabs(error_over(f, bound));
}

static double attack_line(const float *input)
{
    return lines_over(input, 1);
}

static double attack_apex_line(const float *input)
{
    return lines_over(input, 0);
}

/*
 * Numbers of one size, of sizes 2^-4 .. 2^4, 2^-24 .. 2^24 or any, or denormal, or points of two kinds; slopes up to 2.
 */
static void draw_bundle(struct random *random, const struct bound *bound, float *input)
{
    static const int lowest[] = {0, -4, -24, -60, -148}, highest[] = {0, 4, 24, 60, -110};
    const uint32_t kind = draw_below(random, 5), second = draw_below(random, 2) ? kind : draw_below(random, 5);
    const uint32_t alike = draw_below(random, 3);
    const uint32_t points_of_kind = draw_below(random, 0x100);
    const int is_hit = draw_below(random, 2) == 0;
    float base = 1;
    for (int i = 0; i < bound->input_count; i++) {
        const uint32_t one = points_of_kind >> (i < FUSED ? i / 3 : 4 + (i - FUSED) / 3) & 1 ? kind : second;
        const float a = draw_below(random, 3) ? draw_range(random, -2, 2) : draw_below(random, 2) ? -1 : 1;
        input[i] = ldexpf(a, lowest[one] + (int)draw_below(random, (uint32_t)(highest[one] - lowest[one]) + 1));
        if (alike == 0 && draw_below(random, 2)) input[i] = next_float(base, (int)draw_below(random, 17) - 8);
        if (draw_below(random, 4) == 0) base = input[i];
    }
    if (draw_below(random, 3) == 0) { /* a corner near the waist: intercepts weigh most in edge functions */
        const float near = ldexpf(1, -(int)draw_below(random, 24));
        for (int k = 0; k < 3; k++) input[WAIST + k] = input[k] + near * draw_range(random, -1, 1) * input[3 + k];
    }
    const float main =
        fabsf(input[DIRECTION(0)]) < MLRT_SAFE_MIN ? ldexpf(input[DIRECTION(0)], 140) : input[DIRECTION(0)];
    for (int i = DIRECTION(0); i < bound->input_count; i += RAY_INPUTS) {
        const float pace = draw_below(random, 2) ? copysignf(input[i], main) : main;
        input[i] = pace;
        for (int side = 1; side < 3; side++) {
            input[i + side] = draw_below(random, 3) ? pace * draw_range(random, -2, 2) : 0;
        }
    }
    if (is_hit) { /* the first ray goes to a point of the triangle, of two rays the second to another nearby */
        float at[3];
        const float wide = draw_below(random, 3) ? ldexpf(1, -(int)draw_below(random, 20)) : 0;
        for (int i = 0; i < 3; i++) at[i] = draw_below(random, 5) ? draw_range(random, 0, 1) : 0;
        for (int i = ORIGIN(0); i < bound->input_count; i += RAY_INPUTS) {
            const float sum = at[0] + at[1] + at[2] > 0 ? at[0] + at[1] + at[2] : 1;
            for (int k = 0; k < 3; k++) {
                const float p = (at[0] * input[k] + at[1] * input[3 + k] + at[2] * input[6 + k]) / sum;
                if (i > ORIGIN(0) && draw_below(random, 2)) input[i + k] = input[ORIGIN(0) + k];
                input[i + 3 + k] = p - input[i + k];
                at[k] = fmaxf(at[k] + wide * draw_range(random, -1, 1), 0);
            }
        }
    }
    for (int i = 0; i < bound->input_count; i++) input[i] = clamp_input(input[i], (int)(bound->safe >> i & 1));
}

/* As above; of a pair the second triangle is any, or has corners of the first one's plane, a few floats off. */
static void draw_pair(struct random *random, const struct bound *bound, float *input)
{
    draw_bundle(random, bound, input);
    const uint32_t steps = draw_below(random, 5);
    const int is_near = draw_below(random, 4) != 0, is_shifted = draw_below(random, 2) == 0;
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            const float *at = input + k;
            const float a = draw_range(random, -1, 1);
            float x = at[3 * i];
            if (is_shifted) x = i == 0 ? at[0] + (at[3] - at[0]) * 0.25f : i == 1 ? at[6] : at[3] + (at[6] - at[0]);
            if (is_near) x = next_float(x, (int)draw_below(random, 2 * steps + 1) - (int)steps);
            if (!is_near) x = x * (1 + 0.5f * a);
            input[SECOND + 3 * i + k] = clamp_input(x, 0);
        }
    }
}

/* ---- ends of cells ----------------------------------------------------------------------------------------------- */

/*
 * Inputs: the corners of a triangle, the point that is subtracted from those of rays, two such points, and a number:
 * its sign says whether rays are parallel, its lowest bit whether all are multiplied by 2^67.
 */
enum { FROM = 9, POINTS = 12, KIND = 18, INPUT_COUNT_OF_ENDS = 19, END_COUNT = 2 };

/* Makes the cell of rays whose points, before the subtraction, are these two in turn. */
static void make_cell_of_ends(const float *numbers, int are_parallel, struct mlrt_array_cells *cells)
{
    enum { CELL_RAYS = 256 };
    static float points[CELL_RAYS][3];
    static struct mlrt_source source = {.width = 16, .height = 16, .count = CELL_RAYS};
    static struct mlrt_array_layout layout = {
        .data = (const unsigned char *)points, .stride = 12, .step = 12, .row_step = 16 * 12};
    for (int i = 0; i < CELL_RAYS; i++) memcpy(points[i], numbers + POINTS + 3 * (i % END_COUNT), sizeof points[i]);
    *cells = (struct mlrt_array_cells){.reader.source = &source, .area = {0, 0, 16, 16}, .vectors = &layout};
    cells->from = numbers + FROM;
    cells->are_parallel = are_parallel;
}

/* Reads the points as the cell does, and sets its box. */
static void find_ends(const struct mlrt_array_cells *cells, float ends[END_COUNT][3], struct mlrt_box *of_cell)
{
    float rows[3][MLRT_PACKET_RAYS];
    struct extremes box[3] = {NO_EXTREMES, NO_EXTREMES, NO_EXTREMES};
    read_points(cells, 0, rows);
    for (int i = 0; i < END_COUNT; i++) {
        for (int k = 0; k < 3; k++) {
            ends[i][k] = rows[k][i];
            add_to_extremes(rows[k][i], &box[k]);
        }
    }
    set_box(box, 0, of_cell);
}

/* Loads a triangle relative to the point that is subtracted, or to 0, and sets `cross` to n. */
static void load_plane(const float *corners, const float *from)
{
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            mpf_set_d(corner[i].x[k], corners[3 * i + k]);
            mpf_set_d(product, from ? from[k] : 0);
            mpf_sub(corner[i].x[k], corner[i].x[k], product);
        }
    }
    subtract_vectors(&corner[1], &corner[0], &edge[0]);
    subtract_vectors(&corner[2], &corner[0], &edge[1]);
    find_cross(&edge[0], &edge[1]);
}

/* Sets `truth` to n . (a - end) of the plane that was loaded last. */
static void find_number_of_end(const float *end)
{
    for (int k = 0; k < 3; k++) {
        mpf_set_d(product, end[k]);
        mpf_sub(seen.x[k], corner[0].x[k], product);
    }
    find_dot(&seen);
}

/* Sets `truth` to the least number, in a plane's sign, of points of a box. The plane was loaded last. */
static void find_least_of_box(const struct mlrt_box *box, double sign)
{
    find_dot(&corner[0]); /* p */
    if (sign < 0) mpf_neg(truth, truth);
    for (int k = 0; k < 3; k++) { /* the end of the box that makes - n . e the least */
        mpf_set(value, cross.x[k]);
        if (sign < 0) mpf_neg(value, value);
        mpf_set_d(other, mpf_sgn(value) > 0 ? box->hi[k] : box->lo[k]);
        mpf_mul(value, value, other);
        mpf_sub(truth, truth, value);
    }
}

/*
 * By how much a box is nearer to its side of a plane than it is computed to be. What is said must be true of all
 * points.
 */
static double attack_ends(const float *input)
{
    static float numbers[INPUT_LIMIT], ends[END_COUNT][3];
    struct mlrt_array_cells cells;
    struct mlrt_box box;
    struct mlrt_plane_of_cells of;
    struct mlrt_triangle triangle;
    double worst = 0;
    const int are_large = (int)(bits_of_float(input[KIND]) & 1);
    for (int i = 0; i < KIND; i++) {
        numbers[i] = fmaxf(fminf(are_large ? input[i] * 0x1p67f : input[i], FLT_MAX), -FLT_MAX);
    }
    make_cell_of_ends(numbers, input[KIND] < 0, &cells);
    find_ends(&cells, ends, &box);
    for (int i = 0; i < END_COUNT; i++) {
        for (int k = 0; k < 3; k++) {
            if (!isfinite(ends[i][k])) return -1;
        }
    }
    memcpy(triangle.v, numbers, sizeof triangle.v);
    mlrt_see_plane_of_cells(&cells, &triangle, &of);
    set_scale(1, 1);
    load_plane(numbers, cells.are_parallel ? NULL : cells.from);
    for (int sign = -1; sign < 2; sign += 2) {
        of.sign = sign;
        const struct mlrt_side_of_box side = mlrt_find_side_of_box(&box, &of);
        if (side.error > 0) {
            find_least_of_box(&box, sign);
            worst = fmax(worst, error_over(side.nearest, side.error));
        }
        for (int i = 0; mlrt_is_box_apart(&box, &of) && i < END_COUNT; i++) {
            find_number_of_end(ends[i]);
            if (mpf_sgn(truth) * sign <= 0) return INFINITY;
        }
    }
    return worst;
}

/* Two planes as of a pair; the points are any, or points of either triangle, a few floats off. */
static void draw_ends(struct random *random, const struct bound *bound, float *input)
{
    float pair[INPUT_LIMIT];
    const struct bound bound_of_pair = {.input_count = INPUT_COUNT_OF_PAIR};
    (void)bound;
    draw_pair(random, &bound_of_pair, pair);
    memcpy(input, pair, 9 * sizeof *input);
    memcpy(input + FROM, pair + WAIST, 3 * sizeof *input);
    const int is_near = draw_below(random, 4) != 0, is_from_near = draw_below(random, 3) == 0;
    const float *at = draw_below(random, 2) ? pair + SECOND : pair;
    for (int i = 0; i < END_COUNT; i++) {
        float weight[3];
        for (int j = 0; j < 3; j++) weight[j] = draw_below(random, 5) ? draw_range(random, 0, 1) : 0;
        const float sum = weight[0] + weight[1] + weight[2] > 0 ? weight[0] + weight[1] + weight[2] : 1;
        for (int k = 0; k < 3; k++) {
            const float p = (weight[0] * at[k] + weight[1] * at[3 + k] + weight[2] * at[6 + k]) / sum;
            input[POINTS + 3 * i + k] = is_near ? next_float(p, (int)draw_below(random, 5) - 2) : pair[RAY + 3 * i + k];
        }
    }
    for (int k = 0; is_from_near && k < 3; k++)
        input[FROM + k] = next_float(input[POINTS + k], (int)draw_below(random, 99));
    input[KIND] = float_of_bits(bits_of_float(draw_below(random, 2) ? 1 : -1) | draw_below(random, 2));
    for (int i = 0; i < KIND; i++) input[i] = clamp_input(input[i], 0);
}

static void bounds_of_ends_hold(void **state)
{
    static const struct bound ends = {"cells: ends", INPUT_COUNT_OF_ENDS, 0, attack_ends, 0.5, NULL};
    (void)state;
    attack_bound(&ends, draw_ends, 12, STEP_COUNT);
}

static void bounds_of_lines_hold(void **state)
{
    static const struct bound bounds[] = {
        {"bundles: line of two planes", INPUT_COUNT_OF_PAIR, DIRECTION_IS_SAFE, attack_line, 0.25, NULL},
        {"from the waist: line of two planes", INPUT_COUNT_OF_PAIR, DIRECTION_IS_SAFE, attack_apex_line, 0.2, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof bounds / sizeof *bounds; i++) attack_bound(&bounds[i], draw_pair, 6, STEP_COUNT);
}

static void bounds_in_double_hold(void **state)
{
    static const struct bound bounds[] = {
        {"close calls: N, D, edge functions", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_close_call, 0.4, NULL},
        {"close calls: N - t D", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_apart, 0.5, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof bounds / sizeof *bounds; i++) attack_bound(&bounds[i], draw_bundle, 6, STEP_COUNT);
}

static void bounds_of_bundles_hold(void **state)
{
    static const struct bound bounds[] = {
        {"bundles: intercept", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_intercept, 0.35, NULL},
        {"bundles: hull", INPUT_COUNT_OF_TWO, DIRECTIONS_ARE_SAFE, attack_hull, 0.2, NULL},
        {"bundles: box", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_box, 0.2, NULL},
        {"bundles: boxes that are met", INPUT_COUNT_OF_TWO, DIRECTIONS_ARE_SAFE, attack_box_met, 0, NULL},
        {"bundles: outline", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_outline, 0.2, NULL},
        {"bundles: edge function", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_edge, 0.4, NULL},
        {"bundles: e, D over a hull", INPUT_COUNT_OF_TWO, DIRECTIONS_ARE_SAFE, attack_cut, 0.1, NULL},
        {"bundles: D", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_d, 0.35, NULL},
        {"bundles: N", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_n, 0.35, NULL},
        {"bundles: decisions", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_decisions, 0, NULL},
        {"bundles: covers", INPUT_COUNT_OF_TWO, DIRECTIONS_ARE_SAFE, attack_cover, 0.1, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof bounds / sizeof *bounds; i++) attack_bound(&bounds[i], draw_bundle, 6, STEP_COUNT);
}

/* Rays that all begin at the waist: no intercepts, and a triangle's terms have the sign of N there. */
static void bounds_from_the_waist_hold(void **state)
{
    static const struct bound bounds[] = {
        {"from the waist: boxes that are met", INPUT_COUNT_OF_TWO, DIRECTIONS_ARE_SAFE, attack_apex_box_met, 0, NULL},
        {"from the waist: outline", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_apex_outline, 0.2, NULL},
        {"from the waist: edge function", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_apex_edge, 0.4, NULL},
        {"from the waist: e, D over a hull", INPUT_COUNT_OF_TWO, DIRECTIONS_ARE_SAFE, attack_apex_cut, 0.1, NULL},
        {"from the waist: D", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_apex_d, 0.3, NULL},
        {"from the waist: N", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_apex_n, 0.3, NULL},
        {"from the waist: decisions", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_apex_decisions, 0, NULL},
        {"from the waist: covers", INPUT_COUNT_OF_TWO, DIRECTIONS_ARE_SAFE, attack_apex_cover, 0.1, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof bounds / sizeof *bounds; i++) attack_bound(&bounds[i], draw_bundle, 6, STEP_COUNT);
}

static void depths_hold(void **state)
{
    static const struct bound depths = {"bundles: depths", 5, 1u << 2, attack_depths, 0.1, NULL};
    (void)state;
    attack_bound(&depths, draw_depths, 12, STEP_COUNT);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slopes_may_underflow),
        cmocka_unit_test(depths_may_underflow),
        cmocka_unit_test(depths_of_few_rays_may_underflow),
        cmocka_unit_test(places_may_underflow),
        cmocka_unit_test(reciprocals_may_overflow),
        cmocka_unit_test(slopes_of_triangles_may_overflow),
        cmocka_unit_test(one_waist_has_many_slopes),
        cmocka_unit_test(bounds_of_bundles_hold),
        cmocka_unit_test(bounds_from_the_waist_hold),
        cmocka_unit_test(depths_hold),
        cmocka_unit_test(bounds_of_lines_hold),
        cmocka_unit_test(bounds_of_ends_hold),
        cmocka_unit_test(bounds_in_double_hold),
    };
    if (argc > 1 && atoi(argv[1]) > 0) search_effort = (size_t)atoi(argv[1]);
    init_numbers();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
