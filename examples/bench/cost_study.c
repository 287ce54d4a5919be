/* SPDX-License-Identifier: MIT */
/* cost_study.c - trees by other costs of nodes and triangles: see cost_study.h */
#include "cost_study.h"

#include <stdio.h>

enum { SETTING_COUNT = 9 };

// The first is what all are compared with. It takes part twice, which shows how far chance goes.
static const struct setting {
    const char *name;
    int32_t preset;
    float node, triangle; // 0 = the library's
} settings_of[SETTING_COUNT] = {
    {"default", MLRT_TREE_DEFAULT, 0, 0},
    {"default once more", MLRT_TREE_DEFAULT, 0, 0},
    {"triangle 0.005", MLRT_TREE_DEFAULT, 0, 0.005f},
    {"triangle 0.01", MLRT_TREE_DEFAULT, 0, 0.01f},
    {"triangle 0.04", MLRT_TREE_DEFAULT, 0, 0.04f},
    {"triangle 0.08", MLRT_TREE_DEFAULT, 0, 0.08f},
    {"node 0.7", MLRT_TREE_DEFAULT, 0.7f, 0},
    {"node 1.5", MLRT_TREE_DEFAULT, 1.5f, 0},
    {"best", MLRT_TREE_BEST, 0, 0},
};

/* A scene with a tree for each setting. */
struct forest {
    struct subject subject;
    mlrt_tree *trees[SETTING_COUNT];
    double leaf_size[SETTING_COUNT], bytes[SETTING_COUNT]; // references per leaf, bytes per triangle
};

static int plant(const char *word, const struct bench_settings *settings, struct forest *forest)
{
    *forest = (struct forest){.trees = {NULL}};
    if (load_subject(word, settings->views, settings->view, &forest->subject)) return 1;
    if (set_size(&forest->subject, settings->size)) return 1;
    const struct scene *scene = &forest->subject.scene;
    const mlrt_mesh mesh = {.struct_size = sizeof mesh,
                            .vertices = scene->vertices,
                            .vertex_count = scene->vertex_count,
                            .indices = scene->indices,
                            .triangle_count = scene->triangle_count};
    for (int i = 0; i < SETTING_COUNT; i++) {
        const struct setting *setting = &settings_of[i];
        const mlrt_tree_options options = {.struct_size = sizeof options,
                                           .preset = setting->preset,
                                           .traversal_cost = setting->node,
                                           .intersection_cost = setting->triangle};
        mlrt_tree_info info = {.struct_size = sizeof info};
        int32_t status = mlrt_build_tree(&mesh, 1, &options, &forest->trees[i]);
        if (status == MLRT_OK) status = mlrt_get_tree_info(forest->trees[i], &info);
        if (status != MLRT_OK) {
            fprintf(stderr, "%s: %s\n", word, mlrt_status_string(status));
            return 1;
        }
        forest->leaf_size[i] = (double)info.reference_count / (double)info.leaf_count;
        forest->bytes[i] = (double)info.memory_size / (double)scene->triangle_count;
    }
    return 0;
}

static void fell(struct forest *forest)
{
    for (int i = 0; i < SETTING_COUNT; i++) mlrt_destroy_tree(forest->trees[i]);
    free_subject(&forest->subject);
}

static int compare(const struct bench_settings *settings, const struct forest *forest, enum kind kind, int32_t isa)
{
    struct contest contest = {.tree = forest->trees[0], .runs = settings->runs, .count = SETTING_COUNT};
    struct task task;
    for (int i = 0; i < SETTING_COUNT; i++)
        contest.contenders[i] = (struct contender){.who = LIBRARY, .isa = isa, .threads = 1, .tree = forest->trees[i]};
    contest.task = &task;
    const int failed = make_task(kind, &forest->subject, forest->trees[0], NULL, &task) || hold_contest(&contest);
    for (int i = 0; i < SETTING_COUNT && !failed; i++) {
        if (contest.contenders[i].unsupported) continue;
        printf("%s,%s,%s,%s,%.2f,%.1f,%.3f,%.3f\n", forest->subject.name, kind_names[kind], isa_names[isa],
               settings_of[i].name, forest->leaf_size[i], forest->bytes[i], contest.contenders[i].mrays,
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
