/* SPDX-License-Identifier: MIT */
/* cancel.h - measures how soon a build ends when its progress function cancels it, and how often that is called */
#ifndef CANCEL_H
#define CANCEL_H

#include "scene.h"
#include "tree.h"

/*
 * Builds the scene's tree once to the end, and then `count` times with a progress function that asks to stop, at
 * fractions spread over 0..1. Prints, as `name value` lines in milliseconds: the longest time between two calls of the
 * progress function, and the longest from its asking to stop until the build has returned and all is freed; each with
 * the fraction told before, and each also without what the system's free took of it. With one thread (no pool) also in
 * time of that thread, which leaves out what a busy machine adds. Returns 0, or 1 after a message on stderr.
 */
int study_cancelling(const struct scene *scene, const struct tree_settings *build, uint32_t count);

#endif
