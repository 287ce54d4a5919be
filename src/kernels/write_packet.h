/* SPDX-License-Identifier: MIT */
/*
 * The results of a packet on their way out: its triangles are turned into ids and numbers a vector at a time. Where
 * they go is output.h's.
 */

#include "hit_numbers.h"

/* Turns the triangle numbers of a packet into ids, if all are of the mesh that was last seen: 0 if not. */
MLRT_INLINE int find_packet_ids(const struct mlrt_tree *tree, uint32_t mesh, const struct mlrt_packet *packet,
                                uint32_t meshes[MLRT_PACKET_RAYS], uint32_t triangles[MLRT_PACKET_RAYS])
{
    const vi first = i_set1(tree->mesh_first[mesh]), none = i_set1(MLRT_NONE), id = i_set1(tree->mesh_ids[mesh]);
    const vi count = i_set1(tree->mesh_first[mesh + 1] - tree->mesh_first[mesh]);
    uint32_t found = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vi number = i_load(packet->triangle + v), place = i_sub(number, first);
        const vm hit = i_lt(place, count);
        i_store(meshes + v, i_select(hit, id, none));
        i_store(triangles + v, i_select(hit, place, none));
        found |= m_bits(m_or(hit, i_eq(number, none))) << v;
    }
    return found == 0xFFFF;
}

/* Writes the ids of a packet's lanes. `hit`: those with a hit. */
static void write_ids(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_packet *packet,
                      uint32_t hit, uint32_t lanes, uint32_t x, uint32_t y, const struct mlrt_sink *sink)
{
    MLRT_ALIGNED(64) uint32_t meshes[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) uint32_t triangles[MLRT_PACKET_RAYS];
    if (!job->tree->mesh_count || !find_packet_ids(job->tree, worker->mesh, packet, meshes, triangles)) {
        if (hit) worker->mesh = mlrt_mesh_of_triangle(job->tree, packet->triangle[mlrt_lowest_bit(hit)]);
        mlrt_find_packet_ids(job->tree, packet, meshes, triangles);
    }
    if (sink->channel[MLRT_CHANNEL_MESH].data) mlrt_write_words(meshes, lanes, x, y, MLRT_CHANNEL_MESH, sink);
    if (sink->channel[MLRT_CHANNEL_TRIANGLE].data) {
        mlrt_write_words(triangles, lanes, x, y, MLRT_CHANNEL_TRIANGLE, sink);
    }
}

static void write_numbers(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_packet *packet,
                          uint32_t hit, uint32_t lanes, uint32_t x, uint32_t y, uint32_t outputs,
                          const struct mlrt_sink *sink)
{
    struct packet_numbers numbers;
    const void *values[MLRT_CHANNEL_COUNT] = {numbers.t, numbers.uv[0], numbers.uv[1], NULL, NULL, numbers.facing};
    report_packet(job->tree, packet, hit, outputs, &worker->hit_terms, &numbers);
    for (int c = 0; c < MLRT_CHANNEL_OCCLUDED; ++c) {
        if (!values[c] || !sink->channel[c].data) continue;
        mlrt_write_words(values[c], lanes, x, y, (enum mlrt_channel)c, sink);
    }
}

/* Writes the hits of a packet's lanes, whose block starts at (x, y) of the sink; `hit`: those with one. */
static MLRT_NOINLINE void write_hits(const struct mlrt_job *job, struct mlrt_worker *worker,
                                     const struct mlrt_packet *packet, uint32_t hit, uint32_t lanes, uint32_t x,
                                     uint32_t y, const struct mlrt_sink *sink)
{
    const uint32_t outputs = mlrt_sink_numbers(sink);
    if (sink->channel[MLRT_CHANNEL_MESH].data || sink->channel[MLRT_CHANNEL_TRIANGLE].data) {
        write_ids(job, worker, packet, hit, lanes, x, y, sink);
    }
    if (outputs) write_numbers(job, worker, packet, hit, lanes, x, y, outputs, sink);
}

MLRT_INLINE void write_to_sink(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_packet *packet,
                               uint32_t lanes, uint32_t x, uint32_t y, const struct mlrt_sink *sink)
{
    const uint32_t hit = lanes & ~lanes_of_triangle(packet, MLRT_NONE);
    if (!job->any) {
        write_hits(job, worker, packet, hit, lanes, x, y, sink);
    } else if (sink->channel[MLRT_CHANNEL_OCCLUDED].data) {
        mlrt_write_occluded(hit, lanes, x, y, sink);
    }
}

static void write_packet(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_packet *packet,
                         uint32_t lanes, const struct mlrt_rectangle *block)
{
    if (job->has_frame) write_to_sink(job, worker, packet, lanes, block->x, block->y, &job->frame);
    if (job->callback) {
        write_to_sink(job, worker, packet, lanes, block->x - worker->tile_x, block->y - worker->tile_y, &worker->tile);
    }
}
