/* SPDX-License-Identifier: MIT */
/*
 * Hulls and the planes of triangles: at which depths the rays of packets meet a plane, and which of two planes they
 * meet first.
 *
 * WHAT IS COMPUTED (L11, L18). Over the hull of a packet, edge functions and D lie within middle -+ radius, as in
 * leaf.h and with the same doubled bounds. A ray, which is at x + s z, meets the plane at the depth z = N / D, where
 *
 *     N = n . (a - w) - n_j x_j - n_l x_l.
 *
 * An intercept as computed is off by no more than blur (bundle.h), and |n_j|, |n_l| <= 2 in units of the size of n. So
 * N over the hull is off by DISTANCE_ERROR F + 4 blur. Twice that is taken, which covers the roundings of middle and
 * radius. D is off by PLANE_BOUND R, as in leaf.h.
 *
 * If D has one certain sign, which is made +1, z lies between two quotients: of the least N and of the greatest N, each
 * divided by that end of D which makes the quotient the least or the greatest; the sign of N tells which. Each quotient
 * has one rounding, and is moved outward by SLOPE_SLACK of itself.
 *
 * WHICH COMES FIRST (L14, L15). The line of two planes tells it (plane_order.c). It is an edge function, and is bounded
 * over the hull as those of leaf.h are, with its own error in place of EDGE_ERROR.
 */
#ifndef MLRT_TRACE_HULL_ORDER_H
#define MLRT_TRACE_HULL_ORDER_H

#include "hits/triangle_filter.h"
#include "job/stop.h"
#include "rays/slope_limits.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/hull_triangles.h"
#include "trace/leaf.h"
#include "trace/plane_order.h"
#include "trace/ray_hulls.h"

/* Bounds N over the hulls, and sets the depths `near` and `far`, which hold where `sure`. */
MLRT_INLINE void bound_depths(const struct mlrt_hulls *hulls, const struct mlrt_bundle_leaf *leaf, uint32_t triangle,
                              int v, int has_intercepts, struct seen_pairs *of)
{
    const vm backward = of->backward;
    vf middle = v_set1(leaf->planes.distance[triangle]), radius = v_set1(0), error = v_set1(0);
    if (!MLRT_GUESS) {
        error = v_set1(2 * DISTANCE_ERROR * leaf->planes.away[triangle] + 2 * DISTANCE_FLOOR);
        error = v_mul_add(v_load(hulls->filter.blur + v), v_set1(has_intercepts ? 8 : 0), error);
    }
    if (has_intercepts) {
        MLRT_UNROLL
        for (int i = 0; i < 2; ++i) {
            const vf n = v_set1(leaf->planes.normal[1 + i][triangle]);
            middle = v_sub(middle, v_mul(n, v_load(hulls->filter.middle[MLRT_INTERCEPT_J + i] + v)));
            radius = v_mul_add(v_abs(n), v_load(hulls->filter.radius[MLRT_INTERCEPT_J + i] + v), radius);
        }
    }
    const vf width = v_mul(v_load(hulls->filter.direction_size + v), v_set1(PLANE_BOUND)), zero = v_set1(0);
    const vf n = v_select(backward, v_sub(zero, middle), middle), room = v_add(radius, error);
    const vf least_n = v_sub(n, room), greatest_n = v_add(n, room);
    const vf from = v_sub(v_select(backward, v_sub(zero, of->greatest_d), of->least_d), width);
    const vf to = v_add(v_select(backward, v_sub(zero, of->least_d), of->greatest_d), width);
    const vf near = v_div(least_n, v_select(v_gt(least_n, zero), to, from));
    const vf far = v_div(greatest_n, v_select(v_gt(greatest_n, zero), from, to));
    const vf slack = v_set1(SLOPE_SLACK), floor = v_set1(HULL_FLOOR);
    of->near = v_sub(near, v_mul_add(v_abs(near), slack, floor));
    of->far = v_add(far, v_mul_add(v_abs(far), slack, floor));
}

/* What lines of planes tell of a triangle and others, one for each packet of a vector. */
struct order_of_packets {
    uint32_t in_plane; /* the other triangle lies in its plane */
    uint32_t farther;  /* all rays meet its plane behind that of the other */
    uint32_t nearer;   /* all rays meet it before */
};

/* Adds those of `places` whose order the line of a triangle and another tells (plane_order.c). */
MLRT_INLINE void add_order_by_line(const struct mlrt_hulls *hulls, const struct mlrt_pair_line *line, uint32_t places,
                                   int v, const struct seen_pairs *of, struct order_of_packets *order)
{
    const vf size = v_load(hulls->filter.direction_size + v), zero = v_set1(0),
             width = v_mul(size, v_set1(2 * PLANE_BOUND));
    const vf error = v_mul(size, v_set1(2 * line->error));
    const vf bound = v_mul_add(v_mul(v_load(hulls->filter.blur + v), size), v_set1(2 * line->steepness), error);
    vf f = v_set1(line->constant), d = v_set1(line->normal[0]), f_radius = zero, d_radius = zero;
    for (int i = 0; i < MLRT_RAY_TERMS; ++i) {
        const vf middle = v_load(hulls->filter.middle[i] + v), radius = v_load(hulls->filter.radius[i] + v);
        f = v_mul_add(v_set1(line->coefficient[i]), middle, f);
        f_radius = v_mul_add(v_abs(v_set1(line->coefficient[i])), radius, f_radius);
        if (i >= 2) continue;
        d = v_mul_add(v_set1(line->normal[1 + i]), middle, d);
        d_radius = v_mul_add(v_abs(v_set1(line->normal[1 + i])), radius, d_radius);
    }
    const vm above = v_gt(v_sub(f, f_radius), bound), below = v_lt(v_add(f, f_radius), v_sub(zero, bound));
    const vm forward_2 = v_gt(v_sub(d, d_radius), width), backward_2 = v_lt(v_add(d, d_radius), v_sub(zero, width));
    const vm forward = m_andnot(of->sure, of->backward);
    const vm same = m_or(m_and(forward_2, forward), m_and(backward_2, of->backward));
    const vm other = m_or(m_and(forward_2, of->backward), m_and(backward_2, forward));
    order->farther |= places & m_bits(m_or(m_and(above, same), m_and(below, other)));
    order->nearer |= places & m_bits(m_or(m_and(below, same), m_and(above, other)));
}

/*
 * Finds the order of a triangle and those in `others`, of which each packet has one, for the packets `places` of the
 * vector that begins at `v`. If the worker is stopped, the triangle counts as farther.
 */
static MLRT_NOINLINE struct order_of_packets find_order(const struct mlrt_job *job, struct mlrt_worker *worker,
                                                        struct mlrt_bundle *bundle, uint32_t number,
                                                        const uint32_t others[MLRT_BUNDLE_PACKETS], uint32_t places,
                                                        int v, const struct seen_pairs *of)
{
    struct order_of_packets order = {0, 0, 0};
    if (places && mlrt_is_stopped_in_step(worker)) return (struct order_of_packets){0, places, 0};
    while (places) {
        const uint32_t other = others[(uint32_t)v + mlrt_lowest_bit(places)];
        const uint32_t same = places & m_bits(i_eq(i_load(others + v), i_set1(other)));
        places &= ~same;
        if (other == MLRT_NONE || other == number) continue;
        const struct mlrt_pair_line *line = mlrt_find_pair_line(job->tree, number, other, worker, bundle->cache);
        if (line->kind == MLRT_ONE_PLANE) order.in_plane |= same;
        if (line->kind == MLRT_LINE) add_order_by_line(&bundle->hulls, line, same, v, of, &order);
    }
    return order;
}

#endif
