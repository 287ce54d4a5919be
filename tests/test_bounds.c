/* SPDX-License-Identifier: MIT */
/*
 * The bounds of docs/accuracy.md, attacked: for each, a search for the input whose error comes closest to the
 * bound. Random inputs of several kinds (near 1, spread exponents, near the limits 2^-60 and 2^60, so small that
 * products underflow, nearly equal), then hill climbing on mantissas, exponents and signs. True values are GMP floats
 * with more bits than any of these numbers needs.
 *
 *     test_bounds        about eight seconds
 *     test_bounds 100    100 times the search
 *
 * A line per bound: the largest error found, over the bound. Above 1 the test fails.
 *
 * The kernels are included, one lane wide, and so are the files whose inner functions are needed.
 */
#include "search.h"

#include <gmp.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rays/camera.c"
#include "mlrta/beam.c"
#include "mlrta/entry_point.c"
#include "scene/clip.c"
#include "mlrta/ray.c"

#include "simd/scalar.h"

/* What the filter divided by: the sizes that its terms are scaled by, which true values must be scaled by too. */
static int divisor_count;
static float divisors[16];
static f4 last_divisors;

static float remembering_divide(float a, float b)
{
    divisors[divisor_count++ % 16] = b;
    return v_div(a, b);
}

static f4 remembering_divide_four(f4 a, f4 b)
{
    last_divisors = b;
    return f4_div(a, b);
}

#define v_div          remembering_divide
#define f4_div         remembering_divide_four
#define BOX_KERNELS    bounds_kernels
#define KDTREE_KERNELS bounds_kernels_kdtree
#include "isa/kernels.h"
#undef v_div
#undef f4_div

#include "exact/quotients.c"

/* ---- numbers without rounding ------------------------------------------------------------------------------------ */

/* Determinants take under 900 bits. Quotients are rounded, but later than anything here can see. */
#define EXACT_BITS 1280

struct point {
    mpf_t x[3];
};

static mpf_t scratch[4]; /* of the functions in this section */
static mpf_t truth, other_truth, difference;
static struct point true_vertex[3], true_edge[2], true_cross, true_direction;

static void init_point(struct point *point)
{
    for (int k = 0; k < 3; ++k) mpf_init(point->x[k]);
}

static void init_numbers(void)
{
    mpf_set_default_prec(EXACT_BITS);
    for (int i = 0; i < 4; ++i) mpf_init(scratch[i]);
    mpf_inits(truth, other_truth, difference, NULL);
    for (int i = 0; i < 3; ++i) init_point(&true_vertex[i]);
    for (int i = 0; i < 2; ++i) init_point(&true_edge[i]);
    init_point(&true_cross);
    init_point(&true_direction);
}

static void subtract_exactly(double a, double b, mpf_t result)
{
    mpf_set_d(result, a);
    mpf_set_d(scratch[0], b);
    mpf_sub(result, result, scratch[0]);
}

static void cross_exactly(const struct point *a, const struct point *b, struct point *result)
{
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        mpf_mul(scratch[1], a->x[i], b->x[j]);
        mpf_mul(scratch[2], a->x[j], b->x[i]);
        mpf_sub(result->x[k], scratch[1], scratch[2]);
    }
}

static void dot_exactly(const struct point *a, const struct point *b, mpf_t result)
{
    mpf_mul(result, a->x[0], b->x[0]);
    for (int k = 1; k < 3; ++k) {
        mpf_mul(scratch[1], a->x[k], b->x[k]);
        mpf_add(result, result, scratch[1]);
    }
}

/* |a| / bound; where there is an error, a bound of 0 is infinitely wrong. */
static double over(const mpf_t a, double bound)
{
    long exponent;
    int bound_exponent;
    if (mpf_sgn(a) == 0) return 0;
    if (!(bound > 0)) return INFINITY;
    const double top = fabs(mpf_get_d_2exp(&exponent, a)), bottom = frexp(bound, &bound_exponent);
    return ldexp(top / bottom, (int)exponent - bound_exponent);
}

/* |a - value| / bound */
static double error_over(const mpf_t a, double value, double bound)
{
    mpf_set_d(scratch[0], value);
    mpf_sub(difference, a, scratch[0]);
    return over(difference, bound);
}

/* How far from the middle of [lo, hi] a number is; 1 = at an end. */
static double place_in(const mpf_t a, double lo, double hi)
{
    mpf_set_d(scratch[0], lo);
    mpf_set_d(scratch[1], hi);
    mpf_add(scratch[2], scratch[0], scratch[1]);
    mpf_div_ui(scratch[2], scratch[2], 2);
    mpf_sub(difference, a, scratch[2]);
    mpf_sub(scratch[1], scratch[1], scratch[0]);
    mpf_div_ui(scratch[1], scratch[1], 2);
    return over(difference, mpf_get_d(scratch[1]));
}

/* What rounding took of a bound that is |a| moved by `slack` of itself: 0 = nothing, 1 = all. `is_upper`: moved up. */
static double slack_used(const mpf_t a, double bound, double slack, int is_upper)
{
    mpf_set_d(scratch[0], bound);
    mpf_sub(difference, scratch[0], a);
    if (!is_upper) mpf_neg(difference, difference);
    mpf_abs(scratch[1], a);
    mpf_div(difference, difference, scratch[1]);
    return 1 - mpf_get_d(difference) / slack;
}

static int is_normal(const mpf_t a)
{
    long exponent;
    (void)mpf_get_d_2exp(&exponent, a);
    return mpf_sgn(a) != 0 && exponent > -125 && exponent < 128;
}

/* ---- the search -------------------------------------------------------------------------------------------------- */

enum kind { NEAR_ONE, SPREAD, ANY_SAFE, TINY, NEARLY_EQUAL, AT_LIMITS, MIDWAY, AIMED, FAST, KIND_COUNT };

static float draw_input(struct random *random, enum kind kind, int is_safe, float base)
{
    static const int steps[] = {0, 0, 0, -1, 1, -12, -24};
    static const int limits[] = {-149, -126, -61, -60, -59, 0, 59, 60};
    const uint32_t pattern = draw_below(random, 3);
    float a = pattern == 0 ? 1 : pattern == 1 ? 1 + (float)draw_below(random, 8) * 0x1p-23f : draw_range(random, 1, 2);
    if (draw_below(random, 2)) a = -a;
    switch (kind) {
    case NEAR_ONE:
        return draw_below(random, 6) ? a : 0;
    case SPREAD:
        return ldexpf(a, steps[draw_below(random, 7)]);
    case ANY_SAFE:
        return ldexpf(a, (int)draw_below(random, 121) - 60);
    case TINY:
        if (is_safe) return draw_below(random, 3) ? ldexpf(a, (int)draw_below(random, 3) * 60 - 60) : 0;
        return ldexpf(a, -(int)draw_below(random, 50) - 50);
    case AT_LIMITS:
        return ldexpf(a, limits[draw_below(random, 8)]);
    default:
        return next_float(base, (int)draw_below(random, 17) - 8);
    }
}

static void draw_inputs(struct random *random, const struct bound *bound, float *input)
{
    const enum kind kind = (enum kind)draw_below(random, KIND_COUNT), first = (enum kind)draw_below(random, 4);
    const int mixed = draw_below(random, 3) == 0;
    float base = draw_input(random, first, 0, 0);
    for (int i = 0; i < bound->input_count; ++i) {
        const enum kind one = mixed ? (enum kind)draw_below(random, KIND_COUNT) : kind;
        const int is_safe = (int)(bound->safe >> i & 1);
        if (draw_below(random, 8) == 0) base = draw_input(random, first, is_safe, 0);
        input[i] = draw_input(random, one >= MIDWAY ? first : one, is_safe, base);
    }
    /* Of a triangle and a ray: the origin in the middle of an edge, where a + b cancels. */
    if (kind == MIDWAY && bound->input_count >= 14) {
        for (int k = 0; k < 3; ++k) input[9 + k] = 0.5f * input[k] + 0.5f * input[3 + k];
    }
    /* The ray towards an edge, or along the plane. */
    if (kind == AIMED && bound->input_count >= 15) {
        const float x = draw_range(random, 0, 1), y = draw_range(random, -1, 1);
        const int is_along = (int)draw_below(random, 2);
        for (int k = 0; k < 3; ++k) {
            const float *v = input + k;
            input[12 + k] = is_along ? x * (v[3] - v[0]) + y * (v[6] - v[0]) : v[0] + x * (v[3] - v[0]) - v[9];
        }
    }
    /* From 0 so fast through a plane so near that t underflows. */
    if (kind == FAST && bound->input_count >= 14) {
        for (int k = 0; k < 3; ++k) {
            input[k] = draw_input(random, TINY, 0, 0);
            input[9 + k] = 0;
            if (12 + k < bound->input_count) input[12 + k] = ldexpf(input[12 + k], 60);
        }
    }
    for (int i = 0; i < bound->input_count; ++i) input[i] = clamp_input(input[i], (int)(bound->safe >> i & 1));
}

static void attack(const struct bound *bound, size_t climb_count)
{
    attack_bound(bound, draw_inputs, climb_count, STEP_COUNT);
}

/* ---- triangles and rays ------------------------------------------------------------------------------------------ */

/* Inputs: the corners a, b, c, the origin, the direction. */
#define TRIANGLE_AND_RAY 15
#define RAY_IS_SAFE      0x7E00u
#define ORIGIN_IS_SAFE   0x0E00u

static void load_triangle(const float *input, struct mlrt_triangle *triangle)
{
    memcpy(triangle->v, input, sizeof triangle->v);
}

static void load_exactly(const float *input, const double direction[3])
{
    for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i) subtract_exactly(input[3 * i + k], input[9 + k], true_vertex[i].x[k]);
        for (int i = 0; i < 2; ++i) subtract_exactly(input[3 * i + 3 + k], input[k], true_edge[i].x[k]);
        mpf_set_d(true_direction.x[k], direction[k]);
    }
}

/* e_ij */
static void find_edge(int i, mpf_t result)
{
    cross_exactly(&true_vertex[i], &true_vertex[(i + 1) % 3], &true_cross);
    dot_exactly(&true_direction, &true_cross, result);
}

/* D and N */
static void find_d_and_n(mpf_t d, mpf_t n)
{
    cross_exactly(&true_edge[0], &true_edge[1], &true_cross);
    dot_exactly(&true_direction, &true_cross, d);
    dot_exactly(&true_vertex[0], &true_cross, n);
}

/* ---- the float filter -------------------------------------------------------------------------------------------- */

/*
 * A 16th input says which axis counts as the main one: each of the three must do, also one that rays hardly go along.
 */
#define FILTER_INPUTS 16

/* What the filter works out, and by what it has scaled it. */
struct filtered {
    struct triangle_terms terms;
    float size[4];
    float direction_size; /* R */
    float direction[3];
};

static void choose_axis(const float *input, struct ray_group *group)
{
    const uint32_t choice = bits_of(input[15]) % 8;
    memset(group, 0, sizeof *group);
    for (int k = 0; k < 3; ++k) group->axis[k].largest = fabsf(input[12 + k]);
    set_main_axis(group);
    if (choice > 2) return;
    const float others = fmaxf(group->axis[(choice + 1) % 3].largest, group->axis[(choice + 2) % 3].largest);
    group->axis_code = choice;
    group->direction_size = fmaxf(group->axis[choice].largest, 2 * others);
}

/* Both ways to the terms: of rays with different origins, and of rays with a common one. */
static void find_terms(const float *input, int shared, struct filtered *filtered)
{
    struct mlrt_triangle triangle;
    struct ray_group group;
    load_triangle(input, &triangle);
    choose_axis(input, &group);
    filtered->direction_size = group.direction_size;
    memcpy(filtered->direction, input + 12, sizeof filtered->direction);
    if (shared) {
        struct mlrt_triangle_setup setup = {.axis_code = group.axis_code};
        set_up_terms(&triangle, input + 9, &setup);
        set_apex_terms(&setup, &filtered->terms);
        memcpy(filtered->size, last_divisors.x, sizeof filtered->size);
    } else {
        divisor_count = 0;
        set_terms(&triangle, input + 9, group.axis_code & 3, &filtered->terms);
        for (int i = 0; i < 4; ++i) filtered->size[i] = divisors[i * divisor_count / 4];
    }
    for (int i = 0; i < 4; ++i) {
        const float *cross = filtered->terms.cross[i];
        assert_true(isfinite(cross[0]) && isfinite(cross[1]) && isfinite(cross[2])); /* v_min would drop a NaN */
        assert_true(filtered->size[i] > 0 && isfinite(filtered->size[i]));
    }
}

static void load_direction(const float *input, double direction[3])
{
    for (int k = 0; k < 3; ++k) direction[k] = input[12 + k];
}

static int has_direction(const float *input)
{
    return input[12] != 0 || input[13] != 0 || input[14] != 0;
}

static void divide_by(float size, mpf_t a)
{
    mpf_set_d(scratch[0], size);
    mpf_div(a, a, scratch[0]);
}

/* e_ij as the filter has scaled it. */
static void find_scaled_edge(const struct filtered *filtered, int i, mpf_t result)
{
    find_edge(i, result);
    mpf_mul_ui(result, result, 2);
    divide_by(filtered->size[i], result);
}

/* Of a size so small that underflow could matter, or of another one. */
static double attack_edge(const float *input, int is_small)
{
    double direction[3], worst = -1;
    if (!has_direction(input)) return -1;
    load_direction(input, direction);
    load_exactly(input, direction);
    for (int shared = 0; shared < 2; ++shared) {
        struct filtered filtered;
        find_terms(input, shared, &filtered);
        for (int i = 0; i < 3; ++i) {
            if (is_small != (filtered.size[i] < 0x1p-90f)) continue;
            find_scaled_edge(&filtered, i, truth);
            const float value = dot_product(filtered.direction, filtered.terms.cross[i]);
            worst = fmax(worst, error_over(truth, value, EDGE_BOUND * filtered.direction_size));
        }
    }
    return worst;
}

static double attack_filter_edge(const float *input)
{
    return attack_edge(input, 0);
}

static double attack_filter_small_edge(const float *input)
{
    return attack_edge(input, 1);
}

/* How near a value of the wrong sign comes to what counts as certain. Right ones lead there as they come near 0. */
static double sign_over(const mpf_t a, double value, double least)
{
    const double share = fabs(value) / least;
    const int is_wrong = value != 0 && mpf_sgn(a) != (value > 0 ? 1 : -1);
    return is_wrong ? share : 0.001 / (1 + share);
}

static struct verdict decide(const struct filtered *filtered, float t_min, float lo, float hi)
{
    struct mlrt_packet packet;
    for (int k = 0; k < 3; ++k) packet.direction[k][0] = filtered->direction[k];
    packet.t_min[0] = t_min;
    packet.nearest.lo[0] = lo;
    packet.nearest.hi[0] = hi;
    packet.nearest.triangle[0] = MLRT_NONE;
    return filter_vector(&filtered->terms, filtered->direction_size, &packet, 0, m_from_bits(1));
}

/* The decisions on edges, of both ways. */
static double attack_filter_inside(const float *input)
{
    double direction[3];
    int sign[3];
    if (!has_direction(input)) return -1;
    load_direction(input, direction);
    load_exactly(input, direction);
    for (int i = 0; i < 3; ++i) {
        find_edge(i, truth);
        sign[i] = mpf_sgn(truth);
    }
    const int is_outside = sign[0] * sign[1] < 0 || sign[1] * sign[2] < 0 || sign[2] * sign[0] < 0;
    const int is_inside = sign[0] != 0 && sign[0] == sign[1] && sign[1] == sign[2];
    double worst = 0;
    for (int shared = 0; shared < 2; ++shared) {
        struct filtered filtered;
        find_terms(input, shared, &filtered);
        filtered.terms.distance_bound = INFINITY; /* of distances nothing is known */
        const struct verdict verdict = decide(&filtered, 0, INFINITY, INFINITY);
        if (verdict.inside && !is_inside) return INFINITY;
        if (!verdict.undecided && !is_outside) return INFINITY;
        for (int i = 0; i < 3; ++i) {
            find_edge(i, truth);
            const float value = dot_product(filtered.direction, filtered.terms.cross[i]);
            worst = fmax(worst, sign_over(truth, value, EDGE_BOUND * filtered.direction_size));
        }
    }
    return worst;
}

/* Of a ray that is surely inside. */
static void put_inside(struct filtered *filtered)
{
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) filtered->terms.cross[i][k] = filtered->direction[k] < 0 ? -1 : 1;
    }
}

/* Decisions on distances where D has the wrong sign. */
static double attack_filter_facing(const float *input)
{
    double direction[3], worst = 0;
    if (!has_direction(input)) return -1;
    load_direction(input, direction);
    load_exactly(input, direction);
    find_d_and_n(truth, other_truth);
    for (int shared = 0; shared < 2; ++shared) {
        struct filtered filtered;
        find_terms(input, shared, &filtered);
        put_inside(&filtered);
        filtered.terms.distance_bound = 0;
        const float value = dot_product(filtered.direction, filtered.terms.cross[3]);
        worst = fmax(worst, sign_over(truth, value, PLANE_BOUND * filtered.direction_size));
        if (value == 0 || mpf_sgn(truth) == (value > 0 ? 1 : -1)) continue;
        for (int sign = -1; sign <= 1; sign += 2) {
            filtered.terms.distance = (float)sign;
            if (!decide(&filtered, 0, INFINITY, INFINITY).undecided) return INFINITY;
        }
    }
    return worst;
}

enum decision { BEFORE_NEAREST, BEHIND_NEAREST, AFTER_START, BEFORE_START };

static int decides(const struct filtered *filtered, enum decision decision, float x)
{
    switch (decision) {
    case BEFORE_NEAREST:
        return m_bits(decide(filtered, 0, x, INFINITY).nearer) != 0;
    case BEHIND_NEAREST: {
        const struct verdict verdict = decide(filtered, 0, 0, x);
        return !verdict.nearer && !verdict.undecided;
    }
    case AFTER_START:
        return m_bits(decide(filtered, x, INFINITY, INFINITY).nearer) != 0;
    default: {
        const struct verdict verdict = decide(filtered, x, 0, INFINITY);
        return !verdict.nearer && !verdict.undecided;
    }
    }
}

/* The last float x >= 0 with the decision for t_min, lo or hi = x, or the first; near `start`. -1: there is none. */
static float find_threshold(const struct filtered *filtered, enum decision decision, float start)
{
    const uint32_t limit = bits_of(FLT_MAX);
    const int is_last = decision == BEHIND_NEAREST || decision == AFTER_START;
    uint32_t yes = bits_of(start) < limit ? bits_of(start) : limit, no = yes;
    for (uint32_t step = 1; !decides(filtered, decision, float_of(yes)); step *= 2) {
        if (yes == (is_last ? 0 : limit)) return -1;
        no = yes;
        yes = is_last ? (yes > step ? yes - step : 0) : (limit - yes > step ? yes + step : limit);
    }
    for (uint32_t step = 1; yes == no || decides(filtered, decision, float_of(no)); step *= 2) {
        if (yes != no) yes = no;
        if (no == (is_last ? limit : 0)) return -1;
        no = is_last ? (limit - no > step ? no + step : limit) : (no > step ? no - step : 0);
    }
    while (yes - no != 1 && no - yes != 1) {
        const uint32_t middle = yes / 2 + no / 2 + (yes & no & 1);
        *(decides(filtered, decision, float_of(middle)) ? &yes : &no) = middle;
    }
    return float_of(yes);
}

/* How far t goes from the middle of what the filter holds for possible towards its ends; `t` must be positive. */
static double ends_over(const struct filtered *filtered, const mpf_t t, double middle)
{
    const struct verdict verdict = decide(filtered, 0, INFINITY, INFINITY);
    if (!verdict.nearer) return -1;
    const int is_above = mpf_cmp_d(t, middle) > 0;
    const double ends[3] = {
        is_above ? verdict.hi : verdict.lo,
        is_above ? find_threshold(filtered, BEFORE_NEAREST, verdict.hi)
                 : find_threshold(filtered, BEHIND_NEAREST, verdict.lo),
        is_above ? find_threshold(filtered, BEFORE_START, verdict.hi)
                 : find_threshold(filtered, AFTER_START, verdict.lo),
    };
    double worst = 0;
    for (int i = 0; i < 3; ++i) {
        const double end = ends[i];
        if (end < 0 || isinf(end) || (end == 0 && mpf_sgn(t) > 0)) continue;
        worst = fmax(worst, error_over(t, middle, is_above ? end - middle : middle - end));
    }
    return worst;
}

enum quantity { D, N, T };

/* Bounds of N below this are little else than their floor. */
#define NEARLY_FLOOR 0x1.01p-82f

/* The ends of t = N / D; with 1 for the true N or D if only the other one is looked at. */
static double attack_ends(const float *input, enum quantity quantity, int tiny)
{
    double direction[3], worst = -1;
    if (!has_direction(input)) return -1;
    load_direction(input, direction);
    load_exactly(input, direction);
    for (int shared = 0; shared < 2; ++shared) {
        struct filtered filtered;
        find_terms(input, shared, &filtered);
        struct triangle_terms *terms = &filtered.terms;
        if (tiny != (terms->distance_bound < NEARLY_FLOOR)) continue;
        find_d_and_n(other_truth, truth);
        divide_by(filtered.size[3], other_truth);
        divide_by(filtered.size[3], truth);
        if (quantity == D) {
            terms->distance = dot_product(filtered.direction, terms->cross[3]) > 0 ? 1 : -1;
            terms->distance_bound = 0;
            mpf_set_d(truth, terms->distance);
        } else if (quantity == N) {
            mpf_set_d(other_truth, terms->distance > 0 ? 1 : -1);
            memset(filtered.direction, 0, sizeof filtered.direction);
            filtered.direction[0] = 1;
            terms->cross[3][0] = terms->distance > 0 ? 1 : -1;
            filtered.direction_size = 0;
        }
        if (mpf_sgn(other_truth) == 0) continue;
        mpf_div(truth, truth, other_truth);
        const float d = dot_product(filtered.direction, terms->cross[3]);
        put_inside(&filtered);
        worst = fmax(worst, ends_over(&filtered, truth, (double)terms->distance / d));
    }
    return worst;
}

static double attack_filter_d(const float *input)
{
    return attack_ends(input, D, 0);
}

static double attack_filter_n(const float *input)
{
    return attack_ends(input, N, 0);
}

static double attack_filter_t(const float *input)
{
    return attack_ends(input, T, 0);
}

/* Error of N' where its bound is hardly more than the floor. */
static double attack_filter_n_floor(const float *input)
{
    double direction[3], worst = -1;
    load_direction(input, direction);
    load_exactly(input, direction);
    for (int shared = 0; shared < 2; ++shared) {
        struct filtered filtered;
        find_terms(input, shared, &filtered);
        if (!(filtered.terms.distance_bound < NEARLY_FLOOR)) continue;
        find_d_and_n(other_truth, truth);
        divide_by(filtered.size[3], truth);
        worst = fmax(worst, error_over(truth, filtered.terms.distance, filtered.terms.distance_bound));
    }
    return worst;
}

static double attack_filter_t_floor(const float *input)
{
    return attack_ends(input, T, 1);
}

/* ---- the filter of single rays ----------------------------------------------------------------------------------- */

/*
 * What it works out of the inputs: for one ray, or for any from its origin (lanes_leaf.h). 0 if that is beyond what
 * float carries, which it must notice.
 */
static int load_single(const float *input, int is_any, struct float_test *test)
{
    static struct lanes_search search;
    vf term[SIDE_TERMS], to[3], d[3];
    double direction[3];
    search.direction_limit = 0;
    for (int k = 0; k < 3; ++k) {
        search.origin[k] = input[9 + k];
        d[k] = input[12 + k];
        search.direction_limit = fmaxf(4 * fabsf(input[12 + k]), search.direction_limit);
    }
    set_sides(input, 1, term);
    set_side_sizes(search.direction_limit, term);
    for (int k = 0; k < 3; ++k) to[k] = term[k] - search.origin[k];
    set_edges(term, to, d, test);
    set_edge_bound(term, to, test);
    set_plane(term, to, test);
    if (is_any) {
        struct triangles_from_origin of;
        set_up_from_origin(&search, input, 1, INFINITY, &of);
        const vf ca[3] = {of.ca[0][0], of.ca[1][0], of.ca[2][0]}, ab[3] = {of.ab[0][0], of.ab[1][0], of.ab[2][0]};
        const vf normal[3] = {of.normal[0][0], of.normal[1][0], of.normal[2][0]};
        test->determinant = dot_product(d, normal);
        test->edge_bound = of.edge_bound[0];
        test->inner = inside_of_sides(dot_product(d, ca), dot_product(d, ab), test->determinant);
        test->plane_bound = of.plane_bound[0];
        test->distance = of.distance[0];
        test->distance_bound = of.distance_bound[0];
    }
    load_direction(input, direction);
    load_exactly(input, direction);
    assert_true(test->edge_bound > 0 && test->plane_bound > 0 && test->distance_bound > 0);
    assert_true(isinf(test->edge_bound) || isfinite(test->inner));
    assert_true(isinf(test->plane_bound) || isfinite(test->determinant));
    assert_true(isinf(test->distance_bound) || isfinite(test->distance));
    return has_direction(input);
}

/* D, N and their bounds by components. 0 as above. */
static int load_components(const float *input, struct float_test *test)
{
    vf term[SIDE_TERMS], to[3], d[3];
    double direction[3];
    set_sides(input, 1, term);
    for (int k = 0; k < 3; ++k) {
        to[k] = term[k] - input[9 + k];
        d[k] = input[12 + k];
    }
    set_plane_by_components(term, to, d, test);
    load_direction(input, direction);
    load_exactly(input, direction);
    find_d_and_n(other_truth, truth);
    assert_true(test->plane_bound > 0 && test->distance_bound > 0);
    assert_true(isinf(test->plane_bound) || isfinite(test->determinant));
    assert_true(isinf(test->distance_bound) || isfinite(test->distance));
    return has_direction(input);
}

static double attack_components_d(const float *input)
{
    struct float_test test;
    if (!load_components(input, &test) || isinf(test.plane_bound)) return -1;
    return error_over(other_truth, test.determinant, test.plane_bound);
}

static double attack_components_n(const float *input)
{
    struct float_test test;
    if (!load_components(input, &test) || isinf(test.distance_bound)) return -1;
    return error_over(truth, test.distance, test.distance_bound);
}

static double attack_single_edges(const float *input)
{
    double worst = -1;
    for (int is_any = 0; is_any < 2; ++is_any) {
        struct float_test test;
        if (!load_single(input, is_any, &test) || isinf(test.edge_bound)) continue;
        find_edge(0, truth);
        mpf_set(other_truth, truth);
        for (int i = 1; i < 3; ++i) {
            static mpf_t edge;
            if (!edge->_mp_d) mpf_init(edge);
            find_edge(i, edge);
            if (mpf_cmp(edge, truth) < 0) mpf_set(truth, edge);
            if (mpf_cmp(edge, other_truth) > 0) mpf_set(other_truth, edge);
        }
        mpf_neg(other_truth, other_truth);
        if (mpf_cmp(other_truth, truth) > 0) mpf_set(truth, other_truth);
        worst = fmax(worst, error_over(truth, test.inner, test.edge_bound));
    }
    return worst;
}

static double attack_single_d(const float *input)
{
    double worst = -1;
    for (int is_any = 0; is_any < 2; ++is_any) {
        struct float_test test;
        if (!load_single(input, is_any, &test) || isinf(test.plane_bound)) continue;
        find_d_and_n(other_truth, truth);
        worst = fmax(worst, error_over(other_truth, test.determinant, test.plane_bound));
    }
    return worst;
}

static double attack_single_n(const float *input)
{
    double worst = -1;
    for (int is_any = 0; is_any < 2; ++is_any) {
        struct float_test test;
        if (!load_single(input, is_any, &test) || isinf(test.distance_bound)) continue;
        find_d_and_n(other_truth, truth);
        worst = fmax(worst, error_over(truth, test.distance, test.distance_bound));
    }
    return worst;
}

/* Where t of a hit is between the ends that are kept. */
static double attack_single_t(const float *input)
{
    double worst = -1;
    for (int is_any = 0; is_any < 2; ++is_any) {
        struct float_test test;
        if (!load_single(input, is_any, &test)) continue;
        test.inner = FLT_MAX;
        test.edge_bound = 0;
        const struct verdict verdict = compare_distances(&test, ALL_LANES, 0, INFINITY, INFINITY);
        if (!verdict.nearer || isinf(verdict.hi)) continue;
        find_d_and_n(other_truth, truth);
        mpf_div(truth, truth, other_truth);
        worst = fmax(worst, place_in(truth, verdict.lo, verdict.hi));
    }
    return worst;
}

/*
 * Where lanes of one origin take a plane to be out of reach of a ray: the error of T |D| - |N|, for the greatest end T.
 */
static double attack_single_reach(const float *input)
{
    static struct lanes_search search;
    struct triangles_from_origin of;
    struct float_test test;
    if (!load_single(input, 1, &test)) return -1;
    search.direction_limit = 0;
    for (int k = 0; k < 3; ++k) {
        search.origin[k] = input[9 + k];
        search.hull.direction_lo[k] = search.hull.direction_hi[k] = input[12 + k];
        search.direction_limit = fmaxf(4 * fabsf(input[12 + k]), search.direction_limit);
    }
    const double n = fabs((double)test.distance), d = (double)v_flip(test.determinant, test.distance);
    uint32_t left_out = 0,
             reached = 0x7F800000; /* ends as words: those of floats that are not negative have their order */
    float end = 0;
    if (set_up_from_origin(&search, input, 1, end, &of)) return -1;
    while (reached - left_out > 1) {
        const uint32_t middle = left_out + (reached - left_out) / 2;
        float tried;
        memcpy(&tried, &middle, sizeof tried);
        if (set_up_from_origin(&search, input, 1, tried, &of)) {
            reached = middle;
        } else {
            left_out = middle;
            end = tried;
        }
    }
    if (!isfinite(end * d - n)) return INFINITY; /* what float does not carry must not be left out */
    find_d_and_n(other_truth, truth);
    if (mpf_sgn(truth) == 0) return INFINITY;
    if (mpf_sgn(truth) < 0) mpf_neg(other_truth, other_truth);
    mpf_abs(truth, truth);
    mpf_set_d(scratch[0], end);
    mpf_mul(other_truth, other_truth, scratch[0]);
    mpf_sub(truth, other_truth, truth);
    if (mpf_sgn(truth) >= 0) return INFINITY;
    return error_over(truth, end * d - n, (double)end * test.plane_bound + test.distance_bound);
}

/* ---- two tempting bounds ----------------------------------------------------------------------------------------- */

/* The filter's, but with |a + b| in place of |a| + |b|. */
static double attack_sum_of_cancelled(const float *input)
{
    struct filtered filtered;
    double direction[3], size = 0;
    find_terms(input, 0, &filtered);
    load_direction(input, direction);
    for (int k = 0; k < 3; ++k) {
        const int p = (k + 1) % 3, q = (k + 2) % 3;
        const double sum_p = (double)(input[p] - input[9 + p]) + (input[3 + p] - input[9 + p]);
        const double sum_q = (double)(input[q] - input[9 + q]) + (input[3 + q] - input[9 + q]);
        size += fabs(direction[k]) *
                (fabs(sum_p * ((double)input[3 + q] - input[q])) + fabs(sum_q * ((double)input[3 + p] - input[p])));
    }
    load_exactly(input, direction);
    find_scaled_edge(&filtered, 0, truth);
    return error_over(truth, dot_product(filtered.direction, filtered.terms.cross[0]),
                      EDGE_BOUND * size / filtered.size[0]);
}

/* t as computed is within 2^-20 of itself, if only the sign of D is certain. */
static double attack_fixed_tolerance(const float *input)
{
    struct filtered filtered;
    double direction[3];
    find_terms(input, 0, &filtered);
    const float determinant = dot_product(filtered.direction, filtered.terms.cross[3]);
    assert_true(fabsf(determinant) > 2 * PLANE_BOUND * filtered.direction_size);
    load_direction(input, direction);
    load_exactly(input, direction);
    find_d_and_n(other_truth, truth);
    mpf_div(truth, truth, other_truth);
    const float t = filtered.terms.distance / determinant;
    return error_over(truth, t, 0x1p-20 * t);
}

/* ---- planes ------------------------------------------------------------------------------------------------------ */

static void find_plane_distance(double c, double o, double d)
{
    subtract_exactly(c, o, truth);
    mpf_set_d(scratch[0], d);
    mpf_div(truth, truth, scratch[0]);
}

/* The smallest float that is not below a, for a > 0. */
static float round_up_exactly(const mpf_t a)
{
    double below = mpf_get_d(a);
    return mlrt_float_up(mpf_cmp_d(a, below) > 0 ? nextafter(below, INFINITY) : below);
}

static float round_down_exactly(const mpf_t a)
{
    return mlrt_float_down(mpf_get_d(a));
}

/*
 * Inputs: c, o, d. Where t underflows, the interval need not contain it, but no float may come between: what is beyond
 * the interval is beyond t.
 */
static double attack_group_plane(const float *input)
{
    struct mlrt_packet packet;
    struct group_axis axis;
    if (input[2] == 0 || input[0] == input[1]) return -1;
    packet.has.apex = 1;
    packet.apex[0] = input[1];
    set_group_axis(&packet, 1, 0, input[2], input[2], &axis);
    set_group_reciprocals(input[2], input[2], &axis);
    const struct distance_interval t = plane_distances(&axis, input[0], 0);
    find_plane_distance(input[0], input[1], input[2]);
    if (is_normal(truth)) return place_in(truth, t.lo, t.hi);
    const int negative = mpf_sgn(truth) < 0;
    mpf_abs(truth, truth);
    const float lo = negative ? -t.hi : t.lo, hi = negative ? -t.lo : t.hi;
    return lo <= round_up_exactly(truth) && hi >= round_down_exactly(truth) ? 0 : INFINITY;
}

static double attack_ray_plane(const float *input)
{
    if (input[2] == 0 || input[0] == input[1]) return -1;
    const struct mlrt_interval t = mlrt_plane_distance(input[0], input[1], 1.0 / input[2]);
    find_plane_distance(input[0], input[1], input[2]);
    return place_in(truth, t.enter, t.exit);
}

/* ---- outlines ---------------------------------------------------------------------------------------------------- */

/* Inputs: a point, an apex, a direction, each over the main axis and one other. */
static double attack_outline(const float *input)
{
    struct mlrt_triangle triangle;
    struct mlrt_outline outline[2];
    const float apex[3] = {input[2], input[3], 0};
    struct mlrt_box box;
    if (!(input[0] > input[2])) return -1;
    for (int i = 0; i < 3; ++i) {
        triangle.v[i][0] = box.lo[0] = box.hi[0] = input[0];
        triangle.v[i][1] = box.lo[1] = box.hi[1] = input[1];
        triangle.v[i][2] = box.lo[2] = box.hi[2] = 1;
    }
    set_triangle_outline(&triangle, axis_code_of(0, 0), apex, &outline[0]);
    set_box_outline(&box, axis_code_of(0, 0), apex, &outline[1]);
    subtract_exactly(input[1], input[3], truth);
    subtract_exactly(input[0], input[2], other_truth);
    mpf_div(truth, truth, other_truth);
    double worst = -1;
    for (int i = 0; i < 2 && is_normal(truth); ++i) {
        worst = fmax(worst, slack_used(truth, outline[i].slope_lo[0], SLOPE_SLACK, 0));
        worst = fmax(worst, slack_used(truth, outline[i].slope_hi[0], SLOPE_SLACK, 1));
    }
    return worst;
}

static double attack_ray_slope(const float *input)
{
    struct mlrt_packet packet;
    float lo[MLRT_PACKET_RAYS], hi[MLRT_PACKET_RAYS];
    if (input[0] == 0 || input[1] == 0) return -1;
    memset(&packet, 0, sizeof packet);
    packet.direction[0][0] = input[0];
    packet.direction[1][0] = input[1];
    set_ray_slopes(&packet, 0, 1, lo, hi);
    mpf_set_d(truth, input[1]);
    mpf_set_d(other_truth, fabs(input[0]));
    mpf_div(truth, truth, other_truth);
    if (!is_normal(truth)) return -1;
    return fmax(slack_used(truth, lo[0], SLOPE_SLACK, 0), slack_used(truth, hi[0], SLOPE_SLACK, 1));
}

/* Inputs: depth of a point, of the apex, |d|. From which distance on does the group look at the point? */
static double attack_outline_depth(const float *input)
{
    struct ray_group group;
    struct mlrt_outline outline;
    if (!(input[0] > input[1]) || input[2] == 0) return -1;
    memset(&group, 0, sizeof group);
    group.lanes = 1;
    group.axis[0].largest = fabsf(input[2]);
    outline.least_depth = input[0] - input[1];
    outline.slope_lo[0] = outline.slope_lo[1] = -INFINITY;
    outline.slope_hi[0] = outline.slope_hi[1] = INFINITY;
    find_plane_distance(input[0], input[1], fabsf(input[2]));
    float farthest = round_up_exactly(truth);
    if (!touched_lanes(&group, &outline, farthest)) return INFINITY;
    if (!is_normal(truth)) return 0;
    while (touched_lanes(&group, &outline, farthest)) farthest = next_float(farthest, -1);
    /* As if the last bit of `farthest` had been rounded away too. */
    return slack_used(truth, next_float(farthest, 1), SLOPE_SLACK, 0);
}

/* ---- beams ------------------------------------------------------------------------------------------------------- */

/* (q / r) / (q0 / r0) - 1, where q0 is `truth` and r0 is `other_truth`. */
static double relative_error(double q, double r)
{
    mpf_set_d(scratch[0], q);
    mpf_mul(scratch[0], scratch[0], other_truth);
    mpf_set_d(scratch[1], r);
    mpf_mul(scratch[1], scratch[1], truth);
    mpf_div(scratch[0], scratch[0], scratch[1]);
    mpf_sub_ui(scratch[0], scratch[0], 1);
    return mpf_get_d(scratch[0]);
}

/*
 * Inputs: c, o_a, d_a, h, o_j, d_j. Seen along axis a, the ray is at o_j + m x; what is compared with h - o_j must have
 * moved away from it.
 */
static double attack_beam_slope(const float *input)
{
    struct mlrt_beam beam;
    const float x = input[0] - input[1], r = input[3] - input[4];
    if (input[2] == 0 || input[5] == 0 || x == 0 || r == 0) return -1;
    const double slope = input[5] * (1.0 / input[2]);
    mlrt_set_slope(&beam, 0, 1, slope, slope);
    const struct offset_interval q = offset_range(&beam, 0, 1, x, x);
    find_plane_distance(input[0], input[1], input[2]);
    mpf_set_d(scratch[0], input[5]);
    mpf_mul(truth, truth, scratch[0]);
    subtract_exactly(input[3], input[4], other_truth);
    if (!is_normal(truth) || !is_normal(other_truth)) return -1;
    const double outward = mpf_sgn(truth) > 0 ? SLOPE_SLACK : -SLOPE_SLACK;
    return fmax(1 + relative_error(q.lo, r) / outward, 1 - relative_error(q.hi, r) / outward);
}

/* Inputs: d00, dx, dy over two axes, sample_x, sample_y, and where the tile is. */
static void load_view(const float *input, mlrt_camera *view, uint32_t *x, uint32_t *y)
{
    memset(view, 0, sizeof *view);
    for (int k = 0; k < 2; ++k) {
        view->d00[k] = input[k];
        view->dx[k] = input[2 + k];
        view->dy[k] = input[4 + k];
    }
    view->sample_x = input[6];
    view->sample_y = input[7];
    view->t_max = INFINITY;
    *x = bits_of(input[8]) >> 8 & (PIXEL_LIMIT - 1);
    *y = bits_of(input[9]) >> 8 & (PIXEL_LIMIT - 1);
}

static double attack_camera_pad(const float *input)
{
    mlrt_camera view;
    struct corners corners;
    uint32_t x, y;
    float p[3];
    load_view(input, &view, &x, &y);
    find_corners(&view, x, y, 1, 1, &corners);
    mlrt_view_point(&view, x, y, p);
    double worst = -1;
    for (int k = 0; k < 2; ++k) {
        const double samples[2] = {mlrt_sample_position(0, x, view.sample_x),
                                   mlrt_sample_position(0, y, view.sample_y)};
        mpf_set_d(truth, view.d00[k]);
        mpf_set_d(scratch[0], samples[0] * view.dx[k]); /* 48 bits: exact */
        mpf_add(truth, truth, scratch[0]);
        mpf_set_d(scratch[0], samples[1] * view.dy[k]);
        mpf_add(truth, truth, scratch[0]);
        if (isfinite(p[k])) worst = fmax(worst, error_over(truth, p[k], corners.pad[k]));
    }
    return worst;
}

/* The slope of a ray in its beam, less the part of the beam that is there for other roundings. */
static double attack_camera_slope(const float *input)
{
    mlrt_camera view;
    struct mlrt_beam beam;
    uint32_t x, y;
    float p[3];
    load_view(input, &view, &x, &y);
    const struct mlrt_source source = {.kind = MLRT_SOURCE_CAMERA, .view = view};
    if (!mlrt_get_beam(&source, x, y, 1, 1, &beam)) return -1;
    if (!isfinite(beam.slope_lo[0][1]) || !isfinite(beam.slope_hi[0][1])) return -1;
    mlrt_view_point(&view, x, y, p);
    mpf_set_d(truth, p[1]);
    mpf_set_d(other_truth, p[0]);
    mpf_div(truth, truth, other_truth);
    const double lo = beam.slope_lo[0][1], hi = beam.slope_hi[0][1];
    if (!is_normal(truth)) return mpf_cmp_d(truth, lo) >= 0 && mpf_cmp_d(truth, hi) <= 0 ? 0 : INFINITY;
    return place_in(truth, lo / (1 + (lo < 0 ? SLOPE_SLACK : -SLOPE_SLACK)),
                    hi / (1 - (hi < 0 ? SLOPE_SLACK : -SLOPE_SLACK)));
}

/* ---- cells ------------------------------------------------------------------------------------------------------- */

/*
 * Inputs as of the camera: how far beyond the slopes of a cell's corners its rays go, of the way to the cell's bounds.
 */
static double attack_camera_cell(const float *input)
{
    static struct mlrt_bundle bundle;
    mlrt_camera view;
    uint32_t x, y;
    float p[3];
    load_view(input, &view, &x, &y);
    const struct mlrt_rectangle area = {x, y, 4, 4};
    if (!mlrt_gather_camera_cells(&view, 1, &area, 4, &bundle)) return -1;
    const struct mlrt_hull_row *slopes = bundle.hulls.term;
    const int a = bundle.waist.main_axis, side = a == 0 ? 0 : 1, j = 1 - a; /* over axes 0 and 1 */
    if (a == 2) return -1;
    double lo = INFINITY, hi = -INFINITY, worst = -1;
    for (int i = 0; i < 4; ++i) {
        const double sample_x = mlrt_sample_position(0, x + (i & 1 ? 3 : 0), view.sample_x);
        const double sample_y = mlrt_sample_position(0, y + (i & 2 ? 3 : 0), view.sample_y);
        double d[2];
        for (int k = 0; k < 2; ++k) d[k] = view.d00[k] + sample_x * view.dx[k] + sample_y * view.dy[k];
        const double slope = d[j] / fabs(d[a]);
        lo = fmin(slope, lo);
        hi = fmax(slope, hi);
    }
    const double below = lo - slopes[side].lo[0], above = slopes[side].hi[0] - hi;
    if (!(below > 0 && above > 0)) return INFINITY;
    for (uint32_t i = 0; i < 16; ++i) {
        mlrt_view_point(&view, x + i % 4, y + i / 4, p);
        if (!(p[a] * bundle.waist.sign > 0)) return INFINITY;
        const double slope = (double)p[j] / fabs((double)p[a]);
        worst = fmax(worst, fmax((lo - slope) / below, (slope - hi) / above));
    }
    return fmax(worst, 0);
}

/* ---- covers ------------------------------------------------------------------------------------------------------ */

/* Inputs: a triangle, an apex, two slopes. */
static void load_corner(const float *input, struct corner_terms *terms)
{
    struct mlrt_triangle triangle;
    struct mlrt_beam beam;
    memset(&beam, 0, sizeof beam);
    load_triangle(input, &triangle);
    memcpy(beam.origin_lo, input + 9, sizeof beam.origin_lo);
    beam.main_axis = 2;
    for (int j = 0; j < 2; ++j) beam.slope_lo[2][j] = beam.slope_hi[2][j] = input[12 + j];
    struct corner_directions corners;
    set_corner_directions(&beam, &corners);
    set_corner_terms(&triangle, &beam, &corners, terms);
    load_exactly(input, (const double[3]){input[12], input[13], 1});
}

static double attack_cover_edge(const float *input)
{
    struct corner_terms terms;
    double worst = 0;
    load_corner(input, &terms);
    for (int i = 0; i < 3; ++i) {
        find_edge(i, truth);
        worst = fmax(worst, error_over(truth, terms.value[i][0], terms.bound[i]));
    }
    return worst;
}

static double attack_cover_d_and_n(const float *input)
{
    struct corner_terms terms;
    load_corner(input, &terms);
    find_d_and_n(truth, other_truth);
    const double d = error_over(truth, terms.value[3][0], terms.bound[3]);
    return fmax(d, error_over(other_truth, terms.distance, terms.distance_bound));
}

static double attack_cover_depth(const float *input)
{
    struct corner_terms terms;
    load_corner(input, &terms);
    const int sign = certain_sign(&terms, 3);
    if (sign == 0 || !(sign * terms.distance > terms.distance_bound)) return -1;
    find_d_and_n(other_truth, truth);
    mpf_div(truth, truth, other_truth);
    const double middle = fabs(terms.distance) / fabs(terms.value[3][0]);
    const int is_above = mpf_cmp_d(truth, middle) > 0;
    return error_over(truth, middle, is_above ? greatest_depth(&terms, 0) - middle : middle - least_depth(&terms, 0));
}

/* ---- the judge in double ----------------------------------------------------------------------------------------- */

static struct mlrt_operands load_judge(const float *input)
{
    struct mlrt_triangle triangle;
    struct mlrt_ray_segment ray = {.t_max = INFINITY};
    double direction[3];
    load_triangle(input, &triangle);
    memcpy(ray.origin, input + 9, sizeof ray.origin);
    memcpy(ray.direction, input + 12, sizeof ray.direction);
    load_direction(input, direction);
    load_exactly(input, direction);
    return mlrt_load_operands(ray.origin, ray.direction, triangle.v[0], 1);
}

static double measured_over(const mpf_t exact, struct mlrt_measured measured, double error)
{
    return error_over(exact, measured.value, error * measured.size);
}

static double attack_judge_edges(const float *input)
{
    const struct mlrt_operands operands = load_judge(input);
    const struct mlrt_two_edges edges = mlrt_measure_edges(&operands);
    find_edge(0, truth);
    const double ratio = measured_over(truth, edges.ab, MLRT_SIGN_ERROR);
    find_edge(2, truth);
    return fmax(ratio, measured_over(truth, edges.ca, MLRT_SIGN_ERROR));
}

static double attack_judge_third_edge(const float *input)
{
    const struct mlrt_operands operands = load_judge(input);
    const struct mlrt_two_edges edges = mlrt_measure_edges(&operands);
    find_edge(1, truth);
    return measured_over(truth, mlrt_measure_third_edge(&edges, mlrt_measure_crossing(&operands).d), MLRT_SIGN_ERROR);
}

static double attack_judge_d_and_n(const float *input)
{
    const struct mlrt_operands operands = load_judge(input);
    const struct mlrt_crossing crossing = mlrt_measure_crossing(&operands);
    find_d_and_n(truth, other_truth);
    const double ratio = measured_over(truth, crossing.d, MLRT_SIGN_ERROR);
    return fmax(ratio, measured_over(other_truth, crossing.n, MLRT_SIGN_ERROR));
}

/* A 16th input: t. */
static double attack_judge_beyond(const float *input)
{
    const struct mlrt_operands operands = load_judge(input);
    const struct mlrt_crossing crossing = mlrt_measure_crossing(&operands);
    const float t = fabsf(input[15]);
    find_d_and_n(truth, other_truth);
    mpf_set_d(scratch[0], t);
    mpf_mul(truth, truth, scratch[0]);
    mpf_sub(truth, other_truth, truth);
    return measured_over(truth, mlrt_measure_beyond(&crossing, t), MLRT_SIGN_ERROR);
}

/* Nine more inputs: another triangle. */
static double attack_judge_order(const float *input)
{
    float other[TRIANGLE_AND_RAY];
    memcpy(other, input + 15, 9 * sizeof(float));
    memcpy(other + 9, input + 9, 6 * sizeof(float));
    const struct mlrt_operands operands = load_judge(input);
    const struct mlrt_crossing crossing = mlrt_measure_crossing(&operands);
    find_d_and_n(truth, other_truth);
    const struct mlrt_operands other_operands = load_judge(other);
    const struct mlrt_crossing other_crossing = mlrt_measure_crossing(&other_operands);
    find_d_and_n(scratch[3], difference);
    mpf_mul(other_truth, other_truth, scratch[3]);
    mpf_mul(truth, truth, difference);
    mpf_sub(truth, other_truth, truth);
    return measured_over(truth, mlrt_measure_order(&crossing, &other_crossing), MLRT_ORDER_ERROR);
}

static double attack_judge_quotient(const float *input)
{
    const struct mlrt_operands operands = load_judge(input);
    const struct mlrt_crossing crossing = mlrt_measure_crossing(&operands);
    if (!is_safe_denominator(crossing.d)) return -1;
    const struct enclosure t = enclose_quotient(crossing.n, invert(crossing.d));
    const struct enclosure u = enclose_quotient(mlrt_measure_edges(&operands).ca, invert(crossing.d));
    find_d_and_n(other_truth, truth);
    mpf_div(truth, truth, other_truth);
    const double ratio = place_in(truth, t.low, t.high);
    find_edge(2, truth);
    mpf_div(truth, truth, other_truth);
    return fmax(ratio, place_in(truth, u.low, u.high));
}

static double place_in_quotient(double x, double width, const struct lane_denominator *denominator,
                                const mpf_t quotient)
{
    const struct quotient_ends ends = enclose_quotients(x, width, denominator);
    return place_in(quotient, ends.low, ends.high);
}

/* Of packets: lane by lane, and by terms that are kept. u is that of a hit, so at most 1. */
static double attack_packet_quotient(const float *input)
{
    static struct mlrt_packet packet;
    struct mlrt_triangle triangle;
    struct mlrt_hit_terms kept;
    struct plane_terms plane;
    struct start_terms start;
    struct lane_denominator denominator;
    double corner[9], origin[3], direction[3], moment[3];
    load_judge(input);
    load_triangle(input, &triangle);
    for (int k = 0; k < 9; ++k) corner[k] = triangle.v[k / 3][k % 3];
    for (int k = 0; k < 3; ++k) {
        origin[k] = input[9 + k];
        direction[k] = packet.direction[k][0] = input[12 + k];
    }
    set_plane_terms(corner, &plane);
    set_start_terms(&plane, origin, MLRT_OUTPUT_UV, &start);
    mlrt_set_hit_terms(&triangle, input + 9, &kept);
    const double size = greatest_direction_size(&packet, 1);
    const double d = fused_dot_product(direction, plane.normal);
    if (!invert_denominator(d, plane.normal_size * size, &denominator)) return -1;
    find_d_and_n(other_truth, truth);
    mpf_div(truth, truth, other_truth);
    double ratio = place_in_quotient(start.n, start.n_width, &denominator, truth);
    ratio = fmax(ratio, place_in_quotient(kept.n, kept.n_width, &denominator, truth));
    find_edge(2, truth);
    mpf_div(truth, truth, other_truth);
    if (mpf_sgn(truth) < 0 || mpf_cmp_ui(truth, 1) > 0) return ratio;
    fused_cross_product(start.p, direction, moment);
    ratio = fmax(ratio, place_in_quotient(fused_dot_product(plane.side[0], moment), start.edge_width[0] * size,
                                          &denominator, truth));
    return fmax(
        ratio, place_in_quotient(mlrt_dot((struct mlrt_vector){direction[0], direction[1], direction[2]}, kept.edge[0]),
                                 kept.edge_width[0] * size, &denominator, truth));
}

/* ---- clipping ---------------------------------------------------------------------------------------------------- */

/* Inputs: a triangle, a box, a plane. */
#define CLIP_INPUTS 16

struct exact_polygon {
    int count;
    struct point vertex[12];
};

static struct exact_polygon whole_polygon, cut_one, cut_two, true_half[2];

/* What of `in` is above (sign = 1) or below (sign = -1) a plane. */
static void cut_exactly(const struct exact_polygon *in, int axis, int sign, float position, struct exact_polygon *out)
{
    mpf_set_d(scratch[3], position);
    out->count = 0;
    for (int i = 0; i < in->count; ++i) {
        const struct point *here = &in->vertex[i], *next = &in->vertex[(i + 1) % in->count];
        mpf_sub(scratch[0], here->x[axis], scratch[3]);
        mpf_sub(scratch[1], next->x[axis], scratch[3]);
        const int side = sign * mpf_sgn(scratch[0]), next_side = sign * mpf_sgn(scratch[1]);
        if (side >= 0) {
            for (int k = 0; k < 3; ++k) mpf_set(out->vertex[out->count].x[k], here->x[k]);
            ++out->count;
        }
        if (side * next_side >= 0) continue;
        mpf_sub(scratch[1], scratch[0], scratch[1]);
        mpf_div(scratch[0], scratch[0], scratch[1]);
        for (int k = 0; k < 3; ++k) {
            mpf_sub(scratch[1], next->x[k], here->x[k]);
            mpf_mul(scratch[1], scratch[1], scratch[0]);
            mpf_add(out->vertex[out->count].x[k], here->x[k], scratch[1]);
        }
        /* Exactly on the plane, in spite of the division. */
        mpf_set(out->vertex[out->count].x[axis], scratch[3]);
        ++out->count;
    }
}

static int is_within(const struct exact_polygon *polygon, const struct bounds *bounds)
{
    for (int i = 0; i < polygon->count; ++i) {
        for (int k = 0; k < 3; ++k) {
            if (mpf_cmp_d(polygon->vertex[i].x[k], bounds->lo[k]) < 0) return 0;
            if (mpf_cmp_d(polygon->vertex[i].x[k], bounds->hi[k]) > 0) return 0;
        }
    }
    return 1;
}

/* 1 if clipping with this share of the margins loses nothing of the two halves. */
static int is_enough(const struct mlrt_triangle *triangle, const struct mlrt_box *box, float position, double share)
{
    struct mlrt_box whole;
    double margin[3];
    struct polygon polygon[2];
    mlrt_bound_triangle(triangle, whole.lo, whole.hi);
    find_margins(&whole, margin);
    for (int k = 0; k < 3; ++k) margin[k] *= share;
    copy_triangle(triangle, &polygon[0]);
    const int current = cut_by_box(&whole, margin, box, polygon);
    for (int side = 0; side < 2; ++side) {
        const double sign = side == 0 ? -1 : 1;
        const struct plane plane = {0, sign, position - sign * margin[0]};
        struct bounds bounds;
        cut_polygon(&polygon[current], &plane, &polygon[1 - current]);
        bound_polygon(&polygon[1 - current], margin, &bounds);
        if (!is_within(&true_half[side], &bounds)) return 0;
    }
    return 1;
}

static double attack_clip(const float *input)
{
    struct mlrt_triangle triangle;
    struct mlrt_box box;
    load_triangle(input, &triangle);
    for (int k = 0; k < 3; ++k) {
        box.lo[k] = fminf(input[9 + k], input[12 + k]);
        box.hi[k] = fmaxf(input[9 + k], input[12 + k]);
    }
    const float position = fminf(fmaxf(input[15], box.lo[0]), box.hi[0]);
    whole_polygon.count = 3;
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) mpf_set_d(whole_polygon.vertex[i].x[k], triangle.v[i][k]);
    }
    struct exact_polygon *in = &whole_polygon, *out = &cut_one;
    for (int face = 0; face < 6; ++face) {
        cut_exactly(in, face / 2, face % 2 ? -1 : 1, face % 2 ? box.hi[face / 2] : box.lo[face / 2], out);
        in = out;
        out = out == &cut_one ? &cut_two : &cut_one;
    }
    if (in->count == 0) return -1;
    for (int side = 0; side < 2; ++side) cut_exactly(in, 0, side ? 1 : -1, position, &true_half[side]);
    if (!is_enough(&triangle, &box, position, 1)) return INFINITY;
    double lo = 0, hi = 1;
    for (int i = 0; i < 9; ++i) {
        const double middle = 0.5 * (lo + hi);
        *(is_enough(&triangle, &box, position, middle) ? &hi : &lo) = middle;
    }
    return hi;
}

static void init_polygons(void)
{
    struct exact_polygon *polygons[] = {&whole_polygon, &cut_one, &cut_two, &true_half[0], &true_half[1]};
    for (int i = 0; i < 5; ++i) {
        for (int j = 0; j < 12; ++j) init_point(&polygons[i]->vertex[j]);
    }
}

/* ---- tests of bounds --------------------------------------------------------------------------------------------- */

/* The worst of some 100 million inputs. */
static const float worst_d[INPUT_LIMIT] = {-0x1.ff7f9p-2f,   0x1.0a669ep-23f,   -0x1.038052p-12f, 0x1.870cp-11f,
                                           -0x1.08c8e4p-23f, -0x1.30000cp-121f, -0x1.80344ep-11f, -0x1.00001ep-76f,
                                           0x1.ffff0ap+0f,   0x1.120042p-2f,    -0x1.a1789p-32f,  0x1.000006p-24f,
                                           -0x1.cee7f6p-1f,  0x1.0ef71ap-1f,    -0x1.f55daep-2f,  0x1.0ef71ap-1f};
static const float worst_n[INPUT_LIMIT] = {0x1.4b7p-11f,    -0x1.007fd4p-2f, 0x1.00cep+2f,    -0x1.000012p-66f,
                                           0x1.44400cp-64f, -0x1.fff9ep+10f, 0x1.00004ep-62f, -0x1.000438p+13f,
                                           0x1.10408cp-11f, 0x1.152b3ap+1f,  -0x1.cc7104p+0f, 0x1.09b644p+1f,
                                           0x1.8001p+1f,    0x1.014054p+50f, -0x1.0002ep+11f, 0x1.4b6ffcp+1f};
static const float worst_edge[INPUT_LIMIT] = {0x1.fc13a2p-3f,  -0x1.083b1p-5f,   -0x1.04c892p+5f, 0x1.db60cap-3f,
                                              0x1.04010ep-76f, -0x1.00c88ep-7f,  0x1.05ff3ep+5f,  0x1.00004ep-74f,
                                              0x1.00c46p+5f,   -0x1.000018p+22f, 0x1.d91eaap-3f,  0x1.db60c2p-3f,
                                              0x1.feffe2p-7f,  0x1.005206p-6f,   -0x1.00305cp-6f, 0x1.0400b4p-77f};
static const float worst_t[INPUT_LIMIT] = {-0x1.0019d2p+0f, 0x1.000026p+25f, 0x1.0001f6p+0f,   -0x1.419fcap+0f,
                                           -0x1.022fcp+13f, -0x1.40a158p+0f, 0x1.000528p+0f,   -0x1.0000b4p+1f,
                                           0x1.004128p+0f,  0x1.06bf04p+24f, 0x1.ff8ce2p+23f,  0x1.06a0bap+24f,
                                           0x1.40000ep+26f, -0x1.024038p-2f, -0x1.06a2bep+23f, -0x1.10c9a2p+34f};

static void filter_bounds_hold(void **state)
{
    static const struct bound bounds[] = {
        {"filter: e", FILTER_INPUTS, RAY_IS_SAFE, attack_filter_edge, 0.5, worst_edge},
        {"filter: e of small size", FILTER_INPUTS, RAY_IS_SAFE, attack_filter_small_edge, 0.5, NULL},
        {"filter: e of the wrong sign", FILTER_INPUTS, RAY_IS_SAFE, attack_filter_inside, 0.15, NULL},
        {"filter: D of the wrong sign", FILTER_INPUTS, RAY_IS_SAFE, attack_filter_facing, 0.1, NULL},
        {"filter: D", FILTER_INPUTS, RAY_IS_SAFE, attack_filter_d, 0.35, worst_d},
        {"filter: N", FILTER_INPUTS, RAY_IS_SAFE, attack_filter_n, 0.5, worst_n},
        {"filter: t", FILTER_INPUTS, RAY_IS_SAFE, attack_filter_t, 0.3, worst_t},
        {"filter: N, where it underflows", FILTER_INPUTS, RAY_IS_SAFE, attack_filter_n_floor, 0.0001, NULL},
        {"filter: t, where it underflows", FILTER_INPUTS, RAY_IS_SAFE, attack_filter_t_floor, 0.05, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof bounds / sizeof bounds[0]; ++i) attack(&bounds[i], CLIMB_COUNT);
}

static void single_ray_bounds_hold(void **state)
{
    static const struct bound bounds[] = {
        {"single: e", TRIANGLE_AND_RAY, RAY_IS_SAFE, attack_single_edges, 0.3, NULL},
        {"single: D", TRIANGLE_AND_RAY, RAY_IS_SAFE, attack_single_d, 0.15, NULL},
        {"single: N", TRIANGLE_AND_RAY, RAY_IS_SAFE, attack_single_n, 0.3, NULL},
        {"single: D by components", TRIANGLE_AND_RAY, RAY_IS_SAFE, attack_components_d, 0.15, NULL},
        {"single: N by components", TRIANGLE_AND_RAY, RAY_IS_SAFE, attack_components_n, 0.3, NULL},
        {"single: t", TRIANGLE_AND_RAY, RAY_IS_SAFE, attack_single_t, 0.2, NULL},
        {"lanes: t of a plane", TRIANGLE_AND_RAY, RAY_IS_SAFE, attack_single_reach, 0.1, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof bounds / sizeof bounds[0]; ++i) attack(&bounds[i], CLIMB_COUNT);
}

/* Those of docs/accuracy.md. */
static void tempting_bounds_do_not_hold(void **state)
{
    static const float cancelling[FILTER_INPUTS] = {-2.5f, 2.2f, 0.3f,  3.3f, -2.4f, 5.3f, 0,   1,
                                                    2,     0.4f, -0.1f, 2.8f, -1.3f, 0.1f, 1.6f};
    static const float grazing[FILTER_INPUTS] = {1.7f,  1,     1.3f, -1.8f, -1.4f,  2,     0.3f,     0.7f,
                                                 -0.9f, -2.7f, 0.2f, 0.5f,  -0.14f, 0.96f, -3.94014f};
    (void)state;
    const double sum = attack_sum_of_cancelled(cancelling), tolerance = attack_fixed_tolerance(grazing);
    print_message("%-34s %.0f\n%-34s %.0f\n", "no bound: |a + b|", sum, "no bound: 2^-20 of t", tolerance);
    assert_true(sum > 10000 && tolerance > 5000);
    assert_true(attack_filter_edge(cancelling) <= 1 && attack_filter_d(grazing) <= 1 && attack_filter_n(grazing) <= 1);
    assert_true(attack_filter_t(grazing) <= 1);
}

static void plane_bounds_hold(void **state)
{
    static const struct bound bounds[] = {
        {"planes, group", 3, 7, attack_group_plane, 0.3, NULL},
        {"planes, one ray", 3, 0, attack_ray_plane, 0.3, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof bounds / sizeof bounds[0]; ++i) attack(&bounds[i], CLIMB_COUNT);
}

static void outline_bounds_hold(void **state)
{
    static const struct bound bounds[] = {
        {"outlines: slope", 4, 0xC, attack_outline, 0.15, NULL},
        {"outlines: slope of a ray", 2, 3, attack_ray_slope, 0.1, NULL},
        {"outlines: depth", 3, 6, attack_outline_depth, 0.12, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof bounds / sizeof bounds[0]; ++i) attack(&bounds[i], CLIMB_COUNT);
}

static void beam_bounds_hold(void **state)
{
    static const struct bound bounds[] = {
        {"beam: slope", 6, 0x36, attack_beam_slope, 0.12, NULL},
        {"camera: pad", 10, 0, attack_camera_pad, 0.5, NULL},
        {"camera: slope", 10, 0, attack_camera_slope, 0.4, NULL},
        {"camera: slope of a cell's ray", 10, 0, attack_camera_cell, 0.1, NULL},
        {"cover: edge", 14, ORIGIN_IS_SAFE, attack_cover_edge, 0.25, NULL},
        {"cover: D and N", 14, ORIGIN_IS_SAFE, attack_cover_d_and_n, 0.25, NULL},
        {"cover: depth", 14, ORIGIN_IS_SAFE, attack_cover_depth, 0.12, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof bounds / sizeof bounds[0]; ++i) attack(&bounds[i], CLIMB_COUNT);
}

static void double_bounds_hold(void **state)
{
    static const struct bound bounds[] = {
        {"double: e_ab, e_ca", TRIANGLE_AND_RAY, 0, attack_judge_edges, 0.4, NULL},
        {"double: e_bc", TRIANGLE_AND_RAY, 0, attack_judge_third_edge, 0.4, NULL},
        {"double: D, N", TRIANGLE_AND_RAY, 0, attack_judge_d_and_n, 0.4, NULL},
        {"double: N - t D", TRIANGLE_AND_RAY + 1, 0, attack_judge_beyond, 0.4, NULL},
        {"double: order", TRIANGLE_AND_RAY + 9, 0, attack_judge_order, 0.4, NULL},
        {"double: quotients", TRIANGLE_AND_RAY, 0, attack_judge_quotient, 0.15, NULL},
        {"double: quotients of packets", TRIANGLE_AND_RAY, 0, attack_packet_quotient, 0.15, NULL},
    };
    (void)state;
    for (size_t i = 0; i < sizeof bounds / sizeof bounds[0]; ++i) attack(&bounds[i], CLIMB_COUNT);
}

static void the_clip_margin_holds(void **state)
{
    static const struct bound bound = {"clip: margin", CLIP_INPUTS, 0, attack_clip, 0.02, NULL};
    (void)state;
    attack(&bound, CLIMB_COUNT / 4);
}

/* ---- whole traversals where a bound matters ---------------------------------------------------------------------- */

/* Triangles so small that products of the filter underflow, seen from 0, among others that make the tree float-safe. */
static void products_that_underflow_decide_nothing(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < scaled(14 * search_effort); ++seed) {
        struct random random = {seed * 0x10001 + 5};
        struct soup soup = {0};
        struct ray_list list = {.row_length = 16};
        const float lo[3] = {-1, -1, -1}, hi[3] = {1, 1, 1}, zero[3] = {0, 0, 0};
        const int exponent = -72 - (int)draw_below(&random, 6);
        soup_add_box(&soup, lo, hi);
        for (int i = 0; i < 40; ++i) {
            float corner[3][3];
            for (int j = 0; j < 3; ++j) {
                for (int k = 0; k < 3; ++k) corner[j][k] = ldexpf(draw_range(&random, -1, 1), exponent);
            }
            soup_add_triangle(&soup, corner[0], corner[1], corner[2]);
        }
        for (int i = 0; i < 128; ++i) {
            float target[3];
            if (i % 16 == 0) draw_point(&random, -1, 1, target); /* rays of a packet must be alike to stay together */
            for (int k = 0; k < 3; ++k) target[k] = next_float(target[k], (int)draw_below(&random, 0x40000));
            add_ray_towards(&list, zero, target);
        }
        struct fixture fixture = fixture_of_soup("underflow", seed, &soup);
        check_rays_quickly(&fixture, &list);
        free_rays(&list);
        free_fixture(&fixture);
    }
}

/*
 * Walls across an axis, and rays so fast that t underflows on the way from one to the next: the distance of a wall, the
 * t at which the cells beside it end, and t_min or t_max are one float, or neighbours.
 */
static void rays_may_begin_and_end_in_a_split_plane(void **state)
{
    const mlrt_kdtree_options build = {
        .struct_size = sizeof build, .preset = MLRT_KDTREE_PAPER, .intersection_cost = 100, .traversal_cost = 0.01f};
    (void)state;
    for (uint64_t seed = 0; seed < scaled(24 * search_effort); ++seed) {
        struct random random = {seed * 0x10001 + 9};
        struct soup soup = {0};
        struct ray_list list = {.row_length = 16};
        const int axis = (int)draw_below(&random, 3), x = (axis + 1) % 3, y = (axis + 2) % 3;
        const float start = MLRT_SAFE_MIN, sign = draw_below(&random, 2) ? 1 : -1;
        for (int wall = 0; wall < 8; ++wall) {
            float corner[3] = {start, start, start}, side[3] = {0, 0, 0}, other_side[3] = {0, 0, 0};
            corner[axis] = next_float(start, (int)draw_below(&random, 40));
            side[x] = other_side[y] = next_float(start, 40) - start;
            soup_add_quad(&soup, corner, side, other_side);
        }
        for (int packet = 0; packet < 24; ++packet) {
            float origin[3], direction[3] = {0, 0, 0};
            for (int k = 0; k < 3; ++k) origin[k] = next_float(start, 1 + (int)draw_below(&random, 39));
            const int is_up = (int)draw_below(&random, 2);
            origin[axis] = is_up ? start : next_float(start, 40);
            direction[axis] = (is_up ? 1 : -1) * draw_range(&random, 0.5f, 1) * MLRT_SAFE_MAX;
            if (draw_below(&random, 2)) direction[axis] = copysignf(MLRT_SAFE_MAX, direction[axis]);
            const float wall = soup.corners[9 * (size_t)draw_below(&random, (uint32_t)soup.count) + (size_t)axis];
            const float t = (wall - origin[axis]) / direction[axis];
            const float t_min = draw_below(&random, 2) ? next_float(t, (int)draw_below(&random, 3) - 1) : 0;
            const float t_max = draw_below(&random, 2) ? next_float(t, (int)draw_below(&random, 3) - 1) : INFINITY;
            for (int i = 0; i < 16; ++i) {
                struct reference_ray *ray = add_ray(&list, origin, direction);
                ray->t_min = fmaxf(t_min, 0);
                ray->t_max = t_max;
            }
        }
        for (size_t i = 0; i < 9 * soup.count; ++i) soup.corners[i] *= sign;
        for (size_t i = 0; i < list.count; ++i) {
            for (int k = 0; k < 3; ++k) {
                list.rays[i].origin[k] *= sign;
                list.rays[i].direction[k] *= sign;
            }
        }
        mlrt_mesh mesh = soup_mesh(&soup);
        struct fixture fixture = make_fixture_with("split plane", seed, &mesh, 1, &build);
        check_rays_quickly(&fixture, &list);
        free_rays(&list);
        free_fixture(&fixture);
        free_soup(&soup);
    }
}

/*
 * The deepest hierarchy there may be, all of whose boxes are met, the inner ones first: so all others wait. (What lies
 * behind a stack is noticed by a build with SAN=address.)
 */
static void stacks_hold_what_waits(void **state)
{
    enum { QUAD = MLRT_BVH_DEPTH_LIMIT };
    static struct mlrt_bvh_node nodes[MLRT_BVH_DEPTH_LIMIT];
    static float corners[36 * (QUAD + 1) + 16];
    static uint32_t numbers[4 * (QUAD + 1) + 16];
    static struct mlrt_bundle_leaf leaves[2];
    static struct mlrt_worker worker;
    static struct mlrt_packet packet;
    static struct mlrt_triangle triangle;
    static struct mlrt_reciprocals reciprocals;
    static struct mlrt_bundle bundle;
    struct mlrt_tree tree = {.by_number.corners = triangle.v[0], .bvh.unit = 1};
    const struct mlrt_job job = {.tree = &tree};
    (void)state;
    assert_true(MLRT_BVH_STACK_LIMIT >= (MLRT_BVH_DEPTH_LIMIT - 1) * (MLRT_BVH_WIDTH - 1) + MLRT_BVH_WIDTH);
    for (uint32_t n = 0; n < MLRT_BVH_DEPTH_LIMIT; ++n) {
        for (uint32_t i = 0; i < MLRT_BVH_WIDTH; ++i) {
            for (int k = 0; k < 3; ++k) {
                nodes[n].lo[k][i] = k == 2 ? 1 : -1;
                nodes[n].hi[k][i] = k == 2 ? 2 : 1;
            }
            const int is_inner = i == MLRT_BVH_WIDTH - 1 && n + 1 < MLRT_BVH_DEPTH_LIMIT;
            nodes[n].child[i] = is_inner ? (n + 1) << 3 : QUAD << 3 | 1;
        }
    }
    /* One triangle, beside the rays. */
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            triangle.v[i][k] = k == i ? 0.9f : 1;
            for (int place = 0; place < 4; ++place) corners[36 * QUAD + 4 * (3 * i + k) + place] = triangle.v[i][k];
        }
    }
    for (int place = 1; place < 4; ++place) numbers[4 * QUAD + place] = MLRT_NONE;
    tree.bvh = (struct mlrt_bvh){.nodes = nodes,
                                 .node_count = MLRT_BVH_DEPTH_LIMIT,
                                 .quad_count = QUAD + 1,
                                 .corners = corners,
                                 .numbers = numbers,
                                 .whole = {{-1, -1, 1}, {1, 1, 2}},
                                 .core = {{-1, -1, 1}, {1, 1, 2}},
                                 .unit = 1};

    const float direction[3] = {0, 0, 1};
    mlrt_face_waist(direction, &bundle.waist);
    for (int side = 0; side < 2; ++side) {
        bundle.hulls.term[side].lo[0] = -0.01f;
        bundle.hulls.term[side].hi[0] = 0.01f;
    }
    mlrt_begin_cells(1, &bundle);
    static struct mlrt_bundles bundles;
    bundles.caches[0].leaves = leaves;
    bundles.caches[0].bits = 1;
    worker.bundles = &bundles;
    worker.mask = MLRT_MASK_ALL;
    for (int k = 0; k < 3; ++k) bundle.apex[k] = NAN;
    trace_cells(&job, &worker, 0, &bundle);
    assert_true(bundle.has.apex);
    for (int k = 0; k < 3; ++k) assert_true(bundle.apex[k] == bundle.waist.point[k]); /* packets are compared with it */
    assert_true(bundle.state.closed == 1 && bundle.state.going == 1 && bundle.hulls.closed.cover[0] == MLRT_NONE);

    packet.direction[2][0] = 1;
    packet.nearest.lo[0] = packet.nearest.hi[0] = INFINITY;
    packet.nearest.triangle[0] = MLRT_NONE;
    packet.has.apex = 1;
    set_reciprocals(&packet, &reciprocals);
    const struct ray_rows rows = rows_of_lane(&packet, &reciprocals, 0);
    trace_single(&job, &rows, 0, 0, &packet, &worker);
    assert_true(packet.nearest.triangle[0] == MLRT_NONE);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(filter_bounds_hold),
        cmocka_unit_test(single_ray_bounds_hold),
        cmocka_unit_test(tempting_bounds_do_not_hold),
        cmocka_unit_test(plane_bounds_hold),
        cmocka_unit_test(outline_bounds_hold),
        cmocka_unit_test(beam_bounds_hold),
        cmocka_unit_test(double_bounds_hold),
        cmocka_unit_test(the_clip_margin_holds),
        cmocka_unit_test(products_that_underflow_decide_nothing),
        cmocka_unit_test(rays_may_begin_and_end_in_a_split_plane),
        cmocka_unit_test(stacks_hold_what_waits),
    };
    if (argc > 1 && atoi(argv[1]) > 0) search_effort = (size_t)atoi(argv[1]);
    init_numbers();
    init_polygons();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
