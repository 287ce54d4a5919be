/* SPDX-License-Identifier: MIT */
/*
 * grid.c against GMP integers: each function on inputs that are as wide as a grid may be, one binade wider, at both
 * ends of the floats, and with exact zeros and ties at every width.
 *
 * grid.c is included: its integers are also checked by themselves.
 */
#include "exact/grid.c"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#include <gmp.h>

#include "support.h"

#if MLRT_HAVE_INT128

#define CASES 120000

/* Binades between the least and the greatest coordinate that still fit: 61 bits, of which 24 are a float's own. */
#define WIDEST 37

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
    static const uint32_t widths[] = {WIDEST, WIDEST, WIDEST, WIDEST + 1, WIDEST + 1, 36, 20, 3, 0, 60};
    struct window window = {0, widths[draw_below(random, 10)]};
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

/* What grid.h says, by other means: all are multiples of 2^unit, less than 2^61 of them. */
struct frame {
    int unit;
    int highest; /* all are below 2^highest */
};

static const struct frame no_frame = {1000, -1000};

static void widen(struct frame *frame, const float v[3])
{
    for (int k = 0; k < 3; k++) {
        int exponent;
        if (v[k] == 0) continue;
        frexpf(v[k], &exponent); // below 2^exponent
        if (exponent > frame->highest) frame->highest = exponent;
        if (exponent - 24 < frame->unit) frame->unit = exponent - 24 < -149 ? -149 : exponent - 24;
    }
}

static void widen_by_triangle(struct frame *frame, const struct mlrt_triangle *triangle)
{
    for (int i = 0; i < 3; i++) widen(frame, triangle->v[i]);
}

static int fits(struct frame frame)
{
    return frame.highest - frame.unit <= 61;
}

static int direction_fits(const struct input *input)
{
    struct frame frame = no_frame;
    widen(&frame, input->ray.direction);
    return fits(frame);
}

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

static void set_vector(vector *out, const float v[3], int unit)
{
    for (int k = 0; k < 3; k++) mpz_set_d((*out)[k], ldexp((double)v[k], -unit));
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

/* Makes corners relative to the origin, and from them edge functions, D and N. Returns the unit of points. */
static int evaluate(const struct input *input)
{
    struct frame frame = no_frame, direction_frame = no_frame;
    widen(&frame, input->ray.origin);
    widen_by_triangle(&frame, &input->first);
    widen_by_triangle(&frame, &input->second);
    widen(&direction_frame, input->ray.direction);
    set_vector(&origin, input->ray.origin, frame.unit);
    set_vector(&direction, input->ray.direction, direction_frame.unit);
    for (int t = 0; t < 2; t++) {
        const struct mlrt_triangle *triangle = t ? &input->second : &input->first;
        for (int i = 0; i < 3; i++) {
            set_vector(&corner[t][i], triangle->v[i], frame.unit);
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
    return frame.unit - direction_frame.unit;
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

/* How often something came up that a test is about. */
struct tally {
    size_t on_grid;
    size_t off_grid;
    size_t zeros;
};

static void assert_all_kinds(struct tally tally)
{
    assert_true(tally.on_grid > scaled(CASES) / 4);
    assert_true(tally.off_grid > scaled(CASES) / 10);
    assert_true(tally.zeros > scaled(CASES) / 50);
}

/* Counts a case; 1 if there is an answer to look at. */
static int count_case(struct tally *tally, int answered, int expected, const struct input *input, uint64_t seed)
{
    if (answered != expected) fail_input(input, seed, expected ? "fits, but no answer" : "an answer that cannot be");
    *(answered ? &tally->on_grid : &tally->off_grid) += 1;
    return answered;
}

/* ---- functions --------------------------------------------------------------------------------------------------- */

static void edge_signs(void **state)
{
    (void)state;
    struct random random = {1};
    struct tally tally = {0, 0, 0};
    for (size_t c = 0; c < scaled(CASES); c++) {
        const uint64_t seed = random.state;
        struct input input;
        struct frame frame = no_frame;
        int sign[3] = {0, 0, 0}, expected[3];
        draw_input(&input, &random);
        widen(&frame, input.ray.origin);
        widen_by_triangle(&frame, &input.first);
        const int expect_answer = fits(frame) && direction_fits(&input);
        if (expect_answer) evaluate(&input);
        for (int i = 0; i < 3; i++) {
            expected[i] = expect_answer ? mpz_sgn(edge[0][i]) : 0;
            if (draw_below(&random, 3) == 0) sign[i] = expected[i]; // known before
        }
        const int answered = mlrt_grid_edge_signs(&input.ray, &input.first, sign);
        if (!count_case(&tally, answered, expect_answer, &input, seed)) continue;
        if (memcmp(sign, expected, sizeof sign) != 0) fail_input(&input, seed, "edge signs");
        tally.zeros += sign[0] == 0 || sign[1] == 0 || sign[2] == 0;
    }
    assert_all_kinds(tally);
}

static void signs_that_are_known_are_kept(void **state)
{
    (void)state;
    const struct mlrt_ray_segment ray = {{0, 0, 0}, {0, 0, 1}, 0, INFINITY, ~0u};
    const struct mlrt_triangle triangle = {{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}};
    for (int known = -1; known <= 1; known += 2) {
        int sign[3] = {known, known, known};
        assert_int_equal(mlrt_grid_edge_signs(&ray, &triangle, sign), 1);
        for (int i = 0; i < 3; i++) assert_int_equal(sign[i], known);
    }
}

static void distance_signs(void **state)
{
    (void)state;
    struct random random = {3};
    struct tally tally = {0, 0, 0};
    for (size_t c = 0; c < scaled(CASES); c++) {
        const uint64_t seed = random.state;
        struct input input;
        struct frame frame = no_frame;
        int sign = -2;
        draw_input(&input, &random);
        widen(&frame, input.ray.origin);
        widen_by_triangle(&frame, &input.first);
        const int answered = mlrt_grid_distance_sign(&input.first, input.ray.origin, &sign);
        if (!count_case(&tally, answered, fits(frame), &input, seed)) continue;
        evaluate(&input);
        if (sign != mpz_sgn(n[0])) fail_input(&input, seed, "distance sign");
        tally.zeros += sign == 0;
    }
    assert_all_kinds(tally);
}

static void orders(void **state)
{
    (void)state;
    struct random random = {4};
    struct tally tally = {0, 0, 0};
    size_t unanswered = 0;
    for (size_t c = 0; c < scaled(2 * CASES); c++) {
        const uint64_t seed = random.state;
        struct input input;
        struct frame frame = no_frame;
        int sign = -2;
        draw_input(&input, &random);
        widen(&frame, input.ray.origin);
        widen_by_triangle(&frame, &input.first);
        widen_by_triangle(&frame, &input.second);
        const int answered = mlrt_grid_order(&input.ray, &input.first, &input.second, &sign);
        if (!count_case(&tally, answered, fits(frame) && direction_fits(&input), &input, seed)) continue;
        evaluate(&input);
        if (mpz_sgn(d[0]) == 0 || mpz_sgn(d[1]) == 0) { // not a question
            unanswered++;
            continue;
        }
        mpz_mul(left, n[0], d[1]);
        mpz_mul(right, n[1], d[0]);
        const int order = mpz_cmp(left, right);
        const int expected = mpz_sgn(d[0]) * mpz_sgn(d[1]) * ((order > 0) - (order < 0));
        if (sign != expected) fail_input(&input, seed, "order");
        tally.zeros += sign == 0;
    }
    assert_all_kinds(tally);
    assert_true(tally.on_grid - unanswered > scaled(CASES) / 4);
}

/* |q d - x 2^unit| 2^49 <= |x 2^unit|, for q >= 0 */
static int is_close_quotient(double q, const mpz_t x, const mpz_t divisor, int unit)
{
    int exponent;
    if (!(q >= 0) || isinf(q)) return 0;
    mpz_set_d(left, ldexp(frexp(q, &exponent), 53));
    exponent -= 53;
    mpz_mul(left, left, divisor);
    mpz_abs(left, left);
    mpz_abs(right, x);
    const int shift = exponent - unit; // left 2^shift against right
    if (shift >= 0) {
        mpz_mul_2exp(left, left, (mp_bitcnt_t)shift);
    } else {
        mpz_mul_2exp(right, right, (mp_bitcnt_t)-shift);
    }
    mpz_sub(left, left, right);
    mpz_mul_2exp(left, left, 49);
    return mpz_cmpabs(left, right) <= 0;
}

static void quotients(void **state)
{
    (void)state;
    struct random random = {5};
    struct tally tally = {0, 0, 0};
    size_t unanswered = 0;
    for (size_t c = 0; c < scaled(CASES); c++) {
        const uint64_t seed = random.state;
        struct input input;
        struct frame frame = no_frame;
        double quotient[3];
        draw_input(&input, &random);
        widen(&frame, input.ray.origin);
        widen_by_triangle(&frame, &input.first);
        const int answered = mlrt_grid_quotients(&input.ray, &input.first, quotient);
        if (!count_case(&tally, answered, fits(frame) && direction_fits(&input), &input, seed)) continue;
        const int unit = evaluate(&input);
        if (mpz_sgn(d[0]) == 0) { // not a question
            unanswered++;
            continue;
        }
        if (!is_close_quotient(quotient[0], n[0], d[0], unit)) fail_input(&input, seed, "t");
        if (!is_close_quotient(quotient[1], edge[0][2], d[0], 0)) fail_input(&input, seed, "u");
        if (!is_close_quotient(quotient[2], edge[0][0], d[0], 0)) fail_input(&input, seed, "v");
        tally.zeros += quotient[0] == 0 || quotient[1] == 0 || quotient[2] == 0;
    }
    assert_all_kinds(tally);
    assert_true(tally.on_grid - unanswered > scaled(CASES) / 4);
}

/* ---- the integers themselves ------------------------------------------------------------------------------------- */

static void set_words(mpz_t out, const uint64_t *word, size_t count)
{
    mpz_import(out, count, -1, sizeof *word, 0, 0, word);
}

/* The ends of what differences can be, and anything in between. */
static int64_t pick_difference(struct random *random)
{
    static const int64_t ends[] = {0, 1, -1, INT64_C(1) << 62, -(INT64_C(1) << 62), (INT64_C(1) << 62) - 1, 1 << 30};
    if (draw_below(random, 2)) return ends[draw_below(random, 7)];
    const uint64_t bits = (uint64_t)draw_bits(random) << 32 | draw_bits(random);
    const int64_t size = (int64_t)(bits >> (2 + draw_below(random, 62)));
    return draw_below(random, 2) ? size : -size;
}

static void determinants_of_the_largest_differences(void **state)
{
    (void)state;
    struct random random = {6};
    size_t widest = 0;
    for (size_t c = 0; c < scaled(CASES); c++) {
        int64_t rows[3][3];
        for (int i = 0; i < 9; i++) rows[i / 3][i % 3] = pick_difference(&random);
        if (draw_below(&random, 8) == 0) memcpy(rows[1], rows[0], sizeof rows[0]); // all components cancel
        const struct determinant got = determinant_of(rows[0], rows[1], rows[2]);
        for (int k = 0; k < 3; k++) {
            mpz_set_si(side[k], rows[0][k]);
            mpz_set_si(other_side[k], rows[1][k]);
            mpz_set_si(origin[k], rows[2][k]);
        }
        cross_vectors(&normal, &side, &other_side);
        dot_vectors(left, &normal, &origin);
        set_words(right, got.word, 3);
        if (mpz_sgn(left) != got.sign || mpz_cmpabs(left, right) != 0) fail_msg("case %zu", c);
        const size_t bits = mpz_sizeinbase(left, 2);
        if (bits > widest) widest = bits;
    }
    assert_true(widest >= 188);
}

static void products_of_determinants(void **state)
{
    (void)state;
    struct random random = {7};
    static const uint64_t special[] = {0, 1, UINT64_MAX, UINT64_MAX - 1, UINT64_C(1) << 63};
    size_t equal = 0;
    for (size_t c = 0; c < scaled(CASES); c++) {
        struct determinant x[4];
        for (int i = 0; i < 4; i++) {
            for (int w = 0; w < 3; w++) {
                const uint64_t bits = (uint64_t)draw_bits(&random) << 32 | draw_bits(&random);
                x[i].word[w] = draw_below(&random, 2) ? special[draw_below(&random, 5)] : bits;
            }
            x[i].sign = draw_below(&random, 2) ? 1 : -1;
        }
        if (draw_below(&random, 2)) { // the same product, or nearly
            x[2] = x[1];
            x[3] = x[0];
            if (draw_below(&random, 2)) x[3].word[draw_below(&random, 3)] ^= 1;
        }
        mpz_t value[4];
        for (int i = 0; i < 4; i++) {
            mpz_init(value[i]);
            set_words(value[i], x[i].word, 3);
            if (mpz_sgn(value[i]) == 0) x[i].sign = 0;
            if (x[i].sign < 0) mpz_neg(value[i], value[i]);
        }
        mpz_mul(left, value[0], value[1]);
        mpz_mul(right, value[2], value[3]);
        const int order = mpz_cmp(left, right), expected = (order > 0) - (order < 0);
        uint64_t product[6];
        multiply_magnitudes(&x[0], &x[1], product);
        set_words(right, product, 6);
        if (mpz_cmpabs(left, right) != 0) fail_msg("product %zu", c);
        if (sign_of_difference(&x[0], &x[1], &x[2], &x[3]) != expected) fail_msg("difference %zu", c);
        equal += expected == 0;
        for (int i = 0; i < 4; i++) mpz_clear(value[i]);
    }
    assert_true(equal > scaled(CASES) / 10);
}

/* ---- widths by hand ---------------------------------------------------------------------------------------------- */

/* 1.11..1 2^WIDEST beside 1 fits, wherever both are, and nothing beyond does. */
static void the_widest_grid(void **state)
{
    (void)state;
    for (uint32_t base = 0; base + WIDEST + 1 <= 254; base++) {
        const uint32_t unit = base ? base : 1; // denormals share the unit of the first binade
        const float small = float_of_bits(base << 23 | 1), large = float_of_bits((unit + WIDEST) << 23 | 0x7FFFFF);
        const float larger = float_of_bits((unit + WIDEST + 1) << 23);
        struct mlrt_ray_segment ray = {{-small, 0, 0}, {0, 0, 1}, 0, INFINITY, ~0u};
        struct mlrt_triangle triangle = {{{large, -large, -0.0f}, {-large, large, 0}, {large, large, large}}};
        int sign = -2, signs[3] = {0, 0, 0};
        double quotient[3];
        assert_int_equal(mlrt_grid_distance_sign(&triangle, ray.origin, &sign), 1);
        assert_int_equal(sign, 1); // the first edge passes above the origin, on the side of n
        assert_int_equal(mlrt_grid_edge_signs(&ray, &triangle, signs), 1);
        assert_int_equal(mlrt_grid_order(&ray, &triangle, &triangle, &sign), 1);
        assert_int_equal(sign, 0);
        assert_int_equal(mlrt_grid_quotients(&ray, &triangle, quotient), 1);
        triangle.v[0][0] = larger;
        assert_int_equal(mlrt_grid_distance_sign(&triangle, ray.origin, &sign), 0);
        assert_int_equal(mlrt_grid_edge_signs(&ray, &triangle, signs), 0);
        assert_int_equal(mlrt_grid_order(&ray, &triangle, &triangle, &sign), 0);
        assert_int_equal(mlrt_grid_quotients(&ray, &triangle, quotient), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edge_signs),
        cmocka_unit_test(signs_that_are_known_are_kept),
        cmocka_unit_test(distance_signs),
        cmocka_unit_test(orders),
        cmocka_unit_test(quotients),
        cmocka_unit_test(determinants_of_the_largest_differences),
        cmocka_unit_test(products_of_determinants),
        cmocka_unit_test(the_widest_grid),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

#else

static void there_is_no_grid(void **state)
{
    (void)state;
    const struct mlrt_ray_segment ray = {{0, 0, 0}, {0, 0, 1}, 0, INFINITY, ~0u};
    const struct mlrt_triangle triangle = {{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}};
    int sign[3] = {0, 0, 0};
    double quotient[3];
    assert_int_equal(mlrt_grid_edge_signs(&ray, &triangle, sign), 0);
    assert_int_equal(mlrt_grid_distance_sign(&triangle, ray.origin, sign), 0);
    assert_int_equal(mlrt_grid_order(&ray, &triangle, &triangle, sign), 0);
    assert_int_equal(mlrt_grid_quotients(&ray, &triangle, quotient), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(there_is_no_grid)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#endif
