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

void mlrt_find_ids(const struct mlrt_tree *tree, uint32_t number, uint32_t *mesh, uint32_t *triangle)
{
    *mesh = *triangle = MLRT_NONE;
    if (number == MLRT_NONE) return;
    const uint32_t position = mlrt_mesh_of_triangle(tree, number);
    *mesh = tree->mesh_ids[position];
    *triangle = number - tree->mesh_first[position];
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

static const struct mlrt_hit_report miss = {INFINITY, 0, 0, 0};

static void *element(const struct mlrt_sink *sink, enum mlrt_channel c, uint32_t x, uint32_t y)
{
    return sink->channel[c].data + (size_t)y * sink->channel[c].row_stride + (size_t)x * sink->channel[c].stride;
}

static void write_report(const struct mlrt_hit_report *report, uint32_t x, uint32_t y, const struct mlrt_sink *sink)
{
    if (sink->channel[MLRT_CHANNEL_T].data) *(float *)element(sink, MLRT_CHANNEL_T, x, y) = report->t;
    if (sink->channel[MLRT_CHANNEL_U].data) *(float *)element(sink, MLRT_CHANNEL_U, x, y) = report->u;
    if (sink->channel[MLRT_CHANNEL_V].data) *(float *)element(sink, MLRT_CHANNEL_V, x, y) = report->v;
    if (sink->channel[MLRT_CHANNEL_FACING].data) {
        *(int32_t *)element(sink, MLRT_CHANNEL_FACING, x, y) = report->facing;
    }
}

/* A 4-byte channel of a packet's lanes. */
static void write_words(const uint32_t values[MLRT_PACKET_RAYS], uint32_t lanes, uint32_t x, uint32_t y,
                        enum mlrt_channel c, const struct mlrt_sink *sink)
{
    const size_t stride = sink->channel[c].stride, row_stride = sink->channel[c].row_stride;
    unsigned char *corner = element(sink, c, x, y);
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        if (!(lanes >> lane & 1)) continue;
        unsigned char *at = corner + (size_t)mlrt_lane_y[lane] * row_stride + (size_t)mlrt_lane_x[lane] * stride;
        *(uint32_t *)(void *)at = values[lane];
    }
}

/* Turns triangle numbers into ids. Neighbours mostly hit the same mesh, so its range is tried first. */
static void find_ids(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t meshes[MLRT_PACKET_RAYS],
                     uint32_t triangles[MLRT_PACKET_RAYS])
{
    uint32_t mesh = 0;
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        const uint32_t number = packet->triangle[lane];
        if (number == MLRT_NONE) {
            meshes[lane] = triangles[lane] = MLRT_NONE;
            continue;
        }
        if (number < tree->mesh_first[mesh] || number >= tree->mesh_first[mesh + 1]) {
            mesh = mlrt_mesh_of_triangle(tree, number);
        }
        meshes[lane] = tree->mesh_ids[mesh];
        triangles[lane] = number - tree->mesh_first[mesh];
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

int mlrt_sink_wants_ids_only(const struct mlrt_sink *sink)
{
    return wanted_numbers(sink) == 0;
}

static void write_ids(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t lanes, uint32_t x,
                      uint32_t y, const struct mlrt_sink *sink)
{
    uint32_t meshes[MLRT_PACKET_RAYS], triangles[MLRT_PACKET_RAYS];
    if (!sink->channel[MLRT_CHANNEL_MESH].data && !sink->channel[MLRT_CHANNEL_TRIANGLE].data) return;
    find_ids(tree, packet, meshes, triangles);
    if (sink->channel[MLRT_CHANNEL_MESH].data) write_words(meshes, lanes, x, y, MLRT_CHANNEL_MESH, sink);
    if (sink->channel[MLRT_CHANNEL_TRIANGLE].data) write_words(triangles, lanes, x, y, MLRT_CHANNEL_TRIANGLE, sink);
}

static void write_reports(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t lanes, uint32_t x,
                          uint32_t y, uint32_t outputs, const struct mlrt_sink *sink)
{
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        if (!(lanes >> lane & 1)) continue;
        struct mlrt_hit_report report = miss;
        if (packet->triangle[lane] != MLRT_NONE) {
            struct mlrt_ray_segment ray;
            mlrt_get_segment(packet, lane, &ray);
            mlrt_report_hit(&ray, &tree->triangles[packet->triangle[lane]], outputs, &report);
        }
        write_report(&report, x + (uint32_t)mlrt_lane_x[lane], y + (uint32_t)mlrt_lane_y[lane], sink);
    }
}

static void write_occluded(const struct mlrt_packet *packet, uint32_t lanes, uint32_t x, uint32_t y,
                           const struct mlrt_sink *sink)
{
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        if (!(lanes >> lane & 1)) continue;
        *(uint8_t *)element(sink, MLRT_CHANNEL_OCCLUDED, x + (uint32_t)mlrt_lane_x[lane],
                            y + (uint32_t)mlrt_lane_y[lane]) = packet->triangle[lane] != MLRT_NONE;
    }
}

void mlrt_write_packet(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t lanes, uint32_t x,
                       uint32_t y, const struct mlrt_sink *sink)
{
    const uint32_t outputs = wanted_numbers(sink);
    write_ids(tree, packet, lanes, x, y, sink);
    if (outputs) write_reports(tree, packet, lanes, x, y, outputs, sink);
    if (sink->channel[MLRT_CHANNEL_OCCLUDED].data) write_occluded(packet, lanes, x, y, sink);
}

static void write_run(uint32_t value, uint32_t x, uint32_t y, uint32_t count, enum mlrt_channel c,
                      const struct mlrt_sink *sink)
{
    if (!sink->channel[c].data) return;
    for (uint32_t i = 0; i < count; ++i) *(uint32_t *)element(sink, c, x + i, y) = value;
}

static void write_occluded_run(uint8_t value, uint32_t x, uint32_t y, uint32_t count, const struct mlrt_sink *sink)
{
    if (!sink->channel[MLRT_CHANNEL_OCCLUDED].data) return;
    for (uint32_t i = 0; i < count; ++i) *(uint8_t *)element(sink, MLRT_CHANNEL_OCCLUDED, x + i, y) = value;
}

void mlrt_write_same_hits(const struct mlrt_tree *tree, uint32_t number, uint32_t x, uint32_t y, uint32_t count,
                          const struct mlrt_sink *sink)
{
    uint32_t mesh, triangle;
    mlrt_find_ids(tree, number, &mesh, &triangle);
    write_run(mesh, x, y, count, MLRT_CHANNEL_MESH, sink);
    write_run(triangle, x, y, count, MLRT_CHANNEL_TRIANGLE, sink);
    write_occluded_run(1, x, y, count, sink);
}

void mlrt_write_misses(uint32_t x, uint32_t y, uint32_t count, const struct mlrt_sink *sink)
{
    write_run(MLRT_NONE, x, y, count, MLRT_CHANNEL_MESH, sink);
    write_run(MLRT_NONE, x, y, count, MLRT_CHANNEL_TRIANGLE, sink);
    write_occluded_run(0, x, y, count, sink);
    if (mlrt_sink_wants_ids_only(sink)) return;
    for (uint32_t i = 0; i < count; ++i) write_report(&miss, x + i, y, sink);
}
