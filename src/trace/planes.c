/* SPDX-License-Identifier: MIT */
/*
 * The plane of a triangle in double: see planes.h.
 */
#include "trace/planes.h"

void mlrt_set_plane(const struct mlrt_triangle *triangle, struct mlrt_plane *plane)
{
    double ab[3], ac[3];
    for (int k = 0; k < 3; ++k) {
        plane->point[k] = triangle->v[0][k];
        ab[k] = triangle->v[1][k] - plane->point[k];
        ac[k] = triangle->v[2][k] - plane->point[k];
    }
    mlrt_cross_with_sizes(ab, ac, plane->normal, plane->size);
}
