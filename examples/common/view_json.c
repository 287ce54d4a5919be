/* SPDX-License-Identifier: MIT */
/* view_json.c - views from JSON files, through cJSON: see view.h. Built without cJSON, it reports that on stderr. */
#include "view.h"

#include <stdio.h>

#ifdef HAVE_CJSON

#include "file.h"

#include <cJSON.h>

#include <errno.h>
#include <stdlib.h>
#include <string.h>

enum { MAXIMUM_FILE_SIZE = 16 << 20 };

static char *read_text(const char *path)
{
    const char *problem = find_input_problem(path);
    FILE *file = problem ? NULL : fopen(path, "rb");
    char *text = NULL;
    long size = -1;
    if (file && fseek(file, 0, SEEK_END) == 0) size = ftell(file);
    if (size < 0) {
        fprintf(stderr, "%s: %s\n", path, problem ? problem : strerror(errno));
    } else if (size > MAXIMUM_FILE_SIZE) {
        fprintf(stderr, "%s: too large for a file of views\n", path);
    } else {
        rewind(file);
        text = malloc((size_t)size + 1);
        const size_t count = text ? fread(text, 1, (size_t)size, file) : 0;
        if (!text) {
            fprintf(stderr, "%s: not enough memory\n", path);
        } else if (count != (size_t)size || memchr(text, 0, count)) {
            fprintf(stderr, "%s: not a text that can be read to its end\n", path);
            free(text);
            text = NULL;
        } else {
            text[count] = 0;
        }
    }
    if (file) fclose(file);
    return text;
}

static int read_vector(const cJSON *object, const char *key, double vector[3])
{
    const cJSON *array = cJSON_GetObjectItemCaseSensitive(object, key);
    if (!cJSON_IsArray(array) || cJSON_GetArraySize(array) != 3) return 0;
    for (int k = 0; k < 3; k++) {
        const cJSON *number = cJSON_GetArrayItem(array, k);
        if (!cJSON_IsNumber(number)) return 0;
        vector[k] = number->valuedouble;
    }
    return 1;
}

// NULL, or what is missing.
static const char *read_entry(const cJSON *entry, struct view *view)
{
    static const double y_axis[3] = {0, 1, 0};
    double direction[3];
    if (!read_vector(entry, "eye", view->eye)) return "\"eye\": three numbers";
    if (read_vector(entry, "dir", direction)) {
        for (int k = 0; k < 3; k++) view->look[k] = view->eye[k] + direction[k];
    } else if (!read_vector(entry, "look", view->look)) {
        return "\"look\" or \"dir\": three numbers";
    }
    if (!read_vector(entry, "up", view->up)) memcpy(view->up, y_axis, sizeof view->up);
    if (!read_vector(entry, "light", view->light)) memcpy(view->light, view->eye, sizeof view->light);
    const cJSON *vfov = cJSON_GetObjectItemCaseSensitive(entry, "vfov");
    if (!cJSON_IsNumber(vfov)) return "\"vfov\": a number";
    view->vfov = vfov->valuedouble;
    return NULL;
}

// The scene's list of views; a string "same views as OTHER" is followed.
static const cJSON *find_scene(const cJSON *scenes, const char *name)
{
    static const char same[] = "same views as ";
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(scenes, name);
    for (int hops = 0; hops < 8 && cJSON_IsString(list); hops++) {
        if (strncmp(list->valuestring, same, sizeof same - 1) != 0) return NULL;
        list = cJSON_GetObjectItemCaseSensitive(scenes, list->valuestring + sizeof same - 1);
    }
    return cJSON_IsArray(list) ? list : NULL;
}

static const cJSON *find_view(const cJSON *list, const char *name)
{
    const cJSON *entry;
    cJSON_ArrayForEach(entry, list)
    {
        const cJSON *its_name = cJSON_GetObjectItemCaseSensitive(entry, "name");
        if (!*name || (cJSON_IsString(its_name) && strcmp(its_name->valuestring, name) == 0)) return entry;
    }
    return NULL;
}

static int select_view(const cJSON *scenes, const char *path, const char *scene, const char *name, struct view *view)
{
    const cJSON *list = find_scene(scenes, scene), *entry = list ? find_view(list, name) : NULL;
    if (!list) {
        fprintf(stderr, "%s: no list of views for a scene \"%s\"\n", path, scene);
        return 1;
    }
    if (!entry) {
        fprintf(stderr, "%s: scene \"%s\" has no view \"%s\"\n", path, scene, name);
        return 1;
    }
    const char *missing = read_entry(entry, view);
    if (missing) fprintf(stderr, "%s: the view of scene \"%s\" lacks %s\n", path, scene, missing);
    return missing != NULL;
}

static int read_view_from(const char *path, const char *scene, const char *name, struct view *view)
{
    char *text = read_text(path);
    if (!text) return 1;
    cJSON *scenes = cJSON_ParseWithOpts(text, NULL, 1); // and nothing behind it
    int failed = 1;
    if (scenes) {
        failed = select_view(scenes, path, scene, name, view);
    } else {
        const char *end = cJSON_GetErrorPtr();
        int line = 1;
        for (const char *c = text; end && c < end && *c; c++) line += *c == '\n';
        fprintf(stderr, "%s: not JSON (line %d)\n", path, line);
    }
    cJSON_Delete(scenes);
    free(text);
    return failed;
}

int read_view(const char *specification, struct view *view)
{
    char *path = malloc(strlen(specification) + 1), *scene = NULL;
    if (path) scene = strrchr(strcpy(path, specification), ':');
    int failed = 1;
    if (!path) {
        fprintf(stderr, "not enough memory\n");
    } else if (!scene) {
        fprintf(stderr, "%s: a view is given as FILE.json:SCENE/VIEW\n", specification);
    } else {
        *scene++ = 0;
        char *name = strchr(scene, '/');
        if (name) *name++ = 0;
        failed = read_view_from(path, scene, name ? name : "", view);
    }
    free(path);
    return failed;
}

#else

int read_view(const char *specification, struct view *view)
{
    (void)view;
    fprintf(
        stderr,
        "%s: this program was built without cJSON, which reads files of views. Install it (Debian, Ubuntu: apt-get\n"
        "install libcjson-dev; or: make deps) and build again; or give --eye, --look, --up and --fov.\n",
        specification);
    return 1;
}

#endif
