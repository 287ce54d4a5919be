/* SPDX-License-Identifier: MIT */
/*
 * embree_packet.h - the loops around one of Embree's calls for packets, included once for each width
 *
 * The including file defines WIDTH, SIDE_X and SIDE_Y (the pixels of a packet), QUERY and OCCLUSION (the structs),
 * INTERSECT(valid, scene, context, query) and OCCLUDED(...), LANE(field, i), and NAME(word). Fields that Embree does
 * not change are set once per loop.
 */

static void NAME(start_ray)(struct NAME_RAY *ray, const float origin[3])
{
    for (int i = 0; i < WIDTH; i++) {
        LANE(ray->org_x, i) = origin[0], LANE(ray->org_y, i) = origin[1], LANE(ray->org_z, i) = origin[2];
        LANE(ray->tnear, i) = 0, LANE(ray->time, i) = 0;
        LANE(ray->mask, i) = 0xFFFFFFFFu, LANE(ray->id, i) = 0, LANE(ray->flags, i) = 0;
    }
}

static inline void NAME(start_hit)(struct QUERY *query)
{
    for (int i = 0; i < WIDTH; i++) {
        LANE(query->hit.geomID, i) = RTC_INVALID_GEOMETRY_ID;
        LANE(query->hit.instID[0], i) = RTC_INVALID_GEOMETRY_ID;
    }
}

static inline void NAME(start_query)(struct QUERY *query, float t_max)
{
    for (int i = 0; i < WIDTH; i++) LANE(query->ray.tfar, i) = t_max;
    NAME(start_hit)(query);
}

/* ---- pictures ------------------------------------------------------------------------------------------------ */

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

static inline void NAME(read_block)(const struct picture *picture, const struct QUERY *query, uint32_t *block)
{
    if (!picture->rgba)
        NAME(read_triangles)(query, block);
    else if (picture->own_normals)
        NAME(shade_by_own)(query, block);
    else
        NAME(shade_by_table)(picture, query, block);
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
    NAME(read_block)(picture, query, block);
    NAME(store_block)(block, pitch, (picture->rgba ? picture->rgba : picture->triangles) + pixel);
}

static inline void NAME(start_picture)(const mlrt_camera *camera, struct picture *picture,
                                       struct RTCIntersectContext *context, struct QUERY *query)
{
    rtcInitIntersectContext(context);
    context->flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    memset(query, 0, sizeof *query);
    NAME(start_ray)(&query->ray, camera->eye);
    memcpy(picture->lane_columns, all_lane_columns[SIDE_X], sizeof picture->lane_columns);
    memcpy(picture->lane_rows, all_lane_rows[SIDE_X], sizeof picture->lane_rows);
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
    NAME(start_picture)(&camera, &picture, &context, &apart.query);
    for (uint32_t j = 0; j < TILE_SIDE; j += SIDE_Y) {
        for (uint32_t i = 0; i < TILE_SIDE; i += SIDE_X) {
            NAME(trace_block)(&picture, &camera, &context, &apart.query, column + i, row + j);
        }
    }
}

/* ---- lit pictures -------------------------------------------------------------------------------------------- */

// The rays from the light to the hits, but for those on triangles whose plane is between light and eye: they are dark.
// Returns 0 if there is no other. Rays from the hits to the light, with origins of their own, had 0.96 to 1.01 of the
// speed (erw6, conference_mgf, clinic_bim, cruiser_mgf, sponza_dabrovic, dragon, building). The others end before they
// begin, too: where 16 rays are more than the processor is wide, Embree takes them as a stream, and does not look at
// `valid`.
static inline int NAME(aim_at_light)(const struct picture *picture, const mlrt_camera *camera,
                                     const struct QUERY *query, int *valid, struct NAME_RAY *ray)
{
    const float ex = camera->eye[0] - picture->light[0], ey = camera->eye[1] - picture->light[1];
    const float ez = camera->eye[2] - picture->light[2];
    int some = 0;
    for (int i = 0; i < WIDTH; i++) {
        const float dx = LANE(query->ray.dir_x, i), dy = LANE(query->ray.dir_y, i), dz = LANE(query->ray.dir_z, i);
        const float nx = LANE(query->hit.Ng_x, i), ny = LANE(query->hit.Ng_y, i), nz = LANE(query->hit.Ng_z, i);
        const float t = LANE(query->ray.tfar, i);
        const float x = ex + t * dx, y = ey + t * dy, z = ez + t * dz;
        const float of_eye = dx * nx + dy * ny + dz * nz, of_light = x * nx + y * ny + z * nz;
        const int faces = (of_eye < 0) == (of_light < 0) && of_light != 0;
        valid[i] = -(faces & (LANE(query->hit.geomID, i) != RTC_INVALID_GEOMETRY_ID));
        some |= valid[i];
        LANE(ray->dir_x, i) = x, LANE(ray->dir_y, i) = y, LANE(ray->dir_z, i) = z;
        LANE(ray->tfar, i) = valid[i] ? SHADOW_END : -1;
    }
    return some;
}

// 1 for hits that the light does not reach.
static inline void NAME(find_dark)(const struct QUERY *query, const int *valid, const struct NAME_RAY *ray,
                                   uint32_t *dark)
{
    for (int i = 0; i < WIDTH; i++) {
        const int is_hit = LANE(query->hit.geomID, i) != RTC_INVALID_GEOMETRY_ID;
        dark[i] = (uint32_t)(is_hit & ((valid[i] == 0) | (LANE(ray->tfar, i) < 0)));
    }
}

static inline void NAME(store_dark)(const uint32_t *dark, uint32_t pitch, uint8_t *occluded)
{
    for (int i = 0; i < WIDTH; i++) occluded[(size_t)(i / SIDE_X) * pitch + (size_t)(i % SIDE_X)] = (uint8_t)dark[i];
}

// Shaded between the two calls, while what that needs is at hand.
static inline void NAME(trace_lit_block)(const struct picture *picture, const mlrt_camera *camera,
                                         struct RTCIntersectContext *context, struct QUERY *query, struct NAME_RAY *ray,
                                         uint32_t column, uint32_t row)
{
    RTC_ALIGN(64) int valid[WIDTH];
    uint32_t block[WIDTH], dark[WIDTH];
    const uint32_t pitch = camera->width;
    const size_t pixel = (size_t)row * pitch + column;
    NAME(aim)(picture, camera, column, row, &query->ray);
    NAME(start_query)(query, INFINITY);
    INTERSECT(all_valid, picture->scene, context, query);
    NAME(read_block)(picture, query, block);
    if (NAME(aim_at_light)(picture, camera, query, valid, ray)) OCCLUDED(valid, picture->scene, context, ray);
    NAME(find_dark)(query, valid, ray, dark);
    for (int i = 0; i < WIDTH && picture->rgba; i++) block[i] = darken(block[i], dark[i]);
    NAME(store_block)(block, pitch, (picture->rgba ? picture->rgba : picture->triangles) + pixel);
    if (!picture->rgba) NAME(store_dark)(dark, pitch, picture->occluded + pixel);
}

static void NAME(trace_lit)(const struct picture *shared, uint32_t column, uint32_t row)
{
    struct picture picture = *shared;
    const mlrt_camera camera = *shared->camera;
    struct RTCIntersectContext context;
    RTC_ALIGN(64) struct {
        char distance[HALF_PAGE];
        struct QUERY query;
        struct NAME_RAY ray;
        char more_distance[HALF_PAGE];
    } apart;
    NAME(start_picture)(&camera, &picture, &context, &apart.query);
    memset(&apart.ray, 0, sizeof apart.ray);
    NAME(start_ray)(&apart.ray, picture.light);
    for (uint32_t j = 0; j < TILE_SIDE; j += SIDE_Y) {
        for (uint32_t i = 0; i < TILE_SIDE; i += SIDE_X) {
            NAME(trace_lit_block)(&picture, &camera, &context, &apart.query, &apart.ray, column + i, row + j);
        }
    }
}

/* ---- streams ------------------------------------------------------------------------------------------------- */

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
    for (int i = 0; stream->origins[0] && i < WIDTH; i++) {
        LANE(ray->org_x, i) = stream->origins[0][first + (size_t)i];
        LANE(ray->org_y, i) = stream->origins[1][first + (size_t)i];
        LANE(ray->org_z, i) = stream->origins[2][first + (size_t)i];
    }
    for (int i = 0; stream->t_mins && i < WIDTH; i++) LANE(ray->tnear, i) = stream->t_mins[first + (size_t)i];
    for (int i = 0; i < WIDTH; i++) {
        LANE(ray->tfar, i) = stream->t_maxes ? stream->t_maxes[first + (size_t)i] : stream->t_max;
    }
}

// The triangles, distances, and what else is asked for.
static inline void NAME(store_hits)(const struct QUERY *query, const struct answers *answers, size_t first)
{
    NAME(read_triangles)(query, answers->triangles + first);
    for (int i = 0; i < WIDTH; i++) answers->t[first + (size_t)i] = LANE(query->ray.tfar, i);
    if (!answers->u) return;
    for (int i = 0; i < WIDTH; i++) {
        answers->u[first + (size_t)i] = LANE(query->hit.u, i);
        answers->v[first + (size_t)i] = LANE(query->hit.v, i);
        answers->mesh[first + (size_t)i] = LANE(query->hit.geomID, i);
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
        NAME(start_hit)(&query);
        INTERSECT(all_valid, batch->scene, &context, &query);
        NAME(store_hits)(&query, batch->answers, first);
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
