/* SPDX-License-Identifier: MIT */
/*
 * The host's functions, and messages: see host.h.
 */
#include "base/host.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/structs.h"

/* Of a line for the log: the 255 bytes that mlrt.h promises at most, and the NUL. */
#define LINE_SIZE 256

int32_t mlrt_take_host(const mlrt_host *given, mlrt_host *own)
{
    memset(own, 0, sizeof *own);
    if (!given) return MLRT_OK;
    const int32_t status = mlrt_take_struct(given, MLRT_SIZE_UP_TO(mlrt_host, progress), own, sizeof *own);
    if (status != MLRT_OK) return status;
    return !own->allocate != !own->free || own->reserved != 0 ? MLRT_ERROR_ARGUMENT : MLRT_OK;
}

void mlrt_begin_message(const struct mlrt_voice *voice)
{
    if (voice->message && voice->message_size) voice->message[0] = '\0';
}

static void send(const struct mlrt_voice *voice, int32_t level, const char *line)
{
    if (voice->host.log) voice->host.log(voice->host.user, level, line);
}

void mlrt_log(const struct mlrt_voice *voice, int32_t level, const char *format, ...)
{
    char line[LINE_SIZE];
    va_list values;
    va_start(values, format);
    vsnprintf(line, sizeof line, format, values);
    va_end(values);
    send(voice, level, line);
}

void mlrt_explain(const struct mlrt_voice *voice, const char *format, ...)
{
    char line[LINE_SIZE];
    va_list values;
    va_start(values, format);
    vsnprintf(line, sizeof line, format, values);
    va_end(values);
    if (voice->message && voice->message_size) snprintf(voice->message, voice->message_size, "%s", line);
    send(voice, MLRT_LOG_ERROR, line);
}
