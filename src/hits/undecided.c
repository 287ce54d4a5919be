/* SPDX-License-Identifier: MIT */
/* Triangles in one plane, and rays that neither float nor vectors of doubles decide: see undecided.h. */
#include "hits/undecided.h"

#include <string.h>

#include "exact/nearest.h"
#include "job/read_lanes.h"
#include "job/stop.h"
#include "simd/sixteen.h"

/*
 * PLANES. Triangles that were found to lie in one plane form a tree: each refers to another triangle of its plane,
 * except the root, which represents all of them. The table is a cache: a triangle whose entry was overwritten
 * represents itself again, and is compared again when that is needed. So what the table says is true, and it need not
 * be complete. A new reference goes from one root to another, or replaces a reference that leads to the same root, so
 * there is no cycle.
 */

void mlrt_forget_planes(uint32_t plane_bits, struct mlrt_worker *worker)
{
    worker->known.plane_mask = (1u << plane_bits) - 1;
    memset(worker->known.planes, 0xFF, sizeof *worker->known.planes << plane_bits);
}

int mlrt_have_one_plane(const struct mlrt_tree *tree, uint32_t first, uint32_t second, struct mlrt_worker *worker)
{
    const uint32_t plane_1 = mlrt_known_plane_of(worker, first), plane_2 = mlrt_known_plane_of(worker, second);
    if (plane_1 == plane_2) return 1;
    if (mlrt_is_stopped_in_step(worker)) return 0;
    const struct mlrt_triangle triangles[2] = {mlrt_triangle_at(&tree->by_number, first),
                                               mlrt_triangle_at(&tree->by_number, second)};
    if (!mlrt_share_plane(&triangles[0], &triangles[1])) return 0;
    worker->known.planes[plane_1 & worker->known.plane_mask] = (struct mlrt_known_plane){plane_1, plane_2};
    worker->known.planes[first & worker->known.plane_mask] = (struct mlrt_known_plane){first, plane_2};
    return 1;
}

/*
 * Settles exact ties, which are common: surfaces that are there twice, walls in one plane. `nearest` is the nearest
 * hit of all `lanes`, and triangle `number` lies in its plane. So if a ray hits triangle `number`, it does at the same
 * t, which is known to be in range. A triangle that comes later in the input changes nothing, hit or not. An earlier
 * one becomes the nearest hit of the lanes that are surely inside it. Returns the lanes that are settled.
 */
static uint32_t settle_tie(uint32_t number, uint32_t nearest, uint32_t lanes, uint32_t inside,
                           struct mlrt_packet *packet)
{
    if (number > nearest) return lanes;
    lanes &= inside;
    for (uint32_t left = lanes; left; left &= left - 1) packet->nearest.triangle[mlrt_lowest_bit(left)] = number;
    return lanes;
}

uint32_t mlrt_settle_ties(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes, uint32_t inside,
                          struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    uint32_t settled = 0;
    while (lanes) {
        const uint32_t nearest = packet->nearest.triangle[mlrt_lowest_bit(lanes)];
        const uint32_t same = lanes & mlrt_same_words(packet->nearest.triangle, nearest);
        lanes &= ~same;
        if (nearest == MLRT_NONE || (number < nearest && !(same & inside))) continue;
        if (tree ? mlrt_have_one_plane(tree, number, nearest, worker)
                 : mlrt_known_plane_of(worker, number) == mlrt_known_plane_of(worker, nearest))
            settled |= settle_tie(number, nearest, same, inside, packet);
    }
    return settled;
}

/* Lets the judge decide lanes one by one. Returns those that have a nearer hit than before. */
static uint32_t judge_lanes(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes, struct mlrt_packet *packet,
                            struct mlrt_worker *worker, mlrt_counters *counters)
{
    uint32_t hit = 0;
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        struct mlrt_ray_segment ray;
        if (mlrt_is_stopped_in_step(worker)) break;
        mlrt_get_segment(packet, lane, &ray);
        struct mlrt_nearest nearest = {packet->nearest.triangle[lane], packet->nearest.lo[lane],
                                       packet->nearest.hi[lane]};
        if (!mlrt_offer_triangle(&tree->by_number, &ray, number, &nearest, counters)) continue;
        packet->nearest.triangle[lane] = nearest.triangle;
        packet->nearest.lo[lane] = nearest.lo;
        packet->nearest.hi[lane] = nearest.hi;
        hit |= 1u << lane;
    }
    return hit;
}

uint32_t mlrt_decide_lanes(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes, uint32_t inside,
                           struct mlrt_packet *packet, struct mlrt_worker *worker, mlrt_counters *counters)
{
    const uint32_t tied = mlrt_settle_ties(tree, number, lanes, inside, packet, worker), undecided = lanes & ~tied;
    if (counters) {
        counters->tie_lane_count += mlrt_count_bits(tied);
        counters->undecided_test_count += undecided != 0;
        counters->judged_lane_count += mlrt_count_bits(undecided);
    }
    return judge_lanes(tree, number, undecided, packet, worker, counters);
}
