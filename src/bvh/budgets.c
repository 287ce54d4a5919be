/* SPDX-License-Identifier: MIT */
/*
 * The limits of a build of boxes, and how a set shares its own out to its two sides. Three quantities are bounded for
 * any input:
 *
 *   Leaves. A set of n references has a budget of at least reserve(n) leaves, so that halving it down to sets of 16
 *   never exceeds the budget. A split is not made if the two sides need more than the budget. A binary hierarchy of b
 *   leaves has 2 b - 1 nodes, so each subtree has its own part of the array of nodes.
 *
 *   Depth. A split is made only if both sides can be halved to leaves in the levels that remain. A node of sixteen
 *   takes at least one binary level, so MLRT_BVH_DEPTH_LIMIT binary levels are never too deep.
 *
 *   References. A set has spare places behind its references (spatial splits make more of these), and a split is not
 *   made if it needs more.
 */
#include "bvh/build.h"

/* The most leaves of a set that is halved down to sets of 16: an only leaf, or leaves of 8 references or more. */
static uint32_t reserve(uint32_t count)
{
    return count <= MLRT_BVH_LEAF_LIMIT ? 1 : count / 8;
}

/* The levels that halving down to sets of 16 takes. */
static uint32_t halving_depth(uint32_t count)
{
    uint32_t depth = 0;
    for (; count > MLRT_BVH_LEAF_LIMIT; depth++) count -= count / 2;
    return depth;
}

/* a * b / c */
static uint32_t scale(uint32_t a, uint32_t b, uint64_t c)
{
    return (uint32_t)((uint64_t)a * b / c);
}

int mlrt_may_split(const struct mlrt_portion *portion, uint32_t lower, uint32_t upper)
{
    uint32_t larger = lower > upper ? lower : upper;
    return reserve(lower) + reserve(upper) <= portion->budget &&
           portion->depth + 1 + halving_depth(larger) <= MLRT_BVH_DEPTH_LIMIT;
}

/*
 * Each side gets its reserve of leaves first, then its part of the rest by size, and spare places by size. A set too
 * small for spatial splits shares out no spare places: its sides need none, and the references of a set that may become
 * one leaf must have no gap.
 */
void mlrt_share_out(const struct mlrt_bvh_build *build, const struct mlrt_portion *portion,
                    const struct mlrt_bvh_set sets[2], struct mlrt_portion sides[2])
{
    const uint64_t count = (uint64_t)sets[0].count + sets[1].count;
    const uint32_t rest = portion->budget - reserve(sets[0].count) - reserve(sets[1].count);
    const int is_last = portion->set.count <= build->preset->spatial_size;
    const uint32_t spare = is_last ? 0 : (uint32_t)(portion->set.count + portion->spare - count);
    const uint32_t depth = portion->depth + 1, failed_count = portion->failed_count;
    const uint32_t lower_budget = reserve(sets[0].count) + scale(rest, sets[0].count, count);
    const uint32_t lower_spare = scale(spare, sets[0].count, count), upper = portion->node + 2 * lower_budget;
    sides[0] = (struct mlrt_portion){sets[0], lower_spare, portion->node + 1, depth, lower_budget, failed_count};
    sides[1] =
        (struct mlrt_portion){sets[1], spare - lower_spare, upper, depth, portion->budget - lower_budget, failed_count};
}
