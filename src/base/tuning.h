/* SPDX-License-Identifier: MIT */
/*
 * What method tile decides by itself while it traces, and the numbers it does so with. They are here, and can be set by
 * the compiler's command line, so that a sweep (examples/bench/sweep.py) can compare each with fixed choices;
 * docs/performance.md has what it found.
 */
#ifndef MLRT_BASE_TUNING_H
#define MLRT_BASE_TUNING_H

#include "mlrt.h"

/*
 * Where all cells of one area had to be opened, so have those of the next ones, mostly: so many tiles of 16x16 begin
 * with open cells, and so many squares of 64x64 with their tiles. 0: all areas begin with closed cells.
 */
#ifndef MLRT_TILE_RUN
#define MLRT_TILE_RUN 3
#endif
#ifndef MLRT_SQUARE_RUN
#define MLRT_SQUARE_RUN 3
#endif

/* How many begin so at first. 0xFFFFFFFF: all. */
#ifndef MLRT_FIRST_OPEN_TILES
#define MLRT_FIRST_OPEN_TILES 0
#endif
#ifndef MLRT_FIRST_OPEN_SQUARES
#define MLRT_FIRST_OPEN_SQUARES 0
#endif

/* A packet so many times as wide as most of its tile goes lane by lane. */
#ifndef MLRT_WIDE_FACTOR
#define MLRT_WIDE_FACTOR 4.0f
#endif

/* A tile of which so many packets see one triangle each begins its shadows with closed cells of these; others have
 * rays. */
#ifndef MLRT_LEAST_LIT_CELLS
#define MLRT_LEAST_LIT_CELLS 9
#endif

/* A tile of at least this many packets has the rays of few of them go on one by one from what these meet
 * (trace/tile.h). 17: none does. */
#ifndef MLRT_MANY_PACKETS
#define MLRT_MANY_PACKETS 8
#endif

/* At most so many packets, */
#ifndef MLRT_FEW_PACKETS
#define MLRT_FEW_PACKETS 4
#endif

/* and so many of their rays: through a node, and through a leaf that is not set up. */
#ifndef MLRT_FEW_RAYS
#define MLRT_FEW_RAYS 32
#endif
#ifndef MLRT_FEW_LEAF_RAYS
#define MLRT_FEW_LEAF_RAYS 3
#endif

/*
 * A packet that has been tested against so many triangles that none of its rays could hit goes on lane by lane. Rays of
 * arrays with 40 and 160 in its place have 0.87 to 1.02 of the speed (conference, dragon, cruiser).
 */
#ifndef MLRT_MOST_TESTS
#define MLRT_MOST_TESTS 96
#endif

/* Where more packets of a tile than this have been tested so often, all of it goes lane by lane, and so do the next tiles.
 */
#ifndef MLRT_MOST_GIVEN_UP
#define MLRT_MOST_GIVEN_UP 4
#endif
#ifndef MLRT_LANE_TILES
#define MLRT_LANE_TILES 3
#endif

/*
 * A worker keeps 1 << this set-ups of leaves, of 2 KiB; in calls of fewer rays than many, fewer, since what first
 * uses memory waits for it. By instructions, pictures and shadows take up to 3 % more with 32.
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

/* What a triangle more in a leaf costs the builder, where a node costs 1: less makes larger leaves. */
#ifndef MLRT_TRIANGLE_COST
#define MLRT_TRIANGLE_COST 0.02f
#endif

#endif
