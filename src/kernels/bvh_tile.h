/* SPDX-License-Identifier: MIT */
/*
 * A tile of packets down the hierarchy of boxes: what is near comes first, a node's sixteen boxes are compared with the
 * whole tile at once, and before anything is opened its box is compared with all sixteen packets at once, since many of
 * them may have found something nearer in the meantime.
 *
 * Based on: Reshetov et al. 2005 (one traversal for all rays of a tile, which is cut down to packets); I. Wald, S.
 * Boulos, P. Shirley, "Ray Tracing Deformable Scenes Using Dynamic Bounding Volume Hierarchies", 2007 (frusta against
 * boxes).
 */

/* A child that is still to be opened. */
struct pending_box {
    float near;    /* depth */
    uint32_t slot; /* 16 * node + place in it */
};

#define TILE_STACK_SIZE (MLRT_BVH_DEPTH_LIMIT * (MLRT_BVH_WIDTH - 1) + 1)

/* The children of a node whose boxes the cells may meet; their least depths go to `near`. */
MLRT_INLINE uint32_t children_met(const struct mlrt_cells *cells, const struct mlrt_bvh_node *node,
                                  float near[MLRT_BVH_WIDTH])
{
    const int a = cells->main_axis;
    const vf apex = v_set1(cells->apex[a]), zero = v_set1(0);
    uint32_t met = 0;
    for (int v = 0; v < MLRT_BVH_WIDTH; v += VW) {
        const vf below = v_sub(v_load(node->lo[a] + v), apex), above = v_sub(v_load(node->hi[a] + v), apex);
        const vf first = v_max(cells->sign > 0 ? below : v_sub(zero, above), zero);
        const vf last = cells->sign > 0 ? above : v_sub(zero, below);
        vm may = m_and(v_ge(last, zero), v_le(first, v_set1(cells->whole_farthest)));
        for (int side = 0; side < 2; ++side) {
            const int j = mlrt_slope_axis(a, side);
            const float lo = cells->slope_lo[side], hi = cells->slope_hi[side];
            const vf least = v_sub(v_load(node->lo[j] + v), v_set1(cells->apex[j]));
            const vf greatest = v_sub(v_load(node->hi[j] + v), v_set1(cells->apex[j]));
            may = m_and(may, v_le(least, v_mul(v_set1(hi), hi > 0 ? last : first)));
            may = m_and(may, v_ge(greatest, v_mul(v_set1(lo), lo >= 0 ? first : last)));
        }
        v_store(near + v, first);
        met |= m_bits(may) << v;
    }
    return met;
}

/* The cells that may meet a box, which is child `place` of a node. Its last depth may be infinite, and the product of that
 * and a slope 0 no number: as the first operand it is dropped. */
MLRT_INLINE uint32_t cells_met(const struct mlrt_cells *cells, const struct mlrt_bvh_node *node, uint32_t place)
{
    struct mlrt_seen_box box;
    mlrt_see_box(cells, node, place, &box);
    const vf first = v_set1(box.first), last = v_set1(box.last);
    uint32_t met = 0;
    for (int v = 0; v < MLRT_CELL_COUNT; v += VW) {
        vm may = v_le(v_set1(box.nearest), v_load(cells->farthest + v));
        for (int side = 0; side < 2; ++side) {
            const vf lo = v_load(cells->slopes[side].lo + v), hi = v_load(cells->slopes[side].hi + v);
            const vf least = v_set1(box.begin[side]), greatest = v_set1(box.end[side]);
            may = m_and(may, v_le(least, v_max(v_mul(hi, last), v_mul(hi, first))));
            may = m_and(may, v_ge(greatest, v_min(v_mul(lo, last), v_mul(lo, first))));
        }
        met |= m_bits(may) << v;
    }
    return met;
}

/* Has what a child refers to fetched into the cache. */
MLRT_INLINE void prefetch_child(const struct mlrt_bvh *bvh, uint32_t child)
{
    const uint32_t quads = mlrt_bvh_quad_count(child), offset = mlrt_bvh_offset(child);
    const char *first = quads ? (const char *)(bvh->corners + 36 * (size_t)offset) : (const char *)&bvh->nodes[offset];
    const uint32_t size = quads ? 144 * quads : (uint32_t)sizeof *bvh->nodes;
    for (uint32_t i = 0; i < size; i += 64) mlrt_prefetch(first + i);
    if (quads) mlrt_prefetch(bvh->numbers + 4 * (size_t)offset);
}

/* Puts children on the stack, the nearest on top. */
MLRT_INLINE uint32_t push_boxes(const struct mlrt_bvh *bvh, uint32_t node, uint32_t met,
                                const float near[MLRT_BVH_WIDTH], struct pending_box *stack, uint32_t count)
{
    const uint32_t base = count;
    for (; met; met &= met - 1) {
        const uint32_t place = mlrt_lowest_bit(met);
        uint32_t at = count++;
        for (; at > base && stack[at - 1].near < near[place]; --at) stack[at] = stack[at - 1];
        stack[at] = (struct pending_box){near[place], node * MLRT_BVH_WIDTH + place};
        prefetch_child(bvh, bvh->nodes[node].child[place]);
    }
    return count;
}

#define PACKET_VECTORS (MLRT_PACKET_RAYS / VW)

/*
 * A vector of a packet's rays, in registers while triangles of a leaf pass by. What is nearest stays a quotient of
 * bounds (triangle_filter.h, "DISTANCES"), since products say which of two quotients is less: where a product of floats
 * is less than another after rounding, it is so before.
 */
struct ray_vector {
    vf direction[3];
    vf least_n; /* t of the nearest hit so far is between least_n / greatest_d and greatest_n / least_d */
    vf greatest_n;
    vf least_d;
    vf greatest_d;
    vi triangle;
};

MLRT_INLINE void load_ray_vector(const struct mlrt_packet *packet, int v, struct ray_vector *rays)
{
    MLRT_UNROLL
    for (int k = 0; k < 3; ++k) rays->direction[k] = v_load(packet->direction[k] + v);
    rays->least_n = v_load(packet->lo + v);
    rays->greatest_n = v_load(packet->hi + v);
    rays->least_d = rays->greatest_d = v_set1(1);
    rays->triangle = i_load(packet->triangle + v);
}

/*
 * Stores the nearest hits of the lanes where they changed, and returns these. A quotient has a rounding, and so has the
 * product that moves it; where they lose 2^-149, N's bounds have 2^-83 / D to spare.
 */
MLRT_INLINE uint32_t store_ray_vector(const struct ray_vector *rays, int v, struct mlrt_packet *packet)
{
    const vm same = i_eq(rays->triangle, i_load(packet->triangle + v));
    const uint32_t changed = ~m_bits(same) & ALL_LANES;
    if (!changed) return 0;
    const vf lo = v_mul(v_div(rays->least_n, rays->greatest_d), v_set1(1 - RECIPROCAL_SLACK));
    const vf hi = v_mul(v_div(rays->greatest_n, rays->least_d), v_set1(1 + RECIPROCAL_SLACK));
    v_store(packet->lo + v, v_select(same, v_load(packet->lo + v), lo));
    v_store(packet->hi + v, v_select(same, v_load(packet->hi + v), hi));
    i_store(packet->triangle + v, rays->triangle);
    return changed << v;
}

/* How far off the filter's edge functions and D may be, over all rays of a packet. */
struct filter_bounds {
    vf edge;
    vf plane;
};

/* What the filter says of a triangle of a leaf. */
struct leaf_verdict {
    vm nearer; /* as in struct verdict */
    vm undecided;
    vm inside;
    vf least_d; /* bounds of D */
    vf greatest_d;
};

/*
 * The float part of a test of rays against the triangle at `place` of a leaf: filter_vector for triangles whose
 * sign is known, where D < 0 is a miss and, with t_min = 0, N / D is surely above it. First the edges of so many
 * vectors of rays: the least of the edge functions of each,
 */
MLRT_INLINE void find_least_edges(const struct mlrt_leaf_setup *leaf, uint32_t place, vf (*direction)[3], int vectors,
                                  vf *least)
{
    MLRT_UNROLL
    for (int edge = 0; edge < 3; ++edge) {
        const vf cross[3] = {v_set1(leaf->cross[edge][0][place]), v_set1(leaf->cross[edge][1][place]),
                             v_set1(leaf->cross[edge][2][place])};
        MLRT_UNROLL
        for (int i = 0; i < vectors; ++i) {
            const vf product = dot_product(direction[i], cross);
            least[i] = edge == 0 ? product : v_min(least[i], product);
        }
    }
}

/* and then the distances, of rays that are not surely outside. `t_min` is NULL if all are 0. */
MLRT_INLINE struct leaf_verdict filter_leaf_vector(const struct mlrt_leaf_setup *leaf, uint32_t place,
                                                   const struct filter_bounds *bounds, const float *t_min,
                                                   const struct ray_vector *rays, vf least, vm candidates)
{
    struct leaf_verdict verdict;
    const vf normal[3] = {v_set1(leaf->cross[3][0][place]), v_set1(leaf->cross[3][1][place]),
                          v_set1(leaf->cross[3][2][place])};
    const vf size = dot_product(rays->direction, normal), width = bounds->plane;
    const vf least_d = v_sub(size, width), greatest_d = v_add(size, width);
    const vf least_n = v_set1(leaf->least_n[place]), greatest_n = v_set1(leaf->greatest_n[place]);
    const vm certain = m_and(candidates, v_gt(least_d, width));
    vm farther = v_gt(v_mul(least_n, rays->least_d), v_mul(rays->greatest_n, greatest_d));
    vm nearer = v_lt(v_mul(greatest_n, rays->greatest_d), v_mul(rays->least_n, least_d));
    if (MLRT_UNLIKELY(t_min != NULL)) {
        const vf from = v_load(t_min);
        farther = m_or(farther, v_le(greatest_n, v_mul(from, least_d)));
        nearer = m_and(nearer, m_or(v_gt(least_n, v_mul(from, greatest_d)), v_eq(from, v_set1(0))));
    }
    verdict.inside = m_and(certain, v_gt(least, bounds->edge));
    if (MLRT_GUESS) verdict.inside = m_and(candidates, v_gt(size, v_set1(0)));
    verdict.nearer = m_and(verdict.inside, nearer);
    verdict.undecided =
        m_andnot(m_andnot(m_andnot(candidates, m_and(certain, farther)), verdict.nearer), v_lt(greatest_d, v_set1(0)));
    if (MLRT_GUESS) verdict.undecided = m_andnot(candidates, candidates);
    verdict.least_d = least_d;
    verdict.greatest_d = greatest_d;
    return verdict;
}

/* Makes a triangle of a leaf the nearest hit where it is. */
MLRT_INLINE void keep_leaf_verdict(const struct leaf_verdict *verdict, const struct mlrt_leaf_setup *leaf,
                                   uint32_t place, struct ray_vector *rays)
{
    rays->least_n = v_select(verdict->nearer, v_set1(leaf->least_n[place]), rays->least_n);
    rays->greatest_n = v_select(verdict->nearer, v_set1(leaf->greatest_n[place]), rays->greatest_n);
    rays->least_d = v_select(verdict->nearer, verdict->least_d, rays->least_d);
    rays->greatest_d = v_select(verdict->nearer, verdict->greatest_d, rays->greatest_d);
    rays->triangle = i_select(verdict->nearer, i_set1(leaf->numbers[place]), rays->triangle);
}

/* Tests a vector of a packet's rays against triangles of a leaf, by the least of their edge functions. Returns the
 * lanes whose nearest hit changed. */
MLRT_INLINE uint32_t test_ray_vector(const struct mlrt_job *job, struct mlrt_worker *worker,
                                     const struct mlrt_leaf_setup *leaf, uint32_t triangles,
                                     float (*edges)[MLRT_PACKET_RAYS], const struct filter_bounds *bounds,
                                     const float *t_min, int v, struct mlrt_packet *packet)
{
    const vi skip = packet->has_skip ? i_load(packet->skip + v) : i_set1(MLRT_NONE);
    struct ray_vector rays;
    uint32_t decided = 0;
    load_ray_vector(packet, v, &rays);
    for (; triangles; triangles &= triangles - 1) {
        const uint32_t place = mlrt_lowest_bit(triangles), number = leaf->numbers[place];
        const vf least = v_load(edges[place] + v);
        const vm known = m_or(i_eq(rays.triangle, i_set1(number)), i_eq(skip, i_set1(number)));
        const vm candidates = m_andnot(v_ge(least, v_sub(v_set1(0), bounds->edge)), known);
        const struct leaf_verdict verdict = filter_leaf_vector(leaf, place, bounds, t_min, &rays, least, candidates);
        keep_leaf_verdict(&verdict, leaf, place, &rays);
        if (MLRT_LIKELY(!m_bits(verdict.undecided))) continue;
        decided |= store_ray_vector(&rays, v, packet);
        decided |= decide_lanes(job->tree, number, m_bits(verdict.undecided) << v, m_bits(verdict.inside) << v,
                                packet, worker, COUNTERS(worker));
        load_ray_vector(packet, v, &rays);
    }
    return decided | store_ray_vector(&rays, v, packet);
}

/*
 * Finds the least edge functions of all rays of a packet, and of triangles of a leaf those that some ray of each vector
 * is not surely outside of: with nothing at hand but directions, and no branch on what each triangle says. Most of many
 * have no ray inside, and are done with so; so are those that rays to a light begin on, and pass.
 */
MLRT_INLINE void find_edges(const struct mlrt_leaf_setup *leaf, uint32_t triangles, vf edge_bound,
                            const struct mlrt_packet *packet, float (*edges)[MLRT_PACKET_RAYS],
                            uint32_t of_vector[PACKET_VECTORS])
{
    vf direction[PACKET_VECTORS][3];
    MLRT_UNROLL
    for (int i = 0; i < PACKET_VECTORS; ++i) {
        of_vector[i] = 0;
        const vm active = m_from_bits(packet->active >> VW * i);
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) {
            direction[i][k] = v_select(active, v_load(packet->direction[k] + VW * i), v_set1(NAN));
        }
    }
    for (; triangles; triangles &= triangles - 1) {
        const uint32_t place = mlrt_lowest_bit(triangles), bit = triangles & (0u - triangles);
        vf least[PACKET_VECTORS];
        vm may[PACKET_VECTORS];
        find_least_edges(leaf, place, direction, PACKET_VECTORS, least);
        MLRT_UNROLL
        for (int i = 0; i < PACKET_VECTORS; ++i) {
            v_store(edges[place] + VW * i, least[i]);
            may[i] = v_ge(least[i], v_sub(v_set1(0), edge_bound));
        }
        if (packet->has_skip) {
            MLRT_UNROLL
            for (int i = 0; i < PACKET_VECTORS; ++i) {
                may[i] = m_andnot(may[i], i_eq(i_load(packet->skip + VW * i), i_set1(leaf->numbers[place])));
            }
        }
        MLRT_UNROLL
        for (int i = 0; i < PACKET_VECTORS; ++i) of_vector[i] |= m_bits(may[i]) ? bit : 0;
    }
}

/* After hits of an open packet, those that look no further in the lanes `done`. */
static MLRT_NOINLINE void update_cell(struct mlrt_ray_tile *tile, uint32_t place, uint32_t done)
{
    struct mlrt_packet *packet = &tile->packets[place];
    packet->active &= ~done;
    if (done && packet->active) {
        add_packet(tile, place); /* narrower than it was, and so a cell; but not one without rays */
        tile->cells.closed &= ~(1u << place);
    } else {
        tile->cells.farthest[place] = farthest_depth(packet, tile->cells.main_axis);
    }
}

/* Tests a packet against triangles of a leaf. */
static MLRT_NOINLINE void test_packet(const struct mlrt_job *job, struct mlrt_worker *worker,
                                      struct mlrt_ray_tile *tile, const struct mlrt_leaf_setup *leaf,
                                      uint32_t triangles, uint32_t place)
{
    struct mlrt_packet *packet = &tile->packets[place];
    uint32_t changed = 0;
    const float reach = packet_reach(tile, place);
    const struct filter_bounds bounds = {v_set1(EDGE_BOUND * reach), v_set1(PLANE_BOUND * reach)};
    const float *from = tile->limits_below ? packet->t_min : NULL;
    COUNT(&worker->counters, triangle_test_count, mlrt_count_bits(triangles));
    COUNT(&worker->counters, lane_test_count, mlrt_count_bits(triangles) * mlrt_count_bits(packet->active));
    MLRT_ALIGNED(64) float edges[MLRT_BVH_LEAF_LIMIT][MLRT_PACKET_RAYS];
    uint32_t of_vector[PACKET_VECTORS];
    find_edges(leaf, triangles, bounds.edge, packet, edges, of_vector);
    for (int i = 0; i < PACKET_VECTORS; ++i) {
        const int v = VW * i;
        if (!of_vector[i]) continue;
        changed |= test_ray_vector(job, worker, leaf, of_vector[i], edges, &bounds, from ? from + v : NULL, v, packet);
    }
    if (changed) update_cell(tile, place, job->any ? changed : 0);
}

/* Opens a closed cell: makes its rays, if they are not there, and tests them against its cover. Rays that are not in units
 * leave the cells, and go on as a bundle (levels.c). */
static MLRT_NOINLINE void open_packet(const struct mlrt_job *job, struct mlrt_worker *worker,
                                      struct mlrt_ray_tile *tile, uint32_t place)
{
    struct mlrt_cells *cells = &tile->cells;
    struct mlrt_packet *packet = &tile->packets[place];
    const int is_new = !(tile->made >> place & 1);
    if (is_new) {
        mlrt_make_rays(job, tile, place);
        tile->greatest_depth[place] = greatest_direction(packet, cells->main_axis);
    }
    if (MLRT_UNLIKELY(job->tree->bvh.unit != 1)) {
        cells->closed &= ~(1u << place);
        mlrt_leave_out_cell(cells, place);
        return;
    }
    if (MLRT_UNLIKELY(tile->seen != NULL) && packet->active)
        add_packet(tile, place); /* closer than what was known without rays */
    cells->closed &= ~(1u << place);
    if (cells->cover[place] != MLRT_NONE) {
        struct lone_triangle lone;
        set_up_lone_triangle(job->tree, cells, cells->cover[place], &lone);
        test_packet(job, worker, tile, &lone.leaf, 1, place);
    } else {
        cells->farthest[place] = farthest_depth(packet, cells->main_axis);
    }
}

/*
 * A triangle in the plane of a cell's cover is hit where that is, if at all, and the first of the two in the input
 * wins: the later one changes nothing, and the earlier one may cover the cell instead. One that is behind the cover
 * wherever it is hit changes nothing either, and one that is before it may cover the cell; `near` is its least depth
 * there. 0 if it is not as simple.
 */
static int settle_cover(const struct mlrt_tree *tree, struct mlrt_worker *worker, struct mlrt_cells *cells,
                        uint32_t place, uint32_t number, int is_inside, float near)
{
    const uint32_t cover = cells->cover[place];
    float eye[3];
    if (cover == MLRT_NONE) return 0;
    find_eye(tree, cells, eye);
    const int order = mlrt_known_order(tree, eye, number, cover, worker);
    if (order > 0) return 1;
    if (order == 0) {
        if (number < cover && !is_inside) return 0;
        if (!mlrt_have_one_plane(tree, number, cover, worker)) return 0;
        if (number < cover) cells->cover[place] = number;
        return 1;
    }
    if (!is_inside) return 0;
    cells->cover[place] = number;
    cells->cover_near[place] = near;
    return 1;
}

/* Offers the triangles of a leaf to closed cells. Opens those that are left in doubt. */
static void test_closed_cells(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_cells *cells,
                              const struct mlrt_leaf_setup *leaf, uint32_t seen, uint32_t met)
{
    for (; seen; seen &= seen - 1) {
        const uint32_t among = met & cells->closed;
        if (!among) return;
        COUNT(&worker->counters, triangle_test_count, 1);
        const uint32_t triangle = mlrt_lowest_bit(seen);
        MLRT_ALIGNED(64) float near[MLRT_CELL_COUNT];
        uint32_t inside, opened = offer_to_closed(cells, leaf, triangle, among, job->any, &inside, near);
        for (; opened; opened &= opened - 1) {
            const uint32_t place = mlrt_lowest_bit(opened);
            const int is_inside = inside >> place & 1;
            if (settle_cover(job->tree, worker, cells, place, leaf->numbers[triangle], is_inside, near[place])) {
                continue;
            }
            if (cells->tile) {
                open_packet(job, worker, cells->tile, place);
            } else {
                cells->closed &= ~(1u << place);
                mlrt_leave_out_cell(cells, place);
            }
        }
    }
}

/* Has a packet by now been tested so often that its rays had better gone alone? */
MLRT_INLINE int is_tedious(struct mlrt_ray_tile *tile, uint32_t place, uint32_t triangles)
{
    tile->tests[place] += mlrt_count_bits(triangles);
    return tile->tests[place] > MLRT_MOST_TESTS;
}

static MLRT_NOINLINE void visit_bvh_leaf(const struct mlrt_job *job, struct mlrt_worker *worker,
                                         struct mlrt_cells *cells, uint32_t child, uint32_t met)
{
    uint32_t seen;
    const struct mlrt_leaf_setup *leaf = set_up_leaf(job->tree, cells, child, worker, &worker->caches[job->any], &seen);
    if (!seen) return;
    if (met & cells->closed) test_closed_cells(job, worker, cells, leaf, seen, met);
    if (cells->tile && MLRT_LIKELY(job->tree->bvh.unit == 1)) {
        for (uint32_t open = met & ~cells->closed; open; open &= open - 1) {
            const uint32_t place = mlrt_lowest_bit(open), left = seen_by_cell(cells, place, seen, leaf);
            if (!left) continue;
            if (MLRT_UNLIKELY(is_tedious(cells->tile, place, left))) {
                mlrt_trace_alone(job, worker, cells->tile, place);
            } else {
                test_packet(job, worker, cells->tile, leaf, left, place);
            }
        }
    }
    set_whole_farthest(cells);
}

/* Takes cells down the hierarchy. */
static MLRT_NOINLINE void traverse_bvh(const struct mlrt_job *job, struct mlrt_worker *worker, struct mlrt_cells *cells)
{
    const struct mlrt_bvh *bvh = &job->tree->bvh;
    struct pending_box stack[TILE_STACK_SIZE];
    MLRT_ALIGNED(64) float near[MLRT_BVH_WIDTH];
    uint32_t node = 0, count = 0;
    if (bvh->node_count == 0) return;
    struct mlrt_leaf_cache *cache = &worker->caches[job->any];
    if (have_other_leaves(cells, cache)) forget_leaves(cells, cache);
    for (;;) {
        COUNT(&worker->counters, cell_count, 1);
        count = push_boxes(bvh, node, children_met(cells, &bvh->nodes[node], near), near, stack, count);
        for (;;) {
            if (count == 0) return;
            const struct pending_box *top = &stack[--count];
            if (top->near > cells->whole_farthest) continue;
            const struct mlrt_bvh_node *parent = &bvh->nodes[top->slot / MLRT_BVH_WIDTH];
            const uint32_t place = top->slot % MLRT_BVH_WIDTH, child = parent->child[place];
            const uint32_t met = cells_met(cells, parent, place);
            if (!met) continue;
            if (mlrt_count_bits(met) <= cells->few && mlrt_trace_few_rays(job, worker, cells, top->slot, met)) {
                set_whole_farthest(cells);
                continue;
            }
            if (!mlrt_bvh_quad_count(child)) {
                node = mlrt_bvh_offset(child);
                break;
            }
            COUNT(&worker->counters, cell_count, 1);
            visit_bvh_leaf(job, worker, cells, child, met);
        }
    }
}
