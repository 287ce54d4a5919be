/* SPDX-License-Identifier: MIT */
/*
 * The rays of a camera's block: the formula of camera.h, a vector of pixels at a time, to the same bits.
 */

/* Lanes whose value float arithmetic carries safely: 0 or of magnitude 2^-60 .. 2^60. */
MLRT_INLINE vm safe_lanes(vf a)
{
    const vf size = v_abs(a);
    return m_or(v_eq(a, v_set1(0)), m_and(v_ge(size, v_set1(MLRT_SAFE_MIN)), v_le(size, v_set1(MLRT_SAFE_MAX))));
}

static void get_pinhole_packet(const struct mlrt_view *view, uint32_t x, uint32_t y, uint32_t lanes,
                               struct mlrt_packet *packet)
{
    const vf x0 = v_set1((float)(view->first_x + x)), y0 = v_set1((float)(view->first_y + y));
    int apex_is_safe = 1;
    for (int k = 0; k < 3; ++k) {
        packet->apex[k] = view->eye[k];
        apex_is_safe &= mlrt_is_float_safe(view->eye[k]);
    }
    packet->has_apex = 1;
    packet->has_skip = packet->has_masks = 0;
    packet->shear = NULL;
    packet->has_limits = view->t_min > 0;
    uint32_t safe = 0, zero = 0, finite = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf xs = v_add(v_add(x0, v_load(mlrt_lane_x + v)), v_set1(view->sample_x));
        const vf ys = v_add(v_add(y0, v_load(mlrt_lane_y + v)), v_set1(view->sample_y));
        vf size = v_set1(0), difference = v_set1(0);
        vm ok = m_from_bits(0xFFFFFFFFu);
        for (int k = 0; k < 3; ++k) {
            const vf d =
                v_add(v_add(v_set1(view->d00[k]), v_mul(xs, v_set1(view->dx[k]))), v_mul(ys, v_set1(view->dy[k])));
            v_store(packet->direction[k] + v, v_add(d, v_set1(0))); /* -0 becomes 0 */
            ok = m_and(ok, safe_lanes(d));
            size = v_max(size, v_abs(d));
            difference = v_add(difference, v_sub(d, d)); /* 0, or NaN where d is not finite */
        }
        safe |= m_bits(ok) << v;
        zero |= m_bits(v_eq(size, v_set1(0))) << v;
        finite |= m_bits(v_eq(difference, v_set1(0))) << v;
        v_store(packet->t_min + v, v_set1(view->t_min));
        v_store(packet->t_max + v, v_set1(view->t_max));
        v_store(packet->lo + v, v_set1(view->t_max));
        v_store(packet->hi + v, v_set1(view->t_max));
        i_store(packet->triangle + v, i_set1(MLRT_NONE));
    }
    const uint32_t valid = view->t_min < view->t_max ? lanes & finite & ~zero : 0;
    packet->active = apex_is_safe ? valid & safe : 0;
    packet->single = valid & ~packet->active;
}
