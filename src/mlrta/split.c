/* SPDX-License-Identifier: MIT */
/*
 * Where to split a cell: see split.h.
 *
 * Areas, sums and costs are doubles: an extent is 0 or from 2^-149 to 2^129, so nothing here overflows, and a cell with
 * extents in two axes has an area above 0.
 */
#include "mlrta/split.h"

#include <math.h>
#include <string.h>

#include "base/platform.h"
#include "mlrta/sort_keys.h"
#include "scene/clip.h"

/* ---- boxes --------------------------------------------------------------------------------------------------- */

static double extent(const struct mlrt_box *box, uint32_t axis)
{
    return (double)box->hi[axis] - box->lo[axis];
}

static double cross_section(const struct mlrt_box *box, uint32_t axis)
{
    return extent(box, (axis + 1) % 3) * extent(box, (axis + 2) % 3);
}

double mlrt_half_area(const struct mlrt_box *box)
{
    return cross_section(box, 0) + cross_section(box, 1) + cross_section(box, 2);
}

static int is_planar(const struct mlrt_box *box, uint32_t axis)
{
    return box->lo[axis] == box->hi[axis];
}

struct mlrt_content mlrt_measure_content(const struct mlrt_box *cell, const struct mlrt_reference *references,
                                         size_t count, struct mlrt_progress *progress)
{
    struct mlrt_content content = {cell, references, count, progress, references[0].box, {0, 0, 0}};
    for (size_t i = 0; i < count && !mlrt_is_cancelled_in_round(progress, i + 1); i++) {
        const struct mlrt_box *box = &references[i].box;
        for (uint32_t k = 0; k < 3; k++) {
            content.bounds.lo[k] = box->lo[k] < content.bounds.lo[k] ? box->lo[k] : content.bounds.lo[k];
            content.bounds.hi[k] = box->hi[k] > content.bounds.hi[k] ? box->hi[k] : content.bounds.hi[k];
            if (is_planar(box, k)) content.planar_area[k] += cross_section(box, k);
        }
    }
    return content;
}

/* 1 as long as there is a reference i to look at, and the call is not cancelled. */
MLRT_INLINE int has_next(const struct mlrt_content *content, size_t i)
{
    return i < content->count && !mlrt_is_cancelled_in_round(content->progress, i + 1);
}

/* ---- rule 1: empty space ------------------------------------------------------------------------------------- */

/* An empty side must be more than this part of the cell's volume: the paper's value. */
#define EMPTY_SIDE 0.1

int mlrt_find_empty_side(const struct mlrt_content *content, struct mlrt_split *split)
{
    const struct mlrt_box *cell = content->cell, *bounds = &content->bounds;
    double largest = EMPTY_SIDE;
    for (uint32_t k = 0; k < 3; k++) {
        double below = (double)bounds->lo[k] - cell->lo[k], above = (double)cell->hi[k] - bounds->hi[k];
        double gap = below > above ? below : above;
        if (gap <= largest * extent(cell, k)) continue;
        largest = gap / extent(cell, k);
        split->axis = k;
        split->planar_above = gap == below;
        split->position = split->planar_above ? bounds->lo[k] : bounds->hi[k];
    }
    return largest > EMPTY_SIDE;
}

/* ---- rule 2: covered planes ---------------------------------------------------------------------------------- */

/* The areas of triangles that cover a rectangle add up to its area but for rounding errors, far below 2^-20 of it. */
#define COVERED (1 - 0x1p-20)

/* Stores the positions of planar references in `keys`, ascending and each once. Returns the number of positions. */
static size_t gather_planes(const struct mlrt_content *content, uint32_t axis, uint32_t *keys)
{
    size_t key_count = 0;
    for (size_t i = 0; has_next(content, i); i++) {
        const struct mlrt_box *box = &content->references[i].box;
        if (is_planar(box, axis)) keys[key_count++] = mlrt_float_key(box->lo[axis]);
    }
    return mlrt_sort_unique_keys(keys, keys + key_count, key_count);
}

/* The number of the plane that a reference lies in, among those with ascending keys; key_count if it lies in none. */
static size_t find_plane(const struct mlrt_box *box, uint32_t axis, const uint32_t *keys, size_t key_count)
{
    if (!is_planar(box, axis)) return key_count;
    const uint32_t key = mlrt_float_key(box->lo[axis]);
    size_t first = 0, last = key_count;
    while (first < last) {
        const size_t middle = first + (last - first) / 2;
        if (keys[middle] < key)
            first = middle + 1;
        else
            last = middle;
    }
    return first < key_count && keys[first] == key ? first : key_count;
}

/* Sets the area of the triangles in each plane, clipped to their boxes. */
static void measure_planes(const struct mlrt_triangle *triangles, const struct mlrt_content *content, uint32_t axis,
                           const uint32_t *keys, size_t key_count, double *areas)
{
    memset(areas, 0, key_count * sizeof *areas);
    for (size_t i = 0; has_next(content, i); i++) {
        const struct mlrt_box *box = &content->references[i].box;
        const size_t plane = find_plane(box, axis, keys, key_count);
        const struct mlrt_triangle *triangle = &triangles[content->references[i].triangle];
        if (plane < key_count && mlrt_is_across(triangle, axis)) areas[plane] += mlrt_clipped_area(triangle, box, axis);
    }
}

int mlrt_find_covered_plane(const struct mlrt_triangle *triangles, const struct mlrt_content *content, uint32_t *keys,
                            double *areas, struct mlrt_split *split)
{
    const struct mlrt_box *cell = content->cell;
    double best = -1;
    for (uint32_t k = 0; k < 3; k++) {
        const double enough = COVERED * cross_section(cell, k); /* area of triangles in a plane across the axis */
        if (extent(cell, k) <= 0 || enough <= 0 || content->planar_area[k] < enough) continue;
        const size_t plane_count = gather_planes(content, k, keys);
        measure_planes(triangles, content, k, keys, plane_count, areas);
        for (size_t plane = 0; plane < plane_count; plane++) {
            const float position = mlrt_key_float(keys[plane]);
            const double below = (double)position - cell->lo[k], above = (double)cell->hi[k] - position;
            const double smaller = (above < below ? above : below) / extent(cell, k);
            if (areas[plane] < enough || smaller <= best) continue;
            best = smaller;
            split->axis = k;
            split->position = position;
            split->planar_above = above < below;
        }
    }
    return best >= 0;
}

/* ---- surface area heuristic ---------------------------------------------------------------------------------- */

/* An axis of a cell, and the terms of what a split across it costs. */
struct sweep {
    const struct mlrt_cost_model *model;
    double lo; /* bounds of the cell */
    double hi;
    double cross_section;
    double perimeter; /* half of that of the cross section */
    double per_area;  /* cost of a triangle test, per half area of the child that has it */
    uint32_t axis;
};

static struct sweep start_sweep(const struct mlrt_cost_model *model, const struct mlrt_box *cell, uint32_t axis)
{
    struct sweep sweep = {model, cell->lo[axis], cell->hi[axis], cross_section(cell, axis), 0, 0, axis};
    sweep.perimeter = extent(cell, (axis + 1) % 3) + extent(cell, (axis + 2) % 3);
    sweep.per_area = model->intersection / mlrt_half_area(cell);
    return sweep;
}

/* The cost of a split at `position`. Not inlined: 450 bytes less. */
static MLRT_NOINLINE double cost_at(const struct sweep *sweep, double position, size_t below_count, size_t above_count)
{
    double below_area = sweep->cross_section + (position - sweep->lo) * sweep->perimeter;
    double above_area = sweep->cross_section + (sweep->hi - position) * sweep->perimeter;
    double tests = sweep->per_area * (below_area * (double)below_count + above_area * (double)above_count);
    double factor = below_count == 0 || above_count == 0 ? sweep->model->empty_factor : 1;
    return factor * (sweep->model->traversal + tests);
}

double mlrt_split_cost(const struct mlrt_cost_model *model, const struct mlrt_box *cell, const struct mlrt_split *split,
                       size_t below_count, size_t above_count)
{
    struct sweep sweep = start_sweep(model, cell, split->axis);
    return cost_at(&sweep, split->position, below_count, above_count);
}

static void offer_split(const struct sweep *sweep, float position, size_t below_count, size_t above_count,
                        int planar_above, struct mlrt_split *best)
{
    double cost = cost_at(sweep, position, below_count, above_count);
    if (cost < best->cost) {
        best->cost = cost;
        best->position = position;
        best->axis = sweep->axis;
        best->planar_above = planar_above;
    }
}

/* Bounds of references along an axis, sorted: starts and ends of those not planar in it, positions of the planar. */
struct events {
    uint32_t *starts;
    uint32_t *ends;
    uint32_t *planars;
    size_t start_count;
    size_t end_count;
    size_t planar_count;
};

/* Moves *next past the keys that are equal to `key`. Returns their number. */
MLRT_INLINE size_t skip_equal(const uint32_t *keys, size_t count, size_t *next, uint32_t key)
{
    size_t first = *next;
    while (*next < count && keys[*next] == key) ++*next;
    return *next - first;
}

/* The lesser of `key` and the next of `keys`. */
static uint32_t first_key(const uint32_t *keys, size_t count, size_t next, uint32_t key)
{
    return next < count && keys[next] < key ? keys[next] : key;
}

/*
 * Tries a split at every event. References that end at the plane leave the upper side before the split is tried, those
 * that start there join the lower side after it; planar ones are tried on both sides. `below_count` references start
 * before the first event, `above_count` do not end before it. A face of the cell is tried only if that takes planar
 * references out of the rest of the cell.
 */
static void sweep_events(const struct sweep *sweep, const struct events *events, size_t below_count, size_t above_count,
                         struct mlrt_split *best)
{
    size_t start = 0, end = 0, planar = 0;
    while (start < events->start_count || end < events->end_count || planar < events->planar_count) {
        uint32_t key = first_key(events->starts, events->start_count, start, UINT32_MAX);
        key = first_key(events->ends, events->end_count, end, key);
        key = first_key(events->planars, events->planar_count, planar, key);
        size_t planar_here = skip_equal(events->planars, events->planar_count, &planar, key);
        above_count -= skip_equal(events->ends, events->end_count, &end, key) + planar_here;
        float position = mlrt_key_float(key);
        if (position > sweep->lo && (planar_here > 0 || position < sweep->hi))
            offer_split(sweep, position, below_count, above_count + planar_here, 1, best);
        if (planar_here > 0 && position < sweep->hi)
            offer_split(sweep, position, below_count + planar_here, above_count, 0, best);
        below_count += skip_equal(events->starts, events->start_count, &start, key) + planar_here;
    }
}

/* Bins per axis: the planes between them are tried first, then the events in the two bins beside the best plane. */
#define BIN_COUNT 256

/* The bins of an axis. Their numbers never decrease with x (bin_of), so that counts of whole bins are exact. */
struct binning {
    double start;
    double scale;
};

MLRT_INLINE int bin_of(const struct binning *binning, float x)
{
    const int bin = (int)((x - binning->start) * binning->scale);
    return bin < BIN_COUNT ? bin : BIN_COUNT - 1;
}

/* 1 if x lies in one of two neighbouring bins; without `binning`, always. */
MLRT_INLINE int is_in_bins(const struct binning *binning, int first_bin, float x)
{
    return binning == NULL || (unsigned)(bin_of(binning, x) - first_bin) < 2;
}

/*
 * Gathers the events along an axis; with `binning`, those in the bins first_bin and first_bin + 1. Starts are stored
 * from keys[0] up, planars from keys[count - 1] down, and ends from keys[count] up.
 */
static struct events gather_events(const struct mlrt_content *content, uint32_t axis, const struct binning *binning,
                                   int first_bin, uint32_t *keys)
{
    uint32_t *middle = keys + content->count;
    struct events events = {keys, middle, middle, 0, 0, 0};
    for (size_t i = 0; has_next(content, i); i++) {
        const float lo = content->references[i].box.lo[axis], hi = content->references[i].box.hi[axis];
        const int starts = is_in_bins(binning, first_bin, lo), ends = is_in_bins(binning, first_bin, hi);
        if (lo == hi) {
            if (!starts) continue;
            *--events.planars = mlrt_float_key(lo);
            events.planar_count++;
            continue;
        }
        if (starts) events.starts[events.start_count++] = mlrt_float_key(lo);
        if (ends) events.ends[events.end_count++] = mlrt_float_key(hi);
    }
    uint32_t *spare = middle + content->count;
    mlrt_sort_keys(events.starts, spare, events.start_count);
    mlrt_sort_keys(events.ends, spare, events.end_count);
    mlrt_sort_keys(events.planars, spare, events.planar_count);
    return events;
}

void mlrt_find_exact_split(const struct mlrt_cost_model *model, const struct mlrt_content *content, uint32_t *keys,
                           struct mlrt_split *split)
{
    split->cost = HUGE_VAL;
    for (uint32_t k = 0; k < 3; k++) {
        if (extent(content->cell, k) <= 0) continue;
        const struct sweep sweep = start_sweep(model, content->cell, k);
        const struct events events = gather_events(content, k, NULL, 0, keys);
        sweep_events(&sweep, &events, 0, content->count, split);
    }
}

/* ---- the same with bins -------------------------------------------------------------------------------------- */

/* The number of references that start and end in each bin of an axis. */
struct bins {
    struct binning binning;
    uint32_t starts[BIN_COUNT];
    uint32_t ends[BIN_COUNT];
};

static void fill_bins(const struct mlrt_content *content, uint32_t axis, struct bins *bins)
{
    memset(bins, 0, sizeof *bins);
    bins->binning.start = content->bounds.lo[axis];
    bins->binning.scale = BIN_COUNT / extent(&content->bounds, axis);
    for (size_t i = 0; has_next(content, i); i++) {
        bins->starts[bin_of(&bins->binning, content->references[i].box.lo[axis])]++;
        bins->ends[bin_of(&bins->binning, content->references[i].box.hi[axis])]++;
    }
}

/* The cheapest bin boundary. */
struct boundary {
    double cost;
    struct binning binning;
    uint32_t axis;
    int bin;            /* the first above it; 0 = there is no boundary */
    size_t below_count; /* of references that start below bin - 1 */
    size_t above_count; /* of those that do not end below bin - 1 */
};

/* Replaces *best by the cheapest boundary of the sweep's axis if that is cheaper. */
static void offer_boundaries(const struct sweep *sweep, const struct bins *bins, size_t count, struct boundary *best)
{
    size_t below_count = 0, above_count = count;
    for (int bin = 1; bin < BIN_COUNT; bin++) {
        const uint32_t started = bins->starts[bin - 1], ended = bins->ends[bin - 1];
        const double position = bins->binning.start + bin / bins->binning.scale;
        const double cost = cost_at(sweep, position, below_count + started, above_count - ended);
        if (cost < best->cost)
            *best = (struct boundary){cost, bins->binning, sweep->axis, bin, below_count, above_count};
        below_count += started;
        above_count -= ended;
    }
}

void mlrt_find_binned_split(const struct mlrt_cost_model *model, const struct mlrt_content *content, uint32_t *keys,
                            struct mlrt_split *split)
{
    struct boundary best = {.cost = HUGE_VAL, .bin = 0};
    for (uint32_t k = 0; k < 3; k++) {
        struct bins bins;
        if (extent(&content->bounds, k) <= 0) continue;
        fill_bins(content, k, &bins);
        const struct sweep sweep = start_sweep(model, content->cell, k);
        offer_boundaries(&sweep, &bins, content->count, &best);
    }
    split->cost = HUGE_VAL;
    if (best.bin > 0) {
        const struct sweep sweep = start_sweep(model, content->cell, best.axis);
        const struct events events = gather_events(content, best.axis, &best.binning, best.bin - 1, keys);
        sweep_events(&sweep, &events, best.below_count, best.above_count, split);
    }
    if (split->cost == HUGE_VAL) mlrt_find_exact_split(model, content, keys, split);
}
