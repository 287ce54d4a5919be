/* SPDX-License-Identifier: MIT */
/*
 * The builder of the hierarchy of boxes. References are cut in two, over and over, which gives a binary hierarchy;
 * collapse.c says which of its nodes become nodes of sixteen; these are written in depth-first order.
 *
 * The upper levels are built one set after the other, with the pool looking for the split, and below them each subtree
 * by itself, shared out to the pool. What becomes of a set depends on its references and its shares of depth, leaves
 * and room only, and everything has its place before it is made, so the number of threads changes nothing. (Bins that
 * several workers fill are put together by minima, maxima and sums of integers: it does not matter who filled which.)
 *
 * Three things are bounded for any input:
 *
 *   Leaves. A set of n references has a budget of leaves, at least reserve(n), so that halving it until 16 are left
 *   always stays within. A split that would leave one side with less than its reserve is not made. A binary hierarchy
 *   of b leaves has 2 b - 1 nodes, so each subtree has its own part of the array of nodes.
 *
 *   Depth. A split is made only if both sides can be halved to leaves in the levels that remain. A node of sixteen
 * takes at least one level, so a limit of MLRT_BVH_DEPTH_LIMIT binary levels would do, but is more than most scenes
 * need and less than some do. So it is built with a larger one first, and again with that one only if the result is too
 * deep.
 */
#include "bvh/build.h"

#include <math.h>
#include <string.h>

#include "base/progress.h"
#include "base/scheduler.h"
#include "base/tuning.h"
#include "bvh/check.h"
#include "bvh/collapse.h"
#include "bvh/spatial.h"
#include "bvh/split.h"
#include "bvh/unit.h"
#include "exact/predicate.h"

/* ---- settings ------------------------------------------------------------------------------------------------ */

struct preset {
    float spare_share;     /* room for references of triangles that are cut, per triangle */
    float overlap_limit;   /* planes are looked for where sides overlap by more than this part of the scene's area */
    uint32_t spatial_size; /* and sets have more references than this, at least MLRT_BVH_LEAF_LIMIT */
};

/*
 * Overlap limits of 1e-5, 1e-4, 1e-3: nodes per packet of 4x4 in clinic, a building, 6.08, 6.08, 6.45, and time to
 * build dragon, a scan, by 3 : 2 : 1.6. Room of 0.1, 0.15, 0.2: expected cost of clinic 18.8, 18.1, 17.8, of
 * sponza 12.8, 12.7, 12.6, at 89.6, 91.6, 93.3 bytes per triangle for the first.
 */
static const struct preset PRESETS[] = {
    {0.15f, 1e-4f, 32}, /* MLRT_TREE_DEFAULT */
    {0.0f, 1.0f, 32},   /* MLRT_TREE_FAST */
    {0.5f, 1e-6f, 16},  /* MLRT_TREE_BEST */
};

/*
 * Leaves cost about what nodes do, however many triangles they have: both are looked at sixteen wide. Nodes / leaves
 * per packet of 4x4 that a single walk visits (seven scenes, geometric mean of the sum), and triangles per leaf:
 *
 *     leaf, quad, triangle     sum     per leaf
 *     1.0   0     0.02         6.08    8.8 to 10.6
 *     1.0   0     0.03         6.10    8.1 to 9.2
 *     0.7   0     0.02         6.11    8.9 to 10.6
 *     1.5   0     0.02         6.12    8.4 to 10.2
 *     1.0   0.1   0.03         6.26    6.2 to 8.0
 *     0.5   0.05  0.03         6.25    6.9 to 8.5
 *     0.3   0.2   0.03         6.42    5.2 to 6.6
 *     0.8   0     0.08         6.35    5.1 to 7.0
 *
 * So small leaves save quads, by a third at most, but not visits. `quad` is there to be tried with other kernels.
 */
static const struct mlrt_bvh_costs COSTS = {1.0f, 1.0f, 0.0f, MLRT_TRIANGLE_COST};

/*
 * A plane must be this much better than the best other split. In scenes of regular parts both are often about the same,
 * and planes only cost references: with 1, erw10 (a room of equal squares) takes 3.79 nodes and 2.85 leaves per packet,
 * with 0.99 and 0.97 3.53 and 2.94. 0.9 is too much: a building (clinic) then takes 8.3 nodes instead of 6.1.
 */
#define PLANE_GAIN 0.99

/* References per leaf that the budget allows for on average: memory for nodes while building is 104 / 4 bytes each. */
#define LEAF_SHARE 4

/* Binary levels in the first attempt. It bounds the stack. */
#define BINARY_DEPTH 64

/* Of MLRT_BVH_WORK, what looking at a triangle first takes, and writing nodes at the end. */
#define FIRST_WORK 1.0
#define LAST_WORK  1.0

/* Subtrees of at most so many references, or of this part of all, are built by one worker. */
#define TASK_SIZE  4096
#define TASK_SHARE 64

/* So many references, or triangles, between two looks at whether the call goes on; the pool is given them at a time.
 * Looking for planes takes 3 ms for them. */
#define CHUNK_SIZE 4096

/* Quads and nodes have 29 bits in a child. */
#define COUNT_LIMIT (UINT32_MAX >> 3)

/* ---- one build ----------------------------------------------------------------------------------------------- */

/* A set to be cut, its place among the binary nodes, and what it may use. */
struct portion {
    struct mlrt_bvh_set set;
    uint32_t spare; /* places for references behind those of the set */
    uint32_t node;
    uint32_t depth;
    uint32_t budget; /* of leaves */
};

/* A subtree that one worker builds. */
struct task {
    struct portion portion;
    struct mlrt_forest_costs costs;
    uint32_t slots; /* children of the node above that it may become */
    uint32_t depth; /* of that node */
    struct mlrt_bvh_size size;
    struct mlrt_bvh_cursor cursor;
};

/* What a worker counts for all. */
struct share {
    struct mlrt_bvh_bins bins;
    struct mlrt_spatial_bins slabs;
};

/* References made of a chunk of triangles, and those that are left out. */
struct chunk {
    struct mlrt_box bounds; /* as given */
    uint32_t count;
    uint32_t non_finite_count;
    uint32_t zero_area_count;
};

struct build {
    struct mlrt_tree *tree;
    mlrt_pool *pool;
    const struct preset *preset;
    struct mlrt_bvh_costs costs;
    struct mlrt_quad_box *references;
    struct mlrt_binary_tree binary;
    struct task *tasks;
    struct share *shares;
    struct chunk *chunks;
    uint32_t capacity; /* references that there is room for */
    uint32_t reference_count;
    uint32_t leaf_limit;
    uint32_t task_capacity;
    uint32_t task_count;
    uint32_t task_size; /* sets up to this are tasks */
    uint32_t chunk_count;
    uint32_t depth_limit;
    double scene_area;              /* of the core: a few large boxes are as large as that */
    const struct portion *together; /* the set that the pool is looking at */
    struct mlrt_progress *progress;
    double cut_work; /* per reference of a set that is cut */
};

static float relative_area(const struct build *build, const struct mlrt_quad_box *box)
{
    const double area = mlrt_quad_box_area(box);
    return area < build->scene_area ? (float)(area / build->scene_area) : 1;
}

/* ---- references ---------------------------------------------------------------------------------------------- */

/* Beyond MLRT_BVH_FAR, where boxes have no bounds: here they have this one, to have an area. */
#define REFERENCE_LIMIT (2 * MLRT_BVH_FAR)

static float limit_reference(float bound)
{
    return bound < -REFERENCE_LIMIT ? -REFERENCE_LIMIT : bound > REFERENCE_LIMIT ? REFERENCE_LIMIT : bound;
}

/* Brings a reference into units. */
static void scale_reference(float unit, struct mlrt_quad_box *reference)
{
    for (int k = 0; k < 3; k++) {
        reference->lo[k] = limit_reference(mlrt_low_in_units(reference->lo[k], unit));
        reference->hi[k] = limit_reference(mlrt_high_in_units(reference->hi[k], unit));
    }
}

/* + 0 turns -0 into 0. */
static void set_reference(struct mlrt_quad_box *reference, const struct mlrt_triangle *triangle, uint32_t number)
{
    uint32_t bits = number | MLRT_REFERENCE_MARK;
    for (int k = 0; k < 3; k++) {
        float a = triangle->v[0][k], b = triangle->v[1][k], c = triangle->v[2][k];
        float lo = a < b ? a : b, hi = a < b ? b : a;
        reference->lo[k] = (c < lo ? c : lo) + 0.0f;
        reference->hi[k] = (c > hi ? c : hi) + 0.0f;
    }
    memcpy(&reference->lo[3], &bits, sizeof bits);
    reference->hi[3] = 0;
}

/* One reference for each triangle of the chunk that can be hit, from the chunk's own place on. */
static MLRT_NOINLINE void refer_to_chunk(struct build *build, uint32_t number)
{
    struct chunk *chunk = &build->chunks[number];
    uint32_t first = number * CHUNK_SIZE, left = build->tree->triangle_count - first;
    uint32_t last = first + (left < CHUNK_SIZE ? left : CHUNK_SIZE);
    const struct mlrt_box no_bounds = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    memset(chunk, 0, sizeof *chunk);
    chunk->bounds = no_bounds;
    for (uint32_t i = first; i < last; i++) {
        const struct mlrt_triangle *triangle = &build->tree->triangles[i];
        if (!mlrt_triangle_is_finite(triangle))
            chunk->non_finite_count++;
        else if (!mlrt_triangle_has_area(triangle))
            chunk->zero_area_count++;
        else
            set_reference(&build->references[first + chunk->count++], triangle, i);
    }
    for (uint32_t i = 0; i < chunk->count; i++) {
        struct mlrt_quad_box *reference = &build->references[first + i];
        int is_far = 0;
        for (int k = 0; k < 3; k++) {
            const float lo = reference->lo[k], hi = reference->hi[k];
            chunk->bounds.lo[k] = lo < chunk->bounds.lo[k] ? lo : chunk->bounds.lo[k];
            chunk->bounds.hi[k] = hi > chunk->bounds.hi[k] ? hi : chunk->bounds.hi[k];
            is_far |= lo < -MLRT_BVH_FAR || hi > MLRT_BVH_FAR;
        }
        if (build->tree->bvh.unit != 1 || is_far) scale_reference(build->tree->bvh.unit, reference);
    }
}

static int32_t run_chunk(void *work, uint32_t item, uint32_t worker)
{
    struct build *build = work;
    (void)worker;
    const uint64_t environment = mlrt_enter_fp_environment();
    refer_to_chunk(build, item);
    mlrt_leave_fp_environment(environment);
    return mlrt_advance(build->progress, CHUNK_SIZE * FIRST_WORK);
}

static void extend_bounds(const struct mlrt_box *bounds, struct mlrt_box *all)
{
    for (int k = 0; k < 3; k++) {
        if (bounds->lo[k] < all->lo[k]) all->lo[k] = bounds->lo[k];
        if (bounds->hi[k] > all->hi[k]) all->hi[k] = bounds->hi[k];
    }
}

/* References to all triangles, without gaps, and the bounds of all. Those left out are counted. */
static int32_t refer_to_all(struct build *build)
{
    struct mlrt_box bounds = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    mlrt_tree_info *info = &build->tree->info;
    info->non_finite_count = info->zero_area_count = 0;
    build->reference_count = 0;
    if (mlrt_run_items(build->pool, build->chunk_count, run_chunk, build)) return MLRT_ERROR_CANCELLED;
    for (uint32_t i = 0; i < build->chunk_count; i++) {
        const struct chunk *chunk = &build->chunks[i];
        if (build->reference_count != i * CHUNK_SIZE)
            memmove(&build->references[build->reference_count], &build->references[i * CHUNK_SIZE],
                    chunk->count * sizeof *build->references);
        build->reference_count += chunk->count;
        extend_bounds(&chunk->bounds, &bounds);
        info->non_finite_count += chunk->non_finite_count;
        info->zero_area_count += chunk->zero_area_count;
    }
    if (build->reference_count > 0) build->tree->bounds = bounds;
    mlrt_set_bvh_extent(build->tree);
    return MLRT_OK;
}

/* ---- budgets ------------------------------------------------------------------------------------------------- */

/* Leaves that halving leaves: at least 8 references in each if there are more than 16. */
static uint32_t reserve(uint32_t count)
{
    return count <= MLRT_BVH_LEAF_LIMIT ? 1 : count / 8;
}

/* Levels that halving takes. */
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

static int may_split(const struct build *build, const struct portion *portion, uint32_t lower, uint32_t upper)
{
    uint32_t larger = lower > upper ? lower : upper;
    return reserve(lower) + reserve(upper) <= portion->budget &&
           portion->depth + 1 + halving_depth(larger) <= build->depth_limit;
}

/*
 * Shares out what a portion may use to its sides: first what each needs, the rest by size. Sets that will not be cut by
 * planes have no use for room, and those that may become one leaf must have none between their sides.
 */
static void share_out(const struct build *build, const struct portion *portion, const struct mlrt_bvh_set sets[2],
                      struct portion sides[2])
{
    uint64_t count = (uint64_t)sets[0].count + sets[1].count;
    uint32_t rest = portion->budget - reserve(sets[0].count) - reserve(sets[1].count);
    uint32_t lower_budget = reserve(sets[0].count) + scale(rest, sets[0].count, count);
    int is_last = portion->set.count <= build->preset->spatial_size;
    uint32_t spare = is_last ? 0 : (uint32_t)(portion->set.count + portion->spare - count);
    uint32_t lower_spare = scale(spare, sets[0].count, count);
    sides[0] = (struct portion){sets[0], lower_spare, portion->node + 1, portion->depth + 1, lower_budget};
    sides[1] = (struct portion){sets[1], spare - lower_spare, portion->node + 2 * lower_budget, portion->depth + 1,
                                portion->budget - lower_budget};
}

/* ---- looking for a split --------------------------------------------------------------------------------------- */

struct choice {
    int spatial; /* 1 = by a plane */
    struct mlrt_bvh_split split;
    struct mlrt_spatial_split plane;
};

static uint32_t chunk_end(const struct portion *portion, uint32_t chunk)
{
    uint32_t left = portion->set.count - chunk * CHUNK_SIZE;
    return left < CHUNK_SIZE ? left : CHUNK_SIZE;
}

static int32_t fill_bins_item(void *work, uint32_t item, uint32_t worker)
{
    struct build *build = work;
    const struct portion *portion = build->together;
    const uint64_t environment = mlrt_enter_fp_environment();
    mlrt_fill_bins(build->references, portion->set.first + item * CHUNK_SIZE, chunk_end(portion, item),
                   &portion->set.centres, &build->shares[worker].bins);
    mlrt_leave_fp_environment(environment);
    return mlrt_is_cancelled(build->progress);
}

static int32_t fill_slabs_item(void *work, uint32_t item, uint32_t worker)
{
    struct build *build = work;
    const struct portion *portion = build->together;
    const uint64_t environment = mlrt_enter_fp_environment();
    mlrt_fill_spatial_bins(build->tree->triangles, build->tree->bvh.unit, build->references,
                           portion->set.first + item * CHUNK_SIZE, chunk_end(portion, item), &portion->set.box,
                           &build->shares[worker].slabs);
    mlrt_leave_fp_environment(environment);
    return mlrt_is_cancelled(build->progress);
}

static uint32_t chunks_of(uint32_t count)
{
    return count / CHUNK_SIZE + (count % CHUNK_SIZE != 0);
}

/* Whether so many references have such a chunk, and it is to be looked at. One chunk is not worth a look at the time.
 */
static int goes_on(const struct build *build, uint32_t count, uint32_t chunk)
{
    return chunk < chunks_of(count) && (chunk == 0 || !mlrt_is_cancelled(build->progress));
}

static void fill_bins(struct build *build, const struct portion *portion, struct mlrt_bvh_bins *bins)
{
    const struct mlrt_bvh_set *set = &portion->set;
    mlrt_clear_bins(bins);
    if (build->together != portion) {
        for (uint32_t i = 0; goes_on(build, set->count, i); i++)
            mlrt_fill_bins(build->references, set->first + i * CHUNK_SIZE, chunk_end(portion, i), &set->centres, bins);
        return;
    }
    uint32_t worker_count = mlrt_worker_count(build->pool);
    for (uint32_t i = 0; i < worker_count; i++) mlrt_clear_bins(&build->shares[i].bins);
    mlrt_run_items(build->pool, chunks_of(set->count), fill_bins_item, build);
    for (uint32_t i = 0; i < worker_count; i++) mlrt_merge_bins(&build->shares[i].bins, bins);
}

static void fill_slabs(struct build *build, const struct portion *portion, struct mlrt_spatial_bins *slabs)
{
    const struct mlrt_bvh_set *set = &portion->set;
    mlrt_clear_spatial_bins(slabs);
    if (build->together != portion) {
        for (uint32_t i = 0; goes_on(build, set->count, i); i++)
            mlrt_fill_spatial_bins(build->tree->triangles, build->tree->bvh.unit, build->references,
                                   set->first + i * CHUNK_SIZE, chunk_end(portion, i), &set->box, slabs);
        return;
    }
    uint32_t worker_count = mlrt_worker_count(build->pool);
    for (uint32_t i = 0; i < worker_count; i++) mlrt_clear_spatial_bins(&build->shares[i].slabs);
    mlrt_run_items(build->pool, chunks_of(set->count), fill_slabs_item, build);
    for (uint32_t i = 0; i < worker_count; i++) mlrt_merge_spatial_bins(&build->shares[i].slabs, slabs);
}

static MLRT_NOINLINE void look_for_split(struct build *build, const struct portion *portion,
                                         struct mlrt_bvh_split *split)
{
    if (portion->set.count <= MLRT_SWEEP_LIMIT) {
        mlrt_sweep_set(&build->costs, build->references, &portion->set, split);
    } else {
        struct mlrt_bvh_bins bins;
        fill_bins(build, portion, &bins);
        mlrt_choose_split(&build->costs, &bins, portion->set.count, split);
    }
    uint32_t lower = split->lower_count;
    if (split->cost < HUGE_VAL && !may_split(build, portion, lower, portion->set.count - lower)) split->cost = HUGE_VAL;
}

static MLRT_NOINLINE void look_for_plane(struct build *build, const struct portion *portion,
                                         struct mlrt_spatial_split *plane)
{
    struct mlrt_spatial_bins slabs;
    fill_slabs(build, portion, &slabs);
    mlrt_choose_spatial_split(&build->costs, &slabs, portion->set.count, portion->spare, plane);
    if (plane->cost < HUGE_VAL && !may_split(build, portion, plane->count[0], plane->count[1])) plane->cost = HUGE_VAL;
}

/* The paper's measure of when to look for planes: how much the sides of the best other split overlap. */
static int overlaps(const struct build *build, const struct mlrt_bvh_split *split)
{
    struct mlrt_quad_box common;
    for (int k = 0; k < 3; k++) {
        const struct mlrt_quad_box *a = &split->box[0], *b = &split->box[1];
        common.lo[k] = a->lo[k] > b->lo[k] ? a->lo[k] : b->lo[k];
        common.hi[k] = a->hi[k] < b->hi[k] ? a->hi[k] : b->hi[k];
        if (common.lo[k] > common.hi[k]) return 0;
    }
    return mlrt_quad_box_area(&common) > build->preset->overlap_limit * build->scene_area;
}

/* Coordinates must not be too large for spatial.c. */
static int may_be_cut(const struct mlrt_quad_box *box)
{
    for (int k = 0; k < 3; k++)
        if (box->lo[k] < -MLRT_SAFE_MAX || box->hi[k] > MLRT_SAFE_MAX) return 0;
    return 1;
}

static void choose(struct build *build, const struct portion *portion, struct choice *choice)
{
    look_for_split(build, portion, &choice->split);
    choice->spatial = 0;
    if (portion->spare == 0 || portion->set.count <= build->preset->spatial_size) return;
    if (!may_be_cut(&portion->set.box)) return;
    if (choice->split.cost < HUGE_VAL && !choice->split.sorted && !overlaps(build, &choice->split)) return;
    look_for_plane(build, portion, &choice->plane);
    choice->spatial = choice->plane.cost < PLANE_GAIN * choice->split.cost;
}

/* ---- cutting ------------------------------------------------------------------------------------------------- */

/* A sixteenth of a node is what another child of it costs. */
static int split_pays(const struct build *build, const struct mlrt_bvh_set *set, const struct mlrt_bvh_split *split)
{
    const struct mlrt_bvh_costs *costs = &build->costs;
    double area = mlrt_quad_box_area(&set->box);
    return split->cost + area * (costs->node / MLRT_BVH_WIDTH) < area * mlrt_bvh_leaf_cost(costs, set->count);
}

/* Moves a set, whose order does not matter, to another first place. Not all of it, if the call is to end. */
static void move_set(const struct build *build, struct mlrt_bvh_set *set, uint32_t first)
{
    const uint32_t distance = first > set->first ? first - set->first : set->first - first;
    const uint32_t count = distance < set->count ? distance : set->count;
    const uint32_t from = first > set->first ? set->first : set->first + set->count - count;
    const uint32_t to = first > set->first ? first + set->count - count : first;
    for (uint32_t chunk = 0; goes_on(build, count, chunk); chunk++) {
        const uint32_t begin = chunk * CHUNK_SIZE, left = count - begin;
        memcpy(build->references + to + begin, build->references + from + begin,
               (left < CHUNK_SIZE ? left : CHUNK_SIZE) * sizeof *build->references);
    }
    set->first = first;
}

/* Halves a set in which planes cut nothing off after all. */
static void halve(struct build *build, struct mlrt_bvh_set sets[2])
{
    static const struct mlrt_bvh_split NO_SPLIT = {.cost = HUGE_VAL};
    struct mlrt_bvh_set whole = sets[0].count > 0 ? sets[0] : sets[1];
    mlrt_apply_bvh_split(build->references, &whole, &NO_SPLIT, build->progress, sets);
}

/* Deals the references of a portion out to its sides. Returns 0 if the call is to end. */
static int apply(struct build *build, const struct portion *portion, const struct choice *choice,
                 struct portion sides[2])
{
    struct mlrt_bvh_set sets[2];
    if (choice->spatial)
        mlrt_apply_spatial_split(build->tree->triangles, build->tree->bvh.unit, build->references, &portion->set,
                                 &choice->plane, build->progress, sets);
    else
        mlrt_apply_bvh_split(build->references, &portion->set, &choice->split, build->progress, sets);
    if (mlrt_is_cancelled(build->progress)) return 0;
    if (sets[0].count == 0 || sets[1].count == 0) halve(build, sets);
    share_out(build, portion, sets, sides);
    move_set(build, &sides[0].set, portion->set.first);
    move_set(build, &sides[1].set, portion->set.first + sides[0].set.count + sides[0].spare);
    return 1;
}

static struct mlrt_binary_node *start_node(const struct build *build, const struct portion *portion)
{
    struct mlrt_binary_node *node = &build->binary.nodes[portion->node];
    memcpy(node->lo, portion->set.box.lo, sizeof node->lo);
    memcpy(node->hi, portion->set.box.hi, sizeof node->hi);
    node->first = portion->set.first;
    node->count = portion->set.count;
    node->upper = 0;
    return node;
}

/* Cuts a set in two, unless it is to be a leaf, or the call is to end. Returns whether it did. */
static int cut(struct build *build, const struct portion *portion, struct mlrt_binary_node *node,
               struct portion sides[2])
{
    struct choice choice;
    int is_small = portion->set.count <= MLRT_BVH_LEAF_LIMIT;
    if (is_small && (portion->budget < 2 || portion->set.count < 2)) return 0;
    if (mlrt_advance(build->progress, build->cut_work * portion->set.count)) return 0;
    choose(build, portion, &choice);
    /* Then bins may have been filled in part, and a plane cut more references than there is room for. */
    if (portion->set.count > CHUNK_SIZE && mlrt_is_cancelled(build->progress)) return 0;
    if (is_small && (choice.split.cost == HUGE_VAL || !split_pays(build, &portion->set, &choice.split))) return 0;
    if (!apply(build, portion, &choice, sides)) return 0;
    node->upper = sides[1].node;
    return 1;
}

/* ---- binary hierarchy ---------------------------------------------------------------------------------------- */

static void build_subtree(struct build *build, const struct portion *portion, struct mlrt_forest_costs *costs)
{
    struct mlrt_binary_node *node = start_node(build, portion);
    struct portion sides[2];
    struct mlrt_forest_costs side_costs[2];
    float area = relative_area(build, &portion->set.box);
    if (!cut(build, portion, node, sides)) {
        mlrt_choose_leaf(&build->costs, area, node, costs);
        for (uint32_t i = node->first; i < node->first + node->count; i++)
            build->binary.triangles[i] = mlrt_reference_triangle(&build->references[i]);
        return;
    }
    for (int side = 0; side < 2; side++) build_subtree(build, &sides[side], &side_costs[side]);
    mlrt_choose_cut(&build->costs, area, side_costs, node, costs);
}

static int32_t build_task(void *work, uint32_t item, uint32_t worker)
{
    struct build *build = work;
    (void)worker;
    const uint64_t environment = mlrt_enter_fp_environment();
    build_subtree(build, &build->tasks[item].portion, &build->tasks[item].costs);
    mlrt_leave_fp_environment(environment);
    return mlrt_is_cancelled(build->progress);
}

/* Cuts sets until they are small enough for tasks, and notes these in the order of the hierarchy. */
static void find_tasks(struct build *build, const struct portion *portion)
{
    struct portion sides[2];
    if (portion->set.count <= build->task_size) {
        build->tasks[build->task_count++].portion = *portion;
        return;
    }
    build->together = build->shares != NULL && portion->set.count > 2 * CHUNK_SIZE ? portion : NULL;
    if (!cut(build, portion, start_node(build, portion), sides)) return;
    for (int side = 0; side < 2; side++) find_tasks(build, &sides[side]);
}

static int is_next_task(const struct build *build, uint32_t number, uint32_t next_task)
{
    return next_task < build->task_count && build->tasks[next_task].portion.node == number;
}

/* The choices of the upper levels, when the tasks below them are done. */
static void choose_upper(const struct build *build, uint32_t number, uint32_t *next_task,
                         struct mlrt_forest_costs *costs)
{
    if (is_next_task(build, number, *next_task)) {
        *costs = build->tasks[(*next_task)++].costs;
        return;
    }
    struct mlrt_binary_node *node = &build->binary.nodes[number];
    struct mlrt_forest_costs side_costs[2];
    struct mlrt_quad_box box;
    memcpy(box.lo, node->lo, sizeof node->lo);
    memcpy(box.hi, node->hi, sizeof node->hi);
    choose_upper(build, number + 1, next_task, &side_costs[0]);
    choose_upper(build, node->upper, next_task, &side_costs[1]);
    mlrt_choose_cut(&build->costs, relative_area(build, &box), side_costs, node, costs);
}

/* ---- nodes of sixteen ---------------------------------------------------------------------------------------- */

/* Counts the nodes above the tasks, and tells these what they are to become. */
static void measure_upper(struct build *build, uint32_t number, uint32_t slots, uint32_t depth, uint32_t *next_task,
                          struct mlrt_bvh_size *size)
{
    if (is_next_task(build, number, *next_task)) {
        struct task *task = &build->tasks[(*next_task)++];
        task->slots = slots;
        task->depth = depth;
        return;
    }
    const struct mlrt_binary_node *node = &build->binary.nodes[number];
    struct mlrt_cut cut = mlrt_cut_of(node, slots);
    if (cut.kind == MLRT_CUT_NODE) {
        size->node_count++;
        depth++;
    }
    measure_upper(build, number + 1, cut.slots[0], depth, next_task, size);
    measure_upper(build, node->upper, cut.slots[1], depth, next_task, size);
}

static int32_t measure_task(void *work, uint32_t item, uint32_t worker)
{
    static const struct mlrt_bvh_size NOTHING;
    struct build *build = work;
    struct task *task = &build->tasks[item];
    (void)worker;
    task->size = NOTHING;
    mlrt_measure_forest(&build->binary, task->portion.node, task->slots, task->depth, &task->size);
    return mlrt_is_cancelled(build->progress);
}

static struct mlrt_bvh_size measure_all(struct build *build)
{
    struct mlrt_bvh_size size = {0, 0, 0, 0};
    uint32_t next_task = 0;
    measure_upper(build, 0, 1, 0, &next_task, &size);
    mlrt_run_items(build->pool, build->task_count, measure_task, build);
    for (uint32_t i = 0; i < build->task_count; i++) {
        const struct mlrt_bvh_size *part = &build->tasks[i].size;
        size.node_count += part->node_count;
        size.quad_count += part->quad_count;
        size.depth = part->depth > size.depth ? part->depth : size.depth;
    }
    if (build->binary.nodes[0].choice[1] == 0) size.node_count = size.depth = 1;
    return size;
}

/* Writes the nodes above the tasks, and tells these where theirs go. */
static void write_upper(struct build *build, uint32_t number, uint32_t slots, uint32_t *next_task,
                        struct mlrt_bvh_cursor *cursor)
{
    if (is_next_task(build, number, *next_task)) {
        struct task *task = &build->tasks[(*next_task)++];
        task->cursor = *cursor;
        cursor->node += (uint32_t)task->size.node_count;
        cursor->quad += (uint32_t)task->size.quad_count;
        cursor->slot += task->size.slot_count;
        return;
    }
    const struct mlrt_binary_node *node = &build->binary.nodes[number];
    struct mlrt_cut cut = mlrt_cut_of(node, slots);
    struct mlrt_bvh_cursor below, *inner = cursor;
    if (cut.kind == MLRT_CUT_NODE) {
        below = mlrt_start_node(node, build->tree, cursor);
        inner = &below;
    }
    write_upper(build, number + 1, cut.slots[0], next_task, inner);
    write_upper(build, node->upper, cut.slots[1], next_task, inner);
    cursor->node = inner->node;
    cursor->quad = inner->quad;
}

static int32_t write_task(void *work, uint32_t item, uint32_t worker)
{
    struct build *build = work;
    struct task *task = &build->tasks[item];
    (void)worker;
    mlrt_write_forest(&build->binary, task->portion.node, task->slots, build->tree, build->progress, &task->cursor);
    return mlrt_advance(build->progress, LAST_WORK * task->portion.set.count);
}

/* The root is a node even if one leaf would do. Otherwise it is the only child of a node that nobody needs. */
static int32_t write_all(struct build *build)
{
    struct mlrt_bvh_node above;
    uint32_t next_task = 0;
    int is_leaf = build->binary.nodes[0].choice[1] == 0;
    struct mlrt_bvh_cursor cursor = {is_leaf ? 1 : 0, 0, 0, is_leaf ? build->tree->bvh.nodes : &above};
    mlrt_clear_node(cursor.parent);
    write_upper(build, 0, 1, &next_task, &cursor);
    return mlrt_run_items(build->pool, build->task_count, write_task, build) ? MLRT_ERROR_CANCELLED : MLRT_OK;
}

/* ---- memory -------------------------------------------------------------------------------------------------- */

static void release(const struct build *build, void *block, size_t count, size_t size)
{
    mlrt_free(&build->tree->memory, block, count, size);
}

static size_t share_count(const struct build *build)
{
    uint32_t worker_count = mlrt_worker_count(build->pool);
    return worker_count > 1 ? worker_count : 0;
}

static size_t node_capacity(const struct build *build)
{
    return 2 * (size_t)build->leaf_limit - 1;
}

static int allocate_work(struct build *build)
{
    struct mlrt_memory *memory = &build->tree->memory;
    build->chunks = mlrt_allocate(memory, build->chunk_count, sizeof *build->chunks);
    build->references = mlrt_allocate(memory, build->capacity, sizeof *build->references);
    build->binary.nodes = mlrt_allocate(memory, node_capacity(build), sizeof *build->binary.nodes);
    build->binary.triangles = mlrt_allocate(memory, build->capacity, sizeof *build->binary.triangles);
    build->tasks = mlrt_allocate(memory, build->task_capacity, sizeof *build->tasks);
    if (share_count(build) > 0) build->shares = mlrt_allocate(memory, share_count(build), sizeof *build->shares);
    return build->chunks != NULL && build->references != NULL && build->binary.nodes != NULL &&
           build->binary.triangles != NULL && build->tasks != NULL &&
           (share_count(build) == 0 || build->shares != NULL);
}

static void release_references(struct build *build)
{
    release(build, build->references, build->capacity, sizeof *build->references);
    build->references = NULL;
}

static void release_work(struct build *build)
{
    release_references(build);
    release(build, build->chunks, build->chunk_count, sizeof *build->chunks);
    release(build, build->binary.nodes, node_capacity(build), sizeof *build->binary.nodes);
    release(build, build->binary.triangles, build->capacity, sizeof *build->binary.triangles);
    release(build, build->tasks, build->task_capacity, sizeof *build->tasks);
    release(build, build->shares, share_count(build), sizeof *build->shares);
}

void mlrt_free_bvh(struct mlrt_tree *tree)
{
    static const struct mlrt_bvh NONE;
    struct mlrt_bvh *bvh = &tree->bvh;
    mlrt_free(&tree->memory, bvh->nodes, bvh->node_count, sizeof *bvh->nodes);
    mlrt_free(&tree->memory, bvh->corners, 36 * (size_t)bvh->quad_count + 16, sizeof *bvh->corners);
    mlrt_free(&tree->memory, bvh->numbers, 4 * (size_t)bvh->quad_count + 16, sizeof *bvh->numbers);
    *bvh = NONE;
}

static int32_t allocate_result(struct mlrt_tree *tree, const struct mlrt_bvh_size *size)
{
    struct mlrt_bvh *bvh = &tree->bvh;
    if (size->node_count > COUNT_LIMIT || size->quad_count > COUNT_LIMIT) return MLRT_ERROR_TOO_LARGE;
    bvh->node_count = (uint32_t)size->node_count;
    bvh->quad_count = (uint32_t)size->quad_count;
    bvh->nodes = mlrt_allocate(&tree->memory, bvh->node_count, sizeof *bvh->nodes);
    bvh->corners = mlrt_allocate(&tree->memory, 36 * (size_t)bvh->quad_count + 16, sizeof *bvh->corners);
    bvh->numbers = mlrt_allocate(&tree->memory, 4 * (size_t)bvh->quad_count + 16, sizeof *bvh->numbers);
    if (bvh->nodes == NULL || bvh->corners == NULL || bvh->numbers == NULL) return MLRT_ERROR_OUT_OF_MEMORY;
    memset(bvh->corners + 36 * (size_t)bvh->quad_count, 0, 16 * sizeof *bvh->corners);
    memset(bvh->numbers + 4 * (size_t)bvh->quad_count, 0, 16 * sizeof *bvh->numbers);
    return MLRT_OK;
}

/* ---- the whole hierarchy ------------------------------------------------------------------------------------- */

/* The area of what a box shares with the core of the scene. */
static void measure_scene(struct build *build, const struct mlrt_quad_box *box)
{
    const struct mlrt_box *core = &build->tree->bvh.core;
    struct mlrt_quad_box part = *box;
    for (int k = 0; k < 3; k++) {
        if (core->lo[k] > part.lo[k]) part.lo[k] = core->lo[k];
        if (core->hi[k] < part.hi[k]) part.hi[k] = core->hi[k];
    }
    build->scene_area = mlrt_quad_box_area(&part);
}

/* Sets *size, unless the call is to end. */
static int32_t build_binary(struct build *build, uint32_t depth_limit, struct mlrt_bvh_size *size)
{
    struct portion root = {mlrt_measure_set(build->references, 0, build->reference_count, build->progress),
                           build->capacity - build->reference_count, 0, 0, build->leaf_limit};
    struct mlrt_forest_costs costs;
    uint32_t next_task = 0;
    measure_scene(build, &root.set.box);
    build->task_count = 0;
    build->depth_limit = depth_limit;
    find_tasks(build, &root);
    build->together = NULL;
    if (!mlrt_is_cancelled(build->progress)) mlrt_run_items(build->pool, build->task_count, build_task, build);
    if (mlrt_is_cancelled(build->progress)) return MLRT_ERROR_CANCELLED;
    choose_upper(build, 0, &next_task, &costs);
    *size = measure_all(build);
    return mlrt_is_cancelled(build->progress) ? MLRT_ERROR_CANCELLED : MLRT_OK;
}

static int32_t build_hierarchy(struct build *build)
{
    struct mlrt_tree *tree = build->tree;
    struct mlrt_bvh_size size;
    if (!allocate_work(build)) return MLRT_ERROR_OUT_OF_MEMORY;
    memset(&tree->bounds, 0, sizeof tree->bounds);
    mlrt_set_bvh_unit(tree);
    int32_t status = refer_to_all(build);
    if (status != MLRT_OK || build->reference_count == 0) return status;
    status = build_binary(build, BINARY_DEPTH, &size);
    if (status == MLRT_OK && size.depth > MLRT_BVH_DEPTH_LIMIT) {
        status = refer_to_all(build); // some were cut
        if (status == MLRT_OK) status = build_binary(build, MLRT_BVH_DEPTH_LIMIT, &size);
    }
    release_references(build);
    if (status == MLRT_OK) status = allocate_result(tree, &size);
    return status == MLRT_OK ? write_all(build) : status;
}

/* What follows from the options and the number of triangles. */
static void set_limits(const mlrt_tree_options *options, uint32_t triangle_count, struct build *build)
{
    build->preset = &PRESETS[options != NULL ? options->preset : MLRT_TREE_DEFAULT];
    build->costs = COSTS;
    if (options != NULL && options->traversal_cost > 0) build->costs.node = options->traversal_cost;
    if (options != NULL && options->intersection_cost > 0) build->costs.triangle = options->intersection_cost;
    build->capacity = triangle_count + (uint32_t)((float)triangle_count * build->preset->spare_share);
    build->leaf_limit = build->capacity / LEAF_SHARE + 1;
    build->task_size = build->capacity / TASK_SHARE > TASK_SIZE ? build->capacity / TASK_SHARE : TASK_SIZE;
    build->task_capacity = BINARY_DEPTH * (build->capacity / build->task_size) + 1; // as many on each level
    build->chunk_count = chunks_of(triangle_count);
    const double levels = log2((double)triangle_count / MLRT_BVH_LEAF_LIMIT + 2);
    build->cut_work = (MLRT_BVH_WORK - FIRST_WORK - LAST_WORK) / levels;
}

static const struct build NOTHING_BUILT;

int32_t mlrt_build_bvh(struct mlrt_tree *tree, const mlrt_tree_options *options, struct mlrt_progress *progress)
{
    static const struct mlrt_bvh NONE;
    struct build build = NOTHING_BUILT;
    tree->bvh = NONE;
    if (tree->triangle_count >= MLRT_REFERENCE_MARK) return MLRT_ERROR_TOO_LARGE;
    build.tree = tree;
    build.pool = options != NULL ? options->pool : NULL;
    build.progress = progress;
    set_limits(options, tree->triangle_count, &build);
    int32_t status = build_hierarchy(&build);
    release_work(&build);
    if (status == MLRT_OK) {
        mlrt_measure_bvh(tree, &build.costs, progress);
        if (mlrt_is_cancelled(progress)) status = MLRT_ERROR_CANCELLED;
    }
    if (status != MLRT_OK) mlrt_free_bvh(tree);
    return status;
}

/* ---- memory, before ------------------------------------------------------------------------------------------ */

/* Bytes of nodes and quads per triangle that scenes take, with some room: DEFAULT 47 to 56, FAST 47 to 51, BEST 49
 * to 65. */
static const double RESULT_SIZES[] = {58, 53, 66};

struct mlrt_demand mlrt_foresee_bvh(const mlrt_tree_options *options, uint32_t triangle_count)
{
    struct build build = NOTHING_BUILT;
    set_limits(options, triangle_count, &build);
    const uint64_t references = (uint64_t)build.capacity * sizeof *build.references;
    const uint64_t binary = (uint64_t)build.capacity * sizeof *build.binary.triangles +
                            node_capacity(&build) * (uint64_t)sizeof *build.binary.nodes +
                            build.task_capacity * (uint64_t)sizeof *build.tasks +
                            build.chunk_count * (uint64_t)sizeof *build.chunks +
                            (options->pool ? mlrt_worker_count(options->pool) * (uint64_t)sizeof *build.shares : 0);
    const uint64_t result = (uint64_t)(RESULT_SIZES[options->preset] * triangle_count) + sizeof(struct mlrt_bvh_node) +
                            2 * 52 * sizeof(float);
    return (struct mlrt_demand){result, binary + (references > result ? references : result)};
}
