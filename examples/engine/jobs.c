/* SPDX-License-Identifier: MIT */
/* jobs.c - the engine's own job system: see jobs.h */
#define _POSIX_C_SOURCE 200112L
#include "engine/jobs.h"

#include "engine/heap.h"

#include <string.h>

enum { JOB_COUNT = 64, THREAD_LIMIT = 256 };
enum job_state { JOB_FREE, JOB_QUEUED, JOB_RUNNING, JOB_DONE };

struct job {
    enum job_state state;
    mlrt_task_function function;
    void *argument;
};

struct jobs {
    pthread_mutex_t mutex; // guards all below
    pthread_cond_t changed;
    struct job jobs[JOB_COUNT];
    int ending;
    uint32_t thread_count;
    pthread_t threads[THREAD_LIMIT];
};

// With the mutex held. In what order jobs are run does not matter to anyone.
static struct job *find_job(struct jobs *jobs, enum job_state state)
{
    for (int i = 0; i < JOB_COUNT; i++) {
        if (jobs->jobs[i].state == state) return &jobs->jobs[i];
    }
    return NULL;
}

// Enters and leaves with the mutex held.
static void run_job(struct jobs *jobs, struct job *job)
{
    job->state = JOB_RUNNING;
    pthread_mutex_unlock(&jobs->mutex);
    job->function(job->argument);
    pthread_mutex_lock(&jobs->mutex);
    job->state = JOB_DONE;
    pthread_cond_broadcast(&jobs->changed);
}

// Runs a job if there is one, else waits until something has changed.
static void run_or_sleep(struct jobs *jobs)
{
    struct job *job = find_job(jobs, JOB_QUEUED);
    if (job)
        run_job(jobs, job);
    else
        pthread_cond_wait(&jobs->changed, &jobs->mutex);
}

static void *run_thread(void *argument)
{
    struct jobs *jobs = argument;
    pthread_mutex_lock(&jobs->mutex);
    while (!jobs->ending) run_or_sleep(jobs);
    pthread_mutex_unlock(&jobs->mutex);
    return NULL;
}

void *jobs_add(void *user, mlrt_task_function function, void *argument)
{
    struct jobs *jobs = user;
    pthread_mutex_lock(&jobs->mutex);
    struct job *job = find_job(jobs, JOB_FREE);
    if (job) {
        *job = (struct job){JOB_QUEUED, function, argument};
        pthread_cond_broadcast(&jobs->changed);
    }
    pthread_mutex_unlock(&jobs->mutex);
    if (!job) function(argument);
    return job;
}

void jobs_wait(void *user, void *handle)
{
    struct jobs *jobs = user;
    struct job *job = handle;
    if (!job) return;
    pthread_mutex_lock(&jobs->mutex);
    while (job->state != JOB_DONE) run_or_sleep(jobs);
    job->state = JOB_FREE;
    pthread_mutex_unlock(&jobs->mutex);
}

struct jobs *jobs_begin(struct heap *heap, uint32_t worker_count)
{
    struct jobs *jobs = heap_allocate(heap, sizeof *jobs, 64);
    if (!jobs) return NULL;
    memset(jobs, 0, sizeof *jobs);
    pthread_mutex_init(&jobs->mutex, NULL);
    pthread_cond_init(&jobs->changed, NULL);
    while (jobs->thread_count + 1 < worker_count && jobs->thread_count < THREAD_LIMIT) {
        if (pthread_create(&jobs->threads[jobs->thread_count], NULL, run_thread, jobs) != 0) break;
        jobs->thread_count++; // fewer threads than wanted will do: whoever waits helps
    }
    return jobs;
}

void jobs_end(struct jobs *jobs, struct heap *heap)
{
    if (!jobs) return;
    pthread_mutex_lock(&jobs->mutex);
    jobs->ending = 1;
    pthread_cond_broadcast(&jobs->changed);
    pthread_mutex_unlock(&jobs->mutex);
    for (uint32_t i = 0; i < jobs->thread_count; i++) pthread_join(jobs->threads[i], NULL);
    pthread_cond_destroy(&jobs->changed);
    pthread_mutex_destroy(&jobs->mutex);
    heap_free(heap, jobs, sizeof *jobs, 64);
}
