/* SPDX-License-Identifier: MIT */
/* What a build of the kd-tree is asked for: see settings.h. */
#include "mlrta/settings.h"

#include <math.h>

#include "mlrta/kdtree.h"

/*
 * Intersection cost: with 1, 2.5, 8 a 4x4 packet from the root visits 55.9, 58.3, 59.6 cells of conference and tests
 * 5.2, 4.1, 3.8 triangles, by 3.2, 6.1, 8.7 nodes per triangle. So leaves that are smaller than those of 2.5 do not
 * pay.
 *
 * Empty factor: expected costs for 1, 0.9, 0.8, 0.7 differ by less than 1 %.
 *
 * Minimum cell: with 1e-8, 1e-6, 2e-5, 1e-4, packets visit 64.8, 59.6, 56.9, 55.0 cells of conference and 333, 146,
 * 42.9, 30.4 of a dense scan (dragon, 7.8 M triangles); at 2e-5 these match the 42.2 that the paper counts for its own
 * dragon without beams. Build times fall by a third at each step. But leaves grow: frames of a ship seen from inside
 * (cruiser) take 169, 220, 432 ms at 1e-6, 4e-6, 2e-5, those of the dragon 969, 749, 694 ms. So 1e-6 is a compromise.
 */
static const struct mlrt_preset PRESETS[] = {
    {{1.0, 2.5, 0.9}, 2e-5}, /* MLRT_KDTREE_PAPER */
    {{1.0, 1.0, 0.9}, 1e-6}, /* MLRT_KDTREE_TUNED */
};

/*
 * The usual 8 + 1.3 log2 n, plus 12 levels for empty sides and covered planes. With 60 levels in its place, expected
 * costs are the same in four digits (erw6, conference, cruiser, dragon, 2 million triangles of rooms). With 36 levels
 * they are at most 0.4 % higher, with 32 up to 4 %, with 28 up to 31 % (examples/depth.c).
 */
static uint32_t default_depth(uint32_t triangle_count)
{
    double depth = 20 + 1.3 * log2((double)triangle_count + 1);
    return depth < MLRT_DEPTH_LIMIT ? (uint32_t)depth : MLRT_DEPTH_LIMIT;
}

struct mlrt_kdtree_settings mlrt_resolve_kdtree_options(const mlrt_kdtree_options *options, uint32_t triangle_count)
{
    struct mlrt_kdtree_settings settings = {PRESETS[options->preset], options->rules_off, options->max_depth,
                                            options->max_references, options->pool};
    if (options->traversal_cost > 0) settings.preset.model.traversal = options->traversal_cost;
    if (options->intersection_cost > 0) settings.preset.model.intersection = options->intersection_cost;
    if (settings.depth_limit == 0) settings.depth_limit = default_depth(triangle_count);
    if (settings.depth_limit > MLRT_DEPTH_LIMIT) settings.depth_limit = MLRT_DEPTH_LIMIT;
    if (settings.reference_limit == 0) settings.reference_limit = 8 * (uint64_t)triangle_count + 1024;
    if (settings.reference_limit > UINT32_MAX) settings.reference_limit = UINT32_MAX;
    return settings;
}

/*
 * The nodes and entries of scenes take 9 to 59 bytes per triangle (docs/data/reproduce-5.md), and twice that while they
 * are built. Entries are limited; each has 4 bytes and, if it is alone in its leaf, 16 bytes of nodes.
 */
struct mlrt_demand mlrt_foresee_nodes(const void *options, uint32_t triangle_count)
{
    const struct mlrt_kdtree_settings settings = mlrt_resolve_kdtree_options(options, triangle_count);
    const uint64_t guess = 56 * (uint64_t)triangle_count + 64 * 12;
    const uint64_t most = 4 * settings.reference_limit + 16 * (settings.reference_limit + 1);
    const uint64_t held = guess < most ? guess : most;
    const uint64_t triangles = (uint64_t)triangle_count * sizeof(struct mlrt_triangle);
    return (struct mlrt_demand){triangles + held, 2 * triangles + 2 * held};
}
