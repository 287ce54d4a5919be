/* SPDX-License-Identifier: MIT */
/*
 * The thresholds of the decisions that the default method takes while it traces, and one of the builder. They are
 * macros that the compiler's command line can set, so that a sweep (examples/bench/sweep.py) can compare other values;
 * docs/performance.md, "What tiles decide by themselves", has its results.
 *
 * A cell of a camera (a packet of a tile of 16x16, or a tile of a square of 64x64) is closed while its rays are not
 * made, and open once they are.
 */
#ifndef MLRT_BASE_TUNING_H
#define MLRT_BASE_TUNING_H

#include "mlrt.h"

/*
 * After an area whose cells all had to be opened, so must most cells of the next areas. So this many tiles begin with
 * open cells, and this many squares are not traced as squares but tile by tile. 0: every area begins with closed cells.
 */
#ifndef MLRT_TILE_RUN
#define MLRT_TILE_RUN 3
#endif
#ifndef MLRT_SQUARE_RUN
#define MLRT_SQUARE_RUN 3
#endif

/* How many tiles, and how many squares, of a worker begin so at first. 0xFFFFFFFF: all. */
#ifndef MLRT_FIRST_OPEN_TILES
#define MLRT_FIRST_OPEN_TILES 0
#endif
#ifndef MLRT_FIRST_OPEN_SQUARES
#define MLRT_FIRST_OPEN_SQUARES 0
#endif

/* A packet this many times as wide as most packets of its tile goes lane by lane. */
#ifndef MLRT_WIDE_FACTOR
#define MLRT_WIDE_FACTOR 4.0f
#endif

/*
 * In a tile where at least this many packets see one triangle each, the shadows of these packets begin with closed
 * cells; all other packets begin with rays.
 */
#ifndef MLRT_LEAST_LIT_CELLS
#define MLRT_LEAST_LIT_CELLS 9
#endif

/*
 * If a bundle has at least MANY_PACKETS packets, and at most FEW_PACKETS of them meet a child, then the rays of these
 * that meet it are traced one by one from there (trace_few_of_bundle, trace/tile.h): at most FEW_RAYS rays through a
 * node, at most FEW_LEAF_RAYS through a leaf that is not set up. MANY_PACKETS of 17: never. Other values take more
 * instructions: docs/design.md, "Few rays go one by one".
 */
#ifndef MLRT_MANY_PACKETS
#define MLRT_MANY_PACKETS 8
#endif

#ifndef MLRT_FEW_PACKETS
#define MLRT_FEW_PACKETS 4
#endif
#ifndef MLRT_FEW_RAYS
#define MLRT_FEW_RAYS 32
#endif
#ifndef MLRT_FEW_LEAF_RAYS
#define MLRT_FEW_LEAF_RAYS 3
#endif

/*
 * A packet that has been tested in vain against more triangles than this goes on lane by lane. With 40 or 160 instead,
 * rays of arrays have 0.87 to 1.02 of the speed (conference, dragon, cruiser).
 */
#ifndef MLRT_MOST_TESTS
#define MLRT_MOST_TESTS 96
#endif

/*
 * A tile with more than MOST_GIVEN_UP such packets goes lane by lane as a whole, and so do the next LANE_TILES tiles:
 * 1.3 times the speed for rays through a lens in conference.
 */
#ifndef MLRT_MOST_GIVEN_UP
#define MLRT_MOST_GIVEN_UP 4
#endif
#ifndef MLRT_LANE_TILES
#define MLRT_LANE_TILES 3
#endif

/*
 * A worker keeps 1 << LEAF_SETUP_BITS set-ups of leaves, of 2 KiB each. In calls of fewer than MANY_RAYS rays it keeps
 * 1 << FEW_SETUP_BITS, because memory is slow when it is used first. With 32 set-ups in all calls, pictures and shadows
 * take up to 3 % more instructions.
 */
#ifndef MLRT_LEAF_SETUP_BITS
#define MLRT_LEAF_SETUP_BITS 7
#endif
#ifndef MLRT_FEW_SETUP_BITS
#define MLRT_FEW_SETUP_BITS 5
#endif
#ifndef MLRT_MANY_RAYS
#define MLRT_MANY_RAYS 16384
#endif
#if MLRT_FEW_SETUP_BITS > MLRT_LEAF_SETUP_BITS
#error "MLRT_FEW_SETUP_BITS: at most MLRT_LEAF_SETUP_BITS"
#endif

/* The builder's cost of each triangle of a leaf, where a node costs 1 (bvh/build.c). Lower costs make larger leaves. */
#ifndef MLRT_TRIANGLE_COST
#define MLRT_TRIANGLE_COST 0.02f
#endif

#endif
