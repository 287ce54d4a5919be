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

#include <png.h>

#include <errno.h>
#include <stdlib.h>
#include <sys/stat.h>

static int complain(const char *path, const char *what)
{
    fprintf(stderr, "%s: cannot write the picture: %s\n", path, what);
    return 1;
}

static int write_to(const char *path, const char *name, png_image *image, const uint8_t *rgb)
{
    FILE *file = fopen(path, "wb");
    if (!file) return complain(name, strerror(errno));
    int written = png_image_write_to_stdio(image, file, 0, rgb, 0, NULL);
    if (!written) {
        complain(name, image->message);
        fclose(file);
        return 1;
    }
    return fclose(file) == 0 ? 0 : complain(name, strerror(errno));
}

// A pipe or a device is written to: renaming would replace it by a file.
static int is_special(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

int write_png(const char *path, uint32_t width, uint32_t height, const uint8_t *rgb)
{
    static const char suffix[] = ".part";
    png_image image;
    memset(&image, 0, sizeof image);
    image.version = PNG_IMAGE_VERSION;
    image.width = width;
    image.height = height;
    image.format = PNG_FORMAT_RGB;
    if (is_special(path)) return write_to(path, path, &image, rgb);

    char *part = malloc(strlen(path) + sizeof suffix);
    if (!part) return complain(path, "not enough memory");
    strcat(strcpy(part, path), suffix);
    int failed = write_to(part, path, &image, rgb);
    if (!failed && rename(part, path) != 0) failed = complain(path, strerror(errno));
    if (failed) remove(part);
    free(part);
    return failed;
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
