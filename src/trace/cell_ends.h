/* SPDX-License-Identifier: MIT */
/*
 * Where the rays of cells end or begin, cells being tiles of the caller's arrays without rays (array_cells.h): rays to
 * a light end on the surface that it shines on, and parallel rays begin there. Depths do not tell on which side of such
 * a surface that is, and where a wall is there twice, neighbouring rays skip different triangles.
 *
 * The ends of all rays of a cell lie in a box, which tells the side of planes that are nearly across an axis, as those
 * of most walls are (L21 of docs/accuracy.md, "Bundles").
 */
#ifndef MLRT_TRACE_CELL_ENDS_H
#define MLRT_TRACE_CELL_ENDS_H

#include "rays/extremes.h"
#include "rays/read_arrays.h"
#include "rays/rectangle.h"
#include "scene/triangle_numbers.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/cells.h"
#include "trace/leaf.h"

/* The tile of a square that a cell stands for. */
MLRT_INLINE struct mlrt_rectangle tile_of_cell(const struct mlrt_rectangle *area, uint32_t place)
{
    return mlrt_cut_piece(area, 16 * (place % 4), 16 * (place / 4), 16);
}

/* The first element of a block of a tile whose rays are whole rows of sixteen. */
MLRT_INLINE size_t element_of_block(const struct mlrt_array_cells *cells, const struct mlrt_rectangle *tile,
                                    uint32_t block)
{
    return ((size_t)tile->y + (block & ~3u)) * cells->reader.source->width + tile->x + 4 * (block & 3);
}

/* Reads the directions of a block, or the origins of parallel rays. */
MLRT_INLINE void read_points(const struct mlrt_array_cells *cells, size_t element, float (*rows)[MLRT_PACKET_RAYS])
{
    const struct mlrt_array_layout *vectors = cells->vectors;
    read_vectors(vectors, vectors->data + element * vectors->stride, cells->are_parallel ? NULL : cells->from, rows,
                 NULL);
}

/* The lanes of a block that skip the triangle of a mesh that `pair` tells. */
MLRT_INLINE uint32_t lanes_with_pair(const struct mlrt_array_layout *skip, size_t element, const uint32_t pair[2])
{
    uint32_t lanes = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vi meshes, triangles;
        i_pairs_at(skip->data + element * skip->stride + offset_of_lane(skip, v), skip->step, skip->row_step, &meshes,
                   &triangles);
        lanes |= m_bits(m_and(i_eq(meshes, i_set1(pair[0])), i_eq(triangles, i_set1(pair[1])))) << v;
    }
    return lanes;
}

/* Does a ray of a cell skip the triangle `number`? */
static MLRT_NOINLINE int cell_skips(const struct mlrt_array_cells *cells, uint32_t place, uint32_t number)
{
    const struct mlrt_rectangle tile = tile_of_cell(&cells->area, place);
    uint32_t pair[2];
    if (!cells->reader.skip.data) return 0;
    mlrt_find_ids(cells->reader.source->tree, number, &pair[0], &pair[1]);
    for (uint32_t block = 0; block < 16; ++block) {
        if (lanes_with_pair(&cells->reader.skip, element_of_block(cells, &tile, block), pair)) return 1;
    }
    return 0;
}

/*
 * As find_packets_apart (cover.h), of cells of arrays: returns those of `places` none of whose rays can hit the
 * triangle: all skip it, all end before its plane, or all begin behind it. With the sign of D, N - D is positive for a
 * ray that ends before the plane, and N negative for one that begins behind it.
 */
static MLRT_NOINLINE uint32_t find_cells_apart(const struct mlrt_tree *tree, const struct mlrt_bundle *bundle,
                                               const struct mlrt_bundle_leaf *leaf, uint32_t triangle, uint32_t places,
                                               uint32_t at_end, uint32_t backward)
{
    const struct mlrt_array_cells *cells = bundle->arrays;
    struct mlrt_plane_of_cells of;
    uint32_t apart = 0;
    places &= cells->are_parallel ? ~at_end : cells->have_ends ? at_end : 0;
    if (!places) return 0;
    const struct mlrt_triangle corners = triangle_of_leaf(tree, leaf, triangle);
    mlrt_see_plane_of_cells(cells, &corners, &of);
    if ((bundle->waist.sign < 0) != cells->are_parallel) backward = ~backward;
    for (; places; places &= places - 1) {
        const uint32_t place = mlrt_lowest_bit(places), bit = places & (0u - places);
        of.sign = backward & bit ? -1 : 1;
        if (bundle->hulls.closed.skip[place] == leaf->numbers[triangle] || mlrt_is_box_apart(&cells->ends[place], &of))
            apart |= bit;
    }
    return apart;
}

#endif
