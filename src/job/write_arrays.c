/* SPDX-License-Identifier: MIT */
/*
 * Writes results to the arrays of a sink. The numbers of a hit (rule R5) are computed by the kernels
 * (hits/hit_numbers.h), and only for channels that the sink has.
 */
#include "job/write_arrays.h"

#include <math.h>
#include <string.h>

#include "scene/triangle_numbers.h"
#include "simd/quad.h"
#include "simd/sixteen.h"

/* ---- packets ---- */

/* The array with the values of channel i of a group. */
MLRT_INLINE const unsigned char *values_of(const struct mlrt_packet_values *values, const struct mlrt_sink_group *group,
                                           uint32_t i)
{
    return (const unsigned char *)values + sizeof values->t * group->channel[i];
}

/* Writes a whole packet to packed elements. Lanes 0 .. 3 and 4 .. 7 are two squares of 2x2 beside each other. */
MLRT_INLINE void write_block(const unsigned char *values, unsigned char *at, size_t row_stride)
{
    for (int half = 0; half < 2; ++half, at += 2 * row_stride, values += 32) {
        const f4 left = f4_load_any(values), right = f4_load_any(values + 16);
        f4_store_any(at, f4_low(left, right));
        f4_store_any(at + row_stride, f4_high(left, right));
    }
}

/* The addresses of the elements of four lanes, a square of 2x2. */
struct square {
    unsigned char *at[4];
};

MLRT_INLINE struct square find_square(unsigned char *corner, size_t square, const struct mlrt_image *image)
{
    const size_t stride = image->stride, row_stride = image->row_stride;
    unsigned char *above = corner + (square & 1) * 2 * stride + (square >> 1) * 2 * row_stride;
    return (struct square){{above, above + stride, above + row_stride, above + row_stride + stride}};
}

/* Writes two neighbouring values to each struct of a square. */
MLRT_INLINE void write_pairs(const unsigned char *first, const unsigned char *second, const struct square *to)
{
    const f4 a = f4_load_any(first), b = f4_load_any(second);
    const f4 evens = f4_evens(a, b), odds = f4_odds(a, b);
    const f4 above = f4_evens(evens, odds), below = f4_odds(evens, odds);
    f4_store_low(to->at[0], above);
    f4_store_high(to->at[1], above);
    f4_store_low(to->at[2], below);
    f4_store_high(to->at[3], below);
}

/* Writes four neighbouring values to each. */
MLRT_INLINE void write_fours(const unsigned char *const *values, size_t offset, const struct square *to)
{
    f4 a[4];
    MLRT_UNROLL
    for (int i = 0; i < 4; ++i) a[i] = f4_load_any(values[i] + offset);
    const f4 evens = f4_evens(a[0], a[1]), odds = f4_odds(a[0], a[1]);
    const f4 more_evens = f4_evens(a[2], a[3]), more_odds = f4_odds(a[2], a[3]);
    f4_store_any(to->at[0], f4_evens(evens, more_evens));
    f4_store_any(to->at[1], f4_evens(odds, more_odds));
    f4_store_any(to->at[2], f4_odds(evens, more_evens));
    f4_store_any(to->at[3], f4_odds(odds, more_odds));
}

static MLRT_NOINLINE void write_structs(const struct mlrt_packet_values *values, const struct mlrt_sink_group *group,
                                        unsigned char *corner)
{
    const struct mlrt_image image = group->image;
    const uint32_t count = group->count;
    const unsigned char *arrays[4];
    MLRT_UNROLL
    for (uint32_t i = 0; i < 4; ++i) arrays[i] = values_of(values, group, i);
    MLRT_UNROLL
    for (size_t i = 0; i < 4; ++i) {
        const struct square square = find_square(corner, i, &image);
        if (count == 4) {
            write_fours(arrays, 16 * i, &square);
        } else if (count == 2) {
            write_pairs(arrays[0] + 16 * i, arrays[1] + 16 * i, &square);
        } else {
            MLRT_UNROLL
            for (size_t k = 0; k < 4; ++k) memcpy(square.at[k], arrays[0] + 16 * i + 4 * k, 4);
        }
    }
}

/* Writes any lanes of a packet to elements with any stride. */
static MLRT_NOINLINE void write_lanes(const struct mlrt_packet_values *values, uint32_t lanes,
                                      const struct mlrt_sink_group *group, unsigned char *corner)
{
    for (uint32_t i = 0; i < group->count; ++i, corner += 4) {
        const unsigned char *from = values_of(values, group, i);
        for (uint32_t left = lanes; left; left &= left - 1) {
            const uint32_t lane = mlrt_lowest_bit(left);
            memcpy(corner + mlrt_lane_offset(lane, group->image.stride, group->image.row_stride), from + 4 * lane, 4);
        }
    }
}

void mlrt_write_group(const struct mlrt_packet_values *values, uint32_t lanes, const struct mlrt_rectangle *block,
                      const struct mlrt_sink *sink, const struct mlrt_sink_group *group)
{
    unsigned char *corner = mlrt_find_corner(sink, &group->image, block);
    if (MLRT_UNLIKELY(lanes != 0xFFFF)) {
        write_lanes(values, lanes, group, corner);
    } else if (group->image.stride == 4) {
        write_block(values_of(values, group, 0), corner, group->image.row_stride);
    } else {
        write_structs(values, group, corner);
    }
}

/* A byte for each bit of a number of four bits. */
static const uint8_t bytes_of_bits[16][4] = {
    {0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {1, 1, 0, 0}, {0, 0, 1, 0}, {1, 0, 1, 0}, {0, 1, 1, 0}, {1, 1, 1, 0},
    {0, 0, 0, 1}, {1, 0, 0, 1}, {0, 1, 0, 1}, {1, 1, 0, 1}, {0, 0, 1, 1}, {1, 0, 1, 1}, {0, 1, 1, 1}, {1, 1, 1, 1}};

/* Writes a byte for each lane to elements with any stride. */
static MLRT_NOINLINE void write_bytes(const uint8_t bytes[MLRT_PACKET_RAYS], uint32_t lanes, unsigned char *corner,
                                      const struct mlrt_image *image)
{
    for (uint32_t i = 0; i < 4 && lanes == 0xFFFF; ++i) {
        const struct square square = find_square(corner, i, image);
        MLRT_UNROLL
        for (uint32_t k = 0; k < 4; ++k) *square.at[k] = bytes[4 * i + k];
    }
    for (lanes = lanes == 0xFFFF ? 0 : lanes; lanes; lanes &= lanes - 1) {
        const uint32_t lane = mlrt_lowest_bit(lanes);
        corner[mlrt_lane_offset(lane, image->stride, image->row_stride)] = bytes[lane];
    }
}

void mlrt_write_occluded(uint32_t occluded, uint32_t lanes, const struct mlrt_rectangle *block,
                         const struct mlrt_sink *sink)
{
    const struct mlrt_image *image = &sink->channel[MLRT_CHANNEL_OCCLUDED];
    if (!image->data) return;
    unsigned char *corner = mlrt_find_corner(sink, image, block);
    if (MLRT_LIKELY(lanes == 0xFFFF && image->stride == 1)) {
        /* From squares of 2x2 to rows: bit 4 y + x is that of column x and row y. */
        uint32_t rows = (occluded & 0xC3C3) | (occluded & 0x0C0C) << 2 | (occluded & 0x3030) >> 2;
        MLRT_UNROLL
        for (int row = 0; row < 4; ++row, rows >>= 4, corner += image->row_stride)
            memcpy(corner, bytes_of_bits[rows & 15], 4);
    } else {
        uint8_t bytes[MLRT_PACKET_RAYS];
        for (int i = 0; i < 4; ++i) memcpy(bytes + 4 * i, bytes_of_bits[occluded >> 4 * i & 15], 4);
        write_bytes(bytes, lanes, corner, image);
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

void mlrt_write_shadows(const uint8_t shadows[MLRT_PACKET_RAYS], uint32_t lanes, const struct mlrt_rectangle *block,
                        const struct mlrt_sink *sink)
{
    const struct mlrt_image *image = &sink->channel[MLRT_CHANNEL_OCCLUDED];
    if (!image->data) return;
    unsigned char *corner = mlrt_find_corner(sink, image, block);
    if (MLRT_LIKELY(lanes == 0xFFFF && image->stride == 1)) {
        for (uint32_t row = 0; row < 4; ++row, corner += image->row_stride) {
            const uint8_t *left = shadows + 2 * (row & 1) + 8 * (row >> 1);
            memcpy(corner, left, 2);
            memcpy(corner + 2, left + 4, 2);
        }
    } else {
        write_bytes(shadows, lanes, corner, image);
    }
}

/* ---- rectangles ---- */

void mlrt_add_sink_rows(const struct mlrt_sink *sink, uint32_t x, uint32_t y, uint32_t width,
                        struct mlrt_rows_ahead *rows)
{
    const struct mlrt_rectangle row = {x, y, width, 1};
    for (uint32_t i = 0; i <= sink->group_count; ++i) {
        const int is_group = i < sink->group_count;
        const struct mlrt_image *image = is_group ? &sink->groups[i].image : &sink->channel[MLRT_CHANNEL_OCCLUDED];
        if (!image->data || (is_group && sink->groups[i].is_same_struct)) continue;
        mlrt_add_rows_ahead(mlrt_find_corner(sink, image, &row), width * image->stride, image->row_stride, 1, rows);
    }
}

/* Writes one word to rows of 4 * quads packed elements. */
MLRT_INLINE void fill_quads(uint32_t value, uint32_t quads, uint32_t height, size_t row_stride, unsigned char *row)
{
    const uint32_t words[4] = {value, value, value, value};
    const f4 quad = f4_load_any(words);
    for (; height; --height, row += row_stride)
        for (uint32_t i = 0; i < quads; ++i) f4_store_any(row + 16 * (size_t)i, quad);
}

/* Writes the same values, one for each channel of 4 bytes, to the channels of a group, block by block. */
static MLRT_NOINLINE void fill_blocks(const uint32_t values[MLRT_CHANNEL_OCCLUDED], const struct mlrt_rectangle *area,
                                      const struct mlrt_sink *sink, const struct mlrt_sink_group *group)
{
    MLRT_ALIGNED(64) uint32_t words[MLRT_CHANNEL_OCCLUDED][MLRT_PACKET_RAYS]; /* a struct mlrt_packet_values */
    const struct mlrt_packet_values *packet = (const struct mlrt_packet_values *)(const void *)words;
    for (uint32_t i = 0; i < group->count; ++i) mlrt_fill_words(words[group->channel[i]], values[group->channel[i]]);
    for (uint32_t j = 0; j < area->height; j += 4) {
        for (uint32_t i = 0; i < area->width; i += 4) {
            const struct mlrt_rectangle part = mlrt_cut_piece(area, i, j, 4);
            mlrt_write_group(packet, mlrt_block_lanes(part.width, part.height), &part, sink, group);
        }
    }
}

/* Writes the same values, one for each channel of 4 bytes, to a rectangle. */
static void fill_channels(const uint32_t values[MLRT_CHANNEL_OCCLUDED], const struct mlrt_rectangle *area,
                          const struct mlrt_sink *sink)
{
    const uint32_t width = area->width, height = area->height;
    for (uint32_t g = 0; g < sink->group_count; ++g) {
        const struct mlrt_sink_group *group = &sink->groups[g];
        unsigned char *row = mlrt_find_corner(sink, &group->image, area);
        if (MLRT_LIKELY(group->image.stride == 4 && width == 16)) { /* tiles */
            fill_quads(values[group->channel[0]], 4, height, group->image.row_stride, row);
        } else if (MLRT_LIKELY(group->image.stride == 4 && width == 4)) { /* packets */
            fill_quads(values[group->channel[0]], 1, height, group->image.row_stride, row);
        } else {
            fill_blocks(values, area, sink, group);
        }
    }
}

void mlrt_write_same_shadow(uint8_t value, const struct mlrt_rectangle *area, const struct mlrt_sink *sink)
{
    const struct mlrt_image *image = &sink->channel[MLRT_CHANNEL_OCCLUDED];
    if (!image->data) return;
    unsigned char *row = mlrt_find_corner(sink, image, area);
    for (uint32_t left = area->height; left; --left, row += image->row_stride) {
        if (image->stride != 1) {
            for (uint32_t i = 0; i < area->width; ++i) row[i * image->stride] = value;
        } else if (area->width == 16) { /* a fixed length: compiled to a store, not a call */
            memset(row, value, 16);
        } else {
            memset(row, value, area->width);
        }
    }
}

void mlrt_write_same_ids(const struct mlrt_tree *tree, uint32_t number, const struct mlrt_rectangle *area,
                         const struct mlrt_sink *sink)
{
    uint32_t values[MLRT_CHANNEL_OCCLUDED] = {0};
    mlrt_find_ids(tree, number, &values[MLRT_CHANNEL_MESH], &values[MLRT_CHANNEL_TRIANGLE]);
    fill_channels(values, area, sink);
}

void mlrt_write_misses(const struct mlrt_rectangle *area, const struct mlrt_sink *sink)
{
    const float infinity = INFINITY;
    uint32_t values[MLRT_CHANNEL_OCCLUDED] = {0, 0, 0, MLRT_NONE, MLRT_NONE, 0};
    memcpy(&values[MLRT_CHANNEL_T], &infinity, sizeof infinity);
    fill_channels(values, area, sink);
    mlrt_write_same_shadow(0, area, sink);
}
