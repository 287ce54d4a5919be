/* SPDX-License-Identifier: MIT */
/*
 * A pool of pthreads that sleep until there are items, claim them one by one under a mutex, and sleep again. An item is
 * tens of microseconds of work, claiming one takes tens of nanoseconds.
 */
#define _POSIX_C_SOURCE 200809L
#include "scheduler.h"

#include <pthread.h>
#include <stdlib.h>
#include <unistd.h>

#define THREAD_LIMIT 1024

/* One call of mlrt_run_items. Guarded by the pool's mutex. */
struct batch {
    mlrt_work_function *function;
    void *work;
    uint32_t item_count;
    uint32_t next_item;
    int32_t result; /* 0, or what the first function to say stop said */
};

struct mlrt_pool {
    pthread_mutex_t call_mutex; /* held for the length of a call: one batch at a time */
    pthread_mutex_t mutex;      /* guards all below */
    pthread_cond_t batch_begins;
    pthread_cond_t batch_ends;
    struct batch *batch;   /* NULL between calls */
    uint64_t batch_number; /* so that a worker takes part in each batch once */
    uint32_t busy_count;   /* started threads inside the batch */
    int ending;
    uint32_t thread_count; /* started ones */
    struct thread *threads;
};

struct thread {
    pthread_t handle;
    mlrt_pool *pool;
    uint32_t worker;
};

/* Claims and runs items until none is left. Enters and leaves with the mutex held. */
static void work_on_batch(mlrt_pool *pool, struct batch *batch, uint32_t worker)
{
    while (batch->next_item < batch->item_count && batch->result == 0) {
        uint32_t item = batch->next_item++;
        pthread_mutex_unlock(&pool->mutex);
        int32_t result = batch->function(batch->work, item, worker);
        pthread_mutex_lock(&pool->mutex);
        if (result != 0 && batch->result == 0) batch->result = result;
    }
}

static void *run_thread(void *argument)
{
    struct thread *thread = argument;
    mlrt_pool *pool = thread->pool;
    uint64_t seen = 0;
    pthread_mutex_lock(&pool->mutex);
    for (;;) {
        while (!pool->ending && (!pool->batch || pool->batch_number == seen)) {
            pthread_cond_wait(&pool->batch_begins, &pool->mutex);
        }
        if (pool->ending) break;
        seen = pool->batch_number;
        ++pool->busy_count;
        work_on_batch(pool, pool->batch, thread->worker);
        if (--pool->busy_count == 0) pthread_cond_signal(&pool->batch_ends);
    }
    pthread_mutex_unlock(&pool->mutex);
    return NULL;
}

uint32_t mlrt_worker_count(const mlrt_pool *pool)
{
    return pool ? pool->thread_count + 1 : 1;
}

static int32_t run_alone(uint32_t item_count, mlrt_work_function *function, void *work)
{
    for (uint32_t item = 0; item < item_count; ++item) {
        int32_t result = function(work, item, 0);
        if (result != 0) return result;
    }
    return 0;
}

int32_t mlrt_run_items(mlrt_pool *pool, uint32_t item_count, mlrt_work_function *function, void *work)
{
    if (!pool || pool->thread_count == 0) return run_alone(item_count, function, work);

    struct batch batch = {function, work, item_count, 0, 0};
    pthread_mutex_lock(&pool->call_mutex);
    pthread_mutex_lock(&pool->mutex);
    pool->batch = &batch;
    ++pool->batch_number;
    if (item_count > 1) pthread_cond_broadcast(&pool->batch_begins);
    work_on_batch(pool, &batch, 0);
    pool->batch = NULL;
    while (pool->busy_count > 0) pthread_cond_wait(&pool->batch_ends, &pool->mutex);
    pthread_mutex_unlock(&pool->mutex);
    pthread_mutex_unlock(&pool->call_mutex);
    return batch.result;
}

static void free_pool(mlrt_pool *pool)
{
    pthread_cond_destroy(&pool->batch_ends);
    pthread_cond_destroy(&pool->batch_begins);
    pthread_mutex_destroy(&pool->mutex);
    pthread_mutex_destroy(&pool->call_mutex);
    free(pool->threads);
    free(pool);
}

static mlrt_pool *allocate_pool(uint32_t thread_count)
{
    mlrt_pool *pool = calloc(1, sizeof *pool);
    if (!pool) return NULL;
    pool->threads = calloc(thread_count, sizeof *pool->threads);
    if (!pool->threads) {
        free(pool);
        return NULL;
    }
    pthread_mutex_init(&pool->call_mutex, NULL);
    pthread_mutex_init(&pool->mutex, NULL);
    pthread_cond_init(&pool->batch_begins, NULL);
    pthread_cond_init(&pool->batch_ends, NULL);
    return pool;
}

static uint32_t online_processor_count(void)
{
    long count = sysconf(_SC_NPROCESSORS_ONLN);
    return count < 1 ? 1 : count > THREAD_LIMIT ? THREAD_LIMIT : (uint32_t)count;
}

MLRT_API int32_t mlrt_create_pool(uint32_t thread_count, mlrt_pool **pool)
{
    if (!pool) return MLRT_ERROR_ARGUMENT;
    *pool = NULL;
    if (thread_count > THREAD_LIMIT) return MLRT_ERROR_ARGUMENT;
    if (thread_count == 0) thread_count = online_processor_count();

    mlrt_pool *made = allocate_pool(thread_count);
    if (!made) return MLRT_ERROR_OUT_OF_MEMORY;
    for (uint32_t worker = 1; worker < thread_count; ++worker) {
        struct thread *thread = &made->threads[worker - 1];
        thread->pool = made;
        thread->worker = worker;
        if (pthread_create(&thread->handle, NULL, run_thread, thread) != 0) {
            mlrt_destroy_pool(made);
            return MLRT_ERROR_THREAD;
        }
        ++made->thread_count;
    }
    *pool = made;
    return MLRT_OK;
}

MLRT_API void mlrt_destroy_pool(mlrt_pool *pool)
{
    if (!pool) return;
    pthread_mutex_lock(&pool->mutex);
    pool->ending = 1;
    pthread_cond_broadcast(&pool->batch_begins);
    pthread_mutex_unlock(&pool->mutex);
    for (uint32_t i = 0; i < pool->thread_count; ++i) pthread_join(pool->threads[i].handle, NULL);
    free_pool(pool);
}
