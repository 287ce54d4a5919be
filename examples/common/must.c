/* SPDX-License-Identifier: MIT */
/* must.c - messages about failures, memory, or the end of the program: see must.h */
#include "must.h"

#include <mlrt.h>

#include <stdio.h>
#include <stdlib.h>

int has_failed(int32_t status, const char *what)
{
    if (status == MLRT_OK) return 0;
    fprintf(stderr, "cannot %s: %s: %s\n", what, mlrt_status_string(status), mlrt_last_message());
    return 1;
}

void *must_allocate(size_t count, size_t size)
{
    void *block = calloc(count ? count : 1, size);
    if (block) return block;
    fprintf(stderr, "out of memory\n");
    exit(1);
}

void must_succeed(int32_t status)
{
    if (status == MLRT_OK) return;
    fprintf(stderr, "%s: %s\n", mlrt_status_string(status), mlrt_last_message());
    exit(1);
}
