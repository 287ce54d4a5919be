/* SPDX-License-Identifier: MIT */
/* png_write.h - writes a picture as a PNG file */
#ifndef PNG_WRITE_H
#define PNG_WRITE_H

#include <stdint.h>

/*
 * Writes 3 bytes (red, green, blue, as sRGB) per pixel, rows from the top. The file appears whole or not at all
 * (file.h). Returns 0, or 1 after a message on stderr.
 */
int write_png(const char *path, uint32_t width, uint32_t height, const uint8_t *rgb);

/*
 * Returns 0 if the name ends in .png or is that of a device such as /dev/stdout, or else 1 after a message on stderr.
 */
int check_png_name(const char *path);

#endif
