/* SPDX-License-Identifier: MIT */
/*
 * predicate.c against the hit rule in GMP integers: every decision and every rounded quotient, on inputs made to be
 * close or equal. test_bounds.c is about its bounds on errors.
 *
 * predicate.c and quotients.c are included: their parts in double and their exact parts are also checked one by one.
 */
#include "exact/order.h"
#include "exact/predicate.c"
#include "exact/quotients.c"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>
#include <gmp.h>

#define CASES_PER_KIND 5000

/* ------------------------------------------------------------------------------------------------------------------
 * Random input
 * ------------------------------------------------------------------------------------------------------------------ */

static uint64_t random_state;

static uint32_t next_random(void)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(random_state >> 33) ^ (uint32_t)(random_state >> 13);
}

static float float_of_bits(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* The float `steps` further from 0, or nearer if negative, if that is finite and of the same sign. */
static float nudge(float value, int32_t steps)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint32_t nudged = bits + (uint32_t)steps;
    if (((nudged ^ bits) & 0x80000000u) != 0 || (nudged & 0x7F800000u) == 0x7F800000u) return value;
    return float_of_bits(nudged);
}

/* -1 .. 1 */
static float unit_float(void)
{
    return (float)((int32_t)(next_random() % 0x2000001u) - 0x1000000) * 0x1p-24f;
}

static float small_integer(void)
{
    float value = (float)(next_random() % 3);
    return next_random() % 2 ? value : -value; // so that there are zeros of both signs
}

static float grid_point(void)
{
    return (float)((int32_t)(next_random() % 4097) - 2048) * 0x1p-6f;
}

static float any_finite_float(void)
{
    uint32_t bits = next_random();
    if ((bits & 0x7F800000u) == 0x7F800000u) bits ^= 0x40000000u;
    return float_of_bits(bits);
}

/* One of the sizes that do not mix well. */
static float extreme_float(void)
{
    static const float sizes[] = {0x1p-149f, 0x1.8p-140f, FLT_MIN, 1e-20f, 0, 1, 1.5f, 1e20f, 0x1p127f, FLT_MAX};
    float value = sizes[next_random() % (sizeof sizes / sizeof sizes[0])];
    return next_random() % 2 ? value : -value;
}

struct test_case {
    struct mlrt_ray_segment ray;
    struct mlrt_triangle triangle;
};

static void fill(struct test_case *test, float (*coordinate)(void))
{
    for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i) test->triangle.v[i][k] = coordinate();
        test->ray.origin[k] = coordinate();
        test->ray.direction[k] = coordinate();
    }
    test->ray.t_min = 0;
    test->ray.t_max = INFINITY;
}

/* Points the ray at the sum of the vertices with these weights, as well as float can. */
static void aim(struct test_case *test, float weight_a, float weight_b, float weight_c)
{
    for (int k = 0; k < 3; ++k) {
        float target =
            weight_a * test->triangle.v[0][k] + weight_b * test->triangle.v[1][k] + weight_c * test->triangle.v[2][k];
        test->ray.direction[k] = target - test->ray.origin[k];
    }
}

static void aim_inside(struct test_case *test)
{
    float weight_b = fabsf(unit_float()), weight_c = (1 - weight_b) * fabsf(unit_float());
    aim(test, 1 - weight_b - weight_c, weight_b, weight_c);
}

static void make_ordinary(struct test_case *test)
{
    fill(test, unit_float);
    if (next_random() % 2) aim_inside(test);
}

static void make_small_integers(struct test_case *test)
{
    fill(test, small_integer);
}

static void make_any_exponents(struct test_case *test)
{
    fill(test, any_finite_float);
}

static void make_extremes(struct test_case *test)
{
    fill(test, extreme_float);
}

static void make_far_away(struct test_case *test)
{
    fill(test, unit_float);
    for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i) test->triangle.v[i][k] = 1e7f + 8 * test->triangle.v[i][k];
        test->ray.origin[k] = 1e7f * (float)(next_random() % 2) + 8 * test->ray.origin[k];
    }
    aim_inside(test);
}

static void make_sliver(struct test_case *test)
{
    fill(test, unit_float);
    float along = unit_float();
    for (int k = 0; k < 3; ++k) {
        float a = test->triangle.v[0][k], b = test->triangle.v[1][k];
        test->triangle.v[2][k] = a + along * (b - a);
    }
    aim_inside(test);
}

/* Grid points make the aim exact: at vertices, at points of edges, along edges. */
static void make_aimed_at_vertex(struct test_case *test)
{
    fill(test, grid_point);
    uint32_t vertex = next_random() % 3;
    aim(test, vertex == 0, vertex == 1, vertex == 2);
}

static void make_aimed_at_edge(struct test_case *test)
{
    fill(test, grid_point);
    float weight = (float)(next_random() % 17) / 8 - 0.5f;
    uint32_t vertex = next_random() % 3;
    float weights[3];
    weights[vertex] = 0;
    weights[(vertex + 1) % 3] = weight;
    weights[(vertex + 2) % 3] = 1 - weight;
    aim(test, weights[0], weights[1], weights[2]);
}

static void make_in_plane(struct test_case *test)
{
    fill(test, grid_point);
    float s = small_integer(), t = small_integer(), p = small_integer(), q = small_integer();
    for (int k = 0; k < 3; ++k) {
        float a = test->triangle.v[0][k], ab = test->triangle.v[1][k] - a, ac = test->triangle.v[2][k] - a;
        test->ray.origin[k] = a + s * ab + t * ac;
        test->ray.direction[k] = p * ab + q * ac;
    }
}

/* Walls and rays along axes: most products are zeros, of both signs. */
static void make_axis_parallel(struct test_case *test)
{
    fill(test, small_integer);
    uint32_t wall = next_random() % 3, axis = next_random() % 4 ? wall : next_random() % 3;
    for (uint32_t k = 0; k < 3; ++k) {
        if (k == wall) test->triangle.v[1][k] = test->triangle.v[2][k] = test->triangle.v[0][k];
        if (k != axis) test->ray.direction[k] = next_random() % 2 ? 0.0f : -0.0f;
    }
}

/* A point of the plane x + y + z = 0, of any size. */
static void any_point_in_plane(float point[3])
{
    uint32_t zero = next_random() % 3;
    float size = any_finite_float();
    point[zero] = 0;
    point[(zero + 1) % 3] = size;
    point[(zero + 2) % 3] = -size;
}

/*
 * Nearly all points in one plane, and sizes too different for any grid: exact zeros that only exact/integers.h can
 * tell.
 */
static void make_wide_plane(struct test_case *test)
{
    fill(test, any_finite_float);
    uint32_t outside = next_random() % 8; // 0..2 a vertex, 3 the origin, 4 the direction
    for (uint32_t i = 0; i < 3; ++i) {
        if (i != outside) any_point_in_plane(test->triangle.v[i]);
    }
    if (outside != 3) any_point_in_plane(test->ray.origin);
    if (outside != 4) any_point_in_plane(test->ray.direction);
}

/* From 0 through a vertex, with vertices of any size. */
static void make_wide_corner(struct test_case *test)
{
    fill(test, any_finite_float);
    for (int k = 0; k < 3; ++k) {
        test->ray.origin[k] = 0;
        test->ray.direction[k] = test->triangle.v[0][k];
    }
}

/* A point and how far it is from there to the plane, or to a vertex: the sum cancels, or is in the plane. */
static void make_sum_in_plane(struct test_case *test)
{
    fill(test, next_random() % 4 ? grid_point : small_integer);
    const int is_far = next_random() % 2;
    const float s = small_integer(), t = small_integer(), far = is_far ? 0x1p16f : 0;
    for (int k = 0; k < 3; ++k) {
        const float a = test->triangle.v[0][k], ab = test->triangle.v[1][k] - a, ac = test->triangle.v[2][k] - a;
        test->ray.origin[k] += far;
        test->ray.direction[k] = a + s * ab + t * ac - test->ray.origin[k];
    }
}

/* Likewise where neither of the two is near the triangle, and their sum is not a float. */
static void make_sum_of_any_sizes(struct test_case *test)
{
    fill(test, unit_float);
    const float size = next_random() % 2 ? 0x1p60f : 0x1p10f;
    for (int k = 0; k < 3; ++k) {
        test->ray.origin[k] *= size;
        test->ray.direction[k] = test->triangle.v[next_random() % 3][k] - test->ray.origin[k];
    }
}

/* Moves a coordinate or two by a few steps, so that what was equal is now close. */
static void disturb(struct test_case *test)
{
    for (uint32_t i = next_random() % 3; i > 0; --i) {
        uint32_t which = next_random() % 15, k = which % 3;
        float *value = which < 9    ? &test->triangle.v[which / 3][k]
                       : which < 12 ? &test->ray.origin[k]
                                    : &test->ray.direction[k];
        *value = nudge(*value, (int32_t)(next_random() % 5) - 2);
    }
}

/* ------------------------------------------------------------------------------------------------------------------
 * The hit rule in integers
 * ------------------------------------------------------------------------------------------------------------------ */

/* Coordinates in units of 2^-149; e_ab, e_bc, e_ca, D and N in units of 2^-447. */
struct integers {
    mpz_t origin[3], direction[3], vertex[3][3], normal[3];
    mpz_t edge[3], d, n;
    mpz_t x, y, z; /* scratch */
};

static struct integers first_integers, second_integers;

static void init_integers(struct integers *integers)
{
    for (int k = 0; k < 3; ++k) {
        mpz_inits(integers->origin[k], integers->direction[k], integers->normal[k], integers->edge[k], NULL);
        for (int i = 0; i < 3; ++i) mpz_init(integers->vertex[i][k]);
    }
    mpz_inits(integers->d, integers->n, integers->x, integers->y, integers->z, NULL);
}

static void clear_integers(struct integers *integers)
{
    for (int k = 0; k < 3; ++k) {
        mpz_clears(integers->origin[k], integers->direction[k], integers->normal[k], integers->edge[k], NULL);
        for (int i = 0; i < 3; ++i) mpz_clear(integers->vertex[i][k]);
    }
    mpz_clears(integers->d, integers->n, integers->x, integers->y, integers->z, NULL);
}

/* value * 2^scale, which must be an integer */
static void set_scaled(mpz_t result, double value, int scale)
{
    int exponent;
    mpz_set_d(result, ldexp(frexp(value, &exponent), 53));
    exponent += scale - 53;
    if (exponent >= 0) mpz_mul_2exp(result, result, (mp_bitcnt_t)exponent);
    if (exponent < 0) mpz_tdiv_q_2exp(result, result, (mp_bitcnt_t)-exponent);
}

static void set_integers(struct integers *integers, const struct test_case *test)
{
    struct integers *z = integers;
    for (int k = 0; k < 3; ++k) {
        set_scaled(z->origin[k], test->ray.origin[k], 149);
        set_scaled(z->direction[k], test->ray.direction[k], 149);
        for (int i = 0; i < 3; ++i) set_scaled(z->vertex[i][k], test->triangle.v[i][k], 149);
    }
    mpz_t to[3][3], ab[3], ac[3];
    for (int k = 0; k < 3; ++k) {
        mpz_inits(ab[k], ac[k], NULL);
        mpz_sub(ab[k], z->vertex[1][k], z->vertex[0][k]);
        mpz_sub(ac[k], z->vertex[2][k], z->vertex[0][k]);
        for (int i = 0; i < 3; ++i) {
            mpz_init(to[i][k]);
            mpz_sub(to[i][k], z->vertex[i][k], z->origin[k]);
        }
    }
    for (int i = 0; i < 3; ++i) mpz_set_ui(z->edge[i], 0);
    mpz_set_ui(z->d, 0);
    mpz_set_ui(z->n, 0);
    for (int k = 0; k < 3; ++k) {
        int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
        mpz_mul(z->normal[k], ab[k1], ac[k2]);
        mpz_submul(z->normal[k], ab[k2], ac[k1]);
        mpz_addmul(z->d, z->direction[k], z->normal[k]);
        mpz_addmul(z->n, to[0][k], z->normal[k]);
        for (int i = 0; i < 3; ++i) {
            int j = (i + 1) % 3;
            mpz_mul(z->x, to[i][k1], to[j][k2]);
            mpz_submul(z->x, to[i][k2], to[j][k1]);
            mpz_addmul(z->edge[i], z->direction[k], z->x);
        }
    }
    for (int k = 0; k < 3; ++k) {
        mpz_clears(ab[k], ac[k], to[0][k], to[1][k], to[2][k], NULL);
    }
    mpz_add(z->x, z->edge[0], z->edge[1]);
    mpz_add(z->x, z->x, z->edge[2]);
    assert_true(mpz_cmp(z->x, z->d) == 0);
}

/* The sign of N - t D. */
static int expected_beyond(struct integers *z, float t)
{
    set_scaled(z->x, t, 149);
    mpz_mul(z->x, z->x, z->d);
    mpz_mul_2exp(z->y, z->n, 149);
    return mpz_cmp(z->y, z->x) > 0 ? 1 : mpz_cmp(z->y, z->x) < 0 ? -1 : 0;
}

static int expected_facing(const struct integers *z)
{
    int d = mpz_sgn(z->d);
    for (int i = 0; i < 3; ++i) {
        if (d * mpz_sgn(z->edge[i]) < 0) return 0;
    }
    return d;
}

static int expected_hit(struct integers *z, const struct mlrt_ray_segment *ray)
{
    int facing = expected_facing(z);
    if (facing * expected_beyond(z, ray->t_min) <= 0) return 0;
    return isinf(ray->t_max) || facing * expected_beyond(z, ray->t_max) <= 0;
}

static int expected_order(struct integers *first, const struct integers *second)
{
    mpz_mul(first->x, first->n, second->d);
    mpz_mul(first->y, second->n, first->d);
    return mpz_sgn(first->d) * mpz_sgn(second->d) * mpz_cmp(first->x, first->y);
}

static int sign_of_int(int value)
{
    return (value > 0) - (value < 0);
}

/* The sign of |x / d| - value, for a value that is a multiple of 2^-150 and may be 2^128. */
static int compare_quotient(struct integers *z, const mpz_t x, double value)
{
    set_scaled(z->x, value, 150);
    mpz_mul(z->x, z->x, z->d);
    mpz_mul_2exp(z->y, x, 150);
    return sign_of_int(mpz_cmpabs(z->y, z->x));
}

/* A float as a double, where the one after FLT_MAX is 2^128. */
static double wide(float value)
{
    return isinf(value) ? 0x1p128 : value;
}

/* Whether |x / d|, rounded to nearest even, is the float: it lies between the midpoints to the neighbours. */
static int is_rounded_quotient(struct integers *z, const mpz_t x, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    if (bits > 0x7F800000u) return 0; // NaN or with a sign
    int odd = (int)(bits & 1);
    if (bits > 0) {
        double below = 0.5 * (wide(float_of_bits(bits - 1)) + wide(value));
        int order = compare_quotient(z, x, below);
        if (order < 0 || (order == 0 && odd)) return 0;
    }
    if (!isinf(value)) {
        double above = 0.5 * (wide(value) + wide(float_of_bits(bits + 1)));
        int order = compare_quotient(z, x, above);
        if (order > 0 || (order == 0 && odd)) return 0;
    }
    return 1;
}

/* ------------------------------------------------------------------------------------------------------------------
 * One case
 * ------------------------------------------------------------------------------------------------------------------ */

static void fail_case(const char *what, const struct test_case *test)
{
    print_error("%s, random state 0x%llx\n", what, (unsigned long long)random_state);
    print_error("origin %a %a %a direction %a %a %a t_min %a t_max %a\n", test->ray.origin[0], test->ray.origin[1],
                test->ray.origin[2], test->ray.direction[0], test->ray.direction[1], test->ray.direction[2],
                test->ray.t_min, test->ray.t_max);
    for (int i = 0; i < 3; ++i) {
        print_error("vertex %a %a %a\n", test->triangle.v[i][0], test->triangle.v[i][1], test->triangle.v[i][2]);
    }
    fail();
}

static void check(int condition, const char *what, const struct test_case *test)
{
    if (!condition) fail_case(what, test);
}

/* The origin plus the direction, as a point. */
static void check_sum(const struct test_case *test)
{
    struct integers *z = &first_integers;
    mpz_sub(z->x, z->d, z->n);
    const int side = mpz_sgn(z->x);
    const float *from = test->ray.origin, *by = test->ray.direction;
    check(mlrt_side_of_sum(&test->triangle, from, by) == side, "side_of_sum", test);
    check(mlrt_side_of_sum(&test->triangle, by, from) == side, "side_of_sum, swapped", test);
    check(mlrt_exact_sign_beyond(from, by, &test->triangle, 1) == -side, "exact side of a sum", test);
}

static void check_triangle(const struct test_case *test)
{
    struct integers *z = &first_integers;
    int has_area = mpz_sgn(z->normal[0]) != 0 || mpz_sgn(z->normal[1]) != 0 || mpz_sgn(z->normal[2]) != 0;
    check(mlrt_triangle_has_area(&test->triangle) == has_area, "has_area", test);
    for (int k = 0; k < 3; ++k) {
        const float axis[3] = {k == 0, k == 1, k == 2}, *from = test->triangle.v[0];
        const int facing = mpz_sgn(z->normal[k]);
        check(mlrt_facing_axis(&test->triangle, k) == facing, "facing an axis", test);
        check(mlrt_exact_sign_beyond(from, axis, &test->triangle, 1) == -facing, "exactly facing an axis", test);
    }
    int side = -mpz_sgn(z->n);
    check(mlrt_side_of_plane(&test->triangle, test->ray.origin) == side, "side_of_plane", test);
    check(mlrt_exact_sign_beyond(test->ray.origin, NO_STEP, &test->triangle, 1) == -side, "exact side", test);
    check_sum(test);
}

static void check_hit(const struct test_case *test)
{
    int hit = expected_hit(&first_integers, &test->ray);
    check(mlrt_hits_triangle(&test->ray, &test->triangle, NULL) == hit, "hits_triangle", test);
}

/* The interval's ends at, just below and just above t. */
static void check_intervals(struct test_case *test, float t)
{
    check_hit(test);
    if (isinf(t)) t = FLT_MAX;
    const float around[] = {0, nudge(t, -1), t, nudge(t, 1), INFINITY};
    for (int i = 0; i < 4; ++i) {
        for (int j = i + 1; j < 5; ++j) {
            test->ray.t_min = around[i];
            test->ray.t_max = around[j];
            if (test->ray.t_min < test->ray.t_max) check_hit(test);
        }
        check(mlrt_exact_sign_beyond(test->ray.origin, test->ray.direction, &test->triangle, around[i]) ==
                  expected_beyond(&first_integers, around[i]),
              "sign_beyond_exactly", test);
    }
    test->ray.t_min = 0;
    test->ray.t_max = INFINITY;
}

static void check_report(const struct test_case *test, const mlrt_hit *report)
{
    struct integers *z = &first_integers;
    check(is_rounded_quotient(z, z->n, report->t), "t", test);
    check(is_rounded_quotient(z, z->edge[2], report->u), "u", test);
    check(is_rounded_quotient(z, z->edge[0], report->v), "v", test);
    check(report->facing == mpz_sgn(z->d), "facing", test);
}

static void check_distance_bounds(const struct test_case *test)
{
    struct integers *z = &first_integers;
    float lo, hi;
    mlrt_bound_distance(&test->ray, &test->triangle, &lo, &hi);
    check(lo >= 0 && compare_quotient(z, z->n, lo) >= 0, "lo", test);
    check(isinf(hi) || compare_quotient(z, z->n, hi) <= 0, "hi", test);
}

#define ALL_OUTPUTS (MLRT_OUTPUT_T | MLRT_OUTPUT_UV | MLRT_OUTPUT_FACING)

/* Everything about one ray and one triangle. 1 if it is a hit. */
static int check_case(struct test_case *test)
{
    struct integers *z = &first_integers;
    set_integers(z, test);
    check_triangle(test);
    int facing = expected_facing(z);
    check(facing_exactly(&test->ray, &test->triangle, (const int[3]){0, 0, 0}, NULL) == facing, "facing_exactly", test);
    if (!expected_hit(z, &test->ray)) {
        check_hit(test);
        return 0;
    }
    mlrt_hit report, exact_report;
    mlrt_exact_report(&test->ray, &test->triangle, ALL_OUTPUTS, &exact_report);
    check_report(test, &exact_report);
    mlrt_report_hit(&test->ray, &test->triangle, ALL_OUTPUTS, &report);
    check_report(test, &report);
    check_distance_bounds(test);
    check_intervals(test, report.t);
    return 1;
}

static void check_kind(void (*make)(struct test_case *), uint64_t seed, int least_hit_count)
{
    random_state = seed;
    int hit_count = 0;
    for (int i = 0; i < CASES_PER_KIND; ++i) {
        struct test_case test;
        make(&test);
        if (i % 2) disturb(&test);
        hit_count += check_case(&test);
    }
    assert_true(hit_count >= least_hit_count);
}

static void ordinary_rays(void **state)
{
    (void)state;
    check_kind(make_ordinary, 1, CASES_PER_KIND / 3);
}

/* They begin just off the plane, to either side. For nearly all that leave it, double is sure. */
static void rays_from_the_plane(void **state)
{
    (void)state;
    random_state = 15;
    int leaving = 0, sure = 0;
    for (int i = 0; i < CASES_PER_KIND; ++i) {
        struct test_case test;
        make_ordinary(&test);
        const float b = unit_float() / 2, c = unit_float() / 2;
        for (int k = 0; k < 3; ++k) {
            const float a = test.triangle.v[0][k], to_b = test.triangle.v[1][k] - a, to_c = test.triangle.v[2][k] - a;
            test.ray.origin[k] = nudge(a + b * to_b + c * to_c, (int32_t)(next_random() % 5) - 2);
        }
        set_integers(&first_integers, &test);
        check_hit(&test);
        if (mpz_sgn(first_integers.n) * mpz_sgn(first_integers.d) >= 0) continue;
        mlrt_counters counters = {0};
        mlrt_hits_triangle(&test.ray, &test.triangle, &counters);
        ++leaving;
        sure += counters.exact_edge_count + counters.exact_range_count == 0;
    }
    assert_true(leaving > CASES_PER_KIND / 3 && sure > leaving - leaving / 100);
}

static void small_integers(void **state)
{
    (void)state;
    check_kind(make_small_integers, 2, CASES_PER_KIND / 50);
}

static void sums_in_the_plane(void **state)
{
    (void)state;
    int zero_count = 0;
    random_state = 30;
    for (int i = 0; i < CASES_PER_KIND; ++i) {
        struct test_case test;
        make_sum_in_plane(&test);
        if (i % 4 == 3) disturb(&test);
        set_integers(&first_integers, &test);
        check_sum(&test);
        zero_count += mlrt_side_of_sum(&test.triangle, test.ray.origin, test.ray.direction) == 0;
    }
    assert_in_range(zero_count, CASES_PER_KIND / 2, CASES_PER_KIND - CASES_PER_KIND / 10);
}

static void sums_of_any_sizes(void **state)
{
    (void)state;
    random_state = 31;
    for (int i = 0; i < CASES_PER_KIND; ++i) {
        struct test_case test;
        make_sum_of_any_sizes(&test);
        if (i % 2) disturb(&test);
        set_integers(&first_integers, &test);
        check_sum(&test);
    }
}

static void any_exponents(void **state)
{
    (void)state;
    check_kind(make_any_exponents, 3, 1);
}

static void extremes_in_one_triangle(void **state)
{
    (void)state;
    check_kind(make_extremes, 4, CASES_PER_KIND / 50);
}

static void far_from_the_origin(void **state)
{
    (void)state;
    check_kind(make_far_away, 5, CASES_PER_KIND / 10);
}

static void slivers(void **state)
{
    (void)state;
    check_kind(make_sliver, 6, 1);
}

static void rays_at_vertices(void **state)
{
    (void)state;
    check_kind(make_aimed_at_vertex, 7, CASES_PER_KIND / 2);
}

static void rays_at_edges(void **state)
{
    (void)state;
    check_kind(make_aimed_at_edge, 8, CASES_PER_KIND / 4);
}

static void rays_in_the_plane(void **state)
{
    (void)state;
    check_kind(make_in_plane, 9, 1);
}

static void axis_parallel_rays(void **state)
{
    (void)state;
    check_kind(make_axis_parallel, 10, CASES_PER_KIND / 50);
}

static void planes_too_wide_for_a_grid(void **state)
{
    (void)state;
    check_kind(make_wide_plane, 11, CASES_PER_KIND / 500);
}

static void corners_too_far_for_a_grid(void **state)
{
    (void)state;
    check_kind(make_wide_corner, 12, CASES_PER_KIND / 5);
}

/* ------------------------------------------------------------------------------------------------------------------
 * Two triangles
 * ------------------------------------------------------------------------------------------------------------------ */

static int has_area_in_integers(const struct integers *z)
{
    return mpz_sgn(z->normal[0]) != 0 || mpz_sgn(z->normal[1]) != 0 || mpz_sgn(z->normal[2]) != 0;
}

/* The vertices of the second triangle are in the plane of the first. */
static int expected_share(struct integers *first, const struct integers *second)
{
    for (int i = 0; i < 3; ++i) {
        mpz_set_ui(first->x, 0);
        for (int k = 0; k < 3; ++k) {
            mpz_sub(first->y, second->vertex[i][k], first->vertex[0][k]);
            mpz_addmul(first->x, first->y, first->normal[k]);
        }
        if (mpz_sgn(first->x) != 0) return 0;
    }
    return 1;
}

/* Compares the first triangle in double with the second, if the ray hits both. */
static void check_comes_first(const struct test_case *test, const struct mlrt_triangle *second, int order)
{
    const struct mlrt_ray_segment *ray = &test->ray;
    float places[9][4];
    if (!mlrt_hits_triangle(ray, &test->triangle, NULL) || !mlrt_hits_triangle(ray, second, NULL)) return;
    for (int i = 0; i < 9; ++i) places[i][2] = test->triangle.v[i / 3][i % 3];
    const struct mlrt_corners corners = {&places[0][2], 4, 1}, others = {second->v[0], 1, 0};
    for (int wins_tie = 0; wins_tie < 2; ++wins_tie) {
        const int said =
            comes_first(load_twice(ray->origin, 1), load_twice(ray->direction, 1), &corners, &others, wins_tie);
        check(said < 0 || said == (order ? order < 0 : wins_tie), "comes_first", test);
    }
}

/* The corners of an odd triangle are NaNs: double says nothing of it, whatever the other one is. */
static void nothing_is_said_of_odd_triangles(void **state)
{
    (void)state;
    const float odd[9] = {NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN}, origin[3] = {0, 0, 0}, along[3] = {0, 0, 1};
    static const float others[2][9] = {{0, 0, 1, 1, 0, 1, 0, 1, 1}, {-1, -1, 1, 1, -1, 2, 0, 1, 1.5f}};
    for (size_t i = 0; i < 2; ++i) {
        const struct mlrt_corners corners = {odd, 1, 0}, other = {others[i], 1, 0};
        for (int wins_tie = 0; wins_tie < 2; ++wins_tie) {
            const struct two_vectors o = load_twice(origin, 1), d = load_twice(along, 1);
            assert_int_equal(comes_first(o, d, &corners, &other, wins_tie), -1);
            assert_int_equal(comes_first(o, d, &other, &corners, wins_tie), -1);
            assert_int_equal(comes_first(o, d, &corners, &corners, wins_tie), -1);
        }
    }
}

/* Compares in both directions, fast and exactly. 1 if the distances are equal. */
static int check_pair(const struct test_case *test, const struct mlrt_triangle *second)
{
    struct test_case other = *test;
    other.triangle = *second;
    set_integers(&first_integers, test);
    set_integers(&second_integers, &other);
    if (has_area_in_integers(&first_integers) && has_area_in_integers(&second_integers)) {
        int share = expected_share(&first_integers, &second_integers);
        check(mlrt_share_plane(&test->triangle, second) == share, "share_plane", test);
        check(mlrt_share_plane(second, &test->triangle) == share, "share_plane, swapped", test);
    }
    if (mpz_sgn(first_integers.d) == 0 || mpz_sgn(second_integers.d) == 0) return 0;
    int order = sign_of_int(expected_order(&first_integers, &second_integers));
    const struct mlrt_ray_segment *ray = &test->ray;
    const struct mlrt_triangle *first = &test->triangle;
    check(mlrt_compare_distance(ray, first, second, NULL) == order, "compare_distance", test);
    check(mlrt_compare_distance(ray, second, first, NULL) == -order, "compare_distance, swapped", test);
    check(compare_close_distance(ray, first, second, NULL) == order, "compare_close_distance", test);
    check(mlrt_exact_order(ray, first, second) == order, "mlrt_exact_order", test);
    check_comes_first(test, second, order);
    return order == 0;
}

static void disturb_triangle(struct mlrt_triangle *triangle)
{
    float *value = &triangle->v[next_random() % 3][next_random() % 3];
    *value = nudge(*value, (int32_t)(next_random() % 3) - 1);
}

static void unrelated_triangles(void **state)
{
    (void)state;
    random_state = 20;
    void (*const kinds[])(struct test_case *) = {make_ordinary, make_small_integers, make_any_exponents,
                                                 make_extremes, make_far_away,       make_axis_parallel};
    for (int i = 0; i < CASES_PER_KIND; ++i) {
        struct test_case test, other;
        kinds[i % 6](&test);
        kinds[(i / 6) % 6](&other);
        check_pair(&test, &other.triangle);
    }
}

static void the_same_triangle_twice(void **state)
{
    (void)state;
    random_state = 21;
    int equal_count = 0;
    for (int i = 0; i < CASES_PER_KIND; ++i) {
        struct test_case test;
        (i % 4 ? make_ordinary : make_any_exponents)(&test);
        struct mlrt_triangle second;
        for (int j = 0; j < 3; ++j) {
            int from = i % 2 ? (i + j) % 3 : (i + 3 - j) % 3;
            memcpy(second.v[j], test.triangle.v[from], sizeof second.v[j]);
        }
        equal_count += check_pair(&test, &second);
        disturb_triangle(&second);
        check_pair(&test, &second);
    }
    assert_true(equal_count > CASES_PER_KIND / 2);
}

static void triangles_in_one_plane(void **state)
{
    (void)state;
    random_state = 22;
    int equal_count = 0;
    for (int i = 0; i < CASES_PER_KIND; ++i) {
        struct test_case test;
        fill(&test, grid_point);
        struct mlrt_triangle second;
        for (int j = 0; j < 3; ++j) {
            float p = small_integer(), q = small_integer();
            for (int k = 0; k < 3; ++k) {
                float a = test.triangle.v[0][k];
                second.v[j][k] = a + p * (test.triangle.v[1][k] - a) + q * (test.triangle.v[2][k] - a);
            }
        }
        equal_count += check_pair(&test, &second);
        disturb_triangle(&second);
        check_pair(&test, &second);
    }
    assert_true(equal_count > CASES_PER_KIND / 3);
}

static void ties_too_wide_for_a_grid(void **state)
{
    (void)state;
    random_state = 25;
    int equal_count = 0;
    for (int i = 0; i < CASES_PER_KIND; ++i) {
        struct test_case test;
        struct mlrt_triangle second;
        make_wide_corner(&test);
        for (int j = 0; j < 9; ++j) second.v[j / 3][j % 3] = any_finite_float();
        if (i % 2) {
            for (int j = 0; j < 3; ++j) {
                any_point_in_plane(test.triangle.v[j]);
                any_point_in_plane(second.v[j]);
                test.ray.origin[j] = any_finite_float();
            }
        } else {
            memcpy(second.v[i / 2 % 3], test.triangle.v[0], sizeof test.triangle.v[0]);
        }
        equal_count += check_pair(&test, &second);
        disturb_triangle(&second);
        check_pair(&test, &second);
    }
    assert_true(equal_count > CASES_PER_KIND / 2);
}

static void walls_across_one_axis(void **state)
{
    (void)state;
    random_state = 23;
    for (int i = 0; i < CASES_PER_KIND; ++i) {
        float (*const coordinate)(void) = i % 3 == 0 ? any_finite_float : i % 3 == 1 ? unit_float : small_integer;
        struct test_case test, other;
        fill(&test, coordinate);
        fill(&other, coordinate);
        uint32_t axis = next_random() % 3;
        float plane = test.triangle.v[0][axis], other_plane = nudge(plane, (int32_t)(next_random() % 3) - 1);
        for (int j = 0; j < 3; ++j) {
            test.triangle.v[j][axis] = plane;
            other.triangle.v[j][axis] = other_plane;
        }
        check_pair(&test, &other.triangle);
        float *corner = &other.triangle.v[next_random() % 3][axis]; /* no wall any more */
        *corner = nudge(*corner, 1);
        check_pair(&test, &other.triangle);
    }
}

static void triangles_that_meet_where_the_ray_hits(void **state)
{
    (void)state;
    random_state = 24;
    int equal_count = 0;
    for (int i = 0; i < CASES_PER_KIND; ++i) {
        struct test_case test, other;
        fill(&test, grid_point);
        fill(&other, grid_point);
        memcpy(other.triangle.v[i % 3], test.triangle.v[0], sizeof test.triangle.v[0]);
        aim(&test, 1, 0, 0);
        equal_count += check_pair(&test, &other.triangle);
        disturb_triangle(&other.triangle);
        check_pair(&test, &other.triangle);
    }
    assert_true(equal_count > CASES_PER_KIND / 2);
}

/* ------------------------------------------------------------------------------------------------------------------
 * Single facts
 * ------------------------------------------------------------------------------------------------------------------ */

/* A right triangle in z = depth with legs along x and y, seen along z from (x, y, z) with direction (0, 0, speed). */
static struct test_case make_facing_case(float corner, float end, float x, float y, float z, float depth, float speed)
{
    struct test_case test = {{{x, y, z}, {0, 0, speed}, 0, INFINITY, ~0u},
                             {{{corner, corner, depth}, {end, corner, depth}, {corner, end, depth}}}};
    return test;
}

static void assert_t(float z, float depth, float speed, float expected)
{
    struct test_case test = make_facing_case(-1, 2, 0, 0, z, depth, speed);
    assert_true(check_case(&test));
    mlrt_hit report;
    mlrt_report_hit(&test.ray, &test.triangle, MLRT_OUTPUT_T, &report);
    assert_true(report.t == expected);
}

static void ties_of_t_go_to_even(void **state)
{
    (void)state;
    assert_t(-0x1p24f, 1, 1, 0x1p24f);
    assert_t(-0x1p24f, 3, 1, 0x1p24f + 4);
    assert_t(-0x1p24f, 0x1.000002p0f, 1, 0x1p24f + 2);
    assert_t(-0x1p24f, 0x1.fffffep-1f, 1, 0x1p24f);
}

/* x and y with a x + b y = gcd(a, b), which is returned. */
static int64_t find_combination(int64_t a, int64_t b, int64_t *x, int64_t *y)
{
    int64_t u = 0, v = 1;
    for (*x = 1, *y = 0; b != 0;) {
        int64_t quotient = a / b, next_a = b, next_u = *x - quotient * u, next_v = *y - quotient * v;
        b = a - quotient * b;
        a = next_a;
        *x = u, *y = v;
        u = next_u, v = next_v;
    }
    return a;
}

/*
 * t = M / 2 + 1 / (2 D), M odd: nearer to the middle between two floats than any double can tell. With integers n =
 * normal, n . (2 A - M d) = 1 for a vertex at A = a - o, and A is split into a, a multiple of `unit`, and o.
 */
static void quotients_beside_a_middle(void **state)
{
    (void)state;
    random_state = 30;
    const int64_t unit = 1 << 22;
    int count = 0;
    for (int i = 0; i < CASES_PER_KIND; ++i) {
        struct test_case test = {.ray = {.t_max = INFINITY}};
        int64_t ab[3], ac[3], n[3], b[3];
        for (int k = 0; k < 3; ++k) {
            ab[k] = (int64_t)(next_random() % 0x20000) - 0x10000;
            ac[k] = (int64_t)(next_random() % 0x20000) - 0x10000;
        }
        for (int k = 0; k < 3; ++k) n[k] = ab[(k + 1) % 3] * ac[(k + 2) % 3] - ab[(k + 2) % 3] * ac[(k + 1) % 3];
        b[2] = 0;
        int64_t gcd = find_combination(n[0], n[1], &b[0], &b[1]);
        if (gcd != 1 && gcd != -1) continue;
        int64_t middle = 0x1000001 + 2 * (int64_t)(next_random() % 0x800000);
        for (int k = 0; k < 3; ++k) {
            int64_t direction = 2 * (int64_t)(next_random() % 0x80000) + (b[k] & 1);
            int64_t to_a = (b[k] + middle * direction) / 2, a = (to_a + unit / 2) / unit;
            test.ray.direction[k] = (float)direction;
            test.ray.origin[k] = (float)(a * unit - to_a);
            test.triangle.v[0][k] = (float)(a * unit);
            test.triangle.v[1][k] = (float)((a + ab[k]) * unit);
            test.triangle.v[2][k] = (float)((a + ac[k]) * unit);
        }
        struct integers *z = &first_integers;
        set_integers(z, &test);
        if (mpz_sgn(z->d) * mpz_sgn(z->n) <= 0) continue;
        mlrt_hit report;
        mlrt_report_hit(&test.ray, &test.triangle, MLRT_OUTPUT_T, &report);
        check(is_rounded_quotient(z, z->n, report.t), "t beside a middle", &test);
        check(fabs((double)report.t - (double)middle / 2) <= 0.5, "t is where it should be", &test);
        ++count;
    }
    assert_true(count > CASES_PER_KIND / 4);
}

/* Across an axis, t = M, odd and of 25 bits, or 1 / d more or less. */
static void walls_at_a_middle_and_beside_it(void **state)
{
    (void)state;
    random_state = 31;
    for (int i = 0; i < CASES_PER_KIND; ++i) {
        const int64_t unit = 1 << 20, middle = 0x1000001 + 2 * (int64_t)(next_random() % 0x800000);
        const int64_t speed = 1 + (int64_t)(next_random() % 0x10000);
        const int64_t to_wall = middle * speed + i % 3 - 1, depth = (to_wall + unit / 2) / unit * unit;
        struct test_case test = make_facing_case(-1, 2, 0, 0, (float)(depth - to_wall), (float)depth, (float)speed);
        assert_true(check_case(&test));
    }
}

static void ties_of_u_and_v_go_to_even(void **state)
{
    (void)state;
    struct test_case test = make_facing_case(-0x1p24f, 0x1p24f, 1, -3, 0, 1, 1);
    assert_true(check_case(&test));
    mlrt_hit report;
    mlrt_report_hit(&test.ray, &test.triangle, MLRT_OUTPUT_UV, &report);
    assert_true(report.u == 0.5f);
    assert_true(report.v == (0x1p24f - 3) / 0x1p25f);
    test = make_facing_case(-0x1p24f, 0x1p24f, -5, 3, 0, 1, 1);
    assert_true(check_case(&test));
    mlrt_report_hit(&test.ray, &test.triangle, MLRT_OUTPUT_UV, &report);
    assert_true(report.u == (0x1p24f - 5) / 0x1p25f);
    assert_true(report.v == (0x1p24f + 4) / 0x1p25f);
}

static void t_can_be_denormal_or_vanish(void **state)
{
    (void)state;
    assert_t(0, 0x1p-40f, 0x1p109f, 0x1p-149f);
    assert_t(0, 0x1.8p-40f, 0x1p109f, 0x1p-148f); // a tie: 1.5 to 2 units
    assert_t(0, 0x1.4p-39f, 0x1p109f, 0x1p-148f); // a tie: 2.5 to 2 units
    assert_t(0, 0x1p-41f, 0x1p109f, 0);           // a tie: 0.5 to 0 units
    assert_t(0, 0x1.000002p-41f, 0x1p109f, 0x1p-149f);
    assert_t(0, 0x1p-149f, FLT_MAX, 0);
    assert_t(0, 0x1p-149f, 0x1p-149f, 1);
}

static void t_can_overflow(void **state)
{
    (void)state;
    assert_t(1, 0x1p25f, 0x1p-103f, INFINITY); // 2^25 - 1: midway between FLT_MAX and 2^128
    assert_t(0x1.000002p0f, 0x1p25f, 0x1p-103f, FLT_MAX);
    assert_t(0x1.fffffep-1f, 0x1p25f, 0x1p-103f, INFINITY);
    assert_t(0, FLT_MAX, 1, FLT_MAX);
    assert_t(-FLT_MAX, FLT_MAX, 0x1p-149f, INFINITY);
}

/* In the plane x + z = 2^78, D is proportional to d_x + d_z: it moves t off the midpoint by less than double shows. */
static void t_close_to_overflow(void **state)
{
    (void)state;
    struct test_case test = {
        {{0, 0, 0x1p53f}, {0x1p-101f, 0, 0x1p-50f}, 0, INFINITY, ~0u},
        {{{-0x1p60f, -0x1p60f, 0x1p78f + 0x1p60f}, {0x1p60f, -0x1p60f, 0x1p78f - 0x1p60f}, {0, 0x1p60f, 0x1p78f}}}};
    assert_true(check_case(&test));
    mlrt_hit report;
    mlrt_report_hit(&test.ray, &test.triangle, MLRT_OUTPUT_T, &report);
    assert_true(report.t == FLT_MAX);
    test.ray.direction[0] = -test.ray.direction[0];
    assert_true(check_case(&test));
    mlrt_report_hit(&test.ray, &test.triangle, MLRT_OUTPUT_T, &report);
    assert_true(report.t == INFINITY);
}

static void a_hit_beyond_all_floats_needs_an_infinite_t_max(void **state)
{
    (void)state;
    struct test_case test = make_facing_case(-1, 2, 0, 0, -FLT_MAX, FLT_MAX, 1);
    assert_int_equal(mlrt_hits_triangle(&test.ray, &test.triangle, NULL), 1);
    test.ray.t_max = FLT_MAX;
    assert_int_equal(mlrt_hits_triangle(&test.ray, &test.triangle, NULL), 0);
    test.ray.t_min = FLT_MAX;
    test.ray.t_max = INFINITY;
    assert_int_equal(mlrt_hits_triangle(&test.ray, &test.triangle, NULL), 1);
}

static void the_interval_is_half_open(void **state)
{
    (void)state;
    struct test_case test = make_facing_case(-1, 2, 0, 0, 0, 3, 1);
    test.ray.t_max = 3;
    assert_int_equal(mlrt_hits_triangle(&test.ray, &test.triangle, NULL), 1);
    test.ray.t_max = nudge(3, -1);
    assert_int_equal(mlrt_hits_triangle(&test.ray, &test.triangle, NULL), 0);
    test.ray.t_max = INFINITY;
    test.ray.t_min = 3;
    assert_int_equal(mlrt_hits_triangle(&test.ray, &test.triangle, NULL), 0);
    test.ray.t_min = nudge(3, -1);
    assert_int_equal(mlrt_hits_triangle(&test.ray, &test.triangle, NULL), 1);
}

static void an_origin_in_the_triangle_misses(void **state)
{
    (void)state;
    struct test_case test = make_facing_case(-1, 2, 0, 0, 5, 5, 1);
    assert_int_equal(mlrt_hits_triangle(&test.ray, &test.triangle, NULL), 0);
    test.ray.origin[2] = nudge(5, -1);
    assert_int_equal(mlrt_hits_triangle(&test.ray, &test.triangle, NULL), 1);
    test.ray.origin[2] = nudge(5, 1);
    assert_int_equal(mlrt_hits_triangle(&test.ray, &test.triangle, NULL), 0);
}

static void corners_report_zero_and_one(void **state)
{
    (void)state;
    const float weights[3][2] = {{0, 0}, {1, 0}, {0, 1}};
    struct test_case test = make_facing_case(0.1f, 0.7f, 0, 0, -1, 2, -0.3f);
    test.ray.origin[2] = 5;
    for (int i = 0; i < 3; ++i) {
        memcpy(test.ray.origin, test.triangle.v[i], 2 * sizeof(float));
        assert_true(check_case(&test));
        mlrt_hit report;
        mlrt_report_hit(&test.ray, &test.triangle, MLRT_OUTPUT_UV, &report);
        assert_true(report.u == weights[i][0] && report.v == weights[i][1]);
        assert_false(signbit(report.u) || signbit(report.v));
    }
}

static void only_what_is_asked_for_is_written(void **state)
{
    (void)state;
    struct test_case test = make_facing_case(-1, 2, 0, 0, 0, 3, 1);
    struct test_case grazing = test; // so nearly in the plane that double cannot tell which side it faces
    for (int i = 0; i < 3; ++i) grazing.triangle.v[i][2] = 3 + 0x1p-20f * grazing.triangle.v[i][0];
    grazing.ray.direction[0] = 0x1p60f;
    grazing.ray.origin[0] = -0x1p59f;
    const struct test_case *const cases[] = {&test, &grazing};
    for (int i = 0; i < 2; ++i) {
        for (uint32_t outputs = 0; outputs < 16; ++outputs) {
            mlrt_hit report = {.t = -7, .u = -7, .v = -7, .facing = -7};
            mlrt_report_hit(&cases[i]->ray, &cases[i]->triangle, outputs, &report);
            assert_int_equal(report.t != -7, (outputs & MLRT_OUTPUT_T) != 0);
            assert_int_equal(report.u != -7, (outputs & MLRT_OUTPUT_UV) != 0);
            assert_int_equal(report.v != -7, (outputs & MLRT_OUTPUT_UV) != 0);
            assert_int_equal(report.facing != -7, (outputs & MLRT_OUTPUT_FACING) != 0);
        }
    }
}

static void triangles_without_area(void **state)
{
    (void)state;
    const struct mlrt_triangle flat[] = {{{{1, 2, 3}, {1, 2, 3}, {1, 2, 3}}},
                                         {{{1, 2, 3}, {4, 5, 6}, {1, 2, 3}}},
                                         {{{1, 2, 3}, {4, 5, 6}, {4, 5, 6}}},
                                         {{{0, 0, 0}, {1, 2, 3}, {3, 6, 9}}},
                                         {{{0.1f, 0.1f, 0.1f}, {0.2f, 0.2f, 0.2f}, {0.7f, 0.7f, 0.7f}}},
                                         {{{0, -0.0f, 0}, {-0.0f, 0, 0}, {1, 1, 1}}},
                                         {{{FLT_MAX, 0, 0}, {-FLT_MAX, 0, 0}, {0x1p-149f, 0, 0}}}};
    for (size_t i = 0; i < sizeof flat / sizeof flat[0]; ++i) {
        assert_int_equal(mlrt_triangle_has_area(&flat[i]), 0);
        struct test_case test = {{{-1, -2, -3}, {4, 5, 7}, 0, INFINITY, ~0u}, flat[i]};
        assert_int_equal(check_case(&test), 0);
    }
    const struct mlrt_triangle thin = {{{0, 0, 0}, {FLT_MAX, 0, 0}, {FLT_MAX, 0x1p-149f, 0}}};
    assert_int_equal(mlrt_triangle_has_area(&thin), 1);
    const struct mlrt_triangle tiny = {{{0, 0, 0}, {0x1p-149f, 0, 0}, {0, 0x1p-149f, 0}}};
    assert_int_equal(mlrt_triangle_has_area(&tiny), 1);
}

/* A fan around a vertex, seen along rays that meet its edges: no ray slips through. */
static void no_ray_slips_between_neighbours(void **state)
{
    (void)state;
    random_state = 30;
    for (int i = 0; i < CASES_PER_KIND / 4; ++i) {
        float corner[4][3];
        for (int j = 0; j < 4; ++j) {
            corner[j][0] = (float)(j % 2 * 2 - 1) * (1 + fabsf(unit_float()));
            corner[j][1] = (float)(j / 2 * 2 - 1) * (1 + fabsf(unit_float()));
            corner[j][2] = unit_float();
        }
        struct test_case test;
        fill(&test, unit_float);
        test.ray.origin[2] = -8;
        const int order[5] = {0, 1, 3, 2, 0};
        int hit_count = 0;
        float along = fabsf(unit_float());
        for (int k = 0; k < 3; ++k) {
            float apex = 0.25f * unit_float();
            test.triangle.v[0][k] = apex;
            test.ray.direction[k] = apex + along * (corner[i % 4][k] - apex) - test.ray.origin[k];
        }
        for (int j = 0; j < 4; ++j) {
            memcpy(test.triangle.v[1], corner[order[j]], sizeof corner[0]);
            memcpy(test.triangle.v[2], corner[order[j + 1]], sizeof corner[0]);
            hit_count += check_case(&test);
        }
        check(hit_count >= 1, "a ray through the fan", &test);
    }
}

static int set_up(void **state)
{
    (void)state;
    init_integers(&first_integers);
    init_integers(&second_integers);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    clear_integers(&first_integers);
    clear_integers(&second_integers);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_is_said_of_odd_triangles),
        cmocka_unit_test(ordinary_rays),
        cmocka_unit_test(rays_from_the_plane),
        cmocka_unit_test(small_integers),
        cmocka_unit_test(sums_in_the_plane),
        cmocka_unit_test(sums_of_any_sizes),
        cmocka_unit_test(any_exponents),
        cmocka_unit_test(extremes_in_one_triangle),
        cmocka_unit_test(far_from_the_origin),
        cmocka_unit_test(slivers),
        cmocka_unit_test(rays_at_vertices),
        cmocka_unit_test(rays_at_edges),
        cmocka_unit_test(rays_in_the_plane),
        cmocka_unit_test(axis_parallel_rays),
        cmocka_unit_test(planes_too_wide_for_a_grid),
        cmocka_unit_test(corners_too_far_for_a_grid),
        cmocka_unit_test(unrelated_triangles),
        cmocka_unit_test(the_same_triangle_twice),
        cmocka_unit_test(triangles_in_one_plane),
        cmocka_unit_test(ties_too_wide_for_a_grid),
        cmocka_unit_test(walls_across_one_axis),
        cmocka_unit_test(triangles_that_meet_where_the_ray_hits),
        cmocka_unit_test(ties_of_t_go_to_even),
        cmocka_unit_test(quotients_beside_a_middle),
        cmocka_unit_test(walls_at_a_middle_and_beside_it),
        cmocka_unit_test(ties_of_u_and_v_go_to_even),
        cmocka_unit_test(t_can_be_denormal_or_vanish),
        cmocka_unit_test(t_can_overflow),
        cmocka_unit_test(t_close_to_overflow),
        cmocka_unit_test(a_hit_beyond_all_floats_needs_an_infinite_t_max),
        cmocka_unit_test(the_interval_is_half_open),
        cmocka_unit_test(an_origin_in_the_triangle_misses),
        cmocka_unit_test(corners_report_zero_and_one),
        cmocka_unit_test(only_what_is_asked_for_is_written),
        cmocka_unit_test(triangles_without_area),
        cmocka_unit_test(no_ray_slips_between_neighbours),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
