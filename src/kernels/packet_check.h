/* SPDX-License-Identifier: MIT */
/*
 * What hit.h's mlrt_make_segment and source.h's mlrt_is_safe_ray say of one ray, for the rays of a packet as a source
 * gave them (mlrt_fetch_packet), a vector at a time.
 */

/* Lanes whose value float arithmetic carries safely: 0 or of magnitude 2^-60 .. 2^60. */
MLRT_INLINE vm safe_lanes(vf a)
{
    const vf size = v_abs(a);
    return m_or(v_eq(a, v_set1(0)), m_and(v_ge(size, v_set1(MLRT_SAFE_MIN)), v_le(size, v_set1(MLRT_SAFE_MAX))));
}

/* Lanes whose direction is finite and not 0, so that they can hit something; and those whose direction float carries.
 */
struct checked_lanes {
    uint32_t valid;
    uint32_t safe;
};

/* Directions of VW lanes from lane v on: checked, and put where they belong. -0 becomes 0. */
MLRT_INLINE void take_directions(const vf d[3], int v, struct mlrt_packet *packet, struct checked_lanes *lanes)
{
    vf size = v_set1(0), difference = v_set1(0);
    vm is_safe = m_from_bits(0xFFFFFFFFu);
    for (int k = 0; k < 3; ++k) {
        v_store(packet->direction[k] + v, v_add(d[k], v_set1(0)));
        is_safe = m_and(is_safe, safe_lanes(d[k]));
        size = v_max(size, v_abs(d[k]));
        difference = v_add(difference, v_sub(d[k], d[k])); /* 0, or NaN where a number is not finite */
    }
    lanes->valid |= m_bits(m_andnot(v_eq(difference, v_set1(0)), v_eq(size, v_set1(0)))) << v;
    lanes->safe |= m_bits(is_safe) << v;
}

/* Where rays begin and end, and that nothing was hit so far. */
MLRT_INLINE void take_limits(vf t_min, vf t_max, int v, struct mlrt_packet *packet)
{
    v_store(packet->t_min + v, t_min);
    v_store(packet->t_max + v, t_max);
    v_store(packet->lo + v, t_max);
    v_store(packet->hi + v, t_max);
    i_store(packet->triangle + v, i_set1(MLRT_NONE));
}

/* Rule R1 (hit.h), and which rays float can carry (packet.h). */
MLRT_INLINE void check_packet(uint32_t lanes, struct mlrt_packet *packet)
{
    struct checked_lanes checked = {0, 0};
    KEEP_LANES_LOOP
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vf difference = v_set1(0), d[3];
        vm is_safe = m_from_bits(0xFFFFFFFFu);
        MLRT_KEEP_LOOP
        for (int k = 0; k < 3; ++k) {
            const vf o = packet->has_apex ? v_set1(packet->apex[k]) : v_load(packet->origin[k] + v);
            d[k] = v_load(packet->direction[k] + v);
            is_safe = m_and(is_safe, safe_lanes(o));
            difference = v_add(difference, v_sub(o, o));
        }
        take_directions(d, v, packet, &checked);
        const vf given = v_load(packet->t_min + v), t_max = v_load(packet->t_max + v);
        const vf t_min = v_select(v_lt(given, v_set1(0)), v_set1(0), given);
        take_limits(t_min, t_max, v, packet);
        checked.valid &= ~((~m_bits(m_and(v_lt(t_min, t_max), v_eq(difference, v_set1(0)))) & ALL_LANES) << v);
        checked.safe &= ~((~m_bits(is_safe) & ALL_LANES) << v);
    }
    packet->active = lanes & checked.valid & checked.safe;
    packet->single = lanes & checked.valid & ~checked.safe;
}

/* Do all rays that can hit something start at one point? */
MLRT_INLINE void find_apex(struct mlrt_packet *packet)
{
    const uint32_t valid = packet->active | packet->single;
    uint32_t first = 0, elsewhere = 0;
    while (first < MLRT_PACKET_RAYS - 1 && !(valid >> first & 1)) ++first;
    for (int k = 0; k < 3; ++k) {
        packet->apex[k] = packet->origin[k][first];
        KEEP_LANES_LOOP
        for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
            const unsigned same = m_bits(v_eq(v_load(packet->origin[k] + v), v_set1(packet->apex[k])));
            elsewhere |= (~same & ALL_LANES) << v;
        }
    }
    packet->has_apex = (elsewhere & valid) == 0;
}

/* A mesh that was looked up, and its triangles. At first it is that of nothing. */
struct known_mesh {
    uint32_t id;
    struct mlrt_mesh_range range;
};

#define NO_MESH ((struct known_mesh){MLRT_NONE, {0, 0}})

/*
 * Turns pairs of mesh and triangle that rays pass into triangle numbers. Neighbours mostly pass triangles of one mesh,
 * or nothing.
 */
MLRT_INLINE void number_skips(const struct mlrt_tree *tree, struct known_mesh *known, struct mlrt_packet *packet)
{
    const uint32_t id = packet->skip_mesh[0];
    uint32_t same = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        same |= m_bits(i_eq(i_load(packet->skip_mesh + v), i_set1(id))) << v;
    }
    if (MLRT_UNLIKELY(same != 0xFFFF)) {
        mlrt_number_skips(tree, packet);
        return;
    }
    if (known->id != id) *known = (struct known_mesh){id, mlrt_find_mesh(tree, id)};
    const struct mlrt_mesh_range mesh = known->range;
    KEEP_LANES_LOOP
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vi triangle = i_load(packet->skip + v), number = i_sub(triangle, i_set1(0u - mesh.first));
        i_store(packet->skip + v, i_select(i_lt(triangle, i_set1(mesh.count)), number, i_set1(MLRT_NONE)));
    }
}
