/* SPDX-License-Identifier: MIT */
/*
 * Bounds of a triangle clipped to a box. The planes of the box, moved outward by a margin, cut the triangle one after
 * the other in double arithmetic. The bounds of the polygon that remains are widened by the same margin.
 *
 * Based on: Ivan Sutherland, Gary Hodgman, "Reentrant Polygon Clipping", 1974. Vlastimil Havran, Jiri Bittner, "On
 * Improving KD-Trees for Ray Shooting", 2002. The proof is our own.
 *
 * Why the bounds hold every common point. Let T be the triangle, M_k the largest |coordinate| of its vertices along
 * axis k, and u = 2^-53. A cut replaces the vertices outside its plane by points on edges (p inside, q outside),
 *
 *     x_k = fl(p_k + fl(t fl(q_k - p_k))),      t = fl(d_p / fl(d_p - d_q)) in [0, 1],
 *
 * where d is the distance from the plane. To each computed vertex x belongs a true point w of T: w = x for the vertices
 * of T, and w = (1 - t) w_p + t w_q, exactly, for a new vertex with the computed t.
 *
 * (a) |x_k - w_k| <= 5.01 u M_k after the first cut: the difference and the product are off by 2 u of
 *     t |q_k - p_k| <= 2 M_k, and the sum by u M_k. The errors of p and q enter that of x with weights that add up to
 *     1, so after s cuts |x_k - w_k| <= 5.01 s u M_k. Underflow adds at most 2^-1074 (1 + 2 M_k), which is negligible
 *     beside u M_k >= 2^-202.
 *
 * (b) The points w, in their order, form a convex polygon W, because each new w lies exactly on an edge of the polygon
 *     before the cut.
 *
 * (c) For each run of outside vertices, a cut removes from W the hull of their w and the two new w. Along the axis of
 *     the cut, the x of outside vertices are beyond the plane, so their w are at most 5.01 * 6 u M_k before it. The t
 *     of a new vertex is off by 4.01 u t, which moves the vertex by 4.01 u |d_p| <= 8.03 u M_k. So no point of the
 *     removed part is more than (5.01 * 6 + 8.03) u M_k < 39 u M_k before the plane.
 *
 * (d) There are at most seven cuts: six by the box and one that halves it. The planes lie MARGIN * M_k outside the box,
 *     up to rounding of 2 u M_k. (A plane at more than 2 M_k from the origin cuts off nothing, or rightly all of T.) So
 *     with a MARGIN of 41 u the removed parts have no point in the box, and every point that T and the box share is in
 *     the last W. That W reaches at most 7 * 5.01 u M_k < 36 u M_k outside the bounds of the computed x.
 *
 * MARGIN = 64 u is enough for (c), (d) and the widening. Vertices of T are exact: bounds are not widened for them.
 */
#include "scene/clip.h"

#include <math.h>
#include <string.h>

#include "base/platform.h"
#include "exact/rounding.h"

#define MARGIN 0x1p-47

/*
 * A cut turns n vertices into at most floor(3 n / 2), since every second vertex of a polygon that rounding has made
 * concave can be outside. The triangle and seven cuts: 3, 4, 6, 9, 13, 19, 28, 42.
 */
#define VERTEX_LIMIT 42

struct polygon {
    int vertex_count;
    double vertex[VERTEX_LIMIT][3];
    unsigned char computed[VERTEX_LIMIT]; /* 1 = a computed vertex, 0 = a vertex of the triangle */
};

struct bounds {
    double lo[3];
    double hi[3];
};

/* A plane across an axis. The inside is above it (sign +1) or below it (sign -1). */
struct plane {
    uint32_t axis;
    double sign;
    double position;
};

/* The distance from the plane; negative outside. */
MLRT_INLINE double distance_inside(const struct plane *plane, const double point[3])
{
    return plane->sign * (point[plane->axis] - plane->position);
}

static void add_vertex(struct polygon *polygon, const double point[3], int computed)
{
    memcpy(polygon->vertex[polygon->vertex_count], point, 3 * sizeof(double));
    polygon->computed[polygon->vertex_count++] = (unsigned char)computed;
}

/* Adds the point where the edge from `inner` to `outer` meets the plane. */
static void add_cut(const double inner[3], double inner_distance, const double outer[3], double outer_distance,
                    struct polygon *polygon)
{
    const double t = inner_distance / (inner_distance - outer_distance);
    double point[3];
    for (int k = 0; k < 3; k++) point[k] = inner[k] + t * (outer[k] - inner[k]);
    add_vertex(polygon, point, 1);
}

/* Sets *result to the part of the polygon inside the plane. A vertex in the plane stays, and its edges are not cut. */
static void cut_polygon(const struct polygon *polygon, const struct plane *plane, struct polygon *result)
{
    result->vertex_count = 0;
    if (polygon->vertex_count == 0) return;
    const double *last = polygon->vertex[polygon->vertex_count - 1];
    double last_distance = distance_inside(plane, last);
    for (int i = 0; i < polygon->vertex_count; i++) {
        const double *vertex = polygon->vertex[i], distance = distance_inside(plane, vertex);
        if (last_distance > 0 && distance < 0) add_cut(last, last_distance, vertex, distance, result);
        if (last_distance < 0 && distance > 0) add_cut(vertex, distance, last, last_distance, result);
        if (distance >= 0) add_vertex(result, vertex, polygon->computed[i]);
        last = vertex;
        last_distance = distance;
    }
}

static void find_margins(const struct mlrt_box *whole, double margin[3])
{
    for (int k = 0; k < 3; k++) margin[k] = MARGIN * (-whole->lo[k] > whole->hi[k] ? -whole->lo[k] : whole->hi[k]);
}

static void copy_triangle(const struct mlrt_triangle *triangle, struct polygon *polygon)
{
    polygon->vertex_count = 3;
    for (int i = 0; i < 9; i++) polygon->vertex[i / 3][i % 3] = triangle->v[i / 3][i % 3];
    memset(polygon->computed, 0, 3);
}

/*
 * Cuts polygon[0] by those planes of the box that the triangle reaches beyond. polygon[1] is used in turn; returns the
 * index of the result.
 */
static int cut_by_box(const struct mlrt_box *whole, const double margin[3], const struct mlrt_box *box,
                      struct polygon polygon[2])
{
    int current = 0;
    for (uint32_t k = 0; k < 3; k++) {
        const struct plane planes[2] = {{k, 1, box->lo[k] - margin[k]}, {k, -1, box->hi[k] + margin[k]}};
        const int is_beyond[2] = {planes[0].position > whole->lo[k], planes[1].position < whole->hi[k]};
        for (int side = 0; side < 2; side++) {
            if (!is_beyond[side]) continue;
            cut_polygon(&polygon[current], &planes[side], &polygon[1 - current]);
            current = 1 - current;
        }
    }
    return current;
}

MLRT_INLINE void extend(struct bounds *bounds, const double point[3], const double margin[3])
{
    for (int k = 0; k < 3; k++) {
        double lo = point[k] - margin[k], hi = point[k] + margin[k];
        bounds->lo[k] = lo < bounds->lo[k] ? lo : bounds->lo[k];
        bounds->hi[k] = hi > bounds->hi[k] ? hi : bounds->hi[k];
    }
}

/* The bounds of a polygon, widened for computed vertices. Without vertices they are inverted: lo > hi. */
static void bound_polygon(const struct polygon *polygon, const double margin[3], struct bounds *bounds)
{
    static const double no_margin[3];
    *bounds = (struct bounds){{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
    for (int i = 0; i < polygon->vertex_count; i++)
        extend(bounds, polygon->vertex[i], polygon->computed[i] ? margin : no_margin);
}

/* The largest float <= x that is 0 or at least `tiny` in magnitude. 0 is +0. */
MLRT_INLINE float round_down(double x, float tiny)
{
    if (x > -tiny && x < tiny) return x < 0 ? -tiny : 0.0f;
    return mlrt_float_down(x) + 0.0f;
}

static float round_up(double x, float tiny)
{
    return 0.0f - round_down(-x, tiny);
}

/* Intersects the box with the bounds, rounded outward. Returns 0 if they are disjoint; then the box is undefined. */
static int intersect_bounds(const struct bounds *bounds, float tiny, struct mlrt_box *box)
{
    for (int k = 0; k < 3; k++) {
        if (bounds->lo[k] > box->hi[k] || bounds->hi[k] < box->lo[k]) return 0;
        if (bounds->lo[k] > box->lo[k]) {
            float lo = round_down(bounds->lo[k], tiny);
            box->lo[k] = lo > box->lo[k] ? lo : box->lo[k];
        }
        if (bounds->hi[k] < box->hi[k]) {
            float hi = round_up(bounds->hi[k], tiny);
            box->hi[k] = hi < box->hi[k] ? hi : box->hi[k];
        }
    }
    return 1;
}

void mlrt_clip_halves(const struct mlrt_triangle *triangle, const struct mlrt_box *box, uint32_t axis, float position,
                      float tiny, struct mlrt_halves *halves)
{
    struct mlrt_box whole;
    double margin[3];
    struct polygon polygon[2];
    mlrt_bound_triangle(triangle, whole.lo, whole.hi);
    find_margins(&whole, margin);
    copy_triangle(triangle, &polygon[0]);
    int current = cut_by_box(&whole, margin, box, polygon);
    halves->box[0] = *box;
    halves->box[0].hi[axis] = position;
    halves->box[1] = *box;
    halves->box[1].lo[axis] = position;
    for (int side = 0; side < 2; side++) {
        double sign = side == 0 ? -1 : 1;
        struct plane plane = {axis, sign, position - sign * margin[axis]};
        struct bounds bounds;
        cut_polygon(&polygon[current], &plane, &polygon[1 - current]);
        bound_polygon(&polygon[1 - current], margin, &bounds);
        halves->touched[side] = intersect_bounds(&bounds, tiny, &halves->box[side]);
    }
}

double mlrt_clipped_area(const struct mlrt_triangle *triangle, const struct mlrt_box *box, uint32_t axis)
{
    static const double no_margin[3];
    struct mlrt_box whole;
    struct polygon polygon[2];
    mlrt_bound_triangle(triangle, whole.lo, whole.hi);
    copy_triangle(triangle, &polygon[0]);
    const struct polygon *part = &polygon[cut_by_box(&whole, no_margin, box, polygon)];
    uint32_t x = (axis + 1) % 3, y = (axis + 2) % 3;
    double doubled = 0;
    for (int i = 2; i < part->vertex_count; i++) {
        const double *a = part->vertex[0], *b = part->vertex[i - 1], *c = part->vertex[i];
        doubled += (b[x] - a[x]) * (c[y] - a[y]) - (b[y] - a[y]) * (c[x] - a[x]);
    }
    return 0.5 * fabs(doubled);
}
