/* SPDX-License-Identifier: MIT */
/*
 * Results on their way out: where they go. What nobody reads is not computed: the numbers of a hit (rule R5) are worked
 * out by the kernels (kernels/hit_numbers.h), and only for channels that a sink has.
 */
#include "output.h"

#include <math.h>
#include <string.h>

#include "structs.h"
#include "kernels/quad.h"

size_t mlrt_channel_size(enum mlrt_channel channel)
{
    return channel == MLRT_CHANNEL_OCCLUDED ? 1 : 4;
}

int32_t mlrt_make_sink(const mlrt_hits *hits, uint32_t channels, uint32_t width, int packed_rows,
                       struct mlrt_sink *sink)
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
        if (!(channels >> c & 1)) return MLRT_ERROR_ARGUMENT;
        if (stride > MLRT_STRIDE_LIMIT || (!packed_rows && array->row_stride > MLRT_STRIDE_LIMIT)) {
            return MLRT_ERROR_ARGUMENT;
        }
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
    ray->mask = packet->has_masks ? packet->mask[lane] : MLRT_MASK_ALL;
}

static unsigned char *element(const struct mlrt_sink *sink, enum mlrt_channel c, uint32_t x, uint32_t y)
{
    return sink->channel[c].data + (size_t)y * sink->channel[c].row_stride + (size_t)x * sink->channel[c].stride;
}

uint32_t mlrt_sink_numbers(const struct mlrt_sink *sink)
{
    uint32_t outputs = 0;
    if (sink->channel[MLRT_CHANNEL_T].data) outputs |= MLRT_OUTPUT_T;
    if (sink->channel[MLRT_CHANNEL_U].data || sink->channel[MLRT_CHANNEL_V].data) outputs |= MLRT_OUTPUT_UV;
    if (sink->channel[MLRT_CHANNEL_FACING].data) outputs |= MLRT_OUTPUT_FACING;
    return outputs;
}

/* ---- packets ---- */

static size_t lane_offset(uint32_t lane, size_t stride, size_t row_stride)
{
    const uint32_t column = (lane & 1) | (lane >> 1 & 2), row = (lane >> 1 & 1) | (lane >> 2 & 2);
    return row * row_stride + column * stride;
}

/* A whole packet to elements that lie side by side. Lanes 0 .. 3 and 4 .. 7 are two squares beside each other. */
MLRT_INLINE void write_block(const unsigned char *values, unsigned char *at, size_t row_stride)
{
    for (int half = 0; half < 2; ++half, at += 2 * row_stride, values += 32) {
        const f4 left = f4_load_any(values), right = f4_load_any(values + 16);
        f4_store_any(at, f4_low(left, right));
        f4_store_any(at + row_stride, f4_high(left, right));
    }
}

void mlrt_write_words(const void *values, uint32_t lanes, uint32_t x, uint32_t y, enum mlrt_channel c,
                      const struct mlrt_sink *sink)
{
    const size_t stride = sink->channel[c].stride, row_stride = sink->channel[c].row_stride;
    unsigned char *corner = element(sink, c, x, y);
    if (MLRT_LIKELY(lanes == 0xFFFF && stride == 4)) {
        write_block(values, corner, row_stride);
        return;
    }
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        memcpy(corner + lane_offset(lane, stride, row_stride), (const unsigned char *)values + 4 * lane, 4);
    }
}

/* Four bits as bytes. */
static const uint8_t bytes_of_bits[16][4] = {
    {0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {1, 1, 0, 0}, {0, 0, 1, 0}, {1, 0, 1, 0}, {0, 1, 1, 0}, {1, 1, 1, 0},
    {0, 0, 0, 1}, {1, 0, 0, 1}, {0, 1, 0, 1}, {1, 1, 0, 1}, {0, 0, 1, 1}, {1, 0, 1, 1}, {0, 1, 1, 1}, {1, 1, 1, 1}};

void mlrt_write_occluded(uint32_t occluded, uint32_t lanes, uint32_t x, uint32_t y, const struct mlrt_sink *sink)
{
    const size_t stride = sink->channel[MLRT_CHANNEL_OCCLUDED].stride;
    const size_t row_stride = sink->channel[MLRT_CHANNEL_OCCLUDED].row_stride;
    unsigned char *corner = element(sink, MLRT_CHANNEL_OCCLUDED, x, y);
    if (MLRT_LIKELY(lanes == 0xFFFF && stride == 1)) {
        uint32_t rows = (occluded & 0xC3C3) | (occluded & 0x0C0C) << 2 | (occluded & 0x3030) >> 2;
        MLRT_UNROLL
        for (int row = 0; row < 4; ++row, rows >>= 4, corner += row_stride) memcpy(corner, bytes_of_bits[rows & 15], 4);
        return;
    }
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        corner[lane_offset(lane, stride, row_stride)] = occluded >> lane & 1;
    }
}

void mlrt_add_shadow(uint8_t shadows[MLRT_PACKET_RAYS], uint32_t dark, uint8_t bit)
{
    for (int lane = 0; lane < MLRT_PACKET_RAYS; lane += 4, dark >>= 4) {
        uint32_t four, added;
        memcpy(&four, shadows + lane, sizeof four);
        memcpy(&added, bytes_of_bits[dark & 15], sizeof added);
        four |= added * bit;
        memcpy(shadows + lane, &four, sizeof four);
    }
}

void mlrt_write_shadows(const uint8_t shadows[MLRT_PACKET_RAYS], uint32_t lanes, uint32_t x, uint32_t y,
                        const struct mlrt_sink *sink)
{
    const size_t stride = sink->channel[MLRT_CHANNEL_OCCLUDED].stride;
    const size_t row_stride = sink->channel[MLRT_CHANNEL_OCCLUDED].row_stride;
    unsigned char *corner = element(sink, MLRT_CHANNEL_OCCLUDED, x, y);
    if (MLRT_LIKELY(lanes == 0xFFFF && stride == 1)) {
        for (uint32_t row = 0; row < 4; ++row, corner += row_stride) {
            const uint8_t *left = shadows + 2 * (row & 1) + 8 * (row >> 1);
            memcpy(corner, left, 2);
            memcpy(corner + 2, left + 4, 2);
        }
        return;
    }
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        corner[lane_offset(lane, stride, row_stride)] = shadows[lane];
    }
}

/* Neighbours mostly hit the same mesh, so its range is tried first. */
void mlrt_find_packet_ids(const struct mlrt_tree *tree, const struct mlrt_packet *packet,
                          uint32_t meshes[MLRT_PACKET_RAYS], uint32_t triangles[MLRT_PACKET_RAYS])
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

/* ---- rectangles ---- */

void mlrt_prefetch_sink(uint32_t x, uint32_t y, uint32_t width, uint32_t height, const struct mlrt_sink *sink)
{
    for (int c = 0; c < MLRT_CHANNEL_COUNT; ++c) {
        if (!sink->channel[c].data) continue;
        const unsigned char *row = element(sink, (enum mlrt_channel)c, x, y);
        for (uint32_t j = 0; j < height; ++j, row += sink->channel[c].row_stride) {
            for (size_t i = 0; i < width * sink->channel[c].stride; i += 64) mlrt_prefetch_for_writing(row + i);
            mlrt_prefetch_for_writing(row + width * sink->channel[c].stride - 1);
        }
    }
}

/* One word to rows of so many times four elements that lie side by side. */
MLRT_INLINE void fill_quads(uint32_t value, uint32_t quads, uint32_t height, size_t row_stride, unsigned char *row)
{
    const uint32_t words[4] = {value, value, value, value};
    const f4 quad = f4_load_any(words);
    for (; height; --height, row += row_stride) {
        for (uint32_t i = 0; i < quads; ++i) f4_store_any(row + 16 * (size_t)i, quad);
    }
}

static void fill_words(uint32_t value, uint32_t x, uint32_t y, uint32_t width, uint32_t height, enum mlrt_channel c,
                       const struct mlrt_sink *sink)
{
    const size_t stride = sink->channel[c].stride, row_stride = sink->channel[c].row_stride;
    if (!sink->channel[c].data) return;
    unsigned char *row = element(sink, c, x, y);
    if (MLRT_LIKELY(stride == 4 && width == 16)) { /* tiles */
        fill_quads(value, 4, height, row_stride, row);
    } else if (MLRT_LIKELY(stride == 4 && width == 4)) { /* packets */
        fill_quads(value, 1, height, row_stride, row);
    } else {
        for (; height; --height, row += row_stride) {
            for (uint32_t i = 0; i < width; ++i) memcpy(row + i * stride, &value, 4);
        }
    }
}

void mlrt_write_same_shadow(uint8_t value, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
                            const struct mlrt_sink *sink)
{
    const size_t stride = sink->channel[MLRT_CHANNEL_OCCLUDED].stride;
    const size_t row_stride = sink->channel[MLRT_CHANNEL_OCCLUDED].row_stride;
    if (!sink->channel[MLRT_CHANNEL_OCCLUDED].data) return;
    unsigned char *row = element(sink, MLRT_CHANNEL_OCCLUDED, x, y);
    for (; height; --height, row += row_stride) {
        if (stride != 1) {
            for (uint32_t i = 0; i < width; ++i) row[i * stride] = value;
        } else if (width == 16) { /* a store, where the other is a call */
            memset(row, value, 16);
        } else {
            memset(row, value, width);
        }
    }
}

void mlrt_write_same_ids(const struct mlrt_tree *tree, uint32_t number, uint32_t x, uint32_t y, uint32_t width,
                         uint32_t height, const struct mlrt_sink *sink)
{
    uint32_t mesh, triangle;
    mlrt_find_ids(tree, number, &mesh, &triangle);
    fill_words(mesh, x, y, width, height, MLRT_CHANNEL_MESH, sink);
    fill_words(triangle, x, y, width, height, MLRT_CHANNEL_TRIANGLE, sink);
}

void mlrt_write_misses(uint32_t x, uint32_t y, uint32_t width, uint32_t height, const struct mlrt_sink *sink)
{
    const float infinity = INFINITY;
    uint32_t values[MLRT_CHANNEL_COUNT] = {0, 0, 0, MLRT_NONE, MLRT_NONE, 0, 0};
    memcpy(&values[MLRT_CHANNEL_T], &infinity, sizeof infinity);
    for (int c = 0; c < MLRT_CHANNEL_OCCLUDED; ++c) {
        fill_words(values[c], x, y, width, height, (enum mlrt_channel)c, sink);
    }
    mlrt_write_same_shadow(0, x, y, width, height, sink);
}
