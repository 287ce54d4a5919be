/* SPDX-License-Identifier: MIT */
/*
 * Coordinates as 64-bit integers, and their determinants in 192 bits.
 *
 * A float is a multiple of 2^(e - 23), where 2^e is the highest power of two not above its magnitude (e = -126 for
 * denormals). Let `least` and `greatest` be the extremes of e over the coordinates: then all are integers below
 * 2^(greatest - least + 24) in units of 2^(least - 23). If that bound is at most 2^61, differences are at most 2^62,
 * components of a cross product of two such vectors at most 2^125, and determinants of three at most 3 * 2^187 < 2^189:
 * a sign and three words of 64 bits. The products of two determinants in the order test take six words. Signs do not
 * depend on the unit. Every quantity is linear in the direction, so the direction has a unit of its own.
 */
#include "exact/grid.h"

#include <string.h>

#include "base/platform.h"

#if MLRT_HAVE_INT128

#define GRID_BITS 61

__extension__ typedef __int128 int128;
__extension__ typedef unsigned __int128 uint128;

/* sign * (word[0] + 2^64 word[1] + 2^128 word[2]); a zero has sign 0. */
struct determinant {
    int sign;
    uint64_t word[3];
};

/* The least and the greatest exponent of the numbers that share a grid, biased by 127, without zeros. */
struct extent {
    int least;
    int greatest;
};

static void extend(struct extent *extent, const float *v, int count)
{
    for (int k = 0; k < count; ++k) {
        uint32_t bits;
        memcpy(&bits, &v[k], sizeof bits);
        const int exponent = (int)(bits >> 23 & 255);
        if (bits << 1 == 0) continue;
        if (exponent < extent->least) extent->least = exponent;
        if (exponent > extent->greatest) extent->greatest = exponent;
    }
}

/* Sets *scale to the factor that makes all numbers integers. Returns 0 if the integers would exceed 61 bits. */
static int find_grid(const struct extent *extent, double *scale)
{
    /* Denormals have exponent 0 but the spacing of exponent 1. */
    const int least = extent->least > 0 ? extent->least : 1;
    if (extent->greatest - least + 24 > GRID_BITS) return 0;
    const uint64_t bits = (uint64_t)(1023 + 127 + 23 - least) << 52;
    memcpy(scale, &bits, sizeof *scale);
    return 1;
}

static void subtract_on_grid(const float v[3], const float w[3], double scale, int64_t difference[3])
{
    for (int k = 0; k < 3; ++k) difference[k] = (int64_t)(v[k] * scale) - (int64_t)(w[k] * scale);
}

static uint64_t magnitude_of(int64_t a)
{
    return a < 0 ? 0 - (uint64_t)a : (uint64_t)a;
}

/* sum += a * b, in two's complement of 192 bits. */
static void add_product(int128 a, int64_t b, uint64_t sum[3])
{
    const int negative = (a < 0) != (b < 0);
    const uint128 size = a < 0 ? 0 - (uint128)a : (uint128)a;
    const uint64_t factor = magnitude_of(b), flip = negative ? UINT64_MAX : 0;
    const uint128 low = (uint128)(uint64_t)size * factor;
    const uint128 high = (uint128)(uint64_t)(size >> 64) * factor + (uint64_t)(low >> 64);
    const uint64_t product[3] = {(uint64_t)low, (uint64_t)high, (uint64_t)(high >> 64)};
    uint128 carry = (unsigned)negative;
    for (int i = 0; i < 3; ++i) {
        carry += (uint128)sum[i] + (product[i] ^ flip);
        sum[i] = (uint64_t)carry;
        carry >>= 64;
    }
}

static void cross_product(const int64_t x[3], const int64_t y[3], int128 cross[3])
{
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        cross[k] = (int128)x[i] * y[j] - (int128)x[j] * y[i];
    }
}

static struct determinant dot_product(const int128 cross[3], const int64_t z[3])
{
    uint64_t sum[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) add_product(cross[k], z[k], sum);
    struct determinant determinant = {0, {sum[0], sum[1], sum[2]}};
    if ((sum[0] | sum[1] | sum[2]) == 0) return determinant;
    determinant.sign = sum[2] >> 63 ? -1 : 1;
    if (determinant.sign > 0) return determinant;
    uint128 carry = 1;
    for (int i = 0; i < 3; ++i) {
        carry += (uint64_t)~sum[i];
        determinant.word[i] = (uint64_t)carry;
        carry >>= 64;
    }
    return determinant;
}

/* (x cross y) . z */
static struct determinant determinant_of(const int64_t x[3], const int64_t y[3], const int64_t z[3])
{
    int128 cross[3];
    cross_product(x, y, cross);
    return dot_product(cross, z);
}

static void multiply_magnitudes(const struct determinant *first, const struct determinant *second, uint64_t product[6])
{
    memset(product, 0, 6 * sizeof *product);
    for (int i = 0; i < 3; ++i) {
        uint64_t carry = 0;
        for (int j = 0; j < 3; ++j) {
            const uint128 sum = (uint128)first->word[i] * second->word[j] + product[i + j] + carry;
            product[i + j] = (uint64_t)sum;
            carry = (uint64_t)(sum >> 64);
        }
        product[i + 3] = carry;
    }
}

/* The sign of a b - c d. */
static int sign_of_difference(const struct determinant *a, const struct determinant *b, const struct determinant *c,
                              const struct determinant *d)
{
    const int plus = a->sign * b->sign, minus = c->sign * d->sign;
    if (plus != minus) return plus > minus ? 1 : -1;
    uint64_t first[6], second[6];
    multiply_magnitudes(a, b, first);
    multiply_magnitudes(c, d, second);
    for (int i = 5; i >= 0; --i)
        if (first[i] != second[i]) return first[i] > second[i] ? plus : -plus;
    return 0;
}

/* A grid for a ray and points, with the ray's direction in units of its own. */
struct grid {
    double scale;
    double direction_scale;
    int64_t direction[3];
};

/*
 * Finds a grid for the ray and `count` coordinates, and as many `others` (NULL: none). Without a direction, `direction`
 * is NULL. Returns 0 if there is none.
 */
static int make_grid(const float origin[3], const float *direction, const float *points, int count, const float *others,
                     struct grid *grid)
{
    struct extent extent = {255, 0}, direction_extent = {255, 0};
    extend(&extent, origin, 3);
    extend(&extent, points, count);
    if (others) extend(&extent, others, count);
    if (!find_grid(&extent, &grid->scale)) return 0;
    if (!direction) return 1;
    extend(&direction_extent, direction, 3);
    if (!find_grid(&direction_extent, &grid->direction_scale)) return 0;
    for (int k = 0; k < 3; ++k) grid->direction[k] = (int64_t)(direction[k] * grid->direction_scale);
    return 1;
}

static int is_zero(const int128 cross[3])
{
    return cross[0] == 0 && cross[1] == 0 && cross[2] == 0;
}

/*
 * e_ij = (d x p_i) . p_j for p relative to the origin: integers do not cancel. Mostly the ray goes through an edge or a
 * corner, and d x p is 0 for a corner that it goes through, which settles two edges.
 */
int mlrt_grid_edge_signs(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, int sign[3])
{
    struct grid grid;
    int64_t vertex[3][3];
    int128 moment[3][3];
    if (!make_grid(ray->origin, ray->direction, triangle->v[0], 9, NULL, &grid)) return 0;
    for (int i = 0; i < 3; ++i) {
        subtract_on_grid(triangle->v[i], ray->origin, grid.scale, vertex[i]);
        cross_product(grid.direction, vertex[i], moment[i]);
    }
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        if (sign[i] != 0 || is_zero(moment[i]) || is_zero(moment[j])) continue;
        sign[i] = dot_product(moment[i], vertex[j]).sign;
    }
    return 1;
}

int mlrt_grid_distance_sign(const struct mlrt_triangle *triangle, const float point[3], int *sign)
{
    struct grid grid;
    int64_t ab[3], ac[3], to_a[3];
    if (!make_grid(point, NULL, triangle->v[0], 9, NULL, &grid)) return 0;
    subtract_on_grid(triangle->v[1], triangle->v[0], grid.scale, ab);
    subtract_on_grid(triangle->v[2], triangle->v[0], grid.scale, ac);
    subtract_on_grid(triangle->v[0], point, grid.scale, to_a);
    *sign = determinant_of(ab, ac, to_a).sign;
    return 1;
}

/* D and N of the triangle's plane. */
struct crossing {
    struct determinant d, n;
};

static struct crossing cross_plane(const struct grid *grid, const float origin[3], const struct mlrt_triangle *triangle)
{
    int64_t ab[3], ac[3], to_a[3];
    subtract_on_grid(triangle->v[1], triangle->v[0], grid->scale, ab);
    subtract_on_grid(triangle->v[2], triangle->v[0], grid->scale, ac);
    subtract_on_grid(triangle->v[0], origin, grid->scale, to_a);
    return (struct crossing){determinant_of(ab, ac, grid->direction), determinant_of(ab, ac, to_a)};
}

int mlrt_grid_order(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *first,
                    const struct mlrt_triangle *second, int *sign)
{
    struct grid grid;
    if (!make_grid(ray->origin, ray->direction, first->v[0], 9, second->v[0], &grid)) return 0;
    const struct crossing a = cross_plane(&grid, ray->origin, first), b = cross_plane(&grid, ray->origin, second);
    *sign = a.d.sign * b.d.sign * sign_of_difference(&a.n, &b.d, &b.n, &a.d);
    return 1;
}

/* The magnitude, with a relative error below 2^-51 from three conversions and two sums. */
static double size_of(const struct determinant *determinant)
{
    return ((double)determinant->word[2] * 0x1p64 + (double)determinant->word[1]) * 0x1p64 +
           (double)determinant->word[0];
}

int mlrt_grid_quotients(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, double quotient[3])
{
    struct grid grid;
    int64_t ab[3], ca[3], to_a[3], to_c[3];
    if (!make_grid(ray->origin, ray->direction, triangle->v[0], 9, NULL, &grid)) return 0;
    subtract_on_grid(triangle->v[1], triangle->v[0], grid.scale, ab);
    subtract_on_grid(triangle->v[0], triangle->v[2], grid.scale, ca);
    subtract_on_grid(triangle->v[0], ray->origin, grid.scale, to_a);
    subtract_on_grid(triangle->v[2], ray->origin, grid.scale, to_c);
    const struct crossing plane = cross_plane(&grid, ray->origin, triangle);
    const struct determinant e_ca = determinant_of(grid.direction, to_c, ca);
    const struct determinant e_ab = determinant_of(grid.direction, to_a, ab);
    quotient[0] = size_of(&plane.n) / size_of(&plane.d) * (grid.direction_scale / grid.scale);
    quotient[1] = size_of(&e_ca) / size_of(&plane.d);
    quotient[2] = size_of(&e_ab) / size_of(&plane.d);
    return 1;
}

#endif
