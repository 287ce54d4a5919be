/* SPDX-License-Identifier: MIT */
/*
 * Results on their way out. What nobody reads is not computed: the numbers of a hit (rule R5) are worked out here, once
 * per ray, and only for channels that a sink has.
 */
#include "output.h"

#include <math.h>
#include <string.h>

size_t mlrt_channel_size(enum mlrt_channel channel)
{
    return channel == MLRT_CHANNEL_OCCLUDED ? 1 : 4;
}

int32_t mlrt_make_sink(const mlrt_hits *hits, int any, uint32_t width, int packed_rows, struct mlrt_sink *sink)
{
    const mlrt_array arrays[MLRT_CHANNEL_COUNT] = {hits->t,        hits->u,      hits->v,       hits->mesh,
                                                   hits->triangle, hits->facing, hits->occluded};
    for (int c = 0; c < MLRT_CHANNEL_COUNT; ++c) {
        const mlrt_array *array = &arrays[c];
        const size_t size = mlrt_channel_size((enum mlrt_channel)c);
        const size_t stride = array->stride ? array->stride : size;
        const size_t row = packed_rows || !array->row_stride ? stride * width : array->row_stride;
        sink->channel[c].data = array->data;
        sink->channel[c].stride = stride;
        sink->channel[c].row_stride = row;
        if (!array->data) continue;
        if ((c == MLRT_CHANNEL_OCCLUDED) != (any != 0)) return MLRT_ERROR_ARGUMENT;
        if (stride < size || stride % size != 0 || row % size != 0 || (uintptr_t)array->data % size != 0) {
            return MLRT_ERROR_ARGUMENT;
        }
    }
    return MLRT_OK;
}

int mlrt_sink_is_empty(const struct mlrt_sink *sink)
{
    for (int c = 0; c < MLRT_CHANNEL_COUNT; ++c) {
        if (sink->channel[c].data) return 0;
    }
    return 1;
}

uint32_t mlrt_mesh_of_triangle(const struct mlrt_tree *tree, uint32_t number)
{
    uint32_t below = 0, above = tree->mesh_count;
    while (above - below > 1) {
        uint32_t middle = below + (above - below) / 2;
        if (tree->mesh_first[middle] <= number) {
            below = middle;
        } else {
            above = middle;
        }
    }
    return below;
}

void mlrt_get_segment(const struct mlrt_packet *packet, uint32_t lane, struct mlrt_ray_segment *ray)
{
    for (int k = 0; k < 3; ++k) {
        ray->origin[k] = packet->has_apex ? packet->apex[k] : packet->origin[k][lane];
        ray->direction[k] = packet->direction[k][lane];
    }
    ray->t_min = packet->t_min[lane];
    ray->t_max = packet->t_max[lane];
}

/* Everything there is to say about one ray. */
struct result {
    struct mlrt_hit_report report;
    uint32_t mesh;
    uint32_t triangle;
    uint8_t occluded;
};

static const struct result miss = {{INFINITY, 0, 0, 0}, MLRT_NONE, MLRT_NONE, 0};

static void *element(const struct mlrt_sink *sink, enum mlrt_channel c, uint32_t x, uint32_t y)
{
    return sink->channel[c].data + (size_t)y * sink->channel[c].row_stride + (size_t)x * sink->channel[c].stride;
}

static void write_result(const struct result *result, uint32_t x, uint32_t y, const struct mlrt_sink *sink)
{
    if (sink->channel[MLRT_CHANNEL_T].data) *(float *)element(sink, MLRT_CHANNEL_T, x, y) = result->report.t;
    if (sink->channel[MLRT_CHANNEL_U].data) *(float *)element(sink, MLRT_CHANNEL_U, x, y) = result->report.u;
    if (sink->channel[MLRT_CHANNEL_V].data) *(float *)element(sink, MLRT_CHANNEL_V, x, y) = result->report.v;
    if (sink->channel[MLRT_CHANNEL_MESH].data) *(uint32_t *)element(sink, MLRT_CHANNEL_MESH, x, y) = result->mesh;
    if (sink->channel[MLRT_CHANNEL_TRIANGLE].data) {
        *(uint32_t *)element(sink, MLRT_CHANNEL_TRIANGLE, x, y) = result->triangle;
    }
    if (sink->channel[MLRT_CHANNEL_FACING].data) {
        *(int32_t *)element(sink, MLRT_CHANNEL_FACING, x, y) = result->report.facing;
    }
    if (sink->channel[MLRT_CHANNEL_OCCLUDED].data) {
        *(uint8_t *)element(sink, MLRT_CHANNEL_OCCLUDED, x, y) = result->occluded;
    }
}

/* What mlrt_report_hit has to work out for a sink. */
static uint32_t wanted_numbers(const struct mlrt_sink *sink)
{
    uint32_t outputs = 0;
    if (sink->channel[MLRT_CHANNEL_T].data) outputs |= MLRT_OUTPUT_T;
    if (sink->channel[MLRT_CHANNEL_U].data || sink->channel[MLRT_CHANNEL_V].data) outputs |= MLRT_OUTPUT_UV;
    if (sink->channel[MLRT_CHANNEL_FACING].data) outputs |= MLRT_OUTPUT_FACING;
    return outputs;
}

void mlrt_write_packet(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t lanes, uint32_t x,
                       uint32_t y, const struct mlrt_sink *sink)
{
    const uint32_t outputs = wanted_numbers(sink);
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        if (!(lanes >> lane & 1)) continue;
        struct result result = miss;
        const uint32_t number = packet->triangle[lane];
        if (number != MLRT_NONE) {
            const uint32_t mesh = mlrt_mesh_of_triangle(tree, number);
            result.mesh = tree->mesh_ids[mesh];
            result.triangle = number - tree->mesh_first[mesh];
            result.occluded = 1;
            if (outputs) {
                struct mlrt_ray_segment ray;
                mlrt_get_segment(packet, lane, &ray);
                mlrt_report_hit(&ray, &tree->triangles[number], outputs, &result.report);
            }
        }
        write_result(&result, x + (uint32_t)mlrt_lane_x[lane], y + (uint32_t)mlrt_lane_y[lane], sink);
    }
}

void mlrt_write_misses(uint32_t x, uint32_t y, uint32_t count, const struct mlrt_sink *sink)
{
    for (uint32_t i = 0; i < count; ++i) write_result(&miss, x + i, y, sink);
}
