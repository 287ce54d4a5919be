/* SPDX-License-Identifier: MIT */
/* Which processor gets which kernels. */
#ifndef MLRT_RUN_DISPATCH_H
#define MLRT_RUN_DISPATCH_H

#include "job/structure.h"

/*
 * The kernels of a structure for an MLRT_ISA_* and one of its methods, NULL if this build or this machine lacks the
 * instruction set. If `counting`, they count. They may use a narrower instruction set than the one given.
 */
const struct mlrt_kernels *mlrt_select_kernels(const struct mlrt_structure *structure, int32_t isa, int32_t method,
                                               int counting);

/* The kernels for the widest instruction set of this machine. */
const struct mlrt_kernels *mlrt_widest_kernels(const struct mlrt_structure *structure);

#endif
