/* SPDX-License-Identifier: MIT */
/*
 * One triangle against the hulls of all packets of a bundle at once, and closed packets.
 *
 * A packet is closed as long as it has met only one triangle that all of its rays hit, its cover, and triangles that
 * are surely behind the cover; or nothing at all. No ray of a closed packet is tested: all that is known is the
 * cover, and the depths between which its hits lie. A packet that meets any other triangle is opened: from then on
 * its rays are tested. L6, L11, ... are the lemmas of docs/accuracy.md, "Bundles".
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
 * CLOSE COVERS (L14, L15). Where a triangle and the cover of a packet are so close that depths do not tell which comes
 * first, the line of their planes does (plane_order.c). It is an edge function, and is bounded over the hull as those
 * of leaf.h are, with its own error in place of EDGE_ERROR. So walls that are drawn twice leave packets closed.
 *
 * BEGINS AND ENDS (L15). Rays begin on surfaces, and end on them. Whether they reach a triangle there is decided in
 * double, lane by lane (plane_sides.h); for tiles of arrays, whose rays are not made, by cell_ends.h.
 *
 * COVERS OF SEVERAL TRIANGLES (L22). Where any hit will do, a cell of arrays stays closed although a triangle hides
 * only some of its rays: cover_parts.c finds out whether others hide the rest. If not, it is opened at the end.
 *
 * CELLS OF A LIGHT (L20). The rays of such a packet skip a triangle S, and end before its plane, on the light's side
 * (shadow_ray.h). The hull contains the direction to a point of S, and D of S has one sign over it (add_order_by_line).
 * So all rays go towards S, and end at a t below that of S. A triangle that is met behind S, by the line, or that lies
 * in the plane of S, is not hit.
 *
 * Based on: Reshetov et al. 2005, section 4.1 (an object that every possible ray hits ends the search).
 */
#ifndef MLRT_TRACE_COVER_H
#define MLRT_TRACE_COVER_H

#include <math.h>

#include "hits/close_calls.h"
#include "hits/triangle_filter.h"
#include "job/stop.h"
#include "rays/slope_limits.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/cell_ends.h"
#include "trace/cover_parts.h"
#include "trace/hull_triangles.h"
#include "trace/leaf.h"
#include "trace/make_rays.h"
#include "trace/plane_order.h"
#include "trace/plane_sides.h"
#include "trace/ray_hulls.h"
#include "trace/units.h"

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

/*
 * A triangle and a cover are put in order by their line only where the depths of both begin and end near each other: no
 * farther apart than this share of their widths, or this share of the depth. Where a triangle farther apart meets the
 * cover, as walls meet, the packet is opened all the same: the line would take 2 % of the time (erw6, arrays).
 */
#define MOST_APART   0.25f
#define ALWAYS_CLOSE 1e-4f

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

/* Does a packet have its rays? */
MLRT_INLINE int has_rays(const struct mlrt_bundle *bundle, uint32_t place)
{
    return bundle->tile && bundle->tile->made >> place & 1;
}

/*
 * Makes the rays of a packet of which only the hull was known. Returns 0 if the packet has left the bundle: because
 * none of its rays can hit anything (rule R1), or because float does not carry one of them; then it is set aside if
 * it has active rays.
 */
static MLRT_NOINLINE int make_rays_of_packet(const struct mlrt_job *job, struct mlrt_bundle *bundle, uint32_t place)
{
    struct mlrt_packet *packet = &bundle->tile->packets[place];
    const int v = (int)(place - place % VW);
    make_rays(job, bundle->tile, place);
    if (MLRT_UNLIKELY(bundle->scene.unit != 1))
        check_packet_in_units(packet->active | packet->in_double, bundle->scene.unit, bundle->scene.reach, packet);
    int fits = packet->active && !packet->in_double;
    if (fits && (bundle->scene.unit != 1 || bundle->tile->seen)) { /* bounds of the rays are closer than the cell's */
        const float last = bundle->hulls.last[place];              /* may be the cover's */
        fits = !(packet->active & ~bound_rays(bundle, place)) && hulls_fit(bundle, 1u << place);
        finish_depths(bundle, 1u << place, v);
        if (last < bundle->hulls.last[place]) bundle->hulls.last[place] = last;
        finish_hulls(bundle, v);
    } else if (fits) {
        fits = !may_have_tiny_slopes(&bundle->hulls, place) || !has_tiny_slopes(bundle, packet);
    }
    if (fits) return 1;
    leave_bundle(bundle, place);
    bundle->state.set_aside |= packet->active ? 1u << place : 0;
    return 0;
}

/*
 * Opens a closed packet: makes its cover the nearest hit of all rays, at depths between those of the cover over all
 * rays. A packet that stands for a tile leaves the bundle.
 */
static MLRT_NOINLINE void open_bundle_packet(const struct mlrt_job *job, struct mlrt_bundle *bundle, uint32_t place)
{
    const struct mlrt_hulls *hulls = &bundle->hulls;
    bundle->state.closed &= ~(1u << place);
    if (!bundle->tile) {
        leave_bundle(bundle, place);
        return;
    }
    if (!has_rays(bundle, place) && !make_rays_of_packet(job, bundle, place)) return;
    need_lanes(bundle, place);
    if (hulls->closed.cover[place] == MLRT_NONE) return;
    struct mlrt_packet *packet = &bundle->tile->packets[place];
    struct mlrt_bundle_rays *rays = &bundle->tile->rays[place];
    const vf near = v_set1(hulls->closed.cover_near[place]), far = v_set1(hulls->last[place]),
             away = v_set1(hulls->filter.away[place]);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vm active = m_from_bits(packet->active >> v);
        const vf z = v_load(rays->to_waist[0] + v), slack = v_set1(SLOPE_SLACK), floor = v_set1(HULL_FLOOR);
        const vf lo = v_sub(v_add(near, z), v_mul_add(v_add(v_abs(near), away), slack, floor));
        const vf hi = v_add(v_add(far, z), v_mul_add(v_add(v_abs(far), away), slack, floor));
        v_store(rays->lo + v, v_select(active, v_max(lo, v_set1(0)), v_load(rays->lo + v)));
        v_store(rays->hi + v, v_select(active, hi, v_load(rays->hi + v)));
        i_store(packet->nearest.triangle + v,
                i_select(active, i_set1(hulls->closed.cover[place]), i_load(packet->nearest.triangle + v)));
    }
}

/* Ends a packet whose rays have never been tested: all of them hit its cover, or miss if it has none. */
MLRT_INLINE void finish_untouched_packet(struct mlrt_bundle *bundle, uint32_t place)
{
    struct mlrt_packet *packet = &bundle->tile->packets[place];
    const vi cover = i_set1(bundle->hulls.closed.cover[place]), none = i_set1(MLRT_NONE);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        i_store(packet->nearest.triangle + v, i_select(m_from_bits(packet->active >> v), cover, none));
    }
}

/* The rays of a packet that skip a triangle. */
MLRT_INLINE uint32_t skipping_lanes(const struct mlrt_bundle *bundle, uint32_t place, uint32_t number)
{
    const struct mlrt_packet *packet = &bundle->tile->packets[place];
    uint32_t skipping = 0;
    for (int v = 0; packet->has.skip && v < MLRT_PACKET_RAYS; v += VW) {
        skipping |= m_bits(i_eq(i_load(packet->skip + v), i_set1(number))) << v;
    }
    return skipping & packet->active;
}

/*
 * Decides by lines of planes between a triangle and the covers of closed packets (L15): the packets `doubtful` of the
 * vector that begins at `v`, where depths do not tell which comes first. A triangle behind the cover changes nothing. A
 * triangle before the cover becomes the cover of packets in `may_cover`. If both lie in one plane, the first in the
 * input becomes the cover if all rays pass inside it. Returns the packets that are decided.
 */
static MLRT_NOINLINE uint32_t settle_covers(const struct mlrt_job *job, struct mlrt_worker *worker,
                                            struct mlrt_bundle *bundle, uint32_t number, uint32_t doubtful,
                                            uint32_t may_cover, int v, const struct seen_pairs *of)
{
    struct mlrt_hulls *hulls = &bundle->hulls;
    const vf far = v_load(hulls->last + v), near = v_load(hulls->closed.cover_near + v);
    const vf apart = v_add(v_abs(v_sub(of->near, near)), v_abs(v_sub(of->far, far)));
    const vf width = v_sub(v_add(of->far, far), v_add(of->near, near));
    const vf close = v_mul_add(width, v_set1(MOST_APART), v_mul(v_abs(of->far), v_set1(ALWAYS_CLOSE)));
    const vi cover = i_load(hulls->closed.cover + v);
    doubtful &= m_bits(m_andnot(v_le(apart, close), i_eq(cover, i_set1(MLRT_NONE))));
    if (!doubtful) return 0;
    const struct order_of_packets order = find_order(job, worker, bundle, number, hulls->closed.cover, doubtful, v, of);
    const uint32_t later = order.in_plane & m_bits(i_lt(cover, i_set1(number)));
    const uint32_t nearer = order.nearer & may_cover, first = order.in_plane & ~later & m_bits(of->inside);
    const vm kept = m_from_bits(nearer);
    v_store(hulls->last + v, v_select(kept, v_min(of->far, far), far));
    v_store(hulls->closed.cover_near + v, v_select(kept, of->near, near));
    i_store(hulls->closed.cover + v, i_select(m_from_bits(nearer | first), i_set1(number), cover));
    return order.farther | nearer | later | first;
}

/*
 * Returns the packets of `places` of which no ray reaches a triangle: most rays start on the surface that it is part
 * of, or end before it. The packets are closed and have rays, which meet the plane where they may end (`at_end`) or
 * begin (the others). D has one sign for all rays of a packet, which is -1 in `backward`. That is D relative to the
 * waist; if depth goes down the main axis, D of the plane has the opposite sign.
 */
static MLRT_NOINLINE uint32_t find_packets_apart(const struct mlrt_tree *tree, const struct mlrt_bundle *bundle,
                                                 const struct mlrt_bundle_leaf *leaf, uint32_t triangle,
                                                 uint32_t places, uint32_t at_end, uint32_t backward)
{
    const uint32_t number = leaf->numbers[triangle];
    const struct mlrt_triangle corners = triangle_of_leaf(tree, leaf, triangle);
    struct mlrt_plane plane;
    struct measured_lanes n = {d_set1(0), d_set1(0)};
    const float *apex = NULL; /* whose N is in `n` */
    uint32_t apart = 0;
    mlrt_set_plane(&corners, &plane);
    if (bundle->waist.sign < 0) backward = ~backward;
    for (; places; places &= places - 1) {
        const uint32_t place = mlrt_lowest_bit(places);
        const struct mlrt_packet *packet = &bundle->tile->packets[place];
        const uint32_t lanes = packet->active & ~skipping_lanes(bundle, place, number);
        const int is_end = at_end >> place & 1;
        if (packet->has.apex && (!apex || memcmp(apex, packet->apex, sizeof packet->apex) != 0)) {
            apex = packet->apex;
            measure_n(&plane, packet, 0, &n);
        }
        const struct sides_of_plane sides =
            find_sides_of_plane(&plane, packet, is_end ? packet->t_max : NULL, backward >> place & 1 ? -1 : 1, &n);
        if (!(lanes & ~(is_end ? sides.before : sides.behind))) apart |= places & (0u - places);
    }
    return apart;
}

/*
 * Sets open[i], for the packets of a vector, to those for which edge i is open: not all rays are known to pass inside
 * it. D has one sign for each packet, which is -1 in `backward`.
 */
static MLRT_NOINLINE void find_open_edges(const struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf,
                                          uint32_t triangle, int v, uint32_t backward, uint32_t open[3])
{
    const struct hull_pairs pairs = {&bundle->hulls, leaf, (uint32_t)v, triangle, 1, bundle->has.intercepts};
    const vm turned = m_from_bits(leaf->state.flipped >> triangle & 1 ? ~backward : backward);
    const vf bound = edge_bounds(&pairs, 2);
    for (int i = 0; i < 3; ++i) {
        vf least, greatest;
        bound_edge(&pairs, i, &least, &greatest);
        const vm all_inside = v_gt(v_select(turned, v_sub(v_set1(0), greatest), least), bound);
        open[i] = (open[i] | ALL_LANES << v) & ~(m_bits(all_inside) << v);
    }
}

/*
 * Of the packets `met` of a vector, returns those that are closed and none of whose rays reaches the triangle. Only
 * packets that meet the plane near an end are asked: most others are opened all the same, and to test them takes 1.5 %
 * of the time (shadow rays of erw6).
 */
MLRT_INLINE uint32_t find_out_of_reach(const struct mlrt_job *job, struct mlrt_worker *worker,
                                       struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf,
                                       uint32_t triangle, int v, uint32_t met, const struct seen_pairs *of)
{
    const struct mlrt_hulls *hulls = &bundle->hulls;
    const vm near_begin = v_lt(of->near, v_load(hulls->closed.common_first + v));
    const vf common_last = v_load(hulls->closed.common_last + v), ends = v_sub(v_load(hulls->last + v), common_last);
    const vf close = v_mul_add(v_abs(of->far), v_set1(ALWAYS_CLOSE), v_add(ends, ends));
    const vm near_end = m_and(v_gt(of->far, common_last), v_le(v_sub(of->far, of->near), close));
    const uint32_t asked = m_bits(m_and(of->sure, m_or(near_begin, near_end))) & met & bundle->state.closed >> v;
    const uint32_t made = (bundle->tile ? bundle->tile->made : 0) >> v, packets = asked & made, cells = asked & ~made;
    const uint32_t at_end = ~m_bits(near_begin) << v, backward = m_bits(of->backward) << v;
    uint32_t apart = 0;
    if (cells && bundle->ends_at_skip) { /* see "CELLS OF A LIGHT" */
        const struct order_of_packets order =
            find_order(job, worker, bundle, leaf->numbers[triangle], hulls->closed.skip, cells, v, of);
        apart |= order.in_plane | order.farther;
    }
    if (cells && bundle->arrays)
        apart |= find_cells_apart(job->tree, bundle, leaf, triangle, cells << v, at_end, backward) >> v;
    if (packets) apart |= find_packets_apart(job->tree, bundle, leaf, triangle, packets << v, at_end, backward) >> v;
    return apart;
}

/*
 * Returns those packets of `met`, of a vector, not all of whose rays skip a triangle. Adds to *skipping the closed ones
 * of which a ray skips it, as far as `covers` or a packet's rays ask for that.
 */
MLRT_INLINE uint32_t leave_skipping_packets(const struct mlrt_bundle *bundle, uint32_t number, int v, uint32_t met,
                                            uint32_t covers, uint32_t *skipping)
{
    const uint32_t with_rays = (bundle->tile ? bundle->tile->made : 0) >> v & bundle->state.closed >> v;
    const uint32_t without = bundle->state.closed >> v & ~with_rays;
    met &= ~(m_bits(i_eq(i_load(bundle->hulls.closed.skip + v), i_set1(number))) & without);
    for (uint32_t left = bundle->arrays ? met & covers & without : 0; left; left &= left - 1) {
        if (cell_skips(bundle->arrays, (uint32_t)v + mlrt_lowest_bit(left), number)) *skipping |= left & (0u - left);
    }
    for (uint32_t left = met & with_rays; left; left &= left - 1) {
        const uint32_t place = (uint32_t)v + mlrt_lowest_bit(left), bit = left & (0u - left);
        const uint32_t lanes = skipping_lanes(bundle, place, number);
        if (!lanes) continue;
        *skipping |= bit;
        if (lanes == bundle->tile->packets[place].active) met &= ~bit;
    }
    return met;
}

/* Tests a triangle against the hulls of the packets `among`, and sets covers. */
MLRT_INLINE struct mlrt_offered_packets offer_to_packets_by(const struct mlrt_job *job, struct mlrt_worker *worker,
                                                            struct mlrt_bundle *bundle,
                                                            const struct mlrt_bundle_leaf *leaf, uint32_t triangle,
                                                            uint32_t among, int has_intercepts)
{
    struct mlrt_hulls *hulls = &bundle->hulls;
    const uint32_t number = leaf->numbers[triangle];
    struct mlrt_offered_packets offered = {0, 0, 0, 0};
    for (int v = 0; v < MLRT_BUNDLE_PACKETS; v += VW) {
        const uint32_t asked = among >> v & ALL_LANES;
        if (!asked) continue;
        struct seen_pairs of;
        const struct hull_pairs pairs = {hulls, leaf, (uint32_t)v, triangle, 1, has_intercepts};
        see_pairs(&pairs, &of);
        if (!(asked & ~m_bits(of.out) & bundle->state.closed >> v)) {
            offered.may |= (asked & ~m_bits(of.out)) << v;
            continue;
        }
        bound_depths(hulls, leaf, triangle, v, has_intercepts, &of);
        if (leaf->state.flipped >> triangle & 1) of.backward = m_andnot(of.sure, of.backward); /* of D, not of -D */
        const vf last = v_load(hulls->last + v), cover_near = v_load(hulls->closed.cover_near + v);
        const vm out_of_depth = m_or(v_gt(of.near, last), v_lt(of.far, v_load(hulls->first + v))),
                 passed = m_and(of.sure, out_of_depth);
        const vm in_common = m_and(v_gt(of.near, v_load(hulls->closed.common_first + v)),
                                   v_lt(of.far, v_load(hulls->closed.common_last + v)));
        const vm covers = m_and(m_and(of.inside, in_common), v_lt(of.far, cover_near));
        const vm is_cover = i_eq(i_load(hulls->closed.cover + v), i_set1(number));
        uint32_t met = asked & ~m_bits(m_or(of.out, passed)), skipping = 0;
        if (met & bundle->state.closed >> v) {
            met &= ~find_out_of_reach(job, worker, bundle, leaf, triangle, v, met, &of);
        }
        met = leave_skipping_packets(bundle, number, v, met, m_bits(covers), &skipping);
        /* Does it cover closed packets, or hide cells in part? */
        offered.may |= (met & ~(m_bits(is_cover) & bundle->state.closed >> v)) << v;
        const uint32_t closed = met & bundle->state.closed >> v & ~(m_bits(is_cover) | skipping);
        const uint32_t covered = m_bits(covers) & closed;
        if (covered) {
            const vm kept = m_from_bits(covered);
            offered.covered |= covered << v;
            v_store(hulls->last + v, v_select(kept, v_min(of.far, last), last));
            v_store(hulls->closed.cover_near + v, v_select(kept, of.near, cover_near));
            i_store(hulls->closed.cover + v, i_select(kept, i_set1(number), i_load(hulls->closed.cover + v)));
        }
        if (bundle->arrays && !worker->bundles->parts.lone_squares.left) {
            const uint32_t in_part = closed & ~covered & m_bits(m_and(of.sure, in_common));
            offered.in_part |= in_part << v;
            offered.backward |= m_bits(of.backward) << v;
            if (in_part) find_open_edges(bundle, leaf, triangle, v, m_bits(of.backward), worker->bundles->parts.open);
        }
        /* Which comes first, the triangle or the cover? */
        const uint32_t doubtful = job->any ? 0 : closed & ~covered;
        if (!doubtful) continue;
        offered.may &=
            ~(settle_covers(job, worker, bundle, number, doubtful, m_bits(m_and(of.inside, in_common)), v, &of) << v);
    }
    return offered;
}

/*
 * Offers a triangle to the packets `among`. Opens closed packets where that is needed. Returns the open packets whose
 * rays may hit the triangle. Where any hit will do, packets that it covers are done and leave the bundle.
 */
static MLRT_NOINLINE uint32_t offer_to_packets(const struct mlrt_job *job, struct mlrt_worker *worker,
                                               struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf,
                                               uint32_t triangle, uint32_t among)
{
    const struct mlrt_offered_packets of = bundle->has.intercepts
                                               ? offer_to_packets_by(job, worker, bundle, leaf, triangle, among, 1)
                                               : offer_to_packets_by(job, worker, bundle, leaf, triangle, among, 0);
    uint32_t may = of.may & among & ~of.covered, covered = of.covered;
    if (of.in_part) {
        struct mlrt_offered_packets parts = {may, covered, of.in_part, of.backward};
        mlrt_add_cover_part(bundle, leaf, triangle, cell_skips, &worker->bundles->parts, &parts);
        may = parts.may, covered = parts.covered;
    }
    for (uint32_t left = may & bundle->state.closed; left; left &= left - 1)
        open_bundle_packet(job, bundle, mlrt_lowest_bit(left));
    if (job->any) bundle->state.covered |= covered;
    for (uint32_t left = job->any ? covered : 0; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        leave_bundle(bundle, place);
        if (!has_rays(bundle, place)) continue;
        finish_untouched_packet(bundle, place);
        bundle->tile->packets[place].active = 0;
    }
    return may & bundle->state.going;
}

#endif
