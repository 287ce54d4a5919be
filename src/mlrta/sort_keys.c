/* SPDX-License-Identifier: MIT */
/* Floats as keys, sorted: see sort_keys.h. */
#include "mlrta/sort_keys.h"

#include <string.h>

/* Up to so many keys, insertion sort is faster: four passes over 256 counters cost as much as inserting 48 keys. */
#define INSERTION_LIMIT 48

static void insertion_sort(uint32_t *keys, size_t count)
{
    for (size_t i = 1; i < count; i++) {
        uint32_t key = keys[i];
        size_t j = i;
        for (; j > 0 && keys[j - 1] > key; j--) keys[j] = keys[j - 1];
        keys[j] = key;
    }
}

static void count_digits(const uint32_t *keys, size_t count, uint32_t counts[4][256])
{
    memset(counts, 0, 4 * sizeof counts[0]);
    for (size_t i = 0; i < count; i++)
        for (int digit = 0; digit < 4; digit++) counts[digit][keys[i] >> (8 * digit) & 255]++;
}

static void sort_by_digit(const uint32_t *keys, size_t count, int shift, const uint32_t counts[256], uint32_t *sorted)
{
    uint32_t place[256];
    uint32_t sum = 0;
    for (int value = 0; value < 256; value++) {
        place[value] = sum;
        sum += counts[value];
    }
    for (size_t i = 0; i < count; i++) sorted[place[keys[i] >> shift & 255]++] = keys[i];
}

/* Radix sort by bytes, the lowest first; bytes that are equal in all keys are skipped. */
void mlrt_sort_keys(uint32_t *keys, uint32_t *spare, size_t count)
{
    if (count <= INSERTION_LIMIT) {
        insertion_sort(keys, count);
        return;
    }
    uint32_t counts[4][256];
    count_digits(keys, count, counts);
    uint32_t *from = keys, *to = spare;
    for (int digit = 0; digit < 4; digit++) {
        if (counts[digit][keys[0] >> (8 * digit) & 255] == count) continue;
        sort_by_digit(from, count, 8 * digit, counts[digit], to);
        uint32_t *swap = from;
        from = to;
        to = swap;
    }
    if (from != keys) memcpy(keys, from, count * sizeof *keys);
}

size_t mlrt_sort_unique_keys(uint32_t *keys, uint32_t *spare, size_t count)
{
    size_t unique_count = 0;
    mlrt_sort_keys(keys, spare, count);
    for (size_t i = 0; i < count; i++)
        if (unique_count == 0 || keys[unique_count - 1] != keys[i]) keys[unique_count++] = keys[i];
    return unique_count;
}
