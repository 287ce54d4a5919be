/* SPDX-License-Identifier: MIT */
/*
 * Structs that grow: the caller's struct has struct_size bytes, which may be fewer or more than this version knows
 * (mlrt.h, rules of the whole interface). Also the greatest stride that arrays in such structs may have.
 */
#ifndef MLRT_BASE_STRUCTS_H
#define MLRT_BASE_STRUCTS_H

#include <stddef.h>

#include "mlrt.h"

/* The greatest stride that a caller may give, in bytes. A greater one is a mistake, such as a negative number. */
#define MLRT_STRIDE_LIMIT ((size_t)1 << 31)

/* Bytes up to the end of a field: the size of the struct in a version whose last field it was. */
#define MLRT_SIZE_UP_TO(type, field) (offsetof(type, field) + sizeof(((type *)0)->field))

/*
 * Copies a caller's struct to *own; fields that it does not have become 0. `first_size` is its size in the first
 * version. Returns MLRT_OK, or MLRT_ERROR_STRUCT_SIZE if its size is less than that, greater than that of any later
 * version, or not a multiple of 4, or if a byte behind the fields that this version knows is not 0.
 */
int32_t mlrt_take_struct(const void *given, size_t first_size, void *own, size_t own_size);

/* Checks that struct_size of a caller's result is one that mlrt_give_struct can write. Returns a status. */
int32_t mlrt_check_result_size(const void *given, size_t first_size, size_t own_size);

/* Copies *own to a caller's struct: the fields that it has, and 0 to those that this version does not know. */
void mlrt_give_struct(const void *own, size_t own_size, void *given);

#endif
