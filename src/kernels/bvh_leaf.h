/* SPDX-License-Identifier: MIT */
/*
 * The triangles of a leaf as rays from one apex see them, sixteen at a time: where they are seen, and the
 * terms of their edge functions (triangle_filter.h). An array has a place for each triangle.
 *
 * From one apex, t = N / D > 0 asks for D and N of equal sign, and N is the same for all rays: so the triangle's edge
 * functions and D are given the sign of N, once, and a ray then hits if none of them is negative. Where float does not
 * know the sign of N the judge says it; if it is 0 no ray from here hits the triangle.
 */

/* Bounds over slopes, in units of the greater of 1 and twice the steepest slope. */
#define SLOPE_EDGE_BOUND  (1.125f * EDGE_BOUND)
#define SLOPE_PLANE_BOUND (1.125f * PLANE_BOUND)

/* Corners relative to the apex. */
struct leaf_corners {
    vf from[3][3]; /* as stored */
    vf to[3][3];
};

MLRT_INLINE void load_leaf_corners(const struct mlrt_cells *cells, const struct mlrt_leaf_setup *leaf, uint32_t v,
                                   struct leaf_corners *corners)
{
    for (uint32_t i = 0; i < 3; ++i) {
        for (uint32_t k = 0; k < 3; ++k) {
            corners->from[i][k] = v_load_any(leaf->corners + (3 * i + k) * leaf->row + v);
            corners->to[i][k] = v_sub(corners->from[i][k], v_set1(cells->apex[k]));
        }
    }
}

/* Sets where one vector of triangles is seen. */
MLRT_INLINE void set_leaf_outline(const struct mlrt_cells *cells, const struct leaf_corners *corners, uint32_t v,
                                  struct mlrt_leaf_setup *leaf)
{
    const int a = cells->main_axis;
    const vf infinity = v_set1(INFINITY);
    vf depth[3], scale[3];
    for (int i = 0; i < 3; ++i) {
        depth[i] = v_flip(corners->to[i][a], v_set1(cells->sign));
        scale[i] = v_div(v_set1(1), depth[i]);
    }
    const vf least = v_min(v_min(depth[0], depth[1]), depth[2]);
    const vf greatest = v_max(v_max(depth[0], depth[1]), depth[2]);
    const vm in_front = v_gt(least, v_set1(SMALLEST_SIZE)); /* or 1 / depth may be infinite */
    v_store(leaf->least_depth + v, v_select(v_ge(greatest, v_set1(0)), least, infinity));
    for (int side = 0; side < 2; ++side) {
        const int j = mlrt_slope_axis(a, side);
        vf slope[3];
        for (int i = 0; i < 3; ++i) slope[i] = v_mul(corners->to[i][j], scale[i]);
        const vf lo = v_min(v_min(slope[0], slope[1]), slope[2]), hi = v_max(v_max(slope[0], slope[1]), slope[2]);
        const vf lower = v_sub(lo, v_mul(v_abs(lo), v_set1(SLOPE_SLACK)));
        const vf upper = v_add(hi, v_mul(v_abs(hi), v_set1(SLOPE_SLACK)));
        v_store(leaf->slope_lo[side] + v, v_select(in_front, lower, v_sub(v_set1(0), infinity)));
        v_store(leaf->slope_hi[side] + v, v_select(in_front, upper, infinity));
    }
}

/* Sets the terms of one vector of triangles, and returns those whose plane the apex may lie in. */
MLRT_INLINE uint32_t set_leaf_terms(const struct mlrt_cells *cells, const struct leaf_corners *corners, uint32_t v,
                                    struct mlrt_leaf_setup *leaf)
{
    const int a = cells->main_axis;
    vf edge[3][3], cross[4][3];
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) edge[i][k] = v_sub(corners->from[(i + 1) % 3][k], corners->from[i][k]);
    }
    for (int i = 0; i < 3; ++i) {
        vf sum[3];
        for (int k = 0; k < 3; ++k) sum[k] = v_add(corners->to[i][k], corners->to[(i + 1) % 3][k]);
        scaled_cross_product(sum, edge[i], (uint32_t)a, cross[i]);
    }
    scaled_cross_product(edge[2], edge[0], (uint32_t)a, cross[3]);
    const vf distance = dot_product(corners->to[0], cross[3]), size = v_abs(distance);
    const vf other = v_max(v_abs(corners->to[0][mlrt_slope_axis(a, 0)]), v_abs(corners->to[0][mlrt_slope_axis(a, 1)]));
    const vf farthest = v_max(v_abs(corners->to[0][a]), v_mul(other, v_set1(2)));
    const vf bound = v_add(v_mul(farthest, v_set1(DISTANCE_BOUND)), v_set1(DISTANCE_FLOOR));
    for (int i = 0; i < 4; ++i) {
        for (int k = 0; k < 3; ++k) v_store(leaf->cross[i][k] + v, v_flip(cross[i][k], distance));
    }
    leaf->negative |= m_bits(v_lt(v_flip(v_set1(1), distance), v_set1(0))) << v;
    v_store(leaf->least_n + v, v_sub(size, bound));
    v_store(leaf->greatest_n + v, v_add(size, bound));
    return m_bits(v_le(size, bound));
}

/* The apex as it was given: it is exact in units. */
MLRT_INLINE void find_eye(const struct mlrt_tree *tree, const struct mlrt_cells *cells, float eye[3])
{
    for (int k = 0; k < 3; ++k) eye[k] = cells->apex[k] / tree->bvh.unit;
}

/*
 * Decides the sign of N for a triangle of which float does not know it. Returns 0 if it is 0: no ray from the apex hits
 * the triangle.
 */
static int settle_sign(const struct mlrt_tree *tree, const struct mlrt_cells *cells, uint32_t place,
                       struct mlrt_leaf_setup *leaf)
{
    const struct mlrt_triangle *triangle = &tree->triangles[leaf->numbers[place]];
    float eye[3];
    find_eye(tree, cells, eye);
    const int side = mlrt_side_of_plane(triangle, eye); /* that of -N */
    if (side == 0) return 0;
    if ((leaf->negative >> place & 1) != (side > 0)) {
        for (int i = 0; i < 4; ++i) {
            for (int k = 0; k < 3; ++k) leaf->cross[i][k][place] = -leaf->cross[i][k][place];
        }
    }
    return 1;
}

/* An odd triangle (../bvh_unit.h) relative to the apex, in double: there nothing overflows or underflows. */
struct odd_triangle {
    double to[3][3];
    double edge[3][3];
};

static void see_odd_triangle(const struct mlrt_tree *tree, const struct mlrt_cells *cells, uint32_t number,
                             struct odd_triangle *odd)
{
    const struct mlrt_triangle *triangle = &tree->triangles[number];
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            odd->to[i][k] = triangle->v[i][k] * (double)tree->bvh.unit - cells->apex[k];
            odd->edge[i][k] = ((double)triangle->v[(i + 1) % 3][k] - triangle->v[i][k]) * tree->bvh.unit;
        }
    }
}

/* As set_leaf_outline. */
static MLRT_NOINLINE void set_odd_outline(const struct mlrt_tree *tree, const struct mlrt_cells *cells, uint32_t place,
                                          struct mlrt_leaf_setup *leaf)
{
    const int a = cells->main_axis;
    struct odd_triangle odd;
    see_odd_triangle(tree, cells, leaf->numbers[place], &odd);
    double least = INFINITY, greatest = -INFINITY;
    for (int i = 0; i < 3; ++i) {
        least = fmin(odd.to[i][a] * cells->sign, least);
        greatest = fmax(odd.to[i][a] * cells->sign, greatest);
    }
    /* Not -inf: that is where cells that are done look. */
    leaf->least_depth[place] = greatest >= 0 ? mlrt_float_down(fmin(fmax(least, -FLT_MAX), MLRT_BVH_FAR)) : INFINITY;
    for (int side = 0; side < 2; ++side) {
        double lo = INFINITY, hi = -INFINITY;
        for (int i = 0; i < 3; ++i) {
            const double slope = odd.to[i][mlrt_slope_axis(a, side)] / (odd.to[i][a] * cells->sign);
            lo = fmin(slope, lo);
            hi = fmax(slope, hi);
        }
        const int in_front = least > 0x1p-300;
        leaf->slope_lo[side][place] = in_front ? mlrt_low_bound(lo - fabs(lo) * SLOPE_SLACK) : -INFINITY;
        leaf->slope_hi[side][place] = in_front ? -mlrt_low_bound(-(hi + fabs(hi) * SLOPE_SLACK)) : INFINITY;
    }
}

/* As scaled_cross_product; *error receives what its product with `point` may be off by. */
static void scaled_cross_of_doubles(const double sum[3], const double edge[3], int main_axis, const double point[3],
                                    double cross[3], double *error)
{
    double reach[3], size = 0;
    *error = 0;
    for (int k = 0; k < 3; ++k) reach[k] = fmax(fabs(sum[k]), fabs(edge[k]));
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        cross[k] = sum[i] * edge[j] - sum[j] * edge[i];
        size += (reach[i] * fabs(edge[j]) + reach[j] * fabs(edge[i])) * (k == main_axis ? 1 : 0.5);
        *error += fabs(point[k]) * (fabs(sum[i] * edge[j]) + fabs(sum[j] * edge[i])) * 0x1p-49;
    }
    for (int k = 0; k < 3; ++k) cross[k] /= size;
    *error /= size;
}

/* As set_leaf_terms, but for the bound of N, which is that of doubles. Corners far away are not what N is off by. */
static MLRT_NOINLINE uint32_t set_odd_terms(const struct mlrt_tree *tree, const struct mlrt_cells *cells, uint32_t place,
                                            struct mlrt_leaf_setup *leaf)
{
    const int a = cells->main_axis;
    struct odd_triangle odd;
    double cross[4][3], error, distance = 0;
    see_odd_triangle(tree, cells, leaf->numbers[place], &odd);
    for (int i = 0; i < 3; ++i) {
        double sum[3];
        for (int k = 0; k < 3; ++k) sum[k] = odd.to[i][k] + odd.to[(i + 1) % 3][k];
        scaled_cross_of_doubles(sum, odd.edge[i], a, sum, cross[i], &error);
    }
    scaled_cross_of_doubles(odd.edge[2], odd.edge[0], a, odd.to[0], cross[3], &error);
    for (int k = 0; k < 3; ++k) distance += odd.to[0][k] * cross[3][k];
    for (int i = 0; i < 4; ++i) {
        for (int k = 0; k < 3; ++k) leaf->cross[i][k][place] = (float)(distance < 0 ? -cross[i][k] : cross[i][k]);
    }
    const double bound = fabs(distance) * DISTANCE_BOUND + 2 * error + DISTANCE_FLOOR;
    leaf->negative = (leaf->negative & ~(1u << place)) | (uint32_t)(distance < 0) << place;
    leaf->least_n[place] = mlrt_float_down(fabs(distance) - bound);
    leaf->greatest_n[place] = mlrt_float_up(fabs(distance) + bound);
    return (uint32_t)(fabs(distance) <= bound) << place;
}

/* Lanes of odd triangles, or empty ones. */
MLRT_INLINE uint32_t lanes_without_corners(const struct leaf_corners *corners)
{
    return ~m_bits(v_eq(corners->from[0][0], corners->from[0][0])) & ALL_LANES;
}

/* Sets the terms of triangles whose vectors have some of `wanted`. */
static MLRT_NOINLINE void set_up_triangles(const struct mlrt_tree *tree, const struct mlrt_cells *cells,
                                           uint32_t wanted, struct mlrt_leaf_setup *leaf)
{
    uint32_t doubtful = 0, odd = 0;
    for (uint32_t v = 0; v < MLRT_BVH_LEAF_LIMIT; v += VW) {
        if (!((wanted & ~leaf->ready) >> v & ALL_LANES)) continue;
        struct leaf_corners corners;
        load_leaf_corners(cells, leaf, v, &corners);
        doubtful |= set_leaf_terms(cells, &corners, v, leaf) << v;
        odd |= lanes_without_corners(&corners) << v;
        leaf->ready |= (ALL_LANES & 0xFFFF) << v;
    }
    for (odd &= leaf->there; MLRT_UNLIKELY(odd != 0); odd &= odd - 1) {
        doubtful |= set_odd_terms(tree, cells, mlrt_lowest_bit(odd), leaf);
    }
    for (uint32_t rest = doubtful & leaf->there; rest; rest &= rest - 1) {
        const uint32_t place = mlrt_lowest_bit(rest);
        if (!settle_sign(tree, cells, place, leaf)) leaf->there &= ~(1u << place);
    }
}

/* Begins the set-up of a leaf: which places there are for rays with this mask, and where they are seen. */
static MLRT_NOINLINE void begin_leaf(const struct mlrt_tree *tree, const struct mlrt_cells *cells, uint32_t child,
                                     uint32_t mask, struct mlrt_leaf_setup *leaf)
{
    const uint32_t row = 4 * mlrt_bvh_quad_count(child);
    leaf->axis = mlrt_axis_code(cells);
    leaf->corners = tree->bvh.corners + 36 * (size_t)mlrt_bvh_offset(child);
    leaf->numbers = tree->bvh.numbers + 4 * (size_t)mlrt_bvh_offset(child);
    leaf->row = row;
    leaf->ready = leaf->negative = leaf->there = 0;
    uint32_t odd = 0;
    for (uint32_t v = 0; v < row; v += VW) {
        struct leaf_corners corners;
        load_leaf_corners(cells, leaf, v, &corners);
        set_leaf_outline(cells, &corners, v, leaf);
        odd |= lanes_without_corners(&corners) << v;
        leaf->there |= (~m_bits(i_eq(i_load_any(leaf->numbers + v), i_set1(MLRT_NONE))) & ALL_LANES) << v;
    }
    leaf->there &= 0xFFFFu >> (MLRT_BVH_LEAF_LIMIT - row);
    for (odd &= leaf->there; MLRT_UNLIKELY(odd != 0); odd &= odd - 1) {
        set_odd_outline(tree, cells, mlrt_lowest_bit(odd), leaf);
    }
    if (MLRT_UNLIKELY(mask != MLRT_MASK_ALL)) leaf->there = mlrt_visible_places(tree, leaf->numbers, leaf->there, mask);
}

/* Triangles of a leaf that cells may hit, by their outlines. */
MLRT_INLINE uint32_t seen_by_cells(const struct mlrt_cells *cells, const struct mlrt_leaf_setup *leaf)
{
    uint32_t seen = 0;
    for (int v = 0; v < MLRT_BVH_LEAF_LIMIT; v += VW) {
        if (!(leaf->there >> v & ALL_LANES)) continue;
        vm may = v_le(v_load(leaf->least_depth + v), v_set1(cells->whole_farthest));
        for (int side = 0; side < 2; ++side) {
            may = m_and(may, m_and(v_le(v_load(leaf->slope_lo[side] + v), v_set1(cells->slope_hi[side])),
                                   v_ge(v_load(leaf->slope_hi[side] + v), v_set1(cells->slope_lo[side]))));
        }
        seen |= m_bits(may) << v;
    }
    return seen & leaf->there;
}

/*
 * The set-up of a leaf, and in *seen which of its triangles cells may hit: these have their terms. A worker keeps the
 * last set-ups for its next tiles.
 */
static struct mlrt_leaf_setup *set_up_leaf(const struct mlrt_tree *tree, const struct mlrt_cells *cells, uint32_t child,
                                           const struct mlrt_worker *worker, struct mlrt_leaf_cache *cache,
                                           uint32_t *seen)
{
    const uint32_t place = mlrt_place_of_leaf(child, cache);
    struct mlrt_leaf_setup *leaf = &cache->leaves[place];
    if (!mlrt_is_set_up(cells, child, cache)) {
        begin_leaf(tree, cells, child, worker->mask, leaf);
        cache->children[place] = child;
    }
    *seen = seen_by_cells(cells, leaf);
    const uint32_t wanted = *seen & ~leaf->ready;
    if (wanted) {
        set_up_triangles(tree, cells, wanted, leaf);
        *seen &= leaf->there;
    }
    return leaf;
}

/* Set-ups are for one apex. */
MLRT_INLINE int have_other_leaves(const struct mlrt_cells *cells, const struct mlrt_leaf_cache *cache)
{
    return memcmp(cells->apex, cache->apex, sizeof cells->apex) != 0;
}

static void forget_leaves(const struct mlrt_cells *cells, struct mlrt_leaf_cache *cache)
{
    memset(cache->children, 0, sizeof cache->children);
    memcpy(cache->apex, cells->apex, sizeof cache->apex);
}

/* Of the triangles `seen`, those that the rays of one cell may hit. */
MLRT_INLINE uint32_t seen_by_cell(const struct mlrt_cells *cells, uint32_t place, uint32_t seen,
                                  const struct mlrt_leaf_setup *leaf)
{
    const float *slope_lo[2] = {&cells->slopes[0].lo[place], &cells->slopes[1].lo[place]};
    const float *slope_hi[2] = {&cells->slopes[0].hi[place], &cells->slopes[1].hi[place]};
    const int a = cells->main_axis, axes[2] = {mlrt_slope_axis(a, 0), mlrt_slope_axis(a, 1)};
    const vf farthest = v_set1(cells->farthest[place]);
    uint32_t left = 0;
    for (int v = 0; v < MLRT_BVH_LEAF_LIMIT; v += VW) {
        if (!(seen >> v & ALL_LANES)) continue;
        vm may = v_le(v_load(leaf->least_depth + v), farthest);
        MLRT_UNROLL
        for (int side = 0; side < 2; ++side) {
            may = m_and(may, m_and(v_le(v_load(leaf->slope_lo[side] + v), v_set1(*slope_hi[side])),
                                   v_ge(v_load(leaf->slope_hi[side] + v), v_set1(*slope_lo[side]))));
        }
        if (!m_bits(may)) continue;
        MLRT_UNROLL
        for (int i = 0; i < 3; ++i) {
            vf greatest = v_mul(v_load(leaf->cross[i][a] + v), v_set1(cells->sign));
            MLRT_UNROLL
            for (int side = 0; side < 2; ++side) {
                const vf c = v_load(leaf->cross[i][axes[side]] + v);
                greatest = v_add(greatest, v_max(v_mul(c, v_set1(*slope_lo[side])), v_mul(c, v_set1(*slope_hi[side]))));
            }
            may = m_and(may, v_ge(greatest, v_set1(-SLOPE_EDGE_BOUND * cells->slope_bound)));
        }
        left |= m_bits(may) << v;
    }
    return left & seen;
}

/* Least and greatest values of c . (+-1, s_j, s_l) over the slopes of a vector of cells. */
MLRT_INLINE void range_over_cells(const struct mlrt_cells *cells, const struct mlrt_leaf_setup *leaf, int edge,
                                  uint32_t place, int v, vf *least, vf *greatest)
{
    const int a = cells->main_axis;
    *least = *greatest = v_set1(leaf->cross[edge][a][place] * cells->sign);
    MLRT_UNROLL
    for (int side = 0; side < 2; ++side) {
        const vf c = v_set1(leaf->cross[edge][mlrt_slope_axis(a, side)][place]);
        const vf p = v_mul(c, v_load(cells->slopes[side].lo + v)), q = v_mul(c, v_load(cells->slopes[side].hi + v));
        *least = v_add(*least, v_min(p, q));
        *greatest = v_add(*greatest, v_max(p, q));
    }
}

/*
 * Offers a triangle to closed cells: those that it covers in front of what covered them are closed by it from now on,
 * those that it misses, or lies behind the cover of, stay as they are. Returns the others: they may have to be opened.
 * All rays of `inside_cells` hit the triangle; `near_in_cells` receives its least depth in cells that are returned.
 *
 * Edge functions over slopes have the bound of triangle_filter.h with R = 1, or twice the steepest slope, and so has D;
 * all rays of a cell hit what is surely inside at its corners. There their depth is N / D.
 */
static uint32_t offer_to_closed(struct mlrt_cells *cells, const struct mlrt_leaf_setup *leaf, uint32_t place,
                                uint32_t among, int any, uint32_t *inside_cells, float near_in_cells[MLRT_CELL_COUNT])
{
    const uint32_t number = leaf->numbers[place];
    const float bound = SLOPE_EDGE_BOUND * cells->slope_bound, width = SLOPE_PLANE_BOUND * cells->slope_bound;
    uint32_t opened = 0;
    *inside_cells = 0;
    for (int v = 0; v < MLRT_CELL_COUNT; v += VW) {
        const vf farthest = v_load(cells->farthest + v);
        const vm known =
            m_or(i_eq(i_load(cells->cover + v), i_set1(number)), i_eq(i_load(cells->skip + v), i_set1(number)));
        vm may = m_andnot(m_from_bits(among >> v), known);
        may = m_and(may, v_le(v_set1(leaf->least_depth[place]), farthest));
        MLRT_UNROLL
        for (int side = 0; side < 2; ++side) {
            may = m_and(may, v_le(v_set1(leaf->slope_lo[side][place]), v_load(cells->slopes[side].hi + v)));
            may = m_and(may, v_ge(v_set1(leaf->slope_hi[side][place]), v_load(cells->slopes[side].lo + v)));
        }
        if (!m_bits(may)) continue;
        vf inside = v_set1(INFINITY), outside = v_set1(INFINITY), least, greatest;
        MLRT_UNROLL
        for (int edge = 0; edge < 3; ++edge) {
            range_over_cells(cells, leaf, edge, place, v, &least, &greatest);
            inside = v_min(least, inside);
            outside = v_min(greatest, outside);
        }
        may = m_and(may, v_ge(outside, v_set1(-bound)));
        if (!m_bits(may)) continue;
        range_over_cells(cells, leaf, 3, place, v, &least, &greatest);
        const vf least_d = v_sub(least, v_set1(width)), greatest_d = v_add(greatest, v_set1(width));
        const vf near = v_mul(v_div(v_set1(leaf->least_n[place]), greatest_d), v_set1(1 - SLOPE_SLACK));
        may = m_and(may, m_and(v_gt(greatest_d, v_set1(0)), v_le(near, farthest)));
        const vf far = v_mul(v_div(v_set1(leaf->greatest_n[place]), least_d), v_set1(1 + SLOPE_SLACK));
        const vf nearest = v_load(cells->cover_near + v);
        const vm certain = m_and(may, m_and(v_gt(inside, v_set1(bound)), v_gt(least_d, v_set1(width))));
        const vm covered = m_and(certain, m_and(v_lt(far, nearest), v_lt(far, v_load(cells->shortest + v))));
        if (m_bits(covered)) {
            v_store(cells->farthest + v, v_select(covered, any ? v_set1(-INFINITY) : far, farthest));
            v_store(cells->cover_near + v, v_select(covered, near, nearest));
            i_store(cells->cover + v, i_select(covered, i_set1(number), i_load(cells->cover + v)));
        }
        *inside_cells |= m_bits(certain) << v;
        v_store(near_in_cells + v, near);
        opened |= m_bits(m_andnot(may, covered)) << v;
    }
    return opened;
}

/* A leaf of one triangle of its own: its corners are repeated as often as a vector is wide. */
struct lone_triangle {
    struct mlrt_leaf_setup leaf;
    float corners[9 * 4 + MLRT_BVH_LEAF_LIMIT];
    uint32_t number;
};

static void set_up_lone_triangle(const struct mlrt_tree *tree, const struct mlrt_cells *cells, uint32_t number,
                                 struct lone_triangle *lone)
{
    struct mlrt_triangle triangle;
    const int is_usual = mlrt_triangle_in_units(&tree->triangles[number], tree->bvh.unit, &triangle);
    for (int i = 0; i < 9 * 4 + MLRT_BVH_LEAF_LIMIT; ++i) {
        const int c = i < 36 ? i / 4 : 0;
        lone->corners[i] = is_usual ? triangle.v[c / 3][c % 3] : NAN;
    }
    lone->number = number;
    lone->leaf.numbers = &lone->number;
    lone->leaf.corners = lone->corners;
    lone->leaf.row = 4;
    lone->leaf.there = 1;
    lone->leaf.ready = lone->leaf.negative = 0;
    set_up_triangles(tree, cells, 1, &lone->leaf);
}
