/* SPDX-License-Identifier: MIT */
/*
 * Cuts a set of references by a plane. A reference on both sides becomes two. This helps where large triangles lie
 * among small ones: a large one as a whole makes the boxes of both sides overlap, whichever side it is on.
 *
 * A slab is a bin: the space between two planes. The bounds of the parts in slabs are estimates in float: they only
 * choose the plane. References are then cut by scene/clip.c, whose boxes hold every point of the triangle.
 *
 * Based on: Martin Stich, Heiko Friedrich, Andreas Dietrich, "Spatial Splits in Bounding Volume Hierarchies", 2009.
 */
#include "bvh/build.h"

#include <math.h>
#include <string.h>

#include "bvh/unit.h"
#include "scene/clip.h"

/* ---- slabs --------------------------------------------------------------------------------------------------- */

/* The slab of coordinate x. */
MLRT_INLINE uint32_t slab_of(const struct mlrt_binning *slabs, uint32_t axis, float x)
{
    return (uint32_t)(int32_t)((x - slabs->start[axis]) * slabs->scale[axis]);
}

/* The coordinate at which a slab starts, approximately. */
MLRT_INLINE float slab_start(const struct mlrt_binning *slabs, uint32_t axis, uint32_t slab)
{
    return slabs->start[axis] + (float)slab * slabs->width[axis];
}

/* ---- estimates ------------------------------------------------------------------------------------------------- */

/* The vertices of a triangle in units. Fourth elements do not matter. */
struct vertices {
    MLRT_ALIGNED(16) float of[3][4];
};

/* Reads the last vertex from one float earlier, so as not to read past it. */
MLRT_INLINE void load_vertices(const struct mlrt_triangle *triangle, float unit, struct vertices *vertices)
{
    const f4 scale = f4_set1(unit);
    f4_store(vertices->of[0], f4_mul(f4_load_any(triangle->v[0]), scale));
    f4_store(vertices->of[1], f4_mul(f4_load_any(triangle->v[1]), scale));
    f4_store(vertices->of[2], f4_mul(f4_rest(f4_load_any(triangle->v[1] + 2)), scale));
}

/* A triangle with its vertices in the order of their heights (coordinates along an axis), and its edges' slopes. */
struct sorted_triangle {
    f4 low, middle;
    float low_height, middle_height, high_height;
    f4 whole_slope, lower_slope, upper_slope; /* of the edges low - high, low - middle, middle - high, per height */
};

MLRT_INLINE f4 slope_of(f4 from, f4 to, float height)
{
    return height > 0 ? f4_mul(f4_sub(to, from), f4_set1(1 / height)) : f4_set1(0);
}

/* Compilers make the choices without branches, which would be mispredicted. */
MLRT_INLINE struct sorted_triangle sort_vertices(const struct vertices *vertices, uint32_t axis)
{
    const float height[3] = {vertices->of[0][axis], vertices->of[1][axis], vertices->of[2][axis]};
    uint32_t low = height[1] < height[0], high = height[1] >= height[0];
    low = height[2] < height[low] ? 2 : low;
    high = height[2] >= height[high] ? 2 : high;
    const uint32_t middle = 3 - low - high;
    struct sorted_triangle sorted;
    const f4 top = f4_load(vertices->of[high]);
    sorted.low = f4_load(vertices->of[low]);
    sorted.middle = f4_load(vertices->of[middle]);
    sorted.low_height = height[low];
    sorted.middle_height = height[middle];
    sorted.high_height = height[high];
    sorted.whole_slope = slope_of(sorted.low, top, sorted.high_height - sorted.low_height);
    sorted.lower_slope = slope_of(sorted.low, sorted.middle, sorted.middle_height - sorted.low_height);
    sorted.upper_slope = slope_of(sorted.middle, top, sorted.high_height - sorted.middle_height);
    return sorted;
}

/* The box of the segment in which a plane, at that height, cuts the triangle. */
MLRT_INLINE struct mlrt_quad_box cross_section(const struct sorted_triangle *triangle, float height)
{
    f4 above_low = f4_set1(height - triangle->low_height), above_middle = f4_set1(height - triangle->middle_height);
    f4 a = f4_add(triangle->low, f4_mul(triangle->whole_slope, above_low));
    f4 b = height < triangle->middle_height ? f4_add(triangle->low, f4_mul(triangle->lower_slope, above_low))
                                            : f4_add(triangle->middle, f4_mul(triangle->upper_slope, above_middle));
    return (struct mlrt_quad_box){{.v = f4_min(a, b)}, {.v = f4_max(a, b)}};
}

/*
 * Adds a reference to slabs first .. last along an axis. The part between two planes is bounded by its two segments in
 * the planes, and by the middle vertex if it lies between them.
 */
MLRT_INLINE void fill_axis(const struct vertices *vertices, const struct mlrt_quad_box *reference,
                           const struct mlrt_binning *slabs, uint32_t axis, uint32_t first, uint32_t last,
                           struct mlrt_bvh_bins *bins)
{
    const struct sorted_triangle sorted = sort_vertices(vertices, axis);
    f4 lo = reference->lo.v, hi = reference->hi.v;
    float height = reference->lo.x[axis], end = reference->hi.x[axis];
    if (height < sorted.low_height) height = sorted.low_height;
    if (end > sorted.high_height) end = sorted.high_height;
    struct mlrt_quad_box below = cross_section(&sorted, height);
    for (uint32_t slab = first; slab <= last; slab++) {
        float next_height = slab < last ? slab_start(slabs, axis, slab + 1) : end;
        struct mlrt_quad_box above = cross_section(&sorted, next_height), box = below;
        grow(&box, above.lo.v, above.hi.v);
        if (height <= sorted.middle_height && sorted.middle_height <= next_height)
            grow(&box, sorted.middle, sorted.middle);
        grow(&bins->box[slab][axis], f4_max(box.lo.v, lo), f4_min(box.hi.v, hi));
        below = above;
        height = next_height;
    }
}

/* References that are put into slabs, or cut, between two calls of mlrt_is_cancelled: one to three milliseconds. */
#define CUT_ROUNDS 4096

/* Triangles are prefetched so many references ahead. */
#define AHEAD 12

void mlrt_fill_slabs(const struct mlrt_triangle *triangles, float unit, const struct mlrt_quad_box *references,
                     uint32_t first, uint32_t count, const struct mlrt_quad_box *box, struct mlrt_progress *progress,
                     struct mlrt_bvh_bins *bins)
{
    const struct mlrt_binning slabs = mlrt_cut_bins(box, bins->bin_count);
    f4 start = f4_load(slabs.start), scale = f4_load(slabs.scale);
    for (uint32_t i = first; i < first + count; i++) {
        if (i % CUT_ROUNDS == 0 && mlrt_is_cancelled(progress)) break;
        const struct mlrt_quad_box *reference = &references[i];
        const struct mlrt_triangle *triangle = &triangles[mlrt_reference_triangle(reference)];
        if (i + AHEAD < first + count) mlrt_prefetch(&triangles[mlrt_reference_triangle(&references[i + AHEAD])]);
        MLRT_ALIGNED(16) float low[4], high[4];
        struct vertices vertices;
        f4 lo = reference->lo.v, hi = reference->hi.v;
        f4_store(low, f4_mul(f4_sub(lo, start), scale));
        f4_store(high, f4_mul(f4_sub(hi, start), scale));
        load_vertices(triangle, unit, &vertices);
        for (uint32_t axis = 0; axis < 3; axis++) {
            uint32_t first_slab = (uint32_t)(int32_t)low[axis], last_slab = (uint32_t)(int32_t)high[axis];
            bins->first_count[first_slab][axis]++;
            bins->last_count[last_slab][axis]++;
            if (first_slab == last_slab)
                grow(&bins->box[first_slab][axis], lo, hi);
            else
                fill_axis(&vertices, reference, &slabs, axis, first_slab, last_slab, bins);
        }
    }
}

/* ---- choice ---------------------------------------------------------------------------------------------------- */

static void choose_on_axis(const struct mlrt_bvh_costs *costs, const struct mlrt_bvh_bins *bins, uint32_t count,
                           uint32_t spare, uint32_t axis, struct mlrt_bvh_split *split)
{
    struct mlrt_quad_box upper[MLRT_BVH_BINS], lower = empty_box();
    uint32_t lower_count = 0, upper_count = count;
    upper[bins->bin_count - 1] = bins->box[bins->bin_count - 1][axis];
    for (uint32_t slab = bins->bin_count - 2; slab > 0; slab--) {
        upper[slab] = upper[slab + 1];
        grow(&upper[slab], bins->box[slab][axis].lo.v, bins->box[slab][axis].hi.v);
    }
    for (uint32_t slab = 0; slab < bins->bin_count - 1; slab++) {
        lower_count += (uint32_t)bins->first_count[slab][axis];
        upper_count -= (uint32_t)bins->last_count[slab][axis];
        grow(&lower, bins->box[slab][axis].lo.v, bins->box[slab][axis].hi.v);
        if (lower_count == 0 || lower_count == count || upper_count == 0 || upper_count == count) continue;
        if (lower_count + upper_count - count > spare) continue;
        double cost =
            area_of(&lower) * set_cost(costs, lower_count) + area_of(&upper[slab + 1]) * set_cost(costs, upper_count);
        if (!(cost < split->cost)) continue;
        *split = (struct mlrt_bvh_split){.cost = cost,
                                         .kind = MLRT_SPLIT_BY_PLANE,
                                         .axis = axis,
                                         .bin = slab,
                                         .count = {lower_count, upper_count},
                                         .box = {lower, upper[slab + 1]}};
    }
}

void mlrt_choose_plane(const struct mlrt_bvh_build *build, const struct mlrt_bvh_bins *bins, uint32_t count,
                       uint32_t spare, struct mlrt_bvh_split *split)
{
    split->cost = HUGE_VAL;
    for (uint32_t axis = 0; axis < 3; axis++) choose_on_axis(&build->costs, bins, count, spare, axis, split);
}

/* ---- dealing out ----------------------------------------------------------------------------------------------- */

/* A set whose references are being dealt out to two sides. */
struct dealing {
    struct mlrt_bvh_set side[2]; /* the references dealt so far */
    uint32_t count[2];           /* how many references, in which box, each side is expected to have in the end */
    struct mlrt_quad_box box[2];
};

static void swap_references(struct mlrt_quad_box *a, struct mlrt_quad_box *b)
{
    struct mlrt_quad_box copy = *a;
    *a = *b;
    *b = copy;
}

static double joined_area(const struct mlrt_quad_box *box, const struct mlrt_quad_box *reference)
{
    struct mlrt_quad_box joined = *box;
    grow(&joined, reference->lo.v, reference->hi.v);
    return area_of(&joined);
}

/* The cheapest place of a reference that lies on both sides: 0 or 1 = whole on that side ("unsplitting"), 2 = cut. */
static int choose_side(const struct dealing *dealing, const struct mlrt_quad_box *reference)
{
    double area[2] = {area_of(&dealing->box[0]), area_of(&dealing->box[1])};
    double both = area[0] * dealing->count[0] + area[1] * dealing->count[1];
    double whole[2] = {
        joined_area(&dealing->box[0], reference) * dealing->count[0] + area[1] * (dealing->count[1] - 1.0),
        area[0] * (dealing->count[0] - 1.0) + joined_area(&dealing->box[1], reference) * dealing->count[1]};
    int better = whole[1] < whole[0];
    return whole[better] < both && dealing->count[1 - better] > 1 ? better : 2;
}

/* Leaves a reference whole, as the part of one side. Returns the bit of the side. */
static int keep_whole(struct dealing *dealing, int side, const struct mlrt_quad_box *reference,
                      struct mlrt_quad_box parts[2])
{
    grow(&dealing->box[side], reference->lo.v, reference->hi.v);
    dealing->count[1 - side]--;
    parts[side] = *reference;
    return 1 << side;
}

/*
 * Cuts a reference by a plane. Returns a bit for each part that exists, at least one. For an odd triangle, which has no
 * corners in units, the box is cut instead.
 */
static int cut_reference(const struct mlrt_tree *tree, const struct mlrt_quad_box *reference, uint32_t axis,
                         float position, struct mlrt_quad_box parts[2])
{
    struct mlrt_triangle triangle;
    struct mlrt_box box;
    struct mlrt_halves halves;
    memcpy(box.lo, reference->lo.x, sizeof box.lo);
    memcpy(box.hi, reference->hi.x, sizeof box.hi);
    if (position < box.lo[axis]) position = box.lo[axis];
    if (position > box.hi[axis]) position = box.hi[axis];
    parts[0] = parts[1] = *reference;
    if (!mlrt_triangle_in_units(&tree->triangles[mlrt_reference_triangle(reference)], tree->bvh.unit, &triangle)) {
        parts[0].hi.x[axis] = parts[1].lo.x[axis] = position;
        return 3;
    }
    mlrt_clip_halves(&triangle, &box, axis, position, 0, &halves);
    for (int side = 0; side < 2; side++)
        for (int k = 0; k < 3 && halves.touched[side]; k++) {
            parts[side].lo.x[k] = halves.box[side].lo[k];
            parts[side].hi.x[k] = halves.box[side].hi[k];
        }
    int touched = halves.touched[0] | halves.touched[1] << 1;
    return touched != 0 ? touched : 1;
}

/*
 * The first loop orders the references: those of the lower side, those on both sides, those of the upper side. The
 * second loop deals out those on both sides: parts of the lower side go right behind the lower ones, parts of the upper
 * side behind all references.
 */
void mlrt_apply_spatial_split(const struct mlrt_bvh_build *build, const struct mlrt_bvh_set *set,
                              const struct mlrt_bvh_split *split, struct mlrt_bvh_set sides[2])
{
    struct mlrt_quad_box *references = build->references.boxes;
    const struct mlrt_binning slabs = mlrt_cut_bins(&set->box, MLRT_BVH_BINS);
    struct dealing dealing = {
        {empty_set(set->first), empty_set(0)}, {split->count[0], split->count[1]}, {split->box[0], split->box[1]}};
    uint32_t axis = split->axis, lower = set->first, next = lower, upper = lower + set->count, end = upper;
    while (next < upper) {
        if (mlrt_is_cancelled_in_round(build->progress, upper - next)) break;
        if (slab_of(&slabs, axis, references[next].hi.x[axis]) <= split->bin) {
            add_reference(&references[next], &dealing.side[0]);
            if (next != lower) swap_references(&references[next], &references[lower]);
            lower++;
            next++;
        } else if (slab_of(&slabs, axis, references[next].lo.x[axis]) > split->bin) {
            add_reference(&references[next], &dealing.side[1]);
            swap_references(&references[next], &references[--upper]);
        } else {
            next++;
        }
    }
    float position = slab_start(&slabs, axis, split->bin + 1);
    for (next = lower; next < upper; next++) {
        if (next % CUT_ROUNDS == 0 && mlrt_is_cancelled(build->progress)) break;
        struct mlrt_quad_box reference = references[next], parts[2];
        const int side = choose_side(&dealing, &reference);
        const int touched = side < 2 ? keep_whole(&dealing, side, &reference, parts)
                                     : cut_reference(build->tree, &reference, axis, position, parts);
        for (int i = 0; i < 2; i++)
            if (touched >> i & 1) add_reference(&parts[i], &dealing.side[i]);
        if (touched == 3) mlrt_mark_copy(&parts[1]);
        if (touched & 1) references[lower++] = parts[0];
        if (touched & 2) references[end++] = parts[1];
    }
    sides[0] = dealing.side[0];
    sides[1] = dealing.side[1];
    sides[1].first = upper;
}
