/* SPDX-License-Identifier: MIT */
/*
 * The hierarchy of boxes as a structure: see job/structure.h.
 */
#include "job/structure.h"

#include <string.h>

#include "bvh/node.h"
#include "bvh/unit.h"
#include "job/job.h"
#include "trace/bundle.h"

static int32_t build(struct mlrt_tree *tree, const void *options, struct mlrt_progress *progress)
{
    const int32_t status = mlrt_build_bvh(tree, options, progress);
    if (status != MLRT_OK || !tree->bvh.places) return status;
    mlrt_free(&tree->memory, tree->triangles, tree->triangle_count, sizeof *tree->triangles);
    tree->triangles = NULL; /* leaves have them */
    mlrt_find_triangles(tree);
    return MLRT_OK;
}

/* There are quads of leaves if there are nodes, and other quads only if there are places (bvh/node.h). */
static const char *take(struct mlrt_tree *tree)
{
    const struct mlrt_bvh *bvh = &tree->bvh;
    if ((bvh->node_count > 0) != (bvh->leaf_quad_count > 0) || bvh->leaf_quad_count > bvh->quad_count ||
        (!bvh->places && bvh->leaf_quad_count < bvh->quad_count) || bvh->node_count > MLRT_BVH_NODE_LIMIT) {
        return "counts that no tree has";
    }
    return mlrt_check_places(tree);
}

static const char *check(struct mlrt_tree *tree)
{
    const float unit = tree->bvh.unit;
    const uint64_t left_out = tree->info.non_finite_count + tree->info.zero_area_count;
    if (tree->bvh.node_count == 0 && left_out < tree->triangle_count) return "there are triangles, but no boxes";
    mlrt_set_bvh_extent(tree, mlrt_set_bvh_unit(tree));
    if (memcmp(&unit, &tree->bvh.unit, sizeof unit) != 0) return "the unit is not that of the triangles";
    return mlrt_check_boxes(tree);
}

/*
 * A worker keeps set-ups of leaves for closest hits (any = 0) or any hits (1), in tables of their own, since a
 * picture's tiles and their shadows are traced in turns. Leaves come first, since they fill whole cache lines. For rays
 * of which no bundle is made it keeps nothing.
 */
static size_t lay_out(const struct mlrt_job *job, unsigned char *memory, struct mlrt_worker *worker)
{
    if (mlrt_is_block(job)) return 0;
    const uint32_t bits = mlrt_is_small(job) ? MLRT_FEW_SETUP_BITS : MLRT_LEAF_SETUP_BITS;
    const int is_kept[2] = {!job->any, job->any || job->light_count};
    struct mlrt_bundle_leaf *leaves = (struct mlrt_bundle_leaf *)(void *)memory;
    const size_t size = sizeof *leaves * ((size_t)(is_kept[0] + is_kept[1]) << bits);
    if (memory) {
        struct mlrt_bundles *bundles = (struct mlrt_bundles *)(void *)(memory + size);
        const struct mlrt_backoff none = {0, 0};
        for (int any = 0; any < 2; ++any) {
            struct mlrt_bundle_cache *cache = &bundles->caches[any];
            cache->waist = (struct mlrt_waist){.main_axis = -1};
            cache->waist_count = 0;
            cache->bits = bits;
            cache->leaves = leaves;
            if (is_kept[any]) leaves += (size_t)1 << bits;
            bundles->open_bundles[any] = none;
            bundles->ways[any] = (struct mlrt_ways){.trial = {.left = MLRT_FIRST_TRIAL}};
        }
        for (int i = 0; job->light_count && i < MLRT_KEPT_SURFACES; ++i) bundles->surfaces[i].light = NULL;
        bundles->open_tiles = (struct mlrt_backoff){.left = MLRT_FIRST_OPEN_TILES};
        bundles->open_squares = (struct mlrt_backoff){.left = MLRT_FIRST_OPEN_SQUARES};
        bundles->parts.lone_squares = none;
        bundles->parts.waited = 0;
        worker->bundles = bundles;
    }
    return size + (sizeof(struct mlrt_bundles) + 63) / 64 * 64;
}

const struct mlrt_structure mlrt_structure_bvh = {
    .code = MLRT_STRUCTURE_BVH,
    .name = "one of boxes",
    .plural = "boxes",
    .builder = {.options_form = MLRT_STRUCT_TREE_OPTIONS,
                .work = MLRT_BVH_WORK,
                .build = build,
                .foresee = mlrt_foresee_bvh,
                .free = mlrt_free_bvh},
    .file = {.sections = {MLRT_SECTION(bvh.nodes, bvh.node_count, sizeof(struct mlrt_bvh_node), 0, BOX_NODES,
                                       BOX_NODES),
                          MLRT_SECTION(bvh.corners, bvh.quad_count, 144, 64, QUADS, QUADS),
                          MLRT_SECTION(bvh.numbers, bvh.quad_count, 16, 64, QUADS, QUADS),
                          MLRT_SECTION(bvh.places, triangle_count, 4, 0, PLACES, PLACES)},
             .first = 7,
             .count = 4,
             .numbers = offsetof(struct mlrt_tree, bvh.unit),
             .take = take,
             .check = check},
    .tracer = {.method = MLRT_METHOD_TILE,
               .methods = 1u << MLRT_METHOD_RAY | 1u << MLRT_METHOD_TILE,
               .camera_side = 128,
               .row_side = 64,   /* a square of tiles */
               .list_side = 256, /* lists are four rays wide */
#if MLRT_SSE_KERNELS
               .kernels = {[MLRT_ISA_SSE] = &mlrt_kernels_sse,
                           [MLRT_ISA_AVX2] = &mlrt_kernels_avx2,
                           [MLRT_ISA_AVX512] = &mlrt_kernels_avx512},
#elif MLRT_NEON_KERNELS
               .kernels = {[MLRT_ISA_NEON] = &mlrt_kernels_neon},
#else
               .kernels = {[MLRT_ISA_SCALAR] = &mlrt_kernels_scalar},
#endif
               .lay_out = lay_out,
               .trace_ray = mlrt_trace_boxes},
};
