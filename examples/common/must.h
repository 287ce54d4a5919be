/* SPDX-License-Identifier: MIT */
/* must.h - what to say on stderr if a call fails, and for programs that cannot go on then: to end with it */
#ifndef MUST_H
#define MUST_H

#include <stddef.h>
#include <stdint.h>

/* Returns whether a call of the library failed just now, after saying so: "cannot WHAT", and why. */
int has_failed(int32_t status, const char *what);

/* A block of count elements, all 0, also if count is 0. */
void *must_allocate(size_t count, size_t size);

/* Ends the program unless the status of a call of the library is MLRT_OK. */
void must_succeed(int32_t status);

#endif
