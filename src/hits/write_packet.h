/* SPDX-License-Identifier: MIT */
/*
 * Writes the results of packets: the triangles that they hit become ids and numbers, a vector at a time, which are
 * stored here, if the caller's arrays are packed, or by write_arrays.h.
 */
#ifndef MLRT_HITS_WRITE_PACKET_H
#define MLRT_HITS_WRITE_PACKET_H

#include "hits/hit_numbers.h"
#include "hits/outcome.h"
#include "job/sink.h"
#include "job/write_arrays.h"
#include "job/job.h"
#include "rays/rectangle.h"
#include "scene/triangle_numbers.h"
#include "simd/simd.h"
#include "simd/sixteen.h"

/*
 * Sets the ids of the lanes that hit a triangle of mesh `mesh` (a position), and returns these lanes. Other lanes get
 * the ids of a miss with `is_first`, and otherwise keep theirs.
 */
MLRT_INLINE uint32_t find_ids_in_mesh(const struct mlrt_tree *tree, uint32_t mesh, const struct mlrt_packet *packet,
                                      int is_first, struct mlrt_packet_values *values)
{
    const vi first = i_set1(tree->meshes.first[mesh]), none = i_set1(MLRT_NONE), id = i_set1(tree->meshes.ids[mesh]);
    const vi count = i_set1(tree->meshes.first[mesh + 1] - tree->meshes.first[mesh]);
    uint32_t found = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vi place = i_sub(i_load(packet->nearest.triangle + v), first);
        const vm hit = i_lt(place, count);
        i_store(values->mesh + v, i_select(hit, id, is_first ? none : i_load(values->mesh + v)));
        i_store(values->triangle + v, i_select(hit, place, is_first ? none : i_load(values->triangle + v)));
        found |= m_bits(hit) << v;
    }
    return found;
}

/*
 * Sets the ids of the lanes `hit`, mesh by mesh, and of a miss in the others. The mesh that was hit last comes first,
 * as neighbours mostly hit it. A tree may have no mesh, and then no lane has a hit.
 */
MLRT_INLINE void find_packet_ids(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t hit,
                                 uint32_t *last_mesh, struct mlrt_packet_values *values)
{
    if (MLRT_UNLIKELY(!hit)) {
        mlrt_fill_words(values->mesh, MLRT_NONE);
        mlrt_fill_words(values->triangle, MLRT_NONE);
        return;
    }
    uint32_t left = hit & ~find_ids_in_mesh(tree, *last_mesh, packet, 1, values);
    while (MLRT_UNLIKELY(left)) {
        *last_mesh = mlrt_mesh_of_triangle(tree, packet->nearest.triangle[mlrt_lowest_bit(left)]);
        left &= ~find_ids_in_mesh(tree, *last_mesh, packet, 0, values);
    }
}

#define PACKETS_OF_ROW 4

/*
 * Packets whose blocks lie side by side. Their results are written together: a row of a tile is then a line of the
 * cache, which is written at once and not in four parts with many other lines in between.
 */
struct row_of_packets {
    const struct mlrt_packet *packet[PACKETS_OF_ROW];
    uint32_t lanes[PACKETS_OF_ROW]; /* that exist */
    uint32_t count;
    struct mlrt_rectangle first; /* block */
};

/* Adds the packet of a block to a row: the block lies beside the last one. */
MLRT_INLINE void add_to_row(const struct mlrt_packet *packet, uint32_t lanes, const struct mlrt_rectangle *block,
                            struct row_of_packets *row)
{
    if (!row->count) row->first = *block;
    row->packet[row->count] = packet;
    row->lanes[row->count++] = lanes;
}

/* Writes the values of a row of packets to the channels of a group. */
MLRT_INLINE void write_group_of_row(const struct row_of_packets *row, const struct mlrt_packet_values *values,
                                    const struct mlrt_sink *sink, const struct mlrt_sink_group *group)
{
    struct mlrt_rectangle block = row->first;
    const int is_whole =
        row->count == PACKETS_OF_ROW && (row->lanes[0] & row->lanes[1] & row->lanes[2] & row->lanes[3]) == 0xFFFF;
    if (is_whole && group->image.stride == 4) {
        const unsigned char *first = (const unsigned char *)values + sizeof values->t * group->channel[0];
        v_store_rows((const float *)(const void *)first, sizeof *values / sizeof *values->t,
                     mlrt_find_corner(sink, &group->image, &block), group->image.row_stride);
        return;
    }
    for (uint32_t i = 0; i < row->count; ++i, block.x += 4)
        mlrt_write_group(&values[i], row->lanes[i], &block, sink, group);
}

/* Writes the results of a row of packets to a sink. */
static MLRT_NOINLINE void write_to_sink(const struct mlrt_job *job, struct mlrt_worker *worker,
                                        const struct row_of_packets *row, const struct mlrt_sink *sink)
{
    struct mlrt_packet_values values[PACKETS_OF_ROW];
    struct mlrt_rectangle block = row->first;
    for (uint32_t i = 0; i < row->count; ++i, block.x += 4) {
        const struct mlrt_packet *packet = row->packet[i];
        const uint32_t lanes = row->lanes[i], hit = lanes & ~lanes_of_triangle(packet, MLRT_NONE);
        if (job->any) {
            mlrt_write_occluded(hit, lanes, &block, sink);
            continue;
        }
        if (sink->channel[MLRT_CHANNEL_MESH].data || sink->channel[MLRT_CHANNEL_TRIANGLE].data)
            find_packet_ids(job->tree, packet, hit, &worker->mesh, &values[i]);
        if (sink->numbers) report_packet(job->tree, packet, hit, sink->numbers, &worker->hit_terms, &values[i]);
    }
    for (uint32_t i = 0; i < sink->group_count && !job->any; ++i)
        write_group_of_row(row, values, sink, &sink->groups[i]);
}

/* Writes the results of a row of packets to the frame and to the callback's tile. Empties the row. */
static void write_row(const struct mlrt_job *job, struct mlrt_worker *worker, struct row_of_packets *row)
{
    for (uint32_t i = 0; i < worker->sinks.count && row->count; ++i)
        write_to_sink(job, worker, row, worker->sinks.each[i]);
    row->count = 0;
}

/* Writes the results of a packet's lanes. */
static void write_packet(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_packet *packet,
                         uint32_t lanes, const struct mlrt_rectangle *block)
{
    struct row_of_packets row = {.count = 0};
    add_to_row(packet, lanes, block, &row);
    write_row(job, worker, &row);
}

#endif
