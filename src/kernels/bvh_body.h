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
#include "tile_rays.h"
#include "bvh_leaf.h"
#include "bvh_tile.h"
#include "bvh_single.h"
#include "trace_packets.h"
#include "shade_tile.h"
#include "trace_area.h"

#if MLRT_COUNTING
const struct mlrt_kernels KERNELS_COUNTING = {trace_tile, NULL};
#else
const struct mlrt_kernels KERNELS = {trace_tile, trace_lone_ray};
#endif
