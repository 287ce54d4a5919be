/* SPDX-License-Identifier: MIT */
/* crew.c - a pool of pthreads: see crew.h */
#include "crew.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

struct crew {
    pthread_mutex_t mutex;
    pthread_cond_t started, finished;
    crew_work work;
    void *user;
    size_t item_count, next_item;
    uint32_t busy_count; // threads that still work on this run
    uint64_t run_number;
    int ending;
    uint32_t thread_count; // without the caller
    pthread_t threads[];
};

static int claim_item(struct crew *crew, size_t *item)
{
    pthread_mutex_lock(&crew->mutex);
    const int any = crew->next_item < crew->item_count;
    if (any) *item = crew->next_item++;
    pthread_mutex_unlock(&crew->mutex);
    return any;
}

static void work_on_items(struct crew *crew)
{
    size_t item;
    while (claim_item(crew, &item)) crew->work(crew->user, item);
}

// Waits for a run after the one of this number. Returns 0 when there will be none.
static int wait_for_run(struct crew *crew, uint64_t *run_number)
{
    pthread_mutex_lock(&crew->mutex);
    while (!crew->ending && crew->run_number == *run_number) pthread_cond_wait(&crew->started, &crew->mutex);
    *run_number = crew->run_number;
    const int go_on = !crew->ending;
    pthread_mutex_unlock(&crew->mutex);
    return go_on;
}

static void *thread_main(void *argument)
{
    struct crew *crew = argument;
    uint64_t run_number = 0;
    while (wait_for_run(crew, &run_number)) {
        work_on_items(crew);
        pthread_mutex_lock(&crew->mutex);
        if (--crew->busy_count == 0) pthread_cond_signal(&crew->finished);
        pthread_mutex_unlock(&crew->mutex);
    }
    return NULL;
}

struct crew *create_crew(uint32_t thread_count)
{
    struct crew *crew = calloc(1, sizeof *crew + thread_count * sizeof *crew->threads);
    if (!crew) {
        fprintf(stderr, "not enough memory for %lu threads\n", (unsigned long)thread_count);
        return NULL;
    }
    pthread_mutex_init(&crew->mutex, NULL);
    pthread_cond_init(&crew->started, NULL);
    pthread_cond_init(&crew->finished, NULL);
    while (crew->thread_count + 1 < thread_count) {
        if (pthread_create(&crew->threads[crew->thread_count], NULL, thread_main, crew) != 0) {
            fprintf(stderr, "cannot start a thread\n");
            destroy_crew(crew);
            return NULL;
        }
        crew->thread_count++;
    }
    return crew;
}

void destroy_crew(struct crew *crew)
{
    if (!crew) return;
    pthread_mutex_lock(&crew->mutex);
    crew->ending = 1;
    pthread_cond_broadcast(&crew->started);
    pthread_mutex_unlock(&crew->mutex);
    for (uint32_t i = 0; i < crew->thread_count; i++) pthread_join(crew->threads[i], NULL);
    pthread_cond_destroy(&crew->started);
    pthread_cond_destroy(&crew->finished);
    pthread_mutex_destroy(&crew->mutex);
    free(crew);
}

void run_crew(struct crew *crew, size_t item_count, crew_work work, void *user)
{
    if (!crew) {
        for (size_t item = 0; item < item_count; item++) work(user, item);
        return;
    }
    pthread_mutex_lock(&crew->mutex);
    crew->work = work, crew->user = user;
    crew->item_count = item_count, crew->next_item = 0;
    crew->busy_count = crew->thread_count;
    crew->run_number++;
    pthread_cond_broadcast(&crew->started);
    pthread_mutex_unlock(&crew->mutex);
    work_on_items(crew);
    pthread_mutex_lock(&crew->mutex);
    while (crew->busy_count > 0) pthread_cond_wait(&crew->finished, &crew->mutex);
    pthread_mutex_unlock(&crew->mutex);
}
