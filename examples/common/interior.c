/* SPDX-License-Identifier: MIT */
/* interior.c - is a scene a room, and where in it is a good place for a camera: see interior.h */
#include "interior.h"

#include <mlrt.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

// A grid of points, without those near the box, and rays in all directions from each.
enum { SIDE = 9, POINT_COUNT = SIDE * SIDE * SIDE, DIRECTION_COUNT = 64, RAY_COUNT = POINT_COUNT * DIRECTION_COUNT };

// A point is inside if that part of its rays hit something, and that part of the hits are fronts: inside a solid body,
// all are backs.
static const double HIT_SHARE = 0.95, FRONT_SHARE = 0.5;

// A scene is an interior if that part of the points is inside. Of nine scenes that people published as rooms or as
// objects, rooms had 0.79 to 1, others at most 0.41 (a building with its walls, which is better seen from outside).
static const double INSIDE_SHARE = 0.6;

struct survey {
    float points[POINT_COUNT][3];
    float directions[RAY_COUNT][3]; // the same for each point
    float t[RAY_COUNT];
    int32_t facing[RAY_COUNT];
    double openness[POINT_COUNT]; // how far away surfaces are, on the average of logarithms; -inf = not inside
};

static void place_points(const float minimum[3], const float maximum[3], struct survey *survey)
{
    for (int i = 0; i < POINT_COUNT; i++) {
        const int step[3] = {i % SIDE, i / SIDE % SIDE, i / (SIDE * SIDE)};
        for (int k = 0; k < 3; k++) {
            const double part = 0.1 + 0.8 * step[k] / (SIDE - 1);
            survey->points[i][k] = (float)((1 - part) * minimum[k] + part * maximum[k]);
        }
        for (int j = 0; j < DIRECTION_COUNT; j++) { // a spiral on the sphere
            const double y = 1 - (2 * j + 1.0) / DIRECTION_COUNT, radius = sqrt(1 - y * y),
                         angle = 2.39996323 * j + 0.1;
            float *d = survey->directions[i * DIRECTION_COUNT + j];
            d[0] = (float)(radius * cos(angle)), d[1] = (float)y, d[2] = (float)(radius * sin(angle));
        }
    }
}

static int trace_survey(const mlrt_tree *tree, struct survey *survey)
{
    const mlrt_rays rays = {.struct_size = sizeof rays,
                            .count = RAY_COUNT,
                            .rays_per_origin = DIRECTION_COUNT,
                            .origins = {survey->points, 0},
                            .directions = {survey->directions, 0}};
    const mlrt_hits hits = {.struct_size = sizeof hits, .t = {survey->t, 0, 0}, .facing = {survey->facing, 0, 0}};
    return mlrt_trace_packet(tree, &rays, NULL, &hits) != MLRT_OK;
}

// Returns how many points are inside.
static int judge_points(struct survey *survey)
{
    int inside_count = 0;
    for (int i = 0; i < POINT_COUNT; i++) {
        int hit_count = 0, front_count = 0;
        double sum = 0;
        for (int j = i * DIRECTION_COUNT; j < (i + 1) * DIRECTION_COUNT; j++) {
            if (survey->facing[j] == 0) continue;
            hit_count++;
            front_count += survey->facing[j] < 0;
            sum += log((double)survey->t[j] + 1e-30);
        }
        const int inside = hit_count >= HIT_SHARE * DIRECTION_COUNT && front_count >= FRONT_SHARE * hit_count;
        survey->openness[i] = inside ? sum / hit_count : -INFINITY;
        inside_count += inside;
    }
    return inside_count;
}

static double distance_between(const float a[3], const float b[3])
{
    double sum = 0;
    for (int k = 0; k < 3; k++) sum += ((double)a[k] - b[k]) * ((double)a[k] - b[k]);
    return sqrt(sum);
}

static int sees(const mlrt_tree *tree, const float from[3], const float to[3])
{
    mlrt_ray ray = {.struct_size = sizeof ray, .t_max = 1};
    const mlrt_trace_options any = {.struct_size = sizeof any, .query = MLRT_QUERY_ANY};
    mlrt_hit hit = {.struct_size = sizeof hit};
    for (int k = 0; k < 3; k++) ray.origin[k] = from[k], ray.direction[k] = to[k] - from[k];
    return mlrt_trace_ray(tree, &ray, &any, &hit) == MLRT_OK && !hit.occluded;
}

// y, or z if rooms are clearly flatter that way: they are wider than high.
static int find_up(const float minimum[3], const float maximum[3])
{
    return (double)maximum[2] - minimum[2] < 0.8 * ((double)maximum[1] - minimum[1]) ? 2 : 1;
}

// The eye is the point farthest from the most open one among those at its height and above that see it; the view goes
// towards it, a little downwards, and the light is above it.
static void choose_view_inside(const mlrt_tree *tree, const struct survey *survey, int up, double height,
                               struct view *view)
{
    int centre = 0, eye = -1;
    for (int i = 0; i < POINT_COUNT; i++) centre = survey->openness[i] > survey->openness[centre] ? i : centre;
    const float *middle = survey->points[centre];
    for (int i = 0; i < POINT_COUNT; i++) {
        const float *point = survey->points[i];
        const int level = point[up] >= middle[up] && point[up] <= middle[up] + 0.25 * height;
        if (!level || survey->openness[i] == -INFINITY || !sees(tree, point, middle)) continue;
        if (eye < 0 || distance_between(point, middle) > distance_between(survey->points[eye], middle)) eye = i;
    }
    if (eye < 0 || eye == centre) return;
    for (int k = 0; k < 3; k++) {
        view->eye[k] = survey->points[eye][k];
        view->look[k] = middle[k] - (k == up ? 0.1 * height : 0);
        view->light[k] = middle[k] + (k == up ? 0.1 * height : 0);
        view->up[k] = k == up;
    }
    view->vfov = 65;
}

void look_from_inside(struct scene *scene)
{
    const mlrt_mesh mesh = {.struct_size = sizeof mesh,
                            .vertices = scene->vertices,
                            .vertex_count = scene->vertex_count,
                            .indices = scene->indices,
                            .triangle_count = scene->triangle_count};
    const mlrt_tree_options options = {.struct_size = sizeof options, .preset = MLRT_TREE_FAST};
    struct survey *survey = scene->is_imported ? malloc(sizeof *survey) : NULL;
    mlrt_tree *tree = NULL;
    if (survey && mlrt_build_tree(&mesh, 1, &options, &tree) == MLRT_OK) {
        float minimum[3], maximum[3];
        scene_bounds(scene, minimum, maximum);
        place_points(minimum, maximum, survey);
        if (!trace_survey(tree, survey) && judge_points(survey) >= INSIDE_SHARE * POINT_COUNT) {
            const int up = find_up(minimum, maximum);
            choose_view_inside(tree, survey, up, (double)maximum[up] - minimum[up], &scene->view);
        }
    }
    mlrt_destroy_tree(tree);
    free(survey);
}
