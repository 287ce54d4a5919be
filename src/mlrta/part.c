/* SPDX-License-Identifier: MIT */
/* Memory of a build of the kd-tree: see part.h. */
#include "mlrta/part.h"

int mlrt_set_room(struct mlrt_kdtree_build *build, struct mlrt_growing_array *array, size_t count, size_t size)
{
    pthread_mutex_lock(&build->memory_mutex);
    void *elements = mlrt_resize(build->memory, array->elements, array->capacity, count, size);
    pthread_mutex_unlock(&build->memory_mutex);
    if (elements == NULL) return 0;
    array->elements = elements;
    array->capacity = count;
    return 1;
}

int mlrt_make_room(struct mlrt_kdtree_build *build, struct mlrt_growing_array *array, size_t needed, size_t size)
{
    const size_t grown = array->capacity + array->capacity / 2;
    return needed <= array->capacity || mlrt_set_room(build, array, needed > grown ? needed : grown, size);
}

void mlrt_release_room(struct mlrt_kdtree_build *build, struct mlrt_growing_array *array, size_t size)
{
    pthread_mutex_lock(&build->memory_mutex);
    mlrt_free(build->memory, array->elements, array->capacity, size);
    pthread_mutex_unlock(&build->memory_mutex);
    array->elements = NULL;
    array->capacity = 0;
}
