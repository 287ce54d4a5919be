/* SPDX-License-Identifier: MIT */
/*
 * Writes the results of a packet: the triangles that it hits become ids and numbers, a vector at a time, and
 * write_arrays.h stores them.
 */
#ifndef MLRT_HITS_WRITE_PACKET_H
#define MLRT_HITS_WRITE_PACKET_H

#include "hits/hit_numbers.h"
#include "hits/outcome.h"
#include "job/write_arrays.h"
#include "job/job.h"
#include "rays/rectangle.h"
#include "simd/simd.h"

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
 * Sets the ids of the lanes `hit`, mesh by mesh. The mesh that was hit last comes first, as neighbours mostly hit it.
 */
MLRT_INLINE void find_packet_ids(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t hit,
                                 uint32_t *last_mesh, struct mlrt_packet_values *values)
{
    uint32_t left = hit & ~find_ids_in_mesh(tree, *last_mesh, packet, 1, values);
    while (MLRT_UNLIKELY(left)) {
        *last_mesh = mlrt_mesh_of_triangle(tree, packet->nearest.triangle[mlrt_lowest_bit(left)]);
        left &= ~find_ids_in_mesh(tree, *last_mesh, packet, 0, values);
    }
}

static MLRT_NOINLINE void write_to_sink(const struct mlrt_job *job, struct mlrt_worker *worker,
                                        const struct mlrt_packet *packet, uint32_t lanes,
                                        const struct mlrt_rectangle *block, const struct mlrt_sink *sink)
{
    const uint32_t hit = lanes & ~lanes_of_triangle(packet, MLRT_NONE);
    if (job->any) {
        mlrt_write_occluded(hit, lanes, block, sink);
        return;
    }
    struct mlrt_packet_values values;
    if (sink->channel[MLRT_CHANNEL_MESH].data || sink->channel[MLRT_CHANNEL_TRIANGLE].data) {
        find_packet_ids(job->tree, packet, hit, &worker->mesh, &values);
    }
    if (sink->numbers) report_packet(job->tree, packet, hit, sink->numbers, &worker->hit_terms, &values);
    mlrt_write_values(&values, lanes, block, sink);
}

/* Writes the results of a packet's lanes to the frame and to the callback's tile. */
static void write_packet(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_packet *packet,
                         uint32_t lanes, const struct mlrt_rectangle *block)
{
    for (uint32_t i = 0; i < worker->sinks.count; ++i) {
        write_to_sink(job, worker, packet, lanes, block, worker->sinks.each[i]);
    }
}

#endif
