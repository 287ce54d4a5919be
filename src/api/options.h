/* SPDX-License-Identifier: MIT */
/*
 * Options of a call, resolved: query, method, kernels and tiles of its job. Defaults follow from the tree's structure.
 */
#ifndef MLRT_API_OPTIONS_H
#define MLRT_API_OPTIONS_H

#include "job/job.h"

/*
 * Checks the options, and sets what follows from them and from the tree in a job whose source is set. The job has
 * neither lights nor a callback so far. Returns a status.
 */
int32_t mlrt_resolve_options(const mlrt_tree *tree, const mlrt_trace_options *options, struct mlrt_job *job);

/* Sets the fields of a job that few rays need, of plain options. Returns 0 if the kernels are not known at once. */
int mlrt_set_plain_options(const mlrt_tree *tree, const mlrt_trace_options *options, struct mlrt_job *job);

#endif
