/* SPDX-License-Identifier: MIT */
/*
 * What the kernels of both structures begin with, in the words of the simd_*.h that was included before.
 */
#ifndef MLRT_KERNELS_SHARED_H
#define MLRT_KERNELS_SHARED_H

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "bvh_unit.h"
#include "counters.h"
#include "hit.h"
#include "kernels.h"
#include "levels.h"
#include "pair_line.h"
#include "ray_interval.h"
#include "rounding.h"
#include "results.h"
#include "shadow.h"
#include "stop.h"
#include "tile.h"
#include "tile_packets.h"
#include "trace_ray.h"
#include "undecided.h"
#include "words.h"

#include "slopes.h"
#include "extremes.h"
#include "triangle_filter.h"
#include "outcome.h"
#include "doubles.h"
#include "close_calls.h"

#endif
