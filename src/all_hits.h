/* SPDX-License-Identifier: MIT */
/*
 * All hits of rays, into the caller's arrays.
 */
#ifndef MLRT_ALL_HITS_H
#define MLRT_ALL_HITS_H

#include "source.h"

/* Traces the rays of a source (not a camera) on a pool. `counters` may be NULL. Returns a status. */
int32_t mlrt_run_all_hits(const struct mlrt_tree *tree, const struct mlrt_source *source, const mlrt_hit_lists *lists,
                          mlrt_pool *pool, mlrt_counters *counters);

#endif
