/* SPDX-License-Identifier: MIT */
/* must.h - for programs that cannot go on without memory, or if a call fails: they end with a message on stderr */
#ifndef MUST_H
#define MUST_H

#include <stddef.h>
#include <stdint.h>

/* A block of count elements, all 0, also if count is 0. */
void *must_allocate(size_t count, size_t size);

/* Ends the program unless the status of a call of the library is MLRT_OK. */
void must_succeed(int32_t status);

#endif
