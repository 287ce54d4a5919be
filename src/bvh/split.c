/* SPDX-License-Identifier: MIT */
/*
 * Where to cut a set of references in two: see split.h.
 */
#include "bvh/split.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/progress.h"
#include "bvh/box.h"

/* ---- sets ---------------------------------------------------------------------------------------------------- */

double mlrt_quad_box_area(const struct mlrt_quad_box *box)
{
    return area_of(box);
}

struct mlrt_bvh_set mlrt_measure_set(const struct mlrt_quad_box *references, uint32_t first, uint32_t count,
                                     struct mlrt_progress *progress)
{
    struct growing_set set = empty_set();
    for (uint32_t i = 0; i < count && !mlrt_is_cancelled_in_round(progress, i + 1); i++)
        add_reference(&set, f4_load(references[first + i].lo), f4_load(references[first + i].hi));
    return finish_set(&set, first, count);
}

/* ---- costs --------------------------------------------------------------------------------------------------- */

float mlrt_bvh_leaf_cost(const struct mlrt_bvh_costs *costs, uint32_t count)
{
    return costs->leaf + costs->quad * (float)((count + 3) / 4) + costs->triangle * (float)count;
}

/* ---- few references: all places between two of them ----------------------------------------------------------- */

static void sort_by_centre(const float centre[MLRT_SWEEP_LIMIT][4], uint32_t axis, uint32_t count, uint8_t *order)
{
    for (uint32_t i = 0; i < count; i++) {
        float key = centre[i][axis];
        uint32_t j = i;
        for (; j > 0 && centre[order[j - 1]][axis] > key; j--) order[j] = order[j - 1];
        order[j] = (uint8_t)i;
    }
}

static void sweep_axis(const struct mlrt_bvh_costs *costs, const struct mlrt_quad_box *references, uint32_t count,
                       const uint8_t *order, uint32_t axis, struct mlrt_bvh_split *split)
{
    double upper_area[MLRT_SWEEP_LIMIT];
    struct growing_box box = empty_box();
    struct mlrt_quad_box kept;
    for (uint32_t i = count - 1; i > 0; i--) {
        grow(&box, f4_load(references[order[i]].lo), f4_load(references[order[i]].hi));
        store_box(&box, &kept);
        upper_area[i] = area_of(&kept);
    }
    box = empty_box();
    for (uint32_t i = 1; i < count; i++) {
        grow(&box, f4_load(references[order[i - 1]].lo), f4_load(references[order[i - 1]].hi));
        store_box(&box, &kept);
        double cost = area_of(&kept) * set_cost(costs, i) + upper_area[i] * set_cost(costs, count - i);
        if (cost >= split->cost) continue;
        split->cost = cost;
        split->axis = axis;
        split->lower_count = i;
    }
}

void mlrt_sweep_set(const struct mlrt_bvh_costs *costs, const struct mlrt_quad_box *references,
                    const struct mlrt_bvh_set *set, struct mlrt_bvh_split *split)
{
    MLRT_ALIGNED(16) float centre[MLRT_SWEEP_LIMIT][4];
    uint8_t order[3][MLRT_SWEEP_LIMIT];
    references += set->first;
    for (uint32_t i = 0; i < set->count; i++)
        f4_store(centre[i], centre_of(f4_load(references[i].lo), f4_load(references[i].hi)));
    split->cost = HUGE_VAL;
    split->axis = 0;
    split->sorted = 1;
    for (uint32_t axis = 0; axis < 3; axis++) {
        sort_by_centre((const float(*)[4])centre, axis, set->count, order[axis]);
        sweep_axis(costs, references, set->count, order[axis], axis, split);
    }
    memcpy(split->order, order[split->axis], sizeof split->order);
}

static void apply_order(struct mlrt_quad_box *references, const struct mlrt_bvh_set *set,
                        const struct mlrt_bvh_split *split)
{
    struct mlrt_quad_box sorted[MLRT_SWEEP_LIMIT];
    for (uint32_t i = 0; i < set->count; i++) sorted[i] = references[set->first + split->order[i]];
    memcpy(references + set->first, sorted, set->count * sizeof *sorted);
}

/* ---- many references: between bins ----------------------------------------------------------------------------- */

/* The bin of a centre along each axis is the whole part of (centre - start) * scale. */
struct binning {
    MLRT_ALIGNED(16) float start[4];
    MLRT_ALIGNED(16) float scale[4];
};

/* If all centres along an axis are equal, or so close that the scale would overflow, it is 0: all are in bin 0. */
static struct binning cut_bins(const struct mlrt_quad_box *centres)
{
    struct binning binning;
    for (int k = 0; k < 4; k++) {
        float extent = k < 3 ? centres->hi[k] - centres->lo[k] : 0;
        float scale = extent > 0 ? MLRT_BVH_BINS * (1 - 0x1p-10f) / extent : 0;
        binning.start[k] = k < 3 ? centres->lo[k] : 0;
        binning.scale[k] = scale <= FLT_MAX ? scale : 0;
    }
    return binning;
}

MLRT_INLINE f4 bin_of(f4 lo, f4 hi, f4 start, f4 scale)
{
    return f4_mul(f4_sub(centre_of(lo, hi), start), scale);
}

void mlrt_clear_bins(struct mlrt_bvh_bins *bins)
{
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < MLRT_BVH_BINS; i++) clear_box(&bins->box[axis][i]);
    memset(bins->count, 0, sizeof bins->count);
}

void mlrt_fill_bins(const struct mlrt_quad_box *references, uint32_t first, uint32_t count,
                    const struct mlrt_quad_box *centres, struct mlrt_bvh_bins *bins)
{
    struct binning binning = cut_bins(centres);
    f4 start = f4_load(binning.start), scale = f4_load(binning.scale);
    for (uint32_t i = first; i < first + count; i++) {
        MLRT_ALIGNED(16) float bin[4];
        f4 lo = f4_load(references[i].lo), hi = f4_load(references[i].hi);
        f4_store(bin, bin_of(lo, hi, start, scale));
        for (int axis = 0; axis < 3; axis++) {
            int number = (int)bin[axis];
            extend_box(&bins->box[axis][number], lo, hi);
            bins->count[axis][number]++;
        }
    }
}

void mlrt_merge_bins(const struct mlrt_bvh_bins *bins, struct mlrt_bvh_bins *sum)
{
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < MLRT_BVH_BINS; i++) {
            extend_box(&sum->box[axis][i], f4_load(bins->box[axis][i].lo), f4_load(bins->box[axis][i].hi));
            sum->count[axis][i] += bins->count[axis][i];
        }
}

static void sweep_bins(const struct mlrt_bvh_costs *costs, const struct mlrt_bvh_bins *bins, uint32_t count,
                       uint32_t axis, struct mlrt_bvh_split *split)
{
    double upper_area[MLRT_BVH_BINS];
    struct growing_box box = empty_box();
    struct mlrt_quad_box kept;
    for (int i = MLRT_BVH_BINS - 1; i > 0; i--) {
        grow(&box, f4_load(bins->box[axis][i].lo), f4_load(bins->box[axis][i].hi));
        store_box(&box, &kept);
        upper_area[i] = area_of(&kept);
    }
    box = empty_box();
    uint32_t lower_count = 0;
    for (int i = 0; i < MLRT_BVH_BINS - 1; i++) {
        if (bins->count[axis][i] == 0) continue;
        lower_count += bins->count[axis][i];
        if (lower_count == count) break;
        grow(&box, f4_load(bins->box[axis][i].lo), f4_load(bins->box[axis][i].hi));
        store_box(&box, &kept);
        double cost =
            area_of(&kept) * set_cost(costs, lower_count) + upper_area[i + 1] * set_cost(costs, count - lower_count);
        if (cost >= split->cost) continue;
        split->cost = cost;
        split->axis = axis;
        split->bin = (uint32_t)i;
        split->lower_count = lower_count;
    }
}

/* The box of the references in bins first .. last along the axis. */
static void join_bins(const struct mlrt_bvh_bins *bins, uint32_t axis, uint32_t first, uint32_t last,
                      struct mlrt_quad_box *joined)
{
    struct growing_box box = empty_box();
    for (uint32_t i = first; i <= last; i++) grow(&box, f4_load(bins->box[axis][i].lo), f4_load(bins->box[axis][i].hi));
    store_box(&box, joined);
}

void mlrt_choose_split(const struct mlrt_bvh_costs *costs, const struct mlrt_bvh_bins *bins, uint32_t count,
                       struct mlrt_bvh_split *split)
{
    split->cost = HUGE_VAL;
    split->sorted = 0;
    for (uint32_t axis = 0; axis < 3; axis++) sweep_bins(costs, bins, count, axis, split);
    if (split->cost == HUGE_VAL) return;
    join_bins(bins, split->axis, 0, split->bin, &split->box[0]);
    join_bins(bins, split->axis, split->bin + 1, MLRT_BVH_BINS - 1, &split->box[1]);
}

/* Partitions the references in place: one of the upper side changes places with the last that is not yet tested. */
static void apply_bins(struct mlrt_quad_box *references, const struct mlrt_bvh_set *set,
                       const struct mlrt_bvh_split *split, struct mlrt_progress *progress, struct mlrt_bvh_set sides[2])
{
    struct binning binning = cut_bins(&set->centres);
    f4 start = f4_load(binning.start), scale = f4_load(binning.scale);
    struct growing_set lower = empty_set(), upper = empty_set();
    struct mlrt_quad_box *next = references + set->first, *end = next + set->count, *back = end;
    float limit = (float)(split->bin + 1);
    while (next < back) {
        if (mlrt_is_cancelled_in_round(progress, (size_t)(back - next))) break;
        MLRT_ALIGNED(16) float bin[4];
        f4 lo = f4_load(next->lo), hi = f4_load(next->hi);
        f4_store(bin, bin_of(lo, hi, start, scale));
        if (bin[split->axis] < limit) {
            add_reference(&lower, lo, hi);
            next++;
        } else {
            add_reference(&upper, lo, hi);
            *next = *--back;
            f4_store(back->lo, lo);
            f4_store(back->hi, hi);
        }
    }
    sides[0] = finish_set(&lower, set->first, split->lower_count);
    sides[1] = finish_set(&upper, set->first + split->lower_count, set->count - split->lower_count);
}

/* ---- both ---------------------------------------------------------------------------------------------------- */

void mlrt_apply_bvh_split(struct mlrt_quad_box *references, const struct mlrt_bvh_set *set,
                          const struct mlrt_bvh_split *split, struct mlrt_progress *progress,
                          struct mlrt_bvh_set sides[2])
{
    if (split->cost < HUGE_VAL && !split->sorted) {
        apply_bins(references, set, split, progress, sides);
        return;
    }
    uint32_t lower_count = set->count / 2;
    if (split->cost < HUGE_VAL) {
        apply_order(references, set, split);
        lower_count = split->lower_count;
    }
    sides[0] = mlrt_measure_set(references, set->first, lower_count, progress);
    sides[1] = mlrt_measure_set(references, set->first + lower_count, set->count - lower_count, progress);
}
