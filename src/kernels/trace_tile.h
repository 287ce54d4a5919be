/* SPDX-License-Identifier: MIT */
/*
 * The levels: a tile has a beam, the beam an entry point; from there the tile is cut into smaller tiles with beams and
 * entry points of their own, until packets of 4x4 rays are traced from the last one.
 *
 * A tile whose rays differ in sign has no beam. It is cut as well, and packets of such a tile start where the tile above
 * them started.
 *
 * Based on: Reshetov et al. 2005, section 4.2.
 */

/* Lanes of a block that exist: in the last row of a list some may not. */
MLRT_INLINE uint32_t existing_lanes(const struct mlrt_source *source, uint32_t x, uint32_t y, uint32_t width,
                                    uint32_t height)
{
    uint32_t lanes = mlrt_block_lanes(width, height);
    const uint64_t past = (uint64_t)(y + height - 1) * source->width + x + width;
    if (MLRT_LIKELY(past <= source->count)) return lanes;
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        const uint64_t i = (uint64_t)(y + (uint32_t)mlrt_lane_y[lane]) * source->width + x + (uint32_t)mlrt_lane_x[lane];
        if (i >= source->count) lanes &= ~(1u << lane);
    }
    return lanes;
}

static void trace_single_rays(const struct mlrt_job *job, uint32_t lanes, struct mlrt_packet *packet,
                              mlrt_counters *counters)
{
    for (uint32_t lane = 0; lanes >> lane; ++lane) {
        if (!(lanes >> lane & 1)) continue;
        struct mlrt_ray_segment ray;
        mlrt_get_segment(packet, lane, &ray);
        COUNT(counters, packet_count, 1);
        packet->triangle[lane] = mlrt_trace_segment(job->tree, &ray, packet->has_skip ? packet->skip[lane] : MLRT_NONE,
                                                    job->any, MLRT_COUNTING ? counters : NULL);
    }
}

static void write_packet(const struct mlrt_job *job, struct mlrt_worker *worker, const struct mlrt_packet *packet,
                         uint32_t lanes, uint32_t x, uint32_t y)
{
    if (job->has_frame) mlrt_write_packet(job->tree, packet, lanes, x, y, &job->frame);
    if (job->callback) {
        mlrt_write_packet(job->tree, packet, lanes, x - worker->tile_x, y - worker->tile_y, &worker->tile);
    }
}

/* Traces a block of at most 4x4 rays from an entry point and writes the results. */
static void trace_block(const struct mlrt_job *job, struct mlrt_worker *worker, uint32_t x, uint32_t y, uint32_t width,
                        uint32_t height, const struct entry_point *entry)
{
    const uint32_t lanes = existing_lanes(&job->source, x, y, width, height);
    struct mlrt_packet packet;
    get_packet(&job->source, x, y, width, height, lanes, &packet);
    if (packet.has_apex && memcmp(packet.apex, worker->apex, sizeof packet.apex) != 0) {
        forget_setups(packet.apex, worker);
    }
    if (job->method == MLRT_METHOD_RAY || !job->tree->float_safe) {
        packet.single |= packet.active;
        packet.active = 0;
    }
    if (packet.active) {
        if (job->method == MLRT_METHOD_PACKET2) {
            traverse_masked(job, &packet, worker);
        } else {
            traverse_interval(job, entry, &packet, worker);
        }
    }
    if (packet.single) trace_single_rays(job, packet.single, &packet, &worker->counters);
    write_packet(job, worker, &packet, lanes, x, y);
}

static void trace_blocks(const struct mlrt_job *job, struct mlrt_worker *worker, uint32_t x, uint32_t y, uint32_t width,
                         uint32_t height, const struct entry_point *entry)
{
    for (uint32_t j = 0; j < height; j += 4) {
        for (uint32_t i = 0; i < width; i += 4) {
            const uint32_t block_width = width - i < 4 ? width - i : 4, block_height = height - j < 4 ? height - j : 4;
            trace_block(job, worker, x + i, y + j, block_width, block_height, entry);
        }
    }
}

static void write_misses(const struct mlrt_job *job, struct mlrt_worker *worker, uint32_t x, uint32_t y, uint32_t width,
                         uint32_t height)
{
    for (uint32_t j = y; j < y + height; ++j) {
        const uint64_t first = (uint64_t)j * job->source.width + x;
        if (first >= job->source.count) return;
        const uint64_t left = job->source.count - first;
        const uint32_t count = left < width ? (uint32_t)left : width;
        if (job->has_frame) mlrt_write_misses(x, j, count, &job->frame);
        if (job->callback) mlrt_write_misses(x - worker->tile_x, j - worker->tile_y, count, &worker->tile);
    }
}

/* Writes hits of one triangle: all that is left to do for a ray is its t, u and v, if somebody wants them. */
static void write_cover(const struct mlrt_job *job, struct mlrt_worker *worker, uint32_t number, uint32_t x, uint32_t y,
                        uint32_t width, uint32_t height)
{
    if (mlrt_sink_wants_ids_only(&job->frame) && mlrt_sink_wants_ids_only(&worker->tile)) {
        for (uint32_t j = y; j < y + height; ++j) {
            if (job->has_frame) mlrt_write_same_hits(job->tree, number, x, j, width, &job->frame);
            if (job->callback) {
                mlrt_write_same_hits(job->tree, number, x - worker->tile_x, j - worker->tile_y, width, &worker->tile);
            }
        }
        return;
    }
    for (uint32_t j = 0; j < height; j += 4) {
        for (uint32_t i = 0; i < width; i += 4) {
            const uint32_t block_width = width - i < 4 ? width - i : 4, block_height = height - j < 4 ? height - j : 4;
            const uint32_t lanes = mlrt_block_lanes(block_width, block_height);
            struct mlrt_packet packet;
            get_packet(&job->source, x + i, y + j, block_width, block_height, lanes, &packet);
            for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) i_store(packet.triangle + v, i_set1(number));
            write_packet(job, worker, &packet, lanes, x + i, y + j);
        }
    }
}

static struct entry_point root_entry(const struct mlrt_tree *tree)
{
    return (struct entry_point){0, 0, tree->bounds};
}

/* A tile of side at most `size`, whose rays may all start at `above`. */
static void trace_level(const struct mlrt_job *job, struct mlrt_worker *worker, uint32_t x, uint32_t y, uint32_t width,
                        uint32_t height, uint32_t size, const struct entry_point *above)
{
    struct mlrt_beam beam;
    struct entry_point entry = *above;
    int is_leaf = 0;
    if (mlrt_get_beam(&job->source, x, y, width, height, &beam)) {
        uint32_t cover;
        const int found = find_entry_point(job, &beam, &entry, &cover, &worker->counters);
        if (found == BEAM_MISSES) {
            COUNT(&worker->counters, missed_beam_count, 1);
            write_misses(job, worker, x, y, width, height);
            return;
        }
        if (found == BEAM_IS_COVERED) {
            COUNT(&worker->counters, covered_beam_count, 1);
            write_cover(job, worker, cover, x, y, width, height);
            return;
        }
        is_leaf = mlrt_node_is_leaf(&job->tree->nodes[entry.node]);
    }
    if (size <= job->minimum_tile_size || is_leaf) {
        COUNT(&worker->counters, entry_point_count, 1);
        COUNT(&worker->counters, entry_point_depth_sum, entry.depth);
        trace_blocks(job, worker, x, y, width, height, &entry);
        return;
    }
    uint32_t piece = size / job->split_divisor;
    if (piece < job->minimum_tile_size) piece = job->minimum_tile_size;
    for (uint32_t j = 0; j < height; j += piece) {
        for (uint32_t i = 0; i < width; i += piece) {
            const uint32_t piece_width = width - i < piece ? width - i : piece;
            const uint32_t piece_height = height - j < piece ? height - j : piece;
            trace_level(job, worker, x + i, y + j, piece_width, piece_height, piece, &entry);
        }
    }
}

static void trace_tile(const struct mlrt_job *job, struct mlrt_worker *worker, uint32_t x, uint32_t y, uint32_t width,
                       uint32_t height)
{
    const struct entry_point root = root_entry(job->tree);
    COUNT(&worker->counters, ray_count, (uint64_t)width * height);
    if (job->method == MLRT_METHOD_MULTILEVEL && job->tree->float_safe) {
        trace_level(job, worker, x, y, width, height, job->initial_tile_size, &root);
    } else {
        trace_blocks(job, worker, x, y, width, height, &root);
    }
}
