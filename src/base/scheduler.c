/* SPDX-License-Identifier: MIT */
/*
 * A pool has threads of its own, or it uses tasks that the host runs. Threads sleep until a batch of items begins,
 * claim items one by one under a mutex, and sleep again; tasks claim items in the same way. An item is tens of
 * microseconds of work, and claiming it takes tens of nanoseconds. Waking a thread takes as long as an item (25
 * microseconds where processors are virtual), and a build has some twenty batches: so threads spin before they sleep.
 */
#define _POSIX_C_SOURCE 200809L
#include "base/scheduler.h"

#include <pthread.h>
#include <unistd.h>

#include "base/forms.h"
#include "base/memory.h"
#include "base/platform.h"

/* One call of mlrt_run_items. Guarded by the pool's mutex. */
struct batch {
    mlrt_work_function *function;
    void *work;
    uint32_t item_count;
    uint32_t next_item;
    int32_t result; /* 0, or the first result of the function that was not 0 */
    mlrt_pool *pool;
    uint32_t next_worker; /* worker number of the next task that starts */
};

struct thread {
    pthread_t handle;
    mlrt_pool *pool;
    uint32_t worker;
};

/* The threads of a pool, and the batch that they work on. */
struct threads {
    pthread_cond_t batch_begins;
    pthread_cond_t batch_ends;
    struct batch *batch;   /* NULL between calls */
    uint32_t batch_number; /* so that a thread takes part in each batch once; changes when threads are to end, too */
    uint32_t busy_count;   /* threads that work on the batch */
    int ending;            /* 1 = threads are to end */
};

struct mlrt_pool {
    struct mlrt_memory memory;
    mlrt_pool_options options;  /* with `enqueue` it has no threads, and any number of batches can run at a time */
    uint32_t thread_count;      /* threads started; with tasks, the most tasks of a batch */
    pthread_mutex_t call_mutex; /* held for the length of a call: one batch at a time */
    pthread_mutex_t mutex;      /* guards batches and all members below */
    struct threads threads;
    size_t size;          /* of this block */
    struct thread each[]; /* the threads */
};

/* How often a thread looks whether it may go on before it sleeps: for about as long as waking it takes. */
#define SPIN_COUNT 1000

/*
 * Waits until a counter of the pool may have changed, or the condition was signalled. The mutex is held on entry and on
 * return. Counters are changed with the mutex held, by change_counter, since they are read without it here.
 */
static void wait_for_change(mlrt_pool *pool, const uint32_t *counter, pthread_cond_t *condition)
{
    const uint32_t value = *counter;
    pthread_mutex_unlock(&pool->mutex);
    for (int i = 0; i < SPIN_COUNT && __atomic_load_n(counter, __ATOMIC_RELAXED) == value; ++i) MLRT_PAUSE();
    pthread_mutex_lock(&pool->mutex);
    if (*counter == value) pthread_cond_wait(condition, &pool->mutex);
}

static void change_counter(uint32_t *counter, int change)
{
    __atomic_store_n(counter, *counter + (uint32_t)change, __ATOMIC_RELAXED);
}

/* Claims and runs items until none is left or one stops the batch. The mutex is held on entry and on return. */
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
    uint32_t seen = 0;
    pthread_mutex_lock(&pool->mutex);
    for (;;) {
        while (!pool->threads.ending && (!pool->threads.batch || pool->threads.batch_number == seen))
            wait_for_change(pool, &pool->threads.batch_number, &pool->threads.batch_begins);
        if (pool->threads.ending) break;
        seen = pool->threads.batch_number;
        change_counter(&pool->threads.busy_count, 1);
        work_on_batch(pool, pool->threads.batch, thread->worker);
        change_counter(&pool->threads.busy_count, -1);
        if (pool->threads.busy_count == 0) pthread_cond_signal(&pool->threads.batch_ends);
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

static void run_task(void *argument)
{
    struct batch *batch = argument;
    mlrt_pool *pool = batch->pool;
    pthread_mutex_lock(&pool->mutex);
    const uint32_t worker = batch->next_worker++;
    work_on_batch(pool, batch, worker);
    pthread_mutex_unlock(&pool->mutex);
}

/* A task that starts when no item is left returns at once. It reads the batch, so all tasks end before this returns. */
static void run_tasks(mlrt_pool *pool, struct batch *batch)
{
    void *tasks[MLRT_THREAD_LIMIT];
    const uint32_t most = batch->item_count - 1;
    const uint32_t task_count = pool->thread_count < most ? pool->thread_count : most;
    for (uint32_t i = 0; i < task_count; ++i) tasks[i] = pool->options.enqueue(pool->options.user, run_task, batch);
    pthread_mutex_lock(&pool->mutex);
    work_on_batch(pool, batch, 0);
    pthread_mutex_unlock(&pool->mutex);
    for (uint32_t i = 0; i < task_count; ++i)
        if (tasks[i]) pool->options.finish(pool->options.user, tasks[i]);
}

int32_t mlrt_run_items(mlrt_pool *pool, uint32_t item_count, mlrt_work_function *function, void *work)
{
    if (!pool || pool->thread_count == 0 || item_count < 2) return run_alone(item_count, function, work);

    struct batch batch = {function, work, item_count, 0, 0, pool, 1};
    if (pool->options.enqueue) {
        run_tasks(pool, &batch);
        return batch.result;
    }
    pthread_mutex_lock(&pool->call_mutex);
    pthread_mutex_lock(&pool->mutex);
    pool->threads.batch = &batch;
    change_counter(&pool->threads.batch_number, 1);
    pthread_cond_broadcast(&pool->threads.batch_begins);
    work_on_batch(pool, &batch, 0);
    pool->threads.batch = NULL;
    while (pool->threads.busy_count > 0) wait_for_change(pool, &pool->threads.busy_count, &pool->threads.batch_ends);
    pthread_mutex_unlock(&pool->mutex);
    pthread_mutex_unlock(&pool->call_mutex);
    return batch.result;
}

static void free_pool(mlrt_pool *pool)
{
    pthread_cond_destroy(&pool->threads.batch_ends);
    pthread_cond_destroy(&pool->threads.batch_begins);
    pthread_mutex_destroy(&pool->mutex);
    pthread_mutex_destroy(&pool->call_mutex);
    struct mlrt_memory memory = pool->memory;
    mlrt_free(&memory, pool, 1, pool->size);
}

static mlrt_pool *allocate_pool(const mlrt_host *host, uint32_t thread_capacity)
{
    struct mlrt_memory memory = mlrt_host_memory(host, 0);
    const size_t size = sizeof(mlrt_pool) + thread_capacity * sizeof(struct thread);
    mlrt_pool *pool = mlrt_allocate_zeroed(&memory, 1, size);
    if (!pool) return NULL;
    pool->memory = memory;
    pool->size = size;
    pthread_mutex_init(&pool->call_mutex, NULL);
    pthread_mutex_init(&pool->mutex, NULL);
    pthread_cond_init(&pool->threads.batch_begins, NULL);
    pthread_cond_init(&pool->threads.batch_ends, NULL);
    return pool;
}

static uint32_t online_processor_count(void)
{
    long count = MLRT_ONLINE_PROCESSORS();
    return count < 1 ? 1 : count > MLRT_THREAD_LIMIT ? MLRT_THREAD_LIMIT : (uint32_t)count;
}

/* A call takes up to 128 kB of a stack (docs/embedding.md), and callbacks come on top. Some systems give no more. */
enum { LEAST_STACK_SIZE = 1 << 20 };

static int start_thread(struct thread *thread)
{
    pthread_attr_t attributes;
    size_t size;
    if (pthread_attr_init(&attributes) != 0) return 0;
    if (pthread_attr_getstacksize(&attributes, &size) == 0 && size < LEAST_STACK_SIZE) {
        (void)pthread_attr_setstacksize(&attributes, LEAST_STACK_SIZE);
    }
    const int is_started = pthread_create(&thread->handle, &attributes, run_thread, thread) == 0;
    (void)pthread_attr_destroy(&attributes);
    return is_started;
}

static int32_t start_threads(mlrt_pool *pool, uint32_t thread_count)
{
    for (uint32_t worker = 1; worker < thread_count; ++worker) {
        struct thread *thread = &pool->each[worker - 1];
        thread->pool = pool;
        thread->worker = worker;
        if (!start_thread(thread)) return MLRT_ERROR_THREAD;
        ++pool->thread_count;
    }
    return MLRT_OK;
}

void mlrt_end_pool(mlrt_pool *pool)
{
    pthread_mutex_lock(&pool->mutex);
    pool->threads.ending = 1;
    change_counter(&pool->threads.batch_number, 1);
    pthread_cond_broadcast(&pool->threads.batch_begins);
    pthread_mutex_unlock(&pool->mutex);
    for (uint32_t i = 0; i < pool->thread_count && !pool->options.enqueue; ++i)
        pthread_join(pool->each[i].handle, NULL);
    free_pool(pool);
}

int32_t mlrt_make_pool(const mlrt_pool_options *options, const mlrt_host *host, mlrt_pool **pool)
{
    int32_t status = MLRT_OK;
    const uint32_t thread_count = options->thread_count ? options->thread_count : online_processor_count();
    mlrt_pool *made = allocate_pool(host, options->enqueue ? 0 : thread_count - 1);
    if (!made) return MLRT_ERROR_OUT_OF_MEMORY;
    made->options = *options;
    if (options->enqueue)
        made->thread_count = thread_count - 1;
    else
        status = start_threads(made, thread_count);
    if (status != MLRT_OK) {
        mlrt_end_pool(made);
        return status;
    }
    *pool = made;
    return MLRT_OK;
}
