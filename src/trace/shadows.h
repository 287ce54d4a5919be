/* SPDX-License-Identifier: MIT */
/*
 * Finds which lights reach the hits of a picture's rays (mlrt.h, "Shadows of a picture"), in the tile method.
 */
#ifndef MLRT_TRACE_SHADOWS_H
#define MLRT_TRACE_SHADOWS_H

#include "trace/ray_tile.h"

/* A closed cell of the picture and the lights, one bit each, that are decided for the whole cell. */
struct mlrt_known_lights {
    uint32_t cover; /* the triangle that covers the cell, or MLRT_NONE */
    uint8_t known;  /* lights that reach all of the cell, or none of it */
    uint8_t dark;   /* of these, the lights that do not reach it */
};

/* Decides lights for the closed cells of a square, into `known`. Returns the cells for which all lights are decided. */
uint32_t mlrt_shade_cells(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_bundle *seen,
                          struct mlrt_known_lights known[MLRT_CELL_COUNT]);

/*
 * Finds and writes which lights do not reach the hits of a tile. `known`: the lights decided for the whole tile, or
 * NULL.
 */
void mlrt_shade_tile(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_ray_tile *tile,
                     const struct mlrt_known_lights *known);

#endif
