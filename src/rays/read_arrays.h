/* SPDX-License-Identifier: MIT */
/*
 * The rays of a tile out of the caller's arrays, whatever their strides: a whole block a vector at a time. Blocks at the
 * end of a list, and those of which rows do not share elements evenly, are read by source.c.
 */
#ifndef MLRT_RAYS_READ_ARRAYS_H
#define MLRT_RAYS_READ_ARRAYS_H

#include <math.h>
#include <string.h>

#include "rays/check_packet.h"
#include "simd/simd.h"

/* How the elements of a block lie: neighbours of a row, and rows, in bytes apart. Elements of twelve bytes with nothing
 * between them are packed; behind some others a word follows that is an element of another array. */
struct array_layout {
    const unsigned char *data;
    size_t stride; /* between elements; 0: one serves all rays */
    size_t step;   /* between the neighbours of a block; 0 where they share elements */
    size_t row_step;
    int is_packed;
    int has_word; /* a word behind each element may be read, too */
};

/* The arrays of a source as its whole blocks are read: the same for all blocks of a tile. */
struct array_reader {
    const struct mlrt_source *source;
    struct array_layout points;
    struct array_layout directions;
    struct array_layout t_min;
    struct array_layout t_max;
    struct array_layout skip;
    int points_have_t_min; /* as the word behind them */
    int directions_have_t_max;
    int are_structs; /* directions follow the word behind the points */
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

/* Does an element of `other` follow each of these, twelve bytes from where it begins? Not where that is in the next one. */
static int is_followed_by(const struct array_layout *array, const struct array_layout *other)
{
    return array->data && other->data == array->data + 12 && array->stride > 12 && array->stride == other->stride &&
           array->step == other->step;
}

/* 0 if neighbours share origins in another way than sixteen at a time. */
static int begin_reading(const struct mlrt_source *source, struct array_reader *reader)
{
    const uint32_t group = source->rays_per_origin;
    const int is_rays = source->kind == MLRT_SOURCE_RAYS;
    static const mlrt_const_array none;
    const mlrt_const_array light = {source->light, 0}; /* the direction of all, if it is a directional one */
    if (source->kind == MLRT_SOURCE_CAMERA || (group > 1 && group % MLRT_PACKET_RAYS != 0)) return 0;
    reader->source = source;
    lay_out_array(&source->points, group, source->width, &reader->points);
    lay_out_array(&source->skip, group, source->width, &reader->skip);
    lay_out_array(is_rays ? &source->t_min : &none, group, source->width, &reader->t_min);
    lay_out_array(is_rays ? &source->directions : &light, 1, source->width, &reader->directions);
    lay_out_array(is_rays ? &source->t_max : &none, 1, source->width, &reader->t_max);
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

/* The column and row of a packet's lane. */
MLRT_INLINE size_t offset_of_lane(const struct array_layout *layout, int lane)
{
    return (size_t)((lane & 1) | (lane >> 1 & 2)) * layout->step +
           (size_t)((lane >> 1 & 1) | (lane >> 2 & 2)) * layout->row_step;
}

/*
 * Reads three words of each lane into rows of lanes, and that behind them, if there is one, into `fourth`. Of the vectors
 * `from` is subtracted, if it is not NULL: not afterwards, as what was just stored is not loaded as fast.
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

/* Reads structs of origin, a word, direction and another one. The words go where limits do: who has them elsewhere reads
 * these later. */
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

/* Reads a number of each lane; `standard` where there is no array. */
MLRT_INLINE void read_floats(const struct array_layout *layout, size_t element, float standard, float *row)
{
    if (layout->data) {
        read_floats_of(layout, element, row);
    } else {
        for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) v_store(row + v, v_set1(standard));
    }
}

/* What the rays of a block pass: pairs of mesh and triangle, as numbers. Neighbours mostly pass triangles of one mesh, or
 * nothing. */
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
        for (int w = 0; w < v; w += VW) { /* as they were given, again */
            i_pairs_at(first + offset_of_lane(skip, w), skip->step, skip->row_step, &meshes, &triangles);
            i_store(packet->skip + w, triangles);
        }
    }
    if (MLRT_UNLIKELY(others)) mlrt_number_skips(tree, packet);
}

/* Reads the rays of a whole block; not masks. */
static void read_whole_block(const struct array_reader *reader, uint32_t x, uint32_t y, struct known_mesh *known,
                             struct mlrt_packet *packet)
{
    const struct mlrt_source *source = reader->source;
    const size_t ray = (size_t)y * source->width + x;
    const size_t origin = source->rays_per_origin == 1 ? ray : ray / source->rays_per_origin;
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
