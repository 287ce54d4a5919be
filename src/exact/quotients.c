/* SPDX-License-Identifier: MIT */
/*
 * The quotients of the hit rule, in double between two ends; exactly where these do not round to one float.
 *
 * X and D are computed determinants, x and d the true ones, s(X) and s(D) their sizes: |X - x| <= 8.001 u s(X) and
 * |D - d| <= 8.001 u s(D), see determinants.h. Let |D| > 2^-44 s(D). Then |D - d| < 1.01 * 2^-6 |D| and, since
 * 1 / (1 - 1.01 * 2^-6) < 1.017,
 *
 *     |x / d - X / D| = |(x - X) D - X (d - D)| / |d D| <= 1.017 * 8.001 u (s(X) + |X / D| s(D)) / |D|.
 *
 * The quotient q = X * (1 / D) is rounded twice more, and then q - w and q + w once each: 3.001 u |X / D| in all, which
 * is at most 3.01 u s(X) / |D| because |X| <= (1 + 20 u) s(X). The sum is below (11.2 s(X) + 8.2 |q| s(D)) u / |D|. The
 * constants in quotients.h are 12 and 9, which leaves room for the roundings of the half-width w itself.
 */
#include "exact/quotients.h"

#include <math.h>

#include "exact/determinants.h"
#include "exact/integers.h"

/* 1 / D, and the error of a quotient by D that comes from D, relative to the quotient. */
struct denominator {
    double inverse;
    double error;
};

/* low <= x / d <= high, for the true determinants. */
struct enclosure {
    double low, high;
};

MLRT_INLINE int is_safe_denominator(struct mlrt_measured d)
{
    return fabs(d.value) > MLRT_LEAST_DENOMINATOR * d.size;
}

MLRT_INLINE struct denominator invert(struct mlrt_measured d)
{
    double inverse = 1 / d.value;
    return (struct denominator){inverse, MLRT_DENOMINATOR_ERROR * d.size * fabs(inverse)};
}

MLRT_INLINE struct enclosure enclose_quotient(struct mlrt_measured x, struct denominator d)
{
    double quotient = x.value * d.inverse;
    double width = MLRT_NUMERATOR_ERROR * x.size * fabs(d.inverse) + fabs(quotient) * d.error;
    return (struct enclosure){quotient - width, quotient + width};
}

void mlrt_bound_distance(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, float *lo, float *hi)
{
    const struct mlrt_crossing crossing = mlrt_cross_plane(ray->origin, ray->direction, triangle);
    if (MLRT_UNLIKELY(!is_safe_denominator(crossing.d))) {
        *lo = 0;
        *hi = INFINITY;
        return;
    }
    struct enclosure t = enclose_quotient(crossing.n, invert(crossing.d));
    *lo = mlrt_float_down(t.low > 0 ? t.low : 0); // a hit has t > 0
    *hi = mlrt_float_up(t.high);
}

/* Sets *result to the float that every number of the enclosure rounds to. Returns 0 if there is none. */
MLRT_INLINE int round_enclosure(struct enclosure enclosure, float *result)
{
    *result = (float)enclosure.high;
    return MLRT_GUESS || (float)enclosure.low == *result;
}

/*
 * Sets *t to the rounded (a - o) / d of a triangle in a plane across an axis. This case is frequent: a camera that
 * looks along an axis has d = 1 for all rays, and if a - o lies midway between two floats, all of a wall is undecided.
 *
 * Let a - o be exact in double, and q the rounded quotient. A number midway between two floats is a double, so q lies
 * on the same side of it as the true quotient, unless q is the midway number. Then q has 25 bits and q d is exact: if
 * it equals a - o, q is the true quotient. Returns 0 if that does not determine *t.
 */
static int round_flat_quotient(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, float *t)
{
    for (uint32_t axis = 0; axis < 3; ++axis) {
        if (!mlrt_is_across(triangle, axis)) continue;
        const double to = triangle->v[0][axis], from = ray->origin[axis], d = ray->direction[axis];
        const double difference = to - from, back = to - difference;
        if (d == 0 || (to - (difference + back)) - (from - back) != 0) return 0;
        const double quotient = difference / d;
        *t = (float)quotient;
        return quotient * d == difference || (float)(quotient * (1 - 0x1p-51)) == (float)(quotient * (1 + 0x1p-51));
    }
    return 0;
}

void mlrt_report_hit(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, uint32_t outputs,
                     mlrt_hit *hit)
{
    struct mlrt_operands operands = mlrt_load_operands(ray->origin, ray->direction, triangle->v[0], 1);
    struct mlrt_crossing crossing = mlrt_measure_crossing(&operands);
    if (MLRT_UNLIKELY(!is_safe_denominator(crossing.d))) {
        mlrt_exact_report(ray, triangle, outputs, hit);
        return;
    }
    struct denominator d = invert(crossing.d);
    uint32_t undecided = 0;
    if (outputs & MLRT_OUTPUT_FACING) hit->facing = crossing.d.value > 0 ? 1 : -1;
    if (outputs & MLRT_OUTPUT_T) {
        if (!round_enclosure(enclose_quotient(crossing.n, d), &hit->t) &&
            !round_flat_quotient(ray, triangle, &hit->t)) {
            undecided |= MLRT_OUTPUT_T;
        }
    }
    if (outputs & MLRT_OUTPUT_UV) {
        struct mlrt_two_edges edges = mlrt_measure_edges(&operands);
        int both = round_enclosure(enclose_quotient(edges.ca, d), &hit->u);
        both &= round_enclosure(enclose_quotient(edges.ab, d), &hit->v);
        if (!both) undecided |= MLRT_OUTPUT_UV;
    }
    if (MLRT_UNLIKELY(undecided != 0)) mlrt_exact_report(ray, triangle, undecided, hit);
}
