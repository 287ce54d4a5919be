/* SPDX-License-Identifier: MIT */
/*
 * The functions of the program around the library, and what a call tells it in words.
 */
#ifndef MLRT_BASE_HOST_H
#define MLRT_BASE_HOST_H

#include "mlrt.h"

/* Copies a host (NULL = none) to *own and checks it. Returns a status. */
int32_t mlrt_take_host(const mlrt_host *given, mlrt_host *own);

/* Where words go: to the log, and why a call fails also to a buffer. */
struct mlrt_voice {
    mlrt_host host; /* checked */
    char *message;  /* may be NULL */
    size_t message_size;
};

/* Readies a buffer for a message that may come: an empty one. */
void mlrt_begin_message(const struct mlrt_voice *voice);

#if defined(__GNUC__)
#define MLRT_FORMAT(text, values) __attribute__((format(printf, text, values)))
#else
#define MLRT_FORMAT(text, values)
#endif

/* One line for the log, if there is one. Long lines are cut. */
MLRT_FORMAT(3, 4) void mlrt_log(const struct mlrt_voice *voice, int32_t level, const char *format, ...);

/* Says why a call fails: to the buffer and the log. */
MLRT_FORMAT(2, 3) void mlrt_explain(const struct mlrt_voice *voice, const char *format, ...);

#endif
