/* SPDX-License-Identifier: MIT */
/*
 * Cells made of the packets of a tile (tile.h).
 */

/* The greatest depth at which rays of a packet still look. */
static MLRT_NOINLINE float farthest_depth(const struct mlrt_packet *packet, int main_axis)
{
    vf farthest = v_set1(-INFINITY);
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

/* Sets the slopes of a packet's cell, and what rounding may move them by besides; 0 if they are steep or wide. */
MLRT_INLINE int set_packet_slopes(struct mlrt_cells *cells, uint32_t place, const struct extremes slopes[2],
                                  float slack)
{
    MLRT_ALIGNED(16) float least[4];
    const f4 all = v_hmin4(slopes[0].least, slopes[1].least, slopes[0].negated, slopes[1].negated);
    const f4 moved = f4_sub(f4_sub(all, f4_mul(f4_abs(all), f4_set1(SLOPE_SLACK))), f4_set1(slack));
    const f4 width = f4_add(f4_low(all, all), f4_high(all, all)); /* negated, twice each */
    const f4 is_steep = f4_add(all, f4_set1(STEEPEST_SLOPE)), is_wide = f4_add(width, f4_set1(WIDEST_PACKET));
    if (f4_signs(is_steep) | f4_signs(is_wide)) return 0;
    f4_store(least, moved);
    for (int side = 0; side < 2; ++side) mlrt_set_cell_slopes(cells, place, side, least[side], -least[2 + side]);
    return 1;
}

/* Of the directions of rays: how deep they go, and their slopes. */
struct direction_extremes {
    struct extremes depth;
    struct extremes slopes[2];
};

#define NO_DIRECTIONS ((struct direction_extremes){NO_EXTREMES, {NO_EXTREMES, NO_EXTREMES}})

/* Adds a vector of directions, by axis from the main one on. Where that is a NaN there is none. */
MLRT_INLINE void add_directions(const vf d[3], vf sign, struct direction_extremes *of)
{
    const vf depth = v_flip(d[0], sign), inverse = v_div(v_set1(1), depth);
    add_to_extremes(depth, &of->depth);
    for (int side = 0; side < 2; ++side) add_to_extremes(v_mul(d[1 + side], inverse), &of->slopes[side]);
}

/* Makes a cell of rays that all end at `t_max`; 0 if they do not agree with the main axis, or are wide. */
MLRT_INLINE int set_cell_of_directions(struct mlrt_cells *cells, uint32_t place, const struct direction_extremes *of,
                                       float t_max, float *greatest_depth)
{
    MLRT_ALIGNED(16) float depth[4];
    f4_store(depth, v_hmin4(of->depth.least, of->depth.negated, of->depth.least, of->depth.negated));
    if (!(depth[0] > 0) || !set_packet_slopes(cells, place, of->slopes, 0)) return 0;
    *greatest_depth = -depth[1];
    cells->farthest[place] = t_max * *greatest_depth * (1 + SLOPE_SLACK);
    cells->shortest[place] = t_max * depth[0] * (1 - SLOPE_SLACK);
    return 1;
}

/* Makes a cell of a packet's rays; 0 likewise. */
static MLRT_NOINLINE int add_packet(struct mlrt_ray_tile *tile, uint32_t place)
{
    struct mlrt_cells *cells = &tile->cells;
    struct mlrt_packet *packet = &tile->packets[place];
    const int a = cells->main_axis;
    const float *rows[3] = {packet->direction[a], packet->direction[mlrt_slope_axis(a, 0)],
                            packet->direction[mlrt_slope_axis(a, 1)]};
    struct direction_extremes of = NO_DIRECTIONS;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vm active = m_from_bits(packet->active >> v);
        const vf d[3] = {v_select(active, v_load(rows[0] + v), v_set1(NAN)), v_load(rows[1] + v), v_load(rows[2] + v)};
        add_directions(d, v_set1(cells->sign), &of);
    }
    const float t_max = packet->t_max[mlrt_lowest_bit(packet->active)];
    if (!set_cell_of_directions(cells, place, &of, t_max, &tile->greatest_depth[place])) return 0;
    if (MLRT_UNLIKELY(packet->has_limits)) {
        cells->farthest[place] = farthest_depth(packet, a);
        cells->shortest[place] = shortest_depth(packet, a);
    }
    if (packet->has_limits) tile->limits_below |= highest(packet->t_min, packet->active) > 0;
    cells->closed |= (uint32_t)can_be_closed(packet, &cells->skip[place]) << place;
    return 1;
}
