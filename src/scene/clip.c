/* SPDX-License-Identifier: MIT */
/*
 * Bounds of a triangle clipped to a box: the planes of the box, moved outward by a margin, cut the triangle one after
 * the other in double arithmetic; the bounds of what is left are widened by the same margin.
 *
 * Based on: Ivan Sutherland, Gary Hodgman, "Reentrant Polygon Clipping", 1974. Vlastimil Havran, Jiri Bittner, "On
 * Improving KD-Trees for Ray Shooting", 2002. The proof is our own.
 *
 * Why no point is lost. Let T be the triangle, M_k the largest |coordinate| of its vertices along axis k, u = 2^-53.
 * A cut replaces vertices that are outside by points on edges (p inside, q outside),
 *
 *     x_k = fl(p_k + fl(t fl(q_k - p_k))),      t = fl(d_p / fl(d_p - d_q)) in [0, 1],
 *
 * where d is the distance from the plane. Besides each computed vertex x think of a true point w of T: w = x for the
 * vertices of T, and w = (1 - t) w_p + t w_q for new ones, exactly, with the t that was computed.
 *
 * (a) |x_k - w_k| <= 5.01 u M_k after the first cut: the difference and the product are off by 2 u of
 *     t |q_k - p_k| <= 2 M_k, the sum by u M_k. The errors of p and q pass into those of x with weights that add up
 *     to 1, so after s cuts |x_k - w_k| <= 5.01 s u M_k. Underflow adds at most 2^-1074 (1 + 2 M_k), which is nothing
 *     beside u M_k >= 2^-202.
 *
 * (b) The points w, in their order, are a convex polygon W: new ones lie exactly on edges of the polygon before.
 *
 * (c) What a cut removes of W is, for each run of outside vertices, the hull of these and the two new ones. Along the
 *     axis of the cut, the x of outside vertices are beyond the plane, and their w at most 5.01 * 6 u M_k before it.
 *     The t of new vertices is off by 4.01 u t, which moves them by 4.01 u |d_p| <= 8.03 u M_k. So no w of the removed
 *     part is more than (5.01 * 6 + 8.03) u M_k < 39 u M_k before the plane.
 *
 * (d) There are at most seven cuts: six by the box and one that halves it. The planes lie MARGIN * M_k outside of the
 *     box, within 2 u M_k from rounding (a plane farther out than 2 M_k cuts nothing, or everything and rightly so). A
 *     MARGIN of 41 u is therefore enough for the removed parts to have no point in the box: every point that T and the
 *     box share is in W to the end. W is at most 7 * 5.01 u M_k < 36 u M_k outside of the bounds of the computed x.
 *
 * MARGIN = 64 u serves for both. Vertices of T are exact, and the bounds are not widened for them.
 */
#include "scene/clip.h"

#include <math.h>
#include <string.h>

#include "base/platform.h"
#include "exact/rounding.h"

#define MARGIN 0x1p-47

/*
 * A cut of n vertices leaves at most floor(3 n / 2): rounded polygons need not be convex, so every second vertex might
 * be outside. 3, 4, 6, 9, 13, 19, 28.
 */
#define VERTEX_LIMIT 28

struct polygon {
    int vertex_count;
    double vertex[VERTEX_LIMIT][3];
    unsigned char computed[VERTEX_LIMIT]; /* 0 = a vertex of the triangle */
};

struct bounds {
    double lo[3];
    double hi[3];
};

/* How far vertices are inside of a plane. */
struct plane {
    uint32_t axis;
    double sign; /* +1 = above the plane is inside, -1 = below it is */
    double position;
};

MLRT_INLINE double distance_inside(const struct plane *plane, const double point[3])
{
    return plane->sign * (point[plane->axis] - plane->position);
}

static void cut_edge(const double inner[3], double inner_distance, const double outer[3], double outer_distance,
                     double point[3])
{
    double t = inner_distance / (inner_distance - outer_distance);
    for (int k = 0; k < 3; k++) point[k] = inner[k] + t * (outer[k] - inner[k]);
}

static void add_vertex(struct polygon *polygon, const double point[3], int computed)
{
    memcpy(polygon->vertex[polygon->vertex_count], point, 3 * sizeof(double));
    polygon->computed[polygon->vertex_count++] = (unsigned char)computed;
}

/* The edges that meet the plane in an inner vertex (distance 0) need no new one. */
static void cut_polygon(const struct polygon *polygon, const struct plane *plane, struct polygon *result)
{
    result->vertex_count = 0;
    int last = polygon->vertex_count - 1;
    double last_distance = last < 0 ? 0 : distance_inside(plane, polygon->vertex[last]);
    for (int i = 0; i < polygon->vertex_count; i++) {
        double distance = distance_inside(plane, polygon->vertex[i]);
        double point[3];
        if (last_distance > 0 && distance < 0) {
            cut_edge(polygon->vertex[last], last_distance, polygon->vertex[i], distance, point);
            add_vertex(result, point, 1);
        } else if (last_distance < 0 && distance > 0) {
            cut_edge(polygon->vertex[i], distance, polygon->vertex[last], last_distance, point);
            add_vertex(result, point, 1);
        }
        if (distance >= 0) add_vertex(result, polygon->vertex[i], polygon->computed[i]);
        last = i;
        last_distance = distance;
    }
}

static void bound_triangle(const struct mlrt_triangle *triangle, struct bounds *bounds)
{
    for (int k = 0; k < 3; k++) {
        double a = triangle->v[0][k], b = triangle->v[1][k], c = triangle->v[2][k];
        double lo = a < b ? a : b, hi = a < b ? b : a;
        bounds->lo[k] = c < lo ? c : lo;
        bounds->hi[k] = c > hi ? c : hi;
    }
}

static void find_margins(const struct bounds *bounds, double margin[3])
{
    for (int k = 0; k < 3; k++) margin[k] = MARGIN * (-bounds->lo[k] > bounds->hi[k] ? -bounds->lo[k] : bounds->hi[k]);
}

static void copy_triangle(const struct mlrt_triangle *triangle, struct polygon *polygon)
{
    polygon->vertex_count = 3;
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) polygon->vertex[i][k] = triangle->v[i][k];
        polygon->computed[i] = 0;
    }
}

/* Cuts with those planes of the box that the triangle reaches beyond. Returns which of the two polygons is the result.
 */
static int cut_by_box(const struct bounds *whole, const double margin[3], const struct mlrt_box *box,
                      struct polygon polygon[2])
{
    int current = 0;
    for (uint32_t k = 0; k < 3; k++) {
        struct plane below = {k, 1, box->lo[k] - margin[k]};
        struct plane above = {k, -1, box->hi[k] + margin[k]};
        if (whole->lo[k] < below.position) {
            cut_polygon(&polygon[current], &below, &polygon[1 - current]);
            current = 1 - current;
        }
        if (whole->hi[k] > above.position) {
            cut_polygon(&polygon[current], &above, &polygon[1 - current]);
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

/* The bounds of what a cut would leave of a polygon, widened. They stay inverted if nothing is left. */
static void bound_inside(const struct polygon *polygon, const struct plane *plane, const double margin[3],
                         struct bounds *bounds)
{
    static const double nothing[3];
    int last = polygon->vertex_count - 1;
    double last_distance = last < 0 ? 0 : distance_inside(plane, polygon->vertex[last]);
    for (int k = 0; k < 3; k++) {
        bounds->lo[k] = HUGE_VAL;
        bounds->hi[k] = -HUGE_VAL;
    }
    for (int i = 0; i < polygon->vertex_count; i++) {
        double distance = distance_inside(plane, polygon->vertex[i]);
        double point[3];
        if (last_distance > 0 && distance < 0) {
            cut_edge(polygon->vertex[last], last_distance, polygon->vertex[i], distance, point);
            extend(bounds, point, margin);
        } else if (last_distance < 0 && distance > 0) {
            cut_edge(polygon->vertex[i], distance, polygon->vertex[last], last_distance, point);
            extend(bounds, point, margin);
        }
        if (distance >= 0) extend(bounds, polygon->vertex[i], polygon->computed[i] ? margin : nothing);
        last = i;
        last_distance = distance;
    }
}

/* The largest float <= x that is allowed, +0 instead of -0. */
MLRT_INLINE float round_down(double x, float tiny)
{
    if (x > -tiny && x < tiny) return x < 0 ? -tiny : 0.0f;
    return mlrt_float_down(x) + 0.0f;
}

static float round_up(double x, float tiny)
{
    return 0.0f - round_down(-x, tiny);
}

/* Rounds outward and keeps what is in the box. Returns 0 if nothing is. */
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
    struct bounds whole;
    double margin[3];
    struct polygon polygon[2];
    bound_triangle(triangle, &whole);
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
        bound_inside(&polygon[current], &plane, margin, &bounds);
        halves->touched[side] = intersect_bounds(&bounds, tiny, &halves->box[side]);
    }
}

double mlrt_clipped_area(const struct mlrt_triangle *triangle, const struct mlrt_box *box, uint32_t axis)
{
    struct bounds whole;
    static const double no_margin[3];
    struct polygon polygon[2];
    bound_triangle(triangle, &whole);
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
