/* SPDX-License-Identifier: MIT */
/*
 * The judge of every hit: signs and quotients of the hit rule, in double with a bound on the error; exactly where that
 * is not certain.
 *
 * Based on: Jonathan Richard Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
 * Predicates", 1997 (filter, then exact); Tomas Moeller, Ben Trumbore, "Fast, Minimum Storage Ray/Triangle
 * Intersection", 1997 (which products the three edges and the plane share).
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
 * The bound itself is rounded once, by less than 0.001 of it: SIGN_ERROR = 10 u and ORDER_ERROR = 18 u are enough.
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
 * and so is every partial sum on the way. SIGN_ERROR, ORDER_ERROR and the constants of the quotients are above 2^-50:
 * so these values times such a constant are normal doubles or 0 as well.
 */
#include "exact/predicate.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/platform.h"
#include "exact/big_numbers.h"
#include "exact/grid.h"
#include "exact/rounding.h"
#include "exact/vector.h"

#define SIGN_ERROR  (10 * MLRT_UNIT_ROUNDOFF)
#define ORDER_ERROR (18 * MLRT_UNIT_ROUNDOFF)

/* ---- in double --------------------------------------------------------------------------------------------------- */

/* A computed value, and the size that its error is relative to. */
struct measured {
    double value;
    double size;
};

/* n = (b - a) x (c - a), and the product of the sizes of its factors. */
struct normal {
    struct mlrt_vector n;
    double size;
};

MLRT_INLINE struct normal normal_of(const struct mlrt_triangle *triangle)
{
    const struct mlrt_vector a = mlrt_vector_at(triangle->v[0], 1);
    const struct mlrt_vector ab = mlrt_subtract(mlrt_vector_at(triangle->v[1], 1), a),
                             ac = mlrt_subtract(mlrt_vector_at(triangle->v[2], 1), a);
    return (struct normal){mlrt_cross(ab, ac), mlrt_size_of(ab) * mlrt_size_of(ac)};
}

/* The sign of a value whose error is at most error * size. 0: not certain, as for every value that is truly 0. */
MLRT_INLINE int certain_sign(struct measured measured, double error)
{
    double bound = error * measured.size;
    if (MLRT_GUESS) return measured.value >= 0 ? 1 : -1;
    return (measured.value > bound) - (measured.value < -bound);
}

/* The vectors of the determinants of the hit rule, and their sizes. */
struct operands {
    struct mlrt_vector ab, ac, direction, to_a;
    double ab_size, ac_size, direction_size, to_a_size;
};

MLRT_INLINE struct operands load_operands(const float origin[3], const float direction[3],
                                          const struct mlrt_triangle *triangle)
{
    struct operands operands;
    struct mlrt_vector a = mlrt_vector_at(triangle->v[0], 1);
    operands.ab = mlrt_subtract(mlrt_vector_at(triangle->v[1], 1), a);
    operands.ac = mlrt_subtract(mlrt_vector_at(triangle->v[2], 1), a);
    operands.direction = mlrt_vector_at(direction, 1);
    operands.to_a = mlrt_subtract(a, mlrt_vector_at(origin, 1));
    operands.ab_size = mlrt_size_of(operands.ab);
    operands.ac_size = mlrt_size_of(operands.ac);
    operands.direction_size = mlrt_size_of(operands.direction);
    operands.to_a_size = mlrt_size_of(operands.to_a);
    return operands;
}

/* e_ab and e_ca, which share a cross product. */
struct two_edges {
    struct measured ab, ca;
};

MLRT_INLINE struct two_edges measure_edges(const struct operands *operands)
{
    struct mlrt_vector moment = mlrt_cross(operands->direction, operands->to_a);
    double moment_size = operands->direction_size * operands->to_a_size;
    return (struct two_edges){{mlrt_dot(moment, operands->ab), moment_size * operands->ab_size},
                              {-mlrt_dot(moment, operands->ac), moment_size * operands->ac_size}};
}

/* D and N: where the ray's line crosses the plane, t = N / D. */
struct crossing {
    struct measured d, n;
};

MLRT_INLINE struct crossing measure_crossing(const struct operands *operands)
{
    struct mlrt_vector normal = mlrt_cross(operands->ab, operands->ac);
    double normal_size = operands->ab_size * operands->ac_size;
    return (struct crossing){{mlrt_dot(operands->direction, normal), operands->direction_size * normal_size},
                             {mlrt_dot(operands->to_a, normal), operands->to_a_size * normal_size}};
}

/* D and N of a ray and a triangle. Not inlined: that would take 2 kB and gain no time that can be measured. */
static MLRT_NOINLINE struct crossing cross_plane(const float origin[3], const float direction[3],
                                                 const struct mlrt_triangle *triangle)
{
    const struct operands operands = load_operands(origin, direction, triangle);
    return measure_crossing(&operands);
}

/* e_bc = D - e_ab - e_ca */
MLRT_INLINE struct measured measure_third_edge(const struct two_edges *edges, struct measured d)
{
    return (struct measured){d.value - edges->ab.value - edges->ca.value, d.size + edges->ab.size + edges->ca.size};
}

/* N - t D, t >= 0 */
MLRT_INLINE struct measured measure_beyond(const struct crossing *crossing, float t)
{
    return (struct measured){crossing->n.value - t * crossing->d.value, crossing->n.size + t * crossing->d.size};
}

/* N1 D2 - N2 D1 */
MLRT_INLINE struct measured measure_order(const struct crossing *first, const struct crossing *second)
{
    return (struct measured){first->n.value * second->d.value - second->n.value * first->d.value,
                             first->n.size * second->d.size + second->n.size * first->d.size};
}

/* ---- exactly ----------------------------------------------------------------------------------------------------- */

struct exact_vector {
    struct mlrt_exact x[3];
};

static void exact_vector_of(const float v[3], struct exact_vector *result)
{
    for (int k = 0; k < 3; ++k) mlrt_exact_from_double(v[k], &result->x[k]);
}

static void exact_vector_between(const float from[3], const float to[3], struct exact_vector *result)
{
    for (int k = 0; k < 3; ++k) mlrt_exact_from_difference(to[k], from[k], &result->x[k]);
}

static void exact_cross_component(const struct exact_vector *v, const struct exact_vector *w, int k,
                                  struct mlrt_exact *result)
{
    int i = (k + 1) % 3, j = (k + 2) % 3;
    struct mlrt_exact plus, minus;
    mlrt_exact_multiply(&v->x[i], &w->x[j], &plus);
    mlrt_exact_multiply(&v->x[j], &w->x[i], &minus);
    mlrt_exact_subtract(&plus, &minus, result);
}

static void exact_cross(const struct exact_vector *v, const struct exact_vector *w, struct exact_vector *result)
{
    for (int k = 0; k < 3; ++k) exact_cross_component(v, w, k, &result->x[k]);
}

static void exact_dot(const struct exact_vector *v, const struct exact_vector *w, struct mlrt_exact *result)
{
    struct mlrt_exact product[3], sum;
    for (int k = 0; k < 3; ++k) mlrt_exact_multiply(&v->x[k], &w->x[k], &product[k]);
    mlrt_exact_add(&product[0], &product[1], &sum);
    mlrt_exact_add(&sum, &product[2], result);
}

/* e_ij of the edge from v_i to v_j. */
static void exact_edge(const struct mlrt_ray_segment *ray, const float vertex_i[3], const float vertex_j[3],
                       struct mlrt_exact *result)
{
    struct exact_vector direction, to_i, edge, moment;
    exact_vector_of(ray->direction, &direction);
    exact_vector_between(ray->origin, vertex_i, &to_i);
    exact_vector_between(vertex_i, vertex_j, &edge);
    exact_cross(&direction, &to_i, &moment);
    exact_dot(&moment, &edge, result);
}

/* The signs of e_ab, e_bc, e_ca in sign[]: an entry that is not 0 on entry is known and stays. */
static void exact_edge_signs(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, int sign[3])
{
    if (MLRT_LIKELY(mlrt_grid_edge_signs(ray, triangle, sign))) return;
    for (int i = 0; i < 3; ++i) {
        struct mlrt_exact edge;
        if (sign[i] != 0) continue;
        exact_edge(ray, triangle->v[i], triangle->v[(i + 1) % 3], &edge);
        sign[i] = edge.sign;
    }
}

static void exact_normal(const struct mlrt_triangle *triangle, struct exact_vector *result)
{
    struct exact_vector ab, ac;
    exact_vector_between(triangle->v[0], triangle->v[1], &ab);
    exact_vector_between(triangle->v[0], triangle->v[2], &ac);
    exact_cross(&ab, &ac, result);
}

/* D and N of a ray and a triangle. */
static void exact_crossing(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle,
                           struct mlrt_exact *d, struct mlrt_exact *n)
{
    struct exact_vector normal, direction, to_a;
    exact_normal(triangle, &normal);
    exact_vector_of(ray->direction, &direction);
    exact_vector_between(ray->origin, triangle->v[0], &to_a);
    exact_dot(&direction, &normal, d);
    exact_dot(&to_a, &normal, n);
}

/* The sign of v . n. */
static int exact_side(const struct mlrt_triangle *triangle, const struct exact_vector *v)
{
    struct exact_vector normal;
    struct mlrt_exact height;
    exact_normal(triangle, &normal);
    exact_dot(v, &normal, &height);
    return height.sign;
}

/* The sign of first * second_factor - second * first_factor. */
static int exact_sign_of_difference(const struct mlrt_exact *first, const struct mlrt_exact *second_factor,
                                    const struct mlrt_exact *second, const struct mlrt_exact *first_factor)
{
    struct mlrt_exact plus, minus, difference;
    mlrt_exact_multiply(first, second_factor, &plus);
    mlrt_exact_multiply(second, first_factor, &minus);
    mlrt_exact_subtract(&plus, &minus, &difference);
    return difference.sign;
}

/* ---- triangle and plane ------------------------------------------------------------------------------------------ */

static MLRT_NOINLINE int has_area_exactly(const struct mlrt_triangle *triangle)
{
    struct exact_vector normal;
    exact_normal(triangle, &normal);
    return normal.x[0].sign != 0 || normal.x[1].sign != 0 || normal.x[2].sign != 0;
}

int mlrt_triangle_has_area(const struct mlrt_triangle *triangle)
{
    const struct normal normal = normal_of(triangle);
    // Components have 4 factors, the size has 7. A size of 0 is exact: two vertices are equal.
    if (mlrt_size_of(normal.n) > 3 * SIGN_ERROR * normal.size) return 1; // a component is above SIGN_ERROR * size
    return normal.size > 0 && has_area_exactly(triangle);
}

static MLRT_NOINLINE int side_of_plane_exactly(const struct mlrt_triangle *triangle, const float point[3])
{
    int sign;
    if (MLRT_LIKELY(mlrt_grid_distance_sign(triangle, point, &sign))) return -sign;
    struct exact_vector v;
    exact_vector_between(triangle->v[0], point, &v);
    return exact_side(triangle, &v);
}

/* The sign of v . n; 0 if double cannot tell. `size` is that of v, or those of its summands. */
static int certain_side(const struct mlrt_triangle *triangle, struct mlrt_vector v, double size)
{
    const struct normal normal = normal_of(triangle);
    return certain_sign((struct measured){mlrt_dot(v, normal.n), size * normal.size}, SIGN_ERROR);
}

static int certain_side_of_point(const struct mlrt_triangle *triangle, const float point[3])
{
    const struct mlrt_vector v = mlrt_subtract(mlrt_vector_at(point, 1), mlrt_vector_at(triangle->v[0], 1));
    return certain_side(triangle, v, mlrt_size_of(v));
}

int mlrt_side_of_plane(const struct mlrt_triangle *triangle, const float point[3])
{
    const int side = certain_side_of_point(triangle, point);
    return side != 0 ? side : side_of_plane_exactly(triangle, point);
}

static MLRT_NOINLINE int side_of_sum_exactly(const struct mlrt_triangle *triangle, const float from[3],
                                             const float by[3])
{
    struct exact_vector to_from, point;
    exact_vector_between(triangle->v[0], from, &to_from);
    for (int k = 0; k < 3; ++k) {
        mlrt_exact_from_double(by[k], &point.x[k]);
        const struct mlrt_exact step = point.x[k];
        mlrt_exact_add(&to_from.x[k], &step, &point.x[k]);
    }
    return exact_side(triangle, &point);
}

int mlrt_side_of_sum(const struct mlrt_triangle *triangle, const float from[3], const float by[3])
{
    const struct mlrt_vector to_from = mlrt_subtract(mlrt_vector_at(from, 1), mlrt_vector_at(triangle->v[0], 1)),
                             step = mlrt_vector_at(by, 1);
    const struct mlrt_vector v = {to_from.x + step.x, to_from.y + step.y, to_from.z + step.z};
    // A component of v has 2 factors, so the determinant has 9, relative to the sizes of the two summands of v.
    const int side = certain_side(triangle, v, mlrt_size_of(to_from) + mlrt_size_of(step));
    return side != 0 ? side : side_of_sum_exactly(triangle, from, by);
}

static MLRT_NOINLINE int facing_of_normal_exactly(const struct mlrt_triangle *triangle, const float direction[3])
{
    struct exact_vector along;
    exact_vector_of(direction, &along);
    return exact_side(triangle, &along);
}

int mlrt_facing(const struct mlrt_triangle *triangle, const float direction[3])
{
    int sign = certain_side(triangle, mlrt_vector_at(direction, 1), mlrt_size_of(mlrt_vector_at(direction, 1)));
    if (sign != 0) return sign;
    for (uint32_t axis = 0; axis < 3; ++axis) {
        if (direction[axis] == 0 && mlrt_is_across(triangle, axis)) return 0; /* such as a wall under vertical light */
    }
    return facing_of_normal_exactly(triangle, direction);
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
    exact_edge_signs(ray, triangle, sign);
    for (int i = 0; i < 3; ++i) {
        if (sign[i] * facing < 0) return 0;
        if (sign[i] != 0) facing = sign[i];
    }
    return facing;
}

/* The sign of N - t D. */
static MLRT_NOINLINE int sign_beyond_exactly(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle,
                                             float t, mlrt_counters *counters)
{
    if (counters) ++counters->exact_range_count;
    int sign;
    if (t == 0 && MLRT_LIKELY(mlrt_grid_distance_sign(triangle, ray->origin, &sign))) return sign;
    struct mlrt_exact n, d, one, exact_t;
    exact_crossing(ray, triangle, &d, &n);
    mlrt_exact_from_double(1, &one);
    mlrt_exact_from_double(t, &exact_t);
    return exact_sign_of_difference(&n, &one, &exact_t, &d);
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
                            const struct crossing *crossing, float t, int facing, mlrt_counters *counters)
{
    int sign = facing * certain_sign(measure_beyond(crossing, t), SIGN_ERROR);
    if (MLRT_LIKELY(sign != 0) || mlrt_reaches_flat(ray, triangle, t, &sign)) return sign;
    return facing * sign_beyond_exactly(ray, triangle, t, counters);
}

int mlrt_hits_triangle(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle,
                       mlrt_counters *counters)
{
    struct operands operands = load_operands(ray->origin, ray->direction, triangle);
    struct crossing crossing = measure_crossing(&operands);
    /* First, since many rays that are judged start beside a surface and leave it. */
    if (certain_sign(crossing.d, SIGN_ERROR) * certain_sign(measure_beyond(&crossing, ray->t_min), SIGN_ERROR) < 0)
        return 0;
    struct two_edges edges = measure_edges(&operands);
    int sign_ab = certain_sign(edges.ab, SIGN_ERROR);
    int sign_ca = certain_sign(edges.ca, SIGN_ERROR);
    if (sign_ab * sign_ca < 0) return 0;

    int sign_bc = certain_sign(measure_third_edge(&edges, crossing.d), SIGN_ERROR);
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
 * The sign of an edge function that is 0, when the origin has moved. The move changes it by
 * -((v_j - v_i) x d) . (e, e^2, e^3), so the first component that is not 0 decides. If all are 0, the ray is parallel
 * to the edge and D is 0: then the ray did not hit the triangle.
 */
static int perturbed_edge_sign(const struct mlrt_ray_segment *ray, const float vertex_i[3], const float vertex_j[3])
{
    struct exact_vector edge, direction;
    exact_vector_between(vertex_i, vertex_j, &edge);
    exact_vector_of(ray->direction, &direction);
    for (int k = 0; k < 3; ++k) {
        struct mlrt_exact component;
        exact_cross_component(&edge, &direction, k, &component);
        if (component.sign != 0) return -component.sign;
    }
    return 0;
}

static MLRT_NOINLINE int crosses_exactly(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle)
{
    int sign[3] = {0, 0, 0};
    exact_edge_signs(ray, triangle, sign);
    const int facing = sign[0] ? sign[0] : sign[1] ? sign[1] : sign[2];
    for (int i = 0; i < 3; ++i)
        if (sign[i] == 0 && perturbed_edge_sign(ray, triangle->v[i], triangle->v[(i + 1) % 3]) != facing) return 0;
    return 1;
}

int mlrt_crosses_triangle(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle)
{
    struct operands operands = load_operands(ray->origin, ray->direction, triangle);
    struct two_edges edges = measure_edges(&operands);
    struct crossing crossing = measure_crossing(&operands);
    int inside = certain_sign(edges.ab, SIGN_ERROR) != 0 && certain_sign(edges.ca, SIGN_ERROR) != 0 &&
                 certain_sign(measure_third_edge(&edges, crossing.d), SIGN_ERROR) != 0;
    return inside || crosses_exactly(ray, triangle);
}

/* ---- nearer ------------------------------------------------------------------------------------------------------ */

static MLRT_NOINLINE int compare_distance_exactly(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *first,
                                                  const struct mlrt_triangle *second)
{
    int sign;
    if (MLRT_LIKELY(mlrt_grid_order(ray, first, second, &sign))) return sign;
    struct mlrt_exact n1, d1, n2, d2;
    exact_crossing(ray, first, &d1, &n1);
    exact_crossing(ray, second, &d2, &n2);
    return d1.sign * d2.sign * exact_sign_of_difference(&n1, &d2, &n2, &d1);
}

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
    return compare_distance_exactly(ray, first, second);
}

int mlrt_compare_distance(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *first,
                          const struct mlrt_triangle *second, mlrt_counters *counters)
{
    const struct crossing crossing_1 = cross_plane(ray->origin, ray->direction, first);
    const struct crossing crossing_2 = cross_plane(ray->origin, ray->direction, second);
    int sign = certain_sign(crossing_1.d, SIGN_ERROR) * certain_sign(crossing_2.d, SIGN_ERROR) *
               certain_sign(measure_order(&crossing_1, &crossing_2), ORDER_ERROR);
    return MLRT_LIKELY(sign != 0) ? sign : compare_close_distance(ray, first, second, counters);
}

int mlrt_share_plane(const struct mlrt_triangle *first, const struct mlrt_triangle *second)
{
    for (uint32_t axis = 0; axis < 3; ++axis)
        if (mlrt_is_across(first, axis) && mlrt_is_across(second, axis)) return first->v[0][axis] == second->v[0][axis];
    for (int i = 0; i < 3; ++i)
        if (mlrt_side_of_plane(first, second->v[i]) != 0) return 0;
    return 1;
}

/* ------------------------------------------------------------------------------------------------------------------
 * Quotients
 *
 * X and D are computed determinants, x and d the true ones, s(X) and s(D) their sizes: |X - x| <= 8.001 u s(X) and
 * |D - d| <= 8.001 u s(D), see the head of this file. Let |D| > 2^-44 s(D). Then |D - d| < 1.01 * 2^-6 |D| and, since
 * 1 / (1 - 1.01 * 2^-6) < 1.017,
 *
 *     |x / d - X / D| = |(x - X) D - X (d - D)| / |d D| <= 1.017 * 8.001 u (s(X) + |X / D| s(D)) / |D|.
 *
 * The quotient q = X * (1 / D) is rounded twice more, and then q - w and q + w once each: 3.001 u |X / D| in all, which
 * is at most 3.01 u s(X) / |D| because |X| <= (1 + 20 u) s(X). The sum is below (11.2 s(X) + 8.2 |q| s(D)) u / |D|. The
 * constants in predicate.h are 12 and 9, which leaves room for the roundings of the half-width w itself.
 * ------------------------------------------------------------------------------------------------------------------ */

/* 1 / D, and the error of a quotient by D that comes from D, relative to the quotient. */
struct denominator {
    double inverse;
    double error;
};

/* low <= x / d <= high, for the true determinants. */
struct enclosure {
    double low, high;
};

MLRT_INLINE int is_safe_denominator(struct measured d)
{
    return fabs(d.value) > MLRT_LEAST_DENOMINATOR * d.size;
}

MLRT_INLINE struct denominator invert(struct measured d)
{
    double inverse = 1 / d.value;
    return (struct denominator){inverse, MLRT_DENOMINATOR_ERROR * d.size * fabs(inverse)};
}

MLRT_INLINE struct enclosure enclose_quotient(struct measured x, struct denominator d)
{
    double quotient = x.value * d.inverse;
    double width = MLRT_NUMERATOR_ERROR * x.size * fabs(d.inverse) + fabs(quotient) * d.error;
    return (struct enclosure){quotient - width, quotient + width};
}

void mlrt_bound_distance(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, float *lo, float *hi)
{
    const struct crossing crossing = cross_plane(ray->origin, ray->direction, triangle);
    if (MLRT_UNLIKELY(!is_safe_denominator(crossing.d))) {
        *lo = 0;
        *hi = INFINITY;
        return;
    }
    struct enclosure t = enclose_quotient(crossing.n, invert(crossing.d));
    *lo = mlrt_float_down(t.low > 0 ? t.low : 0); // a hit has t > 0
    *hi = mlrt_float_up(t.high);
}

int mlrt_offer_in_double(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle, int is_inside,
                         const struct mlrt_triangle *other, float *lo, float *hi)
{
    const struct operands operands = load_operands(ray->origin, ray->direction, triangle);
    const struct crossing crossing = measure_crossing(&operands);
    const int facing = certain_sign(crossing.d, SIGN_ERROR);
    const int beyond_t_min = facing * certain_sign(measure_beyond(&crossing, ray->t_min), SIGN_ERROR);
    if (beyond_t_min < 0) return 0; /* most rays that are offered here start beside a surface and leave it */
    if (facing == 0 || !is_safe_denominator(crossing.d)) return -1;
    if (!is_inside) {
        const struct two_edges edges = measure_edges(&operands);
        const int ab = facing * certain_sign(edges.ab, SIGN_ERROR), ca = facing * certain_sign(edges.ca, SIGN_ERROR);
        const int bc = facing * certain_sign(measure_third_edge(&edges, crossing.d), SIGN_ERROR);
        if (ab < 0 || bc < 0 || ca < 0) return 0;
        is_inside = ab > 0 && bc > 0 && ca > 0;
    }
    const struct enclosure t = enclose_quotient(crossing.n, invert(crossing.d));
    if (t.low > *hi) return 0;
    if (!is_inside || beyond_t_min == 0) return -1;
    if (!(t.high < *lo)) {
        if (!other) return -1;
        const struct crossing crossing_2 = cross_plane(ray->origin, ray->direction, other);
        const int order = facing * certain_sign(crossing_2.d, SIGN_ERROR) *
                          certain_sign(measure_order(&crossing, &crossing_2), ORDER_ERROR);
        if (order >= 0) return order > 0 ? 0 : -1;
    }
    *lo = mlrt_float_down(t.low > 0 ? t.low : 0);
    *hi = mlrt_float_up(t.high);
    return 1;
}

/* The float nearest to x / d. The quotient is not negative. */
static float round_quotient_exactly(const struct mlrt_exact *x, const struct mlrt_exact *d)
{
    if (x->sign == 0) return 0;
    // The relative errors are 2^-51 at most for each conversion and u for the division: below 2^-49 together.
    double quotient = fabs(mlrt_exact_to_double(x) / mlrt_exact_to_double(d));
    float low = (float)(quotient * (1 - 0x1p-49));
    float high = (float)(quotient * (1 + 0x1p-49));
    if (low == high) return low;

    // Neighbours. Quotients round to inf from midway between FLT_MAX and 2^128 on, as if 2^128 were the next float.
    double midpoint = 0.5 * ((double)low + (high > FLT_MAX ? 0x1p128 : (double)high));
    struct mlrt_exact exact_midpoint, threshold;
    mlrt_exact_from_double(midpoint, &exact_midpoint);
    mlrt_exact_multiply(&exact_midpoint, d, &threshold);
    int order = mlrt_exact_compare_magnitude(x, &threshold);
    if (order != 0) return order < 0 ? low : high;
    uint32_t low_bits;
    memcpy(&low_bits, &low, sizeof low_bits);
    return low_bits % 2 == 0 ? low : high;
}

/* Sets *result to the float that all numbers within 2^-49 of the quotient round to. Returns 0 if there is none. */
static int round_close_quotient(double quotient, float *result)
{
    *result = (float)(quotient * (1 + 0x1p-48));
    return (float)(quotient * (1 - 0x1p-48)) == *result;
}

/* Sets those of the outputs that grid.h determines. Returns the others. */
static uint32_t report_hit_on_grid(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle,
                                   uint32_t outputs, struct mlrt_hit_report *report)
{
    double quotient[3];
    float u, v;
    if (!(outputs & (MLRT_OUTPUT_T | MLRT_OUTPUT_UV)) || !mlrt_grid_quotients(ray, triangle, quotient)) return outputs;
    if (outputs & MLRT_OUTPUT_T && round_close_quotient(quotient[0], &report->t)) outputs &= ~(uint32_t)MLRT_OUTPUT_T;
    if (outputs & MLRT_OUTPUT_UV && round_close_quotient(quotient[1], &u) && round_close_quotient(quotient[2], &v)) {
        report->u = u;
        report->v = v;
        outputs &= ~(uint32_t)MLRT_OUTPUT_UV;
    }
    return outputs;
}

static MLRT_NOINLINE void report_hit_exactly(const struct mlrt_ray_segment *ray, const struct mlrt_triangle *triangle,
                                             uint32_t outputs, struct mlrt_hit_report *report)
{
    outputs = report_hit_on_grid(ray, triangle, outputs, report);
    if (!outputs) return;
    struct mlrt_exact x, d;
    exact_crossing(ray, triangle, &d, &x);
    if (outputs & MLRT_OUTPUT_FACING) report->facing = d.sign;
    if (outputs & MLRT_OUTPUT_T) report->t = round_quotient_exactly(&x, &d);
    if (outputs & MLRT_OUTPUT_UV) {
        exact_edge(ray, triangle->v[2], triangle->v[0], &x);
        report->u = round_quotient_exactly(&x, &d);
        exact_edge(ray, triangle->v[0], triangle->v[1], &x);
        report->v = round_quotient_exactly(&x, &d);
    }
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
                     struct mlrt_hit_report *report)
{
    struct operands operands = load_operands(ray->origin, ray->direction, triangle);
    struct crossing crossing = measure_crossing(&operands);
    if (MLRT_UNLIKELY(!is_safe_denominator(crossing.d))) {
        report_hit_exactly(ray, triangle, outputs, report);
        return;
    }
    struct denominator d = invert(crossing.d);
    uint32_t undecided = 0;
    if (outputs & MLRT_OUTPUT_FACING) report->facing = crossing.d.value > 0 ? 1 : -1;
    if (outputs & MLRT_OUTPUT_T) {
        if (!round_enclosure(enclose_quotient(crossing.n, d), &report->t) &&
            !round_flat_quotient(ray, triangle, &report->t)) {
            undecided |= MLRT_OUTPUT_T;
        }
    }
    if (outputs & MLRT_OUTPUT_UV) {
        struct two_edges edges = measure_edges(&operands);
        int both = round_enclosure(enclose_quotient(edges.ca, d), &report->u);
        both &= round_enclosure(enclose_quotient(edges.ab, d), &report->v);
        if (!both) undecided |= MLRT_OUTPUT_UV;
    }
    if (MLRT_UNLIKELY(undecided != 0)) report_hit_exactly(ray, triangle, undecided, report);
}
