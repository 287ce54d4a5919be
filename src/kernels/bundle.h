/* SPDX-License-Identifier: MIT */
/*
 * The rays of a tile as a bundle (../bundle.h): its waist, the terms of its rays, and the hulls of its packets.
 *
 * WHAT IS COMPUTED, u = 2^-24. With the main axis' sign o' = o - w, 1 rounding per component; a slope s_j = d_j / |d_main|
 * has 1. Let A be at least |o'_main|, 2 |o'_j|, 2 |o'_l| of all rays of a packet and R at least 1 and 2 |s_j|. A place
 * x_j = o'_j - s_j o'_main is off by u |o'_j| + 3.01 u |s_j o'_main| and its own rounding of at most u (|o'_j| +
 * |s_j o'_main|): together by less than 2 u |o'_j| + 4.1 u |s_j o'_main| <= (1 + 2.05) u R A. PLACE_ERROR makes 4 u of
 * it. A ray from the waist has o' = 0, and place 0 exactly.
 *
 * BOXES. At depth z a ray is at x_j + s_j z. For a box, as computed, c = fl(c_j - w_j) and z = fl(c_main - w_main) are off
 * by u of themselves, the product with a slope and the sum with a place by u each. Slopes and places of hulls are moved
 * apart by SLOPE_SLACK, 2^-20 of themselves (and places by PLACE_ERROR R A): 16 u |s| |z| and 16 u |x|. That pays for all:
 * a box is compared as c <= fl(x) + fl(s z) where both sides differ by at most 2 u |s z| + 3 u (|x| + |s z|) from what
 * they stand for, and u |c| matters only where c is as large as that. Depths where rays begin and end, o'_main + tau,
 * are moved by SLOPE_SLACK (|z| + A).
 *
 * Based on: architecture of the waist: rays relative to the depth where their places vary least; frusta against boxes:
 * I. Wald, S. Boulos, P. Shirley, "Ray Tracing Deformable Scenes Using Dynamic Bounding Volume Hierarchies", 2007.
 */

#define PLACE_ERROR (4 * 0x1p-24f)

/* Lane errors of edge functions per place: see bundle_leaf.h. */
#define BLUR_OF_PLACE (13 * 0x1p-24f)

struct bundle {
    struct mlrt_waist waist;
    int has_places; /* 0: all rays start at the waist, and all places are 0 */
    int has_begins; /* some t_min is not 0 */
    int far_first;  /* boxes that the rays come to last are opened first */
    float scene_first, scene_last;
    struct mlrt_hull whole;
    struct mlrt_hulls hulls;
    uint32_t going; /* packets with a hull */
    uint32_t tests[MLRT_BUNDLE_PACKETS];
    struct mlrt_ray_tile *tile;
    struct mlrt_bundle_rays rays[MLRT_BUNDLE_PACKETS];
};

/* ---- the waist ---- */

/* Sums over rays of slopes and of places relative to a first ray's origin. */
struct ray_sums {
    vf slope[2];
    vf place[2];
    vf slope_slope;
    vf slope_place;
    vf place_place;
};

/* Components of the origins of a vector of lanes. */
MLRT_INLINE vf origin_component(const struct mlrt_packet *packet, int k, int v)
{
    return packet->has_apex ? v_set1(packet->apex[k]) : v_load(packet->origin[k] + v);
}

/*
 * Sets slopes and paces of a packet's rays, and adds the rays to the sums. Returns 0 if some ray does not go along the
 * main axis, or is too steep.
 */
static MLRT_NOINLINE int add_slopes(const struct mlrt_packet *packet, const struct mlrt_waist *from,
                                    struct mlrt_bundle_rays *rays, struct ray_sums *sums)
{
    const int a = from->main_axis;
    const vf sign = v_set1(from->sign), zero = v_set1(0);
    uint32_t good = 0;
    struct ray_sums of = *sums;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vm active = m_from_bits(packet->active >> v);
        const vf pace = v_flip(v_load(packet->direction[a] + v), sign);
        const vf depth = v_flip(v_sub(origin_component(packet, a, v), v_set1(from->point[a])), sign);
        vm fits = v_gt(pace, zero);
        v_store(rays->pace + v, pace);
        for (int side = 0; side < 2; ++side) {
            const int j = mlrt_slope_axis(a, side);
            const vf slope = v_div(v_load(packet->direction[j] + v), pace);
            const vf place = v_sub(v_sub(origin_component(packet, j, v), v_set1(from->point[j])), v_mul(slope, depth));
            fits = m_and(fits, v_le(v_abs(slope), v_set1(STEEPEST_SLOPE)));
            v_store(rays->term[MLRT_SLOPE_J + side] + v, slope);
            const vf s = v_select(active, slope, zero), x = v_select(active, place, zero);
            of.slope[side] = v_add(of.slope[side], s);
            of.place[side] = v_add(of.place[side], x);
            of.slope_slope = v_mul_add(s, s, of.slope_slope);
            of.slope_place = v_mul_add(s, x, of.slope_place);
            of.place_place = v_mul_add(x, x, of.place_place);
        }
        good |= m_bits(fits) << v;
    }
    if (packet->active & ~good) return 0;
    *sums = of;
    return 1;
}

MLRT_INLINE float sum_of_lanes(vf a)
{
    MLRT_ALIGNED(64) float lanes[VW];
    float sum = 0;
    v_store(lanes, a);
    for (int i = 0; i < VW; ++i) sum += lanes[i];
    return sum;
}

/*
 * Sets the waist of rays with these sums relative to `from`: the depth where their places vary least, about
 * -cov(x, s) / var(s). A waist that the last tile had is kept while it is nearly as good, so that set-ups of leaves are
 * shared: no exactness hangs on it.
 */
static void choose_waist(const struct mlrt_box *bounds, const struct mlrt_waist *from, const struct ray_sums *sums,
                         uint32_t count, const struct mlrt_waist *last, struct mlrt_waist *waist)
{
    const int a = from->main_axis;
    const float scale = 1 / (float)count, size = bounds->hi[a] - bounds->lo[a];
    const float lowest = from->sign > 0 ? bounds->lo[a] - from->point[a] : from->point[a] - bounds->hi[a];
    float slope[2], place[2];
    float slope_variance = sum_of_lanes(sums->slope_slope) * scale;
    float covariance = sum_of_lanes(sums->slope_place) * scale, place_variance = sum_of_lanes(sums->place_place) * scale;
    for (int side = 0; side < 2; ++side) {
        slope[side] = sum_of_lanes(sums->slope[side]) * scale;
        place[side] = sum_of_lanes(sums->place[side]) * scale;
        slope_variance -= slope[side] * slope[side];
        covariance -= slope[side] * place[side];
        place_variance -= place[side] * place[side];
    }
    const int is_narrow = !(slope_variance * size * size > 1e-8f * size * size + 1e-5f * place_variance);
    float depth = is_narrow ? lowest + 0.5f * size : -covariance / slope_variance;
    if (!(depth > lowest - size)) depth = lowest - size;
    if (depth > lowest + 2 * size) depth = lowest + 2 * size;
    if (last->main_axis == a && last->sign == from->sign) {
        const float z = (last->point[a] - from->point[a]) * from->sign;
        const float there = place_variance + z * (2 * covariance + z * slope_variance);
        const float best = place_variance + depth * (2 * covariance + depth * slope_variance);
        const float other = (fabsf(z - lowest) + size) * (fabsf(z - lowest) + size);
        if (there <= 1.5f * best + 1e-3f * slope_variance * other && (is_narrow || fabsf(z - lowest) <= 3 * size)) {
            *waist = *last;
            return;
        }
    }
    *waist = *from;
    waist->point[a] += from->sign * depth;
    for (int side = 0; side < 2; ++side) {
        waist->point[mlrt_slope_axis(a, side)] += place[side] + slope[side] * depth;
    }
}

/* ---- rays and hulls ---- */

/* Sets the terms of a packet's rays relative to the waist; slopes and paces are there. */
static MLRT_NOINLINE void set_ray_terms(const struct mlrt_packet *packet, const struct mlrt_waist *waist,
                                        struct mlrt_bundle_rays *rays)
{
    const int a = waist->main_axis, j = mlrt_slope_axis(a, 0), l = mlrt_slope_axis(a, 1);
    const vf sign = v_set1(waist->sign);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf z = v_flip(v_sub(v_set1(waist->point[a]), origin_component(packet, a, v)), sign);
        const vf y_j = v_sub(v_set1(waist->point[j]), origin_component(packet, j, v));
        const vf y_l = v_sub(v_set1(waist->point[l]), origin_component(packet, l, v));
        const vf s_j = v_load(rays->term[MLRT_SLOPE_J] + v), s_l = v_load(rays->term[MLRT_SLOPE_L] + v);
        const vf x_j = v_mul_sub(s_j, z, y_j), x_l = v_mul_sub(s_l, z, y_l);
        v_store(rays->to_waist[0] + v, z);
        v_store(rays->to_waist[1] + v, y_j);
        v_store(rays->to_waist[2] + v, y_l);
        v_store(rays->term[MLRT_PLACE_J] + v, x_j);
        v_store(rays->term[MLRT_PLACE_L] + v, x_l);
        v_store(rays->term[MLRT_MOMENT] + v, v_mul_sub(s_l, x_j, v_mul(s_j, x_l)));
    }
}

/* Sets the distances between which a packet's rays look. */
MLRT_INLINE void set_ray_limits(const struct mlrt_packet *packet, struct mlrt_bundle_rays *rays)
{
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf pace = v_load(rays->pace + v), t_max = v_load(packet->t_max + v);
        v_store(rays->begin + v, v_mul(v_load(packet->t_min + v), pace));
        v_store(rays->lo + v, v_mul(v_mul(t_max, pace), v_set1(1 - SLOPE_SLACK)));
        v_store(rays->hi + v, v_mul(v_mul(t_max, pace), v_set1(1 + SLOPE_SLACK)));
    }
}

/* The depths between which the rays of a packet look, as far as there is something: moved apart by what rounding may
 * change. */
MLRT_INLINE void set_depths(struct bundle *bundle, uint32_t place, float first, float last)
{
    const float away = bundle->hulls.away[place];
    const float from = first - SLOPE_SLACK * (fabsf(first) + away), to = last + SLOPE_SLACK * (fabsf(last) + away);
    bundle->hulls.first[place] = from > bundle->scene_first ? from : bundle->scene_first;
    bundle->hulls.last[place] = to < bundle->scene_last ? to : bundle->scene_last;
}

/* After hits: the greatest depth at which active rays still look. */
static MLRT_NOINLINE void update_last_depth(struct bundle *bundle, uint32_t place)
{
    const struct mlrt_bundle_rays *rays = &bundle->rays[place];
    const uint32_t active = bundle->tile->packets[place].active;
    vf last = v_set1(-INFINITY);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf depth = v_sub(v_load(rays->hi + v), v_load(rays->to_waist[0] + v));
        last = v_max(v_select(m_from_bits(active >> v), depth, v_set1(-INFINITY)), last);
    }
    const float depth = v_hmax(last), to = depth + SLOPE_SLACK * (fabsf(depth) + bundle->hulls.away[place]);
    if (to < bundle->hulls.last[place]) bundle->hulls.last[place] = to;
}

/* Sets the intervals of the terms of a packet's active rays, where they begin and end, and A. */
static MLRT_NOINLINE void bound_packet(struct bundle *bundle, uint32_t place)
{
    const struct mlrt_bundle_rays *rays = &bundle->rays[place];
    const uint32_t active = bundle->tile->packets[place].active;
    struct mlrt_hulls *hulls = &bundle->hulls;
    struct extremes of[MLRT_RAY_TERMS] = {NO_EXTREMES, NO_EXTREMES, NO_EXTREMES, NO_EXTREMES, NO_EXTREMES};
    vf first = v_set1(INFINITY), negated_last = first, negated_away = first;
    const int term_count = bundle->has_places ? MLRT_RAY_TERMS : 2;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vm lanes = m_from_bits(active >> v);
        const vf nothing = v_set1(NAN);
        for (int i = 0; i < term_count; ++i) {
            add_to_extremes(v_select(lanes, v_load(rays->term[i] + v), nothing), &of[i]);
        }
        const vf z = v_load(rays->to_waist[0] + v);
        const vf other = v_max(v_abs(v_load(rays->to_waist[1] + v)), v_abs(v_load(rays->to_waist[2] + v)));
        const vf away = v_max(v_abs(z), v_mul(other, v_set1(2)));
        first = v_min(v_select(lanes, v_sub(v_load(rays->begin + v), z), nothing), first);
        negated_last = v_min(v_select(lanes, v_sub(z, v_load(rays->hi + v)), nothing), negated_last);
        negated_away = v_min(v_select(lanes, v_sub(v_set1(0), away), nothing), negated_away);
    }
    MLRT_ALIGNED(16) float least[16];
    f4_store(least, v_hmin4(of[0].least, of[1].least, of[0].negated, of[1].negated));
    f4_store(least + 4, v_hmin4(first, negated_last, negated_away, negated_away));
    hulls->away[place] = -least[6];
    set_depths(bundle, place, least[4], -least[5]);
    for (int side = 0; side < 2; ++side) {
        hulls->term[side].lo[place] = least[side];
        hulls->term[side].hi[place] = -least[2 + side];
    }
    if (!bundle->has_places) return;
    f4_store(least + 8, v_hmin4(of[2].least, of[3].least, of[2].negated, of[3].negated));
    f4_store(least + 12, v_hmin4(of[4].least, of[4].least, of[4].negated, of[4].negated));
    for (int side = 0; side < 2; ++side) {
        hulls->term[MLRT_PLACE_J + side].lo[place] = least[8 + side];
        hulls->term[MLRT_PLACE_J + side].hi[place] = -least[10 + side];
    }
    hulls->term[MLRT_MOMENT].lo[place] = least[12];
    hulls->term[MLRT_MOMENT].hi[place] = -least[14];
}

/* Makes hulls of what bound_packet found, for the vector of packets from `v` on. */
static MLRT_NOINLINE void finish_hulls(struct bundle *bundle, int v)
{
    struct mlrt_hulls *hulls = &bundle->hulls;
    const vm going = m_from_bits(bundle->going >> v);
    const vf away = v_load(hulls->away + v), one = v_set1(1), inf = v_set1(INFINITY), none = v_set1(-INFINITY);
    const int term_count = bundle->has_places ? MLRT_RAY_TERMS : 2;
    vf reach = one, largest = v_set1(0);
    for (int i = 0; i < term_count; ++i) {
        const vf lo = v_load(hulls->term[i].lo + v), hi = v_load(hulls->term[i].hi + v);
        const vf size = v_max(v_abs(lo), v_abs(hi)), middle = v_mul(v_add(lo, hi), v_set1(0.5f));
        const vf radius = v_mul(v_sub(hi, lo), v_set1(0.5f * (1 + SLOPE_SLACK)));
        v_store(hulls->middle[i] + v, middle);
        v_store(hulls->radius[i] + v, v_mul_add(v_abs(middle), v_set1(0.25f * SLOPE_SLACK), radius));
        if (i < 2) reach = v_max(v_mul(size, v_set1(2)), reach);
        if (i == MLRT_PLACE_J || i == MLRT_PLACE_L) largest = v_max(size, largest);
    }
    const vf error = v_mul(v_mul(reach, away), v_set1(PLACE_ERROR));
    v_store(hulls->reach + v, reach);
    v_store(hulls->blur + v, v_mul_add(largest, v_set1(BLUR_OF_PLACE), error));
    for (int i = 0; i < 2; ++i) {
        const vf lo = v_load(hulls->term[i].lo + v), hi = v_load(hulls->term[i].hi + v), slack = v_set1(SLOPE_SLACK);
        v_store(hulls->slope[i].lo + v, v_select(going, v_sub(lo, v_mul(v_abs(lo), slack)), inf));
        v_store(hulls->slope[i].hi + v, v_select(going, v_add(hi, v_mul(v_abs(hi), slack)), none));
        if (!bundle->has_places) continue;
        const vf from = v_load(hulls->term[2 + i].lo + v), to = v_load(hulls->term[2 + i].hi + v);
        v_store(hulls->place[i].lo + v, v_select(going, v_sub(v_sub(from, v_mul(v_abs(from), slack)), error), inf));
        v_store(hulls->place[i].hi + v, v_select(going, v_add(v_add(to, v_mul(v_abs(to), slack)), error), none));
    }
}

/* What holds for all packets that go. */
static MLRT_NOINLINE void sum_up_hulls(struct bundle *bundle)
{
    const struct mlrt_hulls *hulls = &bundle->hulls;
    struct mlrt_hull *whole = &bundle->whole;
    struct extremes slope[2] = {NO_EXTREMES, NO_EXTREMES}, place[2] = {NO_EXTREMES, NO_EXTREMES};
    vf first = v_set1(INFINITY), last = v_set1(-INFINITY);
    for (int v = 0; v < MLRT_BUNDLE_PACKETS; v += VW) {
        for (int i = 0; i < 2; ++i) {
            slope[i].least = v_min(v_load(hulls->slope[i].lo + v), slope[i].least);
            slope[i].negated = v_min(v_sub(v_set1(0), v_load(hulls->slope[i].hi + v)), slope[i].negated);
            if (!bundle->has_places) continue;
            place[i].least = v_min(v_load(hulls->place[i].lo + v), place[i].least);
            place[i].negated = v_min(v_sub(v_set1(0), v_load(hulls->place[i].hi + v)), place[i].negated);
        }
        first = v_min(v_load(hulls->first + v), first);
        last = v_max(v_load(hulls->last + v), last);
    }
    MLRT_ALIGNED(16) float least[4];
    f4_store(least, v_hmin4(slope[0].least, slope[1].least, slope[0].negated, slope[1].negated));
    for (int i = 0; i < 2; ++i) whole->slope_lo[i] = least[i], whole->slope_hi[i] = -least[2 + i];
    f4_store(least, v_hmin4(place[0].least, place[1].least, place[0].negated, place[1].negated));
    for (int i = 0; i < 2; ++i) {
        whole->place_lo[i] = bundle->has_places ? least[i] : 0;
        whole->place_hi[i] = bundle->has_places ? -least[2 + i] : 0;
    }
    whole->first = v_hmin(first);
    whole->last = v_hmax(last);
}

MLRT_INLINE void set_whole_last(struct bundle *bundle)
{
    vf last = v_set1(-INFINITY);
    for (int v = 0; v < MLRT_BUNDLE_PACKETS; v += VW) last = v_max(v_load(bundle->hulls.last + v), last);
    bundle->whole.last = v_hmax(last);
}

/* A packet that goes with the others no longer. */
static void leave_bundle(struct bundle *bundle, uint32_t place)
{
    struct mlrt_hulls *hulls = &bundle->hulls;
    bundle->going &= ~(1u << place);
    hulls->first[place] = INFINITY;
    hulls->last[place] = -INFINITY;
    for (int i = 0; i < 2; ++i) {
        hulls->slope[i].lo[place] = hulls->place[i].lo[place] = INFINITY;
        hulls->slope[i].hi[place] = hulls->place[i].hi[place] = -INFINITY;
    }
}

/* ---- boxes ---- */

/* Of what is at depths `from` to `to`: where rays with these slopes and places can be, over one axis. */
MLRT_INLINE vf upper_place(vf from, vf to, vf slope_lo, vf slope_hi, vf place_hi, int has_places)
{
    if (!has_places) return v_max(v_mul(slope_hi, from), v_mul(slope_hi, to));
    return v_add(place_hi, v_max(v_max(v_mul(slope_hi, from), v_mul(slope_hi, to)),
                                 v_max(v_mul(slope_lo, from), v_mul(slope_lo, to))));
}

MLRT_INLINE vf lower_place(vf from, vf to, vf slope_lo, vf slope_hi, vf place_lo, int has_places)
{
    if (!has_places) return v_min(v_mul(slope_lo, from), v_mul(slope_lo, to));
    return v_add(place_lo, v_min(v_min(v_mul(slope_hi, from), v_mul(slope_hi, to)),
                                 v_min(v_mul(slope_lo, from), v_mul(slope_lo, to))));
}

/* The children of a node whose boxes the bundle may meet; the least depths go to `near`. */
MLRT_INLINE uint32_t bundle_children_met(const struct bundle *bundle, const struct mlrt_bvh_node *node, int has_places,
                                         float near[MLRT_BVH_WIDTH])
{
    const struct mlrt_waist *waist = &bundle->waist;
    const struct mlrt_hull *whole = &bundle->whole;
    const int a = waist->main_axis;
    const float *enter = waist->sign > 0 ? node->lo[a] : node->hi[a], *exit = waist->sign > 0 ? node->hi[a] : node->lo[a];
    uint32_t met = 0;
    for (int v = 0; v < MLRT_BVH_WIDTH; v += VW) {
        const vf w = v_set1(waist->point[a]), sign = v_set1(waist->sign);
        const vf from = v_max(v_flip(v_sub(v_load(enter + v), w), sign), v_set1(whole->first));
        const vf to = v_min(v_flip(v_sub(v_load(exit + v), w), sign), v_set1(whole->last));
        vm may = v_le(from, to);
        for (int i = 0; i < 2; ++i) {
            const int j = mlrt_slope_axis(a, i);
            const vf lo = v_set1(whole->slope_lo[i]), hi = v_set1(whole->slope_hi[i]);
            const vf least = v_sub(v_load(node->lo[j] + v), v_set1(waist->point[j]));
            const vf greatest = v_sub(v_load(node->hi[j] + v), v_set1(waist->point[j]));
            may = m_and(may, v_le(least, upper_place(from, to, lo, hi, v_set1(whole->place_hi[i]), has_places)));
            may = m_and(may, v_ge(greatest, lower_place(from, to, lo, hi, v_set1(whole->place_lo[i]), has_places)));
        }
        v_store(near + v, from);
        met |= m_bits(may) << v;
    }
    return met;
}

/* A child of a node relative to the waist. */
struct box_of_bundle {
    float from;
    float to;
    float lo[2];
    float hi[2];
};

MLRT_INLINE void see_bundle_box(const struct mlrt_waist *waist, const struct mlrt_bvh_node *node, uint32_t place,
                                struct box_of_bundle *box)
{
    const int a = waist->main_axis;
    const float below = node->lo[a][place] - waist->point[a], above = node->hi[a][place] - waist->point[a];
    box->from = waist->sign > 0 ? below : -above;
    box->to = waist->sign > 0 ? above : -below;
    for (int i = 0; i < 2; ++i) {
        const int j = mlrt_slope_axis(a, i);
        box->lo[i] = node->lo[j][place] - waist->point[j];
        box->hi[i] = node->hi[j][place] - waist->point[j];
    }
}

/* The packets that may meet a box. */
MLRT_INLINE uint32_t packets_met(const struct bundle *bundle, const struct box_of_bundle *box, int has_places)
{
    const struct mlrt_hulls *hulls = &bundle->hulls;
    uint32_t met = 0;
    for (int v = 0; v < MLRT_BUNDLE_PACKETS; v += VW) {
        const vf from = v_max(v_set1(box->from), v_load(hulls->first + v));
        const vf to = v_min(v_set1(box->to), v_load(hulls->last + v));
        vm may = v_le(from, to);
        for (int i = 0; i < 2; ++i) {
            const vf lo = v_load(hulls->slope[i].lo + v), hi = v_load(hulls->slope[i].hi + v);
            const vf place_lo = has_places ? v_load(hulls->place[i].lo + v) : lo;
            const vf place_hi = has_places ? v_load(hulls->place[i].hi + v) : hi;
            may = m_and(may, v_le(v_set1(box->lo[i]), upper_place(from, to, lo, hi, place_hi, has_places)));
            may = m_and(may, v_ge(v_set1(box->hi[i]), lower_place(from, to, lo, hi, place_lo, has_places)));
        }
        met |= m_bits(may) << v;
    }
    return met;
}
