/* SPDX-License-Identifier: MIT */
/* What a build of the kd-tree is asked for: presets, costs, limits. */
#ifndef MLRT_MLRTA_SETTINGS_H
#define MLRT_MLRTA_SETTINGS_H

#include "mlrta/split.h"

struct mlrt_preset {
    struct mlrt_cost_model model;
    double minimum_cell; /* rule 3: cells of less than this part of the scene's surface area are not split */
};

struct mlrt_kdtree_settings {
    struct mlrt_preset preset;
    uint32_t rules_off;
    uint32_t depth_limit;
    uint64_t reference_limit;
    mlrt_pool *pool;
};

/* Options with all defaults resolved. */
struct mlrt_kdtree_settings mlrt_resolve_kdtree_options(const mlrt_kdtree_options *options, uint32_t triangle_count);

#endif
