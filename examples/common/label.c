/* SPDX-License-Identifier: MIT */
/* label.c - a font of 4 x 5 dots: see label.h */
#include "label.h"

#include <ctype.h>
#include <string.h>

// Five rows of four dots each, from the top, a hexadecimal digit a row.
static const char digits[10][6] = {"6BD96", "26227", "E168F", "E161E", "99F11",
                                   "F8E1E", "68E96", "F1244", "69696", "69716"};
static const char letters[26][6] = {"69F99", "E9E9E", "78887", "E999E", "F8E8F", "F8E88", "78B97", "99F99", "72227",
                                    "11196", "9ACA9", "8888F", "9FF99", "9DB99", "69996", "E9E88", "699A5", "E9EA9",
                                    "7861E", "E4444", "99996", "99966", "99FF9", "99699", "99716", "F168F"};

static const char *glyph_of(char character)
{
    const int c = toupper((unsigned char)character);
    if (c >= '0' && c <= '9') return digits[c - '0'];
    if (c >= 'A' && c <= 'Z') return letters[c - 'A'];
    return c == '.' ? "00004" : c == '-' ? "00600" : c == '+' ? "04E40" : "00000";
}

static void draw_dot(const struct canvas *canvas, int x, int y, int size)
{
    for (int j = y; j < y + size; j++) {
        for (int i = x; i < x + size; i++) {
            if (i < 0 || j < 0 || i >= (int)canvas->width || j >= (int)canvas->height) continue;
            memset(canvas->rgb + 3 * ((size_t)j * canvas->width + (size_t)i), 255, 3);
        }
    }
}

void draw_label(const struct canvas *canvas, int x, int y, int size, const char *text)
{
    for (; *text; text++, x += LABEL_WIDTH * size) {
        const char *rows = glyph_of(*text);
        for (int row = 0; row < LABEL_HEIGHT; row++) {
            const int dots = rows[row] <= '9' ? rows[row] - '0' : rows[row] - 'A' + 10;
            for (int column = 0; column < 4; column++) {
                if (dots >> (3 - column) & 1) draw_dot(canvas, x + column * size, y + row * size, size);
            }
        }
    }
}
