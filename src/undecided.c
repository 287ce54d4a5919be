/* SPDX-License-Identifier: MIT */
#include "undecided.h"

#include "hit.h"
#include "output.h"
#include "packet.h"
#include "shear.h"

int mlrt_have_one_plane(const struct mlrt_tree *tree, uint32_t first, uint32_t second, struct mlrt_worker *worker)
{
    struct mlrt_plane_pair *pair = &worker->pairs[(first ^ second) % MLRT_PLANE_PAIR_COUNT];
    if (pair->first != first || pair->second != second) {
        pair->first = first;
        pair->second = second;
        pair->share = mlrt_share_plane(&tree->triangles[first], &tree->triangles[second]);
    }
    return pair->share;
}

/*
 * Exact ties are common: things drawn twice, walls of one plane. Where the nearest hit so far lies in the plane of the
 * triangle, so does the ray's hit of it: at the same t, which is known to be in range. So the later of the two in the
 * input changes nothing, whether it is hit or not, and the earlier one replaces the other where it is surely inside.
 * Returns the lanes of `lanes` that are settled so.
 */
static uint32_t settle_ties(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes, uint32_t inside,
                            struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    uint32_t settled = 0;
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes), nearest = packet->triangle[lane];
        if (nearest == MLRT_NONE) continue;
        const int earlier = number < nearest;
        if (earlier && !(inside >> lane & 1)) continue;
        if (!mlrt_have_one_plane(tree, number, nearest, worker)) continue;
        if (earlier) packet->triangle[lane] = number;
        settled |= 1u << lane;
    }
    return settled;
}

/* Hands single lanes to the judge. Returns those that are hit nearer than before. */
static uint32_t judge_lanes(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes, struct mlrt_packet *packet,
                            mlrt_counters *counters)
{
    uint32_t hit = 0;
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        struct mlrt_ray_segment ray;
        mlrt_get_segment(packet, lane, &ray);
        struct mlrt_nearest nearest = {packet->triangle[lane], packet->lo[lane], packet->hi[lane]};
        if (packet->shear) nearest.lo = 0, nearest.hi = INFINITY; /* not those of t */
        if (!mlrt_offer_triangle(tree, &ray, number, &nearest, counters)) continue;
        if (packet->shear) mlrt_shear_distance(packet->shear, &ray, &nearest);
        packet->triangle[lane] = nearest.triangle;
        packet->lo[lane] = nearest.lo;
        packet->hi[lane] = nearest.hi;
        hit |= 1u << lane;
    }
    return hit;
}

uint32_t mlrt_decide_lanes(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes, uint32_t inside,
                           struct mlrt_packet *packet, struct mlrt_worker *worker, mlrt_counters *counters)
{
    const uint32_t tied = settle_ties(tree, number, lanes, inside, packet, worker), undecided = lanes & ~tied;
    if (counters) {
        counters->tie_lane_count += mlrt_count_bits(tied);
        counters->undecided_test_count += undecided != 0;
        counters->judged_lane_count += mlrt_count_bits(undecided);
    }
    return judge_lanes(tree, number, undecided, packet, counters);
}

int mlrt_decide_triangles(const struct mlrt_job *job, const uint32_t *numbers, uint32_t undecided, uint32_t inside,
                          uint32_t lane, struct mlrt_packet *packet, struct mlrt_worker *worker,
                          mlrt_counters *counters)
{
    float origin[3], direction[3];
    uint32_t hit = 0;
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        origin[k] = packet->has_apex ? packet->apex[k] : packet->origin[k][lane];
        direction[k] = packet->direction[k][lane];
    }
    for (; undecided; undecided &= undecided - 1) {
        const uint32_t i = mlrt_lowest_bit(undecided), number = numbers[i];
        /* Most rays that come here start beside a surface, and leave it. */
        if (mlrt_leaves_plane(origin, direction, &job->tree->triangles[number])) {
            if (counters) {
                ++counters->undecided_test_count;
                ++counters->judged_lane_count;
            }
            continue;
        }
        hit |= mlrt_decide_lanes(job->tree, number, 1u << lane, (inside >> i & 1) << lane, packet, worker, counters);
        if (hit && job->any) break;
    }
    return hit != 0;
}
