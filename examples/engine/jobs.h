/* SPDX-License-Identifier: MIT */
/*
 * jobs.h - the engine's own job system: threads take jobs from a queue, and a thread that waits for a job runs others
 *
 * jobs_add and jobs_wait fit the hooks of mlrt_pool_options. Every thread may add jobs and wait for them, also from
 * within a job.
 */
#ifndef ENGINE_JOBS_H
#define ENGINE_JOBS_H

#include <mlrt.h>

struct jobs;
struct heap;

/* Starts worker_count - 1 threads: the caller's is the first worker, when it waits. NULL if that cannot be. */
struct jobs *jobs_begin(struct heap *heap, uint32_t worker_count);

/* Ends the threads. No job may be left. NULL is allowed. */
void jobs_end(struct jobs *jobs, struct heap *heap);

/* Adds a job. Returns what to wait for, or NULL: there was no room in the queue, and it has been run already. */
void *jobs_add(void *jobs, mlrt_task_function function, void *argument);

/* Waits until a job has been run, and runs others until then. NULL is allowed. */
void jobs_wait(void *jobs, void *job);

#endif
