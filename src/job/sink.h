/* SPDX-License-Identifier: MIT */
/* Sinks: where results go. The arrays of the caller's frame, or of a tile callback, and how their elements lie. */
#ifndef MLRT_JOB_SINK_H
#define MLRT_JOB_SINK_H

#include <stddef.h>
#include <stdint.h>

#include "base/platform.h"
#include "mlrt.h"

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

/* Bytes of one element. */
MLRT_INLINE size_t mlrt_channel_size(enum mlrt_channel channel)
{
    return channel == MLRT_CHANNEL_OCCLUDED ? 1 : 4;
}

/* The array of a channel. Arrays of mlrt_hits lie in the order of channels, and so do the fields of mlrt_hit. */
MLRT_INLINE const mlrt_array *mlrt_array_of(const mlrt_hits *hits, enum mlrt_channel c)
{
    return (const mlrt_array *)(const void *)((const unsigned char *)hits + offsetof(mlrt_hits, t)) + c;
}

/* Its resolved stride. */
MLRT_INLINE size_t mlrt_stride_of(const mlrt_array *array, enum mlrt_channel c)
{
    return array->stride ? array->stride : mlrt_channel_size(c);
}

/*
 * Sets the channels of a sink: arrays that were checked, for a frame of `width` columns. `packed_rows`: rows follow
 * each other without gaps, and the arrays' row_stride is ignored (lists of rays).
 */
void mlrt_make_sink(const mlrt_hits *hits, uint32_t width, int packed_rows, struct mlrt_sink *sink);

/* Sets the fields of a sink that follow from its channels. */
void mlrt_group_channels(struct mlrt_sink *sink);

/* Is no channel of the sink wanted? */
int mlrt_sink_is_empty(const struct mlrt_sink *sink);

#endif
