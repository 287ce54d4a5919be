/* SPDX-License-Identifier: MIT */
/*
 * Points of triangles that are exact in double: the checks of both structures look them up (mlrta/check.c,
 * bvh/check.c).
 */
#ifndef MLRT_EXACT_CHECK_POINT_H
#define MLRT_EXACT_CHECK_POINT_H

#include "exact/triangle.h"

/* Sets *sum to a + b. Returns 1 if that is exact. */
static inline int mlrt_add_exactly(double a, double b, double *sum)
{
    *sum = a + b;
    double b_part = *sum - a, a_part = *sum - b_part;
    return (a - a_part) + (b - b_part) == 0;
}

/*
 * Sets `point` to the sum of the vertices times weight / 16; the products are exact. Returns 1 if the sum is exact too.
 */
static inline int mlrt_find_check_point(const struct mlrt_triangle *triangle, const int weight[3], double point[3])
{
    for (int k = 0; k < 3; k++) {
        double a = triangle->v[0][k] * (weight[0] / 16.0), b = triangle->v[1][k] * (weight[1] / 16.0),
               c = triangle->v[2][k] * (weight[2] / 16.0);
        if (!mlrt_add_exactly(a, b, &point[k]) || !mlrt_add_exactly(point[k], c, &point[k])) return 0;
    }
    return 1;
}

#endif
