/* image_load.c - the functions of image.h, out of a module that is loaded when the first of them is called.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * OpenImageIO comes with some 250 libraries, and the system needs a third of a second to load them: far longer than
 * most files of rays take. Only commands that touch an image wait for it. */
#include "tools/shim/image.h"
#include "tools/shim/module.h"

static void *module;

#define CALL(name, ...) ((__typeof__(&name))module_function(&module, "epatch_image.so", #name))(__VA_ARGS__)

image_kind image_kind_of(const char *path, bool many)
{
    return CALL(image_kind_of, path, many);
}

bool image_takes_channels(const char *path)
{
    return CALL(image_takes_channels, path);
}

void image_extensions(char *list, size_t size)
{
    CALL(image_extensions, list, size);
}

void image_threads(unsigned threads)
{
    CALL(image_threads, threads);
}

bool image_write(const image *im, const char *path, FILE *file, char *why, size_t size)
{
    return CALL(image_write, im, path, file, why, size);
}

float *image_read(const char *path, unsigned *width, unsigned *height, char *why, size_t size)
{
    return CALL(image_read, path, width, height, why, size);
}
