/* SPDX-License-Identifier: MIT */
/* cost_study.c - trees by other settings of the builder: see cost_study.h */
#include "cost_study.h"

#include "common/loaded_library.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SETTING_COUNT = 8, TREE_LIMIT = SETTING_COUNT + MAXIMUM_WORDS + 1 };

// The first is what all are compared with.
static const struct setting {
    const char *name;
    int32_t preset;
    float node, triangle; // 0 = the library's
} settings_of[SETTING_COUNT] = {
    {"default", MLRT_TREE_DEFAULT, 0, 0},           {"triangle 0.005", MLRT_TREE_DEFAULT, 0, 0.005f},
    {"triangle 0.01", MLRT_TREE_DEFAULT, 0, 0.01f}, {"triangle 0.04", MLRT_TREE_DEFAULT, 0, 0.04f},
    {"triangle 0.08", MLRT_TREE_DEFAULT, 0, 0.08f}, {"node 0.7", MLRT_TREE_DEFAULT, 0.7f, 0},
    {"node 1.5", MLRT_TREE_DEFAULT, 1.5f, 0},       {"best", MLRT_TREE_BEST, 0, 0},
};

struct planted {
    char name[64];
    mlrt_tree *tree;
    double leaf_size, bytes; // references per leaf, bytes per triangle
};

/*
 * A scene with a tree for each setting. The default tree is there twice, first and last, which shows how far chance
 * goes.
 */
struct forest {
    struct subject subject;
    struct planted trees[TREE_LIMIT];
    size_t count;
};

// The tree that another build of the library makes, as one of this library.
static int32_t build_elsewhere(const char *path, const mlrt_mesh *mesh, mlrt_tree **tree)
{
    struct library library;
    mlrt_tree *other = NULL;
    void *bytes = NULL;
    size_t size = 0;
    if (load_library(path, &library)) return MLRT_ERROR_ARGUMENT;
    int32_t status =
        library.build_tree && library.save_tree ? library.build_tree(mesh, 1, NULL, &other) : MLRT_ERROR_UNSUPPORTED;
    if (status == MLRT_OK) status = library.save_tree(other, NULL, 0, &size);
    if (status == MLRT_OK) status = (bytes = malloc(size)) ? MLRT_OK : MLRT_ERROR_OUT_OF_MEMORY;
    if (status == MLRT_OK) status = library.save_tree(other, bytes, size, &size);
    library.destroy_tree(other);
    close_library(&library);
    if (status == MLRT_OK) status = mlrt_load_tree(bytes, size, NULL, tree);
    free(bytes);
    return status;
}

// The name of the folder in which a file lies, with spaces for hyphens.
static void name_by_folder(const char *path, char name[64])
{
    const char *end = strrchr(path, '/'), *begin = end ? end : path;
    while (begin > path && begin[-1] != '/') begin--;
    snprintf(name, 64, "%.*s", end ? (int)(end - begin) : 0, begin);
    for (; *name; name++) *name = *name == '-' ? ' ' : *name;
}

static int32_t plant_setting(const struct setting *setting, const mlrt_mesh *mesh, struct planted *planted)
{
    const mlrt_tree_options options = {.struct_size = sizeof options,
                                       .preset = setting->preset,
                                       .traversal_cost = setting->node,
                                       .intersection_cost = setting->triangle};
    snprintf(planted->name, sizeof planted->name, "%s", setting->name);
    return mlrt_build_tree(mesh, 1, &options, &planted->tree);
}

// Counts the tree that was planted behind the others.
static int take_root(struct forest *forest, int32_t status)
{
    struct planted *planted = &forest->trees[forest->count++];
    mlrt_tree_info info = {.struct_size = sizeof info};
    if (status == MLRT_OK) status = mlrt_get_tree_info(planted->tree, &info);
    if (status != MLRT_OK) {
        fprintf(stderr, "%s: %s\n", planted->name, mlrt_status_string(status));
        return 1;
    }
    planted->leaf_size = (double)info.reference_count / (double)info.leaf_count;
    planted->bytes = (double)info.memory_size / (double)forest->subject.scene.triangle_count;
    return 0;
}

static int plant(const char *word, const struct bench_settings *settings, struct forest *forest)
{
    static const struct setting once_more = {"default once more", MLRT_TREE_DEFAULT, 0, 0};
    *forest = (struct forest){.count = 0};
    if (load_subject(word, settings->views, settings->view, &forest->subject)) return 1;
    if (set_size(&forest->subject, settings->size)) return 1;
    const struct scene *scene = &forest->subject.scene;
    const mlrt_mesh mesh = {.struct_size = sizeof mesh,
                            .vertices = scene->vertices,
                            .vertex_count = scene->vertex_count,
                            .indices = scene->indices,
                            .triangle_count = scene->triangle_count};
    int failed = 0;
    for (int i = 0; i < SETTING_COUNT && !failed; i++)
        failed = take_root(forest, plant_setting(&settings_of[i], &mesh, &forest->trees[forest->count]));
    for (size_t i = 0; i < settings->trees.count && !failed; i++) {
        struct planted *planted = &forest->trees[forest->count];
        const char *word_of_list = settings->trees.words[i];
        char path[4096];
        snprintf(path, sizeof path, "%.*s", (int)strcspn(word_of_list, ","), word_of_list);
        name_by_folder(path, planted->name);
        failed = take_root(forest, build_elsewhere(path, &mesh, &planted->tree));
    }
    return failed || take_root(forest, plant_setting(&once_more, &mesh, &forest->trees[forest->count]));
}

static void fell(struct forest *forest)
{
    for (size_t i = 0; i < forest->count; i++) mlrt_destroy_tree(forest->trees[i].tree);
    free_subject(&forest->subject);
}

static int compare(const struct bench_settings *settings, const struct forest *forest, enum kind kind, int32_t isa)
{
    const struct planted *trees = forest->trees;
    struct contest contest = {.tree = trees[0].tree, .runs = settings->runs, .count = forest->count};
    struct task task;
    for (size_t i = 0; i < forest->count; i++)
        contest.contenders[i] = (struct contender){.who = LIBRARY, .isa = isa, .threads = 1, .tree = trees[i].tree};
    contest.task = &task;
    const int failed = make_task(kind, &forest->subject, trees[0].tree, NULL, &task) || hold_contest(&contest);
    for (size_t i = 0; i < forest->count && !failed; i++) {
        if (contest.contenders[i].unsupported) continue;
        printf("%s,%s,%s,%s,%.2f,%.1f,%.3f,%.3f\n", forest->subject.name, kind_names[kind], isa_names[isa],
               trees[i].name, trees[i].leaf_size, trees[i].bytes, contest.contenders[i].mrays,
               contest.contenders[i].mrays / contest.contenders[0].mrays);
    }
    fflush(stdout);
    free_task(&task);
    return failed;
}

int study_costs(const struct bench_settings *settings)
{
    int failed = 0;
    puts("scene,kind,isa,setting,leaf_size,bytes_per_triangle,mrays,over_default");
    for (size_t i = 0; i < settings->scenes.count && !failed; i++) {
        struct forest forest;
        failed = plant(settings->scenes.words[i], settings, &forest);
        for (int kind = 0; kind < KIND_COUNT && !failed; kind++) {
            for (int32_t isa = 0; isa < 5 && !failed; isa++) {
                if (settings->kinds & 1u << kind && settings->isas & 1u << isa)
                    failed = compare(settings, &forest, (enum kind)kind, isa);
            }
        }
        fell(&forest);
    }
    return failed;
}
