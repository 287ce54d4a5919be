/* SPDX-License-Identifier: MIT */
/* Which processor gets which kernels. */
#ifndef MLRT_RUN_DISPATCH_H
#define MLRT_RUN_DISPATCH_H

#include "base/platform.h"
#include "job/structure.h"

/*
 * The kernels of a structure for an MLRT_ISA_* and one of its methods, NULL if this build or this machine lacks the
 * instruction set. If `counting`, they count. They may use a narrower instruction set than the one given.
 */
const struct mlrt_kernels *mlrt_select_kernels(const struct mlrt_structure *structure, int32_t isa, int32_t method,
                                               int counting);

/* The widest instruction set of this machine; 0 = not looked up yet. */
extern int32_t mlrt_known_isa;

/* Is it known that calls may ask for this MLRT_ISA_*? If not, mlrt_select_kernels has to say. */
static inline int mlrt_is_known_isa(int32_t isa)
{
    return MLRT_LIKELY(isa == MLRT_ISA_AUTO) ||
           (isa >= MLRT_ISA_NARROWEST && isa <= __atomic_load_n(&mlrt_known_isa, __ATOMIC_RELAXED));
}

/*
 * The kernels of a structure for an instruction set that mlrt_is_known_isa allows, for calls without counters. NULL:
 * not known yet, ask mlrt_select_kernels.
 */
static inline const struct mlrt_kernels *mlrt_known_kernels(const struct mlrt_structure *structure, int32_t isa)
{
    if (isa == MLRT_ISA_AUTO) isa = __atomic_load_n(&mlrt_known_isa, __ATOMIC_RELAXED);
    return structure->tracer.kernels[isa];
}

#endif
