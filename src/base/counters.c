/* SPDX-License-Identifier: MIT */
/*
 * Sums of counters: each worker of a call counts for itself, and the counts are added up at the end. Behind its head
 * mlrt_counters consists of uint64_t only; a caller compiled with an older version has fewer of them.
 */
#include "base/counters.h"

#include <stddef.h>

#define FIRST_COUNTER offsetof(mlrt_counters, ray_count)

void mlrt_add_counters(mlrt_counters *to, const mlrt_counters *from)
{
    const size_t known = to->struct_size < sizeof *from ? to->struct_size : sizeof *from;
    const uint64_t *more = (const uint64_t *)(const void *)((const unsigned char *)from + FIRST_COUNTER);
    uint64_t *sum = (uint64_t *)(void *)((unsigned char *)to + FIRST_COUNTER);
    for (size_t i = 0; i < (known - FIRST_COUNTER) / sizeof *sum; ++i) sum[i] += more[i];
}
