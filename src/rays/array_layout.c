/* SPDX-License-Identifier: MIT */
/* The layouts of a source's arrays: see array_layout.h. */
#include "rays/array_layout.h"

static MLRT_NOINLINE void lay_out_array(const mlrt_const_array *array, uint32_t group, size_t row_length,
                                        struct mlrt_array_layout *layout)
{
    layout->data = array->data;
    layout->stride = array->data ? array->stride : 0;
    layout->step = group > 1 ? 0 : layout->stride;
    layout->row_step = layout->step * row_length;
    layout->has_word = 0;
}

/*
 * Is the word behind each element of `array`, which takes twelve bytes, the start of an element of `other`? With a
 * stride of 12 that word would belong to the next element of `array`.
 */
static MLRT_NOINLINE int is_followed_by(const struct mlrt_array_layout *array, const struct mlrt_array_layout *other)
{
    return array->data && other->data == array->data + 12 && array->stride > 12 && array->stride == other->stride &&
           array->step == other->step;
}

int mlrt_begin_reading(const struct mlrt_source *source, struct mlrt_array_reader *reader)
{
    const uint32_t group = source->arrays.rays_per_origin;
    const int is_rays = source->kind == MLRT_SOURCE_RAYS;
    const mlrt_const_array light = {source->light, 0}; /* of a directional light: the direction of all rays */
    if (source->kind == MLRT_SOURCE_CAMERA || (group > 1 && group % MLRT_PACKET_RAYS != 0)) return 0;
    reader->source = source;
    lay_out_array(&source->arrays.points, group, source->width, &reader->points);
    lay_out_array(&source->arrays.skip, group, source->width, &reader->skip);
    lay_out_array(&source->arrays.t_min, group, source->width, &reader->t_min);
    lay_out_array(is_rays ? &source->arrays.directions : &light, 1, source->width, &reader->directions);
    lay_out_array(&source->arrays.t_max, 1, source->width, &reader->t_max);
    reader->points_have_t_min = is_followed_by(&reader->points, &reader->t_min);
    reader->directions_have_t_max = is_followed_by(&reader->directions, &reader->t_max);
    reader->points.has_word = reader->points_have_t_min || is_followed_by(&reader->points, &reader->t_max) ||
                              is_followed_by(&reader->points, &reader->directions) ||
                              is_followed_by(&reader->points, &reader->skip);
    reader->directions.has_word =
        reader->directions_have_t_max || is_followed_by(&reader->directions, &reader->t_min) ||
        is_followed_by(&reader->directions, &reader->points) || is_followed_by(&reader->directions, &reader->skip);
    reader->are_structs = reader->points.has_word && reader->directions.has_word &&
                          reader->directions.data == reader->points.data + 16 &&
                          reader->directions.step == reader->points.step;
    return 1;
}
