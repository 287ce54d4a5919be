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
    if (source->rays_per_origin > 1) return 0;
    if (source->skip.data && source->skip.stride != 8) return 0;
    if (source->kind == MLRT_SOURCE_RAYS) {
        return source->directions.stride == 12 && !source->t_min.data && !source->t_max.data;
    }
    return mlrt_are_float_safe(source->light) && (source->kind == MLRT_SOURCE_POINT_LIGHT || !is_zero(source->light));
#endif
}

#if VW >= 8
/* Are the vectors of a block all `v`? A row of them is three quads. */
static MLRT_NOINLINE int are_same_vectors(const float *vectors, size_t step, const float v[3])
{
    const float repeated[12] = {v[0], v[1], v[2], v[0], v[1], v[2], v[0], v[1], v[2], v[0], v[1], v[2]};
    const f4 quads[3] = {f4_load_any(repeated), f4_load_any(repeated + 4), f4_load_any(repeated + 8)};
    f4 same = f4_set1(-1);
    for (int row = 0; row < 4; ++row, vectors += step) {
        for (int i = 0; i < 3; ++i) same = f4_and_same(same, vectors + 4 * i, quads[i]);
    }
    return f4_signs(same) == 15;
}

/* Differences of packed vectors and one, in rows of a packet, checked. */
MLRT_INLINE struct checked_lanes read_packed_vectors(const float *vectors, size_t step, const float from[3],
                                                     float (*rows)[MLRT_PACKET_RAYS], float t_max,
                                                     struct mlrt_packet *packet)
{
    struct checked_lanes lanes = {0xFFFF, 0xFFFF, 0xFFFF};
    struct usual_vectors all = NO_VECTORS;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vf a[3];
        v_triples(vectors + (size_t)(v / 4) * step, step, a);
        for (int k = 0; k < 3; ++k) {
            a[k] = v_sub(a[k], v_set1(from[k]));
            v_store(rows[k] + v, a[k]);
        }
        add_usual_vectors(a, &all);
        take_limits(v_set1(0), v_set1(t_max), v, packet);
    }
    if (!are_usual(&all)) check_lanes(rows, &lanes);
    return lanes;
}

/*
 * What the rays of a block pass: pairs of mesh and triangle, as numbers. Neighbours mostly pass triangles of one mesh,
 * or nothing.
 */
MLRT_INLINE void read_packed_skips(const struct mlrt_source *source, uint32_t x, uint32_t y, struct known_mesh *known,
                                   struct mlrt_packet *packet)
{
    enum { VECTORS = MLRT_PACKET_RAYS / VW };
    packet->has_skip = source->skip.data != NULL;
    if (!source->skip.data) return;
    const uint32_t *pairs = (const uint32_t *)source->skip.data + 2 * ((size_t)y * source->width + x);
    const size_t step = 2 * (size_t)source->width;
    vi triangle[VECTORS];
    vm same = m_from_bits(ALL_LANES);
    for (int i = 0; i < VECTORS; ++i) {
        vi mesh;
        i_pairs(pairs + (size_t)(VW / 4 * i) * step, step, &mesh, &triangle[i]);
        same = m_and(same, i_eq(mesh, i_set1(pairs[0])));
    }
    if (MLRT_UNLIKELY(m_bits(same) != ALL_LANES)) {
        mlrt_fetch_skips(source, x, y, 0xFFFF, packet);
        mlrt_number_skips(source->tree, packet);
        return;
    }
    find_mesh(source->tree, pairs[0], known);
    for (int i = 0; i < VECTORS; ++i) i_store(packet->skip + VW * i, numbers_in_mesh(known, triangle[i]));
}

/*
 * A whole block at (x, y); 0 if it has to be read as others are. Of directions -0 is to become 0: a - -0 is 0 for both,
 * and a - 0 leaves origins as they are.
 */
MLRT_INLINE int read_packed_rays(const struct mlrt_source *source, uint32_t x, uint32_t y, struct mlrt_packet *packet)
{
    const int is_light = source->kind == MLRT_SOURCE_POINT_LIGHT,
              is_sun = source->kind == MLRT_SOURCE_DIRECTIONAL_LIGHT;
    const size_t first = 3 * ((size_t)y * source->width + x), step = 3 * (size_t)source->width;
    const float *points = (const float *)source->points.data + first;
    const float *directions = is_sun     ? source->light
                              : is_light ? points
                                         : (const float *)source->directions.data + first;
    memcpy(packet->apex, is_light ? source->light : points, sizeof packet->apex);
    packet->has_apex = is_light || (!is_sun && are_same_vectors(points, step, points));
    packet->has_direction = !packet->has_apex;
    const float *same = packet->has_apex ? packet->apex : directions;
    if (!packet->has_apex && !is_sun && !are_same_vectors(directions, step, directions)) return 0;
    if (source->kind == MLRT_SOURCE_RAYS && (!mlrt_are_float_safe(same) || (!packet->has_apex && is_zero(same))))
        return 0;
    float from[3] = {0, 0, 0};
    for (int k = 0; k < 3 && packet->has_apex; ++k) from[k] = is_light ? -(0 - packet->apex[k]) : -0.0f;
    struct checked_lanes lanes =
        read_packed_vectors(packet->has_apex ? directions : points, step, from,
                            packet->has_apex ? packet->direction : packet->origin, is_light ? 1 : INFINITY, packet);
    if (!packet->has_apex) lanes.nonzero = 0xFFFF;
    for (int v = 0; v < MLRT_PACKET_RAYS && !packet->has_apex; v += VW) {
        for (int k = 0; k < 3; ++k) v_store(packet->direction[k] + v, v_set1(same[k] + 0.0f));
    }
    const uint32_t valid = lanes.finite & lanes.nonzero;
    packet->active = valid & lanes.safe;
    packet->single = valid & ~lanes.safe;
    packet->has_limits = packet->has_masks = 0;
    packet->shear = NULL;
    return 1;
}
#endif

/* In front of a row of blocks: see mlrt_prefetch_around. */
MLRT_INLINE void prefetch_row_of_blocks(const struct mlrt_source *source, const struct mlrt_ray_tile *tile,
                                        uint32_t place)
{
    if (tile->column_bits && place % 4 == 0) mlrt_prefetch_around(source, &tile->area, place);
}

/* Reads whole blocks of a tile, up to one that has to be read as others are. Returns their places. */
MLRT_INLINE uint32_t read_packed_blocks(const struct mlrt_source *source, struct mlrt_ray_tile *tile)
{
    uint32_t done = 0;
#if VW >= 8
    const struct mlrt_rectangle *area = &tile->area;
    const int is_short = (uint64_t)(area->y + area->height - 1) * source->width + area->x + area->width > source->count;
    struct known_mesh known = NO_MESH;
    if (!has_packed_rays(source)) return 0;
    const uint32_t whole = mlrt_places(tile->column_bits, area->width / 4, (area->height - (uint32_t)is_short) / 4);
    for (uint32_t left = whole; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        const struct mlrt_rectangle block = mlrt_block_of_tile(tile, place);
        prefetch_row_of_blocks(source, tile, place);
        if (!read_packed_rays(source, block.x, block.y, &tile->packets[place])) break;
        read_packed_skips(source, block.x, block.y, &known, &tile->packets[place]);
        done |= 1u << place;
    }
#else
    (void)source, (void)tile;
#endif
    return done;
}
