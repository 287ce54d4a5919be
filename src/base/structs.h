/* SPDX-License-Identifier: MIT */
/*
 * The caller's structs. They grow: the caller's has struct_size bytes, which may be fewer or more than this version
 * knows (mlrt.h, rules of the whole interface). Fields have rules (forms.h). What breaks one is named in the message of
 * the thread (message.h).
 */
#ifndef MLRT_BASE_STRUCTS_H
#define MLRT_BASE_STRUCTS_H

#include "base/forms.h"
#include "base/message.h"

/* The greatest stride that a caller may give, in bytes. A greater one is a mistake, such as a negative number. */
#define MLRT_STRIDE_LIMIT ((size_t)1 << 31)

/*
 * Copies element `index` of a caller's array of structs to *own, and checks it; of a struct alone, that is element 0.
 * Fields that it does not have become 0; without a struct (NULL) all do. `form` is MLRT_STRUCT_* or MLRT_FORM_*; `path`
 * and `index` name the struct as in mlrt_fail_at. Returns MLRT_OK; the status of a rule that is broken; or
 * MLRT_ERROR_STRUCT_SIZE if its size is less than the least that its form has, greater than that of any later version,
 * not a multiple of its alignment, or not that of element 0, which must have been taken first; or if a byte behind the
 * fields that this version knows is not 0.
 */
int32_t mlrt_take_struct(int form, const char *path, size_t index, const void *first, void *own);

/* As mlrt_take_struct, without the rules, for structs that say where messages go. */
int32_t mlrt_copy_struct(int form, const char *path, size_t index, const void *first, void *own);

/* Checks the fields of a struct of this version. Returns MLRT_OK, or the status of a rule that is broken. */
int32_t mlrt_check_fields(int form, const char *path, size_t index, const void *own);

/* Checks that struct_size of a caller's result is one that mlrt_give_struct can write. Returns a status. */
int32_t mlrt_check_result_size(int form, const char *path, const void *given);

/*
 * Checks an array that has data: address and stride must be multiples of `unit` (1, 2 or 4), the stride from `least` to
 * MLRT_STRIDE_LIMIT. Returns MLRT_OK or MLRT_ERROR_ARGUMENT.
 */
int32_t mlrt_check_array(const char *path, size_t index, const char *field, const void *data, size_t stride,
                         size_t unit, size_t least);

/* Adds the counts of a worker to those of the caller, as far as its struct_size reaches. */
void mlrt_add_counters(mlrt_counters *to, const mlrt_counters *from);

/* Copies *own to a caller's struct: the fields that it has, and 0 to those that this version does not know. */
void mlrt_give_struct(const void *own, size_t own_size, void *given);

#endif
