/* SPDX-License-Identifier: MIT */
/* The host's functions, and messages: see host.h. */
#include "base/host.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/structs.h"

int32_t mlrt_take_host(const char *path, const mlrt_host *given, mlrt_host *own)
{
    memset(own, 0, sizeof *own);
    if (!given) return MLRT_OK;
    int32_t status = mlrt_take_struct(MLRT_STRUCT_HOST, path, 0, given, own);
    if (status == MLRT_OK && !own->allocate != !own->free)
        status = mlrt_fail(MLRT_ERROR_ARGUMENT, "%s: `allocate` without `free`, or `free` without `allocate`", path);
    if (status != MLRT_OK) memset(own, 0, sizeof *own);
    return status;
}

int32_t mlrt_begin_call(int form, const void *options, char *message, size_t message_size, const mlrt_host *host,
                        struct mlrt_voice *voice)
{
    voice->message = message;
    voice->message_size = message_size;
    if (message && message_size) message[0] = '\0';
    const int32_t status = mlrt_take_host("options.host", host, &voice->host);
    return status == MLRT_OK ? mlrt_check_fields(form, "options", 0, options) : status;
}

static void send(const struct mlrt_voice *voice, int32_t level, const char *line)
{
    if (voice->host.log) voice->host.log(voice->host.user, level, line);
}

void mlrt_log(const struct mlrt_voice *voice, int32_t level, const char *format, ...)
{
    char line[MLRT_MESSAGE_SIZE];
    va_list values;
    va_start(values, format);
    vsnprintf(line, sizeof line, format, values);
    va_end(values);
    send(voice, level, line);
}

int32_t mlrt_end_call(const struct mlrt_voice *voice, int32_t status)
{
    if (status == MLRT_OK) return status;
    char line[MLRT_MESSAGE_SIZE], *message = mlrt_message_of_thread();
    snprintf(line, sizeof line, "%s", message);
    if (voice->message && voice->message_size) snprintf(voice->message, voice->message_size, "%s", line);
    send(voice, status == MLRT_ERROR_CANCELLED ? MLRT_LOG_INFO : MLRT_LOG_ERROR, line);
    snprintf(message, MLRT_MESSAGE_SIZE, "%s", line);
    return status;
}
