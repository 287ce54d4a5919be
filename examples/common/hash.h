/* SPDX-License-Identifier: MIT */
/*
 * hash.h - a hash of all the answers of a picture
 *
 * Equal pictures have equal hashes on every machine; a single bit that differs gives another hash. Based on: G. Fowler,
 * L. Noll, K.-P. Vo, FNV-1a, 64 bits.
 */
#ifndef HASH_H
#define HASH_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define HASH_START UINT64_C(0xCBF29CE484222325)

static inline uint64_t hash_byte(uint64_t hash, uint8_t byte)
{
    return (hash ^ byte) * UINT64_C(0x100000001B3);
}

/* Four bytes, the lowest first, whatever order the machine has. */
static inline uint64_t hash_uint32(uint64_t hash, uint32_t value)
{
    for (int i = 0; i < 4; i++) hash = hash_byte(hash, (uint8_t)(value >> 8 * i));
    return hash;
}

/* The bits of a float: -0 is not 0, and each NaN is itself. */
static inline uint64_t hash_float(uint64_t hash, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return hash_uint32(hash, bits);
}

/* The hits of a picture in pixel order: for each, mesh, triangle, t, u, v. */
static inline uint64_t hash_hits(const uint32_t *mesh, const uint32_t *triangle, const float *t, const float *u,
                                 const float *v, size_t count)
{
    uint64_t hash = HASH_START;
    for (size_t i = 0; i < count; i++) {
        hash = hash_uint32(hash_uint32(hash, mesh[i]), triangle[i]);
        hash = hash_float(hash_float(hash_float(hash, t[i]), u[i]), v[i]);
    }
    return hash;
}

static inline uint64_t hash_bytes(const uint8_t *bytes, size_t count)
{
    uint64_t hash = HASH_START;
    for (size_t i = 0; i < count; i++) hash = hash_byte(hash, bytes[i]);
    return hash;
}

#endif
