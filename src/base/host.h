/* SPDX-License-Identifier: MIT */
/*
 * The host: the functions that the program around the library provides, and the messages that a call gives it.
 */
#ifndef MLRT_BASE_HOST_H
#define MLRT_BASE_HOST_H

#include "mlrt.h"

/* Copies the host that a caller gave (NULL = none) to *own and checks it. Returns a status. */
int32_t mlrt_take_host(const mlrt_host *given, mlrt_host *own);

/* Where messages go: all to the host's log, and the reason why a call fails also to the caller's buffer. */
struct mlrt_voice {
    mlrt_host host; /* checked */
    char *message;  /* the caller's buffer; may be NULL */
    size_t message_size;
};

/* Makes the caller's buffer an empty string, for calls that end without a message. */
void mlrt_begin_message(const struct mlrt_voice *voice);

#if defined(__GNUC__)
#define MLRT_FORMAT(text, values) __attribute__((format(printf, text, values)))
#else
#define MLRT_FORMAT(text, values)
#endif

/* Sends one line to the log, if the host has one. Lines longer than 255 bytes are cut. */
MLRT_FORMAT(3, 4) void mlrt_log(const struct mlrt_voice *voice, int32_t level, const char *format, ...);

/* Writes the reason why a call fails to the caller's buffer and sends it to the log. */
MLRT_FORMAT(2, 3) void mlrt_explain(const struct mlrt_voice *voice, const char *format, ...);

#endif
