/* SPDX-License-Identifier: MIT */
/*
 * t, u, v and facing of the hits of a packet (rule R5), a vector of doubles at a time: what mlrt_report_hit says of one
 * ray, to the same bits, since each is the float nearest to one and the same quotient.
 *
 * The determinants are those at the head of predicate.c, all as a cross product of two vectors of triangle and origin
 * and its dot product with a third:
 *
 *     D = d . (b-a cross c-a)     N = p . (b-a cross c-a)     e_ca = d . (c-a cross p)     e_ab = d . (p cross b-a)
 *
 * A component of a cross product has 4 factors, one of each difference, a product and a difference, and the dot product
 * adds a product and at most two sums, for N the factor of p as well. So there are 7 factors, for N 8, as there; its
 * bounds hold, and so do those of the quotients, which are formed in the same way. A quotient whose enclosure has ends
 * that round to different floats, or whose denominator is uncertain, is left to mlrt_report_hit. Where a processor
 * multiplies and adds at once there are fewer factors.
 *
 * The cross products are the same for all rays from one origin that hit one triangle: hit_terms.h keeps them. Packets
 * that hit few triangles take them from there, and others work them out for each lane.
 */

/* Few are at most this many. */
#define FEW_TRIANGLES 4

struct packet_numbers {
    MLRT_ALIGNED(64) float t[MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) float uv[2][MLRT_PACKET_RAYS];
    MLRT_ALIGNED(64) uint32_t facing[MLRT_PACKET_RAYS];
};

/* The corners of the triangles that the lanes hit. Lanes without a hit get the triangle of one that has. */
static void gather_corners(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t hit,
                           float corners[9][MLRT_PACKET_RAYS])
{
    const uint32_t standard = packet->triangle[mlrt_lowest_bit(hit)];
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; ++lane) {
        const struct mlrt_triangle *triangle = &tree->triangles[hit >> lane & 1 ? packet->triangle[lane] : standard];
        MLRT_UNROLL
        for (int k = 0; k < 9; ++k) corners[k][lane] = triangle->v[k / 3][k % 3];
    }
}

MLRT_INLINE void fused_cross_product(const vd a[3], const vd b[3], vd cross[3])
{
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        cross[k] = d_mul_sub(a[i], b[j], d_mul(a[j], b[i]));
    }
}

MLRT_INLINE vd fused_dot_product(const vd a[3], const vd b[3])
{
    return d_mul_add(a[2], b[2], d_mul_add(a[1], b[1], d_mul(a[0], b[0])));
}

/* What does not depend on rays: the sides of a triangle and its normal. */
struct plane_terms {
    vd corner[3];
    vd ab[3];
    vd ac[3];
    vd ab_size;
    vd ac_size;
};

MLRT_INLINE void set_plane_terms(const vd corner[9], struct plane_terms *plane, vd term[MLRT_HIT_TERM_COUNT])
{
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) {
        plane->corner[k] = corner[k];
        plane->ab[k] = d_sub(corner[3 + k], corner[k]);
        plane->ac[k] = d_sub(corner[6 + k], corner[k]);
    }
    plane->ab_size = size_of_doubles(plane->ab);
    plane->ac_size = size_of_doubles(plane->ac);
    fused_cross_product(plane->ab, plane->ac, term + MLRT_HIT_NORMAL);
    term[MLRT_HIT_NORMAL_SIZE] = d_mul(plane->ab_size, plane->ac_size);
}

/* The other terms (hit_terms.h), for rays from `origin`. */
MLRT_INLINE void set_origin_terms(const struct plane_terms *plane, const vd origin[3], uint32_t outputs,
                                  vd term[MLRT_HIT_TERM_COUNT])
{
    vd p[3];
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) p[k] = d_sub(plane->corner[k], origin[k]);
    const vd p_size = size_of_doubles(p);
    term[MLRT_HIT_N] = fused_dot_product(p, term + MLRT_HIT_NORMAL);
    term[MLRT_HIT_N_SIZE] = d_mul(p_size, term[MLRT_HIT_NORMAL_SIZE]);
    if (!(outputs & MLRT_OUTPUT_UV)) return;
    fused_cross_product(plane->ac, p, term + MLRT_HIT_EDGE);
    fused_cross_product(p, plane->ab, term + MLRT_HIT_EDGE + 3);
    term[MLRT_HIT_EDGE_SIZE] = d_mul(plane->ac_size, p_size);
    term[MLRT_HIT_EDGE_SIZE + 1] = d_mul(p_size, plane->ab_size);
}

/* All of them, as frame and callback may want different outputs. */
static void keep_hit_terms(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t number,
                           struct mlrt_hit_terms *kept)
{
    vd corner[9], term[MLRT_HIT_TERM_COUNT];
    const vd apex[3] = {d_set1(packet->apex[0]), d_set1(packet->apex[1]), d_set1(packet->apex[2])};
    struct plane_terms plane;
    for (int k = 0; k < 9; ++k) corner[k] = d_set1(tree->triangles[number].v[k / 3][k % 3]);
    set_plane_terms(corner, &plane, term);
    set_origin_terms(&plane, apex, MLRT_OUTPUT_UV, term);
    for (int k = 0; k < MLRT_HIT_TERM_COUNT; ++k) kept->term[k] = d_first(term[k]);
    kept->number = number;
}

/* The terms of a triangle that all lanes of a packet with an apex hit. They are there until the next call. */
MLRT_INLINE const double *find_shared_terms(const struct mlrt_tree *tree, const struct mlrt_packet *packet,
                                            uint32_t number, struct mlrt_hit_term_cache *cache)
{
    if (memcmp(packet->apex, cache->apex, sizeof cache->apex) != 0) {
        for (int i = 0; i < MLRT_HIT_TERMS_COUNT; ++i) cache->entries[i].number = MLRT_NONE;
        memcpy(cache->apex, packet->apex, sizeof cache->apex);
    }
    struct mlrt_hit_terms *kept = &cache->entries[number % MLRT_HIT_TERMS_COUNT];
    if (kept->number != number) keep_hit_terms(tree, packet, number, kept);
    return kept->term;
}

/* 1 / D, its magnitude, and what the error of D adds to a quotient relative to it. */
struct lane_denominator {
    vd inverse;
    vd inverse_size;
    vd error;
};

/* Rounds x / D to floats. Returns the lanes where that is certain. */
MLRT_INLINE uint32_t round_quotients(vd x, vd size, const struct lane_denominator *d, float *result)
{
    const vd quotient = d_mul(x, d->inverse);
    const vd width =
        d_add(d_mul(d_mul(d_set1(MLRT_NUMERATOR_ERROR), size), d->inverse_size), d_mul(d_abs(quotient), d->error));
    const vd low = d_sub(quotient, width), high = d_add(quotient, width);
    d_store(result, high);
    return MLRT_GUESS ? ALL_LANES : d_same_float(low, high);
}

/* The numbers of DW lanes. Returns those that are certain; `positive` receives those with D > 0. */
MLRT_INLINE uint32_t report_vector(const vd term[MLRT_HIT_TERM_COUNT], const struct mlrt_packet *packet, uint32_t lane,
                                   uint32_t outputs, uint32_t *positive, struct packet_numbers *numbers)
{
    const vd direction[3] = {d_load(packet->direction[0] + lane), d_load(packet->direction[1] + lane),
                             d_load(packet->direction[2] + lane)};
    const vd direction_size = size_of_doubles(direction);
    const vd d = fused_dot_product(direction, term + MLRT_HIT_NORMAL),
             d_size = d_mul(direction_size, term[MLRT_HIT_NORMAL_SIZE]);
    uint32_t certain = d_gt(d_abs(d), d_mul(d_set1(MLRT_LEAST_DENOMINATOR), d_size));
    *positive = d_gt(d, d_set1(0));
    struct lane_denominator denominator;
    denominator.inverse = d_div(d_set1(1), d);
    denominator.inverse_size = d_abs(denominator.inverse);
    denominator.error = d_mul(d_mul(d_set1(MLRT_DENOMINATOR_ERROR), d_size), denominator.inverse_size);
    if (outputs & MLRT_OUTPUT_T) {
        certain &= round_quotients(term[MLRT_HIT_N], term[MLRT_HIT_N_SIZE], &denominator, numbers->t + lane);
    }
    const int place_count = outputs & MLRT_OUTPUT_UV ? 2 : 0;
    for (int i = 0; i < place_count; ++i) {
        certain &=
            round_quotients(fused_dot_product(direction, term + MLRT_HIT_EDGE + 3 * i),
                            d_mul(direction_size, term[MLRT_HIT_EDGE_SIZE + i]), &denominator, numbers->uv[i] + lane);
    }
    return certain;
}

/* One lane, by the judge. */
static MLRT_NOINLINE void report_lane(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t lane,
                                      uint32_t outputs, struct packet_numbers *numbers)
{
    struct mlrt_ray_segment ray;
    struct mlrt_hit_report report = {0, 0, 0, 0};
    mlrt_get_segment(packet, lane, &ray);
    mlrt_report_hit(&ray, &tree->triangles[packet->triangle[lane]], outputs, &report);
    numbers->t[lane] = report.t;
    numbers->uv[0][lane] = report.u;
    numbers->uv[1][lane] = report.v;
    numbers->facing[lane] = (uint32_t)report.facing;
}

/* What a miss has. */
MLRT_INLINE void report_misses(struct packet_numbers *numbers)
{
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        v_store(numbers->t + v, v_set1(INFINITY));
        v_store(numbers->uv[0] + v, v_set1(0));
        v_store(numbers->uv[1] + v, v_set1(0));
        i_store(numbers->facing + v, i_set1(0));
    }
}

/* Puts what a miss has where there is no hit, which is rare beside hits; and facing, from where D > 0. */
MLRT_INLINE void settle_numbers(uint32_t hit, uint32_t positive, struct packet_numbers *numbers)
{
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vi facing = i_select(m_from_bits(positive >> v), i_set1(1), i_set1(0xFFFFFFFFu));
        i_store(numbers->facing + v, i_select(m_from_bits(hit >> v), facing, i_set1(0)));
    }
    for (uint32_t missing = ~hit & 0xFFFF; missing; missing &= missing - 1) {
        const uint32_t lane = mlrt_lowest_bit(missing);
        numbers->t[lane] = INFINITY;
        numbers->uv[0][lane] = numbers->uv[1][lane] = 0;
    }
}

/*
 * What is reported of lanes, in one number: bits 0 .. 15 are lanes that are certain, 16 .. 31 those that go along the
 * normal of what they hit. (Of a struct gcc would load both after storing each, and wait.)
 */
MLRT_INLINE uint32_t report_lanes(const vd term[MLRT_HIT_TERM_COUNT], const struct mlrt_packet *packet, uint32_t lane,
                                  uint32_t outputs, struct packet_numbers *numbers)
{
    uint32_t positive;
    const uint32_t certain = report_vector(term, packet, lane, outputs, &positive, numbers);
    return certain << lane | positive << (16 + lane);
}

/* All lanes that hit something hit one triangle, from one origin. */
static uint32_t report_from_apex(const struct mlrt_packet *packet, const double *shared, uint32_t outputs,
                                 struct packet_numbers *numbers)
{
    uint32_t reported = 0;
    vd term[MLRT_HIT_TERM_COUNT];
    const int count = outputs & MLRT_OUTPUT_UV ? MLRT_HIT_TERM_COUNT : MLRT_HIT_EDGE;
    for (int k = 0; k < count; ++k) term[k] = d_set1(shared[k]);
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane += DW) {
        reported |= report_lanes(term, packet, lane, outputs, numbers);
    }
    return reported;
}

MLRT_INLINE void load_origin(const struct mlrt_packet *packet, uint32_t lane, vd origin[3])
{
    for (int k = 0; k < 3; ++k) {
        origin[k] = packet->has_apex ? d_set1(packet->apex[k]) : d_load(packet->origin[k] + lane);
    }
}

/* They hit one triangle, from different origins. */
static uint32_t report_one_triangle(const struct mlrt_packet *packet, const struct mlrt_triangle *triangle,
                                    uint32_t outputs, struct packet_numbers *numbers)
{
    uint32_t reported = 0;
    vd corner[9], origin[3], term[MLRT_HIT_TERM_COUNT];
    struct plane_terms plane;
    for (int k = 0; k < 9; ++k) corner[k] = d_set1(triangle->v[k / 3][k % 3]);
    set_plane_terms(corner, &plane, term);
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane += DW) {
        load_origin(packet, lane, origin);
        set_origin_terms(&plane, origin, outputs, term);
        reported |= report_lanes(term, packet, lane, outputs, numbers);
    }
    return reported;
}

static uint32_t report_triangles(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t hit,
                                 uint32_t outputs, struct packet_numbers *numbers)
{
    uint32_t reported = 0;
    MLRT_ALIGNED(64) float corners[9][MLRT_PACKET_RAYS];
    gather_corners(tree, packet, hit, corners);
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane += DW) {
        vd corner[9], origin[3], term[MLRT_HIT_TERM_COUNT];
        struct plane_terms plane;
        for (int k = 0; k < 9; ++k) corner[k] = d_load(corners[k] + lane);
        set_plane_terms(corner, &plane, term);
        load_origin(packet, lane, origin);
        set_origin_terms(&plane, origin, outputs, term);
        reported |= report_lanes(term, packet, lane, outputs, numbers);
    }
    return reported;
}

/* The numbers of a packet's lanes, `hit` those with a hit. */
static MLRT_NOINLINE void report_packet(const struct mlrt_tree *tree, const struct mlrt_packet *packet, uint32_t hit,
                                        uint32_t outputs, struct mlrt_hit_term_cache *cache,
                                        struct packet_numbers *numbers)
{
    if (!hit) {
        report_misses(numbers);
        return;
    }
    const uint32_t number = packet->triangle[mlrt_lowest_bit(hit)];
    uint32_t reported;
    if (hit & ~lanes_of_triangle(packet, number)) {
        reported = report_triangles(tree, packet, hit, outputs, numbers);
    } else if (packet->has_apex) {
        reported = report_from_apex(packet, find_shared_terms(tree, packet, number, cache), outputs, numbers);
    } else {
        reported = report_one_triangle(packet, &tree->triangles[number], outputs, numbers);
    }
    settle_numbers(hit, reported >> 16, numbers);
    for (uint32_t left = hit & ~reported; left; left &= left - 1) {
        report_lane(tree, packet, mlrt_lowest_bit(left), outputs, numbers);
    }
}
