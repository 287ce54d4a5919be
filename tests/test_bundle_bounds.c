/* SPDX-License-Identifier: MIT */
/*
 * Bundles whose numbers are near the ends of what floats are: places and depths that are denormal, directions of which
 * a component is tiny, whose slopes or reciprocals float does not carry. Every way of tracing against the reference.
 *
 * And searches for the ray and triangle whose place, edge function, D or N comes closest to its bound
 * (docs/accuracy.md, "Bundles"), as in test_bounds.c. `test_bundle_bounds 100` searches 100 times as long.
 */
#include <gmp.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "search.h"

/* The kernels, one lane wide; they multiply and add with one rounding or two. */
#include "kernels/simd_scalar.h"

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

#define v_mul_add multiply_add
#define v_mul_sub multiply_subtract
#define v_div     remembering_divide
#define KERNELS   bundle_bounds_kernels
#define PICTURE   bundle_bounds_picture
#include "kernels/bvh_body.h"
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
    for (uint64_t seed = 0; seed < scaled(24); seed++) {
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
 * Origins 2^-131 from the waist, and a triangle four to five times 2^-149 beside it: roundings of a place there, and of
 * a slope times a depth, make more than 2^-149 together, and PLACE_ERROR R A is less than that. The first tile starts
 * at 0 and so sets the waist, which the second one keeps. In that each packet has one ray, sixteen times; that of
 * packet 5 says which axis is the main one.
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
    check("places that underflow", 0, &soup, &list);
}

/*
 * Directions of 2^-60 with a component of 2^-130, whose reciprocal is infinite, but not the t of what it leads to. One
 * packet is far wider than the others and so goes lane by lane.
 */
static void reciprocals_may_overflow(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < scaled(24); seed++) {
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

/* ---- searches ---------------------------------------------------------------------------------------------------- */

/* Inputs: three corners, the waist, an origin, a number whose sign says whether products are fused, and a direction, of
 * two rays two. */
enum { WAIST = 9, ORIGIN = 12, FUSED = 15, DIRECTION = 16, INPUT_COUNT = 19, INPUT_COUNT_OF_TWO = 22 };
#define DIRECTIONS_ARE_SAFE 0x3F0000u

static struct mlrt_ray_tile tile;
static struct mlrt_bundle bundle;
static struct mlrt_bundle_leaf leaf;

/* Numbers without rounding: of these inputs none has more than 800 bits. */
#define EXACT_BITS 1280

struct vector {
    mpf_t x[3];
};

static mpf_t product, truth, value, scale;
static struct vector corner[3], edge[3], origin, direction, cross; /* by axis of the bundle, relative to the waist */

static void init_vector(struct vector *a)
{
    for (int k = 0; k < 3; k++) mpf_init2(a->x[k], EXACT_BITS);
}

static void init_numbers(void)
{
    mpf_set_default_prec(EXACT_BITS);
    mpf_inits(product, truth, value, scale, NULL);
    for (int i = 0; i < 3; i++) {
        init_vector(&corner[i]);
        init_vector(&edge[i]);
    }
    init_vector(&origin);
    init_vector(&direction);
    init_vector(&cross);
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

/* Makes a bundle of rays from one origin, and the hull of their packet. Returns whether float carries them. */
static int bundle_rays(const float *input, int count)
{
    struct mlrt_packet *packet = &tile.packets[0];
    is_fused = input[FUSED] < 0;
    bundle.tile = &tile;
    bundle.going = 1;
    bundle.unit = 1;
    bundle.has_places = 1;
    bundle.waist.main_axis = 0;
    bundle.waist.sign = input[DIRECTION] < 0 ? -1.0f : 1.0f;
    memcpy(bundle.waist.point, input + WAIST, sizeof bundle.waist.point);
    packet->active = (1u << count) - 1;
    for (int lane = 0; lane < count; lane++) {
        packet->t_max[lane] = INFINITY;
        for (int k = 0; k < 3; k++) {
            packet->origin[k][lane] = input[ORIGIN + k];
            packet->direction[k][lane] = input[DIRECTION + 3 * lane + k];
        }
    }
    if ((set_bundle_rays(&bundle, 0) & packet->active) != packet->active) return 0;
    finish_hulls(&bundle, 0);
    load_exactly(input + ORIGIN, &origin);
    return 1;
}

static void load_direction(const float *input, int lane)
{
    const float *from = input + DIRECTION + 3 * lane;
    for (int k = 0; k < 3; k++) mpf_set_d(direction.x[k], k ? from[k] : fabsf(from[0]));
}

static void set_up_triangle(const float *input)
{
    struct bundle_corners corners;
    load_bundle_corners(&bundle.waist, input, 1, 0, &corners);
    divisor_count = 0;
    set_up_bundle_vector(&corners, 0, &leaf); /* divisors: of edges ab, bc, ca, of n */
    for (int i = 0; i < 3; i++) load_exactly(input + 3 * i, &corner[i]);
    for (int i = 0; i < 3; i++) subtract_vectors(&corner[(i + 1) % 3], &corner[i], &edge[i]);
}

/* In units of 1 / |d_main|. */
static double attack_place(const float *input)
{
    double worst = 0;
    if (!bundle_rays(input, 1)) return -1;
    load_direction(input, 0);
    const float bound = PLACE_ERROR * (bundle.hulls.reach[0] * bundle.hulls.away[0]) + PLACE_FLOOR;
    set_scale(bundle.rays[0].pace[0], 1);
    for (int side = 0; side < 2; side++) {
        mpf_mul(truth, origin.x[1 + side], direction.x[0]);
        mpf_mul(product, origin.x[0], direction.x[1 + side]);
        mpf_sub(truth, truth, product);
        worst = fmax(worst, fabs(error_over(bundle.rays[0].term[MLRT_PLACE_J + side][0], bound)));
    }
    return worst;
}

/* In units of size / |d_main|. An edge is put in the place of the others, since only the least of all three is kept. */
static double attack_edge(const float *input)
{
    double worst = 0;
    float term[MLRT_RAY_TERMS];
    if (!bundle_rays(input, 1)) return -1;
    load_direction(input, 0);
    set_up_triangle(input);
    const float bound = edge_bounds(&bundle.hulls, 0, leaf.steepness[0], 1);
    for (int i = 0; i < MLRT_RAY_TERMS; i++) term[i] = bundle.rays[0].term[i][0];
    for (int i = 0; i < 3; i++) {
        struct edge_values found;
        struct mlrt_bundle_leaf one = leaf;
        for (int j = 0; j < 3; j++) {
            one.edge_constant[j][0] = leaf.edge_constant[i][0];
            memcpy(one.edge[j], leaf.edge[i], sizeof one.edge[j]);
        }
        find_edge_values(&one, 0, term, MLRT_RAY_TERMS, bound, &found);
        subtract_vectors(&corner[i], &origin, &corner[i]);
        find_cross(&corner[i], &edge[i]);
        find_dot(&direction);
        set_scale(divisors[i], bundle.rays[0].pace[0]);
        worst = fmax(worst, fabs(error_over(found.least, bound)));
    }
    return worst;
}

/*
 * How much of what hulls are moved apart by is used up where a ray is at the depth of a point. A corner of a box has
 * one rounding of its own, for which a sixteenth of that is left.
 */
static double attack_box(const float *input)
{
    double worst = 0;
    if (!bundle_rays(input, 1)) return -1;
    const struct mlrt_hulls *hulls = &bundle.hulls;
    const float depth = (input[0] - input[WAIST]) * bundle.waist.sign;
    const float place_bound = PLACE_ERROR * (hulls->reach[0] * hulls->away[0]) + PLACE_FLOOR;
    load_direction(input, 0);
    load_exactly(input, &corner[0]);
    set_scale(bundle.rays[0].pace[0], 1);
    mpf_sub(corner[0].x[0], corner[0].x[0], origin.x[0]);
    for (int i = 0; i < 2; i++) {
        const double place = bundle.rays[0].term[MLRT_PLACE_J + i][0], slope = bundle.rays[0].term[MLRT_SLOPE_J + i][0];
        const double moved = (fabs(place) + fabs(slope * depth)) * SLOPE_SLACK + place_bound + HULL_FLOOR;
        const float upper =
            upper_place(depth, depth, hulls->slope[i].lo[0], hulls->slope[i].hi[0], hulls->place[i].hi[0], 1);
        const float lower =
            lower_place(depth, depth, hulls->slope[i].lo[0], hulls->slope[i].hi[0], hulls->place[i].lo[0], 1);
        mpf_mul(truth, origin.x[1 + i], direction.x[0]);
        mpf_mul(product, direction.x[1 + i], corner[0].x[0]);
        mpf_add(truth, truth, product);
        const double used = fmax(-error_over(upper - moved, moved), error_over(lower + moved, moved));
        worst = fmax(worst, used * 16 / 15);
    }
    return worst;
}

/* How far outside the bounds over their hull the edge functions of two rays are. */
static double attack_cut(const float *input)
{
    double worst = 0;
    if (!bundle_rays(input, 2)) return -1;
    set_up_triangle(input);
    const float bound = 2 * edge_bounds(&bundle.hulls, 0, leaf.steepness[0], 1);
    for (int i = 0; i < 3; i++) {
        float least, greatest;
        bound_over_hull(&bundle.hulls, 0, leaf.edge_constant[i], (const float(*)[MLRT_BVH_LEAF_LIMIT])leaf.edge[i][0],
                        MLRT_RAY_TERMS, &least, &greatest);
        subtract_vectors(&corner[i], &origin, &corner[i]);
        find_cross(&corner[i], &edge[i]);
        for (int lane = 0; lane < 2; lane++) {
            load_direction(input, lane);
            find_dot(&direction);
            set_scale(divisors[i], bundle.rays[0].pace[lane]);
            worst = fmax(worst, fmax(error_over(least, bound), -error_over(greatest, bound)));
        }
    }
    return worst;
}

/* Bounds of D or of N as they are kept of a hit, in units of size / |d_main| or of size. */
static double attack_ends(const float *input, int is_distance)
{
    if (!bundle_rays(input, 1)) return -1;
    load_direction(input, 0);
    set_up_triangle(input);
    const struct plane_bounds bounds = {PLANE_BOUND * bundle.hulls.reach[0], bundle.hulls.away[0], 0};
    const uint32_t number = 7;
    struct bundle_vector of = {.least_n = INFINITY, .greatest_n = INFINITY, .least_d = 1, .greatest_d = 1};
    leaf.numbers = &number;
    struct plane_of_rays plane;
    of.triangle = MLRT_NONE;
    for (int i = 0; i < 2; i++) of.slope[i] = bundle.rays[0].term[i][0];
    for (int i = 0; i < 3; i++) of.to_waist[i] = bundle.rays[0].to_waist[i][0];
    test_distances(&leaf, 0, &bounds, bundle.rays[0].begin, 1, 0xFFFFFFFFu, 0xFFFFFFFFu, &of, &plane);
    if (of.triangle != number) return -1;
    find_cross(&edge[2], &edge[0]); /* (a - c) x (b - a) */
    if (is_distance) subtract_vectors(&corner[0], &origin, &corner[0]);
    find_dot(is_distance ? &corner[0] : &direction);
    mpf_abs(truth, truth);
    set_scale(divisors[3], is_distance ? 1 : bundle.rays[0].pace[0]);
    return fabs(is_distance ? place_between(of.least_n, of.greatest_n) : place_between(of.least_d, of.greatest_d));
}

static double attack_d(const float *input)
{
    return attack_ends(input, 0);
}

static double attack_n(const float *input)
{
    return attack_ends(input, 1);
}

/* Numbers of one size, of sizes 2^-4 .. 2^4, 2^-24 .. 2^24 or any, or denormal, or points of two kinds; slopes up to 2.
 */
static void draw_bundle(struct random *random, const struct bound *bound, float *input)
{
    static const int lowest[] = {0, -4, -24, -60, -148}, highest[] = {0, 4, 24, 60, -110};
    const uint32_t kind = draw_below(random, 5), other = draw_below(random, 2) ? kind : draw_below(random, 5);
    const uint32_t alike = draw_below(random, 3);
    const uint32_t points_of_kind = draw_below(random, 0x80);
    float base = 1;
    for (int i = 0; i < bound->input_count; i++) {
        const uint32_t one = points_of_kind >> i / 3 & 1 ? kind : other;
        const float a = draw_below(random, 3) ? draw_range(random, -2, 2) : draw_below(random, 2) ? -1 : 1;
        input[i] = ldexpf(a, lowest[one] + (int)draw_below(random, (uint32_t)(highest[one] - lowest[one]) + 1));
        if (alike == 0 && draw_below(random, 2)) input[i] = next_float(base, (int)draw_below(random, 17) - 8);
        if (draw_below(random, 4) == 0) base = input[i];
    }
    if (draw_below(random, 3) == 0) { /* a corner near the waist: places weigh most in edge functions */
        const float near = ldexpf(1, -(int)draw_below(random, 24));
        for (int k = 0; k < 3; k++) input[WAIST + k] = input[k] + near * draw_range(random, -1, 1) * input[3 + k];
    }
    if (fabsf(input[DIRECTION]) < MLRT_SAFE_MIN) input[DIRECTION] = ldexpf(input[DIRECTION], 140);
    for (int i = DIRECTION; i < bound->input_count; i += 3) {
        const float main = input[DIRECTION], pace = draw_below(random, 2) ? copysignf(input[i], main) : main;
        input[i] = pace;
        for (int side = 1; side < 3; side++) {
            input[i + side] = draw_below(random, 3) ? pace * draw_range(random, -2, 2) : 0;
        }
    }
    for (int i = 0; i < bound->input_count; i++) input[i] = clamp_input(input[i], (int)(bound->safe >> i & 1));
}

static void bounds_of_bundles_hold(void **state)
{
    static const struct bound bounds[] = {
        {"bundles: place", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_place, 0.5, NULL},
        {"bundles: box", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_box, 0.2, NULL},
        {"bundles: edge function", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_edge, 0.4, NULL},
        {"bundles: edge function over a hull", INPUT_COUNT_OF_TWO, DIRECTIONS_ARE_SAFE, attack_cut, 0.1, NULL},
        {"bundles: D", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_d, 0.35, NULL},
        {"bundles: N", INPUT_COUNT, DIRECTIONS_ARE_SAFE, attack_n, 0.35, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof bounds / sizeof *bounds; i++) attack_bound(&bounds[i], draw_bundle, 10, STEP_COUNT);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slopes_may_underflow),
        cmocka_unit_test(depths_may_underflow),
        cmocka_unit_test(depths_of_few_rays_may_underflow),
        cmocka_unit_test(places_may_underflow),
        cmocka_unit_test(reciprocals_may_overflow),
        cmocka_unit_test(bounds_of_bundles_hold),
    };
    if (argc > 1 && atoi(argv[1]) > 0) search_effort = (size_t)atoi(argv[1]);
    init_numbers();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
