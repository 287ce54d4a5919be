/* SPDX-License-Identifier: MIT */
/*
 * The last message of each thread: why its last call that failed did so (mlrt_last_message).
 */
#ifndef MLRT_BASE_MESSAGE_H
#define MLRT_BASE_MESSAGE_H

#include "mlrt.h"

/* Of a message: the 255 bytes that mlrt.h promises at most, and the NUL. */
#define MLRT_MESSAGE_SIZE 256

/* The buffer of the calling thread, MLRT_MESSAGE_SIZE bytes: a string, empty until a call of the thread fails. */
char *mlrt_message_of_thread(void);

/* Returns `status`. Unless it is MLRT_OK, the message of the thread becomes what the status means. */
int32_t mlrt_note_status(int32_t status);

/* What a status code means: mlrt_status_string. */
const char *mlrt_meaning_of(int32_t status);

#endif
