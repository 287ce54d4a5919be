/* SPDX-License-Identifier: MIT */
/*
 * The judge of every hit: signs of the hit rule, in double with a bound on the error; exactly where that is not
 * certain.
 *
 * Based on: Jonathan Richard Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
 * Predicates", 1997 (filter, then exact).
 */
#include "exact/predicate.h"

#include <float.h>

#include "exact/determinants.h"
#include "exact/integers.h"

MLRT_NOINLINE struct mlrt_crossing mlrt_cross_plane(const float origin[3], const float direction[3],
                                                    const struct mlrt_triangle *triangle)
{
    const struct mlrt_operands operands = mlrt_load_operands(origin, direction, triangle->v[0], 1);
    return mlrt_measure_crossing(&operands);
}

/* ---- triangle and plane ------------------------------------------------------------------------------------------ */

int mlrt_triangle_has_area(const struct mlrt_triangle *triangle)
{
    const struct mlrt_operands operands = mlrt_load_operands(triangle->v[0], triangle->v[0], triangle->v[0], 1);
    const double size = operands.ab_size * operands.ac_size;
    // Components have 4 factors, the size has 7. A size of 0 is exact: two vertices are equal.
    if (mlrt_size_of(mlrt_cross(operands.ab, operands.ac)) > 3 * MLRT_SIGN_ERROR * size)
        return 1; // a component is above MLRT_SIGN_ERROR * size
    for (int k = 0; k < 3 && size > 0; ++k)
        if (mlrt_facing_axis(triangle, k) != 0) return 1;
    return 0;
}

static const float NO_STEP[3] = {0, 0, 0};

/* The sign of (from + by - a) . n, which is -(N - t D) at t = 1 of a ray; 0 if double cannot tell. */
static int certain_side(const struct mlrt_triangle *triangle, const float from[3], const float by[3])
{
    const struct mlrt_crossing crossing = mlrt_cross_plane(from, by, triangle);
    return -mlrt_certain_sign(mlrt_measure_beyond(&crossing, 1), MLRT_SIGN_ERROR);
}

int mlrt_side_of_sum(const struct mlrt_triangle *triangle, const float from[3], const float by[3])
{
    const int side = certain_side(triangle, from, by);
    return side != 0 ? side : -mlrt_exact_sign_beyond(from, by, triangle, 1);
}

int mlrt_side_of_plane(const struct mlrt_triangle *triangle, const float point[3])
{
    return mlrt_side_of_sum(triangle, point, NO_STEP);
}

int mlrt_facing(const struct mlrt_triangle *triangle, const float direction[3])
{
    for (uint32_t axis = 0; axis < 3; ++axis) {
        if (direction[axis] == 0 && mlrt_is_across(triangle, axis)) return 0; /* such as a wall under vertical light */
    }
    return mlrt_side_of_sum(triangle, triangle->v[0], direction);
}

int mlrt_facing_axis(const struct mlrt_triangle *triangle, int axis)
{
    return mlrt_facing(triangle, (const float[3]){axis == 0, axis == 1, axis == 2});
}

/* ---- hit or miss ------------------------------------------------------------------------------------------------- */

/*
 * The sign of D if the ray's line meets the closed triangle, 0 for a miss. `known` holds the signs of e_ab, e_bc, e_ca,
 * or 0 where they are not known. A hit has no two edge functions of opposite signs, and D is their sum: so it has the
 * sign of those that are not 0.
 */
static MLRT_NOINLINE int facing_exactly(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle,
                                        const int known[3], mlrt_counters *counters)
{
    int sign[3] = {known[0], known[1], known[2]}, facing = 0;
    if (counters) ++counters->exact_edge_count;
    mlrt_exact_edge_signs(ray, triangle, sign);
    for (int i = 0; i < 3; ++i) {
        if (sign[i] * facing < 0) return 0;
        if (sign[i] != 0) facing = sign[i];
    }
    return facing;
}

/*
 * The sign of (a - o) - t d. The product t d has 48 bits and is exact. Rounding keeps the order: so if the rounded
 * difference is not t d, the true one lies on the same side of it. If it is, the sign is that of the rounding error,
 * which is a double.
 *
 * Based on: Donald E. Knuth, "The Art of Computer Programming", volume 2, section 4.2.2 (the error of a sum).
 */
static int flat_sign(float a, float o, float t, float d)
{
    const double from = o, to = a, end = (double)t * d, difference = to - from;
    if (difference != end) return difference > end ? 1 : -1;
    const double back = to - difference, rest = (to - (difference + back)) - (from - back);
    return (rest > 0) - (rest < 0);
}

int mlrt_reaches_flat(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, float t, int *sign)
{
    for (uint32_t axis = 0; axis < 3; ++axis) {
        if (!mlrt_is_across(triangle, axis)) continue;
        const float d = ray->direction[axis];
        *sign = flat_sign(triangle->v[0][axis], ray->origin[axis], t, d);
        if (d < 0) *sign = -*sign;
        return d != 0;
    }
    return 0;
}

/* The sign of (N - t D) / D: +1 where the ray meets the plane beyond t. `facing` is the sign of D. */
MLRT_INLINE int sign_beyond(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle,
                            const struct mlrt_crossing *crossing, float t, int facing, mlrt_counters *counters)
{
    int sign = facing * mlrt_certain_sign(mlrt_measure_beyond(crossing, t), MLRT_SIGN_ERROR);
    if (MLRT_LIKELY(sign != 0) || mlrt_reaches_flat(ray, triangle, t, &sign)) return sign;
    if (counters) ++counters->exact_range_count;
    return facing * mlrt_exact_sign_beyond(ray->origin, ray->direction, triangle, t);
}

int mlrt_hits_triangle(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle,
                       mlrt_counters *counters)
{
    struct mlrt_operands operands = mlrt_load_operands(ray->origin, ray->direction, triangle->v[0], 1);
    struct mlrt_crossing crossing = mlrt_measure_crossing(&operands);
    /* First, since many rays that are judged start beside a surface and leave it. */
    if (mlrt_certain_sign(crossing.d, MLRT_SIGN_ERROR) *
            mlrt_certain_sign(mlrt_measure_beyond(&crossing, ray->t_min), MLRT_SIGN_ERROR) <
        0)
        return 0;
    struct mlrt_two_edges edges = mlrt_measure_edges(&operands);
    int sign_ab = mlrt_certain_sign(edges.ab, MLRT_SIGN_ERROR);
    int sign_ca = mlrt_certain_sign(edges.ca, MLRT_SIGN_ERROR);
    if (sign_ab * sign_ca < 0) return 0;

    int sign_bc = mlrt_certain_sign(mlrt_measure_third_edge(&edges, crossing.d), MLRT_SIGN_ERROR);
    if (sign_bc * (sign_ab + sign_ca) < 0) return 0;

    int facing = sign_ab;
    if (MLRT_UNLIKELY(sign_ab == 0 || sign_bc == 0 || sign_ca == 0)) {
        facing = facing_exactly(ray, triangle, (const int[3]){sign_ab, sign_bc, sign_ca}, counters);
        if (facing == 0) return 0;
    }
    if (sign_beyond(ray, triangle, &crossing, ray->t_min, facing, counters) <= 0) return 0;
    return ray->t_max > FLT_MAX || sign_beyond(ray, triangle, &crossing, ray->t_max, facing, counters) <= 0;
}

/*
 * The move of the origin changes an edge function by -((v_j - v_i) x d) . (e, e^2, e^3), so the first component that is
 * not 0 decides for an edge function that is 0. If all are 0, the ray is parallel to the edge and D is 0: then the ray
 * did not hit the triangle.
 */
static MLRT_NOINLINE int crosses_exactly(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle)
{
    int sign[3] = {0, 0, 0};
    mlrt_exact_edge_signs(ray, triangle, sign);
    const int facing = sign[0] ? sign[0] : sign[1] ? sign[1] : sign[2];
    for (int i = 0; i < 3; ++i)
        if (sign[i] == 0 && mlrt_exact_edge_direction(ray, triangle, i) != facing) return 0;
    return 1;
}

int mlrt_crosses_triangle(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle)
{
    struct mlrt_operands operands = mlrt_load_operands(ray->origin, ray->direction, triangle->v[0], 1);
    struct mlrt_two_edges edges = mlrt_measure_edges(&operands);
    struct mlrt_crossing crossing = mlrt_measure_crossing(&operands);
    int inside = mlrt_certain_sign(edges.ab, MLRT_SIGN_ERROR) != 0 &&
                 mlrt_certain_sign(edges.ca, MLRT_SIGN_ERROR) != 0 &&
                 mlrt_certain_sign(mlrt_measure_third_edge(&edges, crossing.d), MLRT_SIGN_ERROR) != 0;
    return inside || crosses_exactly(ray, triangle);
}

/* ---- nearer ------------------------------------------------------------------------------------------------------ */

/*
 * Distances that double cannot tell apart are mostly equal, and most of these are walls in the same plane across an
 * axis. For a plane x_k = w, t = (w - o_k) / d_k, so planes w1 and w2 across the same axis compare as
 * sgn(d_k) (w1 - w2).
 */
static MLRT_NOINLINE int compare_close_distance(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *first,
                                                const struct mlrt_triangle *second, mlrt_counters *counters)
{
    for (uint32_t axis = 0; axis < 3; ++axis) {
        if (!mlrt_is_across(first, axis) || !mlrt_is_across(second, axis)) continue;
        float plane_1 = first->v[0][axis], plane_2 = second->v[0][axis];
        int sign = (plane_1 > plane_2) - (plane_1 < plane_2);
        return ray->direction[axis] < 0 ? -sign : sign;
    }
    if (counters) ++counters->exact_order_count;
    return mlrt_exact_order(ray, first, second);
}

int mlrt_compare_distance(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *first,
                          const struct mlrt_triangle *second, mlrt_counters *counters)
{
    const struct mlrt_crossing crossing_1 = mlrt_cross_plane(ray->origin, ray->direction, first);
    const struct mlrt_crossing crossing_2 = mlrt_cross_plane(ray->origin, ray->direction, second);
    int sign = mlrt_certain_sign(crossing_1.d, MLRT_SIGN_ERROR) * mlrt_certain_sign(crossing_2.d, MLRT_SIGN_ERROR) *
               mlrt_certain_sign(mlrt_measure_order(&crossing_1, &crossing_2), MLRT_ORDER_ERROR);
    return MLRT_LIKELY(sign != 0) ? sign : compare_close_distance(ray, first, second, counters);
}

/*
 * Many triangles in one plane are one that is there twice, or share an edge: corners that both have need no integers.
 * Calls of one ray, which know no planes of rays before, take 0.9 of the instructions in cruiser so.
 */
static int has_corner(const struct mlrt_triangle *triangle, const float point[3])
{
    for (int i = 0; i < 3; ++i) {
        const float *corner = triangle->v[i];
        if (corner[0] == point[0] && corner[1] == point[1] && corner[2] == point[2]) return 1;
    }
    return 0;
}

int mlrt_share_plane(const struct mlrt_triangle *first, const struct mlrt_triangle *second)
{
    for (uint32_t axis = 0; axis < 3; ++axis)
        if (mlrt_is_across(first, axis) && mlrt_is_across(second, axis)) return first->v[0][axis] == second->v[0][axis];
    for (int i = 0; i < 3; ++i)
        if (certain_side(first, second->v[i], NO_STEP) != 0) return 0;
    for (int i = 0; i < 3; ++i)
        if (!has_corner(first, second->v[i]) && mlrt_exact_sign_beyond(second->v[i], NO_STEP, first, 1) != 0) return 0;
    return 1;
}
