/* SPDX-License-Identifier: MIT */
/*
 * Structs that grow: see structs.h. Each begins with its size, a uint32_t.
 */
#include "base/structs.h"

#include <string.h>

/* Bytes that later versions may add: more than they will add, but so few that a size never set is mostly refused. */
#define GROWTH_LIMIT 256

static size_t size_of(const void *given)
{
    uint32_t size;
    memcpy(&size, given, sizeof size);
    return size;
}

static int is_zero(const unsigned char *bytes, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        if (bytes[i]) return 0;
    }
    return 1;
}

int32_t mlrt_check_result_size(const void *given, size_t first_size, size_t own_size)
{
    const size_t size = size_of(given);
    return size < first_size || size > own_size + GROWTH_LIMIT || size % 4 ? MLRT_ERROR_STRUCT_SIZE : MLRT_OK;
}

int32_t mlrt_take_struct(const void *given, size_t first_size, void *own, size_t own_size)
{
    const int32_t status = mlrt_check_result_size(given, first_size, own_size);
    if (status != MLRT_OK) return status;
    const size_t size = size_of(given), known = size < own_size ? size : own_size;
    memcpy(own, given, known);
    memset((unsigned char *)own + known, 0, own_size - known);
    const uint32_t kept = (uint32_t)own_size;
    memcpy(own, &kept, sizeof kept);
    return is_zero((const unsigned char *)given + known, size - known) ? MLRT_OK : MLRT_ERROR_STRUCT_SIZE;
}

void mlrt_give_struct(const void *own, size_t own_size, void *given)
{
    const size_t size = size_of(given), known = size < own_size ? size : own_size;
    memcpy((unsigned char *)given + 4, (const unsigned char *)own + 4, known - 4);
    memset((unsigned char *)given + known, 0, size - known);
}
