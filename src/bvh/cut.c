/* SPDX-License-Identifier: MIT */
/* Cuts a set of references in two: looks for the split that costs least within the set's limits, and makes it. */
#include "bvh/build.h"

#include <math.h>
#include <string.h>

#include "base/tuning.h"
#include "bvh/unit.h"

/* ---- limits ---------------------------------------------------------------------------------------------------- */

/*
 * How a set shares its limits out to its two sides. Three quantities are bounded for any input:
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

/* 1 if sides of `lower` and `upper` references stay within the portion's budget and the depth limit. */
static int may_split(const struct mlrt_portion *portion, uint32_t lower, uint32_t upper)
{
    uint32_t larger = lower > upper ? lower : upper;
    return reserve(lower) + reserve(upper) <= portion->budget &&
           portion->depth + 1 + halving_depth(larger) <= MLRT_BVH_DEPTH_LIMIT;
}

/*
 * Sets the sides of a portion. Each gets its reserve of leaves first, then its part of the rest by size, and spare
 * places by size. A set too small for spatial splits shares out no spare places: its sides need none, and the
 * references of a set that may become one leaf must have no gap.
 */
static void share_out(const struct mlrt_bvh_build *build, const struct mlrt_portion *portion,
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

/* ---- looking for a split --------------------------------------------------------------------------------------- */

/* Adds `count` of a set's references, from `first` on, to its bins. */
static void fill_part(const struct mlrt_bvh_build *build, const struct mlrt_bvh_set *set, uint32_t first,
                      uint32_t count, struct mlrt_bvh_bins *bins)
{
    if (bins->kind == MLRT_SPLIT_BY_PLANE)
        mlrt_fill_slabs(build->tree->triangles, build->tree->bvh.unit, build->references.boxes, first, count, &set->box,
                        build->progress, bins);
    else
        mlrt_fill_bins(build, first, count, &set->centres, bins);
}

/* Adds a chunk of the shared set to the bins of a worker. */
static void fill_share(struct mlrt_bvh_build *build, uint32_t chunk, uint32_t worker)
{
    const struct mlrt_bvh_set *set = &build->work.shared->set;
    fill_part(build, set, set->first + chunk * MLRT_CHUNK_SIZE, mlrt_item_size(set->count, MLRT_CHUNK_SIZE, chunk),
              &build->work.shares[worker]);
}

/* Fills bins with the references of a portion, by all workers if it is shared; if cancelled, not with all. */
static void fill_bins(struct mlrt_bvh_build *build, const struct mlrt_portion *portion, enum mlrt_split_kind kind,
                      struct mlrt_bvh_bins *all)
{
    const uint32_t count = portion->set.count;
    mlrt_clear_bins(kind, count, all);
    if (build->work.shared != portion) {
        fill_part(build, &portion->set, portion->set.first, count, all);
        return;
    }
    const uint32_t worker_count = mlrt_worker_count(build->pool);
    for (uint32_t i = 0; i < worker_count; i++) build->work.shares[i] = *all;
    mlrt_run_step(build, mlrt_item_count(count, MLRT_CHUNK_SIZE), fill_share);
    for (uint32_t i = 0; i < worker_count; i++) mlrt_merge_bins(&build->work.shares[i], all);
}

/* Sets *split to the cheapest of its kind within the portion's limits. Not inlined, for the stack of a recursion. */
static MLRT_NOINLINE void find_split(struct mlrt_bvh_build *build, const struct mlrt_portion *portion,
                                     enum mlrt_split_kind kind, struct mlrt_bvh_split *split)
{
    struct mlrt_bvh_bins bins;
    if (kind != MLRT_SPLIT_BY_RANK) fill_bins(build, portion, kind, &bins);
    if (kind == MLRT_SPLIT_BY_RANK)
        mlrt_sweep_set(build, &portion->set, split);
    else if (kind == MLRT_SPLIT_BY_BIN)
        mlrt_choose_split(build, &bins, &portion->set, split);
    else
        mlrt_choose_plane(build, &bins, portion->set.count, portion->spare, split);
    if (split->cost < HUGE_VAL && !may_split(portion, split->count[0], split->count[1])) split->cost = HUGE_VAL;
}

/* 1 if the sides of the best split by centres overlap so much that a spatial split is tried, as Stich et al. do. */
static int overlaps(const struct mlrt_bvh_build *build, const struct mlrt_bvh_split *split)
{
    const struct mlrt_quad_box *a = &split->box[0], *b = &split->box[1];
    const struct mlrt_quad_box common = {{.v = f4_max(a->lo.v, b->lo.v)}, {.v = f4_min(a->hi.v, b->hi.v)}};
    for (int k = 0; k < 3; k++)
        if (common.lo.x[k] > common.hi.x[k]) return 0;
    return area_of(&common) > build->preset->overlap_limit * build->scene_area;
}

/* Sets *split to the cheapest of any kind. Counts a spatial split tried in vain, and forgets those when one is made. */
static void choose_split(struct mlrt_bvh_build *build, struct mlrt_portion *portion, struct mlrt_bvh_split *split)
{
    struct mlrt_bvh_split plane;
    const int is_sorted = portion->set.count <= MLRT_SWEEP_LIMIT;
    find_split(build, portion, is_sorted ? MLRT_SPLIT_BY_RANK : MLRT_SPLIT_BY_BIN, split);
    if (portion->spare == 0 || portion->set.count <= build->preset->spatial_size) return;
    /* Larger coordinates are too large for the float arithmetic of spatial_split.c. */
    if (!mlrt_is_within(portion->set.box.lo.x, portion->set.box.hi.x, MLRT_SAFE_MAX)) return;
    if (split->cost < HUGE_VAL && !is_sorted && !overlaps(build, split)) return;
    if (portion->failed_count > build->preset->failure_limit) return;
    find_split(build, portion, MLRT_SPLIT_BY_PLANE, &plane);
    portion->failed_count++;
    if (!(plane.cost < MLRT_PLANE_GAIN * split->cost)) return;
    *split = plane;
    portion->failed_count = 0;
}

/* ---- cutting ------------------------------------------------------------------------------------------------- */

/*
 * 1 if the split costs less than a leaf, or a leaf would have too many triangles. Another child of a node counts as a
 * sixteenth of a node.
 */
static int split_pays(const struct mlrt_bvh_build *build, const struct mlrt_bvh_set *set,
                      const struct mlrt_bvh_split *split)
{
    const struct mlrt_bvh_costs *costs = &build->costs;
    if (set->count > MLRT_LEAF_TRIANGLES) return 1;
    double area = area_of(&set->box);
    return split->cost + area * (costs->node / MLRT_BVH_WIDTH) < area * set_cost(costs, set->count);
}

/*
 * Moves the references of a set to another first place; their order does not matter, so only those outside the new
 * place are moved. If the call is cancelled, not all of them.
 */
static void move_set(const struct mlrt_bvh_build *build, struct mlrt_bvh_set *set, uint32_t first)
{
    const uint32_t distance = first > set->first ? first - set->first : set->first - first;
    const uint32_t count = distance < set->count ? distance : set->count;
    const uint32_t from = first > set->first ? set->first : set->first + set->count - count;
    const uint32_t to = first > set->first ? first + set->count - count : first;
    for (uint32_t i = 0; i < count && !mlrt_is_cancelled_in_round(build->progress, i + MLRT_CHUNK_SIZE);
         i += MLRT_CHUNK_SIZE)
        memcpy(build->references.boxes + to + i, build->references.boxes + from + i,
               (count - i < MLRT_CHUNK_SIZE ? count - i : MLRT_CHUNK_SIZE) * sizeof *build->references.boxes);
    set->first = first;
}

/* Sets `sides` to the halves of a set, as its references lie. If the call is cancelled, their boxes are unfinished. */
static void halve_set(const struct mlrt_bvh_build *build, const struct mlrt_bvh_set *set, struct mlrt_bvh_set sides[2])
{
    const uint32_t half = set->count / 2;
    sides[0] = mlrt_measure_set(build, set->first, half);
    sides[1] = mlrt_measure_set(build, set->first + half, set->count - half);
}

/*
 * Deals the references of a portion out to its sides: halves, if there is no split, or a spatial split leaves one side
 * empty. Returns 0 if the call is cancelled.
 */
static int apply_split(struct mlrt_bvh_build *build, const struct mlrt_portion *portion,
                       const struct mlrt_bvh_split *split, struct mlrt_portion sides[2])
{
    struct mlrt_bvh_set sets[2];
    if (split->cost == HUGE_VAL)
        halve_set(build, &portion->set, sets);
    else if (split->kind == MLRT_SPLIT_BY_PLANE)
        mlrt_apply_spatial_split(build, &portion->set, split, sets);
    else
        mlrt_apply_bvh_split(build, &portion->set, split, sets);
    if (mlrt_is_cancelled(build->progress)) return 0;
    if (sets[0].count == 0 || sets[1].count == 0) {
        const struct mlrt_bvh_set whole = sets[sets[0].count == 0];
        halve_set(build, &whole, sets);
    }
    share_out(build, portion, sets, sides);
    move_set(build, &sides[0].set, portion->set.first);
    move_set(build, &sides[1].set, portion->set.first + sides[0].set.count + sides[0].spare);
    return 1;
}

int mlrt_cut_portion(struct mlrt_bvh_build *build, struct mlrt_portion *portion, struct mlrt_portion sides[2])
{
    struct mlrt_bvh_split split;
    int is_small = portion->set.count <= MLRT_BVH_LEAF_LIMIT;
    if (is_small && (portion->budget < 2 || portion->set.count < 2)) return 0;
    if (mlrt_advance(build->progress, build->limits.cut_work * portion->set.count)) return 0;
    choose_split(build, portion, &split);
    /* If cancelled, bins may be unfinished, and a plane chosen from them may cut more references than fit. */
    if (split.kind == MLRT_SPLIT_BY_PLANE && mlrt_is_cancelled(build->progress)) return 0;
    if (is_small && (split.cost == HUGE_VAL || !split_pays(build, &portion->set, &split))) return 0;
    return apply_split(build, portion, &split, sides);
}
