/* SPDX-License-Identifier: MIT */
/*
 * All kernels for the hierarchy of boxes, in the words of the simd_*.h that was included before: one instruction set's
 * file is that header, the names of its tables, and this. Compiled with and without MLRT_COUNTING (counters.h).
 * Everything is static but the table.
 */
#include "shared.h"
#include "sheared.h"

#include "cells.h"
#include "ray_tile.h"
#include "shadow_packet.h"
#include "bvh_leaf.h"
#include "bvh_tile.h"
#include "bvh_single.h"
#include "tile_rays.h"

#if MLRT_COUNTING
#undef KERNELS
#define KERNELS            KERNELS_COUNTING
#define trace_lone_ray     NULL
#define make_shadow_packet NULL
#endif
const struct mlrt_kernels KERNELS = {
    mlrt_trace_levels, MLRT_COUNTING,       fetch_block,  check_block,  write_packet,      trace_lone_ray,
    trace_singles,     gather_camera_cells, sum_up_cells, make_packets, gather_packets,    trace_gathered,
    add_packet,        lanes_near_first,    traverse_bvh, open_packet,  make_shadow_packet};
