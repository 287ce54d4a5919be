/* SPDX-License-Identifier: MIT */
/* view.c - views, and the library's camera: see view.h */
#include "view.h"

#include "interior.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static void cross(const double a[3], const double b[3], double result[3])
{
    result[0] = a[1] * b[2] - a[2] * b[1];
    result[1] = a[2] * b[0] - a[0] * b[2];
    result[2] = a[0] * b[1] - a[1] * b[0];
}

static int normalize(double v[3])
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; k++) v[k] /= length;
    return length > 0 && isfinite(length);
}

int camera_of_view(const struct view *view, uint32_t width, uint32_t height, mlrt_camera *camera)
{
    double forward[3], right[3], up[3];
    for (int k = 0; k < 3; k++) forward[k] = view->look[k] - view->eye[k];
    int good = normalize(forward);
    cross(forward, view->up, right);
    good = good && normalize(right);
    cross(right, forward, up);
    if (!good || !(view->vfov > 0 && view->vfov < 180) || !width || !height) {
        fprintf(stderr,
                "the view shows nothing: eye and look must differ, up must point elsewhere, and the field of view be "
                "between 0 and 180 degrees\n");
        return 1;
    }
    // The picture is on the plane one unit ahead; a pixel on it is this long.
    double pixel = 2 * tan(view->vfov * (3.14159265358979323846 / 360)) / height;
    memset(camera, 0, sizeof *camera);
    camera->struct_size = sizeof *camera;
    camera->projection = MLRT_PROJECTION_PINHOLE;
    camera->width = width;
    camera->height = height;
    camera->sample_x = camera->sample_y = 0.5f;
    for (int k = 0; k < 3; k++) {
        camera->eye[k] = (float)view->eye[k];
        camera->d00[k] = (float)(forward[k] + pixel * (0.5 * height * up[k] - 0.5 * width * right[k]));
        camera->dx[k] = (float)(pixel * right[k]);
        camera->dy[k] = (float)(-pixel * up[k]);
    }
    return 0;
}

mlrt_light light_of_view(const struct view *view)
{
    mlrt_light light = {.struct_size = sizeof light, .kind = MLRT_LIGHT_POINT};
    for (int k = 0; k < 3; k++) light.position[k] = (float)view->light[k];
    return light;
}

int load_scene_and_view(const char *word, const char *views, char name[SCENE_NAME_SIZE], struct scene *scene)
{
    enum { PATH_SIZE = 4096 };
    char path[PATH_SIZE], view[PATH_SIZE + SCENE_NAME_SIZE + 2];
    snprintf(path, sizeof path, "%.*s", (int)strcspn(word, ","), word);
    if (load_scene(path, scene)) return 1;
    const char *file = strrchr(path, '/') ? strrchr(path, '/') + 1 : path;
    const char *dot = strrchr(file, '.');
    snprintf(name, SCENE_NAME_SIZE, "%.*s", dot ? (int)(dot - file) : SCENE_NAME_SIZE, file);
    if (!views) look_from_inside(scene);
    if (!views || !scene->is_imported) return 0;
    snprintf(view, sizeof view, "%.*s:%s", PATH_SIZE - 1, views, name);
    return read_view(view, &scene->view);
}
