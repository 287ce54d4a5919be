/* SPDX-License-Identifier: MIT */
/* A shared library as a table of functions. */
#ifndef MLRT_TESTS_LOAD_H
#define MLRT_TESTS_LOAD_H

#include <dlfcn.h>

#include "library.h"

static inline int look_up(void *handle, const char *name, void *function)
{
    void *address = dlsym(handle, name);
    memcpy(function, &address, sizeof address);
    return address != NULL;
}

/* Returns what dlclose takes, or NULL. */
static inline void *load_library(const char *path, struct library *library)
{
    void *handle = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (handle && look_up(handle, "mlrt_build_tree", &library->build) &&
        look_up(handle, "mlrt_trace_packet", &library->trace) &&
        look_up(handle, "mlrt_destroy_tree", &library->destroy_tree) &&
        look_up(handle, "mlrt_create_pool", &library->create_pool) &&
        look_up(handle, "mlrt_destroy_pool", &library->destroy_pool))
        return handle;
    if (handle) dlclose(handle);
    return NULL;
}

#endif
