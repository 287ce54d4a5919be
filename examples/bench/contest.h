/* SPDX-License-Identifier: MIT */
/*
 * contest.h - the contenders of a task take turns on the same rays, and their answers are compared
 *
 * A contender's speed is that of its fastest run, since whatever else happens on a machine only takes time from a run.
 * All contenders run once in each round, so that each has the same chance of an undisturbed one. If each has one
 * thread, its processor time counts, otherwise the time that passes. Before the rounds each contender answers once: for
 * a sample of the rays the library's answers must be those of another of its methods, and pictures must look alike.
 * Another build of the library traces a tree of its own; it and the library go first by turns. Answers that differ are
 * counted: the library's and those of Embree fast from those of Embree robust, those of the other build from the
 * library's.
 */
#ifndef CONTEST_H
#define CONTEST_H

#include "library.h"
#include "peer.h"

enum { MAXIMUM_CONTENDERS = 128, MAXIMUM_RUNS = 101 };

enum who { LIBRARY, OLD_LIBRARY, PEER_FAST, PEER_ROBUST, SPIN_LOOP, WHO_COUNT };

struct contender {
    enum who who;
    int32_t method, isa;   /* of the library, or the old one */
    uint32_t threads;      /* 1, or those of pool and crew */
    const mlrt_tree *tree; /* of the library; NULL = the contest's */
    int unsupported;       /* 1 = this library cannot do this: not measured */
    int variant;           /* of the peer, the fastest */
    double mrays;          /* millions of rays per second; of the spin loop, of steps */
    size_t different; /* answers that are not those of the robust peer: the library's, or the fast peer's. Of the old
                            library: that are not the library's, by the same method and instruction set */
};

struct contest {
    const struct task *task;
    const mlrt_tree *tree;
    const struct library *old; /* another build of the library; NULL = it does not take part */
    const mlrt_tree *old_tree;
    mlrt_pool *old_pool;
    const struct peer *fast, *robust; /* NULL = they do not take part */
    mlrt_pool *pool;
    struct crew *crew; /* of as many threads as the pool */
    uint32_t runs;
    int paced; /* 1 = each run says on stdout that it begins, waits for a line on stdin, and says how long it took */
    size_t count;
    struct contender contenders[MAXIMUM_CONTENDERS];
};

/* Returns 0, or 1 after a message on stderr, for example if an answer is wrong. */
int hold_contest(struct contest *contest);

/* The old library's contender for one of the library's, or NULL. */
const struct contender *find_old(const struct contest *contest, const struct contender *contender);

/* The first contender of this kind and number of threads, or NULL. */
const struct contender *find_contender(const struct contest *contest, enum who who, uint32_t threads);

#endif
