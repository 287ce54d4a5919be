/* SPDX-License-Identifier: MIT */
/* loaded_library.c - a build of the library, loaded: see loaded_library.h */
#include "loaded_library.h"

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>

const struct library this_library = {NULL,
                                     mlrt_create_pool,
                                     mlrt_destroy_pool,
                                     mlrt_build_tree,
                                     mlrt_build_kdtree,
                                     mlrt_save_tree,
                                     mlrt_destroy_tree,
                                     mlrt_trace_ray,
                                     mlrt_trace_packet,
                                     mlrt_render_tiles,
                                     mlrt_occluded_points};

// A cast from void * to a function pointer is POSIX's, not C's: copying the bits says the same.
static int find_function(void *handle, const char *name, void *function)
{
    void *symbol = dlsym(handle, name);
    if (!symbol) fprintf(stderr, "%s\n", dlerror());
    memcpy(function, &symbol, sizeof symbol);
    return !symbol;
}

int load_library(const char *path, struct library *library)
{
    char in_folder[4096]; // a name without a folder would be looked for where the system has its libraries
    snprintf(in_folder, sizeof in_folder, "%s%s", strchr(path, '/') ? "" : "./", path);
    memset(library, 0, sizeof *library);
    library->handle = dlopen(in_folder, RTLD_NOW | RTLD_LOCAL);
    if (!library->handle) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    int failed = find_function(library->handle, "mlrt_create_pool", &library->create_pool);
    failed |= find_function(library->handle, "mlrt_destroy_pool", &library->destroy_pool);
    failed |= find_function(library->handle, "mlrt_build_kdtree", &library->build_kdtree);
    if (dlsym(library->handle, "mlrt_build_tree")) {
        failed |= find_function(library->handle, "mlrt_build_tree", &library->build_tree);
    }
    if (dlsym(library->handle, "mlrt_save_tree")) {
        failed |= find_function(library->handle, "mlrt_save_tree", &library->save_tree);
    }
    failed |= find_function(library->handle, "mlrt_destroy_tree", &library->destroy_tree);
    failed |= find_function(library->handle, "mlrt_trace_ray", &library->trace_ray);
    failed |= find_function(library->handle, "mlrt_trace_packet", &library->trace_packet);
    failed |= find_function(library->handle, "mlrt_render_tiles", &library->render_tiles);
    failed |= find_function(library->handle, "mlrt_occluded_points", &library->occluded_points);
    if (failed) close_library(library);
    return failed;
}

void close_library(struct library *library)
{
    if (library->handle) dlclose(library->handle);
    memset(library, 0, sizeof *library);
}
