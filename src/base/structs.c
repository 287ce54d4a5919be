/* SPDX-License-Identifier: MIT */
/* The caller's structs: see structs.h. Each begins with its size, a uint32_t. */
#include "base/structs.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "base/platform.h"

/* Bytes that later versions may add: more than they will add, but so few that a size never set is mostly refused. */
#define GROWTH_LIMIT 256

/* ---- sizes ---- */

static size_t size_of(const void *given)
{
    uint32_t size;
    memcpy(&size, given, sizeof size);
    return size;
}

static MLRT_NOINLINE int32_t fail_size(const struct mlrt_form *form, const char *path, size_t index, size_t size)
{
    return mlrt_fail_at(MLRT_ERROR_STRUCT_SIZE, path, index, "struct_size", "%lu is not a multiple of %u from %u to %u",
                        (unsigned long)size, (unsigned)form->alignment, (unsigned)form->first_size,
                        (unsigned)(form->own_size + GROWTH_LIMIT));
}

/* Returns the status of a size. */
static int32_t check_size(const struct mlrt_form *form, const char *path, size_t index, size_t size)
{
    if (MLRT_LIKELY(size >= form->first_size && size <= (size_t)form->own_size + GROWTH_LIMIT &&
                    size % form->alignment == 0))
        return MLRT_OK;
    return fail_size(form, path, index, size);
}

int32_t mlrt_check_result_size(int form, const char *path, const void *given)
{
    return check_size(&mlrt_forms[form], path, 0, size_of(given));
}

/* Copies a struct of another size than this version's: shorter, or longer. */
static MLRT_NOINLINE int32_t convert(const struct mlrt_form *form, const char *path, size_t index,
                                     const unsigned char *given, unsigned char *own)
{
    const uint32_t own_size = form->own_size;
    const size_t size = size_of(given), known = size < own_size ? size : own_size;
    memset(own, 0, own_size);
    memcpy(own, given, known);
    memcpy(own, &own_size, sizeof own_size);
    for (size_t i = own_size; i < size; ++i) {
        if (!given[i]) continue;
        return mlrt_fail_at(MLRT_ERROR_STRUCT_SIZE, path, index, "",
                            "byte %u is not 0, but this version knows only %u bytes", (unsigned)i, (unsigned)own_size);
    }
    return MLRT_OK;
}

int32_t mlrt_copy_struct(int number, const char *path, size_t index, const void *first, void *own)
{
    const struct mlrt_form *form = &mlrt_forms[number];
    if (!first) {
        memset(own, 0, form->own_size);
        return MLRT_OK;
    }
    const size_t size = size_of(first);
    const unsigned char *given = (const unsigned char *)first + index * size;
    if (MLRT_UNLIKELY(size_of(given) != size)) {
        return mlrt_fail_at(MLRT_ERROR_STRUCT_SIZE, path, index, "struct_size", "%lu is not that of element 0, %lu",
                            (unsigned long)size_of(given), (unsigned long)size);
    }
    const int32_t status = check_size(form, path, index, size);
    if (MLRT_UNLIKELY(status != MLRT_OK)) return status;
    if (MLRT_UNLIKELY(size != form->own_size)) return convert(form, path, index, given, own);
    memcpy(own, given, size);
    return MLRT_OK;
}

int32_t mlrt_take_struct(int number, const char *path, size_t index, const void *first, void *own)
{
    const int32_t status = mlrt_copy_struct(number, path, index, first, own);
    return status == MLRT_OK && first ? mlrt_check_fields(number, path, index, own) : status;
}

void mlrt_give_struct(const void *own, size_t own_size, void *given)
{
    const size_t size = size_of(given), known = size < own_size ? size : own_size;
    memcpy((unsigned char *)given + 4, (const unsigned char *)own + 4, known - 4);
    memset((unsigned char *)given + known, 0, size - known);
}

/*
 * Behind its head mlrt_counters consists of uint64_t only; a caller compiled with an older version has fewer of them.
 */
void mlrt_add_counters(mlrt_counters *to, const mlrt_counters *from)
{
    const size_t first = offsetof(mlrt_counters, ray_count), size = size_of(to);
    const uint64_t *more = (const uint64_t *)(const void *)((const unsigned char *)from + first);
    uint64_t *sum = (uint64_t *)(void *)((unsigned char *)to + first);
    for (size_t i = 0; i < ((size < sizeof *from ? size : sizeof *from) - first) / sizeof *sum; ++i) sum[i] += more[i];
}

/* ---- rules ---- */

/* Floats are looked at by their bits: in the caller's floating-point environment a comparison may trap. */
#define SIGN_BIT      0x80000000u
#define INFINITY_BITS 0x7F800000u
#define MILLION_BITS  0x49742400u /* of 1e6 */

/* Of the floats of a field, the first that breaks its rule; NULL if none does. */
static const uint32_t *find_wrong_float(const struct mlrt_field *field, const uint32_t *bits)
{
    const int is_cost = field->kind == MLRT_FIELD_COST;
    const uint32_t most = is_cost ? MILLION_BITS : INFINITY_BITS - (field->kind == MLRT_FIELD_FINITE);
    for (uint32_t i = 0; i < field->most; ++i)
        if ((bits[i] & ~SIGN_BIT) > most || (is_cost && bits[i] > SIGN_BIT)) return &bits[i];
    return NULL;
}

/* Where the value stands that breaks a rule, and the status that this has. */
struct place {
    const char *path;
    size_t index;
    const char *field;
    int32_t status;
};

/* "stride 13 is not a multiple of 4": `what` is the first word, with a blank behind it, or a sign, or nothing. */
static MLRT_NOINLINE int32_t fail_number(const struct place *place, const char *what, uint64_t number, const char *rule,
                                         size_t bound)
{
    char digits[MLRT_DIGITS];
    return mlrt_fail_at(place->status, place->path, place->index, place->field, "%s%s is %s %lu", what,
                        mlrt_write_digits(number, digits), rule, (unsigned long)bound);
}

static MLRT_NOINLINE int32_t fail_array(const struct place *place, const char *what, const void *data, size_t stride,
                                        size_t unit, size_t least)
{
    if (stride == MLRT_STRIDE_ALL) {
        return mlrt_fail_at(place->status, place->path, place->index, place->field,
                            "%sMLRT_STRIDE_ALL is only for arrays of rays and points", what);
    }
    if ((uintptr_t)data % unit) return fail_number(place, "address ", (uintptr_t)data, "not a multiple of", unit);
    if (stride % unit) return fail_number(place, what, stride, "not a multiple of", unit);
    if (stride < least) return fail_number(place, what, stride, "less than", least);
    return fail_number(place, what, stride, "more than", MLRT_STRIDE_LIMIT);
}

/* `what` is the first word of a message about the stride. */
static int32_t check_array(const struct place *place, const char *what, const void *data, size_t stride, size_t unit,
                           size_t least)
{
    const int is_right =
        ((((uintptr_t)data | stride) & (unit - 1)) == 0) & (stride - least <= MLRT_STRIDE_LIMIT - least);
    return MLRT_LIKELY(is_right) ? MLRT_OK : fail_array(place, what, data, stride, unit, least);
}

int32_t mlrt_check_array(const char *path, size_t index, const char *field, const void *data, size_t stride,
                         size_t unit, size_t least)
{
    const struct place place = {path, index, field, MLRT_ERROR_ARGUMENT};
    return check_array(&place, "stride ", data, stride, unit, least);
}

/* Called from within the library's floating-point environment: a float is converted. */
static MLRT_NOINLINE void write_float(const uint32_t *bits, char *text, size_t size)
{
    float value;
    memcpy(&value, bits, sizeof value);
    snprintf(text, size, "%.9g", (double)value);
}

static int32_t fail_float(const struct place *place, const struct mlrt_field *field, const uint32_t *bits)
{
    char text[24] = "NaN";
    if ((*bits & ~SIGN_BIT) <= INFINITY_BITS) MLRT_COMPUTE(write_float(bits, text, sizeof text));
    return mlrt_fail_at(place->status, place->path, place->index, place->field, "%s is not %s", text,
                        field->kind == MLRT_FIELD_COST     ? "from 0 to 1e6"
                        : field->kind == MLRT_FIELD_FINITE ? "finite"
                                                           : "a number");
}

static int32_t check_output(const struct place *place, size_t element_size, int has_rows, const mlrt_array *array)
{
    const size_t unit = element_size == 1 ? 1 : 4, stride = array->stride ? array->stride : element_size;
    const int32_t status = check_array(place, "stride ", array->data, stride, unit, element_size);
    if (status != MLRT_OK || !has_rows) return status;
    return check_array(place, "row stride ", array->data, array->row_stride, unit, 0);
}

static int32_t check_field(struct place *place, const struct mlrt_field *field, int has_rows, const void *at)
{
    if (field->kind <= MLRT_FIELD_COUNT) {
        const uint32_t number = *(const uint32_t *)at;
        const int is_negative = field->kind == MLRT_FIELD_INTEGER && number > INT32_MAX;
        if (MLRT_LIKELY(number <= field->most)) return MLRT_OK;
        return fail_number(place, is_negative ? "-" : "", is_negative ? 0 - number : number,
                           field->most ? "not from 0 to" : "not", field->most);
    }
    if (field->kind == MLRT_FIELD_SIZE) {
        if (MLRT_LIKELY(*(const size_t *)at <= INT32_MAX)) return MLRT_OK;
        place->status = MLRT_ERROR_TOO_LARGE;
        return fail_number(place, "", *(const size_t *)at, "more than", INT32_MAX);
    }
    if (field->kind <= MLRT_FIELD_NUMBER) {
        const uint32_t *wrong = find_wrong_float(field, at);
        return MLRT_LIKELY(!wrong) ? MLRT_OK : fail_float(place, field, wrong);
    }
    const mlrt_const_array *array = at; /* mlrt_array begins like that */
    if (!array->data) return MLRT_OK;
    if (field->kind == MLRT_FIELD_OUTPUT) return check_output(place, field->most, has_rows, at);
    return check_array(place, "stride ", array->data, array->stride == MLRT_STRIDE_ALL ? 0 : array->stride, 4, 0);
}

int32_t mlrt_check_fields(int form, const char *path, size_t index, const void *own)
{
    const int is_camera = form >= MLRT_FORM_DIRECTION && form <= MLRT_FORM_EYE;
    const int has_rows = form == MLRT_FORM_FRAME || form == MLRT_FORM_VECTORS;
    struct place place = {path, index, "", is_camera ? MLRT_ERROR_CAMERA : MLRT_ERROR_ARGUMENT};
    int32_t status = MLRT_OK;
    const struct mlrt_field *field = mlrt_forms[form].rules;
    for (; status == MLRT_OK && field->kind != MLRT_FIELD_END; ++field) {
        place.field = field->name;
        status = check_field(&place, field, has_rows, (const unsigned char *)own + field->offset);
    }
    return status;
}
