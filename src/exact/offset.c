/* SPDX-License-Identifier: MIT */
/*
 * Points just off a triangle. The point on the triangle is computed in double and moved along the normal; each
 * component is rounded to float in the direction of the move; then predicate.h tells the exact side. While that is the
 * wrong side, the move is doubled. So the distance is about the spacing of floats there, and the side is exact.
 */
#include "exact/offset.h"

#include <math.h>

#include "exact/determinants.h"
#include "exact/predicate.h"
#include "exact/rounding.h"

/*
 * Sets `point` to `base` + step * direction, each component rounded in the direction of the move. Returns 0 if that
 * leaves the range of float.
 */
static int move_point(const double base[3], const double direction[3], double step, float point[3])
{
    for (int k = 0; k < 3; ++k) {
        const double moved = base[k] + step * direction[k];
        if (!(fabs(moved) <= FLT_MAX)) return 0;
        point[k] = direction[k] > 0 ? mlrt_float_up(moved) : direction[k] < 0 ? mlrt_float_down(moved) : (float)moved;
    }
    return 1;
}

/*
 * Doubles the step along `direction` until the point is on the wanted side. Base and point are relative to `from`.
 * Returns 0 if the point would leave the range of float.
 */
static int search_along(const struct mlrt_triangle *triangle, const double base[3], const double direction[3], int side,
                        const float *from, float point[3])
{
    const double size = fmax(fabs(base[0]), fmax(fabs(base[1]), fabs(base[2])));
    /* Starts at one spacing of floats: closer points often lie in the plane, and then each takes exact arithmetic. */
    double step = fmax(size * 0x1p-24, 0x1p-149);
    do {
        if (!move_point(base, direction, step, point)) return 0;
        step *= 2;
    } while ((from ? mlrt_side_of_sum(triangle, from, point) : mlrt_side_of_plane(triangle, point)) != side);
    return 1;
}

/* side * normal in double, scaled so that its largest component is +-1. Returns 0 if all components round to 0. */
static int find_normal(const struct mlrt_triangle *triangle, int side, double direction[3])
{
    const struct mlrt_operands operands = mlrt_load_operands(triangle->v[0], triangle->v[0], triangle->v[0], 1);
    const struct mlrt_vector n = mlrt_cross(operands.ab, operands.ac);
    const double largest = fmax(fabs(n.x), fmax(fabs(n.y), fabs(n.z)));
    direction[0] = side * n.x / largest, direction[1] = side * n.y / largest, direction[2] = side * n.z / largest;
    return largest > 0;
}

int mlrt_find_offset_point(const struct mlrt_triangle *triangle, float u, float v, int side, const float *from,
                           float point[3])
{
    if (!isfinite(u) || !isfinite(v)) return 0;
    if (!mlrt_triangle_is_finite(triangle) || !mlrt_triangle_has_area(triangle)) return 0;
    double base[3], direction[3];
    for (int k = 0; k < 3; ++k) {
        const double a = triangle->v[0][k];
        base[k] = a + u * (triangle->v[1][k] - a) + v * (triangle->v[2][k] - a) - (from ? from[k] : 0);
    }
    if (find_normal(triangle, side, direction) && search_along(triangle, base, direction, side, from, point)) return 1;
    for (int k = 0; k < 3; ++k) direction[k] = side * mlrt_facing_axis(triangle, k); /* the exact signs of the normal */
    return search_along(triangle, base, direction, side, from, point);
}
