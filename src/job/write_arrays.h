/* SPDX-License-Identifier: MIT */
/*
 * Results on their way out: to the caller's frame, to the buffer of a tile callback, or to both.
 */
#ifndef MLRT_JOB_WRITE_ARRAYS_H
#define MLRT_JOB_WRITE_ARRAYS_H

#include "exact/predicate.h"
#include "rays/packet.h"
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

/* Channels of 4 bytes whose elements lie beside each other in one struct, in the order of their addresses: they are
 * written together. */
struct mlrt_sink_group {
    unsigned char *data; /* of the first; the strides are those of all */
    size_t stride;
    size_t row_stride;
    uint8_t count;          /* 4, 2 or 1 */
    uint8_t channel[4];     /* those past the last are any */
    uint8_t is_same_struct; /* as that of the group before it */
};

/* Arrays over a picture, with resolved strides. data = NULL: not wanted. */
struct mlrt_sink {
    struct {
        unsigned char *data;
        size_t stride;
        size_t row_stride;
    } channel[MLRT_CHANNEL_COUNT];
    /* What follows from these: mlrt_group_channels. */
    uint32_t numbers; /* what mlrt_report_hit would have to work out: MLRT_OUTPUT_T, _UV and _FACING */
    uint32_t group_count;
    struct mlrt_sink_group groups[MLRT_CHANNEL_OCCLUDED];
};

/* What is reported of the hits of a packet: an array for each channel of 4 bytes, in their order. */
struct mlrt_packet_values {
    MLRT_ALIGNED(64) float t[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) float uv[2][MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) uint32_t mesh[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) uint32_t triangle[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) uint32_t facing[MLRT_PACKET_RAYS];
};

/* Of closest hits, of any-hit and shadows: bit per channel. */
#define MLRT_CHANNELS_CLOSEST  ((1u << MLRT_CHANNEL_OCCLUDED) - 1)
#define MLRT_CHANNELS_OCCLUDED (1u << MLRT_CHANNEL_OCCLUDED)

/*
 * Checks and resolves a frame of `width` columns that may have these channels. `packed_rows`: rows follow each other
 * without gaps, whatever the arrays' row_stride says (lists of rays).
 */
int32_t mlrt_make_sink(const mlrt_hits *hits, uint32_t channels, uint32_t width, int packed_rows,
                       struct mlrt_sink *sink);

/* Sets what follows from the channels. */
void mlrt_group_channels(struct mlrt_sink *sink);

/* Does the sink want anything? */
int mlrt_sink_is_empty(const struct mlrt_sink *sink);

/* Bytes of one element. */
size_t mlrt_channel_size(enum mlrt_channel channel);

/* t, u, v and facing of one lane, which hits something, by the judge; what is not asked for may be any number. */
void mlrt_report_lane(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t lane, uint32_t outputs,
                      struct mlrt_packet_values *values);

/* Writes values of the lanes `lanes` of a packet, whose block starts at (x, y) of the sink, to all channels of 4 bytes. */
void mlrt_write_values(const struct mlrt_packet_values *values, uint32_t lanes, uint32_t x, uint32_t y,
                       const struct mlrt_sink *sink);

/* Likewise, which lanes are occluded. */
void mlrt_write_occluded(uint32_t occluded, uint32_t lanes, uint32_t x, uint32_t y, const struct mlrt_sink *sink);

/* Adds `bit` to the shadows of the lanes `dark`, */
void mlrt_add_shadow(uint8_t shadows[MLRT_PACKET_RAYS], uint32_t dark, uint8_t bit);

/* and writes those of lanes. */
void mlrt_write_shadows(const uint8_t shadows[MLRT_PACKET_RAYS], uint32_t lanes, uint32_t x, uint32_t y,
                        const struct mlrt_sink *sink);

/* Has what a rectangle of at most 16 columns will be written to brought into the cache. */
void mlrt_prefetch_sink(uint32_t x, uint32_t y, uint32_t width, uint32_t height, const struct mlrt_sink *sink);

/* Writes misses to a rectangle. */
void mlrt_write_misses(uint32_t x, uint32_t y, uint32_t width, uint32_t height, const struct mlrt_sink *sink);

/* Writes the ids of one triangle to a rectangle of a sink without numbers. */
void mlrt_write_same_ids(const struct mlrt_tree *tree, uint32_t number, uint32_t x, uint32_t y, uint32_t width,
                         uint32_t height, const struct mlrt_sink *sink);

/* Writes one value to the channel `occluded` of a rectangle, if there is one. */
void mlrt_write_same_shadow(uint8_t occluded, uint32_t x, uint32_t y, uint32_t width, uint32_t height,
                            const struct mlrt_sink *sink);

/* The ray of a lane. Its mask is only known if the packet has masks. */
void mlrt_get_segment(const struct mlrt_packet *packet, uint32_t lane, struct mlrt_ray_segment *ray);

/* The position of the mesh that a triangle number belongs to. */
uint32_t mlrt_mesh_of_triangle(const struct mlrt_tree *tree, uint32_t number);

/* The ids that a triangle number is reported by; those of a miss for MLRT_NONE. */
void mlrt_find_ids(const struct mlrt_tree *tree, uint32_t number, uint32_t *mesh, uint32_t *triangle);

/* All of a hit but `occluded`, for the triangle with this number; that of a miss for MLRT_NONE. */
void mlrt_tell_hit(const struct mlrt_tree *tree, const mlrt_ray *ray, uint32_t number, mlrt_hit *hit);

#endif
