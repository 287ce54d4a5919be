/* SPDX-License-Identifier: MIT */
/* crew.h - threads for contenders that have none: they wait between runs, and claim numbered items one by one */
#ifndef CREW_H
#define CREW_H

#include <stddef.h>
#include <stdint.h>

struct crew;

typedef void (*crew_work)(void *user, size_t item);

/* Starts thread_count - 1 threads; the caller is the one more. Returns NULL after a message on stderr. */
struct crew *create_crew(uint32_t thread_count);

/* Ends the threads. NULL is allowed. */
void destroy_crew(struct crew *crew);

/* Does items 0 .. item_count - 1 and returns when all are done. crew = NULL: by the calling thread, in order. */
void run_crew(struct crew *crew, size_t item_count, crew_work work, void *user);

#endif
