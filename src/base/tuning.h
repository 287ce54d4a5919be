/* SPDX-License-Identifier: MIT */
/*
 * The thresholds of the decisions that the default method takes while it traces, and those of the builder. A sweep
 * (examples/bench/sweep.py) compares other values, with copies of this file.
 *
 * Tables of the sweep are in docs/performance.md, "What tiles decide by themselves". Figures here are the speed with
 * another value over that with the value here.
 *
 * A cell is a packet of a tile of 16x16, or a tile of a square of 64x64. It is closed until one of its rays has to be
 * tested (trace/cover.h), and then open.
 */
#ifndef MLRT_BASE_TUNING_H
#define MLRT_BASE_TUNING_H

#include "mlrt.h"

/*
 * An attempt is in vain if all cells of an area had to be opened: then most cells of the next areas must be opened,
 * too. So the next tile begins with open cells, or the next square goes tile by tile; after another attempt in vain the
 * next 3, then 7, up to TILE_BACKOFF tiles (of a camera CELL_BACKOFF) and SQUARE_BACKOFF squares, which are one less
 * than a power of two. Where an attempt reads rays, READ_BACKOFF follow at once. If all are 0, every area begins with
 * closed cells.
 *
 * The first FIRST_OPEN_TILES and FIRST_OPEN_SQUARES areas of a worker begin open; 0xFFFFFFFF: all.
 *
 * Instructions (AVX2) if 3 tiles begin open after each attempt in vain: shadows of dragon 1.03, pictures of erw6 1.01.
 * With READ_BACKOFF 1: shadows of erw6 1.02.
 */
#define MLRT_TILE_BACKOFF       15
#define MLRT_CELL_BACKOFF       3
#define MLRT_SQUARE_BACKOFF     3
#define MLRT_READ_BACKOFF       3
#define MLRT_FIRST_OPEN_TILES   0
#define MLRT_FIRST_OPEN_SQUARES 0

/*
 * If most cells of a square that triangles hide in part are opened in the end, no cells of the next square wait for
 * further parts of a cover. If that is so again, none of the next 3, then 7, up to so many, one less than a power of
 * two. Zen 5, suns of sponza without this rule: 0.95.
 */
#define MLRT_LONE_SQUARE_BACKOFF 63

/*
 * A packet this many times as wide as the narrow ones of its tile (three quarters are at least as wide as those) goes
 * lane by lane, where the nearest hit is asked for. Where any hit will do, its two halves are traced one after the
 * other: without that, these rays take up to 1.1 times the instructions.
 */
#define MLRT_WIDE_FACTOR 4.0f

/*
 * If at least this many of the sixteen packets of a tile are covered by one triangle each, the shadows of these packets
 * begin with closed cells. All other packets get shadow rays.
 */
#define MLRT_LEAST_SHADOW_CELLS 9

/*
 * If a bundle has at least MANY_PACKETS packets, and at most FEW_PACKETS of them meet a child, then the rays of these
 * that meet it are traced one by one from there (trace_few_of_bundle, trace/traverse_bundle.h): at most FEW_RAYS rays
 * through a node, at most FEW_LEAF_RAYS through a leaf that is not set up. MANY_PACKETS of 17: never.
 *
 * Only scenes of small triangles, such as cruiser, need these rules; docs/tried.md, "Bundles", has other values.
 */
#define MLRT_MANY_PACKETS  8
#define MLRT_FEW_PACKETS   4
#define MLRT_FEW_RAYS      32
#define MLRT_FEW_LEAF_RAYS 3

/*
 * A packet that has been tested in vain against more triangles than this goes on lane by lane. With no limit,
 * reflections of small triangles have a quarter of the speed. Where any hit will do, lanes have few close calls: with
 * 96 for these, rays to a light with an extent have 0.72 to 0.99 of the speed, to four lights in turns 0.87 to 1.00;
 * with 40 for all, rays through a lens have 0.83 in doubled, 1.00 to 1.06 elsewhere (Intel Xeon). If all rays of a
 * bundle begin at one point, a test takes less than half of the work: with 96 for these, too, shadows of dragon have
 * 0.94 of the speed, of doubled and sponza 0.97, and with no limit, those of cruiser 0.52 (Zen 5). The same holds for
 * nearly parallel rays: with 96 for these, suns of clinic have 0.91 to 0.94, of dragon 0.97 to 1.00, of others 0.96 to
 * 1.01, and a parallel picture of sponza 0.77.
 */
#define MLRT_MOST_TESTS       96
#define MLRT_MOST_ANY_TESTS   40
#define MLRT_MOST_WAIST_TESTS 384

/*
 * A tile with more than MOST_GIVEN_UP such packets goes lane by lane as a whole, 1.3 times the speed for rays through a
 * lens in conference, and is in vain, as is one of which hardly a packet fits a bundle: the next tiles go lane by lane.
 */
#define MLRT_MOST_GIVEN_UP 2

/*
 * Tiles go as bundles or lane by lane, and now and then one of TRIAL_PACKETS or more goes both ways, to find the faster
 * one (trace/tile.h). After a change, or a bundle in vain, FIRST_TRIAL tiles go without a trial; when it agrees, twice
 * as many and one more do, up to LAST_TRIAL. Of what earlier trials took, TRIALS_KEPT remains when a trial is added.
 *
 * Where triangles are small beside packets, trials gain what bundles lose. Speed with trials over that without (Zen 4,
 * AVX-512, 1,024 x 1,024): in dragon rays in one direction 1.03, to a light with an extent 1.06, to a point 1.06, in
 * dragon_x9 1.13, 1.08 and 1.06; in doubled 1.00, 1.11 and 1.00; in rooms 0.97 to 1.03, 0.96 to 1.03 and 0.98 to 1.00,
 * reflections 0.98 to 1.00. On an Intel Xeon (512 x 512) rays in one direction have 1.15 in dragon and 1.11 in doubled,
 * to a light with an extent 1.33 and 1.13. With 255 tiles at most, rays in one direction and to such a
 * light have 1.01, reflections 0.98, and rays through a lens 0.99 (Zen 4, means of seven scenes).
 */
#define MLRT_FIRST_TRIAL   7
#define MLRT_LAST_TRIAL    63
#define MLRT_TRIAL_PACKETS 4
#define MLRT_TRIALS_KEPT   0.875f

/*
 * A worker keeps 1 << LEAF_SETUP_BITS set-ups of leaves, of 2 KiB each. In calls of fewer than MANY_RAYS rays it keeps
 * 1 << FEW_SETUP_BITS, because memory is slow when it is first used (docs/tried.md, "Bundles").
 */
#define MLRT_LEAF_SETUP_BITS 7
#define MLRT_FEW_SETUP_BITS  5
#define MLRT_MANY_RAYS       16384

/*
 * Below are settings of the builder of boxes. `sweep.py --trees` compares trees by other values with those by these,
 * all traced by the same kernels; docs/performance.md, "How large leaves are", has the results.
 *
 * The builder's cost of each triangle of a leaf, where a leaf costs 1; bvh/build.c has more measurements. Lower costs
 * make larger leaves.
 */
#define MLRT_TRIANGLE_COST 0.02f

/* The most triangles that the builder puts into a leaf, at most MLRT_BVH_LEAF_LIMIT. */
#define MLRT_LEAF_TRIANGLES 16

/* The most children that the builder gives a node, 2 to MLRT_BVH_WIDTH. */
#define MLRT_NODE_CHILDREN 16

/*
 * Spatial splits of the default preset: spare places per triangle for the references that they add; they are tried
 * where sides overlap by more than OVERLAP_LIMIT of the scene's area, in sets of more than SPATIAL_SIZE references (at
 * least MLRT_BVH_LEAF_LIMIT).
 */
#define MLRT_SPARE_SHARE   0.15f
#define MLRT_OVERLAP_LIMIT 1e-4f
#define MLRT_SPATIAL_SIZE  32

/*
 * A spatial split is used if its cost is below this part of the best other split's. In scenes of regular parts both
 * often cost about the same, and spatial splits only add references: with 1, erw10 (a room of equal squares) takes 3.79
 * nodes and 2.85 leaves per packet, with 0.99 and 0.97 it takes 3.53 and 2.94. 0.9 is too low: a building (clinic) then
 * takes 8.3 nodes instead of 6.1.
 */
#define MLRT_PLANE_GAIN 0.99

#endif
