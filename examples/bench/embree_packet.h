/* SPDX-License-Identifier: MIT */
/*
 * embree_packet.h - the loops around one of Embree's calls for packets, included once for each width
 *
 * Before: WIDTH, SIDE_X and SIDE_Y (the pixels of a packet), QUERY and OCCLUSION (the structs), INTERSECT(valid, scene,
 * context, query) and OCCLUDED(...), LANE(field, i), and NAME(word). What Embree leaves as it was is set once per loop.
 */

static void NAME(start_ray)(struct NAME_RAY *ray, const float origin[3])
{
    for (int i = 0; i < WIDTH; i++) {
        LANE(ray->org_x, i) = origin[0], LANE(ray->org_y, i) = origin[1], LANE(ray->org_z, i) = origin[2];
        LANE(ray->tnear, i) = 0, LANE(ray->time, i) = 0;
        LANE(ray->mask, i) = 0xFFFFFFFFu, LANE(ray->id, i) = 0, LANE(ray->flags, i) = 0;
    }
}

static inline void NAME(start_query)(struct QUERY *query, float t_max)
{
    for (int i = 0; i < WIDTH; i++) {
        LANE(query->ray.tfar, i) = t_max;
        LANE(query->hit.geomID, i) = RTC_INVALID_GEOMETRY_ID;
        LANE(query->hit.instID[0], i) = RTC_INVALID_GEOMETRY_ID;
    }
}

/* ---- pictures -----------------------------------------------------------------------------------------------------
 */

static inline void NAME(aim)(const struct picture *picture, const mlrt_camera *camera, uint32_t column, uint32_t row,
                             struct NAME_RAY *ray)
{
    for (int i = 0; i < WIDTH; i++) {
        const float x = (float)((int32_t)column + picture->lane_columns[i]) + camera->sample_x;
        const float y = (float)((int32_t)row + picture->lane_rows[i]) + camera->sample_y;
        LANE(ray->dir_x, i) = (camera->d00[0] + x * camera->dx[0]) + y * camera->dy[0];
        LANE(ray->dir_y, i) = (camera->d00[1] + x * camera->dx[1]) + y * camera->dy[1];
        LANE(ray->dir_z, i) = (camera->d00[2] + x * camera->dx[2]) + y * camera->dy[2];
    }
}

// The geometry is 0 or, for a miss, all ones.
static inline void NAME(read_triangles)(const struct QUERY *query, uint32_t *triangles)
{
    for (int i = 0; i < WIDTH; i++) triangles[i] = LANE(query->hit.geomID, i) | LANE(query->hit.primID, i);
}

// By Embree's own normals, whose length is twice the area of the triangle.
static inline void NAME(shade_by_own)(const struct QUERY *query, uint32_t *rgba)
{
    for (int i = 0; i < WIDTH; i++) {
        const float x = LANE(query->ray.dir_x, i), y = LANE(query->ray.dir_y, i), z = LANE(query->ray.dir_z, i);
        const float a = LANE(query->hit.Ng_x, i), b = LANE(query->hit.Ng_y, i), c = LANE(query->hit.Ng_z, i);
        const float product = fabsf(x * a + y * b + z * c);
        const float level = 255 * product / sqrtf((x * x + y * y + z * z) * (a * a + b * b + c * c));
        const int hit = LANE(query->hit.geomID, i) != RTC_INVALID_GEOMETRY_ID;
        rgba[i] = opaque_grey(hit ? level : BACKGROUND_LEVEL);
    }
}

static inline void NAME(shade_by_table)(const struct picture *picture, const struct QUERY *query, uint32_t *rgba)
{
    float n[4][SHADE_LANES];
    uint32_t triangles[SHADE_LANES] = {0};
    NAME(read_triangles)(query, triangles);
    gather_normals(picture->normals, picture->triangle_count, triangles, n);
    for (int i = 0; i < WIDTH; i++) {
        const struct normal normal = {{n[0][i], n[1][i], n[2][i]}, n[3][i]};
        rgba[i] =
            grey_by_angle(LANE(query->ray.dir_x, i), LANE(query->ray.dir_y, i), LANE(query->ray.dir_z, i), &normal);
    }
}

static inline void NAME(store_block)(const uint32_t *block, uint32_t pitch, uint32_t *pixels)
{
    for (int j = 0; j < SIDE_Y; j++) memcpy(pixels + (size_t)j * pitch, block + j * SIDE_X, SIDE_X * sizeof *block);
}

static inline void NAME(trace_block)(const struct picture *picture, const mlrt_camera *camera,
                                     struct RTCIntersectContext *context, struct QUERY *query, uint32_t column,
                                     uint32_t row)
{
    uint32_t block[WIDTH];
    const uint32_t pitch = camera->width;
    const size_t pixel = (size_t)row * pitch + column;
    NAME(aim)(picture, camera, column, row, &query->ray);
    NAME(start_query)(query, INFINITY);
    INTERSECT(all_valid, picture->scene, context, query);
    if (!picture->rgba)
        NAME(read_triangles)(query, block);
    else if (picture->own_normals)
        NAME(shade_by_own)(query, block);
    else
        NAME(shade_by_table)(picture, query, block);
    NAME(store_block)(block, pitch, (picture->rgba ? picture->rgba : picture->triangles) + pixel);
}

// Copies of the camera and the picture, so that compilers see that stores leave them alone. The query is kept away from
// Embree's own part of the stack: where the two were equal modulo the page size, erw6 took 4 % longer.
static void NAME(trace_picture)(const struct picture *shared, uint32_t column, uint32_t row)
{
    struct picture picture = *shared;
    const mlrt_camera camera = *shared->camera;
    struct RTCIntersectContext context;
    RTC_ALIGN(64) struct {
        char distance[HALF_PAGE];
        struct QUERY query;
        char more_distance[HALF_PAGE];
    } apart;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    memset(&apart.query, 0, sizeof apart.query);
    NAME(start_ray)(&apart.query.ray, camera.eye);
    memcpy(picture.lane_columns, all_lane_columns[SIDE_X], sizeof picture.lane_columns);
    memcpy(picture.lane_rows, all_lane_rows[SIDE_X], sizeof picture.lane_rows);
    for (uint32_t j = 0; j < TILE_SIDE; j += SIDE_Y) {
        for (uint32_t i = 0; i < TILE_SIDE; i += SIDE_X) {
            NAME(trace_block)(&picture, &camera, &context, &apart.query, column + i, row + j);
        }
    }
}

/* ---- streams ------------------------------------------------------------------------------------------------------
 */

// What all rays of a stream have in common, as far as it is.
static void NAME(start_stream)(const struct stream *stream, struct NAME_RAY *ray)
{
    NAME(start_ray)(ray, stream->origin);
    for (int i = 0; i < WIDTH; i++) {
        LANE(ray->dir_x, i) = stream->direction[0], LANE(ray->dir_y, i) = stream->direction[1];
        LANE(ray->dir_z, i) = stream->direction[2], LANE(ray->tnear, i) = stream->t_min;
    }
}

static inline void NAME(read_rays)(const struct stream *stream, size_t first, struct NAME_RAY *ray)
{
    for (int i = 0; stream->directions[0] && i < WIDTH; i++) {
        LANE(ray->dir_x, i) = stream->directions[0][first + (size_t)i];
        LANE(ray->dir_y, i) = stream->directions[1][first + (size_t)i];
        LANE(ray->dir_z, i) = stream->directions[2][first + (size_t)i];
    }
    if (!stream->origins[0]) return;
    for (int i = 0; i < WIDTH; i++) {
        LANE(ray->org_x, i) = stream->origins[0][first + (size_t)i];
        LANE(ray->org_y, i) = stream->origins[1][first + (size_t)i];
        LANE(ray->org_z, i) = stream->origins[2][first + (size_t)i];
    }
}

static void NAME(trace_closest)(const struct batch *batch, size_t first, size_t end)
{
    struct RTCIntersectContext context = batch->context;
    RTC_ALIGN(64) struct QUERY query;
    memset(&query, 0, sizeof query);
    NAME(start_stream)(batch->stream, &query.ray);
    for (; first < end; first += WIDTH) {
        NAME(read_rays)(batch->stream, first, &query.ray);
        NAME(start_query)(&query, batch->stream->t_max);
        INTERSECT(all_valid, batch->scene, &context, &query);
        NAME(read_triangles)(&query, batch->answers->triangles + first);
        for (int i = 0; i < WIDTH; i++) batch->answers->t[first + (size_t)i] = LANE(query.ray.tfar, i);
    }
}

static void NAME(trace_any)(const struct batch *batch, size_t first, size_t end)
{
    struct RTCIntersectContext context = batch->context;
    RTC_ALIGN(64) struct NAME_RAY ray;
    memset(&ray, 0, sizeof ray);
    NAME(start_stream)(batch->stream, &ray);
    for (; first < end; first += WIDTH) {
        NAME(read_rays)(batch->stream, first, &ray);
        for (int i = 0; i < WIDTH; i++) LANE(ray.tfar, i) = batch->stream->t_max;
        OCCLUDED(all_valid, batch->scene, &context, &ray);
        for (int i = 0; i < WIDTH; i++) batch->answers->occluded[first + (size_t)i] = LANE(ray.tfar, i) < 0;
    }
}

#undef WIDTH
#undef SIDE_X
#undef SIDE_Y
#undef QUERY
#undef NAME_RAY
#undef INTERSECT
#undef OCCLUDED
#undef LANE
#undef NAME
