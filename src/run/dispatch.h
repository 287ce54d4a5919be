/* SPDX-License-Identifier: MIT */
/*
 * Which processor gets which kernels.
 */
#ifndef MLRT_RUN_DISPATCH_H
#define MLRT_RUN_DISPATCH_H

#include "job/job.h"

/*
 * The kernels for an MLRT_ISA_* and an MLRT_METHOD_*, NULL if this build or this machine lacks the instruction set. If
 * `counting`, they count. They may use a narrower instruction set than the one given.
 */
const struct mlrt_kernels *mlrt_select_kernels(int32_t isa, int32_t method, int counting);

/* The kernels of MLRT_METHOD_TILE for the widest instruction set of this machine. They do not count. */
const struct mlrt_kernels *mlrt_widest_kernels(void);

#endif
