/* SPDX-License-Identifier: MIT */
/* png_write.c - writes a picture as a PNG file: see png_write.h. Built without libpng, it reports that on stderr. */
#define _POSIX_C_SOURCE 200112L

#include "png_write.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

int check_png_name(const char *path)
{
    const size_t length = strlen(path);
    if (strncmp(path, "/dev/", 5) == 0 || (length > 4 && strcasecmp(path + length - 4, ".png") == 0)) return 0;
    fprintf(stderr, "%s: pictures are PNG files, so the name must end in .png\n", path);
    return 1;
}

#ifdef HAVE_PNG

#include "file.h"

#include <png.h>

int write_png(const char *path, uint32_t width, uint32_t height, const uint8_t *rgb)
{
    struct output_file output;
    png_image image;
    memset(&image, 0, sizeof image);
    image.version = PNG_IMAGE_VERSION;
    image.width = width;
    image.height = height;
    image.format = PNG_FORMAT_RGB;
    if (open_output(path, &output)) return 1;
    const int failed = !png_image_write_to_stdio(&image, output.file, 0, rgb, 0, NULL);
    if (failed) fprintf(stderr, "%s: cannot write the picture: %s\n", path, image.message);
    return close_output(&output, failed);
}

#else

int write_png(const char *path, uint32_t width, uint32_t height, const uint8_t *rgb)
{
    (void)width, (void)height, (void)rgb;
    fprintf(stderr,
            "%s: this program was built without libpng, which writes pictures. Install it (Debian, Ubuntu: apt-get "
            "install\n"
            "libpng-dev; or: make deps) and build again.\n",
            path);
    return 1;
}

#endif
