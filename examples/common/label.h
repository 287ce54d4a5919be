/* SPDX-License-Identifier: MIT */
/* label.h - words and numbers within a picture, in a font of 4 x 5 dots */
#ifndef LABEL_H
#define LABEL_H

#include <stdint.h>

enum { LABEL_WIDTH = 5, LABEL_HEIGHT = 5 }; /* of a letter with the gap behind it, in dots */

/* A picture of 3 bytes per pixel. */
struct canvas {
    uint8_t *rgb;
    uint32_t width, height;
};

/*
 * Draws a text in white, its upper left corner at (x, y), each dot `size` pixels wide and high. Letters appear as
 * capitals; characters other than letters, digits, . + and - are gaps. What lies outside the picture is left out.
 */
void draw_label(const struct canvas *canvas, int x, int y, int size, const char *text);

#endif
