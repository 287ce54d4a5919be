/* SPDX-License-Identifier: MIT */
/*
 * Which processor gets which kernels. Instruction sets are looked up once per process: CPUID takes long in a virtual
 * machine.
 *
 * Calls with counters get kernels of the narrowest instruction set: SSE2, NEON, or plain C where there is neither.
 * These count in calls without counters, too. Kernels that count for every instruction set would nearly double the size
 * of the library.
 */
#include "run/dispatch.h"

#include "job/job.h"

#if MLRT_SSE_KERNELS
#include <cpuid.h>

/* Bits of the wide registers that the operating system saves (XCR0). */
static uint32_t saved_registers(void)
{
    uint32_t low, high;
    __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}

/*
 * The widest instruction set that processor and operating system support. The bits are from Intel, "Intel 64 and IA-32
 * Architectures Software Developer's Manual", volume 1, sections 14.3 and 15.2-15.4: OSXSAVE and FMA; AVX2, AVX512F and
 * AVX512DQ; the saved registers.
 */
static int32_t find_widest(void)
{
    const uint32_t avx2 = bit_AVX2, avx512 = bit_AVX512F | bit_AVX512DQ, needed = bit_OSXSAVE | bit_FMA;
    uint32_t a, b, c, d;
    if (!__get_cpuid(1, &a, &b, &c, &d) || (c & needed) != needed) return MLRT_ISA_SSE;
    const uint32_t saved = saved_registers();
    if (!__get_cpuid_count(7, 0, &a, &b, &c, &d) || !(b & avx2) || (saved & 0x06) != 0x06) return MLRT_ISA_SSE;
    return (b & avx512) == avx512 && (saved & 0xE6) == 0xE6 ? MLRT_ISA_AVX512 : MLRT_ISA_AVX2;
}

int32_t mlrt_known_isa; /* the only static data that the library writes, but for the last message of each thread */

/* Threads that look it up at the same time find the same. */
static int32_t widest_isa(void)
{
    int32_t isa = __atomic_load_n(&mlrt_known_isa, __ATOMIC_RELAXED);
    if (!isa) __atomic_store_n(&mlrt_known_isa, isa = find_widest(), __ATOMIC_RELAXED);
    return isa;
}
#else
int32_t mlrt_known_isa = MLRT_ISA_NARROWEST;

static int32_t widest_isa(void)
{
    return MLRT_ISA_NARROWEST;
}
#endif

const struct mlrt_kernels *mlrt_select_kernels(const struct mlrt_structure *structure, int32_t isa, int32_t method,
                                               int counting)
{
    const int32_t widest = widest_isa();
    if (isa == MLRT_ISA_AUTO) isa = widest;
    if (isa > widest || isa < MLRT_ISA_NARROWEST) return NULL;
    /* Only the narrowest count. Squares of 2x2 rays have four lanes, so packets of them gain nothing from eight. */
    if (counting || method == MLRT_METHOD_PACKET2) isa = MLRT_ISA_NARROWEST;
    while (!structure->tracer.kernels[isa]) --isa;
    return structure->tracer.kernels[isa];
}
