/* SPDX-License-Identifier: MIT */
/*
 * The builder of the hierarchy of boxes. It cuts sets of references in two, again and again: the result is a binary
 * hierarchy. collapse.c chooses which of its nodes become nodes of sixteen, and these are written in depth-first order.
 *
 * The upper sets are cut level by level. All workers of the pool fill the bins of a set that has much of its level; the
 * other sets of the level are cut by one worker each. Below them are subtrees (tasks), each built by one worker.
 *
 * The result does not depend on the number of threads: a set is split according to its references and its shares of
 * depth, leaves and spare places alone, every part has its place in the arrays before it is built, and the bins of
 * several workers are merged by minima, maxima and sums of integers.
 *
 * Three quantities are bounded for any input:
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
#include "bvh/node.h"

#include <math.h>
#include <string.h>

#include "base/message.h"
#include "base/progress.h"
#include "base/scheduler.h"
#include "base/tuning.h"
#include "bvh/collapse.h"
#include "bvh/split.h"
#include "bvh/unit.h"
#include "exact/predicate.h"

/* ---- settings ------------------------------------------------------------------------------------------------ */

struct preset {
    float spare_share;     /* spare places per triangle, for references that spatial splits add */
    float overlap_limit;   /* spatial splits are tried where sides overlap by more than this part of the scene's area */
    uint32_t spatial_size; /* and in sets of more references than this; at least MLRT_BVH_LEAF_LIMIT */
    uint32_t failure_limit; /* and not below sets in which they were tried in vain more than so many times on end */
};

/*
 * With overlap limits of 1e-5, 1e-4, 1e-3, a packet of 4x4 visits 6.08, 6.08, 6.45 nodes in clinic (a building), and
 * the times to build dragon (a scan) are as 3 : 2 : 1.6. With 0.1, 0.15, 0.2 spare places per triangle, the expected
 * cost of clinic is 18.8, 18.1, 17.8 and that of sponza 12.8, 12.7, 12.6; clinic takes 89.6, 91.6, 93.3 bytes per
 * triangle. With failure limits of 1, 2, 3 and none, dragon takes 0.61, 0.68, 0.76 and 1.34 s, clinic 1.51, 1.65, 1.87
 * and 1.86 s. The expected costs differ by 0.3 % (2), and by 0.7 % in sponza (1).
 */
static const struct preset PRESETS[] = {
    {MLRT_SPARE_SHARE, MLRT_OVERLAP_LIMIT, MLRT_SPATIAL_SIZE, 2}, /* MLRT_TREE_DEFAULT */
    {0.0f, 1.0f, 32, 0},                                          /* MLRT_TREE_FAST */
    {0.5f, 1e-6f, 16, UINT32_MAX},                                /* MLRT_TREE_BEST */
};

/*
 * A leaf costs about as much as a node, however many triangles it has, since both are tested sixteen wide. A packet of
 * 4x4 on its own visits 6.08 nodes and leaves (geometric mean of seven scenes). With leaf costs of 0.7 and 1.5 it visits
 * 6.11 and 6.12; with smaller leaves, by a cost of each quad or 0.08 for each triangle, 6.25 to 6.42.
 * docs/performance.md, "How large leaves are", has the speed with other costs.
 */
static const struct mlrt_bvh_costs COSTS = {1, MLRT_TRIANGLE_COST};

/* References per leaf, on average, that the budget allows for: so building takes 104 / 4 bytes of nodes for each. */
#define LEAF_SHARE (MLRT_LEAF_TRIANGLES / 4)

/* The parts of MLRT_BVH_WORK for making a triangle's reference first, and for writing nodes at the end. */
#define FIRST_WORK 1.0
#define LAST_WORK  1.0

/* One worker builds each subtree of at most so many references, or of at most this part of all references. */
#define TASK_SIZE  4096
#define TASK_SHARE 64

/*
 * The pool takes references, or triangles, in chunks of so many, and looks after each chunk whether the call is
 * cancelled. Filling the slabs of a chunk takes 3 ms.
 */
#define CHUNK_SIZE 4096

/*
 * Bytes of the block of references for each of them. It becomes the block of the leaves' corners, 36 to 46 bytes for
 * each, and the system need not clear other pages for these.
 */
#define REFERENCE_ROOM 40

/* A child has 29 bits for the number of a node or quad. */
#define COUNT_LIMIT (UINT32_MAX >> 3)

/* ---- one build ----------------------------------------------------------------------------------------------- */

/* A set to be cut, the number of its binary node, and its limits. */
struct portion {
    struct mlrt_bvh_set set;
    uint32_t spare; /* free places behind the references of the set */
    uint32_t node;
    uint32_t depth;
    uint32_t budget;       /* the most leaves */
    uint32_t failed_count; /* spatial splits tried in vain, for this set and those above it, since one was made */
};

/* The references of a chunk of triangles, and how many triangles are left out. */
struct chunk {
    struct mlrt_bvh_set set;
    struct mlrt_box bounds; /* of the references, not in units */
    uint64_t non_finite_count;
    uint64_t zero_area_count;
};

/* What follows from the options and the number of triangles. */
struct limits {
    uint32_t capacity;   /* references that there is room for */
    uint32_t leaf_limit; /* leaves of the binary hierarchy, at most */
    uint32_t task_size;  /* sets of at most so many references are tasks */
    uint32_t task_capacity;
    uint32_t level_capacity;
    uint32_t chunk_count; /* of triangles */
    double cut_work;      /* per reference of a set that is cut */
};

/* The arrays of a build except its references, in one block of memory. */
struct work {
    void *block;
    uint64_t size;
    struct portion *portions; /* the root, and the sides of all sets that are too large for tasks */
    uint32_t portion_count;
    struct portion **level;      /* those of one depth that are too large */
    struct portion **tasks;      /* those that one worker each builds, in depth-first order */
    struct mlrt_forest *forests; /* of the tasks, and one of no node at the end */
    uint32_t task_count;
    struct mlrt_bvh_bins *shares; /* of each worker, if there are several: bins of its part of a set */
    struct chunk *chunks;
    struct mlrt_bvh_part *parts; /* of the result, measured */
};

/* The set whose bins all workers fill. */
struct shared {
    const struct portion *portion; /* NULL = none */
    uint64_t least_size;           /* of the sets of a level that are shared */
};

/* The boxes of triangles, or of their parts, from which the hierarchy is built. */
struct references {
    struct mlrt_quad_box *boxes;
    struct mlrt_bvh_set whole; /* all of them before any is cut */
};

struct build {
    struct mlrt_tree *tree;
    mlrt_pool *pool;
    struct mlrt_progress *progress;
    const struct preset *preset;
    struct mlrt_bvh_costs costs;
    struct limits limits;
    struct references references;
    struct mlrt_binary_tree binary;
    double scene_area; /* area of the core of the scene; a few boxes may be larger */
    struct work work;
    struct shared shared;
};

/* A step of the build for the workers of the pool. `run` is called in the library's floating-point environment. */
struct step {
    struct build *build;
    double (*run)(struct build *build, uint32_t item, uint32_t worker); /* returns work that progress has not counted */
};

static int32_t run_item(void *work, uint32_t item, uint32_t worker)
{
    const struct step *step = work;
    double done;
    MLRT_COMPUTE(done = step->run(step->build, item, worker));
    return mlrt_advance(step->build->progress, done);
}

/* Returns a status. */
static int32_t run_step(struct build *build, uint32_t count, double (*run)(struct build *, uint32_t, uint32_t))
{
    struct step step = {build, run};
    return mlrt_run_items(build->pool, count, run_item, &step) ? MLRT_ERROR_CANCELLED : MLRT_OK;
}

/* The area of a box relative to the scene's, at most 1. */
static float relative_area(const struct build *build, const float lo[3], const float hi[3])
{
    const double area = area_between(lo, hi);
    return area < build->scene_area ? (float)(area / build->scene_area) : 1;
}

/* ---- references ---------------------------------------------------------------------------------------------- */

/* Brings a reference into units. */
static void scale_reference(float unit, struct mlrt_quad_box *reference)
{
    for (int k = 0; k < 3; k++) {
        reference->lo.x[k] = mlrt_finite_bound(mlrt_low_in_units(reference->lo.x[k], unit));
        reference->hi.x[k] = mlrt_finite_bound(mlrt_high_in_units(reference->hi.x[k], unit));
    }
}

/*
 * A reference to a whole triangle: the box of mlrt_bound_triangle. The last vertex is read from one float earlier, so as
 * not to read past it. A vector load that waited for the store of a single float would take as long as all of this.
 */
MLRT_INLINE struct mlrt_quad_box reference_of(const struct mlrt_triangle *triangle, uint32_t number)
{
    const uint32_t bits = number | MLRT_REFERENCE_MARK;
    const f4 a = f4_load_any(triangle->v[0]), b = f4_load_any(triangle->v[1]), zero = f4_set1(0);
    const f4 c = f4_rest(f4_load_any(triangle->v[1] + 2));
    const f4 lo = f4_add(f4_min(c, f4_min(a, b)), zero), hi = f4_add(f4_max(c, f4_max(a, b)), zero);
    float word;
    memcpy(&word, &bits, sizeof word);
    return (struct mlrt_quad_box){{.v = f4_join(lo, f4_set1(word))}, {.v = f4_join(hi, zero)}};
}

/* Makes a reference for each triangle of a chunk that is not left out, from the place of the chunk's first triangle. */
static double make_chunk_references(struct build *build, uint32_t number, uint32_t worker)
{
    struct chunk *chunk = &build->work.chunks[number];
    const uint32_t first = number * CHUNK_SIZE;
    const uint32_t last = first + mlrt_item_size(build->tree->triangle_count, CHUNK_SIZE, number);
    const float unit = build->tree->bvh.unit;
    struct mlrt_quad_box *references = build->references.boxes + first;
    struct mlrt_bvh_set set = empty_set(first);
    (void)worker;
    *chunk = (struct chunk){.non_finite_count = 0};
    for (uint32_t i = first; i < last; i++) {
        const struct mlrt_triangle *triangle = &build->tree->triangles[i];
        if (!mlrt_keep_triangle(triangle, &chunk->non_finite_count, &chunk->zero_area_count)) continue;
        const struct mlrt_quad_box reference = reference_of(triangle, i);
        references[set.count] = reference;
        add_reference(&reference, &set);
    }
    chunk->set = set;
    memcpy(chunk->bounds.lo, set.box.lo.x, sizeof chunk->bounds.lo);
    memcpy(chunk->bounds.hi, set.box.hi.x, sizeof chunk->bounds.hi);
    if (unit == 1 && mlrt_is_within(chunk->bounds.lo, chunk->bounds.hi, MLRT_BVH_FAR)) return CHUNK_SIZE * FIRST_WORK;
    for (uint32_t i = 0; i < set.count; i++) scale_reference(unit, &references[i]);
    chunk->set = mlrt_measure_set(build->references.boxes, first, set.count, build->progress);
    return CHUNK_SIZE * FIRST_WORK;
}

/* Makes the references of all triangles, without gaps. Sets their whole set, the bounds, and the counts of triangles left out. */
static int32_t make_references(struct build *build)
{
    struct mlrt_box bounds = MLRT_NO_BOX;
    struct mlrt_bvh_set whole = empty_set(0);
    mlrt_tree_info *info = &build->tree->info;
    info->non_finite_count = info->zero_area_count = 0;
    if (run_step(build, build->limits.chunk_count, make_chunk_references) != MLRT_OK) return MLRT_ERROR_CANCELLED;
    for (uint32_t i = 0; i < build->limits.chunk_count; i++) {
        const struct chunk *chunk = &build->work.chunks[i];
        if (whole.count != i * CHUNK_SIZE)
            memmove(&build->references.boxes[whole.count], &build->references.boxes[i * CHUNK_SIZE],
                    chunk->set.count * sizeof *build->references.boxes);
        whole.count += chunk->set.count;
        mlrt_extend_box(chunk->bounds.lo, chunk->bounds.hi, &bounds);
        grow(&whole.box, chunk->set.box.lo.v, chunk->set.box.hi.v);
        grow(&whole.centres, chunk->set.centres.lo.v, chunk->set.centres.hi.v);
        info->non_finite_count += chunk->non_finite_count;
        info->zero_area_count += chunk->zero_area_count;
    }
    build->references.whole = whole;
    if (whole.count > 0) build->tree->bounds = bounds;
    mlrt_set_bvh_extent(build->tree);
    return MLRT_OK;
}

/* ---- budgets ------------------------------------------------------------------------------------------------- */

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
static int may_split(const struct portion *portion, uint32_t lower, uint32_t upper)
{
    uint32_t larger = lower > upper ? lower : upper;
    return reserve(lower) + reserve(upper) <= portion->budget &&
           portion->depth + 1 + halving_depth(larger) <= MLRT_BVH_DEPTH_LIMIT;
}

/*
 * Shares out the budget and the spare places of a portion to its sides: first the reserve of each, then the rest by
 * size. Sets too small for spatial splits get no spare places: they need none, and the references of a set that may
 * become one leaf must have no gap.
 */
static void share_out(const struct build *build, const struct portion *portion, const struct mlrt_bvh_set sets[2],
                      struct portion sides[2])
{
    const uint64_t count = (uint64_t)sets[0].count + sets[1].count;
    const uint32_t rest = portion->budget - reserve(sets[0].count) - reserve(sets[1].count);
    const int is_last = portion->set.count <= build->preset->spatial_size;
    const uint32_t spare = is_last ? 0 : (uint32_t)(portion->set.count + portion->spare - count);
    const uint32_t depth = portion->depth + 1, failed_count = portion->failed_count;
    const uint32_t lower_budget = reserve(sets[0].count) + scale(rest, sets[0].count, count);
    const uint32_t lower_spare = scale(spare, sets[0].count, count), upper = portion->node + 2 * lower_budget;
    sides[0] = (struct portion){sets[0], lower_spare, portion->node + 1, depth, lower_budget, failed_count};
    sides[1] =
        (struct portion){sets[1], spare - lower_spare, upper, depth, portion->budget - lower_budget, failed_count};
}

/* ---- looking for a split --------------------------------------------------------------------------------------- */

/* Adds `count` of a set's references, from `first` on, to its bins. */
static void fill_part(const struct build *build, const struct mlrt_bvh_set *set, uint32_t first, uint32_t count,
                      struct mlrt_bvh_bins *bins)
{
    if (bins->kind == MLRT_SPLIT_BY_PLANE)
        mlrt_fill_slabs(build->tree->triangles, build->tree->bvh.unit, build->references.boxes, first, count, &set->box,
                        build->progress, bins);
    else
        mlrt_fill_bins(build->references.boxes, first, count, &set->centres, build->progress, bins);
}

static double fill_share(struct build *build, uint32_t chunk, uint32_t worker)
{
    const struct mlrt_bvh_set *set = &build->shared.portion->set;
    fill_part(build, set, set->first + chunk * CHUNK_SIZE, mlrt_item_size(set->count, CHUNK_SIZE, chunk),
              &build->work.shares[worker]);
    return 0;
}

/* Fills bins with the references of a portion. If the call is cancelled, not with all. */
static void fill(struct build *build, const struct portion *portion, enum mlrt_split_kind kind,
                 struct mlrt_bvh_bins *all)
{
    const uint32_t count = portion->set.count;
    mlrt_clear_bins(kind, count, all);
    if (build->shared.portion != portion) {
        fill_part(build, &portion->set, portion->set.first, count, all);
        return;
    }
    const uint32_t worker_count = mlrt_worker_count(build->pool);
    for (uint32_t i = 0; i < worker_count; i++) build->work.shares[i] = *all;
    run_step(build, mlrt_item_count(count, CHUNK_SIZE), fill_share);
    for (uint32_t i = 0; i < worker_count; i++) mlrt_merge_bins(&build->work.shares[i], all);
}

/* Sets *split to the cheapest of its kind within the portion's limits. Not inlined, for the stack of a recursion. */
static MLRT_NOINLINE void find_split(struct build *build, const struct portion *portion, enum mlrt_split_kind kind,
                                     struct mlrt_bvh_split *split)
{
    struct mlrt_bvh_bins bins;
    if (kind != MLRT_SPLIT_BY_RANK) fill(build, portion, kind, &bins);
    if (kind == MLRT_SPLIT_BY_RANK)
        mlrt_sweep_set(&build->costs, build->references.boxes, &portion->set, split);
    else if (kind == MLRT_SPLIT_BY_BIN)
        mlrt_choose_split(&build->costs, &bins, &portion->set, split);
    else
        mlrt_choose_plane(&build->costs, &bins, portion->set.count, portion->spare, split);
    if (split->cost < HUGE_VAL && !may_split(portion, split->count[0], split->count[1])) split->cost = HUGE_VAL;
}

/* 1 if the sides of the best split by centres overlap so much that a spatial split is tried, as Stich et al. do. */
static int overlaps(const struct build *build, const struct mlrt_bvh_split *split)
{
    struct mlrt_quad_box common;
    for (int k = 0; k < 3; k++) {
        const struct mlrt_quad_box *a = &split->box[0], *b = &split->box[1];
        common.lo.x[k] = a->lo.x[k] > b->lo.x[k] ? a->lo.x[k] : b->lo.x[k];
        common.hi.x[k] = a->hi.x[k] < b->hi.x[k] ? a->hi.x[k] : b->hi.x[k];
        if (common.lo.x[k] > common.hi.x[k]) return 0;
    }
    return area_of(&common) > build->preset->overlap_limit * build->scene_area;
}

static void choose(struct build *build, struct portion *portion, struct mlrt_bvh_split *split)
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

/* 1 if the split costs less than a leaf, or a leaf would have too many triangles. Another child of a node counts as a sixteenth of a node. */
static int split_pays(const struct build *build, const struct mlrt_bvh_set *set, const struct mlrt_bvh_split *split)
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
static void move_set(const struct build *build, struct mlrt_bvh_set *set, uint32_t first)
{
    const uint32_t distance = first > set->first ? first - set->first : set->first - first;
    const uint32_t count = distance < set->count ? distance : set->count;
    const uint32_t from = first > set->first ? set->first : set->first + set->count - count;
    const uint32_t to = first > set->first ? first + set->count - count : first;
    for (uint32_t i = 0; i < count && !mlrt_is_cancelled_in_round(build->progress, i + CHUNK_SIZE); i += CHUNK_SIZE)
        memcpy(build->references.boxes + to + i, build->references.boxes + from + i,
               (count - i < CHUNK_SIZE ? count - i : CHUNK_SIZE) * sizeof *build->references.boxes);
    set->first = first;
}

/* Halves a set of which a spatial split left one side empty. */
static void halve(struct build *build, struct mlrt_bvh_set sets[2])
{
    static const struct mlrt_bvh_split NO_SPLIT = {.cost = HUGE_VAL};
    struct mlrt_bvh_set whole = sets[0].count > 0 ? sets[0] : sets[1];
    mlrt_apply_bvh_split(build->references.boxes, &whole, &NO_SPLIT, build->progress, sets);
}

/* Deals the references of a portion out to its sides. Returns 0 if the call is cancelled. */
static int apply(struct build *build, const struct portion *portion, const struct mlrt_bvh_split *split,
                 struct portion sides[2])
{
    struct mlrt_bvh_set sets[2];
    if (split->kind == MLRT_SPLIT_BY_PLANE)
        mlrt_apply_spatial_split(build->tree->triangles, build->tree->bvh.unit, build->references.boxes, &portion->set,
                                 split, build->progress, sets);
    else
        mlrt_apply_bvh_split(build->references.boxes, &portion->set, split, build->progress, sets);
    if (mlrt_is_cancelled(build->progress)) return 0;
    if (sets[0].count == 0 || sets[1].count == 0) halve(build, sets);
    share_out(build, portion, sets, sides);
    move_set(build, &sides[0].set, portion->set.first);
    move_set(build, &sides[1].set, portion->set.first + sides[0].set.count + sides[0].spare);
    return 1;
}

/* Sets the binary node of a portion, without children. Returns it. */
static struct mlrt_binary_node *start_node(const struct build *build, const struct portion *portion)
{
    struct mlrt_binary_node *node = &build->binary.nodes[portion->node];
    memcpy(node->lo, portion->set.box.lo.x, sizeof node->lo);
    memcpy(node->hi, portion->set.box.hi.x, sizeof node->hi);
    node->first = portion->set.first;
    node->count = portion->set.count;
    node->upper = 0;
    return node;
}

/* Cuts a portion in two and returns 1. Returns 0 if the portion becomes a leaf, or the call is cancelled. */
static int cut(struct build *build, struct portion *portion, struct portion sides[2])
{
    struct mlrt_bvh_split split;
    int is_small = portion->set.count <= MLRT_BVH_LEAF_LIMIT;
    if (is_small && (portion->budget < 2 || portion->set.count < 2)) return 0;
    if (mlrt_advance(build->progress, build->limits.cut_work * portion->set.count)) return 0;
    choose(build, portion, &split);
    /* If cancelled, bins may be unfinished, and a plane chosen from them may cut more references than fit. */
    if (split.kind == MLRT_SPLIT_BY_PLANE && mlrt_is_cancelled(build->progress)) return 0;
    if (is_small && (split.cost == HUGE_VAL || !split_pays(build, &portion->set, &split))) return 0;
    return apply(build, portion, &split, sides);
}

/* ---- binary hierarchy ---------------------------------------------------------------------------------------- */

/* Builds a subtree, with its binary nodes one behind the other. Returns the number behind the last of them. */
static uint32_t build_subtree(struct build *build, struct portion *portion, struct mlrt_forest_costs *costs)
{
    struct mlrt_binary_node *node = start_node(build, portion);
    struct portion sides[2];
    struct mlrt_forest_costs side_costs[2];
    float area = relative_area(build, node->lo, node->hi);
    if (!cut(build, portion, sides)) {
        mlrt_choose_leaf(&build->costs, area, node, costs);
        for (uint32_t i = node->first; i < node->first + node->count; i++)
            build->binary.words[i] = mlrt_reference_word(&build->references.boxes[i]);
        return portion->node + 1;
    }
    sides[1].node = node->upper = build_subtree(build, &sides[0], &side_costs[0]);
    const uint32_t end = build_subtree(build, &sides[1], &side_costs[1]);
    mlrt_choose_cut(&build->costs, area, side_costs, node, costs);
    return end;
}

static double build_task(struct build *build, uint32_t item, uint32_t worker)
{
    (void)worker;
    build_subtree(build, build->work.tasks[item], &build->work.forests[item].costs);
    return 0;
}

static double cut_item(struct build *build, uint32_t item, uint32_t worker)
{
    struct portion *portion = build->work.level[item];
    struct portion *sides = &build->work.portions[build->work.portion_count + 2 * item];
    (void)worker;
    if (build->shared.portion == NULL && portion->set.count >= build->shared.least_size) return 0;
    struct mlrt_binary_node *node = start_node(build, portion);
    if (cut(build, portion, sides)) node->upper = sides[1].node;
    return 0;
}

/*
 * Cuts the sets of a level: first those that have much of it, with bins that all workers fill, then each by one worker.
 */
static void cut_level(struct build *build, uint32_t count)
{
    const uint64_t worker_count = mlrt_worker_count(build->pool);
    uint64_t sum = 0;
    for (uint32_t i = 0; i < count; i++) sum += build->work.level[i]->set.count;
    const uint64_t much = 3 * sum / (2 * worker_count), least = 2 * CHUNK_SIZE + 1;
    build->shared.least_size = much > least ? much : least; /* more than `sum` for one worker */
    for (uint32_t i = 0; i < count; i++) {
        build->shared.portion = build->work.level[i];
        if (build->work.level[i]->set.count >= build->shared.least_size) cut_item(build, i, 0);
    }
    build->shared.portion = NULL;
    run_step(build, count, cut_item);
    build->work.portion_count += 2 * count;
}

/* Adds a task to those in depth-first order, which is that of the numbers of their nodes. */
static void add_task(struct build *build, struct portion *portion)
{
    uint32_t i = build->work.task_count++;
    for (; i > 0 && build->work.tasks[i - 1]->node > portion->node; i--)
        build->work.tasks[i] = build->work.tasks[i - 1];
    build->work.tasks[i] = portion;
}

/* Adds a set to the first `count` of a level: the largest comes first, so that no worker begins it when others end. */
static void add_to_level(struct build *build, struct portion *portion, uint32_t count)
{
    uint32_t i = count;
    for (; i > 0 && build->work.level[i - 1]->set.count < portion->set.count; i--)
        build->work.level[i] = build->work.level[i - 1];
    build->work.level[i] = portion;
}

/* Cuts portions[0], level by level, until the parts are small enough for tasks. */
static void find_tasks(struct build *build)
{
    build->work.portion_count = 1;
    for (uint32_t i = 0; i < build->work.portion_count && !mlrt_is_cancelled(build->progress);) {
        uint32_t count = 0;
        for (; i < build->work.portion_count; i++) {
            struct portion *portion = &build->work.portions[i];
            if (portion->set.count <= build->limits.task_size)
                add_task(build, portion);
            else
                add_to_level(build, portion, count++);
        }
        cut_level(build, count);
    }
    for (uint32_t i = 0; i <= build->work.task_count; i++)
        build->work.forests[i] =
            (struct mlrt_forest){.node = i < build->work.task_count ? build->work.tasks[i]->node : UINT32_MAX};
}

/* Sets the choices of the nodes above the tasks, all of which have set theirs. `next` is the first task of the rest. */
static void choose_upper(const struct build *build, uint32_t number, const struct mlrt_forest **next,
                         struct mlrt_forest_costs *costs)
{
    if ((*next)->node == number) {
        *costs = (*next)++->costs;
        return;
    }
    struct mlrt_binary_node *node = &build->binary.nodes[number];
    struct mlrt_forest_costs side_costs[2];
    choose_upper(build, number + 1, next, &side_costs[0]);
    choose_upper(build, node->upper, next, &side_costs[1]);
    mlrt_choose_cut(&build->costs, relative_area(build, node->lo, node->hi), side_costs, node, costs);
}

/* ---- nodes of sixteen ---------------------------------------------------------------------------------------- */

/* Writes the nodes of sixteen above the tasks from the cursor on, or only moves the cursor. Returns where it is then. */
static struct mlrt_bvh_cursor write_upper(struct build *build, struct mlrt_bvh_cursor cursor)
{
    mlrt_write_forest(&build->binary, 0, 1, build->tree, build->progress, build->work.forests, &cursor);
    return cursor;
}

static double measure_task(struct build *build, uint32_t item, uint32_t worker)
{
    struct mlrt_forest *forest = &build->work.forests[item];
    struct mlrt_bvh_cursor cursor = {.size = {.depth = forest->from.depth}, .depth = forest->from.depth};
    (void)worker;
    mlrt_write_forest(&build->binary, forest->node, forest->slots, build->tree, build->progress, NULL, &cursor);
    forest->size = cursor.size;
    return 0;
}

static struct mlrt_bvh_size measure_all(struct build *build)
{
    const struct mlrt_bvh_cursor start = {.depth = 0};
    struct mlrt_bvh_size size = write_upper(build, start).size;
    run_step(build, build->work.task_count, measure_task);
    for (uint32_t i = 0; i < build->work.task_count; i++) mlrt_add_size(&build->work.forests[i].size, &size);
    if (build->binary.nodes[0].choice[1] == 0) size.node_count = size.depth = 1;
    return size;
}

static double write_task(struct build *build, uint32_t item, uint32_t worker)
{
    struct mlrt_forest *forest = &build->work.forests[item];
    (void)worker;
    mlrt_write_forest(&build->binary, forest->node, forest->slots, build->tree, build->progress, NULL, &forest->from);
    return LAST_WORK * build->work.tasks[item]->set.count;
}

/*
 * Writes the whole hierarchy. Its root is always a node. If the binary root becomes a leaf, that is the root's only
 * child; else the root is written as the only child of a node `above`, which is dropped.
 */
static int32_t write_all(struct build *build)
{
    struct mlrt_bvh_node above;
    const int is_leaf = build->binary.nodes[0].choice[1] == 0;
    const struct mlrt_bvh_cursor start = {.size = {.node_count = (uint32_t)is_leaf},
                                          .parent = is_leaf ? build->tree->bvh.nodes : &above};
    mlrt_clear_node(start.parent);
    write_upper(build, start);
    return run_step(build, build->work.task_count, write_task);
}

/* ---- memory -------------------------------------------------------------------------------------------------- */

/* Returns the place of `count` elements, *end bytes behind `memory`, and moves *end behind them. With NULL, NULL. */
static void *take(unsigned char *memory, size_t count, size_t size, uint64_t *end)
{
    void *taken = memory ? memory + *end : NULL;
    *end += ((uint64_t)count * size + 63) / 64 * 64;
    return taken;
}

/* Lays out all arrays of a build except its references. Returns their size. With NULL, sets no array. */
static uint64_t lay_out_work(struct build *build, unsigned char *memory)
{
    const uint32_t worker_count = mlrt_worker_count(build->pool);
    uint64_t size = 0;
    build->work.chunks = take(memory, build->limits.chunk_count, sizeof *build->work.chunks, &size);
    build->binary.nodes = take(memory, 2 * (size_t)build->limits.leaf_limit - 1, sizeof *build->binary.nodes, &size);
    build->binary.words =
        take(memory, (size_t)build->limits.capacity + MLRT_WORDS_AHEAD, sizeof *build->binary.words, &size);
    build->work.tasks = take(memory, build->limits.task_capacity, sizeof *build->work.tasks, &size);
    build->work.forests = take(memory, (size_t)build->limits.task_capacity + 1, sizeof *build->work.forests, &size);
    build->work.level = take(memory, build->limits.level_capacity, sizeof *build->work.level, &size);
    build->work.portions = take(memory, 2 * (size_t)build->limits.task_capacity, sizeof *build->work.portions, &size);
    build->work.parts = take(memory, MLRT_BVH_PART_LIMIT, sizeof *build->work.parts, &size);
    build->work.shares = take(memory, worker_count > 1 ? worker_count : 0, sizeof *build->work.shares, &size);
    return size;
}

static int allocate_work(struct build *build)
{
    struct mlrt_memory *memory = &build->tree->memory;
    build->work.size = lay_out_work(build, NULL);
    if (build->work.size > SIZE_MAX) return 0;
    build->references.boxes = mlrt_allocate(memory, build->limits.capacity, REFERENCE_ROOM);
    build->work.block = build->references.boxes ? mlrt_allocate(memory, (size_t)build->work.size, 1) : NULL;
    if (build->work.block) lay_out_work(build, build->work.block);
    return build->work.block != NULL;
}

static void release_references(struct build *build)
{
    mlrt_free(&build->tree->memory, build->references.boxes, build->limits.capacity, REFERENCE_ROOM);
    build->references.boxes = NULL;
}

void mlrt_free_bvh(struct mlrt_tree *tree)
{
    static const struct mlrt_bvh NONE;
    struct mlrt_bvh *bvh = &tree->bvh;
    mlrt_free(&tree->memory, bvh->nodes, bvh->node_count, sizeof *bvh->nodes);
    mlrt_free(&tree->memory, bvh->corners, 36 * (size_t)bvh->quad_count + 16, sizeof *bvh->corners);
    mlrt_free(&tree->memory, bvh->numbers, 4 * (size_t)bvh->quad_count + 16, sizeof *bvh->numbers);
    mlrt_free(&tree->memory, bvh->places, tree->triangle_count, sizeof *bvh->places);
    *bvh = NONE;
}

/* Marks the places of a chunk of triangles as those of triangles in no leaf. Leaves write the places of theirs. */
static double clear_places(struct build *build, uint32_t chunk, uint32_t worker)
{
    const uint32_t count = mlrt_item_size(build->tree->triangle_count, CHUNK_SIZE, chunk);
    uint32_t *places = build->tree->bvh.places + (size_t)chunk * CHUNK_SIZE;
    (void)worker;
    memset(places, 0xFF, count * sizeof *places);
    return 0;
}

static int32_t allocate_result(struct build *build, const struct mlrt_bvh_size *size)
{
    struct mlrt_tree *tree = build->tree;
    struct mlrt_bvh *bvh = &tree->bvh;
    if (size->node_count > COUNT_LIMIT || size->quad_count > COUNT_LIMIT) {
        return mlrt_fail(MLRT_ERROR_TOO_LARGE, "meshes: the tree would have more than %lu nodes, or quads of triangles",
                         (unsigned long)COUNT_LIMIT);
    }
    const uint64_t quad_count = size->quad_count + mlrt_count_given_quads(tree);
    const int has_places = tree->triangle_count > 0 && quad_count < MLRT_PLACE_QUADS;
    bvh->node_count = (uint32_t)size->node_count;
    bvh->leaf_quad_count = (uint32_t)size->quad_count;
    bvh->quad_count = has_places ? (uint32_t)quad_count : bvh->leaf_quad_count;
    if (bvh->quad_count == 0) return MLRT_OK;
    bvh->corners = mlrt_reuse(&tree->memory, build->references.boxes, build->limits.capacity * (size_t)REFERENCE_ROOM,
                              (36 * (size_t)bvh->quad_count + 16) * sizeof *bvh->corners);
    build->references.boxes = NULL;
    if (has_places) bvh->places = mlrt_allocate(&tree->memory, tree->triangle_count, sizeof *bvh->places);
    bvh->nodes = mlrt_allocate(&tree->memory, bvh->node_count, sizeof *bvh->nodes);
    bvh->numbers = mlrt_allocate(&tree->memory, 4 * (size_t)bvh->quad_count + 16, sizeof *bvh->numbers);
    if (bvh->corners == NULL || bvh->numbers == NULL || bvh->nodes == NULL || (has_places && bvh->places == NULL))
        return MLRT_ERROR_OUT_OF_MEMORY;
    if (bvh->quad_count > bvh->leaf_quad_count) run_step(build, build->limits.chunk_count, clear_places);
    memset(bvh->corners + 36 * (size_t)bvh->quad_count, 0, 16 * sizeof *bvh->corners);
    memset(bvh->numbers + 4 * (size_t)bvh->quad_count, 0, 16 * sizeof *bvh->numbers);
    return MLRT_OK;
}

/* ---- the whole hierarchy ------------------------------------------------------------------------------------- */

/* Builds the binary hierarchy, and sets *size to that of the result. Returns a status. */
static int32_t build_binary(struct build *build, struct mlrt_bvh_size *size)
{
    struct portion *root = &build->work.portions[0];
    root->set = build->references.whole;
    root->spare = build->limits.capacity - build->references.whole.count;
    root->node = root->depth = root->failed_count = 0;
    root->budget = build->limits.leaf_limit;
    struct mlrt_forest_costs costs;
    const struct mlrt_forest *next = build->work.forests;
    build->scene_area = area_between(build->tree->bvh.core.lo, build->tree->bvh.core.hi);
    build->work.task_count = 0;
    find_tasks(build);
    if (!mlrt_is_cancelled(build->progress)) run_step(build, build->work.task_count, build_task);
    if (mlrt_is_cancelled(build->progress)) return MLRT_ERROR_CANCELLED;
    choose_upper(build, 0, &next, &costs);
    *size = measure_all(build);
    return mlrt_is_cancelled(build->progress) ? MLRT_ERROR_CANCELLED : MLRT_OK;
}

static double measure_part(struct build *build, uint32_t number, uint32_t worker)
{
    (void)worker;
    mlrt_measure_part(build->tree, &build->costs, number, build->progress, &build->work.parts[number]);
    return 0;
}

static int32_t measure(struct build *build)
{
    run_step(build, mlrt_count_parts(&build->tree->bvh), measure_part);
    mlrt_join_parts(build->work.parts, &build->costs, build->tree);
    return mlrt_is_cancelled(build->progress) ? MLRT_ERROR_CANCELLED : MLRT_OK;
}

static int32_t build_hierarchy(struct build *build)
{
    struct mlrt_tree *tree = build->tree;
    struct mlrt_bvh_size size = {.depth = 0};
    if (!allocate_work(build)) return MLRT_ERROR_OUT_OF_MEMORY;
    mlrt_set_bvh_unit(tree);
    int32_t status = make_references(build);
    if (status == MLRT_OK && build->references.whole.count > 0) status = build_binary(build, &size);
    if (status == MLRT_OK) status = allocate_result(build, &size);
    if (status == MLRT_OK && build->references.whole.count > 0) status = write_all(build);
    if (status != MLRT_OK) return status;
    mlrt_write_given(tree);
    tree->info.depth = size.depth;
    return measure(build);
}

/* Sets all settings and capacities that follow from the options and the number of triangles. */
static void set_limits(const mlrt_tree_options *options, uint32_t triangle_count, struct build *build)
{
    build->pool = options->pool;
    build->preset = &PRESETS[options->preset];
    build->costs = COSTS;
    if (options->traversal_cost > 0) build->costs.node = options->traversal_cost;
    if (options->intersection_cost > 0) build->costs.triangle = options->intersection_cost;
    build->limits.capacity = triangle_count + (uint32_t)((float)triangle_count * build->preset->spare_share);
    build->limits.leaf_limit = build->limits.capacity / LEAF_SHARE + 1;
    build->limits.task_size =
        build->limits.capacity / TASK_SHARE > TASK_SIZE ? build->limits.capacity / TASK_SHARE : TASK_SIZE;
    /* A level has at most capacity / task_size sets larger than tasks, and cutting n of these leaves n + 1 tasks. */
    build->limits.level_capacity = build->limits.capacity / build->limits.task_size + 1;
    build->limits.task_capacity = MLRT_BVH_DEPTH_LIMIT * (build->limits.capacity / build->limits.task_size) + 1;
    build->limits.chunk_count = mlrt_item_count(triangle_count, CHUNK_SIZE);
    const double levels = log2((double)triangle_count / MLRT_BVH_LEAF_LIMIT + 2);
    build->limits.cut_work = (MLRT_BVH_WORK - FIRST_WORK - LAST_WORK) / levels;
}

static const struct build NOTHING_BUILT;

int32_t mlrt_build_bvh(struct mlrt_tree *tree, const mlrt_tree_options *options, struct mlrt_progress *progress)
{
    struct build build = NOTHING_BUILT;
    if (tree->triangle_count >= MLRT_REFERENCE_MARK) return MLRT_ERROR_TOO_LARGE;
    build.tree = tree;
    build.progress = progress;
    set_limits(options, tree->triangle_count, &build);
    int32_t status = build_hierarchy(&build);
    release_references(&build);
    mlrt_free(&tree->memory, build.work.block, (size_t)build.work.size, 1);
    if (status != MLRT_OK) mlrt_free_bvh(tree);
    return status;
}

/* ---- expected memory ----------------------------------------------------------------------------------------- */

/*
 * Bytes of nodes, quads and places per triangle, with a margin. Scenes take: DEFAULT 51 to 60, FAST 50 to 56, BEST 52
 * to 69.
 */
static const double RESULT_SIZES[] = {62, 57, 70};

struct mlrt_demand mlrt_foresee_bvh(const void *tree_options, uint32_t triangle_count)
{
    const mlrt_tree_options *options = tree_options;
    struct build build = NOTHING_BUILT;
    set_limits(options, triangle_count, &build);
    const uint64_t references = (uint64_t)build.limits.capacity * REFERENCE_ROOM;
    const uint64_t work = lay_out_work(&build, NULL);
    const uint64_t result = (uint64_t)(RESULT_SIZES[options->preset] * triangle_count) + sizeof(struct mlrt_bvh_node) +
                            2 * 52 * sizeof(float);
    const uint64_t triangles = (uint64_t)triangle_count * sizeof(struct mlrt_triangle);
    return (struct mlrt_demand){result, triangles + work + (references > result ? references : result)};
}
