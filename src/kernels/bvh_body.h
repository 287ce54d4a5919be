/* SPDX-License-Identifier: MIT */
/*
 * All kernels for the hierarchy of boxes, in the words of the simd_*.h that was included before: one instruction set's
 * file is that header, the names of its tables, and this. Compiled with and without MLRT_COUNTING (counters.h).
 * Everything is static but the table.
 */
#include "shared.h"

#include "packet_check.h"
#if !MLRT_COUNTING
#include "camera_packet.h"
#include "picture.h"
#include "read_arrays.h"
#include "tile_rays.h"
#include "write_packet.h"
#include "shadow_packet.h"
#endif

#include "units.h"
#include "bvh_single.h"
#include "bundle.h"
#include "camera_cells.h"
#include "bundle_outline.h"
#include "bundle_leaf.h"
#include "bundle_cover.h"
#include "lanes.h"
#include "bundle_tile.h"

/* clang-format off: a table */
#define KERNELS_OF_BOXES                                                                                               \
    .trace_tile = mlrt_trace_levels, .counts = MLRT_COUNTING, .gather_camera_cells = gather_camera_cells,              \
    .trace_cells = trace_cells, .trace_bundle = trace_bundle
/* clang-format on */

#if MLRT_COUNTING
const struct mlrt_kernels KERNELS_COUNTING = {KERNELS_OF_BOXES, .picture = &mlrt_plain_picture};
#else
const struct mlrt_picture_kernels PICTURE = {fetch_block, check_block, read_packets, write_packet};
const struct mlrt_kernels KERNELS = {KERNELS_OF_BOXES, .picture = &PICTURE, .trace_ray = trace_lone_ray,
                                     .make_shadow_packet = make_shadow_packet};
#endif
