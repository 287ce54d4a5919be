/* SPDX-License-Identifier: MIT */
/* Results of packets and of rectangles, written to the arrays of a sink. */
#ifndef MLRT_JOB_WRITE_ARRAYS_H
#define MLRT_JOB_WRITE_ARRAYS_H

#include "base/rows_ahead.h"
#include "job/sink.h"
#include "rays/packet.h"
#include "rays/rectangle.h"
#include "scene/tree.h"

/* The results of a packet: an array for each channel of 4 bytes, in the order of the channels. */
struct mlrt_packet_values {
    MLRT_ALIGNED(64) float t[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) float uv[2][MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) uint32_t mesh[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) uint32_t triangle[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) uint32_t facing[MLRT_PACKET_RAYS];
};

/* Rectangles and blocks are parts of the picture; the sink has all of them. */

/* The element of an image where a rectangle begins. */
MLRT_INLINE unsigned char *mlrt_find_corner(const struct mlrt_sink *sink, const struct mlrt_image *image,
                                            const struct mlrt_rectangle *area)
{
    return image->data + (size_t)(area->y - sink->y) * image->row_stride + (size_t)(area->x - sink->x) * image->stride;
}

/* Writes the values of lanes of a packet to the channels of a group. */
void mlrt_write_group(const struct mlrt_packet_values *values, uint32_t lanes, const struct mlrt_rectangle *block,
                      const struct mlrt_sink *sink, const struct mlrt_sink_group *group);

/* Likewise writes which of the lanes are occluded, 1 or 0, to the channel `occluded`, if the sink has it. */
void mlrt_write_occluded(uint32_t occluded, uint32_t lanes, const struct mlrt_rectangle *block,
                         const struct mlrt_sink *sink);

/* Sets `bit`, that of one light, in the shadows of the lanes `dark`. It must not be set yet. */
void mlrt_add_shadow(uint8_t shadows[MLRT_PACKET_RAYS], uint32_t dark, uint8_t bit);

/* Writes the shadows of lanes of a packet to the channel `occluded`, if the sink has it. */
void mlrt_write_shadows(const uint8_t shadows[MLRT_PACKET_RAYS], uint32_t lanes, const struct mlrt_rectangle *block,
                        const struct mlrt_sink *sink);

/* Adds rows of `width` elements, from (x, y) of the picture on. */
void mlrt_add_sink_rows(const struct mlrt_sink *sink, uint32_t x, uint32_t y, uint32_t width,
                        struct mlrt_rows_ahead *rows);

/* Writes misses to a rectangle. */
void mlrt_write_misses(const struct mlrt_rectangle *area, const struct mlrt_sink *sink);

/* Writes the ids of one triangle to a rectangle of a sink without numbers. */
void mlrt_write_same_ids(const struct mlrt_tree *tree, uint32_t number, const struct mlrt_rectangle *area,
                         const struct mlrt_sink *sink);

/* Writes one value to a rectangle of the channel `occluded`, if the sink has it. */
void mlrt_write_same_shadow(uint8_t occluded, const struct mlrt_rectangle *area, const struct mlrt_sink *sink);

#endif
