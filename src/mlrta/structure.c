/* SPDX-License-Identifier: MIT */
/* The kd-tree as a structure: see job/structure.h. */
#include "job/structure.h"

#include <math.h>

#include "job/job.h"
#include "mlrta/kdtree.h"
#include "mlrta/setups.h"

static void free_nodes(struct mlrt_tree *tree)
{
    struct mlrt_kdtree *kdtree = &tree->kdtree;
    mlrt_free(&tree->memory, kdtree->nodes, kdtree->node_count, sizeof *kdtree->nodes);
    mlrt_free(&tree->memory, kdtree->references, kdtree->reference_count, sizeof *kdtree->references);
}

static const char *take(struct mlrt_tree *tree)
{
    return tree->kdtree.node_count > 0 ? NULL : "counts that no tree has";
}

static const char *check(struct mlrt_tree *tree)
{
    mlrt_find_float_limits(tree);
    return mlrt_check_nodes(tree);
}

/*
 * A worker keeps set-ups of triangles; only methods whose packets share them have more than one. They are not cleared,
 * which would slow down calls of few rays: their apex is one that no packet has, so that the first packet clears them
 * (forget_setups).
 */
static size_t lay_out(const struct mlrt_job *job, unsigned char *memory, struct mlrt_worker *worker)
{
    const int is_shared =
        job->method != MLRT_METHOD_PACKET2 && (job->multilevel.shortcuts & MLRT_SHORTCUT_SHARED_SETUPS);
    const uint32_t count = is_shared ? MLRT_SETUP_COUNT : 1;
    if (memory) {
        worker->setups = (struct mlrt_setups *)(void *)memory;
        worker->setups->apex[0] = NAN;
        worker->setups->mask = count - 1;
    }
    return (sizeof(struct mlrt_setups) + count * sizeof(struct mlrt_triangle_setup) + 63) / 64 * 64;
}

const struct mlrt_structure mlrt_structure_kdtree = {
    .code = MLRT_STRUCTURE_KDTREE,
    .name = "a kd-tree",
    .plural = "kd-trees",
    .builder = {.options_form = MLRT_STRUCT_KDTREE_OPTIONS,
                .work = MLRT_KDTREE_WORK,
                .build = mlrt_build_nodes,
                .foresee = mlrt_foresee_nodes,
                .free = free_nodes},
    .file = {.sections = {MLRT_SECTION(kdtree.nodes, kdtree.node_count, sizeof(struct mlrt_node), 0, NODES, NODES),
                          MLRT_SECTION(kdtree.references, kdtree.reference_count, 4, 0, REFERENCES, NODES)},
             .first = 5,
             .count = 2,
             .take = take,
             .check = check},
    .tracer = {.method = MLRT_METHOD_MULTILEVEL,
               .methods = 1u << MLRT_METHOD_RAY | 1u << MLRT_METHOD_PACKET2 | 1u << MLRT_METHOD_PACKET4 |
                          1u << MLRT_METHOD_MULTILEVEL,
               .camera_side = 128,
               .row_side = 32, /* a beam needs a pass over the rays of arrays, so there is one level */
               .list_side = 32,
#if MLRT_SSE_KERNELS
               .kernels = {[MLRT_ISA_SSE] = &mlrt_kernels_kdtree_sse, [MLRT_ISA_AVX2] = &mlrt_kernels_kdtree_avx2},
#elif MLRT_NEON_KERNELS
               .kernels = {[MLRT_ISA_NEON] = &mlrt_kernels_kdtree_neon},
#else
               .kernels = {[MLRT_ISA_SCALAR] = &mlrt_kernels_kdtree_scalar},
#endif
               .lay_out = lay_out,
               .trace_ray = mlrt_trace_cells},
};
