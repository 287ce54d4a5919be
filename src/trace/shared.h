/* SPDX-License-Identifier: MIT */
/*
 * What the kernels of both structures begin with, in the words of the simd_*.h that was included before.
 */
#ifndef MLRT_KERNELS_SHARED_H
#define MLRT_KERNELS_SHARED_H

#include <float.h>
#include <math.h>
#include <string.h>

#include "bvh/unit.h"
#include "base/counters.h"
#include "exact/nearest.h"
#include "job/job.h"
#include "trace/levels.h"
#include "trace/pair_line.h"
#include "exact/ray_interval.h"
#include "exact/rounding.h"
#include "hits/results.h"
#include "hits/shadow_ray.h"
#include "job/stop.h"
#include "trace/ray_tile.h"
#include "trace/make_rays.h"
#include "run/trace_ray.h"
#include "hits/undecided.h"
#include "simd/sixteen.h"

#include "rays/slopes.h"
#include "rays/extremes.h"
#include "hits/triangle_filter.h"
#include "hits/outcome.h"
#include "simd/doubles.h"
#include "hits/close_calls.h"

#endif
