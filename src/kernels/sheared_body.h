/* SPDX-License-Identifier: MIT */
/*
 * What the kernels for the hierarchy of boxes do otherwise for rays of one direction: see ../sheared.h, and ../shear.h
 * for what is computed and how far it is off.
 */
#if MAKES_SHEARED

/* ---- packets ---- */

/* 1 / (1 - z), of depths as far as there is something: beyond or in front of all else it is as good as at the end of
 * that. */
MLRT_INLINE vf seen_distance(vf depth)
{
    return v_div(v_set1(1), v_sub(v_set1(1), v_max(v_min(depth, v_set1(0.75f)), v_set1(-8))));
}

/* Of the rays of a packet as they are seen: their places; where the first begins, and the first and the last end. */
struct sheared_extremes {
    struct extremes slopes[2];
    vf begin;
    struct extremes ends;
    uint32_t at_hand; /* bit per lane */
    uint32_t within;  /* those that may begin within the scene */
};

/* Shears the rays of a vector: directions, begin, lo and hi become what they are seen as, before any hit. */
MLRT_INLINE void shear_vector(const struct mlrt_shear *shear, const int axes[3], int v, struct mlrt_packet *packet,
                              struct sheared_extremes *of)
{
    const int a = axes[0];
    const vm active = m_from_bits(packet->active >> v);
    const vf given = v_sub(v_load(packet->origin[a] + v), v_set1(shear->centre[a]));
    const vf depth = v_mul(given, v_set1(shear->sign * shear->scale));
    vf reach = v_abs(depth);
    for (int side = 0; side < 2; ++side) {
        const int j = axes[1 + side];
        const vf at = v_mul(v_sub(v_load(packet->origin[j] + v), v_set1(shear->centre[j])), v_set1(shear->scale));
        const vf place = v_sub(at, v_mul(v_set1(shear->slope[side]), depth));
        reach = v_max(v_abs(at), reach);
        v_store(packet->direction[j] + v, place);
        add_to_extremes(v_select(active, place, v_set1(NAN)), &of->slopes[side]);
    }
    v_store(packet->direction[a] + v, v_set1(shear->sign));
    const vf one = v_add(depth, v_mul(v_load(packet->t_min + v), v_set1(shear->pace)));
    const vf other = v_add(depth, v_mul(v_load(packet->t_max + v), v_set1(shear->pace)));
    const vf first = v_min(one, other), begin = seen_distance(first), end = seen_distance(v_max(one, other));
    v_store(packet->begin + v, begin);
    v_store(packet->lo + v, end);
    v_store(packet->hi + v, end);
    of->begin = v_min(v_select(active, begin, v_set1(NAN)), of->begin);
    add_to_extremes(v_select(active, end, v_set1(NAN)), &of->ends);
    of->at_hand |= m_bits(v_le(reach, v_set1(1))) << v;
    of->within |= m_bits(v_ge(first, v_set1(shear->front))) << v;
}

/* Shears a packet, and makes a cell of it; 0 if some rays are not at hand, or they are wide. */
static MLRT_NOINLINE int add_sheared_packet(struct mlrt_ray_tile *tile, uint32_t place)
{
    struct mlrt_cells *cells = &tile->cells;
    struct mlrt_packet *packet = &tile->packets[place];
    const struct mlrt_shear shear = cells->shear; /* a copy, which stores leave alone */
    const int axes[3] = {shear.main_axis, (shear.main_axis + 1) % 3, (shear.main_axis + 2) % 3};
    MLRT_ALIGNED(16) float distance[4];
    struct sheared_extremes of = {{NO_EXTREMES, NO_EXTREMES}, v_set1(INFINITY), NO_EXTREMES, 0, 0};
    if (!(fabsf(shear.pace) >= 0x1p-100f)) return 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) shear_vector(&shear, axes, v, packet, &of);
    packet->shear = &cells->shear;
    tile->greatest_depth[place] = 1;
    if (packet->active & ~of.at_hand) return 0;
    if (!set_packet_slopes(cells, place, of.slopes, MLRT_SHEAR_SLACK)) return 0;
    f4_store(distance, v_hmin4(of.begin, of.ends.least, of.ends.negated, of.ends.negated));
    if (distance[0] < cells->begin) cells->begin = distance[0];
    cells->shortest[place] = distance[1] * (1 - SLOPE_SLACK);
    cells->farthest[place] = -distance[2] * (1 + SLOPE_SLACK);
    if (packet->active & of.within) {
        tile->limits_below = 1;
    } else {
        cells->closed |= (uint32_t)can_be_closed(packet, &cells->skip[place]) << place;
    }
    return 1;
}

/* ---- boxes ---- */

/* A sheared box has its extremes in its corners. Empty slots have lo = inf, and are met by nothing. */
static uint32_t sheared_children_met(const struct mlrt_shear *shear, const float slope_lo[2], const float slope_hi[2],
                                     float begin, float farthest, const struct mlrt_bvh_node *node,
                                     float near[MLRT_BVH_WIDTH])
{
    const int a = shear->main_axis, axes[2] = {(a + 1) % 3, (a + 2) % 3};
    const vf centre = v_set1(shear->centre[a]), sign = v_set1(shear->sign);
    const vf least_depth = v_set1(1 - 1 / begin - 0x1p-18f); /* -inf if that is 0 */
    uint32_t met = 0;
    for (int v = 0; v < MLRT_BVH_WIDTH; v += VW) {
        const vf below = v_flip(v_sub(v_load(node->lo[a] + v), centre), sign);
        const vf above = v_flip(v_sub(v_load(node->hi[a] + v), centre), sign);
        const vf first = v_mul(v_min(below, above), v_set1(shear->scale));
        const vf distance = v_div(v_set1(1 - MLRT_SHEAR_DISTANCE_SLACK), v_sub(v_set1(1), first));
        const vf last = v_mul(v_max(below, above), v_set1(shear->scale));
        vm may = m_and(v_le(distance, v_set1(farthest)), v_ge(last, least_depth));
        for (int side = 0; side < 2; ++side) {
            const int k = axes[side];
            const vf p = v_mul(below, v_set1(shear->slope[side])), q = v_mul(above, v_set1(shear->slope[side]));
            const vf least = v_sub(v_sub(v_load(node->lo[k] + v), v_set1(shear->centre[k])), v_max(p, q));
            const vf greatest = v_sub(v_sub(v_load(node->hi[k] + v), v_set1(shear->centre[k])), v_min(p, q));
            may = m_and(may, v_le(least, v_set1(slope_hi[side] * shear->size)));
            may = m_and(may, v_ge(greatest, v_set1(slope_lo[side] * shear->size)));
        }
        v_store(near + v, distance);
        met |= m_bits(may) << v;
    }
    return met;
}

/* ---- leaves ---- */

/* Corners of a vector of triangles, by axis from the main one on: as stored, relative to the centre in units of the
 * size, and what is left of the latter after the shear. */
struct sheared_corners {
    vf from[3][3];
    vf to[3][3];
    vf at[3][2];
};

static void load_sheared_corners(const struct mlrt_shear *shear, const struct mlrt_leaf_setup *leaf, uint32_t v,
                                 struct sheared_corners *corners)
{
    const vf sign = v_set1(shear->sign);
    for (uint32_t i = 0; i < 3; ++i) {
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t axis = ((uint32_t)shear->main_axis + k) % 3;
            corners->from[i][k] = v_load_any(leaf->corners + (3 * i + axis) * leaf->row + v);
            corners->to[i][k] = v_mul(v_sub(corners->from[i][k], v_set1(shear->centre[axis])), v_set1(shear->scale));
        }
        const vf depth = v_flip(corners->to[i][0], sign);
        for (int side = 0; side < 2; ++side) {
            corners->at[i][side] = v_sub(corners->to[i][1 + side], v_mul(v_set1(shear->slope[side]), depth));
        }
    }
}

static void set_sheared_outlines(const struct mlrt_shear *shear, struct mlrt_leaf_setup *leaf)
{
    const vf sign = v_set1(shear->sign);
    for (uint32_t v = 0; v < leaf->row; v += VW) {
        struct sheared_corners corners;
        load_sheared_corners(shear, leaf, v, &corners);
        vf least = v_flip(corners.to[0][0], sign);
        for (int i = 1; i < 3; ++i) least = v_min(v_flip(corners.to[i][0], sign), least);
        v_store(leaf->least_depth + v, v_div(v_set1(1 - MLRT_SHEAR_DISTANCE_SLACK), v_sub(v_set1(1), least)));
        for (int side = 0; side < 2; ++side) {
            const vf *at[3] = {&corners.at[0][side], &corners.at[1][side], &corners.at[2][side]};
            const vf lo = v_min(v_min(*at[0], *at[1]), *at[2]), hi = v_max(v_max(*at[0], *at[1]), *at[2]);
            v_store(leaf->slope_lo[side] + v, v_sub(lo, v_set1(MLRT_SHEAR_SLACK)));
            v_store(leaf->slope_hi[side] + v, v_add(hi, v_set1(MLRT_SHEAR_SLACK)));
        }
    }
}

/* An edge function, by axis from the main one on. */
static void set_sheared_edge(const struct mlrt_shear *shear, const struct sheared_corners *corners, int i, vf cross[3])
{
    const int next = (i + 1) % 3;
    const float sign = shear->sign;
    vf edge[3], x[2], g[2];
    for (int k = 0; k < 3; ++k) edge[k] = v_sub(corners->from[next][k], corners->from[i][k]);
    const vf depth = v_mul(edge[0], v_set1(sign));
    for (int side = 0; side < 2; ++side) {
        x[side] = v_add(corners->at[i][side], corners->at[next][side]);
        g[side] = v_sub(edge[1 + side], v_mul(v_set1(shear->slope[side]), depth));
    }
    const vf size = v_add(v_mul(v_add(v_abs(edge[1]), v_abs(edge[2])), v_set1(8)), v_mul(v_abs(depth), v_set1(18)));
    const vf scale = v_div(v_set1(1), v_max(size, v_set1(SMALLEST_SIZE))), twice = v_mul(scale, v_set1(2 * sign));
    cross[0] = v_mul(v_sub(v_mul(x[0], g[1]), v_mul(x[1], g[0])), scale);
    cross[1] = v_mul(v_sub(v_set1(0), g[1]), twice);
    cross[2] = v_mul(g[0], twice);
}

/* D, by axis from the main one on, and N, which is returned. */
static vf set_sheared_normal(const struct mlrt_shear *shear, const struct sheared_corners *corners, vf cross[3])
{
    const vf sign = v_set1(shear->sign);
    vf first[3], second[3];
    for (int k = 0; k < 3; ++k) {
        first[k] = v_sub(corners->from[0][k], corners->from[2][k]);
        second[k] = v_sub(corners->from[1][k], corners->from[0][k]);
    }
    scaled_cross_product(first, second, 0, cross);
    for (int k = 0; k < 3; ++k) cross[k] = v_mul(cross[k], v_set1(0.125f));
    vf distance = v_mul(cross[0], sign);
    for (int side = 0; side < 2; ++side) {
        distance = v_add(distance, v_mul(cross[1 + side], v_set1(shear->slope[side])));
    }
    cross[0] = v_mul(v_sub(distance, dot_product(corners->to[0], cross)), sign);
    return distance;
}

static uint32_t set_sheared_vector(const struct mlrt_shear *shear, uint32_t v, struct mlrt_leaf_setup *leaf)
{
    struct sheared_corners corners;
    vf cross[4][3];
    load_sheared_corners(shear, leaf, v, &corners);
    for (int i = 0; i < 3; ++i) set_sheared_edge(shear, &corners, i, cross[i]);
    const vf distance = set_sheared_normal(shear, &corners, cross[3]), size = v_abs(distance);
    const float unit = MLRT_GUESS ? 0.0f : 0x1p-24f;
    const vf bound = v_add(v_mul(size, v_set1(32 * unit)), v_set1(4 * unit));
    for (int i = 0; i < 4; ++i) {
        for (int k = 0; k < 3; ++k) {
            v_store(leaf->cross[i][(shear->main_axis + k) % 3] + v, v_flip(cross[i][k], distance));
        }
    }
    leaf->negative |= m_bits(v_lt(v_flip(v_set1(1), distance), v_set1(0))) << v;
    v_store(leaf->least_n + v, v_sub(size, bound));
    v_store(leaf->greatest_n + v, v_add(size, bound));
    return m_bits(v_le(size, bound));
}

static uint32_t set_sheared_terms(const struct mlrt_shear *shear, uint32_t wanted, struct mlrt_leaf_setup *leaf)
{
    uint32_t doubtful = 0;
    for (uint32_t v = 0; v < leaf->row; v += VW) {
        if (!(wanted >> v & ALL_LANES)) continue;
        doubtful |= set_sheared_vector(shear, v, leaf) << v;
        leaf->ready |= (ALL_LANES & 0xFFFF) << v;
    }
    return doubtful;
}

const struct mlrt_sheared_kernels SHEARED = {add_sheared_packet, sheared_children_met, set_sheared_outlines,
                                             set_sheared_terms};

/* ---- cells of a parallel camera, once for all ---- */

#if VW <= 4
/*
 * Places are affine in column and row, so they have their extremes at the corners of a cell. What a ray is moved by
 * there, and 7 u for the corners themselves, is added. What is hardly at hand is left out: between the corners,
 * rounding may move a ray a little beyond them.
 */
int mlrt_set_sheared_slopes(const struct mlrt_shear *shear, const struct mlrt_view *view,
                            float samples[4][MLRT_CELL_COUNT], uint32_t there, const float pad[3],
                            struct mlrt_slopes slopes[2])
{
    const int a = shear->main_axis;
    const float error = pad[a] * shear->scale;
    uint32_t far = 0;
    if (!(fabsf(shear->pace) >= 0x1p-100f)) return 0;
    for (int k = 0; k < 3; ++k) {
        if (!mlrt_is_float_safe(view->direction[k])) return 0;
    }
    for (int v = 0; v < MLRT_CELL_COUNT; v += VW) {
        vf lo[2] = {v_set1(INFINITY), v_set1(INFINITY)}, hi[2] = {v_set1(-INFINITY), v_set1(-INFINITY)};
        vm near = m_from_bits(ALL_LANES);
        for (int corner = 0; corner < 4; ++corner) {
            const vf x = v_load(samples[corner & 1] + v), y = v_load(samples[2 + (corner >> 1)] + v);
            vf at[3];
            for (int i = 0; i < 3; ++i) {
                const int k = (a + i) % 3;
                const vf step = v_add(v_mul(x, v_set1(view->dx[k])), v_mul(y, v_set1(view->dy[k])));
                at[i] = v_mul(v_sub(v_add(v_set1(view->d00[k]), step), v_set1(shear->centre[k])), v_set1(shear->scale));
                near = m_and(near, v_le(v_abs(at[i]), v_set1(0.999f)));
            }
            const vf depth = v_mul(at[0], v_set1(shear->sign));
            near = m_and(near, v_le(v_add(depth, v_set1(error)), v_set1(shear->front)));
            for (int side = 0; side < 2; ++side) {
                const vf place = v_sub(at[1 + side], v_mul(v_set1(shear->slope[side]), depth));
                lo[side] = v_min(place, lo[side]);
                hi[side] = v_max(place, hi[side]);
            }
        }
        const vm cells = m_from_bits(there >> v);
        for (int side = 0; side < 2; ++side) {
            const vf slack = v_set1(MLRT_SHEAR_SLACK + error + pad[(a + 1 + side) % 3] * shear->scale);
            v_store(slopes[side].lo + v, v_select(cells, v_sub(lo[side], slack), v_set1(INFINITY)));
            v_store(slopes[side].hi + v, v_select(cells, v_add(hi[side], slack), v_set1(-INFINITY)));
        }
        far |= m_bits(m_andnot(cells, near)) << v;
    }
    return !far;
}
#endif
#endif
