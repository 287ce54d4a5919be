/* SPDX-License-Identifier: MIT */
/*
 * Finds which lights reach the hits of a picture's rays (mlrt.h, "Shadows of a picture").
 *
 * Where one triangle covers a cell of the picture, its shadow rays usually form a cell of the light. That cell needs no
 * rays if all of it is lit, or if one triangle shades all of it. The other packets get shadow rays.
 */
#ifndef MLRT_TRACE_SHADOWS_H
#define MLRT_TRACE_SHADOWS_H

#include <string.h>

#include "hits/write_to_sinks.h"
#include "job/write_arrays.h"
#include "simd/sixteen.h"
#include "trace/make_rays.h"
#include "trace/shadow_cells.h"
#include "trace/tile.h"

/* A closed cell of the picture and the lights, one bit each, that are decided for the whole cell. */
struct known_lights {
    uint32_t cover; /* the triangle that covers the cell, or MLRT_NONE */
    uint8_t known;  /* lights that reach all of the cell, or none of it */
    uint8_t dark;   /* of these, the lights that do not reach it */
};

/* Can closed cells of the picture become cells of the light? Requires a pinhole camera, a point light and unit 1. */
static int have_shadow_cells(const struct mlrt_job *job, const struct mlrt_job *light)
{
    return job->tree->bvh.unit == 1 && mlrt_is_pinhole(&job->source) && light->source.kind == MLRT_SOURCE_POINT_LIGHT &&
           mlrt_is_within_reach(&job->tree->bvh, light->source.light);
}

/* The closed cells that a triangle covers. */
static uint32_t covered_cells(const struct mlrt_bundle *bundle)
{
    return bundle->state.closed & ~mlrt_same_words(bundle->hulls.closed.cover, MLRT_NONE);
}

/* Decides lights for the closed cells of a square, into `known`. Returns the cells for which all lights are decided. */
static MLRT_NOINLINE uint32_t shade_cells(const struct mlrt_job *job, struct mlrt_worker *worker,
                                          const struct mlrt_bundle *seen,
                                          struct known_lights known[MLRT_BUNDLE_PACKETS])
{
    const uint32_t covered = covered_cells(seen);
    uint32_t all = seen->state.closed;
    for (uint32_t place = 0; place < MLRT_BUNDLE_PACKETS; ++place) {
        known[place] = (struct known_lights){seen->hulls.closed.cover[place], 0, 0};
    }
    for (uint32_t i = 0; i < job->light_count; ++i) {
        const struct mlrt_job *light = &job->lights[i];
        struct mlrt_bundle bundle;
        uint32_t dark = 0, lit = 0;
        bundle.tile = NULL;
        if (covered && have_shadow_cells(job, light) &&
            mlrt_make_shadow_cells(&light->source, job->tree, seen, covered, &bundle, &dark)) {
            trace_cells(light, worker, 0, &bundle);
            dark |= covered_cells(&bundle);
            lit = bundle.state.closed & ~dark;
        }
        for (uint32_t left = dark | lit; left; left &= left - 1) {
            struct known_lights *of = &known[mlrt_lowest_bit(left)];
            of->known |= (uint8_t)(1u << i);
            of->dark |= (uint8_t)((dark >> mlrt_lowest_bit(left) & 1) << i);
        }
        all &= dark | lit | (seen->state.closed & ~covered);
    }
    return all;
}

/* Finds the lanes of a tile's packets that a light does not reach. */
static void shade_packets(const struct mlrt_job *job, const struct mlrt_job *light, struct mlrt_worker *worker,
                          struct mlrt_ray_tile *seen, uint32_t dark_lanes[MLRT_BUNDLE_PACKETS])
{
    struct mlrt_ray_tile tile;
    struct mlrt_bundle bundle;
    uint32_t dark = 0, cells = 0, waiting = 0;
    mlrt_begin_tile(&seen->area, 0, &tile);
    tile.seen = seen;
    tile.surfaces = worker->bundles->surfaces;
    tile.picture = job;
    bundle.tile = &tile;
    bundle.state.closed = 0;
    const uint32_t covered = covered_cells(seen->cells), missed = seen->cells->state.closed & ~covered;
    if (mlrt_count_bits(covered) >= MLRT_LEAST_SHADOW_CELLS && have_shadow_cells(job, light)) {
        cells = mlrt_make_shadow_cells(&light->source, job->tree, seen->cells, covered, &bundle, &dark);
    }
    for (uint32_t left = tile.blocks & ~(dark | cells | missed); left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        make_rays_to_light(light, &tile, place);
        waiting |= ((tile.packets[place].active | tile.packets[place].in_double) != 0u) << place;
        tile.made |= 1u << place;
    }
    trace_bundle(light, worker, &bundle, waiting);
    dark |= cells & covered_cells(&bundle);
    for (uint32_t place = 0; place < MLRT_BUNDLE_PACKETS; ++place) {
        dark_lanes[place] = dark >> place & 1 ? 0xFFFF : 0;
        if (!(tile.made >> place & 1)) continue;
        COUNT(&worker->counters, ray_count, mlrt_count_bits(find_seen(job, seen, place) & ~tile.dark[place]));
        trace_rest_in_double(light, worker, &tile.packets[place]);
        dark_lanes[place] = tile.dark[place] | (0xFFFF & ~lanes_of_triangle(&tile.packets[place], MLRT_NONE));
    }
}

/*
 * Finds and writes which lights do not reach the hits of a tile. `known`: the lights decided for the whole tile, or
 * NULL.
 */
static MLRT_NOINLINE void shade_tile(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_ray_tile *tile,
                                     const struct known_lights *known)
{
    MLRT_ALIGNED(16) uint8_t shadows[MLRT_BUNDLE_PACKETS][MLRT_PACKET_RAYS];
    memset(shadows, known ? known->dark : 0, sizeof shadows);
    for (uint32_t i = 0; i < job->light_count; ++i) {
        uint32_t dark_lanes[MLRT_BUNDLE_PACKETS];
        if (known && known->known >> i & 1) continue;
        shade_packets(job, &job->lights[i], worker, tile, dark_lanes);
        for (uint32_t place = 0; place < MLRT_BUNDLE_PACKETS; ++place) {
            if (dark_lanes[place]) mlrt_add_shadow(shadows[place], dark_lanes[place], (uint8_t)(1u << i));
        }
    }
    for (uint32_t left = tile->blocks; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        const struct mlrt_rectangle block = mlrt_block_of_tile(tile, place);
        mlrt_write_packet_shadows(worker, shadows[place], mlrt_existing_lanes(&job->source, &block), &block);
    }
}

#endif
