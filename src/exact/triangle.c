/* SPDX-License-Identifier: MIT */
/*
 * Triangles by their numbers: see triangle.h.
 */
#include "exact/triangle.h"

#include <string.h>

struct mlrt_triangle mlrt_triangle_at(const struct mlrt_triangles *triangles, uint32_t number)
{
    const struct mlrt_corners from = mlrt_corners_of(triangles, number);
    struct mlrt_triangle triangle;
    float *to = triangle.v[0];
    for (uint32_t i = 0; i < 9; ++i) memcpy(&to[i], &from.corner[i * from.row], sizeof *to);
    if (from.in_units && triangles->inverse_unit != 1) {
        for (uint32_t i = 0; i < 9; ++i) to[i] *= triangles->inverse_unit;
    }
    return triangle;
}
