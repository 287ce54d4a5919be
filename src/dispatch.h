/* SPDX-License-Identifier: MIT */
/*
 * Which processor gets which kernels.
 */
#ifndef MLRT_DISPATCH_H
#define MLRT_DISPATCH_H

#include "kernels.h"

/* The kernels for an MLRT_ISA_*, with or without counting; NULL if this build or machine has none. */
const struct mlrt_kernels *mlrt_select_kernels(int32_t isa, int counting);

#endif
