/* SPDX-License-Identifier: MIT */
/*
 * The rays from what a packet hit to a light, a vector of doubles at a time: what shadow.h says of one ray, step by
 * step, to the same bits. Where its conditions do not hold shadow.c makes the ray.
 */

/* Of the rays of a vector: of the triangle that they hit, and what lies between it, their origin and the light. */
struct shadow_terms {
    vd m[3];
    vd n;          /* p . m */
    vd from[3];    /* from the light to the origin */
    vd plane_size; /* the greatest |p_k| / 32 */
    vd height;     /* H */
    uint32_t certain;
};

MLRT_INLINE vd greatest_of_doubles(const vd a[3])
{
    return d_max(d_max(d_abs(a[0]), d_abs(a[1])), d_abs(a[2]));
}

MLRT_INLINE void set_up_shadow_terms(const vd corner[9], const struct mlrt_packet *seen, uint32_t lane,
                                     const struct mlrt_source *light, struct shadow_terms *terms)
{
    const int is_point = light->kind == MLRT_SOURCE_POINT_LIGHT;
    vd ab[3], ac[3], p[3], to_light[3];
    for (int k = 0; k < 3; ++k) {
        const vd origin = seen->has_apex ? d_set1(seen->apex[k]) : d_load(seen->origin[k] + lane);
        const vd l = d_set1(light->light[k]);
        ab[k] = d_sub(corner[3 + k], corner[k]);
        ac[k] = d_sub(corner[6 + k], corner[k]);
        p[k] = d_sub(corner[k], origin);
        terms->from[k] = is_point ? d_sub(origin, l) : origin;
        to_light[k] = is_point ? d_sub(corner[k], l) : d_set1(-light->light[k]);
    }
    cross_product_of_doubles(ab, ac, terms->m);
    const vd greatest = greatest_of_doubles(terms->m), size = d_mul(size_of_doubles(ab), size_of_doubles(ac));
    terms->certain = d_gt(greatest, d_mul(d_set1(MLRT_SHADOW_NORMAL), size));
    const vd scale = d_div(d_set1(1), greatest);
    for (int k = 0; k < 3; ++k) terms->m[k] = d_mul(terms->m[k], scale);
    terms->n = dot_product_of_doubles(p, terms->m);
    terms->plane_size = d_mul(d_set1(MLRT_SHADOW_PLANE), greatest_of_doubles(p));
    terms->height = dot_product_of_doubles(to_light, terms->m);
    terms->certain &=
        d_gt(d_abs(terms->height), d_mul(d_set1(MLRT_SHADOW_SIDE), size_of_doubles(to_light)));
}

/* Makes the rays of DW lanes: where they end, or begin. Returns those that are certain; *facing: the light is there. */
MLRT_INLINE uint32_t make_shadow_vector(const struct shadow_terms *terms, const struct mlrt_packet *seen, uint32_t lane,
                                        uint32_t *facing, float (*ends)[MLRT_PACKET_RAYS])
{
    vd d[3], f[3], x[3];
    for (int k = 0; k < 3; ++k) d[k] = d_load(seen->direction[k] + lane);
    const vd steepness = dot_product_of_doubles(d, terms->m), t = d_div(terms->n, steepness);
    for (int k = 0; k < 3; ++k) {
        f[k] = d_mul(t, d[k]);
        x[k] = d_add(terms->from[k], f[k]);
    }
    const vd size = d_max(d_max(greatest_of_doubles(x), greatest_of_doubles(f)), terms->plane_size);
    const vd step = d_flip(d_mul(d_set1(-MLRT_SHADOW_STEP), size), steepness);
    for (int k = 0; k < 3; ++k) d_store(ends[k] + lane, d_add(x[k], d_mul(step, terms->m[k])));
    *facing = d_gt(d_flip(terms->height, steepness), d_set1(0));
    return terms->certain & d_gt(d_abs(steepness), d_mul(d_set1(MLRT_SHADOW_GRAZING), size_of_doubles(d))) &
           d_gt(size, d_set1(MLRT_SHADOW_LEAST)) & d_gt(d_set1(MLRT_SHADOW_GREATEST), size);
}

/* One lane, by shadow.c. Returns whether it faces the light; a direction of 0 is a ray that hits nothing. */
static MLRT_SMALL uint32_t make_shadow_lane(const struct mlrt_job *job, const struct mlrt_packet *seen, uint32_t lane,
                                            float (*ends)[MLRT_PACKET_RAYS])
{
    const int is_point = job->source.kind == MLRT_SOURCE_POINT_LIGHT;
    struct mlrt_ray_segment ray, shadow;
    int faces;
    mlrt_get_segment(seen, lane, &ray);
    const int is_ray =
        mlrt_make_shadow_ray(&job->source, &job->tree->triangles[seen->triangle[lane]], &ray, &faces, &shadow);
    for (int k = 0; k < 3; ++k) ends[k][lane] = !is_ray ? 0 : is_point ? shadow.direction[k] : shadow.origin[k];
    return (uint32_t)faces << lane;
}

/*
 * Makes the rays to the light of a job from what the lanes `hit` of a packet hit. Returns the lanes that the light is on
 * the other side of: they have no ray.
 */
static MLRT_NOINLINE uint32_t make_shadow_packet(const struct mlrt_job *job, const struct mlrt_packet *seen,
                                                 uint32_t hit, struct mlrt_packet *packet)
{
    const struct mlrt_source *light = &job->source;
    const int is_point = light->kind == MLRT_SOURCE_POINT_LIGHT;
    float(*ends)[MLRT_PACKET_RAYS] = is_point ? packet->direction : packet->origin;
    MLRT_ALIGNED(64) float corners[9][MLRT_PACKET_RAYS];
    const uint32_t number = seen->triangle[mlrt_lowest_bit(hit)];
    const int is_one = !(hit & ~lanes_of_triangle(seen, number)), shared = is_one && seen->has_apex;
    if (!is_one) gather_corners(job->tree, seen, hit, corners);
    struct shadow_terms terms;
    uint32_t certain = 0, facing = 0;
    for (uint32_t lane = 0; lane < MLRT_PACKET_RAYS; lane += DW) {
        uint32_t vector_facing;
        if (lane == 0 || !shared) {
            vd corner[9];
            const float *first = job->tree->triangles[number].v[0];
            for (int k = 0; k < 9; ++k) corner[k] = is_one ? d_set1(first[k]) : d_load(corners[k] + lane);
            set_up_shadow_terms(corner, seen, lane, light, &terms);
        }
        certain |= make_shadow_vector(&terms, seen, lane, &vector_facing, ends) << lane;
        facing |= vector_facing << lane;
    }
    facing &= certain;
    for (uint32_t left = hit & ~certain; left; left &= left - 1) {
        facing |= make_shadow_lane(job, seen, mlrt_lowest_bit(left), ends);
    }
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        for (int k = 0; !is_point && k < 3; ++k) v_store(packet->direction[k] + v, v_set1(light->light[k]));
        v_store(packet->t_min + v, v_set1(0));
        v_store(packet->t_max + v, v_set1(is_point ? 1 : INFINITY));
        i_store(packet->skip + v, i_load(seen->triangle + v));
    }
    memcpy(packet->apex, light->light, sizeof packet->apex);
    packet->has_apex = is_point;
    packet->has_skip = 1;
    packet->has_limits = packet->has_masks = 0;
    packet->shear = NULL;
    check_packet(hit & facing, packet);
    if (!job->tree->bvh.float_safe) {
        packet->single |= packet->active;
        packet->active = 0;
    }
    return hit & ~facing;
}

/*
 * Makes the rays of a tile's packet to the light of a job; of the picture's packet, too, if it has none yet. Returns the
 * lanes that the light is on the other side of.
 */
static MLRT_NOINLINE uint32_t make_rays_to_light(const struct mlrt_job *job, struct ray_tile *tile, uint32_t place)
{
    struct ray_tile *seen = tile->seen;
    struct mlrt_packet *packet = &seen->packets[place];
    const struct rectangle block = block_of_tile(seen, place);
    const uint32_t lanes = existing_lanes(&tile->picture->source, &block);
    if (!(seen->made >> place & 1)) {
        get_packet(&tile->picture->source, &block, lanes, packet);
        for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
            i_store(packet->triangle + v, i_set1(seen->cells.cover[place]));
        }
        seen->made |= 1u << place;
    }
    const uint32_t hit = lanes & ~lanes_of_triangle(packet, MLRT_NONE);
    if (hit) return make_shadow_packet(job, packet, hit, &tile->packets[place]);
    tile->packets[place].shear = NULL;
    check_packet(0, &tile->packets[place]);
    return 0;
}
