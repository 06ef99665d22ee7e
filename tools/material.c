/* material.c - a small vocabulary.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/material.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <strings.h>

typedef struct word {
    const char *name;
    vec3 colour;
} word;

typedef struct finish {
    const char *name;
    vec3 colour;
    float reflection, roughness;
} finish;

static const word colours[] = {
    {"white", {0.80f, 0.80f, 0.79f}},  {"ivory", {0.76f, 0.70f, 0.55f}},   {"grey", {0.30f, 0.30f, 0.30f}},
    {"gray", {0.30f, 0.30f, 0.30f}},   {"black", {0.025f, 0.025f, 0.03f}}, {"red", {0.60f, 0.045f, 0.035f}},
    {"orange", {0.75f, 0.23f, 0.03f}}, {"yellow", {0.80f, 0.52f, 0.05f}},  {"green", {0.10f, 0.36f, 0.09f}},
    {"teal", {0.03f, 0.30f, 0.31f}},   {"blue", {0.045f, 0.14f, 0.50f}},   {"violet", {0.24f, 0.09f, 0.42f}},
    {"purple", {0.24f, 0.09f, 0.42f}}, {"pink", {0.78f, 0.33f, 0.38f}},    {"brown", {0.24f, 0.12f, 0.06f}},
};

/* With the colour they have when none is named. The first is the default. */
static const finish finishes[] = {
    {"clay", {0.54f, 0.52f, 0.49f}, 0.035f, 0.22f},
    {"plastic", {0.55f, 0.55f, 0.55f}, 0.045f, 0.10f},
    {"porcelain", {0.78f, 0.78f, 0.76f}, 0.05f, 0.02f},
    {"glazed", {0.78f, 0.78f, 0.76f}, 0.05f, 0.02f},
    {"paint", {0.60f, 0.60f, 0.60f}, 0.04f, 0.30f},
    {"rubber", {0.04f, 0.04f, 0.04f}, 0.03f, 0.50f},
    {"paper", {0.50f, 0.495f, 0.48f}, 0, 1},
    {"wood", {0.30f, 0.17f, 0.08f}, 0.035f, 0.25f},
    {"slate", {0.11f, 0.13f, 0.155f}, 0, 1},
    {"stone", {0.27f, 0.265f, 0.26f}, 0, 1},
};

/* Their colour is that of the reflection. */
static const finish metals[] = {
    {"mirror", {0.96f, 0.96f, 0.96f}, 1, 0},       {"chrome", {0.80f, 0.81f, 0.82f}, 1, 0.01f},
    {"silver", {0.95f, 0.94f, 0.91f}, 1, 0.06f},   {"steel", {0.62f, 0.63f, 0.64f}, 1, 0.20f},
    {"iron", {0.46f, 0.45f, 0.44f}, 1, 0.32f},     {"aluminium", {0.87f, 0.88f, 0.88f}, 1, 0.28f},
    {"aluminum", {0.87f, 0.88f, 0.88f}, 1, 0.28f}, {"gold", {1.00f, 0.71f, 0.29f}, 1, 0.08f},
    {"brass", {0.88f, 0.74f, 0.40f}, 1, 0.14f},    {"copper", {0.93f, 0.55f, 0.42f}, 1, 0.10f},
    {"bronze", {0.66f, 0.47f, 0.27f}, 1, 0.20f},
};

#define COUNT(a) (sizeof(a) / sizeof *(a))

static bool is_word(const char *name, const char *text, size_t length)
{
    return strlen(name) == length && !strncasecmp(name, text, length);
}

static const finish *find_finish(const finish *list, size_t count, const char *text, size_t length)
{
    for (size_t i = 0; i < count; ++i)
        if (is_word(list[i].name, text, length)) return &list[i];
    return NULL;
}

/* Full hue circle, even lightness: one cosine a channel, a third of a turn apart. */
static vec3 colour_of_hash(const char *name)
{
    uint32_t h = 2166136261u; /* FNV-1a */
    for (; *name; ++name) h = (h ^ (unsigned char)*name) * 16777619u;
    float hue = (float)(h >> 8) * 0x1p-24f * 6.2831853f;
    return vec(0.34f + 0.26f * cosf(hue), 0.30f + 0.22f * cosf(hue - 2.0944f), 0.32f + 0.26f * cosf(hue + 2.0944f));
}

material material_named(const char *name)
{
    const finish *f = &finishes[0];
    const vec3 *colour = NULL;
    bool metal = false, known = !name;

    for (const char *at = name; at && *at;) {
        size_t n = strcspn(at, " _-");
        for (size_t i = 0; i < COUNT(colours); ++i)
            if (is_word(colours[i].name, at, n)) colour = &colours[i].colour, known = true;
        const finish *g = find_finish(finishes, COUNT(finishes), at, n);
        if (g) f = g, metal = false, known = true;
        g = find_finish(metals, COUNT(metals), at, n);
        if (g) f = g, metal = true, known = true;
        at += n;
        at += strspn(at, " _-");
    }

    vec3 c = !known ? colour_of_hash(name) : colour ? *colour : f->colour;
    if (metal) return (material){vec_grey(0), c, f->roughness};
    return (material){c, vec_grey(f->reflection), f->roughness};
}
