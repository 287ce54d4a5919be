/* SPDX-License-Identifier: MIT */
/*
 * Reads rays from the caller's arrays, of any strides, a whole block of 4x4 rays at a time, with vectors. Blocks that
 * are cut off, and sources where blocks share origins unevenly are read by source.c.
 */
#ifndef MLRT_RAYS_READ_ARRAYS_H
#define MLRT_RAYS_READ_ARRAYS_H

#include <math.h>

#include "rays/array_layout.h"
#include "rays/packet.h"
#include "scene/triangle_numbers.h"
#include "simd/simd.h"

/* The offset of the element of a packet's lane from that of lane 0. */
MLRT_INLINE size_t offset_of_lane(const struct mlrt_array_layout *layout, int lane)
{
    return mlrt_lane_offset((uint32_t)lane, layout->step, layout->row_step);
}

/*
 * Reads three words of each lane into `rows`, and the word behind them into `fourth`, if that is not NULL. Unless
 * `from` is NULL, it is subtracted from the vectors, here and not in a second pass, since loads of words just stored
 * are slow.
 */
static MLRT_NOINLINE void read_vectors_apart(const struct mlrt_array_layout *layout, const unsigned char *first,
                                             const float *from, float (*rows)[MLRT_PACKET_RAYS], float *fourth)
{
    const size_t step = layout->step, row_step = layout->row_step;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const unsigned char *at = first + offset_of_lane(layout, v);
        vf words[4] = {v_set1(0), v_set1(0), v_set1(0), v_set1(0)};
        if (layout->has_word)
            v_quads_at(at, step, row_step, words);
        else
            v_triples_at(at, step, row_step, words);
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) v_store(rows[k] + v, from ? v_sub(words[k], v_set1(from[k])) : words[k]);
        if (fourth) v_store(fourth + v, words[3]);
    }
}

/*
 * Reads structs of origin, a word, direction and a word. The words go to t_min and t_max; if they are not these limits,
 * read_whole_block reads the limits afterwards.
 */
static MLRT_NOINLINE void read_structs(const struct mlrt_array_layout *points, const unsigned char *first,
                                       struct mlrt_packet *packet)
{
    const size_t step = points->step, row_step = points->row_step;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const unsigned char *at = first + offset_of_lane(points, v);
        vf origin[4], direction[4];
        v_quads_at(at, step, row_step, origin);
        v_quads_at(at + 16, step, row_step, direction);
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) {
            v_store(packet->origin[k] + v, origin[k]);
            v_store(packet->direction[k] + v, direction[k]);
        }
        v_store(packet->t_min + v, origin[3]);
        v_store(packet->t_max + v, direction[3]);
    }
}

/* As read_vectors_apart, and faster where vectors follow each other without a gap, or all lanes share one. */
static MLRT_NOINLINE void read_vectors(const struct mlrt_array_layout *layout, const unsigned char *first,
                                       const float *from, float (*rows)[MLRT_PACKET_RAYS], float *fourth)
{
    const float *one = (const float *)(const void *)first;
    const int is_packed = layout->step == 12; /* so no word behind a vector is to be read */
    if (!is_packed && layout->step) {
        read_vectors_apart(layout, first, from, rows, fourth);
        return;
    }
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vf words[3] = {v_set1(one[0]), v_set1(one[1]), v_set1(one[2])};
        if (is_packed) v_triples(first + offset_of_lane(layout, v), layout->row_step, words);
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) v_store(rows[k] + v, from ? v_sub(words[k], v_set1(from[k])) : words[k]);
        if (fourth) v_store(fourth + v, v_set1(one[3]));
    }
}

static MLRT_NOINLINE void read_floats_of(const struct mlrt_array_layout *layout, size_t element, float *row)
{
    const unsigned char *first = layout->data + element * layout->stride;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW)
        v_store(row + v, v_floats_at(first + offset_of_lane(layout, v), layout->step, layout->row_step));
}

/* Reads a number of each lane; `standard` if there is no array. */
MLRT_INLINE void read_floats(const struct mlrt_array_layout *layout, size_t element, float standard, float *row)
{
    if (layout->data) {
        read_floats_of(layout, element, row);
    } else {
        for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) v_store(row + v, v_set1(standard));
    }
}

/* The mesh that was looked up last, and its triangles; NO_MESH before the first. */
struct known_mesh {
    uint32_t id;
    struct mlrt_mesh_range range;
};

#define NO_MESH ((struct known_mesh){MLRT_NONE, {0, 0}})

/* Makes *known the mesh with this id. */
MLRT_INLINE void find_mesh(const struct mlrt_tree *tree, uint32_t id, struct known_mesh *known)
{
    if (known->id != id) *known = (struct known_mesh){id, mlrt_find_mesh(tree, id)};
}

/*
 * Reads the triangles that the rays of a block skip: pairs of a mesh and a triangle of it, which become numbers mesh by
 * mesh, since neighbours mostly skip triangles of one mesh, or none.
 */
static void read_skips(const struct mlrt_array_layout *skip, size_t element, const struct mlrt_tree *tree,
                       struct known_mesh *known, struct mlrt_packet *packet)
{
    MLRT_ALIGNED(64) uint32_t mesh[MLRT_PACKET_RAYS];
    const unsigned char *first = skip->data + element * skip->stride;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vi meshes, triangles;
        i_pairs_at(first + offset_of_lane(skip, v), skip->step, skip->row_step, &meshes, &triangles);
        i_store(mesh + v, meshes);
        i_store(packet->skip + v, triangles);
    }
    for (uint32_t left = 0xFFFF; left;) {
        find_mesh(tree, mesh[mlrt_lowest_bit(left)], known);
        const vi none = i_set1(MLRT_NONE), count = i_set1(known->range.count),
                 minus_first = i_set1(0u - known->range.first);
        for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
            const vi triangle = i_load(packet->skip + v);
            const vm same = m_and(m_from_bits(left >> v), i_eq(i_load(mesh + v), i_set1(known->id)));
            const vi number = i_select(i_lt(triangle, count), i_sub(triangle, minus_first), none);
            i_store(packet->skip + v, i_select(same, number, triangle));
            left &= ~(m_bits(same) << v);
        }
    }
}

static void read_whole_block(const struct mlrt_array_reader *reader, uint32_t x, uint32_t y, struct known_mesh *known,
                             struct mlrt_packet *packet)
{
    const struct mlrt_source *source = reader->source;
    const size_t ray = (size_t)y * source->width + x;
    const size_t group = source->arrays.rays_per_origin, origin = group > 1 ? ray / group : ray;
    const unsigned char *points = reader->points.data + origin * reader->points.stride;
    const unsigned char *directions = reader->directions.data + ray * reader->directions.stride;
    float *t_min = reader->points_have_t_min ? packet->t_min : NULL;
    float *t_max = reader->directions_have_t_max ? packet->t_max : NULL;
    mlrt_begin_packet(source, packet);
    if (packet->has.apex) {
        read_vectors(&reader->points, points, source->light, packet->direction, t_min);
    } else if (reader->are_structs) {
        read_structs(&reader->points, points, packet);
    } else {
        read_vectors(&reader->points, points, NULL, packet->origin, t_min);
        read_vectors(&reader->directions, directions, NULL, packet->direction, t_max);
    }
    if (!t_min) read_floats(&reader->t_min, origin, 0, packet->t_min);
    if (!t_max) read_floats(&reader->t_max, ray, packet->has.apex ? 1 : INFINITY, packet->t_max);
    if (MLRT_UNLIKELY(packet->has.masks)) mlrt_fetch_masks(source, x, y, 0xFFFF, packet);
    if (packet->has.skip) read_skips(&reader->skip, origin, source->tree, known, packet);
}

#endif
