/* SPDX-License-Identifier: MIT */
/* steady_math.c - sine, cosine, random numbers and noise with the same bits on every machine: see steady_math.h */
#include "steady_math.h"

#include <math.h>

double turn_sin(double turns)
{
    double r = turns - floor(turns + 0.5); // -1/2 .. 1/2
    if (r > 0.25) r = 0.5 - r;
    if (r < -0.25) r = -0.5 - r;
    double a = 6.283185307179586 * r, b = a * a; // -pi/2 .. pi/2: the first term left out is a^17 / 17!, below 7e-12
    double sum = -1.0 / 1307674368000.0;
    sum = sum * b + 1.0 / 6227020800.0;
    sum = sum * b - 1.0 / 39916800.0;
    sum = sum * b + 1.0 / 362880.0;
    sum = sum * b - 1.0 / 5040.0;
    sum = sum * b + 1.0 / 120.0;
    sum = sum * b - 1.0 / 6.0;
    return a + a * b * sum;
}

double turn_cos(double turns)
{
    return turn_sin(turns + 0.25);
}

// The finalizer of MurmurHash3 (A. Appleby): every input bit changes every output bit with a chance of about 1/2.
static uint32_t mixed(uint32_t x)
{
    x ^= x >> 16;
    x *= 0x85EBCA6Bu;
    x ^= x >> 13;
    x *= 0xC2B2AE35u;
    return x ^ x >> 16;
}

double random_between(uint32_t *state, double low, double high)
{
    *state += 0x9E3779B9u;
    return low + (high - low) * (mixed(*state) / 4294967296.0);
}

uint32_t random_below(uint32_t *state, uint32_t count)
{
    return (uint32_t)random_between(state, 0, count);
}

static double lattice_value(int32_t x, int32_t y, int32_t z)
{
    uint32_t h = mixed((uint32_t)x + mixed((uint32_t)y + mixed((uint32_t)z)));
    return h / 2147483648.0 - 1.0;
}

static double between(double a, double b, double share)
{
    return a + (b - a) * share;
}

static double fade(double x)
{
    return x * x * x * (x * (x * 6 - 15) + 10);
}

double noise(double x, double y, double z)
{
    double fx = floor(x), fy = floor(y), fz = floor(z);
    int32_t ix = (int32_t)fx, iy = (int32_t)fy, iz = (int32_t)fz;
    double sx = fade(x - fx), sy = fade(y - fy), sz = fade(z - fz);
    double layer[2];
    for (int k = 0; k < 2; k++) {
        double front = between(lattice_value(ix, iy, iz + k), lattice_value(ix + 1, iy, iz + k), sx);
        double back = between(lattice_value(ix, iy + 1, iz + k), lattice_value(ix + 1, iy + 1, iz + k), sx);
        layer[k] = between(front, back, sy);
    }
    return between(layer[0], layer[1], sz);
}
