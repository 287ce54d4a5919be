/* SPDX-License-Identifier: MIT */
/*
 * Structs that grow: what the caller has is as long as its struct_size says, which may be less or more than what this
 * version knows (mlrt.h, rules of the whole interface). And the greatest stride that arrays in them may have.
 */
#ifndef MLRT_BASE_STRUCTS_H
#define MLRT_BASE_STRUCTS_H

#include <stddef.h>

#include "mlrt.h"

/* The greatest stride that a caller may give, in bytes: more is a mistake, such as a negative number. */
#define MLRT_STRIDE_LIMIT ((size_t)1 << 31)

/* Bytes up to the end of a field: what the size of a struct was when that field was the last. */
#define MLRT_SIZE_UP_TO(type, field) (offsetof(type, field) + sizeof(((type *)0)->field))

/*
 * Copies a struct of the caller's, whose size was `first_size` in the first version, to *own: what it does not have
 * becomes 0. MLRT_ERROR_STRUCT_SIZE: it is shorter than ever, longer than any version will be, no multiple of 4, or has
 * something other than 0 where this version knows nothing.
 */
int32_t mlrt_take_struct(const void *given, size_t first_size, void *own, size_t own_size);

/* Whether *given says that it is of a size that mlrt_give_struct can write. */
int32_t mlrt_check_result_size(const void *given, size_t first_size, size_t own_size);

/* The other way: writes the fields that the caller's struct has, and 0 to those that this version does not know. */
void mlrt_give_struct(const void *own, size_t own_size, void *given);

#endif
