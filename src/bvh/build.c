/* SPDX-License-Identifier: MIT */
/*
 * The builder of the hierarchy of boxes. references.c makes a box for each triangle. binary.c cuts sets of these
 * references in two, again and again: the result is a binary hierarchy. cut.c cuts a set, within its limits, where
 * split.c or spatial_split.c say. collapse.c chooses which of its nodes become nodes of sixteen, and write.c writes
 * these in depth-first order. Here are the settings of a build, its memory, its steps, and its report.
 *
 * The result does not depend on the number of threads: a set is split according to its references and its shares of
 * depth, leaves and spare places alone, every part has its place in the arrays before it is built, and the bins of
 * several workers are merged by minima, maxima and sums of integers.
 */
#include "bvh/build.h"

#include <math.h>
#include <string.h>

#include "base/hash.h"
#include "base/platform.h"
#include "base/tuning.h"
#include "bvh/unit.h"

/* ---- settings ------------------------------------------------------------------------------------------------ */

/*
 * With overlap limits of 1e-5, 1e-4, 1e-3, a packet of 4x4 visits 6.08, 6.08, 6.45 nodes in clinic (a building), and
 * the times to build dragon (a scan) are as 3 : 2 : 1.6. With 0.1, 0.15, 0.2 spare places per triangle, the expected
 * cost of clinic is 18.8, 18.1, 17.8 and that of sponza 12.8, 12.7, 12.6; clinic takes 89.6, 91.6, 93.3 bytes per
 * triangle. With failure limits of 1, 2, 3 and none, dragon takes 0.61, 0.68, 0.76 and 1.34 s, clinic 1.51, 1.65, 1.87
 * and 1.86 s. The expected costs differ by 0.3 % (2), and by 0.7 % in sponza (1).
 */
static const struct mlrt_bvh_preset PRESETS[] = {
    {MLRT_SPARE_SHARE, MLRT_OVERLAP_LIMIT, MLRT_SPATIAL_SIZE, 2}, /* MLRT_TREE_DEFAULT */
    {0.0f, 1.0f, 32, 0},                                          /* MLRT_TREE_FAST */
    {0.5f, 1e-6f, 16, UINT32_MAX},                                /* MLRT_TREE_BEST */
};

/*
 * A leaf costs about as much as a node, however many triangles it has, since both are tested sixteen wide. A packet of
 * 4x4 on its own visits 6.08 nodes and leaves (geometric mean of seven scenes). With leaf costs of 0.7 and 1.5 it
 * visits 6.11 and 6.12; with smaller leaves, by a cost of each quad or 0.08 for each triangle, 6.25 to 6.42.
 * docs/performance.md, "How large leaves are", has the speed with other costs.
 */
static const struct mlrt_bvh_costs COSTS = {1, MLRT_TRIANGLE_COST};

/* References per leaf, on average, that the budget allows for: so building takes 104 / 4 bytes of nodes for each. */
#define LEAF_SHARE (MLRT_LEAF_TRIANGLES / 4)

/* One worker builds each subtree of at most so many references, or of at most this part of all references. */
#define TASK_SIZE  4096
#define TASK_SHARE 64

/* ---- steps --------------------------------------------------------------------------------------------------- */

/* A step of the build, for the workers of the pool. */
struct work {
    struct mlrt_bvh_build *build;
    mlrt_bvh_step *step;
};

static int32_t run_item(void *work, uint32_t item, uint32_t worker)
{
    const struct work *own = work;
    MLRT_COMPUTE(own->step(own->build, item, worker));
    return mlrt_is_cancelled(own->build->progress);
}

int32_t mlrt_run_step(struct mlrt_bvh_build *build, uint32_t count, mlrt_bvh_step *step)
{
    struct work work = {build, step};
    return mlrt_run_items(build->pool, count, run_item, &work) ? MLRT_ERROR_CANCELLED : MLRT_OK;
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
static uint64_t lay_out_work(struct mlrt_bvh_build *build, unsigned char *memory)
{
    const uint32_t worker_count = mlrt_worker_count(build->pool);
    uint64_t size = 0;
    build->references.chunks = take(memory, build->limits.chunk_count, sizeof *build->references.chunks, &size);
    build->binary.nodes = take(memory, 2 * (size_t)build->limits.leaf_limit - 1, sizeof *build->binary.nodes, &size);
    build->binary.words =
        take(memory, (size_t)build->limits.capacity + MLRT_WORDS_AHEAD, sizeof *build->binary.words, &size);
    build->work.tasks = take(memory, build->limits.task_capacity, sizeof *build->work.tasks, &size);
    build->work.subtrees = take(memory, (size_t)build->limits.task_capacity + 1, sizeof *build->work.subtrees, &size);
    build->work.level = take(memory, build->limits.level_capacity, sizeof *build->work.level, &size);
    build->work.portions = take(memory, 2 * (size_t)build->limits.task_capacity, sizeof *build->work.portions, &size);
    build->work.shares = take(memory, worker_count > 1 ? worker_count : 0, sizeof *build->work.shares, &size);
    return size;
}

static int allocate_work(struct mlrt_bvh_build *build)
{
    struct mlrt_memory *memory = &build->tree->memory;
    build->block.size = lay_out_work(build, NULL);
    if (build->block.size > SIZE_MAX) return 0;
    build->references.boxes = mlrt_allocate(memory, build->limits.capacity, MLRT_REFERENCE_ROOM);
    build->block.start = build->references.boxes ? mlrt_allocate(memory, (size_t)build->block.size, 1) : NULL;
    if (build->block.start) lay_out_work(build, build->block.start);
    return build->block.start != NULL;
}

static void free_work(struct mlrt_bvh_build *build)
{
    mlrt_free(&build->tree->memory, build->references.boxes, build->limits.capacity, MLRT_REFERENCE_ROOM);
    mlrt_free(&build->tree->memory, build->block.start, (size_t)build->block.size, 1);
}

/* ---- the report ---------------------------------------------------------------------------------------------- */

/*
 * A finished hierarchy is measured in parts, each a share of the nodes and of the numbers in leaves. How many they are
 * does not depend on threads, so sums of doubles do not, either.
 */
struct mlrt_bvh_part {
    double cost; /* sum of cost times area of the children of its nodes */
    uint64_t leaf_count;
    uint64_t reference_count;
    uint64_t hash; /* of boxes, children and numbers. Corners follow from the numbers */
};

/* The most parts, and the fewest nodes that are worth another one. */
#define PART_LIMIT 64
#define PART_NODES 64

/* Nodes, and words of numbers, between two calls of mlrt_is_cancelled. */
#define NODE_ROUNDS 1024
#define WORD_ROUNDS 65536

static uint32_t count_parts(const struct mlrt_bvh *bvh)
{
    const uint32_t count = bvh->node_count / PART_NODES + 1;
    return count < PART_LIMIT ? count : PART_LIMIT;
}

/* Where one of `parts` begins, of a hierarchy that has `count` of something. */
static size_t part_start(size_t count, uint32_t parts, uint32_t number)
{
    return count / parts * number + count % parts * number / parts;
}

/* Half the surface area of a box in units, whose bounds along the axes are `row` floats apart. */
static double half_area(const float *lo, const float *hi, int row)
{
    struct mlrt_quad_box box;
    for (int k = 0; k < 3; k++) {
        box.lo.x[k] = mlrt_finite_bound(lo[k * row]);
        box.hi.x[k] = mlrt_finite_bound(hi[k * row]);
    }
    return area_of(&box);
}

static void measure_node(const struct mlrt_bvh_build *build, const struct mlrt_bvh_node *node,
                         struct mlrt_bvh_part *part)
{
    for (int i = 0; i < MLRT_BVH_WIDTH && node->child[i] != 0; i++) {
        const double area = half_area(&node->lo[0][i], &node->hi[0][i], MLRT_BVH_WIDTH);
        if (mlrt_bvh_quad_count(node->child[i]) != 0) {
            const uint32_t count = mlrt_bvh_leaf_count(&build->tree->bvh, node->child[i]);
            part->cost += area * set_cost(&build->costs, count);
            part->leaf_count++;
            part->reference_count += count;
        } else {
            part->cost += area * build->costs.node;
        }
    }
}

static void measure_part(struct mlrt_bvh_build *build, uint32_t number, uint32_t worker)
{
    const struct mlrt_bvh *bvh = &build->tree->bvh;
    struct mlrt_bvh_part *part = &build->parts[number];
    const size_t word_count = 4 * (size_t)bvh->leaf_quad_count;
    const uint32_t parts = count_parts(bvh);
    const size_t last_node = part_start(bvh->node_count, parts, number + 1);
    const size_t last_word = part_start(word_count, parts, number + 1);
    struct mlrt_hash hash;
    (void)worker;
    mlrt_start_hash(&hash);
    for (size_t i = part_start(bvh->node_count, parts, number); i < last_node; i++) {
        if (i % NODE_ROUNDS == 0 && mlrt_is_cancelled(build->progress)) return;
        mlrt_add_words(&hash, &bvh->nodes[i], sizeof bvh->nodes[i] / 4);
        measure_node(build, &bvh->nodes[i], part);
    }
    for (size_t i = part_start(word_count, parts, number); i < last_word && !mlrt_is_cancelled(build->progress);
         i += WORD_ROUNDS)
        mlrt_add_words(&hash, bvh->numbers + i, last_word - i < WORD_ROUNDS ? last_word - i : WORD_ROUNDS);
    part->hash = mlrt_finish_hash(&hash);
}

/* Sets the members of tree->info that follow from the hierarchy, except depth. Returns a status. */
static int32_t measure(struct mlrt_bvh_build *build)
{
    const struct mlrt_tree *tree = build->tree;
    mlrt_tree_info *info = &build->tree->info;
    struct mlrt_bvh_part parts[PART_LIMIT] = {{0, 0, 0, 0}};
    struct mlrt_hash hash;
    double cost = 0, area = half_area(tree->bvh.whole.lo, tree->bvh.whole.hi, 1);
    build->parts = parts;
    const int32_t status = mlrt_run_step(build, count_parts(&tree->bvh), measure_part);
    build->parts = NULL;
    if (status != MLRT_OK) return status;
    mlrt_start_hash(&hash);
    for (uint32_t i = 0; i < count_parts(&tree->bvh); i++) {
        const uint32_t words[2] = {(uint32_t)parts[i].hash, (uint32_t)(parts[i].hash >> 32)};
        mlrt_add_words(&hash, words, 2);
        cost += parts[i].cost;
        info->leaf_count += parts[i].leaf_count;
        info->reference_count += parts[i].reference_count;
    }
    info->node_count = tree->bvh.node_count;
    info->sah_cost = (area > 0 ? cost / area : 0) / build->costs.node + 1;
    info->tree_hash = mlrt_finish_hash(&hash);
    memcpy(info->bounds_min, tree->bounds.lo, sizeof info->bounds_min);
    memcpy(info->bounds_max, tree->bounds.hi, sizeof info->bounds_max);
    return MLRT_OK;
}

/* ---- the whole hierarchy ------------------------------------------------------------------------------------- */

static int32_t build_hierarchy(struct mlrt_bvh_build *build)
{
    if (!allocate_work(build)) return MLRT_ERROR_OUT_OF_MEMORY;
    build->limits.typical = mlrt_set_bvh_unit(build->tree);
    int32_t status = mlrt_make_references(build);
    if (status == MLRT_OK && build->references.whole.count > 0) status = mlrt_build_binary(build);
    if (status == MLRT_OK) status = mlrt_write_hierarchy(build);
    return status == MLRT_OK ? measure(build) : status;
}

/* Sets all settings and capacities that follow from the options and the number of triangles. */
static void set_limits(const mlrt_tree_options *options, uint32_t triangle_count, struct mlrt_bvh_build *build)
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
    build->limits.chunk_count = mlrt_item_count(triangle_count, MLRT_CHUNK_SIZE);
    const double levels = log2((double)triangle_count / MLRT_BVH_LEAF_LIMIT + 2);
    build->limits.cut_work = (MLRT_BVH_WORK - MLRT_FIRST_WORK - MLRT_LAST_WORK) / levels;
}

int32_t mlrt_build_bvh(struct mlrt_tree *tree, const mlrt_tree_options *options, struct mlrt_progress *progress)
{
    struct mlrt_bvh_build build = {.tree = tree, .progress = progress};
    if (tree->triangle_count >= MLRT_REFERENCE_MARK) return MLRT_ERROR_TOO_LARGE;
    set_limits(options, tree->triangle_count, &build);
    int32_t status = build_hierarchy(&build);
    free_work(&build);
    if (status != MLRT_OK) mlrt_free_bvh(tree);
    return status;
}

/* ---- expected memory ----------------------------------------------------------------------------------------- */

/*
 * Bytes of nodes, quads and places per triangle, with a margin. Scenes take: DEFAULT 51 to 60, FAST 50 to 56, BEST 52
 * to 69. Any tree takes more by a node, and by two arrays of at most a quad of 36 words and 16 behind it.
 */
static const double RESULT_SIZES[] = {62, 57, 70};

struct mlrt_demand mlrt_foresee_bvh(const void *tree_options, uint32_t triangle_count)
{
    const mlrt_tree_options *options = tree_options;
    struct mlrt_bvh_build build = {.tree = NULL};
    set_limits(options, triangle_count, &build);
    const uint64_t references = (uint64_t)build.limits.capacity * MLRT_REFERENCE_ROOM;
    const uint64_t work = lay_out_work(&build, NULL);
    const uint64_t result = (uint64_t)(RESULT_SIZES[options->preset] * triangle_count) + sizeof(struct mlrt_bvh_node) +
                            2 * (36 + 16) * sizeof(float);
    const uint64_t triangles = (uint64_t)triangle_count * sizeof(struct mlrt_triangle);
    return (struct mlrt_demand){result, triangles + work + (references > result ? references : result)};
}
