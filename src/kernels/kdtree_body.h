/* SPDX-License-Identifier: MIT */
/*
 * All kernels for the kd-tree, likewise (bvh_body.h).
 */
#include "shared.h"

#include "outline.h"
#include "ray_group.h"
#include "triangle_setup.h"
#include "packet_filter.h"
#include "interval_traversal.h"
#include "masked_traversal.h"
#include "beam_culling.h"
#include "covering.h"
#include "entry_point.h"
#include "kdtree_levels.h"

const struct mlrt_kernels KERNELS = {.trace_tile = trace_tile, .counts = MLRT_COUNTING, .picture = &mlrt_plain_picture};
