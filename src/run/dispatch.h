/* SPDX-License-Identifier: MIT */
/*
 * Which processor gets which kernels.
 */
#ifndef MLRT_RUN_DISPATCH_H
#define MLRT_RUN_DISPATCH_H

#include "job/job.h"

/*
 * The kernels for an MLRT_ISA_* and an MLRT_METHOD_*, with or without counting: they may use less of the machine than
 * was asked for. NULL if this build or machine lacks the instruction set.
 */
const struct mlrt_kernels *mlrt_select_kernels(int32_t isa, int32_t method, int counting);

/* Those of method tile for the widest instruction set there is, which do not count. */
const struct mlrt_kernels *mlrt_widest_kernels(void);

#endif
