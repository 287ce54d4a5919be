/* SPDX-License-Identifier: MIT */
/*
 * The hash of words: the same in pieces and on every machine, different after any change.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/hash.h"

static uint64_t hash_of(const void *words, size_t count)
{
    struct mlrt_hash hash;
    mlrt_start_hash(&hash);
    mlrt_add_words(&hash, words, count);
    return mlrt_finish_hash(&hash);
}

static void fill(uint32_t *words, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) words[i] = i * i + 7;
}

/* Files carry it: these numbers are for ever. */
static void test_it_is_the_same_everywhere(void **state)
{
    (void)state;
    uint32_t words[100];
    fill(words, 100);
    assert_true(hash_of(words, 0) == 0xFAD2FA928E2829D6u);
    assert_true(hash_of(words, 1) == 0x115CF5924929934Fu);
    assert_true(hash_of(words, 100) == 0xE45669394DEBA341u);
}

static void test_pieces_are_as_good_as_the_whole(void **state)
{
    (void)state;
    uint32_t words[200];
    fill(words, 200);
    for (size_t length = 0; length <= 200; length += 7) {
        for (size_t piece = 1; piece <= 40; piece++) {
            struct mlrt_hash hash;
            mlrt_start_hash(&hash);
            for (size_t i = 0; i < length; i += piece) {
                mlrt_add_words(&hash, words + i, length - i < piece ? length - i : piece);
            }
            assert_true(mlrt_finish_hash(&hash) == hash_of(words, length));
        }
    }
}

static void test_words_may_lie_anywhere(void **state)
{
    (void)state;
    uint32_t words[50];
    unsigned char bytes[204];
    fill(words, 50);
    for (int offset = 0; offset < 4; offset++) {
        memcpy(bytes + offset, words, sizeof words);
        assert_true(hash_of(bytes + offset, 50) == hash_of(words, 50));
    }
}

static void test_every_bit_matters(void **state)
{
    (void)state;
    uint32_t words[70];
    fill(words, 70);
    const uint64_t whole = hash_of(words, 70);
    for (int bit = 0; bit < 70 * 32; bit++) {
        words[bit / 32] ^= 1u << bit % 32;
        assert_true(hash_of(words, 70) != whole);
        words[bit / 32] ^= 1u << bit % 32;
    }
}

/* Signs of two floats, which are where carries end. */
static void test_every_two_highest_bits_matter(void **state)
{
    (void)state;
    uint32_t words[70];
    fill(words, 70);
    const uint64_t whole = hash_of(words, 70);
    for (int i = 0; i < 70; i++) {
        for (int j = 0; j < i; j++) {
            words[i] ^= 0x80000000u;
            words[j] ^= 0x80000000u;
            assert_true(hash_of(words, 70) != whole);
            words[i] ^= 0x80000000u;
            words[j] ^= 0x80000000u;
        }
    }
}

static void test_order_and_zeros_behind_matter(void **state)
{
    (void)state;
    uint32_t words[64] = {0}, other[64] = {0};
    for (size_t length = 1; length < 64; length++) assert_true(hash_of(words, length) != hash_of(words, length - 1));
    fill(words, 64);
    for (int i = 1; i < 64; i++) {
        memcpy(other, words, sizeof other);
        other[0] = words[i];
        other[i] = words[0];
        assert_true(hash_of(other, 64) != hash_of(words, 64));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_it_is_the_same_everywhere),     cmocka_unit_test(test_pieces_are_as_good_as_the_whole),
        cmocka_unit_test(test_words_may_lie_anywhere),        cmocka_unit_test(test_every_bit_matters),
        cmocka_unit_test(test_every_two_highest_bits_matter), cmocka_unit_test(test_order_and_zeros_behind_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
