/* SPDX-License-Identifier: MIT */
/*
 * The determinants of the hit rule in double, with a bound on the error.
 *
 * Based on: Tomas Moeller, Ben Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997 (which products the
 * three edges and the plane share).
 *
 * WHAT IS COMPUTED
 *
 * With p = a - o, and because a triple product with two equal vectors is 0, every quantity of the rule is a determinant
 * [x y z] = (x cross y) . z of d and differences of two points, and such a determinant is small for small triangles:
 *
 *     e_ab = [d p b-a]     e_ca = -[d p c-a]     D = [b-a c-a d]     N = [b-a c-a p]     e_bc = D - e_ab - e_ca
 *
 * THE BOUND
 *
 * Let u = 2^-53 and gamma_k = k u / (1 - k u). A sum of terms, each with at most k factors (1 + delta), |delta| <= u,
 * is off by at most gamma_k times the sum of the terms' magnitudes. A difference of two vertices, or of vertex and
 * origin, has 1 factor (in double it is not exact in general), and d has none. A determinant consists of six products
 * of three components. Each has the factors of its components, those of one product and one difference in the cross
 * product, and those of one product and at most two sums in the dot product. So e_ab, e_ca and D have 2 + 5 = 7
 * factors, and N has 3 + 5 = 8.
 *
 * Let the size of x be |x_0| + |x_1| + |x_2|. The magnitudes of the six terms sum to at most the product of the sizes
 * of the three vectors, which has these six terms and 21 others. As computed, that product has at most 3 * 3 + 2 = 11
 * factors on positive terms, so it is at least (1 - u)^11 of the true one. In units of the computed size, the errors
 * are then:
 *
 *     a determinant     8 factors, size 11:   gamma_8  / (1 - u)^11  <   8.001 u
 *     e_bc              9 factors, size 13:   gamma_9  / (1 - u)^13  <   9.001 u     size: the sum of the three
 *     N - t D           9 factors, size 13:   gamma_9  / (1 - u)^13  <   9.001 u     size: s(N) + t s(D)
 *     N1 D2 - N2 D1    17 factors, size 24:   gamma_17 / (1 - u)^24  <  17.001 u     size: s(N1) s(D2) + s(N2) s(D1)
 *
 * The bound itself is rounded once, by less than 0.001 of it: 10 u (MLRT_SIGN_ERROR) and 18 u (MLRT_ORDER_ERROR) are
 * enough.
 *
 * RANGE
 *
 * Rounding is relative to the result only if nothing overflows or falls below 2^-1022. Floats are multiples of 2^-149
 * below 2^128, and rounding leaves a multiple of 2^k a multiple of 2^k. So, in double as in real arithmetic,
 *
 *     a difference of two floats is     0 or within  2^-149 .. 2^129
 *     a component of a cross product                 2^-298 .. 2^260
 *     a determinant, and its size                    2^-447 .. 2^392     (a size: at most 3^3 2^(3 * 129))
 *     N - t D, and its size                          2^-596 .. 2^521
 *     N1 D2 - N2 D1, and its size                    2^-894 .. 2^785
 *     a quotient                                     2^-839 .. 2^839
 *
 * and so is every partial sum on the way. Both bounds and the constants of the quotients are above 2^-50: so these
 * values times such a constant are normal doubles or 0 as well.
 */
#ifndef MLRT_EXACT_DETERMINANTS_H
#define MLRT_EXACT_DETERMINANTS_H

#include "base/platform.h"
#include "exact/rounding.h"
#include "exact/segment.h"
#include "exact/triangle.h"
#include "exact/vector.h"

#define MLRT_SIGN_ERROR  (10 * MLRT_UNIT_ROUNDOFF)
#define MLRT_ORDER_ERROR (18 * MLRT_UNIT_ROUNDOFF)

/* A computed value, and the size that its error is relative to. */
struct mlrt_measured {
    double value;
    double size;
};

/* The sign of a value whose error is at most error * size. 0: not certain, as for every value that is truly 0. */
MLRT_INLINE int mlrt_certain_sign(struct mlrt_measured measured, double error)
{
    double bound = error * measured.size;
    if (MLRT_GUESS) return measured.value >= 0 ? 1 : -1;
    return (measured.value > bound) - (measured.value < -bound);
}

/* The vectors of the determinants of the hit rule, and their sizes. */
struct mlrt_operands {
    struct mlrt_vector ab, ac, direction, to_a;
    double ab_size, ac_size, direction_size, to_a_size;
};

/* Coordinate i of the corners is corner[i * row]. */
MLRT_INLINE struct mlrt_operands mlrt_load_operands(const float origin[3], const float direction[3],
                                                    const float *corner, size_t row)
{
    struct mlrt_operands operands;
    struct mlrt_vector a = mlrt_vector_at(corner, row);
    operands.ab = mlrt_subtract(mlrt_vector_at(corner + 3 * row, row), a);
    operands.ac = mlrt_subtract(mlrt_vector_at(corner + 6 * row, row), a);
    operands.direction = mlrt_vector_at(direction, 1);
    operands.to_a = mlrt_subtract(a, mlrt_vector_at(origin, 1));
    operands.ab_size = mlrt_size_of(operands.ab);
    operands.ac_size = mlrt_size_of(operands.ac);
    operands.direction_size = mlrt_size_of(operands.direction);
    operands.to_a_size = mlrt_size_of(operands.to_a);
    return operands;
}

/* e_ab and e_ca, which share a cross product. */
struct mlrt_two_edges {
    struct mlrt_measured ab, ca;
};

MLRT_INLINE struct mlrt_two_edges mlrt_measure_edges(const struct mlrt_operands *operands)
{
    struct mlrt_vector moment = mlrt_cross(operands->direction, operands->to_a);
    double moment_size = operands->direction_size * operands->to_a_size;
    return (struct mlrt_two_edges){{mlrt_dot(moment, operands->ab), moment_size * operands->ab_size},
                                   {-mlrt_dot(moment, operands->ac), moment_size * operands->ac_size}};
}

/* D and N: where the ray's line crosses the plane, t = N / D. */
struct mlrt_crossing {
    struct mlrt_measured d, n;
};

MLRT_INLINE struct mlrt_crossing mlrt_measure_crossing(const struct mlrt_operands *operands)
{
    struct mlrt_vector normal = mlrt_cross(operands->ab, operands->ac);
    double normal_size = operands->ab_size * operands->ac_size;
    return (struct mlrt_crossing){{mlrt_dot(operands->direction, normal), operands->direction_size * normal_size},
                                  {mlrt_dot(operands->to_a, normal), operands->to_a_size * normal_size}};
}

/* e_bc = D - e_ab - e_ca */
MLRT_INLINE struct mlrt_measured mlrt_measure_third_edge(const struct mlrt_two_edges *edges, struct mlrt_measured d)
{
    return (struct mlrt_measured){d.value - edges->ab.value - edges->ca.value,
                                  d.size + edges->ab.size + edges->ca.size};
}

/* N - t D, t >= 0 */
MLRT_INLINE struct mlrt_measured mlrt_measure_beyond(const struct mlrt_crossing *crossing, float t)
{
    return (struct mlrt_measured){crossing->n.value - t * crossing->d.value, crossing->n.size + t * crossing->d.size};
}

/* N1 D2 - N2 D1 */
MLRT_INLINE struct mlrt_measured mlrt_measure_order(const struct mlrt_crossing *first,
                                                    const struct mlrt_crossing *second)
{
    return (struct mlrt_measured){first->n.value * second->d.value - second->n.value * first->d.value,
                                  first->n.size * second->d.size + second->n.size * first->d.size};
}

/* D and N of a ray and a triangle (predicate.c). Inline, it would take 2 kB and gain no time that can be measured. */
struct mlrt_crossing mlrt_cross_plane(const float origin[3], const float direction[3],
                                      const struct mlrt_triangle *triangle);

#endif
