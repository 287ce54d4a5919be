/* SPDX-License-Identifier: MIT */
/* The host: the functions that the program around the library provides, and the messages that a call gives it. */
#ifndef MLRT_BASE_HOST_H
#define MLRT_BASE_HOST_H

#include "base/message.h"

/*
 * Copies the host that a caller gave (NULL = none) to *own and checks it; `path` names it. Returns a status. After an
 * error *own is that of no host.
 */
int32_t mlrt_take_host(const char *path, const mlrt_host *given, mlrt_host *own);

/* Where messages go besides the message of the thread. */
struct mlrt_voice {
    mlrt_host host; /* checked */
    char *message;  /* the caller's buffer; may be NULL */
    size_t message_size;
};

/* The options that all calls that trace have in common. */
struct mlrt_run_options {
    mlrt_pool *pool;         /* NULL = the calling thread alone */
    mlrt_counters *counters; /* NULL = nothing is counted */
    struct mlrt_voice voice; /* all 0 = no host */
};

/*
 * Begins a call whose options were copied: sets its voice to their message buffer and host, and then checks the fields
 * of the options, which are of this form. So a message about these fields reaches buffer and host. Returns a status.
 */
int32_t mlrt_begin_call(int form, const void *options, char *message, size_t message_size, const mlrt_host *host,
                        struct mlrt_voice *voice);

/* Sends one line to the log, if the host has one. Lines longer than 255 bytes are cut. */
MLRT_FORMAT(3, 4) void mlrt_log(const struct mlrt_voice *voice, int32_t level, const char *format, ...);

/*
 * Ends a call. Unless `status` is MLRT_OK, the message of the thread goes to the caller's buffer and to the log. It
 * stays as it is, whatever calls the log makes. Returns `status`.
 */
int32_t mlrt_end_call(const struct mlrt_voice *voice, int32_t status);

#endif
