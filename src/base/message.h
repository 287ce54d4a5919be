/* SPDX-License-Identifier: MIT */
/*
 * The last message of each thread: why its last call that failed did so (mlrt_last_message).
 *
 * Whoever finds the reason of an error writes it down by one of the functions here and returns their result. Errors
 * that can come from any depth, and from any thread of a pool (MLRT_ERROR_OUT_OF_MEMORY, _THREAD, _CANCELLED), have no
 * reason but their name: the function that began the work notes it when the work is back (mlrt_note_status).
 *
 * A message names argument, value and rule: "rays.t_max: stride 13 is not a multiple of 4". It is ASCII, so that it can
 * be cut anywhere.
 */
#ifndef MLRT_BASE_MESSAGE_H
#define MLRT_BASE_MESSAGE_H

#include "mlrt.h"

/* Of a message: the 255 bytes that mlrt.h promises at most, and the NUL. */
#define MLRT_MESSAGE_SIZE 256

/* The buffer of the calling thread, MLRT_MESSAGE_SIZE bytes: a string, empty until a call of the thread fails. */
char *mlrt_message_of_thread(void);

#define MLRT_FORMAT(text, values) __attribute__((format(printf, text, values)))

/* Writes the message of the thread. Returns `status`. */
MLRT_FORMAT(2, 3) int32_t mlrt_fail(int32_t status, const char *format, ...);

/*
 * Writes that an argument must not be NULL. `names` has those that must not, with a blank between two; bit i of
 * `missing` says that the i-th is NULL. If no bit is set, the last name is the one that is NULL. Returns
 * MLRT_ERROR_ARGUMENT.
 */
int32_t mlrt_fail_null(const char *names, int missing);

/*
 * Writes where a value stands, and behind a colon the rest of the message: "rays.t_min: ...", or with a path that has a
 * "%lu" for the index "meshes[2].mask: ...". Without a field ("") the path stands alone, and without a path the field.
 * Returns `status`.
 */
MLRT_FORMAT(5, 6)
int32_t mlrt_fail_at(int32_t status, const char *path, size_t index, const char *field, const char *format, ...);

/* Room for any number of 64 bits in decimal digits. */
#define MLRT_DIGITS 21

/* Writes a number to the end of `digits`, and returns where it begins. No format of C99 does so on every system. */
const char *mlrt_write_digits(uint64_t number, char digits[MLRT_DIGITS]);

/* What a status code means: mlrt_status_string. */
const char *mlrt_meaning_of(int32_t status);

/* Writes what a status means, unless it is MLRT_OK. Returns it. */
int32_t mlrt_note_status(int32_t status);

#endif
