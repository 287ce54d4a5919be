/* SPDX-License-Identifier: MIT */
/*
 * The rays of a tile out of the caller's arrays, whatever their strides: a whole block a vector at a time. Blocks at the
 * end of a list, and those of which rows do not share elements evenly, are read by source.c.
 */

/* Where the elements of a block's lanes are, in bytes from that of its first ray. */
struct lane_offsets {
    size_t of[MLRT_PACKET_RAYS];
};

static void set_lane_offsets(size_t stride, size_t row_length, struct lane_offsets *offsets)
{
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        const size_t column = (lane & 1) | (lane >> 1 & 2), row = (lane >> 1 & 1) | (lane >> 2 & 2);
        offsets->of[lane] = (row * row_length + column) * stride;
    }
}

/* The arrays of a source as its whole blocks are read: the same for all blocks of a tile. */
struct array_reader {
    const struct mlrt_source *source;
    struct lane_offsets points;
    struct lane_offsets directions;
    struct lane_offsets t_min;
    struct lane_offsets t_max;
};

/* 0 if neighbours share origins in another way than sixteen at a time. */
static int begin_reading(const struct mlrt_source *source, struct array_reader *reader)
{
    const uint32_t group = source->rays_per_origin;
    if (source->kind == MLRT_SOURCE_CAMERA || (group > 1 && group % MLRT_PACKET_RAYS != 0)) return 0;
    reader->source = source;
    set_lane_offsets(group > 1 ? 0 : source->points.stride, source->width, &reader->points);
    set_lane_offsets(group > 1 ? 0 : source->t_min.stride, source->width, &reader->t_min);
    set_lane_offsets(source->directions.stride, source->width, &reader->directions);
    set_lane_offsets(source->t_max.stride, source->width, &reader->t_max);
    return 1;
}

MLRT_INLINE const unsigned char *element_at(const mlrt_const_array *array, size_t element)
{
    return (const unsigned char *)array->data + element * array->stride;
}

/* Reads the rays of a whole block; not skips and masks. */
static void read_whole_block(const struct array_reader *reader, uint32_t x, uint32_t y, struct mlrt_packet *packet)
{
    const struct mlrt_source *source = reader->source;
    const size_t first = (size_t)y * source->width + x, origin = first / source->rays_per_origin;
    const unsigned char *points = element_at(&source->points, origin), *directions = points, *t_min = points, *t_max = points;
    const int is_rays = source->kind == MLRT_SOURCE_RAYS, is_point = source->kind == MLRT_SOURCE_POINT_LIGHT;
    if (is_rays) directions = element_at(&source->directions, first);
    if (is_rays && source->t_min.data) t_min = element_at(&source->t_min, origin);
    if (is_rays && source->t_max.data) t_max = element_at(&source->t_max, first);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vf point[3], direction[3];
        v_triples_at(points, reader->points.of + v, point);
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) {
            const vf light = v_set1(source->light[k]);
            if (is_point) point[k] = v_sub(point[k], light);
            v_store((is_point ? packet->direction : packet->origin)[k] + v, point[k]);
            if (!is_rays && !is_point) v_store(packet->direction[k] + v, light);
        }
        if (is_rays) {
            v_triples_at(directions, reader->directions.of + v, direction);
            MLRT_UNROLL
            for (int k = 0; k < 3; ++k) v_store(packet->direction[k] + v, direction[k]);
        }
        v_store(packet->t_min + v, t_min != points ? v_floats_at(t_min, reader->t_min.of + v) : v_set1(0));
        v_store(packet->t_max + v, t_max != points ? v_floats_at(t_max, reader->t_max.of + v)
                                                   : v_set1(is_point ? 1 : INFINITY));
    }
    packet->has_apex = is_point;
    if (is_point) memcpy(packet->apex, source->light, sizeof packet->apex);
    packet->has_limits = t_min != points || t_max != points;
    packet->has_masks = 0;
}
