/* SPDX-License-Identifier: MIT */
/* subject.c - a mesh, its trees and its oracle: see subject.h */
#include "subject.h"

#include "common/file.h"
#include "common/interior.h"
#include "common/tree.h"
#include "common/view.h"
#include "meshes.h"
#include "oracle.h"

#include <stdio.h>
#include <string.h>

enum { PATH_SIZE = 4096 };

int complete_subject(struct subject *subject)
{
    const struct tree_settings boxes = {.kind = TREE_DEFAULT}, kdtree = {.kind = TREE_KDTREE_TUNED};
    double seconds;
    return build_tree(&subject->scene, &kdtree, &subject->kdtree, &seconds) ||
           build_tree(&subject->scene, &boxes, &subject->boxes, &seconds);
}

const mlrt_tree *subject_tree(const struct subject *subject, int32_t method)
{
    return method == MLRT_METHOD_TILE ? subject->boxes : subject->kdtree;
}

// A word of the list as a path, and the scene's name: of a file, without folder and extension.
static int name_subject(const char *word, char path[PATH_SIZE], char name[SUBJECT_NAME_SIZE])
{
    int fits = snprintf(path, PATH_SIZE, "%.*s", (int)strcspn(word, ","), word) < PATH_SIZE;
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path, *dot = strrchr(base, '.');
    int length = dot ? (int)(dot - base) : PATH_SIZE;
    fits = fits && snprintf(name, SUBJECT_NAME_SIZE, "%.*s", length, base) < SUBJECT_NAME_SIZE;
    if (!fits) fprintf(stderr, "%s: the name is too long\n", path);
    return !fits;
}

static int read_subject_view(const char *views, const char *name, struct view *view)
{
    char specification[PATH_SIZE + SUBJECT_NAME_SIZE + 8];
    if (find_input_problem(views) && strchr(views, ':')) return read_view(views, view); // no file: a view in one
    snprintf(specification, sizeof specification, "%.*s:%s/view1", PATH_SIZE, views, name);
    return read_view(specification, view);
}

int load_subject(const char *word, const char *views, struct subject *subject)
{
    char path[PATH_SIZE];
    memset(subject, 0, sizeof *subject);
    if (name_subject(word, path, subject->name)) return 1;
    int failed = strcmp(path, "sphere") == 0 ? make_sphere(SPHERE_LEVEL, NULL, &subject->scene)
                                             : load_scene(path, &subject->scene);
    if (!failed && !views) look_from_inside(&subject->scene);
    if (!failed && subject->scene.is_imported && views)
        failed = read_subject_view(views, subject->name, &subject->scene.view);
    return failed || complete_subject(subject);
}

void free_subject(struct subject *subject)
{
    destroy_oracle(subject);
    mlrt_destroy_tree(subject->boxes);
    mlrt_destroy_tree(subject->kdtree);
    free_scene(&subject->scene);
    subject->boxes = subject->kdtree = NULL;
}
