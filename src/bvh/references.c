/* SPDX-License-Identifier: MIT */
/* The references of all triangles, from which a hierarchy of boxes is built: see build.h. */
#include "bvh/build.h"

#include <string.h>

#include "bvh/unit.h"

/* Brings a reference into units. */
static void scale_reference(float unit, struct mlrt_quad_box *reference)
{
    for (int k = 0; k < 3; k++) {
        reference->lo.x[k] = mlrt_finite_bound(mlrt_low_in_units(reference->lo.x[k], unit));
        reference->hi.x[k] = mlrt_finite_bound(mlrt_high_in_units(reference->hi.x[k], unit));
    }
}

/*
 * A reference to a whole triangle: the box of mlrt_bound_triangle. The last vertex is read from one float earlier, so
 * as not to read past it. A vector load that waited for the store of a single float would take as long as all of this.
 */
MLRT_INLINE struct mlrt_quad_box reference_of(const struct mlrt_triangle *triangle, uint32_t number)
{
    const uint32_t bits = number | MLRT_REFERENCE_MARK;
    const f4 a = f4_load_any(triangle->v[0]), b = f4_load_any(triangle->v[1]), zero = f4_set1(0);
    const f4 c = f4_rest(f4_load_any(triangle->v[1] + 2));
    const f4 lo = f4_add(f4_min(c, f4_min(a, b)), zero), hi = f4_add(f4_max(c, f4_max(a, b)), zero);
    float word;
    memcpy(&word, &bits, sizeof word);
    return (struct mlrt_quad_box){{.v = f4_join(lo, f4_set1(word))}, {.v = f4_join(hi, zero)}};
}

/* Makes a reference for each triangle of a chunk that is not left out, from the place of the chunk's first triangle. */
static void make_chunk_references(struct mlrt_bvh_build *build, uint32_t number, uint32_t worker)
{
    struct mlrt_chunk *chunk = &build->references.chunks[number];
    const uint32_t first = number * MLRT_CHUNK_SIZE;
    const uint32_t last = first + mlrt_item_size(build->tree->triangle_count, MLRT_CHUNK_SIZE, number);
    const float unit = build->tree->bvh.unit;
    struct mlrt_quad_box *references = build->references.boxes + first;
    struct mlrt_bvh_set set = empty_set(first);
    (void)worker;
    *chunk = (struct mlrt_chunk){.non_finite_count = 0};
    for (uint32_t i = first; i < last; i++) {
        const struct mlrt_triangle *triangle = &build->tree->triangles[i];
        if (!mlrt_keep_triangle(triangle, &chunk->non_finite_count, &chunk->zero_area_count)) continue;
        const struct mlrt_quad_box reference = reference_of(triangle, i);
        references[set.count] = reference;
        add_reference(&reference, &set);
    }
    chunk->set = set;
    memcpy(chunk->bounds.lo, set.box.lo.x, sizeof chunk->bounds.lo);
    memcpy(chunk->bounds.hi, set.box.hi.x, sizeof chunk->bounds.hi);
    mlrt_advance(build->progress, MLRT_CHUNK_SIZE * MLRT_FIRST_WORK);
    if (unit == 1 && mlrt_is_within(chunk->bounds.lo, chunk->bounds.hi, MLRT_BVH_FAR)) return;
    for (uint32_t i = 0; i < set.count; i++) scale_reference(unit, &references[i]);
    chunk->set = mlrt_measure_set(build, first, set.count);
}

int32_t mlrt_make_references(struct mlrt_bvh_build *build)
{
    struct mlrt_box bounds = MLRT_NO_BOX;
    struct mlrt_bvh_set whole = empty_set(0);
    mlrt_tree_info *info = &build->tree->info;
    if (mlrt_run_step(build, build->limits.chunk_count, make_chunk_references) != MLRT_OK) return MLRT_ERROR_CANCELLED;
    for (uint32_t i = 0; i < build->limits.chunk_count; i++) {
        const struct mlrt_chunk *chunk = &build->references.chunks[i];
        if (whole.count != i * MLRT_CHUNK_SIZE)
            memmove(&build->references.boxes[whole.count], &build->references.boxes[i * MLRT_CHUNK_SIZE],
                    chunk->set.count * sizeof *build->references.boxes);
        whole.count += chunk->set.count;
        mlrt_extend_box(chunk->bounds.lo, chunk->bounds.hi, &bounds);
        grow(&whole.box, chunk->set.box.lo.v, chunk->set.box.hi.v);
        grow(&whole.centres, chunk->set.centres.lo.v, chunk->set.centres.hi.v);
        info->non_finite_count += chunk->non_finite_count;
        info->zero_area_count += chunk->zero_area_count;
    }
    build->references.whole = whole;
    if (whole.count > 0) build->tree->bounds = bounds;
    mlrt_set_bvh_extent(build->tree, build->limits.typical);
    return MLRT_OK;
}
