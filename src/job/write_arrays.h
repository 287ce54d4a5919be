/* SPDX-License-Identifier: MIT */
/* Results, written to a sink (the arrays of the caller's frame, or of a tile callback) or to an mlrt_hit. */
#ifndef MLRT_JOB_WRITE_ARRAYS_H
#define MLRT_JOB_WRITE_ARRAYS_H

#include "base/rows_ahead.h"
#include "exact/quotients.h"
#include "rays/packet.h"
#include "rays/rectangle.h"
#include "scene/tree.h"

enum mlrt_channel {
    MLRT_CHANNEL_T,
    MLRT_CHANNEL_U,
    MLRT_CHANNEL_V,
    MLRT_CHANNEL_MESH,
    MLRT_CHANNEL_TRIANGLE,
    MLRT_CHANNEL_FACING,
    MLRT_CHANNEL_OCCLUDED,
    MLRT_CHANNEL_COUNT
};

/* An array over a picture. */
struct mlrt_image {
    unsigned char *data; /* NULL = there is none */
    size_t stride;
    size_t row_stride;
};

/*
 * Channels of 4 bytes whose elements lie beside each other in one struct, in the order of their addresses. They are
 * written together.
 */
struct mlrt_sink_group {
    struct mlrt_image image; /* of the first channel; all have the same strides */
    uint8_t count;           /* 4, 2 or 1 */
    uint8_t channel[4];      /* entries past `count` have no meaning */
    uint8_t is_same_struct;  /* its elements lie in the same structs as those of the group before it */
};

/* Arrays over a picture, or over a part of it, with resolved strides. */
struct mlrt_sink {
    struct mlrt_image channel[MLRT_CHANNEL_COUNT]; /* without data: not wanted */
    uint32_t x, y;                                 /* where the part begins in the picture */
    /* Set by mlrt_group_channels. */
    uint32_t numbers; /* outputs that have to be computed for each hit: MLRT_OUTPUT_T, _UV and _FACING */
    uint32_t group_count;
    struct mlrt_sink_group groups[MLRT_CHANNEL_OCCLUDED];
};

/* The results of a packet: an array for each channel of 4 bytes, in the order of the channels. */
struct mlrt_packet_values {
    MLRT_ALIGNED(64) float t[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) float uv[2][MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) uint32_t mesh[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) uint32_t triangle[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) uint32_t facing[MLRT_PACKET_RAYS];
};

/*
 * Sets the channels of a sink: arrays that were checked, for a frame of `width` columns. `packed_rows`: rows follow
 * each other without gaps, and the arrays' row_stride is ignored (lists of rays).
 */
void mlrt_make_sink(const mlrt_hits *hits, uint32_t width, int packed_rows, struct mlrt_sink *sink);

/* Sets the fields of a sink that follow from its channels. */
void mlrt_group_channels(struct mlrt_sink *sink);

/* Is no channel of the sink wanted? */
int mlrt_sink_is_empty(const struct mlrt_sink *sink);

/* Bytes of one element. */
size_t mlrt_channel_size(enum mlrt_channel channel);

/* Lets the judge compute t, u, v and facing of a lane with a hit. Numbers outside of `outputs` have no meaning. */
void mlrt_report_lane(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t lane, uint32_t outputs,
                      struct mlrt_packet_values *values);

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

/* Sets *ray to the ray of a lane. If the packet has no masks, its mask is MLRT_MASK_ALL. */
void mlrt_get_segment(const struct mlrt_packet *packet, uint32_t lane, struct mlrt_ray_segment *ray);

/*
 * Loads the corners of the triangles that the lanes `hit` have hit, as they were given: corners[i] has coordinate i of
 * all lanes. Lanes without a hit get the triangle of a lane that has one.
 */
void mlrt_gather_corners(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t hit,
                         float corners[9][MLRT_PACKET_RAYS]);

/* Sets the ids of triangle `number`; those of a miss for MLRT_NONE. */
void mlrt_find_ids(const struct mlrt_tree *tree, uint32_t number, uint32_t *mesh, uint32_t *triangle);

/*
 * Sets all fields of a hit, `occluded` to 0, for triangle `number`; those of a miss for MLRT_NONE. The judge computes
 * the numbers that `outputs` asks for; the others have no meaning.
 */
void mlrt_set_hit(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t number, uint32_t outputs,
                  mlrt_hit *hit);

/* Sets the fields of a hit that a ray's query writes, for triangle `number`; a miss for MLRT_NONE. */
void mlrt_set_result(const struct mlrt_tree *tree, const struct mlrt_lone_ray *ray, uint32_t number, mlrt_hit *hit);

/* Writes `count` hits to all arrays of a list, which were checked, from element `first` on. */
void mlrt_write_hits(const mlrt_hit *hits, size_t first, uint32_t count, const mlrt_hits *list);

#endif
