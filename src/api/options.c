/* SPDX-License-Identifier: MIT */
/* Options of a call, resolved: see options.h. */
#include "api/options.h"

#include "base/message.h"
#include "job/structure.h"
#include "run/dispatch.h"

/* Sides of tiles, in pixels; and in how many parts a tile is split. */
#define RAY_TILE             32 /* method ray: a render stops sooner with small tiles */
#define DEFAULT_MINIMUM_TILE 32
#define DEFAULT_SPLIT_FACTOR 16

/* Checks rules between fields. Only pictures take lights. */
static int32_t check_options(const mlrt_trace_options *options, int is_picture)
{
    const uint32_t split = options->split_factor;
    const char *wrong = NULL;
    if (!is_picture && (options->lights || options->light_count))
        wrong = "only mlrt_render_tiles takes lights";
    else if (options->lights && options->query == MLRT_QUERY_ANY)
        wrong = "given, but query ANY takes no lights";
    else if (!options->lights && options->light_count)
        wrong = "NULL, but light_count is not 0";
    if (wrong) return mlrt_fail(MLRT_ERROR_ARGUMENT, "options.lights: %s", wrong);
    if (split == 0 || split == 4 || split == 16) return MLRT_OK;
    return mlrt_fail(MLRT_ERROR_ARGUMENT, "options.split_factor: %lu is not 0, 4 or 16", (unsigned long)split);
}

/* Sets *size to `given`, or to `standard` if that is 0. A power of two from 4 to `most` is right. Returns a status. */
MLRT_INLINE int32_t resolve_size(const char *field, uint32_t given, uint32_t standard, uint32_t most, uint32_t *size)
{
    *size = given ? given : standard;
    if (MLRT_LIKELY(given == 0) || (!(given & (given - 1)) && given >= 4 && given <= most)) return MLRT_OK;
    return mlrt_fail(MLRT_ERROR_ARGUMENT, "options.%s: %lu is not a power of two from 4 to %lu", field,
                     (unsigned long)given, (unsigned long)most);
}

/* Sets *method to `given` with the default resolved. Returns a status: it must be one of the tree's structure. */
static int32_t resolve_method(int32_t given, const struct mlrt_tree *tree, int32_t *method)
{
    const struct mlrt_structure *structure = tree->structure, *other = &mlrt_structure_kdtree;
    *method = given ? given : structure->tracer.method;
    if (structure->tracer.methods >> *method & 1) return MLRT_OK;
    if (structure == other) other = &mlrt_structure_bvh;
    return mlrt_fail(MLRT_ERROR_UNSUPPORTED, "options.method: %ld is for %s, and the tree is %s", (long)given,
                     other->plural, structure->name);
}

/* The default side of the tiles that threads claim. */
static uint32_t standard_initial_tile(const struct mlrt_job *job)
{
    const struct mlrt_structure *structure = job->tree->structure;
    if (job->method == MLRT_METHOD_RAY) return RAY_TILE;
    if (job->source.kind == MLRT_SOURCE_CAMERA) return structure->tracer.camera_side;
    return mlrt_is_list(&job->source) ? structure->tracer.list_side : structure->tracer.row_side;
}

/* Sets the tree, the query and the masks of a job, whose source is set. Of rays to a light, any hit will do. */
MLRT_INLINE void set_query(const mlrt_tree *tree, const mlrt_trace_options *options, struct mlrt_job *job)
{
    job->tree = tree;
    job->any = options->query == MLRT_QUERY_ANY || mlrt_is_light(&job->source);
    mlrt_set_masks(tree, options->mask, &job->source);
}

int32_t mlrt_resolve_options(const mlrt_tree *tree, const mlrt_trace_options *options, struct mlrt_job *job)
{
    int32_t status = check_options(options, job->source.kind == MLRT_SOURCE_CAMERA);
    if (status == MLRT_OK) status = resolve_method(options->method, tree, &job->method);
    if (status != MLRT_OK) return status;
    job->lights = NULL;
    job->light_count = 0;
    job->callback.function = NULL;
    set_query(tree, options, job);
    job->multilevel.culling = options->culling;
    job->multilevel.culling_check = options->culling_check != 0;
    job->multilevel.shortcuts = ~options->shortcuts_off;
    status = resolve_size("initial_tile_size", options->initial_tile_size, standard_initial_tile(job), 1024,
                          &job->initial_tile_size);
    if (status != MLRT_OK) return status;
    const uint32_t initial = job->initial_tile_size;
    status = resolve_size("minimum_tile_size", options->minimum_tile_size,
                          initial < DEFAULT_MINIMUM_TILE ? initial : DEFAULT_MINIMUM_TILE, initial,
                          &job->multilevel.minimum_tile_size);
    if (status != MLRT_OK) return status;
    const uint32_t split_factor = options->split_factor ? options->split_factor : DEFAULT_SPLIT_FACTOR;
    job->multilevel.split_divisor = split_factor == 4 ? 2 : 4;
    job->callback.outputs = options->outputs;
    job->kernels = mlrt_select_kernels(tree->structure, options->isa, job->method, options->counters != NULL);
    if (job->kernels) return MLRT_OK;
    return mlrt_fail(MLRT_ERROR_UNSUPPORTED, "options.isa: %ld is not in this build, or not on this machine",
                     (long)options->isa);
}

int mlrt_set_plain_options(const mlrt_tree *tree, const mlrt_trace_options *options, struct mlrt_job *job)
{
    const struct mlrt_structure *structure = tree->structure;
    set_query(tree, options, job);
    job->method = structure->tracer.method;
    job->kernels = mlrt_is_known_isa(options->isa) ? mlrt_known_kernels(structure, options->isa) : NULL;
    return job->kernels != NULL;
}
