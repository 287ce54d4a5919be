/* SPDX-License-Identifier: MIT */
/*
 * All kernels, in the words of the simd_*.h that was included before: one instruction set's file is that header, the
 * names of its tables, and this. Compiled twice, with and without MLRT_COUNTING (counters.h). Everything is static but
 * the table.
 *
 * What goes down the kd-tree is there once, for four lanes or, without SSE, one: more would add a quarter to the
 * library for what the hierarchy of boxes does faster (design.md).
 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "counters.h"
#include "hit.h"
#include "kernels.h"
#include "rounding.h"
#include "trace_ray.h"

#ifndef KDTREE_KERNELS
#define KDTREE_KERNELS (MLRT_HAVE_SSE ? VW == 4 : VW == 1)
#endif

#include "camera_packet.h"
#include "packet_check.h"
#include "picture.h"
#include "outline.h"
#include "ray_group.h"
#include "triangle_setup.h"
#include "triangle_filter.h"
#if KDTREE_KERNELS
#include "interval_traversal.h"
#include "masked_traversal.h"
#include "beam_culling.h"
#include "covering.h"
#include "entry_point.h"
#endif
#include "cells.h"
#include "ray_tile.h"
#include "bvh_leaf.h"
#include "bvh_tile.h"
#include "write_packet.h"
#include "bvh_single.h"
#include "trace_tile.h"

#if MLRT_COUNTING
const struct mlrt_kernels KERNELS_COUNTING = {trace_tile, NULL};
#else
const struct mlrt_kernels KERNELS = {trace_tile, trace_lone_ray};
#endif
