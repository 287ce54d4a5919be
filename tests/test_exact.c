/* SPDX-License-Identifier: MIT */
/*
 * exact/big_numbers.c against GMP: conversions, sums, differences and products of numbers of every size up to the
 * largest that the hit rule can form, and the one form that each value has.
 */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>
#include <gmp.h>

#include "exact/big_numbers.h"

#define ROUNDS 20000

/* GMP numbers count units of 2^-2176, below the last bit of a product of two denormal doubles. */
#define UNIT_LIMBS 68
#define UNIT_BITS  (32 * UNIT_LIMBS)

static uint64_t random_state;

static uint32_t next_random(void)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(random_state >> 33) ^ (uint32_t)(random_state >> 13);
}

/* Any finite float: each exponent is as likely, a short mantissa as likely as a long one. */
static float random_float(void)
{
    uint32_t bits = next_random();
    if ((bits & 0x7F800000u) == 0x7F800000u) bits ^= 0x40000000u;
    if (next_random() % 2) bits &= 0xFFF00000u;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static double random_double(void)
{
    uint64_t bits = (uint64_t)next_random() << 32 | next_random();
    if ((bits >> 52 & 0x7FF) == 0x7FF) bits ^= (uint64_t)1 << 62;
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* value = mantissa * 2^exponent, without leaning on how exact/big_numbers.c takes doubles apart. */
static void set_units_of_double(mpz_t units, double value)
{
    int exponent;
    mpz_set_d(units, ldexp(frexp(value, &exponent), 53));
    mpz_mul_2exp(units, units, (mp_bitcnt_t)(UNIT_BITS + exponent - 53));
}

static void set_units(mpz_t units, const struct mlrt_exact *number)
{
    mpz_import(units, (size_t)number->count, -1, sizeof number->limb[0], 0, 0, number->limb);
    if (number->count > 0) mpz_mul_2exp(units, units, (mp_bitcnt_t)(32 * (UNIT_LIMBS + number->position)));
    if (number->sign < 0) mpz_neg(units, units);
}

/* `number` is `expected`, in its one form. */
static void assert_equals(const struct mlrt_exact *number, const mpz_t expected)
{
    mpz_t units;
    mpz_init(units);
    set_units(units, number);
    if (mpz_cmp(units, expected) != 0) print_error("random state 0x%llx\n", (unsigned long long)random_state);
    assert_true(mpz_cmp(units, expected) == 0);
    mpz_clear(units);

    assert_int_equal(number->sign, mpz_sgn(expected));
    assert_int_equal(number->count == 0, number->sign == 0);
    assert_in_range(number->count, 0, MLRT_EXACT_LIMBS);
    if (number->sign == 0) {
        assert_int_equal(number->position, 0);
    } else {
        assert_int_not_equal(number->limb[0], 0);
        assert_int_not_equal(number->limb[number->count - 1], 0);
    }
}

static void assert_double_converts(double value)
{
    mpz_t expected;
    mpz_init(expected);
    set_units_of_double(expected, value);
    struct mlrt_exact number;
    mlrt_exact_from_double(value, &number);
    assert_equals(&number, expected);
    assert_true(number.count <= 3);
    mpz_clear(expected);
}

static void doubles_convert(void **state)
{
    (void)state;
    random_state = 1;
    const double values[] = {0,       -0.0,     1,        -1,           4294967296.0, 0x1p-32,
                             DBL_MIN, -DBL_MIN, DBL_MAX,  0x1p-1074,    -0x1p-1074,   0x0.fffffffffffffp-1022,
                             FLT_MAX, FLT_MIN,  0x1p-149, 0x1.fffffep0, 0x1p128,      1.0 / 3};
    for (size_t i = 0; i < sizeof values / sizeof values[0]; ++i) assert_double_converts(values[i]);
    for (int exponent = -1074; exponent < 1024; ++exponent) assert_double_converts(ldexp(1, exponent));
    for (int i = 0; i < ROUNDS; ++i) assert_double_converts(random_double());
}

static void zero_has_one_form(void **state)
{
    (void)state;
    struct mlrt_exact zero, minus_zero;
    mlrt_exact_from_double(0.0, &zero);
    mlrt_exact_from_double(-0.0, &minus_zero);
    assert_int_equal(zero.sign, 0);
    assert_int_equal(minus_zero.sign, 0);
    assert_int_equal(zero.count, 0);
    assert_int_equal(minus_zero.count, 0);
    assert_int_equal(zero.position, minus_zero.position);
}

static void a_power_of_two_takes_one_limb(void **state)
{
    (void)state;
    for (int exponent = -149; exponent < 128; ++exponent) {
        struct mlrt_exact number;
        mlrt_exact_from_double(ldexp(1, exponent), &number);
        assert_int_equal(number.count, 1);
    }
}

static void differences_of_floats_are_exact(void **state)
{
    (void)state;
    random_state = 2;
    mpz_t first_units, second_units;
    mpz_inits(first_units, second_units, NULL);
    for (int i = 0; i < ROUNDS; ++i) {
        float first = i == 0 ? FLT_MAX : random_float(), second = i == 0 ? -0x1p-149f : random_float();
        if (i % 4 == 1) second = first * (1 + (float)(next_random() % 8) * FLT_EPSILON);
        if (!isfinite(second)) continue;
        struct mlrt_exact difference;
        mlrt_exact_from_difference(first, second, &difference);
        set_units_of_double(first_units, first);
        set_units_of_double(second_units, second);
        mpz_sub(first_units, first_units, second_units);
        assert_equals(&difference, first_units);
    }
    mpz_clears(first_units, second_units, NULL);
}

/* A sum of a few products of three floats, as a determinant is, together with its value. */
static void make_number(struct mlrt_exact *number, mpz_t units)
{
    mpz_t product, factor;
    mpz_inits(product, factor, NULL);
    mlrt_exact_from_double(0, number);
    mpz_set_ui(units, 0);
    for (uint32_t term_count = next_random() % 5; term_count > 0; --term_count) {
        struct mlrt_exact pair, triple, sum, x[3];
        mpz_set_ui(product, 1);
        for (int k = 0; k < 3; ++k) {
            float value = random_float();
            mlrt_exact_from_double(value, &x[k]);
            set_units_of_double(factor, value);
            mpz_mul(product, product, factor);
        }
        mpz_tdiv_q_2exp(product, product, 2 * UNIT_BITS);
        mlrt_exact_multiply(&x[0], &x[1], &pair);
        mlrt_exact_multiply(&pair, &x[2], &triple);
        assert_equals(&triple, product);
        mlrt_exact_add(number, &triple, &sum);
        *number = sum;
        mpz_add(units, units, product);
    }
    mpz_clears(product, factor, NULL);
}

static void sums_and_products_equal_gmp(void **state)
{
    (void)state;
    random_state = 3;
    mpz_t a_units, b_units, expected;
    mpz_inits(a_units, b_units, expected, NULL);
    for (int i = 0; i < ROUNDS / 4; ++i) {
        struct mlrt_exact a, b, result;
        make_number(&a, a_units);
        make_number(&b, b_units);
        if (i % 16 == 0) { // equal numbers cancel, nearly equal ones leave little
            b = a;
            mpz_set(b_units, a_units);
        }
        mlrt_exact_add(&a, &b, &result);
        mpz_add(expected, a_units, b_units);
        assert_equals(&result, expected);
        mlrt_exact_subtract(&a, &b, &result);
        mpz_sub(expected, a_units, b_units);
        assert_equals(&result, expected);
        mlrt_exact_multiply(&a, &b, &result);
        mpz_mul(expected, a_units, b_units);
        mpz_tdiv_q_2exp(expected, expected, UNIT_BITS);
        assert_equals(&result, expected);
        int order = mpz_cmpabs(a_units, b_units);
        assert_int_equal(mlrt_exact_compare_magnitude(&a, &b), (order > 0) - (order < 0));
    }
    mpz_clears(a_units, b_units, expected, NULL);
}

static void carries_and_borrows_run_through(void **state)
{
    (void)state;
    random_state = 4;
    mpz_t units, expected;
    mpz_inits(units, expected, NULL);
    for (int exponent = -149; exponent < 127; ++exponent) {
        // 2^127 - 2^exponent: ones all the way down, and back.
        struct mlrt_exact high, low, ones, back;
        mlrt_exact_from_double(0x1p127, &high);
        mlrt_exact_from_double(ldexp(1, exponent), &low);
        set_units_of_double(expected, 0x1p127);
        set_units_of_double(units, ldexp(1, exponent));
        mlrt_exact_add(&high, &low, &back);
        mpz_add(expected, expected, units);
        assert_equals(&back, expected);
        mpz_submul_ui(expected, units, 2);
        mlrt_exact_subtract(&high, &low, &ones);
        assert_equals(&ones, expected);
        mlrt_exact_add(&ones, &low, &back);
        assert_int_equal(mlrt_exact_compare_magnitude(&back, &high), 0);
        assert_int_equal(mlrt_exact_compare_magnitude(&ones, &high), -1);
    }
    mpz_clears(units, expected, NULL);
}

/* Every bit of a determinant set, and N1 D2 - N2 D1 with both products at their largest and opposite in sign. */
static void the_longest_products_fit(void **state)
{
    (void)state;
    mpz_t units, expected;
    mpz_inits(units, expected, NULL);
    struct mlrt_exact end, least, longest, negative, square, negative_square, result;
    mlrt_exact_from_double(0x1p389, &end);
    mlrt_exact_from_double(0x1p-447, &least);
    mlrt_exact_subtract(&end, &least, &longest);
    mlrt_exact_subtract(&least, &end, &negative);
    assert_int_equal(longest.count, MLRT_EXACT_DETERMINANT_LIMBS);
    mlrt_exact_multiply(&longest, &longest, &square);
    mlrt_exact_multiply(&longest, &negative, &negative_square);
    mlrt_exact_subtract(&square, &negative_square, &result);

    set_units(units, &longest);
    mpz_mul(expected, units, units);
    mpz_tdiv_q_2exp(expected, expected, UNIT_BITS);
    assert_equals(&square, expected);
    mpz_mul_2exp(expected, expected, 1);
    assert_equals(&result, expected);
    mpz_clears(units, expected, NULL);
}

static void doubles_come_back(void **state)
{
    (void)state;
    random_state = 6;
    for (int i = 0; i < ROUNDS; ++i) {
        float value = random_float();
        struct mlrt_exact number;
        mlrt_exact_from_double(value, &number);
        assert_true(mlrt_exact_to_double(&number) == value);
    }
    mpz_t units, back;
    mpz_inits(units, back, NULL);
    for (int i = 0; i < ROUNDS / 4; ++i) {
        struct mlrt_exact number;
        make_number(&number, units);
        set_units_of_double(back, mlrt_exact_to_double(&number));
        mpz_sub(back, back, units);
        mpz_mul_2exp(back, back, 51);
        if (mpz_cmpabs(back, units) > 0) print_error("random state 0x%llx\n", (unsigned long long)random_state);
        assert_true(mpz_cmpabs(back, units) <= 0);
    }
    mpz_clears(units, back, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(doubles_convert),
        cmocka_unit_test(zero_has_one_form),
        cmocka_unit_test(a_power_of_two_takes_one_limb),
        cmocka_unit_test(differences_of_floats_are_exact),
        cmocka_unit_test(sums_and_products_equal_gmp),
        cmocka_unit_test(carries_and_borrows_run_through),
        cmocka_unit_test(the_longest_products_fit),
        cmocka_unit_test(doubles_come_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
