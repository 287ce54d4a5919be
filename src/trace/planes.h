/* SPDX-License-Identifier: MIT */
/*
 * Planes and edges of triangles in double, with the sizes that their errors are relative to.
 *
 * ERRORS, v = 2^-53. A component of n has 4 roundings, relative to its size, the sum of the magnitudes of its two
 * products. V, which is N at the waist, has 8, relative to s(V), the sum of |a_k - w_k| times size k.
 *
 * RANGE. Corners that are not odd are at most 2^60 and multiples of 2^-149. So n is 0 or within 2^-298 .. 2^124, and V
 * within 2^-447 .. 2^187. Of odd triangles, n is below 2^260 and V below 2^392: nothing overflows or underflows.
 */
#ifndef MLRT_TRACE_PLANES_H
#define MLRT_TRACE_PLANES_H

#include <math.h>

#include "exact/vector.h"
#include "scene/tree.h"
#include "trace/bundle.h"

/* The plane of a triangle: a point of it, n, and the sizes of the components of n. */
struct mlrt_plane {
    double point[3];
    double normal[3];
    double size[3];
};

static inline void mlrt_set_plane(const struct mlrt_triangle *triangle, struct mlrt_plane *plane)
{
    double ab[3], ac[3];
    for (int k = 0; k < 3; ++k) {
        plane->point[k] = triangle->v[0][k];
        ab[k] = triangle->v[1][k] - plane->point[k];
        ac[k] = triangle->v[2][k] - plane->point[k];
    }
    mlrt_cross_with_sizes(ab, ac, plane->normal, plane->size);
}

/* |a_z| + (|a_j| + |a_l|) / 2: for C or its errors, the sum of |coefficient| |term| if both slopes are 1/2. */
static inline double mlrt_weigh(const double a[3])
{
    return fabs(a[0]) + 0.5 * (fabs(a[1]) + fabs(a[2]));
}

/* Corners in units, and the waist: component 0 is that of the main axis, with the sign of the waist. */
struct mlrt_turned_corners {
    double corner[3][3];
    double waist[3];
};

static inline void mlrt_turn_corners(const struct mlrt_tree *tree, const struct mlrt_waist *waist, uint32_t number,
                                     struct mlrt_turned_corners *of)
{
    const struct mlrt_corners corners = mlrt_corners_of(&tree->by_number, number);
    const double unit = corners.in_units ? 1 : tree->bvh.unit;
    MLRT_UNROLL
    for (size_t k = 0; k < 3; ++k) {
        const int axis = k == 0 ? waist->main_axis : mlrt_slope_axis(waist->main_axis, (int)k - 1);
        const double sign = k == 0 ? (double)waist->sign : 1;
        of->waist[k] = sign * waist->point[axis];
        MLRT_UNROLL
        for (size_t i = 0; i < 3; ++i) {
            of->corner[i][k] = corners.corner[(3 * i + (size_t)axis) * corners.row] * (sign * unit);
        }
    }
}

/* The plane of such corners. */
struct mlrt_turned_plane {
    double normal[3];
    double size[3];
    double n; /* V */
    double n_size;
};

static inline void mlrt_turn_plane(const struct mlrt_turned_corners *of, struct mlrt_turned_plane *plane)
{
    double to[3], ab[3], ac[3];
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        to[k] = of->corner[0][k] - of->waist[k];
        ab[k] = of->corner[1][k] - of->corner[0][k];
        ac[k] = of->corner[2][k] - of->corner[0][k];
    }
    mlrt_cross_with_sizes(ab, ac, plane->normal, plane->size);
    plane->n = to[0] * plane->normal[0] + to[1] * plane->normal[1] + to[2] * plane->normal[2];
    plane->n_size = fabs(to[0]) * plane->size[0] + fabs(to[1]) * plane->size[1] + fabs(to[2]) * plane->size[2];
}

/*
 * Sets the constant and the coefficients of an edge function to those of C = `moment` and g = `along`, each times
 * `scale`.
 */
static inline void mlrt_scale_edge(const double moment[3], const double along[3], double scale, float *constant,
                                   float coefficient[MLRT_RAY_TERMS])
{
    *constant = (float)(moment[0] * scale);
    coefficient[MLRT_SLOPE_J] = (float)(moment[1] * scale);
    coefficient[MLRT_SLOPE_L] = (float)(moment[2] * scale);
    coefficient[MLRT_INTERCEPT_J] = (float)(-along[2] * scale);
    coefficient[MLRT_INTERCEPT_L] = (float)(along[1] * scale);
    coefficient[MLRT_MOMENT] = (float)(along[0] * scale);
}

#endif
