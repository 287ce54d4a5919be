/* SPDX-License-Identifier: MIT */
/*
 * What the float filters leave: exact ties in one plane, and then the judge, ray by ray (hit.h).
 */

/* Do two triangles lie in one plane? A worker remembers the last answers, since neighbours ask the same. */
static int share_plane(const struct mlrt_tree *tree, uint32_t first, uint32_t second, struct mlrt_worker *worker)
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
        if (!share_plane(tree, number, nearest, worker)) continue;
        if (earlier) packet->triangle[lane] = number;
        settled |= 1u << lane;
    }
    return settled;
}

/* Hands single lanes to the judge. Returns those that are hit nearer than before. */
static uint32_t judge_lanes(const struct mlrt_tree *tree, uint32_t number, uint32_t lanes, struct mlrt_packet *packet,
                            struct mlrt_worker *worker)
{
    uint32_t hit = 0;
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        struct mlrt_ray_segment ray;
        mlrt_get_segment(packet, lane, &ray);
        struct mlrt_nearest nearest = {packet->triangle[lane], packet->lo[lane], packet->hi[lane]};
        if (packet->shear) nearest.lo = 0, nearest.hi = INFINITY; /* not those of t */
        if (!mlrt_offer_triangle(tree, &ray, number, &nearest, MLRT_COUNTING ? &worker->counters : NULL)) continue;
        if (packet->shear) mlrt_shear_distance(packet->shear, &ray, &nearest);
        packet->triangle[lane] = nearest.triangle;
        packet->lo[lane] = nearest.lo;
        packet->hi[lane] = nearest.hi;
        hit |= 1u << lane;
    }
    return hit;
}

/* What the filter leaves of a test: exact ties, and then the judge. Returns the lanes whose nearest hit changed. */
static MLRT_SMALL uint32_t decide_lanes(const struct mlrt_tree *tree, uint32_t number, const struct outcome *outcome,
                                        struct mlrt_packet *packet, struct mlrt_worker *worker)
{
    const uint32_t tied = settle_ties(tree, number, outcome->undecided, outcome->inside, packet, worker);
    const uint32_t undecided = outcome->undecided & ~tied;
    COUNT(&worker->counters, tie_lane_count, mlrt_count_bits(tied));
    if (!undecided) return 0;
    COUNT(&worker->counters, undecided_test_count, 1);
    COUNT(&worker->counters, judged_lane_count, mlrt_count_bits(undecided));
    return judge_lanes(tree, number, undecided, packet, worker);
}
