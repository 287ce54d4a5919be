/* SPDX-License-Identifier: MIT */
/* view.h - from a look-at view to the library's camera, and views from JSON files */
#ifndef VIEW_H
#define VIEW_H

#include "scene.h"

#include <mlrt.h>

/*
 * The camera of a picture of `width` x `height` square pixels, its rays through the middle of each, row 0 at the top.
 * Computed in double and rounded once. Returns 0, or 1 after a message on stderr, for example if eye and look are the
 * same point.
 */
int camera_of_view(const struct view *view, uint32_t width, uint32_t height, mlrt_camera *camera);

/* Its light, rounded to float. */
mlrt_light light_of_view(const struct view *view);

/*
 * Reads a view from "FILE.json:SCENE/VIEW", or the scene's first one from "FILE.json:SCENE". Returns 0, or 1 after a
 * message on stderr. The file is an object of scenes; each is a list of views or a string "same views as SCENE":
 *
 *     {"hall": [{"name": "view1", "eye": [0, 2, 5], "look": [0, 1, 0], "up": [0, 1, 0], "vfov": 45,
 *                "light": [3, 4, 5]}]}
 *
 * where "dir" (a direction of any length) may stand for "look". Without "up" it is +y, without "light" the light is at
 * the eye.
 */
int read_view(const char *specification, struct view *view);

enum { SCENE_NAME_SIZE = 64 };

/*
 * Loads the scene that a word of a list names, which ends at a comma or at its 0. Its name becomes that of the file,
 * without folder and extension. If it is a file and `views` is not NULL, its view is the first one that the file
 * `views` has for that name. Returns as load_scene does.
 */
int load_scene_and_view(const char *word, const char *views, char name[SCENE_NAME_SIZE], struct scene *scene);

#endif
