/* SPDX-License-Identifier: MIT */
/*
 * What a program compiled against mlrt.h relies on, as text: the structs with the size, the alignment and the place of
 * every field, and the constants. The list of them is made from the header itself (interface.awk).
 */
#ifndef MLRT_TESTS_INTERFACE_H
#define MLRT_TESTS_INTERFACE_H

#include <stddef.h>
#include <stdio.h>

#include "mlrt.h"

/* Bytes between fields, or behind the last, that no field names: compilers may differ in them, and nobody sets them. */
static inline size_t print_hole(FILE *out, size_t from, size_t to)
{
    if (to > from) fprintf(out, "%6u %4u  unnamed\n", (unsigned)from, (unsigned)(to - from));
    return to - from;
}

/* Writes all structs, and returns how many bytes of them no field names. */
static inline size_t print_layout(FILE *out)
{
    size_t hole_size = 0, end = 0;
#define STRUCT(type, number)                                                                                           \
    {                                                                                                                  \
        struct after_char {                                                                                            \
            char first;                                                                                                \
            type second;                                                                                               \
        };                                                                                                             \
        fprintf(out, "%s: %u bytes, aligned to %u\n", #type, (unsigned)sizeof(type),                                   \
                (unsigned)offsetof(struct after_char, second));                                                        \
        end = 0;                                                                                                       \
    }
#define FIELD(type, name, field_type)                                                                                  \
    hole_size += print_hole(out, end, offsetof(type, name));                                                           \
    end = offsetof(type, name) + sizeof(((type *)0)->name);                                                            \
    fprintf(out, "%6u %4u  %s: %s\n", (unsigned)offsetof(type, name), (unsigned)sizeof(((type *)0)->name), #name,      \
            field_type);
#define END(type) hole_size += print_hole(out, end, sizeof(type));
#define CONSTANT(name)
#include "interface.inc"
#undef STRUCT
#undef FIELD
#undef END
#undef CONSTANT
    return hole_size;
}

/* Writes all constants. */
static inline void print_constants(FILE *out)
{
#define STRUCT(type, number)
#define FIELD(type, name, field_type)
#define END(type)
#define CONSTANT(name) fprintf(out, "%s = %lu\n", #name, (unsigned long)(name));
#include "interface.inc"
#undef STRUCT
#undef FIELD
#undef END
#undef CONSTANT
}

#endif
