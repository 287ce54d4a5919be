/* SPDX-License-Identifier: MIT */
/*
 * Which of two triangles does a ray of a bundle meet first? The line in which their planes meet decides: rays that meet
 * both planes in one order pass the line on one side, the others on the other side. A line holds for rays from
 * anywhere.
 */
#ifndef MLRT_TRACE_PLANE_ORDER_H
#define MLRT_TRACE_PLANE_ORDER_H

#include "job/job.h"
#include "trace/bundle.h"

/* Sets the line of two triangles, relative to the waist of a cache. */
void mlrt_set_pair_line(const struct mlrt_tree *tree, const struct mlrt_bundle_cache *cache, uint32_t first,
                        uint32_t second, struct mlrt_worker *worker, struct mlrt_pair_line *line);

/* Returns the line of two triangles, relative to the waist of a cache. The cache keeps the last lines. */
static inline const struct mlrt_pair_line *mlrt_find_pair_line(const struct mlrt_tree *tree, uint32_t first,
                                                               uint32_t second, struct mlrt_worker *worker,
                                                               struct mlrt_bundle_cache *cache)
{
    struct mlrt_pair_line *line =
        &cache->lines[(first * 0x9E3779B1u ^ second * 0x85EBCA6Bu) >> (32 - MLRT_PAIR_LINE_BITS)];
    if (MLRT_UNLIKELY(line->first != first || line->second != second || line->waist_count != cache->waist_count)) {
        mlrt_set_pair_line(tree, cache, first, second, worker, line);
    }
    return line;
}

#endif
