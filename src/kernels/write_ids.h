/* SPDX-License-Identifier: MIT */
/*
 * Ids of whole packets on their way out, a vector at a time: the usual case of output.h, where nothing else is wanted,
 * all hits are of one mesh, and elements lie side by side.
 */

/* The lanes of a packet by rows of its block: pairs are neighbours. */
static const uint8_t lane_pairs[4][2] = {{0, 4}, {2, 6}, {8, 12}, {10, 14}};

MLRT_INLINE void write_block(const uint32_t values[MLRT_PACKET_RAYS], uint32_t x, uint32_t y, enum mlrt_channel c,
                             const struct mlrt_sink *sink)
{
    const size_t row_stride = sink->channel[c].row_stride;
    unsigned char *at = sink->channel[c].data + (size_t)y * row_stride + (size_t)x * sizeof *values;
    for (int row = 0; row < 4; ++row, at += row_stride) {
        memcpy(at, values + lane_pairs[row][0], 2 * sizeof *values);
        memcpy(at + 2 * sizeof *values, values + lane_pairs[row][1], 2 * sizeof *values);
    }
}

MLRT_INLINE int is_simple_sink(const struct mlrt_sink *sink)
{
    return mlrt_sink_wants_ids_only(sink) && !sink->channel[MLRT_CHANNEL_OCCLUDED].data &&
           (!sink->channel[MLRT_CHANNEL_MESH].data || sink->channel[MLRT_CHANNEL_MESH].stride == 4) &&
           (!sink->channel[MLRT_CHANNEL_TRIANGLE].data || sink->channel[MLRT_CHANNEL_TRIANGLE].stride == 4);
}

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

/* Writes a whole packet to a sink of ids: 0 if that takes mlrt_write_packet. */
static int write_whole_packet(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_packet *packet,
                              uint32_t x, uint32_t y, const struct mlrt_sink *sink)
{
    MLRT_ALIGNED(64) uint32_t meshes[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) uint32_t triangles[MLRT_PACKET_RAYS];
    if (!job->tree->mesh_count) return 0;
    if (!find_packet_ids(job->tree, worker->mesh, packet, meshes, triangles)) {
        worker->mesh = mlrt_mesh_of_triangle(job->tree, packet->triangle[0]);
        if (!find_packet_ids(job->tree, worker->mesh, packet, meshes, triangles)) return 0;
    }
    if (sink->channel[MLRT_CHANNEL_MESH].data) write_block(meshes, x, y, MLRT_CHANNEL_MESH, sink);
    if (sink->channel[MLRT_CHANNEL_TRIANGLE].data) write_block(triangles, x, y, MLRT_CHANNEL_TRIANGLE, sink);
    return 1;
}

static void write_to_sink(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_packet *packet,
                          uint32_t lanes, uint32_t x, uint32_t y, const struct mlrt_sink *sink)
{
    if (lanes == 0xFFFF && is_simple_sink(sink) && write_whole_packet(job, worker, packet, x, y, sink)) return;
    mlrt_write_packet(job->tree, packet, lanes, x, y, sink);
}
