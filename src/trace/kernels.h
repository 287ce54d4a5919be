/* SPDX-License-Identifier: MIT */
/*
 * All kernels for the hierarchy of boxes. The file of an instruction set includes its simd header, defines the names of
 * its tables, and includes this. With MLRT_COUNTING the kernels count (counters.h). Only the tables are not static.
 */
#ifndef MLRT_TRACE_KERNELS_H
#define MLRT_TRACE_KERNELS_H

#include "base/counters.h"
#include "job/job.h"
#include "trace/levels.h"

#include "rays/check_packet.h"
#include "trace/units.h"
#include "trace/single_ray.h"
#include "trace/ray_hulls.h"
#include "trace/camera_cells.h"
#include "trace/outline.h"
#include "trace/leaf.h"
#include "trace/cover.h"
#include "trace/lane_by_lane.h"
#include "trace/tile.h"
#if !MLRT_COUNTING
#include "rays/camera_packet.h"
#include "rays/fetch_block.h"
#include "rays/read_arrays.h"
#include "trace/read_tile.h"
#include "hits/write_packet.h"
#include "hits/shadow_packet.h"
#include "trace/array_cells.h"
#endif

/* See job.h. Kernels that count have no cells of arrays. */
static int gather_cells(const struct mlrt_job *job, const struct mlrt_rectangle *area, uint32_t side,
                        struct mlrt_bundle *bundle)
{
    if (mlrt_is_pinhole(&job->source)) return gather_camera_cells(job, area, side, bundle);
#if !MLRT_COUNTING
    if (side == 16 && job->source.kind != MLRT_SOURCE_CAMERA) return gather_array_cells(job, area, bundle);
#endif
    return 0;
}

/* clang-format off: a table */
#define KERNELS_OF_BOXES                                                                                               \
    .trace_tile = mlrt_trace_levels, .counts = MLRT_COUNTING, .gather_cells = gather_cells,                            \
    .trace_cells = trace_cells, .trace_bundle = trace_bundle
/* clang-format on */

#if MLRT_COUNTING
const struct mlrt_kernels KERNELS_COUNTING = {KERNELS_OF_BOXES, .picture = &mlrt_plain_picture};
#else
const struct mlrt_picture_kernels PICTURE = {fetch_block, check_block, read_packets, write_packet, decide_lanes};
#ifndef REPORTS
#define REPORTS NULL
#endif
#ifndef REPORT_RAY
#define REPORT_RAY NULL
#endif
const struct mlrt_kernels KERNELS = {KERNELS_OF_BOXES,
                                     .picture = &PICTURE,
                                     .trace_ray = trace_lone_ray,
                                     .trace_scaled_ray = trace_scaled_ray,
                                     .report_ray = REPORT_RAY,
                                     .reports = REPORTS,
                                     .make_shadow_packet = make_shadow_packet};
#endif

#endif
