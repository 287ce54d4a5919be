/* SPDX-License-Identifier: MIT */
/*
 * All that depends on compiler, processor and system: inlining, alignment, bits, and the floating-point environment.
 * Also the settings that every error bound of the library relies on: no contraction of a * b + c, and float arithmetic
 * that is done in float. It is that of IEEE 754 (C99, Annex F): divisions by 0, and doubles beyond the range of float
 * that become floats, give infinities.
 */
#ifndef MLRT_BASE_PLATFORM_H
#define MLRT_BASE_PLATFORM_H

#include <float.h>
#include <stdint.h>

#if defined(__FAST_MATH__)
#error "mlrt needs IEEE arithmetic: do not compile it with -ffast-math"
#endif
#if !defined(FLT_EVAL_METHOD) || FLT_EVAL_METHOD != 0
#error "mlrt needs float arithmetic in float: on 32-bit x86 compile with -msse2 -mfpmath=sse"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

/*
 * 1 in a build that measures the cost of exactness and is never installed (make GUESS=1). There the sign of the first
 * computed value decides, float in packets and double for single rays, with no error bound and no exact arithmetic.
 */
#ifndef MLRT_GUESS
#define MLRT_GUESS 0
#endif

#if !defined(__GNUC__)
#error "mlrt needs gcc or clang, or a compiler with their extensions"
#endif

#define MLRT_INLINE              static inline __attribute__((always_inline, unused))
#define MLRT_NOINLINE            __attribute__((noinline))
#define MLRT_ALIGNED(bytes)      __attribute__((aligned(bytes)))
#define MLRT_LIKELY(condition)   __builtin_expect(!!(condition), 1)
#define MLRT_UNLIKELY(condition) __builtin_expect(!!(condition), 0)

/* A variable that each thread has for itself. */
#define MLRT_THREAD_LOCAL __thread

/*
 * Before a short loop that must be unrolled at every level of optimisation. Without any, gcc would not unroll it, and
 * would warn.
 */
#if !defined(__clang__) && __GNUC__ >= 8 && defined(__OPTIMIZE__)
#define MLRT_UNROLL _Pragma("GCC unroll 9")
#else
#define MLRT_UNROLL
#endif

/*
 * To gcc a prefetch has no effect: a function that does nothing else is pure, and calls of it are dropped. An empty
 * statement in assembler, which counts as one, keeps them. `level` is 3 for the first-level cache, 2 for the second.
 */
#define MLRT_PREFETCH(address, for_writing, level)                                                                     \
    do {                                                                                                               \
        __asm__ __volatile__("");                                                                                      \
        __builtin_prefetch(address, for_writing, level);                                                               \
    } while (0)

/* Prefetches the cache line at `address`, to be read soon. */
MLRT_INLINE void mlrt_prefetch(const void *address)
{
    MLRT_PREFETCH(address, 0, 3);
}

/* How many bits are set. */
MLRT_INLINE uint32_t mlrt_count_bits(uint32_t bits)
{
#if defined(__POPCNT__)
    return (uint32_t)__builtin_popcount(bits);
#else
    bits -= bits >> 1 & 0x55555555u;
    bits = (bits & 0x33333333u) + (bits >> 2 & 0x33333333u);
    return ((bits + (bits >> 4)) & 0x0F0F0F0Fu) * 0x01010101u >> 24;
#endif
}

/* The position of the lowest bit that is set; `bits` is not 0. */
MLRT_INLINE uint32_t mlrt_lowest_bit(uint32_t bits)
{
    return (uint32_t)__builtin_ctz(bits);
}

#if defined(__SSE2__) || defined(__x86_64__)
#define MLRT_HAVE_SSE 1
#else
#define MLRT_HAVE_SSE 0
#endif

/* 1 in a build whose kernels are plain C on any processor, to test them (make SCALAR=1). */
#ifndef MLRT_SCALAR
#define MLRT_SCALAR 0
#endif

/* Says that a thread spins. */
#if MLRT_HAVE_SSE
#define MLRT_PAUSE() __builtin_ia32_pause()
#else
#define MLRT_PAUSE() ((void)0)
#endif

/* Which kernels there are: those of SSE2, AVX2 and AVX-512, or of NEON, or else plain C. */
#define MLRT_SSE_KERNELS (MLRT_HAVE_SSE && !MLRT_SCALAR)
#if defined(__aarch64__) && !defined(__AARCH64EB__) && !MLRT_SCALAR
#define MLRT_NEON_KERNELS 1
#else
#define MLRT_NEON_KERNELS 0
#endif

/* The number of processors that are online. Needs <unistd.h>; on Windows, the <pthread.h> of winpthreads. */
#if defined(_WIN32)
#define MLRT_ONLINE_PROCESSORS() pthread_num_processors_np()
#else
#define MLRT_ONLINE_PROCESSORS() sysconf(_SC_NPROCESSORS_ONLN)
#endif

/*
 * The library computes with round to nearest, denormals kept, and exceptions masked. mlrt_enter_fp_environment saves
 * the caller's environment and sets that one if it is another; mlrt_leave_fp_environment restores what was saved then.
 * Exception flags are left as arithmetic raised them, since to lower them again can take 100 ns (docs/tried.md, "What
 * paid"). Every exported function that computes with floats, and every thread's work, runs between the two: mostly as
 * MLRT_COMPUTE, which is given a statement. This must be a call of a function that is not inlined, so that the compiler
 * moves no arithmetic out of it.
 */
#define MLRT_COMPUTE(statement)                                                                                        \
    do {                                                                                                               \
        mlrt_fp_environment callers_environment;                                                                       \
        mlrt_enter_fp_environment(&callers_environment);                                                               \
        statement;                                                                                                     \
        mlrt_leave_fp_environment(&callers_environment);                                                               \
    } while (0)

#if MLRT_HAVE_SSE
#include <xmmintrin.h>
#define MLRT_WANTED_CONTROL 0x1F80u   /* round to nearest, all exceptions masked; no flush to zero */
#define MLRT_CONTROL_BITS   0xFFC0u   /* the other bits are exception flags */
typedef uint32_t mlrt_fp_environment; /* the control register */
/*
 * Sets *saved to the environment. Returns 1 if it is that of the library, except for exception flags. Then the caller
 * may compute at once: compilers do not move arithmetic before the branch on this result, since it may trap. gcc takes
 * two calls of _mm_getcsr without a store between them for one: hence the statement in assembler.
 */
MLRT_INLINE int mlrt_has_usual_fp_environment(mlrt_fp_environment *saved)
{
    __asm__ volatile("stmxcsr %0" : "=m"(*saved));
    return (*saved & MLRT_CONTROL_BITS) == MLRT_WANTED_CONTROL;
}
MLRT_INLINE void mlrt_enter_fp_environment(mlrt_fp_environment *saved)
{
    if (MLRT_UNLIKELY(!mlrt_has_usual_fp_environment(saved))) _mm_setcsr(MLRT_WANTED_CONTROL);
}
MLRT_INLINE void mlrt_leave_fp_environment(const mlrt_fp_environment *saved)
{
    if (MLRT_UNLIKELY((*saved & MLRT_CONTROL_BITS) != MLRT_WANTED_CONTROL)) _mm_setcsr(*saved);
}
#else
#if defined(__aarch64__)
typedef uint64_t mlrt_fp_environment;
MLRT_INLINE void mlrt_enter_fp_environment(mlrt_fp_environment *saved)
{
    __asm__ volatile("mrs %0, fpcr" : "=r"(*saved));
    __asm__ volatile("msr fpcr, %0" : : "r"((uint64_t)0) : "memory");
}
MLRT_INLINE void mlrt_leave_fp_environment(const mlrt_fp_environment *saved)
{
    __asm__ volatile("msr fpcr, %0" : : "r"(*saved) : "memory");
}
#else
#include <fenv.h>
typedef int mlrt_fp_environment;
MLRT_INLINE void mlrt_enter_fp_environment(mlrt_fp_environment *saved)
{
    *saved = fegetround();
    fesetround(FE_TONEAREST);
}
MLRT_INLINE void mlrt_leave_fp_environment(const mlrt_fp_environment *saved)
{
    fesetround(*saved);
}
#endif
MLRT_INLINE int mlrt_has_usual_fp_environment(mlrt_fp_environment *saved)
{
    (void)saved;
    return 0;
}
#endif

#endif
