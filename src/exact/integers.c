/* SPDX-License-Identifier: MIT */
/*
 * Coordinates as integers, and their determinants, by the schoolbook methods.
 *
 * A double of 25 bits (a float, or a number midway between two) is a multiple of 2^(e - 24), where 2^e is the highest
 * power of two not above its magnitude. Let `least` and `greatest` be the extremes of e over the numbers that share a
 * grid. In units of 2^(least - 24) all are integers below 2^b, b = greatest - least + 25. Signs do not depend on the
 * unit. Every quantity is linear in the direction, so the direction has a unit of its own.
 *
 * An integer has a whole number of limbs, in two's complement. Let n limbs have b + 3 bits or more. Then n limbs have
 * room for a difference of two coordinates (below 2^(b + 1)), 2 n for a component of a cross product of differences
 * (below 2^(2 b + 3)), 3 n for a determinant (below 2^(3 b + 6)), and as many limbs as both factors for a product. With
 * limbs of 64 bits n is 1 unless magnitudes differ by more than 2^36. Floats are multiples of 2^-149 below 2^128, so b
 * is at most 301, and the longest product, N1 D2, takes 6 n limbs.
 *
 * Based on: Donald E. Knuth, "The Art of Computer Programming", volume 2, 1997, section 4.3.1 (algorithms A, S, M).
 */
#include "exact/integers.h"

#include <assert.h>
#include <float.h>
#include <string.h>

#include "base/platform.h"

#if defined(__SIZEOF_INT128__)
typedef uint64_t limb;
typedef int64_t signed_limb;
__extension__ typedef unsigned __int128 two_limbs;
__extension__ typedef __int128 signed_two_limbs;
#else
typedef uint32_t limb;
typedef int32_t signed_limb;
typedef uint64_t two_limbs;
typedef int64_t signed_two_limbs;
#endif

#define LIMB_BITS  (8 * (int)sizeof(limb))
#define LIMB_RANGE (2.0 * ((limb)1 << (LIMB_BITS - 1)))
#define LIMB_LIMIT (6 * ((301 + 3) / LIMB_BITS + 1))

/* The lowest limb comes first. How many there are follows from the grid. */
struct integer {
    limb limbs[LIMB_LIMIT];
};

struct integer_vector {
    struct integer x[3];
};

/* ---- integers ---------------------------------------------------------------------------------------------------- */

/* sum += factor * other; the factor is -1 or 1. Carries out of the highest limb are dropped. */
MLRT_INLINE void add_limbs(int factor, const limb *other, int count, limb *sum)
{
    const limb flip = factor < 0 ? ~(limb)0 : 0;
    two_limbs carry = flip & 1;
    for (int i = 0; i < count; ++i) {
        carry += (two_limbs)sum[i] + (other[i] ^ flip);
        sum[i] = (limb)carry;
        carry >>= LIMB_BITS;
    }
}

MLRT_INLINE int is_negative(const struct integer *a, int count)
{
    return (int)(a->limbs[count - 1] >> (LIMB_BITS - 1));
}

static int sign_of(const struct integer *a, int count)
{
    limb all = 0;
    for (int i = 0; i < count; ++i) all |= a->limbs[i];
    return is_negative(a, count) ? -1 : all != 0;
}

/* product = a b, of as many limbs as both */
MLRT_INLINE void multiply(const struct integer *a, int a_count, const struct integer *b, int b_count,
                          struct integer *product)
{
    for (int j = 0; j < b_count; ++j) product->limbs[j] = 0;
    for (int i = 0; i < a_count; ++i) {
        two_limbs carry = 0; /* with R = 2^LIMB_BITS: (R - 1)^2 + 2 (R - 1) = R^2 - 1, so a step cannot overflow */
        for (int j = 0; j < b_count; ++j) {
            carry += (two_limbs)a->limbs[i] * b->limbs[j] + product->limbs[i + j];
            product->limbs[i + j] = (limb)carry;
            carry >>= LIMB_BITS;
        }
        product->limbs[i + b_count] = (limb)carry;
    }
    /* The limbs of a negative number are those of a number R^count greater. */
    if (is_negative(a, a_count)) add_limbs(-1, b->limbs, b_count, product->limbs + a_count);
    if (is_negative(b, b_count)) add_limbs(-1, a->limbs, a_count, product->limbs + b_count);
}

/* The sign of a b - c d, for a and c of `count` limbs, b and d of `factor_count`. */
static int sign_of_difference(const struct integer *a, const struct integer *b, const struct integer *c,
                              const struct integer *d, int count, int factor_count)
{
    struct integer plus, minus;
    assert(count + factor_count <= LIMB_LIMIT);
    multiply(a, count, b, factor_count, &plus);
    multiply(c, count, d, factor_count, &minus);
    add_limbs(-1, minus.limbs, count + factor_count, plus.limbs);
    return sign_of(&plus, count + factor_count);
}

/* The sign of the first component that is not 0; else 0. */
static int first_sign(const struct integer_vector *v, int count)
{
    int sign = 0;
    for (int k = 0; k < 3 && sign == 0; ++k) sign = sign_of(&v->x[k], count);
    return sign;
}

/* The magnitude, with a relative error below 2^-46: two roundings for each of at most 30 limbs. */
static double size_of(const struct integer *a, int count)
{
    struct integer size = {{0}};
    double sum = 0;
    add_limbs(is_negative(a, count) ? -1 : 1, a->limbs, count, size.limbs);
    for (int i = count; i-- > 0;) sum = sum * LIMB_RANGE + (double)size.limbs[i];
    return sum;
}

/* v x w, for vectors of coordinates */
static void cross(const struct integer_vector *v, const struct integer_vector *w, int count,
                  struct integer_vector *product)
{
    for (int k = 0; k < 3; ++k) {
        const struct integer *a = &v->x[(k + 1) % 3], *b = &v->x[(k + 2) % 3];
        const struct integer *c = &w->x[(k + 1) % 3], *d = &w->x[(k + 2) % 3];
        struct integer *difference = &product->x[k], minus;
        if (count == 1) { /* mostly; this way decisions take half the time */
            const signed_two_limbs both = (signed_two_limbs)(signed_limb)a->limbs[0] * (signed_limb)d->limbs[0] -
                                          (signed_two_limbs)(signed_limb)b->limbs[0] * (signed_limb)c->limbs[0];
            difference->limbs[0] = (limb)both;
            difference->limbs[1] = (limb)(both >> LIMB_BITS);
            continue;
        }
        multiply(a, count, d, count, difference);
        multiply(b, count, c, count, &minus);
        add_limbs(-1, minus.limbs, 2 * count, difference->limbs);
    }
}

MLRT_INLINE void dot_limbs(const struct integer_vector *v, const struct integer_vector *w, int count,
                           struct integer *sum)
{
    struct integer term;
    multiply(&v->x[0], 2 * count, &w->x[0], count, sum);
    for (int k = 1; k < 3; ++k) {
        multiply(&v->x[k], 2 * count, &w->x[k], count, &term);
        add_limbs(1, term.limbs, 3 * count, sum->limbs);
    }
}

/* v . w, for a cross product and a vector of coordinates */
static void dot(const struct integer_vector *v, const struct integer_vector *w, int count, struct integer *sum)
{
    if (count == 1)
        dot_limbs(v, w, 1, sum);
    else
        dot_limbs(v, w, count, sum);
}

/* ---- grids ------------------------------------------------------------------------------------------------------- */

/* The least and the greatest exponent of numbers that are not 0, biased by 1023. */
struct extent {
    int least, greatest;
};

/* Of zeros: they have the grid of the greatest floats. */
static const struct extent NO_EXTENT = {1023 + 127, 0};

MLRT_INLINE void extend(double value, struct extent *extent)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    const int exponent = (int)(bits >> 52 & 2047);
    if (value == 0) return;
    if (exponent < extent->least) extent->least = exponent;
    if (exponent > extent->greatest) extent->greatest = exponent;
}

static void extend_by(const float *values, int count, struct extent *extent)
{
    for (int i = 0; i < count; ++i) extend(values[i], extent);
}

struct grid {
    int count;             /* of the limbs of a coordinate */
    double scale;          /* coordinates times this have their highest limb before the point, the others behind it */
    double direction_unit; /* t of integers is this times t */
    struct integer_vector direction;
};

static int count_limbs(const struct extent *extent)
{
    return extent->greatest > extent->least ? (extent->greatest - extent->least + 27) / LIMB_BITS + 1 : 1;
}

static double scale_of(const struct extent *extent, int count)
{
    const int exponent = 2 * 1023 + 24 - extent->least - (count - 1) * LIMB_BITS;
    const uint64_t bits = (uint64_t)exponent << 52;
    double scale;
    assert(exponent > 0 && exponent < 2047);
    memcpy(&scale, &bits, sizeof scale);
    return scale;
}

static void set_value(double value, double scale, int count, struct integer *result)
{
    struct integer size;
    double rest = fabs(value) * scale;
    for (int i = count; i-- > 0; rest = (rest - (double)size.limbs[i]) * LIMB_RANGE) {
        size.limbs[i] = (limb)rest;
        result->limbs[i] = 0;
    }
    add_limbs(value < 0 ? -1 : 1, size.limbs, count, result->limbs);
}

/* to - from */
static void subtract(const float to[3], const float from[3], double scale, int count, struct integer_vector *difference)
{
    for (int k = 0; k < 3; ++k) {
        struct integer start;
        if (count == 1) {
            difference->x[k].limbs[0] = (limb)((int64_t)(to[k] * scale) - (int64_t)(from[k] * scale));
            continue;
        }
        set_value(to[k], scale, count, &difference->x[k]);
        set_value(from[k], scale, count, &start);
        add_limbs(-1, start.limbs, count, difference->x[k].limbs);
    }
}

/* The grid of a ray, a triangle, and a second one unless that is NULL. */
static void find_grid(const float origin[3], const float direction[3], const struct mlrt_triangle *first,
                      const struct mlrt_triangle *second, struct grid *grid)
{
    struct extent extent = NO_EXTENT, direction_extent = NO_EXTENT;
    extend_by(origin, 3, &extent);
    extend_by(first->v[0], 9, &extent);
    if (second) extend_by(second->v[0], 9, &extent);
    extend_by(direction, 3, &direction_extent);
    const int point_count = count_limbs(&extent), direction_count = count_limbs(&direction_extent);
    grid->count = point_count > direction_count ? point_count : direction_count;
    grid->scale = scale_of(&extent, grid->count);
    const double direction_scale = scale_of(&direction_extent, grid->count);
    grid->direction_unit = grid->scale / direction_scale;
    subtract(direction, (const float[3]){0, 0, 0}, direction_scale, grid->count, &grid->direction);
}

/* The sign of x - factor * y. The factor has 25 bits. */
static int compare_multiple(const struct integer *x, double factor, const struct integer *y, int count)
{
    struct extent extent = NO_EXTENT;
    struct integer one, multiplier;
    extend(1, &extent);
    extend(factor, &extent);
    const int factor_count = count_limbs(&extent);
    set_value(1, scale_of(&extent, factor_count), factor_count, &one);
    set_value(factor, scale_of(&extent, factor_count), factor_count, &multiplier);
    return sign_of_difference(x, &one, y, &multiplier, count, factor_count);
}

/* ---- the hit rule ------------------------------------------------------------------------------------------------ */

static void find_crossing(const struct grid *grid, const float origin[3], const struct mlrt_triangle *triangle,
                          struct integer *d, struct integer *n)
{
    struct integer_vector ab, ac, normal, to_a;
    subtract(triangle->v[1], triangle->v[0], grid->scale, grid->count, &ab);
    subtract(triangle->v[2], triangle->v[0], grid->scale, grid->count, &ac);
    cross(&ab, &ac, grid->count, &normal);
    subtract(triangle->v[0], origin, grid->scale, grid->count, &to_a);
    dot(&normal, &grid->direction, grid->count, d);
    dot(&normal, &to_a, grid->count, n);
}

/*
 * e_ij = (d x p_i) . p_j for p relative to the origin: integers do not cancel. Mostly the ray goes through an edge or a
 * corner, and d x p is 0 for a corner that it goes through, which settles two edges.
 */
void mlrt_exact_edge_signs(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, int sign[3])
{
    struct grid grid;
    find_grid(ray->origin, ray->direction, triangle, NULL, &grid);
    struct integer_vector vertex[3], moment[3];
    int is_met[3];
    for (int i = 0; i < 3; ++i) {
        subtract(triangle->v[i], ray->origin, grid.scale, grid.count, &vertex[i]);
        cross(&grid.direction, &vertex[i], grid.count, &moment[i]);
        is_met[i] = first_sign(&moment[i], 2 * grid.count) == 0;
    }
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        struct integer edge;
        if (sign[i] != 0 || is_met[i] || is_met[j]) continue;
        dot(&moment[i], &vertex[j], grid.count, &edge);
        sign[i] = sign_of(&edge, 3 * grid.count);
    }
}

int mlrt_exact_edge_direction(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, int i)
{
    struct grid grid;
    find_grid(ray->origin, ray->direction, triangle, NULL, &grid);
    struct integer_vector edge, product;
    subtract(triangle->v[(i + 1) % 3], triangle->v[i], grid.scale, grid.count, &edge);
    cross(&grid.direction, &edge, grid.count, &product);
    return first_sign(&product, 2 * grid.count);
}

int mlrt_exact_sign_beyond(const float origin[3], const float direction[3], const struct mlrt_triangle *triangle,
                           float t)
{
    struct grid grid;
    find_grid(origin, direction, triangle, NULL, &grid);
    struct integer d, n;
    find_crossing(&grid, origin, triangle, &d, &n);
    return compare_multiple(&n, t * grid.direction_unit, &d, 3 * grid.count);
}

int mlrt_exact_order(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *first,
                     const struct mlrt_triangle *second)
{
    struct grid grid;
    find_grid(ray->origin, ray->direction, first, second, &grid);
    struct integer d1, n1, d2, n2;
    find_crossing(&grid, ray->origin, first, &d1, &n1);
    find_crossing(&grid, ray->origin, second, &d2, &n2);
    const int count = 3 * grid.count;
    return sign_of(&d1, count) * sign_of(&d2, count) * sign_of_difference(&n1, &d2, &n2, &d1, count, count);
}

/* The float nearest to x / d, which is not negative, if d has a unit of `unit` times that of x. */
static float round_quotient(const struct integer *x, const struct integer *d, int count, double unit)
{
    // The relative errors are 2^-46 for each size and 2^-53 for each of the two other operations: below 2^-44 together.
    const double quotient = size_of(x, count) / size_of(d, count) / unit;
    const float low = (float)(quotient * (1 - 0x1p-44)), high = (float)(quotient * (1 + 0x1p-44));
    if (low == high) return low;

    // Neighbours. Quotients round to inf from midway between FLT_MAX and 2^128 on, as if 2^128 were the next float.
    const double midpoint = 0.5 * ((double)low + (high > FLT_MAX ? 0x1p128 : (double)high));
    const int order = sign_of(d, count) * compare_multiple(x, midpoint * unit, d, count);
    if (order != 0) return order < 0 ? low : high;
    uint32_t low_bits;
    memcpy(&low_bits, &low, sizeof low_bits);
    return low_bits % 2 == 0 ? low : high;
}

void mlrt_exact_report(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, uint32_t outputs,
                       mlrt_hit *hit)
{
    struct grid grid;
    find_grid(ray->origin, ray->direction, triangle, NULL, &grid);
    const int count = 3 * grid.count;
    struct integer x, d;
    find_crossing(&grid, ray->origin, triangle, &d, &x);
    if (outputs & MLRT_OUTPUT_FACING) hit->facing = sign_of(&d, count);
    if (outputs & MLRT_OUTPUT_T) hit->t = round_quotient(&x, &d, count, grid.direction_unit);
    for (int i = 0; i < 2 && outputs & MLRT_OUTPUT_UV; ++i) { /* e_ca / D, then e_ab / D */
        struct integer_vector to_vertex, edge, moment;
        const float *from = triangle->v[(i + 2) % 3];
        subtract(from, ray->origin, grid.scale, grid.count, &to_vertex);
        subtract(triangle->v[i], from, grid.scale, grid.count, &edge);
        cross(&grid.direction, &to_vertex, grid.count, &moment);
        dot(&moment, &edge, grid.count, &x);
        *(i == 0 ? &hit->u : &hit->v) = round_quotient(&x, &d, count, 1);
    }
}
