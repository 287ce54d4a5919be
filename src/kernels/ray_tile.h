/* SPDX-License-Identifier: MIT */
/*
 * Cells made of the packets of a tile (tile.h), and which of them are too wide.
 */

/* The greatest depth at which rays of a packet still look. */
MLRT_INLINE float farthest_depth(const struct mlrt_packet *packet, int main_axis)
{
    vf farthest = v_set1(-INFINITY);
    KEEP_LANES_LOOP
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf depth = v_mul(v_load(packet->hi + v), v_abs(v_load(packet->direction[main_axis] + v)));
        farthest = v_max(v_select(m_from_bits(packet->active >> v), depth, v_set1(-INFINITY)), farthest);
    }
    return v_hmax(farthest) * (1 + SLOPE_SLACK);
}

/* The depth that all rays of a packet reach, before they meet anything. */
MLRT_INLINE float shortest_depth(const struct mlrt_packet *packet, int main_axis)
{
    vf shortest = v_set1(INFINITY);
    KEEP_LANES_LOOP
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf depth = v_mul(v_load(packet->lo + v), v_abs(v_load(packet->direction[main_axis] + v)));
        shortest = v_min(v_select(m_from_bits(packet->active >> v), depth, v_set1(INFINITY)), shortest);
    }
    return v_hmin(shortest) * (1 - SLOPE_SLACK);
}

/* Can a cell of this packet be closed? Its rays must begin at 0, and pass the same triangle, if any. */
MLRT_INLINE int can_be_closed(const struct mlrt_packet *packet, uint32_t *skip)
{
    *skip = packet->has_skip ? packet->skip[mlrt_lowest_bit(packet->active)] : MLRT_NONE;
    uint32_t others = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vm same = m_from_bits(ALL_LANES);
        if (packet->has_limits) same = v_eq(v_load(packet->t_min + v), v_set1(0));
        if (packet->has_skip) same = m_and(same, i_eq(i_load(packet->skip + v), i_set1(*skip)));
        others |= (~m_bits(same) & ALL_LANES) << v;
    }
    return !(others & packet->active);
}

/* The greatest depth of a packet's directions. */
MLRT_INLINE float greatest_direction(const struct mlrt_packet *packet, int main_axis)
{
    vf greatest = v_set1(0);
    KEEP_LANES_LOOP
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf depth = v_abs(v_load(packet->direction[main_axis] + v));
        greatest = v_max(v_select(m_from_bits(packet->active >> v), depth, v_set1(0)), greatest);
    }
    return v_hmax(greatest);
}

/* triangle_filter.h's R of a packet: no |d_j| is more than the steepest slope times the greatest |d_main|. */
MLRT_INLINE float packet_reach(const struct mlrt_ray_tile *tile, uint32_t place)
{
    return tile->greatest_depth[place] * tile->cells.slope_bound;
}

/* Makes a cell of a packet's rays; 0 if they do not agree with the main axis, or are wide. */
static MLRT_NOINLINE int add_packet(struct mlrt_ray_tile *tile, uint32_t place)
{
    struct mlrt_cells *cells = &tile->cells;
    struct mlrt_packet *packet = &tile->packets[place];
    const int a = cells->main_axis;
    int limits_below = 0;
    if (mlrt_are_sheared(cells) && !mlrt_shear_packet(&cells->shear, packet, &cells->begin, &limits_below)) return 0;
    const float slack = mlrt_are_sheared(cells) ? MLRT_SHEAR_SLACK : 0;
    uint32_t forward = 0;
    vf lo[2] = {v_set1(INFINITY), v_set1(INFINITY)}, hi[2] = {v_set1(-INFINITY), v_set1(-INFINITY)};
    KEEP_LANES_LOOP
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vm active = m_from_bits(packet->active >> v);
        const vf depth = v_flip(v_load(packet->direction[a] + v), v_set1(cells->sign));
        const vf inverse = v_div(v_set1(1), depth);
        forward |= m_bits(v_gt(depth, v_set1(0))) << v;
        for (int side = 0; side < 2; ++side) {
            const vf slope = v_mul(v_load(packet->direction[(a + 1 + side) % 3] + v), inverse);
            lo[side] = v_min(v_select(active, slope, v_set1(INFINITY)), lo[side]);
            hi[side] = v_max(v_select(active, slope, v_set1(-INFINITY)), hi[side]);
        }
    }
    if (packet->active & ~forward) return 0;
    float least[2], greatest[2];
    for (int side = 0; side < 2; ++side) {
        least[side] = v_hmin(lo[side]);
        greatest[side] = v_hmax(hi[side]);
        if (!(least[side] >= -STEEPEST_SLOPE && greatest[side] <= STEEPEST_SLOPE)) return 0;
        if (greatest[side] - least[side] > WIDEST_PACKET) return 0;
    }
    for (int side = 0; side < 2; ++side) {
        mlrt_set_cell_slopes(cells, place, side, least[side] - fabsf(least[side]) * SLOPE_SLACK - slack,
                             greatest[side] + fabsf(greatest[side]) * SLOPE_SLACK + slack);
    }
    tile->greatest_depth[place] = greatest_direction(packet, a);
    cells->farthest[place] = cells->shortest[place] = INFINITY;
    if (packet->has_limits || packet->shear || packet->t_max[mlrt_lowest_bit(packet->active)] < INFINITY) {
        cells->farthest[place] = farthest_depth(packet, a);
        cells->shortest[place] = shortest_depth(packet, a);
    }
    if (packet->has_limits || packet->shear) {
        tile->limits_below |= packet->shear ? limits_below : highest(packet->t_min, packet->active) > 0;
        if (limits_below) return 1;
    }
    cells->closed |= (uint32_t)can_be_closed(packet, &cells->skip[place]) << place;
    return 1;
}

/* Of packets of these widths, those wider than MLRT_WIDE_FACTOR times most: than a quarter of them, as edges may be
 * many. */
static MLRT_SMALL uint32_t find_widest(const float widths[MLRT_CELL_COUNT], uint32_t gathered, float *limit)
{
    float sorted[MLRT_CELL_COUNT] = {0};
    uint32_t count = 0, wide = 0;
    for (uint32_t left = gathered; left; left &= left - 1) {
        const float width = widths[mlrt_lowest_bit(left)];
        uint32_t at = count++;
        for (; at > 0 && sorted[at - 1] > width; --at) sorted[at] = sorted[at - 1];
        sorted[at] = width;
    }
    *limit = MLRT_WIDE_FACTOR * sorted[count / 4];
    for (uint32_t left = gathered; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        if (widths[place] > *limit) wide |= 1u << place;
    }
    return wide;
}

/*
 * Of the packets `gathered`, those far wider than most, which lie across an edge of what the tile is about: they would
 * meet all that lies between their rays. If there are any, *limit receives how wide the others are at most.
 */
static uint32_t find_wide_packets(const struct mlrt_cells *cells, uint32_t gathered, float *limit)
{
    MLRT_ALIGNED(64) float widths[MLRT_CELL_COUNT];
    vf least = v_set1(INFINITY), greatest = v_set1(0);
    for (int v = 0; v < MLRT_CELL_COUNT; v += VW) {
        const vf columns = v_sub(v_load(cells->slopes[0].hi + v), v_load(cells->slopes[0].lo + v));
        const vf rows = v_sub(v_load(cells->slopes[1].hi + v), v_load(cells->slopes[1].lo + v));
        const vf width = v_max(columns, rows);
        v_store(widths + v, width);
        least = v_min(v_select(m_from_bits(gathered >> v), width, v_set1(INFINITY)), least);
        greatest = v_max(width, greatest);
    }
    if (MLRT_LIKELY(v_hmax(greatest) <= MLRT_WIDE_FACTOR * v_hmin(least))) return 0;
    return find_widest(widths, gathered, limit);
}

/* Of `lanes`, those whose slopes are at most half of `width` from those of the first. */
static uint32_t lanes_near_first(const struct mlrt_packet *packet, uint32_t lanes, int main_axis, float width)
{
    const uint32_t first = mlrt_lowest_bit(lanes);
    uint32_t near = lanes;
    for (int side = 1; side < 3; ++side) {
        const float *direction = packet->direction[(main_axis + side) % 3], *depth = packet->direction[main_axis];
        const vf slope = v_set1(direction[first] / depth[first]);
        for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
            const vf distance = v_abs(v_sub(v_div(v_load(direction + v), v_load(depth + v)), slope));
            near &= ~((~m_bits(v_le(distance, v_set1(0.5f * width))) & ALL_LANES) << v);
        }
    }
    return near | 1u << first;
}

/* Likewise, from rays of one direction, of which this lane has one. */
static MLRT_SMALL void set_packet_shear(const struct mlrt_job *job, const struct mlrt_packet *packet, uint32_t lane,
                                        struct mlrt_cells *cells)
{
    const float direction[3] = {packet->direction[0][lane], packet->direction[1][lane], packet->direction[2][lane]};
    const float origin[3] = {packet->origin[0][lane], packet->origin[1][lane], packet->origin[2][lane]};
    set_shear(job, direction, origin, cells);
}

/* Does a packet that is to go with others see things as these cells do? */
MLRT_INLINE int is_seen_so(const struct mlrt_packet *packet, const struct mlrt_cells *cells)
{
    if (MLRT_UNLIKELY(!packet->has_apex)) return mlrt_has_direction(packet, &cells->shear);
    return !mlrt_are_sheared(cells) && memcmp(packet->apex, cells->apex, sizeof cells->apex) == 0;
}

/*
 * Makes cells of the packets of `waiting` (bit per place) that can go together with the first of them, and returns
 * which. *wide receives those that are wider than *width, which is too much; or the first, if not even that can go.
 */
static uint32_t gather_packets(const struct mlrt_job *job, struct mlrt_ray_tile *tile, uint32_t waiting, uint32_t *wide,
                               float *width)
{
    struct mlrt_cells *cells = &tile->cells;
    const struct mlrt_packet *first = &tile->packets[mlrt_lowest_bit(waiting)];
    const uint32_t lane = mlrt_lowest_bit(first->active);
    if (MLRT_LIKELY(first->has_apex)) {
        const float direction[3] = {first->direction[0][lane], first->direction[1][lane], first->direction[2][lane]};
        set_main_axis_of(direction, cells);
        memcpy(cells->apex, first->apex, sizeof cells->apex);
        memset(&cells->shear, 0, sizeof cells->shear);
    } else {
        set_packet_shear(job, first, lane, cells);
        cells->begin = INFINITY;
    }
    cells->closed = 0;
    cells->tile = tile;
    tile->limits_below = 0;
    uint32_t gathered = 0;
    for (uint32_t place = 0; place < MLRT_CELL_COUNT; ++place) {
        if (waiting >> place & 1 && is_seen_so(&tile->packets[place], cells) && add_packet(tile, place)) {
            gathered |= 1u << place;
        } else {
            if (tile->packets[place].shear && waiting >> place & 1) mlrt_unshear_packet(&tile->packets[place]);
            mlrt_leave_out_cell(cells, place);
        }
    }
    *width = WIDEST_PART;
    *wide = find_wide_packets(cells, gathered, width);
    for (uint32_t left = *wide; left; left &= left - 1) mlrt_leave_out_cell(cells, mlrt_lowest_bit(left));
    cells->closed &= ~*wide;
    if (!gathered) *wide = waiting & (0u - waiting);
    return gathered & ~*wide;
}
