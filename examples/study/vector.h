/* SPDX-License-Identifier: MIT */
/* vector.h - differences, dot and cross products in float and in double, for triangle tests */
#ifndef VECTOR_H
#define VECTOR_H

#include "base/platform.h"

MLRT_INLINE void subtract_float(const float a[3], const float b[3], float difference[3])
{
    for (int k = 0; k < 3; k++) difference[k] = a[k] - b[k];
}

MLRT_INLINE float dot_float(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

MLRT_INLINE void cross_float(const float a[3], const float b[3], float product[3])
{
    product[0] = a[1] * b[2] - a[2] * b[1];
    product[1] = a[2] * b[0] - a[0] * b[2];
    product[2] = a[0] * b[1] - a[1] * b[0];
}

/* The difference of two vectors of floats. */
MLRT_INLINE void subtract_double(const float a[3], const float b[3], double difference[3])
{
    for (int k = 0; k < 3; k++) difference[k] = (double)a[k] - (double)b[k];
}

MLRT_INLINE double dot_double(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

MLRT_INLINE void cross_double(const double a[3], const double b[3], double product[3])
{
    product[0] = a[1] * b[2] - a[2] * b[1];
    product[1] = a[2] * b[0] - a[0] * b[2];
    product[2] = a[0] * b[1] - a[1] * b[0];
}

#endif
