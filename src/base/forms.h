/* SPDX-License-Identifier: MIT */
/*
 * The forms of the structs of mlrt.h: their sizes, and the rules of single fields, a line each. structs.h has what
 * checks them.
 */
#ifndef MLRT_BASE_FORMS_H
#define MLRT_BASE_FORMS_H

#include <stddef.h>

#include "mlrt.h"

/* What a rule wants of its field. */
enum {
    MLRT_FIELD_INTEGER, /* an int32_t from 0 to `most` */
    MLRT_FIELD_COUNT,   /* a uint32_t from 0 to `most`; if it holds flags, `most` is all of them or-ed */
    MLRT_FIELD_SIZE,    /* a size_t from 0 to INT32_MAX, beyond which the answer is MLRT_ERROR_TOO_LARGE */
    MLRT_FIELD_COST,    /* `most` floats from 0 to 1e6 */
    MLRT_FIELD_FINITE,  /* `most` floats that are finite */
    MLRT_FIELD_NUMBER,  /* `most` floats that are not NaN */
    MLRT_FIELD_INPUT,   /* an mlrt_const_array of 4-byte words */
    MLRT_FIELD_OUTPUT,  /* an mlrt_array whose elements have `most` bytes */
    MLRT_FIELD_END      /* none: there are no more rules */
};

/* A rule. The name is inside, because an address would take three times its place in a shared library. */
struct mlrt_field {
    char name[18];
    uint16_t offset;
    uint16_t most;
    uint8_t kind; /* MLRT_FIELD_* */
};

struct mlrt_form {
    uint16_t first_size; /* of the struct, in the first version */
    uint16_t own_size;   /* in this version */
    uint8_t alignment;   /* every size of the struct is a multiple of it */
    const struct mlrt_field *rules;
};

/* Forms besides those of structs (MLRT_STRUCT_*). */
enum {
    MLRT_FORM_FRAME = MLRT_STRUCT_COUNT, /* mlrt_hits of a picture: the rules of mlrt_hits, and row strides matter */
    MLRT_FORM_DIRECTION,                 /* mlrt_camera: a parallel one has a direction, and no eye */
    MLRT_FORM_VIEW,                      /* mlrt_camera: the other numbers */
    MLRT_FORM_EYE,                       /* mlrt_camera: a pinhole one has an eye, and no direction */
    MLRT_FORM_VECTORS,                   /* mlrt_array as an argument: of three floats, in rows */
    MLRT_FORM_BYTES,                     /* mlrt_array as an argument: of bytes */
    MLRT_FORM_FLOAT,                     /* a float that must be finite */
    MLRT_FORM_COUNT
};

/* By number, MLRT_STRUCT_* or MLRT_FORM_*. */
extern const struct mlrt_form mlrt_forms[];

/* The most lights that a picture may have: its shadows have a byte per pixel, and a light has one bit. */
#define MLRT_LIGHT_LIMIT 8

/* The most threads of a pool, with the one that calls. */
#define MLRT_THREAD_LIMIT 1024

/* Inner nodes of a path in a kd-tree, at most: stacks have room for as many. Scenes need no more (mlrta/build.c). */
#define MLRT_DEPTH_LIMIT 60

#endif
