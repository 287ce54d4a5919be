/* SPDX-License-Identifier: MIT */
/*
 * The arguments of calls that trace, checked: the caller's structs where they have the form of this version, or else
 * copies in this form. What is wrong is named in the message of the thread; the functions return a status.
 */
#ifndef MLRT_API_ARGUMENTS_H
#define MLRT_API_ARGUMENTS_H

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "base/host.h"
#include "base/structs.h"
#include "base/platform.h"

/* `all` with all words of a part of a struct or-ed to it. The part has at least 8 bytes. */
MLRT_INLINE uint64_t or_words(uint64_t all, const void *part, size_t size)
{
    uint64_t two;
    MLRT_UNROLL
    for (size_t i = 0; i + sizeof two <= size; i += sizeof two) {
        memcpy(&two, (const unsigned char *)part + i, sizeof two);
        all |= two;
    }
    if (size % sizeof two == 0) return all;
    memcpy(&two, (const unsigned char *)part + size - sizeof two, sizeof two);
    return all | two;
}

/*
 * Are the options of this version, and all of them 0 except for the query, the instruction set, the mask and the pool?
 * Without options (NULL) all are 0. Checks no rule but that of the query.
 */
MLRT_INLINE int mlrt_are_plain(const mlrt_trace_options *of)
{
    if (!of) return 1;
    if (of->struct_size != sizeof *of) return 0;
    const size_t first = offsetof(mlrt_trace_options, culling), last = offsetof(mlrt_trace_options, counters);
    uint64_t all = (uint32_t)of->method | ((uint32_t)of->query & ~(uint32_t)MLRT_QUERY_ANY);
    all = or_words(all, &of->culling, offsetof(mlrt_trace_options, mask) - first);
    return or_words(all, &of->counters, sizeof *of - last) == 0;
}

/* The t_max of a ray. Its bits are looked at, as the caller's floating-point environment may take a denormal for 0. */
MLRT_INLINE float mlrt_resolve_t_max(const mlrt_ray *ray)
{
    uint32_t bits;
    memcpy(&bits, &ray->t_max, sizeof bits);
    return bits & 0x7FFFFFFF ? ray->t_max : INFINITY;
}

/* The options of a call, and what it runs with. */
struct mlrt_call {
    const mlrt_trace_options *options; /* the caller's, or `own` */
    int is_plain;                      /* the options are plain (mlrt_are_plain), or there are none */
    mlrt_trace_options own;
    struct mlrt_run_options run;
};

/* Takes options (NULL = defaults). mlrt_resolve_options checks what depends on the kind of call (options.h). */
int32_t mlrt_take_options(const mlrt_trace_options *given, struct mlrt_call *call);

/* Check a struct. If it is of another version or unusual, it is copied to *own, and *rays or *hits becomes `own`. */
int32_t mlrt_take_rays(const mlrt_rays **rays, mlrt_rays *own);
int32_t mlrt_take_hits(const mlrt_hits **hits, mlrt_hits *own);

/*
 * Check that the call writes all arrays that are given, and that there is one. None is needed if `may_be_empty`: for a
 * call without rays, or that counts, or has a callback. `path` names the arrays.
 */
int32_t mlrt_check_hits(const char *path, const mlrt_hits *hits, const mlrt_trace_options *options, int has_lights,
                        int may_be_empty);
int32_t mlrt_check_lists(const mlrt_hit_lists *lists, int may_be_empty);

#endif
