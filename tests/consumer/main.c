/* SPDX-License-Identifier: MIT */
/* A program outside the tree: one triangle, two threads, one ray, and whether header and library are of one version. */
#include <mlrt.h>
#include <stdio.h>

int main(void)
{
    const float corners[9] = {0, 0, 5, 1, 0, 5, 0, 1, 5};
    mlrt_mesh mesh = {.struct_size = sizeof mesh, .vertices = corners, .vertex_count = 3, .triangle_count = 1};
    mlrt_pool *pool = NULL;
    mlrt_tree *tree = NULL;
    mlrt_ray ray = {.struct_size = sizeof ray, .origin = {0.25f, 0.25f, 0}, .direction = {0, 0, 1}};
    mlrt_hit hit = {.struct_size = sizeof hit};
    int32_t status = mlrt_create_pool(2, &pool);
    mlrt_tree_options options = {.struct_size = sizeof options, .pool = pool};
    if (status == MLRT_OK) status = mlrt_build_tree(&mesh, 1, &options, &tree);
    if (status == MLRT_OK) status = mlrt_trace_ray(tree, &ray, NULL, &hit);
    mlrt_destroy_tree(tree);
    mlrt_destroy_pool(pool);
    printf("%s: t = %g, version %u\n", mlrt_status_string(status), (double)hit.t, (unsigned)mlrt_version());
    return status != MLRT_OK || hit.t != 5.0f ||
           mlrt_version() != MLRT_VERSION_MAJOR * 10000 + MLRT_VERSION_MINOR * 100 + MLRT_VERSION_PATCH;
}
