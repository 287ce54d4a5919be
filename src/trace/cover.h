/* SPDX-License-Identifier: MIT */
/*
 * One triangle against the hulls of all packets of a bundle at once: what becomes of closed packets.
 *
 * A packet is closed as long as it has met only one triangle that all of its rays hit, its cover, and triangles that
 * are surely behind the cover; or nothing at all. No ray of a closed packet is tested: all that is known is the
 * cover, and the depths between which its hits lie. A packet that meets any other triangle is opened: from then on
 * its rays are tested. L6, L11, ... are the lemmas of docs/accuracy.md, "Bundles".
 *
 * CLOSE COVERS (L14, L15). Where a triangle and the cover of a packet are so close that depths do not tell which comes
 * first, the line of their planes does (hull_order.h). So walls that are drawn twice leave packets closed.
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
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/cell_ends.h"
#include "trace/closed_packet.h"
#include "trace/cover_parts.h"
#include "trace/hull_order.h"
#include "trace/hull_triangles.h"
#include "trace/plane_sides.h"
#include "trace/ray_hulls.h"

/*
 * A triangle and a cover are put in order by their line only where the depths of both begin and end near each other: no
 * farther apart than this share of their widths, or this share of the depth. Where a triangle farther apart meets the
 * cover, as walls meet, the packet is opened all the same: the line would take 2 % of the time (erw6, arrays).
 */
#define MOST_APART   0.25f
#define ALWAYS_CLOSE 1e-4f

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

/* Makes a triangle the cover of the packets `covered` of a vector. */
MLRT_INLINE void set_covers(uint32_t covered, uint32_t number, int v, const struct seen_pairs *of,
                            struct mlrt_hulls *hulls)
{
    const vm kept = m_from_bits(covered);
    const vf last = v_load(hulls->last + v), cover_near = v_load(hulls->closed.cover_near + v);
    v_store(hulls->last + v, v_select(kept, v_min(of->far, last), last));
    v_store(hulls->closed.cover_near + v, v_select(kept, of->near, cover_near));
    i_store(hulls->closed.cover + v, i_select(kept, i_set1(number), i_load(hulls->closed.cover + v)));
}

/*
 * Offers a triangle to the packets `asked` of a vector, of which some are closed and may hit it. All of *of is set.
 * Adds to *offered what becomes of them.
 */
MLRT_INLINE void offer_to_vector(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_bundle *bundle,
                                 const struct mlrt_bundle_leaf *leaf, uint32_t triangle, int v, uint32_t asked,
                                 const struct seen_pairs *of, struct mlrt_offered_packets *offered)
{
    struct mlrt_hulls *hulls = &bundle->hulls;
    const uint32_t number = leaf->numbers[triangle], are_closed = bundle->state.closed >> v;
    const vm out_of_depth = m_or(v_gt(of->near, v_load(hulls->last + v)), v_lt(of->far, v_load(hulls->first + v)));
    const vm in_common = m_and(v_gt(of->near, v_load(hulls->closed.common_first + v)),
                               v_lt(of->far, v_load(hulls->closed.common_last + v)));
    const vm may_cover = m_and(of->inside, in_common);
    const uint32_t covers = m_bits(m_and(may_cover, v_lt(of->far, v_load(hulls->closed.cover_near + v))));
    const uint32_t is_cover = m_bits(i_eq(i_load(hulls->closed.cover + v), i_set1(number)));
    uint32_t met = asked & ~m_bits(m_or(of->out, m_and(of->sure, out_of_depth))), skipping = 0;
    if (met & are_closed) met &= ~find_out_of_reach(job, worker, bundle, leaf, triangle, v, met, of);
    met = leave_skipping_packets(bundle, number, v, met, covers, &skipping);
    offered->may |= (met & ~(is_cover & are_closed)) << v;

    /* Does it cover closed packets, or hide cells in part? */
    const uint32_t closed = met & are_closed & ~(is_cover | skipping), covered = covers & closed;
    offered->covered |= covered << v;
    if (covered) set_covers(covered, number, v, of, hulls);
    if (bundle->arrays && !worker->bundles->parts.lone_squares.left) {
        const uint32_t in_part = closed & ~covered & m_bits(m_and(of->sure, in_common));
        offered->in_part |= in_part << v;
        offered->backward |= m_bits(of->backward) << v;
        if (in_part) find_open_edges(bundle, leaf, triangle, v, m_bits(of->backward), worker->bundles->parts.open);
    }

    /* Which comes first, the triangle or the cover? */
    const uint32_t doubtful = job->any ? 0 : closed & ~covered;
    if (doubtful) {
        offered->may &= ~(settle_covers(job, worker, bundle, number, doubtful, m_bits(may_cover), v, of) << v);
    }
}

/* Tests a triangle against the hulls of the packets `among`, and sets covers. */
MLRT_INLINE struct mlrt_offered_packets offer_to_packets_by(const struct mlrt_job *job, struct mlrt_worker *worker,
                                                            struct mlrt_bundle *bundle,
                                                            const struct mlrt_bundle_leaf *leaf, uint32_t triangle,
                                                            uint32_t among, int has_intercepts)
{
    struct mlrt_offered_packets offered = {0, 0, 0, 0};
    for (int v = 0; v < MLRT_BUNDLE_PACKETS; v += VW) {
        const uint32_t asked = among >> v & ALL_LANES;
        if (!asked) continue;
        struct seen_pairs of;
        const struct hull_pairs pairs = {&bundle->hulls, leaf, (uint32_t)v, triangle, 1, has_intercepts};
        see_pairs(&pairs, &of);
        const uint32_t seen = asked & ~m_bits(of.out);
        if (!(seen & bundle->state.closed >> v)) {
            offered.may |= seen << v;
            continue;
        }
        bound_depths(&bundle->hulls, leaf, triangle, v, has_intercepts, &of);
        if (leaf->state.flipped >> triangle & 1) of.backward = m_andnot(of.sure, of.backward); /* of D, not of -D */
        offer_to_vector(job, worker, bundle, leaf, triangle, v, asked, &of, &offered);
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
