/* SPDX-License-Identifier: MIT */
/*
 * The arguments of calls that trace: see arguments.h. Here are the rules between fields; base/forms.c has those of
 * single ones.
 */
#include "api/arguments.h"

#include "base/host.h"

static int32_t fail_argument(const char *field, const char *rule)
{
    return mlrt_fail(MLRT_ERROR_ARGUMENT, "%s: %s", field, rule);
}

int32_t mlrt_take_options(const mlrt_trace_options *given, struct mlrt_call *call)
{
    static const mlrt_trace_options none = {.struct_size = sizeof none};
    int32_t status = MLRT_OK;
    memset(&call->run, 0, sizeof call->run);
    call->options = &none;
    call->is_plain = 1;
    if (!given) return MLRT_OK;
    if (MLRT_LIKELY(given->struct_size == sizeof *given && mlrt_are_plain(given) &&
                    (uint32_t)given->isa <= MLRT_ISA_AVX512)) {
        call->options = given;
        call->run.pool = given->pool;
        return MLRT_OK;
    }
    call->is_plain = 0;
    const mlrt_trace_options *options =
        mlrt_see_struct(MLRT_STRUCT_TRACE_OPTIONS, "options", given, &call->own, &status);
    if (!options) return status;
    const mlrt_counters *counters = options->counters;
    call->options = options;
    call->run.pool = options->pool;
    call->run.counters = options->counters;
    status = mlrt_take_host("options.host", options->host, &call->run.host);
    if (status != MLRT_OK || !counters) return status;
    status = mlrt_check_result_size(MLRT_STRUCT_COUNTERS, "options.counters", counters);
    return status == MLRT_OK ? mlrt_check_fields(MLRT_STRUCT_COUNTERS, "options.counters", 0, counters) : status;
}

int32_t mlrt_end_traced(const struct mlrt_call *call, int32_t status)
{
    if (status == MLRT_OK) return status;
    const struct mlrt_voice voice = {.host = call->run.host};
    return mlrt_end_call(&voice, status);
}

int32_t mlrt_check_options(const mlrt_trace_options *options)
{
    const uint32_t split = options->split_factor;
    if (options->lights || options->light_count)
        return fail_argument("options.lights", "only mlrt_render_tiles takes lights");
    if (split == 0 || split == 4 || split == 16) return MLRT_OK;
    return mlrt_fail(MLRT_ERROR_ARGUMENT, "options.split_factor: %lu is not 0, 4 or 16", (unsigned long)split);
}

int32_t mlrt_take_lights(mlrt_trace_options *options, const mlrt_light **lights, uint32_t *count)
{
    *lights = options->lights;
    *count = options->light_count;
    options->lights = NULL;
    options->light_count = 0;
    if (*lights && options->query == MLRT_QUERY_ANY)
        return fail_argument("options.lights", "given, but query ANY takes no lights");
    return *lights || !*count ? MLRT_OK : fail_argument("options.lights", "NULL, but light_count is not 0");
}

/*
 * Calls of few rays spend a good part of their time on checks. So structs as most callers give them are recognised
 * here, with all arrays at once; for other structs the tables of rules say what is wrong, if anything. The arrays of a
 * struct are neighbours, and mlrt_array begins as mlrt_const_array does. A stride of 0 or `all` is right, and any other
 * multiple of 4 has room for 4 bytes.
 */
MLRT_INLINE int are_right_arrays(const void *arrays, size_t size, size_t all)
{
    size_t addresses = 0, strides = 0;
    MLRT_UNROLL
    for (size_t i = 0; i < 6; ++i) {
        const mlrt_const_array *array = (const void *)((const unsigned char *)arrays + i * size);
        addresses |= (uintptr_t)array->data;
        strides |= array->stride == all ? 0 : array->stride;
    }
    return ((addresses | strides) & 3) == 0 && strides < MLRT_STRIDE_LIMIT;
}

/* The rules between fields of rays. */
static int32_t check_rays(const mlrt_rays *rays)
{
    char digits[MLRT_DIGITS];
    if (rays->count && !rays->origins.data) return fail_argument("rays.origins", "NULL, but count is not 0");
    if (rays->count && !rays->directions.data) return fail_argument("rays.directions", "NULL, but count is not 0");
    if (rays->rays_per_origin <= 1 || rays->count % rays->rays_per_origin == 0) return MLRT_OK;
    return mlrt_fail(MLRT_ERROR_ARGUMENT, "rays.rays_per_origin: %lu does not divide count %s",
                     (unsigned long)rays->rays_per_origin, mlrt_write_digits(rays->count, digits));
}

const mlrt_rays *mlrt_take_rays(const mlrt_rays *given, mlrt_rays *own, int32_t *status)
{
    const int is_right = given->struct_size == sizeof *given && !given->reserved && given->count <= INT32_MAX &&
                         are_right_arrays(&given->origins, sizeof given->origins, MLRT_STRIDE_ALL);
    const mlrt_rays *rays =
        MLRT_LIKELY(is_right) ? given : mlrt_see_struct(MLRT_STRUCT_RAYS, "rays", given, own, status);
    if (rays) *status = check_rays(rays);
    return *status == MLRT_OK ? rays : NULL;
}

const mlrt_hits *mlrt_take_hits(const mlrt_hits *given, mlrt_hits *own, int32_t *status)
{
    const int is_right = given->struct_size == sizeof *given && !given->reserved &&
                         given->occluded.stride < MLRT_STRIDE_LIMIT && are_right_arrays(&given->t, sizeof given->t, 0);
    return MLRT_LIKELY(is_right) ? given : mlrt_see_struct(MLRT_STRUCT_HITS, "hits", given, own, status);
}

const mlrt_points *mlrt_take_points(const mlrt_points *given, mlrt_points *own, int32_t *status)
{
    const mlrt_points *points = mlrt_see_struct(MLRT_STRUCT_POINTS, "points", given, own, status);
    if (points && points->count && !points->positions.data)
        *status = fail_argument("points.positions", "NULL, but count is not 0");
    return *status == MLRT_OK ? points : NULL;
}

/* Is the array of results given that a field describes? */
static int is_given(const struct mlrt_field *field, const void *arrays)
{
    const void *array = (const unsigned char *)arrays + field->offset;
    return ((const mlrt_array *)array)->data != NULL;
}

static MLRT_NOINLINE int32_t fail_query(const mlrt_hits *hits, int any)
{
    const struct mlrt_field *field = &mlrt_rules.results.hits[any ? 1 : 7];
    while (!is_given(field, hits)) ++field;
    return mlrt_fail(MLRT_ERROR_ARGUMENT,
                     any ? "options.query: ANY writes only `occluded`, but `%s` was given"
                         : "options.query: CLOSEST writes `%s` only with lights, but it was given",
                     field->name);
}

int32_t mlrt_check_hits(const char *path, const mlrt_hits *hits, const mlrt_trace_options *options, int has_lights,
                        int may_be_empty)
{
    const int any = options->query == MLRT_QUERY_ANY, has_occluded = hits->occluded.data != NULL;
    const int has_closest =
        ((uintptr_t)hits->t.data | (uintptr_t)hits->u.data | (uintptr_t)hits->v.data | (uintptr_t)hits->mesh.data |
         (uintptr_t)hits->triangle.data | (uintptr_t)hits->facing.data) != 0;
    if (any ? has_closest : has_occluded && !has_lights) return fail_query(hits, any);
    if (has_closest || has_occluded || may_be_empty) return MLRT_OK;
    return fail_argument(path, "no array is given, so nothing would be written");
}

int32_t mlrt_check_lists(const mlrt_hit_lists *lists, int may_be_empty)
{
    const struct mlrt_field *field = mlrt_rules.results.hit_lists;
    for (int i = 0; i < 9; ++i, ++field) {
        if (!is_given(field, lists)) continue;
        may_be_empty = 1;
        if (i >= 7 || lists->capacity) continue;
        return mlrt_fail(MLRT_ERROR_ARGUMENT, "lists.capacity: 0, but `%s` was given", field->name);
    }
    return may_be_empty ? MLRT_OK : fail_argument("lists", "no array is given, so nothing would be written");
}
