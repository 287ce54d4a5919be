/* SPDX-License-Identifier: MIT */
/* See sink.h. */
#include "job/sink.h"

#include <string.h>

/* How many bytes the elements of `second` lie behind those of `first`; SIZE_MAX if their strides differ. */
static size_t distance_of(const struct mlrt_image *first, const struct mlrt_image *second)
{
    const int is_alike = first->stride == second->stride && first->row_stride == second->row_stride;
    return is_alike ? (uintptr_t)second->data - (uintptr_t)first->data : SIZE_MAX;
}

/* The channel of the set whose elements lie `distance` bytes behind those of `first`; MLRT_CHANNEL_COUNT if none do. */
static int find_channel(const struct mlrt_sink *sink, uint32_t channels, const struct mlrt_image *first,
                        size_t distance)
{
    int c = 0;
    while (c < MLRT_CHANNEL_OCCLUDED && !(channels >> c & 1 && distance_of(first, &sink->channel[c]) == distance)) ++c;
    return c < MLRT_CHANNEL_OCCLUDED ? c : MLRT_CHANNEL_COUNT;
}

/* The channel of the set that has the lowest address. */
static int find_lowest_channel(const struct mlrt_sink *sink, uint32_t channels)
{
    int lowest = (int)mlrt_lowest_bit(channels);
    while (channels &= channels - 1) {
        const int c = (int)mlrt_lowest_bit(channels);
        if ((uintptr_t)sink->channel[c].data < (uintptr_t)sink->channel[lowest].data) lowest = c;
    }
    return lowest;
}

/*
 * Makes a group of channels of the set, and returns them: the first one if it is packed, or else those that begin with
 * the lowest. They fit into one stride, so that the structs of neighbouring pixels do not overlap.
 */
static uint32_t make_group(const struct mlrt_sink *sink, uint32_t channels, struct mlrt_sink_group *group)
{
    uint32_t taken = 0;
    int c = (int)mlrt_lowest_bit(channels);
    if (sink->channel[c].stride > 4) c = find_lowest_channel(sink, channels);
    group->image = sink->channel[c];
    group->count = 0;
    memset(group->channel, 0, sizeof group->channel);
    do {
        group->channel[group->count++] = (uint8_t)c;
        if (group->count == 4 || 4u * (group->count + 1u) > group->image.stride) break;
        c = find_channel(sink, channels, &group->image, 4 * (size_t)group->count);
    } while (c != MLRT_CHANNEL_COUNT);
    if (group->count == 3) group->count = 2;
    for (uint32_t i = 0; i < group->count; ++i) taken |= 1u << group->channel[i];
    return taken;
}

void mlrt_group_channels(struct mlrt_sink *sink)
{
    const uint32_t uv = 1u << MLRT_CHANNEL_U | 1u << MLRT_CHANNEL_V;
    uint32_t channels = 0;
    for (int c = 0; c < MLRT_CHANNEL_OCCLUDED; ++c) channels |= (uint32_t)(sink->channel[c].data != NULL) << c;
    sink->numbers = (channels >> MLRT_CHANNEL_T & 1 ? (uint32_t)MLRT_OUTPUT_T : 0) |
                    (channels & uv ? (uint32_t)MLRT_OUTPUT_UV : 0) |
                    (channels >> MLRT_CHANNEL_FACING & 1 ? (uint32_t)MLRT_OUTPUT_FACING : 0);
    sink->group_count = 0;
    while (channels) {
        struct mlrt_sink_group *group = &sink->groups[sink->group_count];
        channels &= ~make_group(sink, channels, group);
        group->is_same_struct =
            sink->group_count > 0 && distance_of(&group[-1].image, &group->image) < group->image.stride;
        ++sink->group_count;
    }
}

void mlrt_make_sink(const mlrt_hits *hits, uint32_t width, int packed_rows, struct mlrt_sink *sink)
{
    for (int c = 0; c < MLRT_CHANNEL_COUNT; ++c) {
        const mlrt_array *array = mlrt_array_of(hits, (enum mlrt_channel)c);
        sink->channel[c].data = array->data;
        if (!array->data) continue;
        const size_t stride = mlrt_stride_of(array, (enum mlrt_channel)c);
        const size_t row_stride = packed_rows || !array->row_stride ? stride * width : array->row_stride;
        sink->channel[c] = (struct mlrt_image){array->data, stride, row_stride};
    }
    sink->x = sink->y = 0;
}

int mlrt_sink_is_empty(const struct mlrt_sink *sink)
{
    for (int c = 0; c < MLRT_CHANNEL_COUNT; ++c)
        if (sink->channel[c].data) return 0;
    return 1;
}
