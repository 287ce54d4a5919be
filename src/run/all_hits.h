/* SPDX-License-Identifier: MIT */
/* All hits of rays, into the caller's arrays. */
#ifndef MLRT_RUN_ALL_HITS_H
#define MLRT_RUN_ALL_HITS_H

#include "base/host.h"
#include "rays/source.h"

/* Traces the rays of a source, which must not be a camera. Returns a status. */
int32_t mlrt_run_all_hits(const struct mlrt_tree *tree, const struct mlrt_source *source, const mlrt_hit_lists *lists,
                          const struct mlrt_run_options *options);

#endif
