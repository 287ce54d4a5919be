/* SPDX-License-Identifier: MIT */
/*
 * steady_math.h - sine, cosine, random numbers and noise with the same bits on every machine
 *
 * The procedural scenes are test inputs, so their vertices must not depend on a machine's libm. All is computed by
 * addition, subtraction, multiplication, division and floor, in double, in an order that the source fixes.
 */
#ifndef STEADY_MATH_H
#define STEADY_MATH_H

#include <stdint.h>

/* Sine and cosine of an angle in turns: 1 is once around. Good to about 1e-11. */
double turn_sin(double turns);
double turn_cos(double turns);

/* The next number in [low, high) from *state, which may start as anything. */
double random_between(uint32_t *state, double low, double high);

/* The next whole number in 0 .. count - 1. */
uint32_t random_below(uint32_t *state, uint32_t count);

/* Smooth noise in about -1 .. 1 with features of size 1. */
double noise(double x, double y, double z);

#endif
