/* SPDX-License-Identifier: MIT */
/*
 * guess.h - another build of the library as a method: the one that guesses (make GUESS=1), to see what exactness costs
 */
#ifndef GUESS_H
#define GUESS_H

/* Loads the shared object whose functions guess_methods call. Returns 0, or 1 after a message on stderr. */
int load_guess(const char *path);

#endif
