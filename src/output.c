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

/* The channel of 4 bytes that is written at this address, with the strides of `like`, out of a set. */
static int find_neighbour(const struct mlrt_sink *sink, uint32_t channels, const unsigned char *at, int like)
{
    for (int c = 0; c < MLRT_CHANNEL_OCCLUDED; ++c) {
        if (channels >> c & 1 && sink->channel[c].data == at && sink->channel[c].stride == sink->channel[like].stride &&
            sink->channel[c].row_stride == sink->channel[like].row_stride) {
            return c;
        }
    }
    return -1;
}

static int is_same_struct(const struct mlrt_sink *sink, int c, int other)
{
    const uintptr_t distance = (uintptr_t)sink->channel[c].data - (uintptr_t)sink->channel[other].data;
    return distance < sink->channel[c].stride && sink->channel[c].stride == sink->channel[other].stride &&
           sink->channel[c].row_stride == sink->channel[other].row_stride;
}

/* A group that starts with a channel, out of a set. Structs of neighbours do not overlap. */
static uint32_t make_group(const struct mlrt_sink *sink, uint32_t channels, int first, struct mlrt_sink_group *group)
{
    int c = first;
    uint32_t count = 0, taken = 0;
    while (c >= 0 && count < 4 && sink->channel[c].stride >= 4 * (count + 1)) {
        group->channel[count++] = (uint8_t)c;
        c = find_neighbour(sink, channels, sink->channel[c].data + 4, c);
    }
    group->count = (uint8_t)(count == 3 ? 2 : count);
    for (uint32_t i = 0; i < group->count; ++i) taken |= 1u << group->channel[i];
    return taken;
}

void mlrt_group_channels(struct mlrt_sink *sink)
{
    uint32_t left = 0;
    for (int c = 0; c < MLRT_CHANNEL_OCCLUDED; ++c) left |= (uint32_t)(sink->channel[c].data != NULL) << c;
    const uint32_t uv = 1u << MLRT_CHANNEL_U | 1u << MLRT_CHANNEL_V;
    sink->numbers = (left >> MLRT_CHANNEL_T & 1 ? (uint32_t)MLRT_OUTPUT_T : 0) | (left & uv ? (uint32_t)MLRT_OUTPUT_UV : 0) |
                    (left >> MLRT_CHANNEL_FACING & 1 ? (uint32_t)MLRT_OUTPUT_FACING : 0);
    sink->group_count = 0;
    while (left) {
        int first = (int)mlrt_lowest_bit(left);
        for (int c = first + 1; c < MLRT_CHANNEL_OCCLUDED; ++c) {
            const uintptr_t at = (uintptr_t)sink->channel[c].data;
            if (left >> c & 1 && at < (uintptr_t)sink->channel[first].data) first = c;
        }
        struct mlrt_sink_group *group = &sink->groups[sink->group_count];
        left &= ~make_group(sink, left, first, group);
        group->is_same_struct = sink->group_count && is_same_struct(sink, first, group[-1].channel[0]);
        ++sink->group_count;
    }
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
    mlrt_group_channels(sink);
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

/* ---- packets ---- */

static size_t lane_offset(uint32_t lane, size_t stride, size_t row_stride)
{
    const uint32_t column = (lane & 1) | (lane >> 1 & 2), row = (lane >> 1 & 1) | (lane >> 2 & 2);
    return row * row_stride + column * stride;
}

static const unsigned char *values_of(const struct mlrt_packet_values *values, enum mlrt_channel c)
{
    return (const unsigned char *)values + sizeof values->t * (size_t)c;
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

/* A square of lanes, one element each. */
MLRT_INLINE void write_singles(const unsigned char *values, unsigned char *above, unsigned char *below, size_t stride)
{
    memcpy(above, values, 4);
    memcpy(above + stride, values + 4, 4);
    memcpy(below, values + 8, 4);
    memcpy(below + stride, values + 12, 4);
}

/* Two neighbours each, */
MLRT_INLINE void write_pairs(const unsigned char *const *values, size_t offset, unsigned char *above,
                             unsigned char *below, size_t stride)
{
    const f4 a = f4_load_any(values[0] + offset), b = f4_load_any(values[1] + offset);
    const f4 evens = f4_evens(a, b), odds = f4_odds(a, b);
    const f4 first = f4_evens(evens, odds), last = f4_odds(evens, odds);
    f4_store_low(above, first);
    f4_store_high(above + stride, first);
    f4_store_low(below, last);
    f4_store_high(below + stride, last);
}

/* or four. */
MLRT_INLINE void write_fours(const unsigned char *const *values, size_t offset, unsigned char *above,
                             unsigned char *below, size_t stride)
{
    f4 a[4];
    MLRT_UNROLL
    for (int i = 0; i < 4; ++i) a[i] = f4_load_any(values[i] + offset);
    const f4 evens = f4_evens(a[0], a[1]), odds = f4_odds(a[0], a[1]);
    const f4 more_evens = f4_evens(a[2], a[3]), more_odds = f4_odds(a[2], a[3]);
    f4_store_any(above, f4_evens(evens, more_evens));
    f4_store_any(above + stride, f4_evens(odds, more_odds));
    f4_store_any(below, f4_odds(evens, more_evens));
    f4_store_any(below + stride, f4_odds(odds, more_odds));
}

/* Where the lanes of a square are, of a whole packet in structs. */
struct square {
    unsigned char *above;
    unsigned char *below;
};

MLRT_INLINE struct square find_square(unsigned char *corner, size_t square, size_t stride, size_t row_stride)
{
    unsigned char *above = corner + (square & 1) * 2 * stride + (square >> 1) * 2 * row_stride;
    return (struct square){above, above + row_stride};
}

/* A whole packet to structs. */
static MLRT_NOINLINE void write_structs(const struct mlrt_packet_values *values, const struct mlrt_sink_group *group,
                                        unsigned char *corner, size_t stride, size_t row_stride)
{
    const unsigned char *arrays[4];
    for (uint32_t i = 0; i < group->count; ++i) arrays[i] = values_of(values, (enum mlrt_channel)group->channel[i]);
    for (size_t i = 0; i < 4; ++i) {
        const struct square square = find_square(corner, i, stride, row_stride);
        if (group->count == 4) {
            write_fours(arrays, 16 * i, square.above, square.below, stride);
        } else if (group->count == 2) {
            write_pairs(arrays, 16 * i, square.above, square.below, stride);
        } else {
            write_singles(arrays[0] + 16 * i, square.above, square.below, stride);
        }
    }
}

/* Some lanes of a packet, to elements of any kind. */
static MLRT_NOINLINE void write_lanes(const struct mlrt_packet_values *values, enum mlrt_channel c, uint32_t lanes,
                                      unsigned char *corner, size_t stride, size_t row_stride)
{
    for (; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        memcpy(corner + lane_offset(lane, stride, row_stride), values_of(values, c) + 4 * lane, 4);
    }
}

void mlrt_write_values(const struct mlrt_packet_values *values, uint32_t lanes, uint32_t x, uint32_t y,
                       const struct mlrt_sink *sink)
{
    const struct mlrt_sink_group *const end = sink->groups + sink->group_count;
    for (const struct mlrt_sink_group *group = sink->groups; group < end; ++group) {
        const enum mlrt_channel c = (enum mlrt_channel)group->channel[0];
        const size_t stride = sink->channel[c].stride, row_stride = sink->channel[c].row_stride;
        if (MLRT_UNLIKELY(lanes != 0xFFFF)) {
            for (uint32_t i = 0; i < group->count; ++i) {
                const enum mlrt_channel one = (enum mlrt_channel)group->channel[i];
                write_lanes(values, one, lanes, element(sink, one, x, y), stride, row_stride);
            }
        } else if (stride == 4) {
            write_block(values_of(values, c), element(sink, c, x, y), row_stride);
        } else {
            write_structs(values, group, element(sink, c, x, y), stride, row_stride);
        }
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
