/* SPDX-License-Identifier: MIT */
/*
 * Rays of one apex or one direction that lie packed in arrays, read and checked in one go: what fetch_block and
 * check_block do of any rays. What makes packets of these costs as much as tracing them where triangles are large.
 */

MLRT_INLINE int is_zero(const float vector[3])
{
    return vector[0] == 0 && vector[1] == 0 && vector[2] == 0;
}

/* May blocks be read so? All rays have the same limits, nothing lies between their vectors, and lights are no trouble.
 */
MLRT_INLINE int has_packed_rays(const struct mlrt_source *source)
{
#if VW < 8
    (void)source;
    return 0;
#else
    if (source->kind == MLRT_SOURCE_CAMERA || source->has_masks || source->points.stride != 12) return 0;
    if (source->kind == MLRT_SOURCE_RAYS) {
        return source->directions.stride == 12 && !source->t_min.data && !source->t_max.data;
    }
    return mlrt_are_float_safe(source->light) && (source->kind == MLRT_SOURCE_POINT_LIGHT || !is_zero(source->light));
#endif
}

#if VW >= 8
/* Are the vectors of a block all the same as the first? A row of them is three quads. */
static MLRT_NOINLINE int are_same_vectors(const float *vectors, size_t step)
{
    const float *v = vectors;
    const float repeated[12] = {v[0], v[1], v[2], v[0], v[1], v[2], v[0], v[1], v[2], v[0], v[1], v[2]};
    const f4 quads[3] = {f4_load_any(repeated), f4_load_any(repeated + 4), f4_load_any(repeated + 8)};
    f4 same = f4_set1(-1);
    for (int row = 0; row < 4; ++row, v += step) {
        for (int i = 0; i < 3; ++i) same = f4_and_same(same, v + 4 * i, quads[i]);
    }
    return f4_signs(same) == 15;
}

/* Rays that begin at packet->apex. `ends`: their directions, or where they end. */
MLRT_INLINE void read_rays_of_apex(const float *ends, size_t step, int is_light, struct mlrt_packet *packet,
                                   struct checked_lanes *lanes)
{
    const vf from[3] = {v_set1(is_light ? packet->apex[0] : 0), v_set1(is_light ? packet->apex[1] : 0),
                        v_set1(is_light ? packet->apex[2] : 0)};
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vf d[3];
        v_triples(ends + (size_t)(v / 4) * step, step, d);
        for (int k = 0; k < 3; ++k) d[k] = v_sub(d[k], from[k]);
        take_directions(d, v, packet, lanes);
        take_limits(v_set1(0), v_set1(is_light ? 1 : INFINITY), v, packet);
    }
}

/* Rays that all have this direction, which is not 0. */
MLRT_INLINE void read_rays_of_direction(const float direction[3], const float *origins, size_t step,
                                        struct mlrt_packet *packet, struct checked_lanes *lanes)
{
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vf o[3];
        v_triples(origins + (size_t)(v / 4) * step, step, o);
        for (int k = 0; k < 3; ++k) {
            v_store(packet->origin[k] + v, o[k]);
            v_store(packet->direction[k] + v, v_set1(direction[k] + 0.0f));
        }
        const struct checked_vectors checked = check_vectors(o);
        take_limits(v_set1(0), v_set1(INFINITY), v, packet);
        add_checked_vectors(&checked, v, lanes);
        lanes->nonzero = 0xFFFF;
    }
}

/* A whole block at (x, y); 0 if it has to be read as others are. */
static int read_packed_rays(const struct mlrt_source *source, uint32_t x, uint32_t y, struct mlrt_packet *packet)
{
    const int is_light = source->kind == MLRT_SOURCE_POINT_LIGHT,
              is_sun = source->kind == MLRT_SOURCE_DIRECTIONAL_LIGHT;
    const size_t first = 3 * ((size_t)y * source->width + x), step = 3 * (size_t)source->width;
    const float *points = (const float *)source->points.data + first;
    const float *directions = is_sun     ? source->light
                              : is_light ? points
                                         : (const float *)source->directions.data + first;
    struct checked_lanes lanes = {0, 0, 0};
    memcpy(packet->apex, is_light ? source->light : points, sizeof packet->apex);
    packet->has_apex = is_light || (!is_sun && are_same_vectors(points, step));
    if (packet->has_apex) {
        if (!is_light && !mlrt_are_float_safe(packet->apex)) return 0;
        read_rays_of_apex(directions, step, is_light, packet, &lanes);
    } else {
        if (!is_sun && !are_same_vectors(directions, step)) return 0;
        if (!is_sun && (!mlrt_are_float_safe(directions) || is_zero(directions))) return 0;
        read_rays_of_direction(directions, points, step, packet, &lanes);
    }
    const uint32_t valid = lanes.finite & lanes.nonzero;
    packet->active = valid & lanes.safe;
    packet->single = valid & ~lanes.safe;
    packet->has_direction = !packet->has_apex;
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
