/* SPDX-License-Identifier: MIT */
/*
 * Sixteen packets that go through the hierarchy of boxes together, from one origin: a tile of 16x16 rays, as a rule.
 *
 * Seen from the apex along a main axis with its sign, a point in front has a depth z = +-(p_main - apex_main) and
 * slopes (p_j - apex_j) / z over the other two axes; a ray has the slopes d_j / |d_main|. A packet is a rectangle of
 * slopes, and a depth behind which none of its rays looks any more; arrays have a place for each packet, so that one
 * step compares something with all of them.
 *
 * Slopes of rays have two roundings, and are moved apart by SLOPE_SLACK, 2^-20 of themselves. A depth or an offset
 * p - apex has one, the product of a slope and a depth one more. So where a ray meets a box between depths near and far,
 * its x_j = s_j z has x_j <= max(S near, S far), S the upper slope, also as computed: the slack of S pays for the
 * roundings, or, where products are denormal, x_j and S z both are multiples of 2^-149 and rounding keeps their order.
 */

#define TILE_PACKETS 16

/* Slopes of a tile's packets are at most this: the main axis is nearly the main one for all its rays. */
#define STEEPEST_SLOPE 2.0f

/* A packet whose slopes differ by more than this gains nothing from going through the tree as one. */
#define WIDEST_PACKET 0.25f

struct ray_tile {
    struct mlrt_packet packets[TILE_PACKETS];
    struct {
        MLRT_ALIGNED(64) float lo[TILE_PACKETS];
        MLRT_ALIGNED(64) float hi[TILE_PACKETS];
    } slopes[2];                                     /* over axes main + 1, main + 2; empty for packets that do not take part */
    MLRT_ALIGNED(64) float farthest[TILE_PACKETS];   /* depth; -inf: done */
    float reach[TILE_PACKETS];                       /* triangle_filter.h's R of a packet */
    float apex[3];
    int main_axis;
    float sign; /* of the main components: +-1 */
    /* Of all packets together. */
    float slope_lo[2];
    float slope_hi[2];
    float whole_farthest;
    float slope_bound; /* of edge functions over slopes: bvh_leaf.h */
    int limits_below;  /* some t_min is not 0 */
};

/* The greatest depth at which rays of a packet still look. */
MLRT_INLINE float farthest_depth(const struct mlrt_packet *packet, int main_axis)
{
    vf farthest = v_set1(-INFINITY);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf depth = v_mul(v_load(packet->hi + v), v_abs(v_load(packet->direction[main_axis] + v)));
        farthest = v_max(v_select(m_from_bits(packet->active >> v), depth, v_set1(-INFINITY)), farthest);
    }
    return v_hmax(farthest) * (1 + SLOPE_SLACK);
}

MLRT_INLINE void set_whole_farthest(struct ray_tile *tile)
{
    vf farthest = v_set1(-INFINITY);
    for (int v = 0; v < TILE_PACKETS; v += VW) farthest = v_max(v_load(tile->farthest + v), farthest);
    tile->whole_farthest = v_hmax(farthest);
}

/* The main axis of a packet's first ray, for all of the tile. */
MLRT_INLINE void choose_main_axis(const struct mlrt_packet *packet, struct ray_tile *tile)
{
    const uint32_t lane = mlrt_lowest_bit(packet->active);
    float size[3];
    for (int k = 0; k < 3; ++k) size[k] = fabsf(packet->direction[k][lane]);
    tile->main_axis = size[0] > size[1] ? (size[0] > size[2] ? 0 : 2) : (size[1] > size[2] ? 1 : 2);
    tile->sign = packet->direction[tile->main_axis][lane] < 0 ? -1.0f : 1.0f;
}

/* Adds a packet to those of the tile that go together; 0 if its rays do not agree with the main axis, or are wide. */
MLRT_INLINE int add_packet(struct ray_tile *tile, uint32_t place)
{
    struct mlrt_packet *packet = &tile->packets[place];
    const int a = tile->main_axis;
    const vf sign = v_set1(tile->sign);
    vf reach = v_set1(0);
    uint32_t forward = 0;
    vf lo[2] = {v_set1(INFINITY), v_set1(INFINITY)}, hi[2] = {v_set1(-INFINITY), v_set1(-INFINITY)};
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vm active = m_from_bits(packet->active >> v);
        const vf depth = v_flip(v_load(packet->direction[a] + v), sign);
        forward |= m_bits(v_gt(depth, v_set1(0))) << v;
        vf size = v_abs(depth);
        for (int side = 0; side < 2; ++side) {
            const vf d = v_load(packet->direction[(a + 1 + side) % 3] + v), slope = v_div(d, depth);
            lo[side] = v_min(v_select(active, slope, v_set1(INFINITY)), lo[side]);
            hi[side] = v_max(v_select(active, slope, v_set1(-INFINITY)), hi[side]);
            const vf twice = v_mul(v_abs(d), v_set1(2));
            size = v_max(size, twice);
        }
        reach = v_max(v_select(active, size, v_set1(0)), reach);
    }
    if (packet->active & ~forward) return 0;
    float bounds[2][2];
    for (int side = 0; side < 2; ++side) {
        const float least = v_hmin(lo[side]), greatest = v_hmax(hi[side]);
        if (!(least >= -STEEPEST_SLOPE && greatest <= STEEPEST_SLOPE && greatest - least <= WIDEST_PACKET)) return 0;
        bounds[side][0] = least - fabsf(least) * SLOPE_SLACK;
        bounds[side][1] = greatest + fabsf(greatest) * SLOPE_SLACK;
    }
    for (int side = 0; side < 2; ++side) {
        tile->slopes[side].lo[place] = bounds[side][0];
        tile->slopes[side].hi[place] = bounds[side][1];
        tile->slope_lo[side] = bounds[side][0] < tile->slope_lo[side] ? bounds[side][0] : tile->slope_lo[side];
        tile->slope_hi[side] = bounds[side][1] > tile->slope_hi[side] ? bounds[side][1] : tile->slope_hi[side];
    }
    tile->reach[place] = v_hmax(reach);
    tile->farthest[place] = farthest_depth(packet, a);
    tile->limits_below |= highest(packet->t_min, packet->active) > 0;
    return 1;
}

/*
 * Gathers packets of `waiting` (bit per place) that can go together with the first of them, and returns which: none if
 * not even that one can.
 */
static MLRT_NOINLINE uint32_t gather_packets(struct ray_tile *tile, uint32_t waiting)
{
    const struct mlrt_packet *first = &tile->packets[mlrt_lowest_bit(waiting)];
    memcpy(tile->apex, first->apex, sizeof tile->apex);
    choose_main_axis(first, tile);
    for (int side = 0; side < 2; ++side) {
        tile->slope_lo[side] = INFINITY;
        tile->slope_hi[side] = -INFINITY;
    }
    tile->limits_below = 0;
    uint32_t gathered = 0;
    for (uint32_t place = 0; place < TILE_PACKETS; ++place) {
        if (waiting >> place & 1 && memcmp(tile->packets[place].apex, tile->apex, sizeof tile->apex) == 0 &&
            add_packet(tile, place)) {
            gathered |= 1u << place;
            continue;
        }
        tile->farthest[place] = -INFINITY;
        for (int side = 0; side < 2; ++side) {
            tile->slopes[side].lo[place] = INFINITY;
            tile->slopes[side].hi[place] = -INFINITY;
        }
    }
    float steepest = 0.5f;
    for (int side = 0; side < 2; ++side) {
        steepest = larger_of(larger_of(fabsf(tile->slope_lo[side]), fabsf(tile->slope_hi[side])), steepest);
    }
    tile->slope_bound = 2 * steepest * EDGE_BOUND * 1.125f;
    set_whole_farthest(tile);
    return gathered;
}
