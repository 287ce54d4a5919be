/* SPDX-License-Identifier: MIT */
/*
 * integers.c against GMP: each function on inputs of every width, from one binade to all floats, at both ends of them,
 * and with exact zeros and ties at every width.
 *
 * integers.c is included: its integers are also checked by themselves.
 */
#include "exact/integers.c"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#include <gmp.h>

#include "support.h"

#define CASES 60000

/* Binades between the least and the greatest coordinate that one limb has room for. */
#define WIDEST (LIMB_BITS - 28)

/* ---- input ------------------------------------------------------------------------------------------------------- */

/* Two triangles that share the first's grid or not, and a ray; a point is the ray's origin or any corner. */
struct input {
    struct mlrt_ray_segment ray;
    struct mlrt_triangle first;
    struct mlrt_triangle second;
};

/* Exponents as stored: 1..254, 0 = denormal, which has the unit of 1. */
struct window {
    uint32_t base;
    uint32_t width;
};

static uint32_t pick_mantissa(struct random *random)
{
    static const uint32_t special[] = {0, 1, 0x400000, 0x7FFFFE, 0x7FFFFF, 0x7FFFFF};
    return draw_below(random, 2) ? special[draw_below(random, 6)] : draw_bits(random) & 0x7FFFFF;
}

/* Either end of the window as often as all between. */
static float pick_float(struct random *random, struct window window)
{
    uint32_t exponent = window.base;
    switch (draw_below(random, 4)) {
    case 0:
        break;
    case 1:
        exponent += window.width;
        break;
    default:
        exponent += draw_below(random, window.width + 1);
        break;
    }
    if (draw_below(random, 16) == 0) return draw_below(random, 2) ? 0.0f : -0.0f;
    return float_of_bits((draw_bits(random) & 0x80000000u) | exponent << 23 | pick_mantissa(random));
}

static struct window pick_window(struct random *random)
{
    static const uint32_t widths[] = {WIDEST, WIDEST, WIDEST + 1, WIDEST + 1,         36,  20,
                                      3,      0,      60,         WIDEST + LIMB_BITS, 150, 253};
    struct window window = {0, widths[draw_below(random, 12)]};
    const uint32_t highest = 254 - window.width;
    switch (draw_below(random, 4)) {
    case 0:
        window.base = draw_below(random, 2); // denormals
        break;
    case 1:
        window.base = highest;
        break;
    default:
        window.base = draw_below(random, highest + 1);
        break;
    }
    return window;
}

static float *coordinate_of(struct input *input, uint32_t i)
{
    return i < 3    ? &input->ray.origin[i]
           : i < 12 ? &input->first.v[(i - 3) / 3][(i - 3) % 3]
                    : &input->second.v[(i - 12) / 3][(i - 12) % 3];
}

/* Coordinates anywhere in the window. */
static void fill_freely(struct input *input, struct random *random, struct window window)
{
    for (uint32_t i = 0; i < 21; i++) *coordinate_of(input, i) = pick_float(random, window);
}

/* The largest numbers of either sign, and few others: so sums of products come near their bounds. */
static void fill_with_largest(struct input *input, struct random *random, struct window window)
{
    const float largest = float_of_bits((window.base + window.width) << 23 | 0x7FFFFF);
    const float smallest = float_of_bits(window.base << 23 | 1);
    for (uint32_t i = 0; i < 21; i++) {
        const float size = draw_below(random, 8) ? largest : smallest;
        *coordinate_of(input, i) = draw_below(random, 2) ? size : -size;
    }
}

/* A point of the plane x + y + z = 0, or of a line in it. */
static void pick_in_plane(struct random *random, struct window window, int on_line, float point[3])
{
    const uint32_t zero = on_line ? 2 : draw_below(random, 3);
    const float size = pick_float(random, window);
    point[zero] = draw_below(random, 2) ? 0.0f : -0.0f;
    point[(zero + 1) % 3] = size;
    point[(zero + 2) % 3] = -size;
}

/* Most points in one plane, some on one line, some equal: exact zeros of every kind. */
static void fill_plane(struct input *input, struct random *random, struct window window)
{
    for (uint32_t p = 0; p < 7; p++) {
        float *point = coordinate_of(input, 3 * p);
        const uint32_t kind = draw_below(random, 16);
        if (kind == 0) {
            for (int k = 0; k < 3; k++) point[k] = pick_float(random, window);
        } else if (p > 0 && kind < 5) {
            memcpy(point, coordinate_of(input, 3 * draw_below(random, p)), 3 * sizeof *point);
        } else {
            pick_in_plane(random, window, kind < 8, point);
        }
    }
    if (draw_below(random, 4) == 0) {
        float *value = coordinate_of(input, draw_below(random, 21));
        *value = next_float(*value, *value > 0 ? -1 : 1); // towards 0, so it stays finite
    }
}

/* Small integers of one unit; the ray goes through a corner of the first triangle, which the second may share. */
static void fill_lattice(struct input *input, struct random *random, struct window window)
{
    const float unit = float_of_bits((window.base > 100 ? 100 : window.base + 10) << 23);
    for (uint32_t i = 0; i < 21; i++) *coordinate_of(input, i) = (float)((int)draw_below(random, 9) - 4) * unit;
    for (int k = 0; k < 3; k++) input->ray.direction[k] = input->first.v[0][k] - input->ray.origin[k];
    if (draw_below(random, 2)) memcpy(input->second.v[1], input->first.v[0], sizeof input->first.v[0]);
}

static void draw_input(struct input *input, struct random *random)
{
    static void (*const kinds[])(struct input *, struct random *, struct window) = {fill_freely, fill_with_largest,
                                                                                    fill_plane, fill_lattice};
    const uint32_t kind = draw_below(random, 4);
    const struct window window = pick_window(random), direction_window = pick_window(random);
    float *direction = input->ray.direction;
    input->ray.t_min = 0;
    input->ray.t_max = INFINITY;
    for (int k = 0; k < 3; k++) direction[k] = pick_float(random, direction_window);
    if (draw_below(random, 4) == 0) pick_in_plane(random, direction_window, 0, direction);
    kinds[kind](input, random, window);
}

/* ---- the same in integers ---------------------------------------------------------------------------------------- */

typedef mpz_t vector[3];

static vector origin, direction, corner[2][3], side, other_side, normal;
static mpz_t edge[2][3], d[2], n[2], left, right;
static struct {
    vector *vectors[16];
    int count;
} all_vectors;

static void init_vector(vector *v)
{
    for (int k = 0; k < 3; k++) mpz_init((*v)[k]);
    all_vectors.vectors[all_vectors.count++] = v;
}

static int set_up(void **state)
{
    (void)state;
    vector *const vectors[] = {&origin, &direction, &side, &other_side, &normal};
    for (int i = 0; i < 5; i++) init_vector(vectors[i]);
    for (int t = 0; t < 2; t++) {
        for (int i = 0; i < 3; i++) {
            init_vector(&corner[t][i]);
            mpz_init(edge[t][i]);
        }
        mpz_inits(d[t], n[t], NULL);
    }
    mpz_inits(left, right, NULL);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    for (int i = 0; i < all_vectors.count; i++) {
        for (int k = 0; k < 3; k++) mpz_clear((*all_vectors.vectors[i])[k]);
    }
    for (int t = 0; t < 2; t++) {
        for (int i = 0; i < 3; i++) mpz_clear(edge[t][i]);
        mpz_clears(d[t], n[t], NULL);
    }
    mpz_clears(left, right, NULL);
    return 0;
}

/* In units of the least float. */
static void set_vector(vector *out, const float v[3])
{
    for (int k = 0; k < 3; k++) mpz_set_d((*out)[k], ldexp((double)v[k], 149));
}

static void subtract_vectors(vector *out, vector *a, vector *b)
{
    for (int k = 0; k < 3; k++) mpz_sub((*out)[k], (*a)[k], (*b)[k]);
}

static void cross_vectors(vector *out, vector *a, vector *b)
{
    for (int k = 0; k < 3; k++) {
        mpz_mul((*out)[k], (*a)[(k + 1) % 3], (*b)[(k + 2) % 3]);
        mpz_submul((*out)[k], (*a)[(k + 2) % 3], (*b)[(k + 1) % 3]);
    }
}

static void dot_vectors(mpz_t out, vector *a, vector *b)
{
    mpz_mul(out, (*a)[0], (*b)[0]);
    mpz_addmul(out, (*a)[1], (*b)[1]);
    mpz_addmul(out, (*a)[2], (*b)[2]);
}

/* Makes corners relative to the origin, and from them edge functions, D and N. */
static void evaluate(const struct input *input)
{
    set_vector(&origin, input->ray.origin);
    set_vector(&direction, input->ray.direction);
    for (int t = 0; t < 2; t++) {
        const struct mlrt_triangle *triangle = t ? &input->second : &input->first;
        for (int i = 0; i < 3; i++) {
            set_vector(&corner[t][i], triangle->v[i]);
            subtract_vectors(&corner[t][i], &corner[t][i], &origin);
        }
        for (int i = 0; i < 3; i++) {
            cross_vectors(&normal, &corner[t][i], &corner[t][(i + 1) % 3]);
            dot_vectors(edge[t][i], &direction, &normal);
        }
        subtract_vectors(&side, &corner[t][1], &corner[t][0]);
        subtract_vectors(&other_side, &corner[t][2], &corner[t][0]);
        cross_vectors(&normal, &side, &other_side);
        dot_vectors(d[t], &direction, &normal);
        dot_vectors(n[t], &corner[t][0], &normal);
    }
}

static void fail_input(const struct input *input, uint64_t seed, const char *what)
{
    print_error("%s, random state %llu\n", what, (unsigned long long)seed);
    for (int p = 0; p < 8; p++) {
        const float *v = p == 0   ? input->ray.origin
                         : p == 1 ? input->ray.direction
                                  : (p < 5 ? input->first.v[p - 2] : input->second.v[p - 5]);
        print_error("%s %a %a %a\n",
                    p == 0   ? "origin"
                    : p == 1 ? "direction"
                             : "corner",
                    (double)v[0], (double)v[1], (double)v[2]);
    }
    fail();
}

/* ---- functions --------------------------------------------------------------------------------------------------- */

static void edge_signs(void **state)
{
    (void)state;
    struct random random = {1};
    size_t zeros = 0;
    for (size_t c = 0; c < scaled(CASES); c++) {
        const uint64_t seed = random.state;
        struct input input;
        int sign[3] = {0, 0, 0}, expected[3];
        draw_input(&input, &random);
        evaluate(&input);
        for (int i = 0; i < 3; i++) {
            expected[i] = mpz_sgn(edge[0][i]);
            if (draw_below(&random, 3) == 0) sign[i] = expected[i]; // known before
        }
        mlrt_exact_edge_signs(&input.ray, &input.first, sign);
        if (memcmp(sign, expected, sizeof sign) != 0) fail_input(&input, seed, "edge signs");
        zeros += sign[0] == 0 || sign[1] == 0 || sign[2] == 0;
    }
    assert_true(zeros > scaled(CASES) / 50);
}

static void signs_that_are_known_are_kept(void **state)
{
    (void)state;
    const struct mlrt_ray_segment ray = {{0, 0, 0}, {0, 0, 1}, 0, INFINITY, ~0u};
    const struct mlrt_triangle triangle = {{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}};
    for (int known = -1; known <= 1; known += 2) {
        int sign[3] = {known, known, known};
        mlrt_exact_edge_signs(&ray, &triangle, sign);
        for (int i = 0; i < 3; i++) assert_int_equal(sign[i], known);
    }
}

static void directions_of_edges(void **state)
{
    (void)state;
    struct random random = {2};
    for (size_t c = 0; c < scaled(CASES); c++) {
        const uint64_t seed = random.state;
        struct input input;
        draw_input(&input, &random);
        const int i = (int)draw_below(&random, 3);
        if (draw_below(&random, 4) == 0) { // parallel, or nearly
            for (int k = 0; k < 3; k++) input.ray.direction[k] = input.first.v[(i + 1) % 3][k] - input.first.v[i][k];
            for (int k = 0; k < 3; k++)
                if (!isfinite(input.ray.direction[k])) input.ray.direction[k] = 1;
        }
        evaluate(&input);
        subtract_vectors(&side, &corner[0][(i + 1) % 3], &corner[0][i]);
        cross_vectors(&normal, &direction, &side);
        const int x = mpz_sgn(normal[0]), y = mpz_sgn(normal[1]), expected = x ? x : y ? y : mpz_sgn(normal[2]);
        if (mlrt_exact_edge_direction(&input.ray, &input.first, i) != expected) fail_input(&input, seed, "direction");
    }
}

static void sides(void **state)
{
    (void)state;
    struct random random = {3};
    size_t zeros = 0;
    for (size_t c = 0; c < scaled(CASES); c++) {
        const uint64_t seed = random.state;
        struct input input;
        draw_input(&input, &random);
        const float *by = draw_below(&random, 2) ? input.second.v[0] : (const float[3]){0, 0, -0.0f};
        evaluate(&input);
        subtract_vectors(&side, &corner[0][1], &corner[0][0]);
        subtract_vectors(&other_side, &corner[0][2], &corner[0][0]);
        cross_vectors(&normal, &side, &other_side);
        set_vector(&side, by);
        subtract_vectors(&side, &side, &corner[0][0]); // corners are relative to the origin
        dot_vectors(left, &side, &normal);
        const int sign = -mlrt_exact_sign_beyond(input.ray.origin, by, &input.first, 1);
        if (sign != mpz_sgn(left)) fail_input(&input, seed, "side");
        zeros += sign == 0;
    }
    assert_true(zeros > scaled(CASES) / 50);
}

static void signs_beyond(void **state)
{
    (void)state;
    struct random random = {8};
    for (size_t c = 0; c < scaled(CASES); c++) {
        const uint64_t seed = random.state;
        struct input input;
        draw_input(&input, &random);
        evaluate(&input);
        if (mpz_sgn(direction[0]) == 0 && mpz_sgn(direction[1]) == 0 && mpz_sgn(direction[2]) == 0) continue;
        const double quotient = mpz_get_d(n[0]) / mpz_get_d(d[0]);
        float t = draw_below(&random, 4) ? fabsf(pick_float(&random, pick_window(&random))) : (float)fabs(quotient);
        if (!isfinite(t)) t = 0;
        mpz_set_d(right, ldexp((double)t, 149));
        mpz_mul(right, right, d[0]);
        mpz_mul_2exp(left, n[0], 149);
        const int order = mpz_cmp(left, right), expected = (order > 0) - (order < 0);
        if (mlrt_exact_sign_beyond(input.ray.origin, input.ray.direction, &input.first, t) != expected)
            fail_input(&input, seed, "sign beyond");
    }
}

static void orders(void **state)
{
    (void)state;
    struct random random = {4};
    size_t answered = 0, zeros = 0;
    for (size_t c = 0; c < scaled(2 * CASES); c++) {
        const uint64_t seed = random.state;
        struct input input;
        draw_input(&input, &random);
        evaluate(&input);
        if (mpz_sgn(d[0]) == 0 || mpz_sgn(d[1]) == 0) continue; // not a question
        answered++;
        mpz_mul(left, n[0], d[1]);
        mpz_mul(right, n[1], d[0]);
        const int order = mpz_cmp(left, right);
        const int expected = mpz_sgn(d[0]) * mpz_sgn(d[1]) * ((order > 0) - (order < 0));
        const int sign = mlrt_exact_order(&input.ray, &input.first, &input.second);
        if (sign != expected) fail_input(&input, seed, "order");
        zeros += sign == 0;
    }
    assert_true(answered > scaled(CASES) / 4);
    assert_true(zeros > scaled(CASES) / 50);
}

/* |x / d|, with a relative error below 2^-50. Any of them may be far out of the range of doubles. */
static double quotient_of(const mpz_t x, const mpz_t divisor)
{
    long x_exponent, exponent;
    const double size = mpz_get_d_2exp(&x_exponent, x), of = mpz_get_d_2exp(&exponent, divisor);
    return ldexp(fabs(size / of), (int)(x_exponent - exponent));
}

/*
 * One of the two floats next to the quotient, unless that is negative, which no hit has. test_predicate.c knows which.
 */
static int is_close_quotient(float q, const mpz_t x)
{
    const double quotient = quotient_of(x, d[0]);
    return mpz_sgn(x) * mpz_sgn(d[0]) < 0 || q == (float)(quotient * (1 - 0x1p-49)) ||
           q == (float)(quotient * (1 + 0x1p-49));
}

static void quotients(void **state)
{
    (void)state;
    struct random random = {5};
    size_t answered = 0;
    for (size_t c = 0; c < scaled(CASES); c++) {
        const uint64_t seed = random.state;
        struct input input;
        mlrt_hit report;
        draw_input(&input, &random);
        evaluate(&input);
        if (mpz_sgn(d[0]) == 0) continue; // not a question
        answered++;
        mlrt_exact_report(&input.ray, &input.first, MLRT_OUTPUT_T | MLRT_OUTPUT_UV | MLRT_OUTPUT_FACING, &report);
        if (report.facing != mpz_sgn(d[0])) fail_input(&input, seed, "facing");
        if (!is_close_quotient(report.t, n[0])) fail_input(&input, seed, "t");
        if (!is_close_quotient(report.u, edge[0][2])) fail_input(&input, seed, "u");
        if (!is_close_quotient(report.v, edge[0][0])) fail_input(&input, seed, "v");
    }
    assert_true(answered > scaled(CASES) / 4);
}

/* ---- the integers themselves ------------------------------------------------------------------------------------- */

/* The number whose limbs these are, in two's complement. */
static void set_integer(mpz_t out, const struct integer *a, int count)
{
    mpz_import(out, (size_t)count, -1, sizeof *a->limbs, 0, 0, a->limbs);
    if (!is_negative(a, count)) return;
    mpz_set_ui(right, 1);
    mpz_mul_2exp(right, right, (mp_bitcnt_t)(count * LIMB_BITS));
    mpz_sub(out, out, right);
}

/* Any limbs, but ends of their range as often. */
static void pick_integer(struct random *random, int count, struct integer *a)
{
    static const limb ends[] = {0, 1, (limb)-1, (limb)-2, (limb)1 << (LIMB_BITS - 1)};
    for (int i = 0; i < count; i++) {
        const uint64_t bits = (uint64_t)draw_bits(random) << 32 | draw_bits(random);
        a->limbs[i] = draw_below(random, 2) ? ends[draw_below(random, 5)] : (limb)bits;
    }
}

static void sums_and_products(void **state)
{
    (void)state;
    struct random random = {6};
    for (size_t c = 0; c < scaled(CASES); c++) {
        struct integer a, b, product;
        const int a_count = 1 + (int)draw_below(&random, LIMB_LIMIT / 2);
        const int b_count = 1 + (int)draw_below(&random, LIMB_LIMIT / 2);
        pick_integer(&random, a_count, &a);
        pick_integer(&random, b_count, &b);
        set_integer(edge[0][0], &a, a_count);
        set_integer(edge[0][1], &b, b_count);
        assert_int_equal(sign_of(&a, a_count), mpz_sgn(edge[0][0]));
        mpz_mul(left, edge[0][0], edge[0][1]);
        multiply(&a, a_count, &b, b_count, &product);
        set_integer(d[0], &product, a_count + b_count);
        if (mpz_cmp(left, d[0]) != 0) fail_msg("product %zu", c);
        mpz_abs(edge[0][2], edge[0][0]);
        long exponent;
        const double size = mpz_get_d_2exp(&exponent, edge[0][2]);
        if (fabs(ldexp(size_of(&a, a_count), -(int)exponent) - size) > 0x1p-46) fail_msg("size %zu", c);

        /* a + b and a - b, modulo the range of as many limbs */
        struct integer sum = a;
        pick_integer(&random, a_count, &b);
        set_integer(edge[0][1], &b, a_count);
        const int minus = (int)draw_below(&random, 2);
        add_limbs(minus ? -1 : 1, b.limbs, a_count, sum.limbs);
        (minus ? mpz_sub : mpz_add)(left, edge[0][0], edge[0][1]);
        set_integer(d[0], &sum, a_count);
        mpz_sub(left, left, d[0]);
        mpz_fdiv_r_2exp(left, left, (mp_bitcnt_t)(a_count * LIMB_BITS));
        if (mpz_sgn(left) != 0) fail_msg("sum %zu", c);
    }
}

static void products_are_compared(void **state)
{
    (void)state;
    struct random random = {7};
    size_t equal = 0;
    for (size_t c = 0; c < scaled(CASES); c++) {
        struct integer x[4];
        for (int i = 0; i < 4; i++) {
            pick_integer(&random, 3, &x[i]);
            x[i].limbs[2] =
                (limb)((x[i].limbs[2] & 15) - 8); // determinants leave room for the difference of two products
        }
        if (draw_below(&random, 2)) { // the same product, or nearly
            x[2] = x[1];
            x[3] = x[0];
            if (draw_below(&random, 2)) x[3].limbs[draw_below(&random, 2)] ^= 1;
        }
        for (int i = 0; i < 4; i++) set_integer(i < 2 ? edge[0][i] : edge[1][i - 2], &x[i], 3);
        mpz_mul(left, edge[0][0], edge[0][1]);
        mpz_mul(right, edge[1][0], edge[1][1]);
        const int order = mpz_cmp(left, right), expected = (order > 0) - (order < 0);
        if (sign_of_difference(&x[0], &x[1], &x[2], &x[3], 3, 3) != expected) fail_msg("difference %zu", c);
        equal += expected == 0;
    }
    assert_true(equal > scaled(CASES) / 10);
}

/* ---- widths by hand ---------------------------------------------------------------------------------------------- */

/* 1.11..1 2^WIDEST beside 1 takes one limb, wherever both are, and no more does. */
static void the_widest_limb(void **state)
{
    (void)state;
    for (int base = -149; base + WIDEST + 1 < 128; base++) {
        struct extent extent = NO_EXTENT;
        extend(-ldexp(1, base), &extent);
        extend(ldexp(0x1.fffffep0, base + WIDEST), &extent);
        assert_int_equal(count_limbs(&extent), 1);
        extend(ldexp(1, base + WIDEST + 1), &extent);
        assert_int_equal(count_limbs(&extent), 2);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edge_signs),
        cmocka_unit_test(signs_that_are_known_are_kept),
        cmocka_unit_test(directions_of_edges),
        cmocka_unit_test(sides),
        cmocka_unit_test(signs_beyond),
        cmocka_unit_test(orders),
        cmocka_unit_test(quotients),
        cmocka_unit_test(sums_and_products),
        cmocka_unit_test(products_are_compared),
        cmocka_unit_test(the_widest_limb),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
