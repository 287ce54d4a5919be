/* SPDX-License-Identifier: MIT */
/*
 * Reads rays from the caller's arrays, of any strides, a whole block of 4x4 rays at a time, with vectors. Blocks that
 * are cut off, rays with masks, and sources where blocks share origins unevenly are read by source.c.
 */
#ifndef MLRT_RAYS_READ_ARRAYS_H
#define MLRT_RAYS_READ_ARRAYS_H

#include <math.h>
#include <string.h>

#include "rays/check_packet.h"
#include "simd/simd.h"

/* Where the elements of a block lie in an array. Distances are in bytes. */
struct array_layout {
    const unsigned char *data;
    size_t stride;   /* between elements; 0: all rays share one */
    size_t step;     /* between neighbours in a row of a block; 0: they share one element */
    size_t row_step; /* between the rows of a block */
    int is_packed;   /* the step is 12, so that vectors of three floats follow each other without a gap */
    int has_word;    /* the word behind each element belongs to another array, so it may be read too */
};

/* The layouts of a source's arrays: the same for all blocks of a tile. */
struct array_reader {
    const struct mlrt_source *source;
    struct array_layout points;
    struct array_layout directions;
    struct array_layout t_min;
    struct array_layout t_max;
    struct array_layout skip;
    int points_have_t_min;     /* the word behind each point is its t_min */
    int directions_have_t_max; /* the word behind each direction is its t_max */
    int are_structs;           /* each direction follows the word behind its point */
};

static void lay_out_array(const mlrt_const_array *array, uint32_t group, size_t row_length, struct array_layout *layout)
{
    layout->data = array->data;
    layout->stride = array->data ? array->stride : 0;
    layout->step = group > 1 ? 0 : layout->stride;
    layout->row_step = layout->step * row_length;
    layout->is_packed = layout->step == 12;
    layout->has_word = 0;
}

/*
 * Is the word behind each element of `array`, which takes twelve bytes, the start of an element of `other`? With a
 * stride of 12 that word would belong to the next element of `array`.
 */
static int is_followed_by(const struct array_layout *array, const struct array_layout *other)
{
    return array->data && other->data == array->data + 12 && array->stride > 12 && array->stride == other->stride &&
           array->step == other->step;
}

/*
 * Sets up the reader of a source. Returns 0 if whole blocks cannot be read: for a camera, and if the number of rays per
 * origin is neither 1 nor a multiple of a packet's rays.
 */
static int begin_reading(const struct mlrt_source *source, struct array_reader *reader)
{
    const uint32_t group = source->arrays.rays_per_origin;
    const int is_rays = source->kind == MLRT_SOURCE_RAYS;
    static const mlrt_const_array none;
    const mlrt_const_array light = {source->light, 0}; /* of a directional light: the direction of all rays */
    if (source->kind == MLRT_SOURCE_CAMERA || (group > 1 && group % MLRT_PACKET_RAYS != 0)) return 0;
    reader->source = source;
    lay_out_array(&source->arrays.points, group, source->width, &reader->points);
    lay_out_array(&source->arrays.skip, group, source->width, &reader->skip);
    lay_out_array(is_rays ? &source->arrays.t_min : &none, group, source->width, &reader->t_min);
    lay_out_array(is_rays ? &source->arrays.directions : &light, 1, source->width, &reader->directions);
    lay_out_array(is_rays ? &source->arrays.t_max : &none, 1, source->width, &reader->t_max);
    reader->points_have_t_min = is_followed_by(&reader->points, &reader->t_min);
    reader->directions_have_t_max = is_followed_by(&reader->directions, &reader->t_max);
    reader->points.has_word = reader->points_have_t_min || is_followed_by(&reader->points, &reader->t_max) ||
                              is_followed_by(&reader->points, &reader->directions) ||
                              is_followed_by(&reader->points, &reader->skip);
    reader->directions.has_word =
        reader->directions_have_t_max || is_followed_by(&reader->directions, &reader->t_min) ||
        is_followed_by(&reader->directions, &reader->points) || is_followed_by(&reader->directions, &reader->skip);
    reader->are_structs = reader->points.has_word && reader->directions.has_word &&
                          reader->directions.data == reader->points.data + 16 &&
                          reader->directions.step == reader->points.step;
    return 1;
}

/* The offset of the element of a packet's lane from that of lane 0. */
MLRT_INLINE size_t offset_of_lane(const struct array_layout *layout, int lane)
{
    return (size_t)((lane & 1) | (lane >> 1 & 2)) * layout->step +
           (size_t)((lane >> 1 & 1) | (lane >> 2 & 2)) * layout->row_step;
}

/*
 * Reads three words of each lane into `rows`, and the word behind them into `fourth`, if that is not NULL. Unless
 * `from` is NULL, it is subtracted from the vectors, here and not in a second pass, since loads of words just stored
 * are slow.
 */
static MLRT_NOINLINE void read_vectors_apart(const struct array_layout *layout, const unsigned char *first,
                                             const float *from, float (*rows)[MLRT_PACKET_RAYS], float *fourth)
{
    const size_t step = layout->step, row_step = layout->row_step;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const unsigned char *at = first + offset_of_lane(layout, v);
        vf words[4] = {v_set1(0), v_set1(0), v_set1(0), v_set1(0)};
        if (layout->has_word) {
            v_quads_at(at, step, row_step, words);
        } else {
            v_triples_at(at, step, row_step, words);
        }
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) v_store(rows[k] + v, from ? v_sub(words[k], v_set1(from[k])) : words[k]);
        if (fourth) v_store(fourth + v, words[3]);
    }
}

/*
 * Reads structs of origin, a word, direction and a word. The words go to t_min and t_max; if they are not these limits,
 * read_whole_block reads the limits afterwards.
 */
static MLRT_NOINLINE void read_structs(const struct array_layout *points, const unsigned char *first,
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

MLRT_INLINE void read_vectors(const struct array_layout *layout, const unsigned char *first, const float *from,
                              float (*rows)[MLRT_PACKET_RAYS], float *fourth)
{
    const float *one = (const float *)(const void *)first;
    if (!layout->is_packed && layout->step) {
        read_vectors_apart(layout, first, from, rows, fourth);
        return;
    }
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vf words[3] = {v_set1(one[0]), v_set1(one[1]), v_set1(one[2])};
        if (layout->is_packed) v_triples(first + offset_of_lane(layout, v), layout->row_step, words);
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) v_store(rows[k] + v, from ? v_sub(words[k], v_set1(from[k])) : words[k]);
        if (fourth) v_store(fourth + v, v_set1(one[3]));
    }
}

static MLRT_NOINLINE void read_floats_of(const struct array_layout *layout, size_t element, float *row)
{
    const unsigned char *first = layout->data + element * layout->stride;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        v_store(row + v, v_floats_at(first + offset_of_lane(layout, v), layout->step, layout->row_step));
    }
}

/* Reads a number of each lane; `standard` if there is no array. */
MLRT_INLINE void read_floats(const struct array_layout *layout, size_t element, float standard, float *row)
{
    if (layout->data) {
        read_floats_of(layout, element, row);
    } else {
        for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) v_store(row + v, v_set1(standard));
    }
}

/*
 * Reads the triangles that the rays of a block skip: pairs of mesh and triangle become numbers. Neighbours mostly skip
 * triangles of one mesh, or none, so that case is fast.
 */
static void read_skips(const struct array_layout *skip, size_t element, const struct mlrt_tree *tree,
                       struct known_mesh *known, struct mlrt_packet *packet)
{
    const unsigned char *first = skip->data + element * skip->stride;
    uint32_t mesh, others = 0;
    memcpy(&mesh, first, sizeof mesh);
    find_mesh(tree, mesh, known);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vi meshes, triangles;
        i_pairs_at(first + offset_of_lane(skip, v), skip->step, skip->row_step, &meshes, &triangles);
        others |= ~m_bits(i_eq(meshes, i_set1(mesh))) & ALL_LANES;
        i_store(packet->skip_mesh + v, meshes);
        i_store(packet->skip + v, others ? triangles : numbers_in_mesh(known, triangles));
        if (MLRT_LIKELY(!others)) continue;
        for (int w = 0; w < v; w += VW) { /* replaces the numbers found so far by triangles as given */
            i_pairs_at(first + offset_of_lane(skip, w), skip->step, skip->row_step, &meshes, &triangles);
            i_store(packet->skip + w, triangles);
        }
    }
    if (MLRT_UNLIKELY(others)) mlrt_number_skips(tree, packet);
}

/* Reads the rays of a whole block, of a source without masks. */
static void read_whole_block(const struct array_reader *reader, uint32_t x, uint32_t y, struct known_mesh *known,
                             struct mlrt_packet *packet)
{
    const struct mlrt_source *source = reader->source;
    const size_t ray = (size_t)y * source->width + x;
    const size_t origin = source->arrays.rays_per_origin == 1 ? ray : ray / source->arrays.rays_per_origin;
    const unsigned char *points = reader->points.data + origin * reader->points.stride;
    const unsigned char *directions = reader->directions.data + ray * reader->directions.stride;
    float *t_min = reader->points_have_t_min ? packet->t_min : NULL;
    float *t_max = reader->directions_have_t_max ? packet->t_max : NULL;
    packet->has_apex = source->kind == MLRT_SOURCE_POINT_LIGHT;
    if (packet->has_apex) {
        read_vectors(&reader->points, points, source->light, packet->direction, t_min);
        memcpy(packet->apex, source->light, sizeof packet->apex);
    } else if (reader->are_structs) {
        read_structs(&reader->points, points, packet);
    } else {
        read_vectors(&reader->points, points, NULL, packet->origin, t_min);
        read_vectors(&reader->directions, directions, NULL, packet->direction, t_max);
    }
    if (!t_min) read_floats(&reader->t_min, origin, 0, packet->t_min);
    if (!t_max) read_floats(&reader->t_max, ray, packet->has_apex ? 1 : INFINITY, packet->t_max);
    packet->has_limits = reader->t_min.data || reader->t_max.data;
    packet->has_masks = 0;
    packet->has_skip = reader->skip.data != NULL;
    if (packet->has_skip) read_skips(&reader->skip, origin, source->tree, known, packet);
}

#endif
