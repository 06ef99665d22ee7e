/* film.c - channels, the display's transfer curve, and the file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/film.h"
#include "tools/report.h"
#include "tools/shim/image.h"
#include "tools/vec.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

static const struct {
    unsigned count;
    const char *names[3];
} layer_channels[LAYER_COUNT] = {
    [LAYER_DEPTH] = {1, {"depth.Z"}},    [LAYER_NORMAL] = {3, {"normal.X", "normal.Y", "normal.Z"}},
    [LAYER_UV] = {2, {"uv.U", "uv.V"}},  [LAYER_PRIM] = {1, {"prim.ID"}},
    [LAYER_OBJECT] = {1, {"object.ID"}}, [LAYER_ITERATIONS] = {1, {"iterations.N"}},
    [LAYER_SLOW] = {1, {"slow.N"}},
};

unsigned film_layer_size(film_layer layer)
{
    return layer_channels[layer].count;
}

bool film_new(film *f, unsigned width, unsigned height, unsigned layers)
{
    *f = (film){.width = width, .height = height, .channels = 3, .layers = layers, .names = {"R", "G", "B"}};
    for (unsigned layer = 0; layer < LAYER_COUNT; ++layer) {
        if (!(layers >> layer & 1)) continue;
        f->first[layer] = f->channels;
        for (unsigned k = 0; k < layer_channels[layer].count; ++k)
            f->names[f->channels++] = layer_channels[layer].names[k];
    }
    size_t pixels = (size_t)width * height;
    if (pixels > SIZE_MAX / sizeof(float) / f->channels) return false;
    f->pixels = calloc(pixels * f->channels, sizeof(float));
    return f->pixels != NULL;
}

void film_free(film *f)
{
    free(f->pixels);
    f->pixels = NULL;
}

/* Linear up to the knee, then bending towards 1 with the same slope, so that highlights keep their shape. */
static float shoulder(float x)
{
    const float knee = 0.72f;
    return x <= knee ? x : knee + (1 - knee) * (1 - expf((knee - x) / (1 - knee)));
}

static float srgb(float x)
{
    return x <= 0.0031308f ? 12.92f * maxf(x, 0) : 1.055f * powf(x, 1 / 2.4f) - 0.055f;
}

bool film_suits(const char *path, unsigned layers, char *why, size_t size)
{
    if (image_kind_of(path, layers != 0) == IMAGE_NONE) {
        char list[400];
        image_extensions(list, sizeof list);
        snprintf(why, size, "-o %s: the extension must be one of %s", path, list);
        return false;
    }
    if (layers && !image_takes_channels(path)) {
        snprintf(why, size, "--aov needs an image with many channels: -o FILE.exr, or FILE.tif without channel names");
        return false;
    }
    return true;
}

bool film_write(film *f, output *o)
{
    image im = {f->width, f->height, f->channels, f->names, f->pixels, image_kind_of(o->path, f->layers != 0)};
    if (im.kind == IMAGE_DISPLAY) {
        size_t count = (size_t)f->width * f->height * f->channels;
        for (size_t i = 0; i < count; ++i) f->pixels[i] = srgb(shoulder(f->pixels[i]));
    }

    char why[300];
    if (image_write(&im, o->path, o->file, why, sizeof why)) return output_close(o);
    report_file(o->path, "cannot write: %s", why);
    output_discard(o);
    return false;
}
