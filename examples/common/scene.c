/* SPDX-License-Identifier: MIT */
/* scene.c - loads a scene by its name, procedural or a file: see scene.h */
#include "scene.h"

#include "import.h"
#include "procedural.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DEFAULT_SCAN = 1000000, SMALLEST_SCAN = 1000, LARGEST_SCAN = 16000000 };

void scene_bounds(const struct scene *scene, float minimum[3], float maximum[3])
{
    for (int k = 0; k < 3; k++) minimum[k] = INFINITY, maximum[k] = -INFINITY;
    for (size_t i = 0; i < 3 * scene->triangle_count; i++) {
        const float *p = scene->vertices + 3 * (size_t)scene->indices[i];
        if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2])) continue;
        for (int k = 0; k < 3; k++) {
            if (p[k] < minimum[k]) minimum[k] = p[k];
            if (p[k] > maximum[k]) maximum[k] = p[k];
        }
    }
    for (int k = 0; k < 3; k++) {
        if (minimum[k] > maximum[k]) minimum[k] = maximum[k] = 0;
    }
}

// The whole scene from the front, a little from above, lit from over the viewer's left shoulder.
static void look_at_all(struct scene *scene)
{
    static const double from[3] = {0.35, 0.3, 1.0}, lit_from[3] = {-0.6, 1.1, 1.2};
    float minimum[3], maximum[3];
    scene_bounds(scene, minimum, maximum);
    double diagonal = 0;
    for (int k = 0; k < 3; k++) diagonal += ((double)maximum[k] - minimum[k]) * ((double)maximum[k] - minimum[k]);
    diagonal = diagonal > 0 ? sqrt(diagonal) : 1;
    struct view *view = &scene->view;
    for (int k = 0; k < 3; k++) {
        view->look[k] = 0.5 * minimum[k] + 0.5 * maximum[k];
        view->eye[k] = view->look[k] + 1.15 * diagonal * from[k];
        view->light[k] = view->look[k] + 1.3 * diagonal * lit_from[k];
        view->up[k] = k == 1;
    }
    view->vfov = 40;
}

// Reads "scan" or "scan:N". 0 = it is neither, -1 = N makes no sense.
static long scan_size(const char *name)
{
    if (strcmp(name, "scan") == 0) return DEFAULT_SCAN;
    if (strncmp(name, "scan:", 5) != 0) return 0;
    char *end;
    long size = strtol(name + 5, &end, 10);
    return end == name + 5 || *end || size < SMALLEST_SCAN || size > LARGEST_SCAN ? -1 : size;
}

static int make_scene(const char *name, struct shapes *shapes)
{
    static const struct {
        const char *name;
        void (*make)(struct shapes *shapes);
    } scenes[] = {{"room", make_room}, {"office", make_office}, {"building", make_building}, {"doubled", make_doubled}};
    long size = scan_size(name);
    if (size < 0) return -1;
    if (size > 0) {
        make_scan(shapes, (uint32_t)size);
        return 1;
    }
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        if (strcmp(name, scenes[i].name) != 0) continue;
        scenes[i].make(shapes);
        return 1;
    }
    return 0;
}

int load_scene(const char *name_or_path, struct scene *scene)
{
    memset(scene, 0, sizeof *scene);
    struct shapes shapes = {scene, 0, 0, 0, 0};
    int made = make_scene(name_or_path, &shapes);
    if (made < 0) {
        fprintf(stderr, "%s: N of scan:N is a number of triangles, %d to %d\n", name_or_path, SMALLEST_SCAN,
                LARGEST_SCAN);
        return 1;
    }
    if (shapes.failed) {
        fprintf(stderr, "%s: not enough memory for this scene\n", name_or_path);
        free_scene(scene);
        return 1;
    }
    if (made) return 0;
    if (import_mesh(name_or_path, scene)) {
        free_scene(scene);
        return 1;
    }
    look_at_all(scene);
    scene->is_imported = 1;
    return 0;
}

void free_scene(struct scene *scene)
{
    free(scene->vertices);
    free(scene->indices);
    free(scene->material_ids);
    memset(scene, 0, sizeof *scene);
}
