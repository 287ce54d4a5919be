/* SPDX-License-Identifier: MIT */
/*
 * Points just off a triangle: the point on it is computed in double, moved along the normal, rounded to float component
 * by component in the direction of the move, and then the exact side is looked up (predicate.h). If it is the wrong
 * one, the move is doubled. So the distance is about the spacing of floats there, and the side is a fact.
 */
#include "exact/offset.h"

#include <math.h>

#include "base/platform.h"
#include "exact/predicate.h"
#include "exact/rounding.h"

/* base moved by `step` along `direction`, rounded on in the same direction. 0 if that leaves the range of float. */
static int move_point(const double base[3], const double direction[3], double step, float point[3])
{
    for (int k = 0; k < 3; ++k) {
        const double moved = base[k] + step * direction[k];
        if (!(fabs(moved) <= FLT_MAX)) return 0;
        point[k] = direction[k] > 0 ? mlrt_float_up(moved) : direction[k] < 0 ? mlrt_float_down(moved) : (float)moved;
    }
    return 1;
}

/* The point is relative to `from`. Without it that is 0. */
static int search_along(const struct mlrt_triangle *triangle, const double base[3], const double direction[3], int side,
                        const float *from, float point[3])
{
    const double size = fmax(fabs(base[0]), fmax(fabs(base[1]), fabs(base[2])));
    /* From one spacing of floats on: closer points lie in the plane too often, which takes exact arithmetic to see. */
    double step = fmax(size * 0x1p-24, 0x1p-149);
    do {
        if (!move_point(base, direction, step, point)) return 0;
        step *= 2;
    } while ((from ? mlrt_side_of_sum(triangle, from, point) : mlrt_side_of_plane(triangle, point)) != side);
    return 1;
}

/* The signs of the normal, exactly: which side a vertex is on once it is moved along one axis. */
static void find_normal_signs(const struct mlrt_triangle *triangle, int side, double direction[3])
{
    for (int k = 0; k < 3; ++k) {
        float probe[3] = {triangle->v[0][0], triangle->v[0][1], triangle->v[0][2]};
        probe[k] = mlrt_next_down(probe[k]); /* the range of float may end above, as it may below: then it is -inf */
        direction[k] = isfinite(probe[k]) ? -side * mlrt_side_of_plane(triangle, probe) : 0;
    }
}

/* The normal in double, its largest component 1; 0 if it is lost in rounding. */
static int find_normal(const struct mlrt_triangle *triangle, int side, double direction[3])
{
    double edge[2][3], largest = 0;
    for (int k = 0; k < 3; ++k) {
        edge[0][k] = (double)triangle->v[1][k] - triangle->v[0][k];
        edge[1][k] = (double)triangle->v[2][k] - triangle->v[0][k];
    }
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        direction[k] = side * (edge[0][i] * edge[1][j] - edge[0][j] * edge[1][i]);
        largest = fmax(largest, fabs(direction[k]));
    }
    for (int k = 0; k < 3; ++k) direction[k] /= largest;
    return largest > 0;
}

static MLRT_NOINLINE int find_point(const struct mlrt_triangle *triangle, float u, float v, int side, const float *from,
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
    find_normal_signs(triangle, side, direction);
    return search_along(triangle, base, direction, side, from, point);
}

int mlrt_find_offset_point(const struct mlrt_triangle *triangle, float u, float v, int side, float point[3])
{
    return find_point(triangle, u, v, side, NULL, point);
}

int mlrt_find_offset_from(const struct mlrt_triangle *triangle, float u, float v, int side, const float from[3],
                          float by[3])
{
    return find_point(triangle, u, v, side, from, by);
}
