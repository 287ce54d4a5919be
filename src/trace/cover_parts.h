/* SPDX-License-Identifier: MIT */
/*
 * Triangles that together hide all rays of a cell, where any hit will do: walls are mostly cut into triangles, and a
 * cell lies across the edges between them. A cell of arrays that such a triangle hides in part stays closed, and waits
 * for the others. See L22 of docs/accuracy.md, "Bundles".
 */
#ifndef MLRT_TRACE_COVER_PARTS_H
#define MLRT_TRACE_COVER_PARTS_H

#include "trace/cells.h"

/* Does a ray of a cell skip a triangle? */
typedef int mlrt_cell_test(const struct mlrt_array_cells *cells, uint32_t place, uint32_t number);

/* Packets to which a triangle was offered. */
struct mlrt_offered_packets {
    uint32_t may;      /* rays may hit it, also those of closed packets */
    uint32_t covered;  /* it is their cover now */
    uint32_t in_part;  /* closed: D has one sign for all rays, and all look for hits where they meet its plane */
    uint32_t backward; /* D is negative, of those of in_part */
};

/*
 * Adds a triangle to what hides the cells offered->in_part. parts->open[i] has the cells for which its edge i is open:
 * not all of their rays are known to pass inside it. Takes cells that wait now out of offered->may. Where all rays of a
 * cell are hidden now, sets its cover, and adds it to offered->covered.
 */
void mlrt_add_cover_part(struct mlrt_bundle *bundle, const struct mlrt_bundle_leaf *leaf, uint32_t triangle,
                         mlrt_cell_test *skips, struct mlrt_cover_parts *parts, struct mlrt_offered_packets *offered);

/* Opens the cells that still wait when all triangles have been offered. */
void mlrt_end_cover_parts(struct mlrt_bundle *bundle, struct mlrt_cover_parts *parts);

#endif
