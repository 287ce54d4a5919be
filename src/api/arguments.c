/* SPDX-License-Identifier: MIT */
/*
 * The arguments of calls that trace: see arguments.h. Here are the rules between fields; base/forms.c has those of
 * single ones.
 */
#include "api/arguments.h"

static int32_t fail_argument(const char *field, const char *rule)
{
    return mlrt_fail(MLRT_ERROR_ARGUMENT, "%s: %s", field, rule);
}

int32_t mlrt_take_options(const mlrt_trace_options *given, struct mlrt_call *call)
{
    static const mlrt_trace_options none = {.struct_size = sizeof none};
    memset(&call->run, 0, sizeof call->run);
    call->options = &none;
    call->is_plain = 1;
    if (!given) return MLRT_OK;
    if (MLRT_LIKELY(mlrt_are_plain(given) && (uint32_t)given->isa <= MLRT_ISA_NEON)) {
        call->options = given;
        call->run.pool = given->pool;
        return MLRT_OK;
    }
    call->is_plain = 0;
    int32_t status = mlrt_take_struct(MLRT_STRUCT_TRACE_OPTIONS, "options", 0, given, &call->own);
    if (status != MLRT_OK) return status;
    const mlrt_counters *counters = call->own.counters;
    call->options = &call->own;
    call->run.pool = call->own.pool;
    call->run.counters = call->own.counters;
    status = mlrt_take_host("options.host", call->own.host, &call->run.voice.host);
    if (status != MLRT_OK || !counters) return status;
    status = mlrt_check_result_size(MLRT_STRUCT_COUNTERS, "options.counters", counters);
    return status == MLRT_OK ? mlrt_check_fields(MLRT_STRUCT_COUNTERS, "options.counters", 0, counters) : status;
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

int32_t mlrt_take_rays(const mlrt_rays **rays, mlrt_rays *own)
{
    const mlrt_rays *given = *rays;
    const int is_right = given->struct_size == sizeof *given && !given->reserved && given->count <= INT32_MAX &&
                         are_right_arrays(&given->origins, sizeof given->origins, MLRT_STRIDE_ALL);
    if (MLRT_LIKELY(is_right)) return check_rays(given);
    const int32_t status = mlrt_take_struct(MLRT_STRUCT_RAYS, "rays", 0, given, own);
    *rays = own;
    return status == MLRT_OK ? check_rays(own) : status;
}

int32_t mlrt_take_hits(const mlrt_hits **hits, mlrt_hits *own)
{
    const mlrt_hits *given = *hits;
    const int is_right = given->struct_size == sizeof *given && !given->reserved &&
                         given->occluded.stride < MLRT_STRIDE_LIMIT && are_right_arrays(&given->t, sizeof given->t, 0);
    if (MLRT_LIKELY(is_right)) return MLRT_OK;
    *hits = own;
    return mlrt_take_struct(MLRT_STRUCT_HITS, "hits", 0, given, own);
}

/* Is the array of results given that a field describes? */
static int is_given(const struct mlrt_field *field, const void *arrays)
{
    const void *array = (const unsigned char *)arrays + field->offset;
    return ((const mlrt_array *)array)->data != NULL;
}

static MLRT_NOINLINE int32_t fail_query(const mlrt_hits *hits, int any)
{
    const size_t first = any ? offsetof(mlrt_hits, t) : offsetof(mlrt_hits, occluded);
    const struct mlrt_field *field = mlrt_forms[MLRT_STRUCT_HITS].rules;
    while (field->offset < first || !is_given(field, hits)) ++field;
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
    const struct mlrt_field *field = mlrt_forms[MLRT_STRUCT_HIT_LISTS].rules;
    for (; field->kind != MLRT_FIELD_END; ++field) {
        const int is_per_ray = field->offset >= offsetof(mlrt_hit_lists, total);
        if (!is_given(field, lists)) continue;
        may_be_empty = 1;
        if (is_per_ray || lists->capacity) continue;
        return mlrt_fail(MLRT_ERROR_ARGUMENT, "lists.capacity: 0, but `%s` was given", field->name);
    }
    return may_be_empty ? MLRT_OK : fail_argument("lists", "no array is given, so nothing would be written");
}
