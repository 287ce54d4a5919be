#include <mlrt.h>
#include <stdio.h>
int main(void)
{
    const float corners[9] = {0, 0, 5, 1, 0, 5, 0, 1, 5};
    mlrt_mesh mesh = {sizeof mesh, 0, corners, 3, 0, NULL, 1, 0, 0, 0};
    mlrt_tree *tree = NULL;
    int32_t status = mlrt_build_tree(&mesh, 1, NULL, &tree);
    mlrt_ray ray = {.struct_size = sizeof ray, .origin = {0.25f, 0.25f, 0}, .direction = {0, 0, 1}};
    mlrt_hit hit = {.struct_size = sizeof hit};
    if (status == MLRT_OK) status = mlrt_trace_ray(tree, &ray, NULL, &hit);
    printf("%s: t = %g, triangle %u\n", mlrt_status_string(status), (double)hit.t, (unsigned)hit.triangle);
    mlrt_destroy_tree(tree);
    return status != MLRT_OK;
}
