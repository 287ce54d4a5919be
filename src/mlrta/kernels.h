/* SPDX-License-Identifier: MIT */
/*
 * All kernels for the kd-tree, in the words of the simd header that was included before. Everything is static but the
 * table.
 */
#ifndef MLRT_MLRTA_KERNELS_H
#define MLRT_MLRTA_KERNELS_H

#include "base/counters.h"
#include "job/job.h"

#include "mlrta/outline.h"
#include "mlrta/ray_group.h"
#include "mlrta/triangle_setup.h"
#include "mlrta/packet_filter.h"
#include "mlrta/interval_traversal.h"
#include "mlrta/masked_traversal.h"
#include "mlrta/block.h"
#include "mlrta/levels.h"

extern const struct mlrt_picture_kernels PICTURE;

const struct mlrt_kernels KERNELS = {
    .trace_tile = mlrt_trace_kdtree_tile, .picture = &PICTURE, .trace_block = trace_block};

#endif
