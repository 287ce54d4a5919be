/* SPDX-License-Identifier: MIT */
/*
 * Which lights reach what a picture's rays hit (mlrt.h, "Shadows of a picture"), in the tile method.
 */
#ifndef MLRT_TRACE_SHADOWS_H
#define MLRT_TRACE_SHADOWS_H

#include "trace/ray_tile.h"

/* What is known of a cell of the picture that one triangle covers: bit per light. */
struct mlrt_known_lights {
    uint32_t cover;
    uint8_t known;
    uint8_t dark; /* of those known, which do not reach it */
};

/* What is known of the lights at the closed cells of a square. Returns the cells of which all is known. */
uint32_t mlrt_shade_cells(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_bundle *seen,
                          struct mlrt_known_lights known[MLRT_CELL_COUNT]);

/* Finds and writes which lights do not reach what the rays of a tile hit. `known`: what is known of all of it, or NULL.
 */
void mlrt_shade_tile(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_ray_tile *tile,
                     const struct mlrt_known_lights *known);

#endif
