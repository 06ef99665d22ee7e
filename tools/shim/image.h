/* image.h - images in and out, by OpenImageIO, with nothing of it visible. It is loaded at the first call.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EPATCH_IMAGE_H
#define EPATCH_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum image_kind {
    IMAGE_NONE,    /* no format that can be written has this extension         */
    IMAGE_DISPLAY, /* 8 or 16 bits a sample: values in [0, 1] as a display takes them */
    IMAGE_LINEAR   /* floats, proportional to light                             */
} image_kind;

/* What the extension of `path` stands for. `many`: the image has more than three channels. */
image_kind image_kind_of(const char *path, bool many);

/* Does the format take any number of channels? */
bool image_takes_channels(const char *path);

/* The extensions that can be written, as "bmp dpx exr ...". */
void image_extensions(char *list, size_t size);

/* At most this many threads; 0: all. */
void image_threads(unsigned threads);

typedef struct image {
    unsigned width, height, channels;
    const char *const *names; /* of the channels: "R", "G", "B", "depth.Z", ... */
    const float *pixels;      /* interleaved, top row first */
    image_kind kind;
} image;

/* Encodes in the format of `path`'s extension; nothing but that is made of `path`. The bytes go to `file`, whose
 * errors are the caller's to notice. False with a sentence in `why`. */
bool image_write(const image *im, const char *path, FILE *file, char *why, size_t size);

/* Three floats a pixel, linear, top row first; the caller frees them. NULL with a sentence in `why`. */
float *image_read(const char *path, unsigned *width, unsigned *height, char *why, size_t size);

#ifdef __cplusplus
}
#endif
#endif
