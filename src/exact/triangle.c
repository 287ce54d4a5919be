/* SPDX-License-Identifier: MIT */
/* Triangles by their numbers: see triangle.h. */
#include "exact/triangle.h"

#include <stddef.h>

/*
 * One expression, so that compilers write each coordinate to its place once: filled by a loop, a triangle would be
 * copied once more, by loads that wait for several stores.
 */
struct mlrt_triangle mlrt_triangle_of(const struct mlrt_corners *from, float inverse_unit)
{
    const float *c = from->corner;
    const size_t row = from->row;
    if (from->in_units && inverse_unit != 1) {
        struct mlrt_triangle triangle;
        for (size_t i = 0; i < 9; ++i) triangle.v[i / 3][i % 3] = c[i * row] * inverse_unit;
        return triangle;
    }
    return (struct mlrt_triangle){
        {{c[0], c[row], c[2 * row]}, {c[3 * row], c[4 * row], c[5 * row]}, {c[6 * row], c[7 * row], c[8 * row]}}};
}

struct mlrt_triangle mlrt_triangle_at(const struct mlrt_triangles *triangles, uint32_t number)
{
    const struct mlrt_corners from = mlrt_corners_of(triangles, number);
    return mlrt_triangle_of(&from, triangles->inverse_unit);
}
