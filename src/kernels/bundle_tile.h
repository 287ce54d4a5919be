/* SPDX-License-Identifier: MIT */
/*
 * A tile of packets, from anywhere, down the hierarchy of boxes, in three steps: packets that are alike go as a bundle, by
 * their hulls (bundle.h); those too wide for that go lane by lane, and from the box on that few lanes meet, one by one
 * (lanes.h).
 *
 * Of a bundle what is near comes first. A node's sixteen boxes are compared with the whole bundle at once, and before
 * anything is opened its box is compared with all sixteen packets at once, since many of them may have found something
 * nearer in the meantime.
 *
 * Based on: Reshetov et al. 2005 (one traversal for all rays of a tile); I. Wald, S. Boulos, P. Shirley, "Ray Tracing
 * Deformable Scenes Using Dynamic Bounding Volume Hierarchies", 2007 (frusta against boxes).
 */

/* Packets so many times as wide as most of their tile go lane by lane: they lie across an edge of what the tile sees. */
#define WIDE_PACKET MLRT_WIDE_FACTOR

/* After hits of a packet in these lanes. */
static MLRT_NOINLINE void update_bundle(struct bundle *bundle, uint32_t place, uint32_t changed, int any)
{
    struct mlrt_packet *packet = &bundle->tile->packets[place];
    if (!any) {
        update_last_depth(bundle, place);
        return;
    }
    packet->active &= ~changed;
    if (!packet->active) {
        leave_bundle(bundle, place);
        return;
    }
    bound_packet(bundle, place);
    finish_hulls(bundle, (int)(place - place % VW));
}

/* Takes a packet out of the bundle that has been tested so often that its rays had better gone lane by lane. */
static MLRT_NOINLINE void give_up_packet(const struct mlrt_job *job, struct mlrt_worker *worker, struct bundle *bundle,
                                         uint32_t place)
{
    struct mlrt_packet *packet = &bundle->tile->packets[place];
    leave_bundle(bundle, place);
    set_packet_distances(&bundle->rays[place], packet);
    trace_lanes(job, packet->active, packet, worker);
}

MLRT_INLINE void visit_leaf_of_bundle(const struct mlrt_job *job, struct mlrt_worker *worker, struct bundle *bundle,
                                      uint32_t child, uint32_t met, int has_places)
{
    const struct mlrt_bundle_leaf *leaf =
        find_bundle_leaf(job, bundle, child, worker, &worker->bundle_caches[job->any]);
    const struct mlrt_hull *whole = &bundle->whole;
    const struct mlrt_hulls *hulls = &bundle->hulls;
    const uint32_t seen = triangles_met(leaf, whole->first, whole->last, whole->slope_lo, whole->slope_hi, whole->place_lo,
                                        whole->place_hi, has_places, leaf->there);
    if (!seen) return;
    for (; met; met &= met - 1) {
        const uint32_t place = mlrt_lowest_bit(met);
        const float slope_lo[2] = {hulls->slope[0].lo[place], hulls->slope[1].lo[place]};
        const float slope_hi[2] = {hulls->slope[0].hi[place], hulls->slope[1].hi[place]};
        const float place_lo[2] = {hulls->place[0].lo[place], hulls->place[1].lo[place]};
        const float place_hi[2] = {hulls->place[0].hi[place], hulls->place[1].hi[place]};
        uint32_t triangles = triangles_met(leaf, hulls->first[place], hulls->last[place], slope_lo, slope_hi, place_lo,
                                           place_hi, has_places, seen);
        if (!triangles) continue;
        triangles = triangles_within_edges(bundle, leaf, place, has_places, triangles);
        if (!triangles) continue;
        bundle->tests[place] += mlrt_count_bits(triangles);
        if (MLRT_UNLIKELY(bundle->tests[place] > MLRT_MOST_TESTS)) {
            give_up_packet(job, worker, bundle, place);
            continue;
        }
        const uint32_t changed = test_bundle_packet(job, worker, bundle, leaf, triangles, place, has_places);
        if (changed) update_bundle(bundle, place, changed, job->any);
    }
    set_whole_last(bundle);
}

MLRT_INLINE void traverse_bundle_by(const struct mlrt_job *job, struct mlrt_worker *worker, struct bundle *bundle,
                                    int has_places)
{
    const struct mlrt_bvh *bvh = &job->tree->bvh;
    struct pending_box stack[TILE_STACK_SIZE];
    MLRT_ALIGNED(64) float near[MLRT_BVH_WIDTH];
    uint32_t node = 0, count = 0;
    for (;;) {
        COUNT(&worker->counters, cell_count, 1);
        const uint32_t boxes = bundle_children_met(bundle, &bvh->nodes[node], has_places, near);
        for (int v = 0; bundle->far_first && v < MLRT_BVH_WIDTH; v += VW) {
            v_store(near + v, v_sub(v_set1(0), v_load(near + v)));
        }
        count = push_boxes(bvh, node, boxes, near, stack, count);
        for (;;) {
            if (count == 0) return;
            const struct pending_box *top = &stack[--count];
            if (!bundle->far_first && top->near > bundle->whole.last) continue;
            const struct mlrt_bvh_node *parent = &bvh->nodes[top->slot / MLRT_BVH_WIDTH];
            const uint32_t place = top->slot % MLRT_BVH_WIDTH, child = parent->child[place];
            struct box_of_bundle box;
            see_bundle_box(&bundle->waist, parent, place, &box);
            const uint32_t met = packets_met(bundle, &box, has_places);
            if (!met) continue;
            if (!mlrt_bvh_quad_count(child)) {
                node = mlrt_bvh_offset(child);
                break;
            }
            COUNT(&worker->counters, cell_count, 1);
            visit_leaf_of_bundle(job, worker, bundle, child, met, has_places);
        }
    }
}

static MLRT_NOINLINE void traverse_bundle(const struct mlrt_job *job, struct mlrt_worker *worker, struct bundle *bundle)
{
    if (bundle->has_places) {
        traverse_bundle_by(job, worker, bundle, 1);
    } else {
        traverse_bundle_by(job, worker, bundle, 0);
    }
}

/* ---- tiles ---- */

/* The axis along which a ray goes most, and its sign; seen from the ray's origin. */
static void look_along(const struct mlrt_packet *packet, uint32_t lane, struct mlrt_waist *from)
{
    const float x = fabsf(packet->direction[0][lane]), y = fabsf(packet->direction[1][lane]);
    const float z = fabsf(packet->direction[2][lane]);
    from->main_axis = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
    from->sign = packet->direction[from->main_axis][lane] < 0 ? -1.0f : 1.0f;
    for (int k = 0; k < 3; ++k) from->point[k] = packet->has_apex ? packet->apex[k] : packet->origin[k][lane];
}

/* Have all of these packets the same apex? */
static int have_one_apex(const struct mlrt_ray_tile *tile, uint32_t places, float apex[3])
{
    const struct mlrt_packet *first = &tile->packets[mlrt_lowest_bit(places)];
    if (!first->has_apex) return 0;
    memcpy(apex, first->apex, sizeof first->apex);
    for (; places; places &= places - 1) {
        const struct mlrt_packet *packet = &tile->packets[mlrt_lowest_bit(places)];
        if (!packet->has_apex || memcmp(packet->apex, apex, sizeof packet->apex) != 0) return 0;
    }
    return 1;
}

static void look_at_scene(const struct mlrt_box *bounds, struct bundle *bundle)
{
    const struct mlrt_waist *waist = &bundle->waist;
    const float below = bounds->lo[waist->main_axis] - waist->point[waist->main_axis];
    const float above = bounds->hi[waist->main_axis] - waist->point[waist->main_axis];
    bundle->scene_first = waist->sign > 0 ? below : -above;
    bundle->scene_last = waist->sign > 0 ? above : -below;
}

/* Of the packets that go, those far wider than most. */
static MLRT_NOINLINE uint32_t find_wide_bundles(const struct bundle *bundle)
{
    const struct mlrt_hulls *hulls = &bundle->hulls;
    MLRT_ALIGNED(64) float widths[MLRT_BUNDLE_PACKETS];
    vf least = v_set1(INFINITY), greatest = v_set1(0);
    for (int v = 0; v < MLRT_BUNDLE_PACKETS; v += VW) {
        const vm going = m_from_bits(bundle->going >> v);
        const vf depth = v_max(v_abs(v_load(hulls->first + v)), v_abs(v_load(hulls->last + v)));
        vf width = v_set1(0);
        for (int i = 0; i < 2; ++i) {
            width = v_mul_add(v_load(hulls->radius[i] + v), depth, width);
            if (bundle->has_places) width = v_add(v_load(hulls->radius[MLRT_PLACE_J + i] + v), width);
        }
        v_store(widths + v, width);
        least = v_min(v_select(going, width, v_set1(INFINITY)), least);
        greatest = v_max(v_select(going, width, v_set1(0)), greatest);
    }
    if (MLRT_LIKELY(v_hmax(greatest) <= WIDE_PACKET * v_hmin(least))) return 0;
    float sorted[MLRT_BUNDLE_PACKETS];
    uint32_t count = 0, wide = 0;
    for (uint32_t left = bundle->going; left; left &= left - 1) {
        const float width = widths[mlrt_lowest_bit(left)];
        uint32_t at = count++;
        for (; at > 0 && sorted[at - 1] > width; --at) sorted[at] = sorted[at - 1];
        sorted[at] = width;
    }
    const float limit = WIDE_PACKET * sorted[count / 4];
    for (uint32_t left = bundle->going; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        if (!(widths[place] <= limit)) wide |= 1u << place;
    }
    return count > 1 ? wide : 0;
}

/*
 * Are the rays of a bundle closer together where they end than where they begin? Who looks for any hit goes there first,
 * since a triangle is likelier to hide all rays where they are close. Rays that are equally close everywhere begin on
 * surfaces, as a rule, and end in the open.
 */
static int ends_closer(const struct bundle *bundle)
{
    const struct mlrt_hull *whole = &bundle->whole;
    float spread = 0, width = 0;
    for (int i = 0; i < 2; ++i) {
        spread += whole->slope_hi[i] - whole->slope_lo[i];
        width += whole->place_hi[i] - whole->place_lo[i];
    }
    return spread * (whole->last - whole->first) < width || fabsf(whole->last) < fabsf(whole->first);
}

/*
 * Makes a bundle of the packets `waiting` that go along one main axis; returns the others. What remains of the bundle is
 * in `going`.
 */
static MLRT_NOINLINE uint32_t make_bundle(const struct mlrt_job *job, struct mlrt_worker *worker, uint32_t waiting,
                                          struct bundle *bundle)
{
    struct mlrt_bundle_cache *cache = &worker->bundle_caches[job->any];
    struct mlrt_ray_tile *tile = bundle->tile;
    struct mlrt_waist from;
    struct ray_sums sums = {{v_set1(0), v_set1(0)}, {v_set1(0), v_set1(0)}, v_set1(0), v_set1(0), v_set1(0)};
    uint32_t middle = waiting, ray_count = 0;
    while (mlrt_count_bits(middle) > mlrt_count_bits(waiting) / 2 + 1) middle &= middle - 1;
    const struct mlrt_packet *first = &tile->packets[mlrt_lowest_bit(middle)];
    look_along(first, mlrt_lowest_bit(first->active), &from);
    bundle->going = 0;
    bundle->has_begins = 0;
    for (uint32_t left = waiting; left; left &= left - 1) {
        const uint32_t place = mlrt_lowest_bit(left);
        const struct mlrt_packet *packet = &tile->packets[place];
        if (!add_slopes(packet, &from, &bundle->rays[place], &sums)) continue;
        bundle->going |= 1u << place;
        ray_count += mlrt_count_bits(packet->active);
        if (packet->has_limits) bundle->has_begins |= highest(packet->t_min, packet->active) > 0;
    }
    if (!bundle->going) return waiting;
    bundle->has_places = 1;
    if (have_one_apex(tile, bundle->going, from.point)) {
        bundle->has_places = 0;
        bundle->waist = from;
    } else {
        choose_waist(&job->tree->bounds, &from, &sums, ray_count, &cache->waist, &bundle->waist);
    }
    look_at_scene(&job->tree->bounds, bundle);
    for (uint32_t place = 0; place < MLRT_BUNDLE_PACKETS; ++place) {
        if (!(bundle->going >> place & 1)) {
            leave_bundle(bundle, place);
            continue;
        }
        set_ray_terms(&tile->packets[place], &bundle->waist, &bundle->rays[place]);
        set_ray_limits(&tile->packets[place], &bundle->rays[place]);
        bound_packet(bundle, place);
        bundle->tests[place] = 0;
    }
    for (int v = 0; v < MLRT_BUNDLE_PACKETS; v += VW) finish_hulls(bundle, v);
    const uint32_t wide = find_wide_bundles(bundle);
    for (uint32_t left = wide; left; left &= left - 1) leave_bundle(bundle, mlrt_lowest_bit(left));
    sum_up_hulls(bundle);
    bundle->far_first = job->any && ends_closer(bundle);
    keep_bundle_waist(&bundle->waist, cache);
    return waiting & ~bundle->going;
}

/* Traces the packets `waiting` of a tile, whose rays are there. */
static MLRT_NOINLINE void trace_bundle(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_ray_tile *tile,
                                       uint32_t waiting)
{
    struct bundle bundle;
    if (!waiting || job->tree->bvh.node_count == 0) return;
    bundle.tile = tile;
    uint32_t others = make_bundle(job, worker, waiting, &bundle);
    if (bundle.going) traverse_bundle(job, worker, &bundle);
    for (; others; others &= others - 1) {
        struct mlrt_packet *packet = &tile->packets[mlrt_lowest_bit(others)];
        trace_lanes(job, packet->active, packet, worker);
    }
}
