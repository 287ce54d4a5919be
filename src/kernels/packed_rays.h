/* SPDX-License-Identifier: MIT */
/*
 * Rays of one apex that lie packed in arrays, read and checked in one go: what fetch_block and check_block do of any
 * rays. What makes packets of these costs as much as tracing them where triangles are large.
 */

/* May blocks be read so? All rays have the same limits, and nothing lies between their vectors. */
MLRT_INLINE int has_packed_rays(const struct mlrt_source *source)
{
#if VW < 8
    (void)source;
    return 0;
#else
    if (source->has_masks || source->points.stride != 12) return 0;
    return source->kind == MLRT_SOURCE_POINT_LIGHT ||
           (source->kind == MLRT_SOURCE_RAYS && source->directions.stride == 12 && !source->t_min.data &&
            !source->t_max.data);
#endif
}

#if VW >= 8
/* Have all rays of a block one origin? */
MLRT_INLINE int is_apex(const float apex[3], const float *origins, size_t step)
{
    uint32_t same = ALL_LANES;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vf o[3];
        v_triples(origins + (size_t)(v / 4) * step, step, o);
        for (int k = 0; k < 3; ++k) same &= m_bits(v_eq(o[k], v_set1(apex[k])));
    }
    return same == ALL_LANES;
}

/* A whole block at (x, y); 0 if it has to be read as others are. */
static int read_packed_rays(const struct mlrt_source *source, uint32_t x, uint32_t y, struct mlrt_packet *packet)
{
    const int is_light = source->kind == MLRT_SOURCE_POINT_LIGHT;
    const size_t first = 3 * ((size_t)y * source->width + x), step = 3 * (size_t)source->width;
    const float *points = (const float *)source->points.data + first;
    memcpy(packet->apex, is_light ? source->light : points, sizeof packet->apex);
    if (!mlrt_are_float_safe(packet->apex) || !(is_light || is_apex(packet->apex, points, step))) return 0;
    const float *directions = is_light ? points : (const float *)source->directions.data + first;
    const vf from[3] = {v_set1(is_light ? packet->apex[0] : 0), v_set1(is_light ? packet->apex[1] : 0),
                        v_set1(is_light ? packet->apex[2] : 0)};
    struct checked_lanes lanes = {0, 0};
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vf d[3];
        v_triples(directions + (size_t)(v / 4) * step, step, d);
        for (int k = 0; k < 3; ++k) d[k] = v_sub(d[k], from[k]);
        take_directions(d, v, packet, &lanes);
        take_limits(v_set1(0), v_set1(is_light ? 1 : INFINITY), v, packet);
    }
    packet->active = lanes.valid & lanes.safe;
    packet->single = lanes.valid & ~lanes.safe;
    packet->has_apex = 1;
    packet->has_limits = packet->has_masks = 0;
    packet->shear = NULL;
    mlrt_fetch_skips(source, x, y, 0xFFFF, packet);
    return 1;
}
#else
MLRT_INLINE int read_packed_rays(const struct mlrt_source *source, uint32_t x, uint32_t y, struct mlrt_packet *packet)
{
    (void)source, (void)x, (void)y, (void)packet;
    return 0;
}
#endif
