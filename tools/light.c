/* light.c - the studio, the panorama and their irradiance.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/light.h"
#include "tools/report.h"
#include "tools/shim/image.h"

#include <stdlib.h>

#define PI 3.14159265f

/* The studio's lamps; direction: right, up, back. The first is the key light, above the viewer's left shoulder; then
 * a strip on the right that draws the far edge, and a lamp overhead. */
static const struct {
    float direction[3], width, height, radiance;
} lamps[STUDIO_BOXES] = {
    {{-0.74f, 0.62f, 0.34f}, 0.42f, 0.34f, 5.0f},
    {{0.90f, 0.18f, -0.25f}, 0.13f, 0.75f, 2.6f},
    {{0.10f, 1.00f, -0.35f}, 0.55f, 0.22f, 1.5f},
};

/* Radiance of its walls: overhead, at eye level, below eye level, underfoot. */
static const float zenith = 0.32f, horizon = 0.44f, skirting = 0.26f, nadir = 0.15f;

static const float key_strength = 1.15f, key_spread = 0.16f;

/* Irradiance over pi of a surface that faces the key light. */
static const float full_irradiance = 1.45f;

static void place_lamps(light *l)
{
    for (int i = 0; i < STUDIO_BOXES; ++i) {
        const float *d = lamps[i].direction;
        soft_box *b = &l->boxes[i];
        b->n = vec_unit(vec_madd(vec_madd(vec_scale(d[0], l->right), d[1], l->up), d[2], l->back));
        b->s = vec_unit(vec_cross(l->up, b->n));
        b->t = vec_cross(b->n, b->s);
        b->width = lamps[i].width;
        b->height = lamps[i].height;
        b->radiance = lamps[i].radiance;
    }
}

static vec3 studio_walls(const light *l, vec3 d, float blur)
{
    float z = vec_dot(d, l->up), edge = 0.04f + blur;
    float above = horizon + (zenith - horizon) * smoothf(0, 1, z);
    float below = skirting + (nadir - skirting) * smoothf(0, 1, -z);
    float grey = below + (above - below) * smoothf(-edge, edge, z);
    /* a little cooler above, a little warmer below */
    return vec(grey * (1 - 0.03f * z), grey, grey * (1 + 0.05f * z));
}

static float studio_box(const soft_box *b, vec3 d, float blur)
{
    float c = vec_dot(d, b->n);
    if (!(c > 0)) return 0;
    float edge = 0.03f + blur, x = fabsf(vec_dot(d, b->s)) / c, y = fabsf(vec_dot(d, b->t)) / c;
    float across = 1 - smoothf(b->width - edge, b->width + edge, x);
    float along = 1 - smoothf(b->height - edge, b->height + edge, y);
    /* What blurring spreads it also thins. */
    float thin = minf(1, b->width / edge) * minf(1, b->height / edge);
    return b->radiance * across * along * thin;
}

/* ---- panorama: texel (0, 0) looks up, rows go down, columns turn about the up axis ---- */

static vec3 panorama_texel(const panorama *p, unsigned x, unsigned y)
{
    const float *c = p->rgb + 3 * ((size_t)y * p->width + x);
    return vec(c[0], c[1], c[2]);
}

static vec3 panorama_level(const panorama *p, float u, float v)
{
    float x = u * (float)p->width - 0.5f, y = clampf(v * (float)p->height - 0.5f, 0, (float)(p->height - 1));
    float fx = floorf(x), fy = floorf(y);
    unsigned x0 = (unsigned)((long)fx + (long)p->width) % p->width, x1 = (x0 + 1) % p->width;
    unsigned y0 = (unsigned)fy, y1 = y0 + 1 < p->height ? y0 + 1 : y0;
    vec3 a = vec_mix(panorama_texel(p, x0, y0), panorama_texel(p, x1, y0), x - fx);
    vec3 b = vec_mix(panorama_texel(p, x0, y1), panorama_texel(p, x1, y1), x - fx);
    return vec_mix(a, b, y - fy);
}

static vec3 panorama_radiance(const light *l, vec3 d, float blur)
{
    float u = atan2f(vec_dot(d, l->right), vec_dot(d, l->back)) / (2 * PI) + 0.5f;
    float v = acosf(clampf(vec_dot(d, l->up), -1, 1)) / PI;
    const panorama *p = l->panorama;
    float texels = blur * (float)p->height / PI;
    while (texels > 2 && p->half) p = p->half, texels *= 0.5f;
    vec3 c = panorama_level(p, u, v);
    if (p->half && texels > 1) c = vec_mix(c, panorama_level(p->half, u, v), texels - 1);
    return vec_scale(l->exposure, c);
}

static vec3 panorama_direction(const light *l, float u, float v)
{
    float phi = (u - 0.5f) * 2 * PI, theta = v * PI;
    vec3 d = vec_scale(cosf(theta), l->up);
    d = vec_madd(d, sinf(theta) * sinf(phi), l->right);
    return vec_madd(d, sinf(theta) * cosf(phi), l->back);
}

static panorama *panorama_new(unsigned width, unsigned height)
{
    panorama *p = malloc(sizeof *p);
    if (!p) return NULL;
    *p = (panorama){width, height, malloc(sizeof(float) * 3 * width * height), NULL};
    if (!p->rgb) free(p), p = NULL;
    return p;
}

static void panorama_free(panorama *p)
{
    while (p) {
        panorama *half = p->half;
        free(p->rgb);
        free(p);
        p = half;
    }
}

/* Appends the smaller levels; false without memory. */
static bool panorama_pyramid(panorama *p)
{
    for (; p->width >= 8 && p->height >= 4; p = p->half) {
        p->half = panorama_new(p->width / 2, p->height / 2);
        if (!p->half) return false;
        for (unsigned y = 0; y < p->half->height; ++y)
            for (unsigned x = 0; x < p->half->width; ++x)
                for (unsigned k = 0; k < 3; ++k) {
                    const float *c = p->rgb + 3 * ((size_t)2 * y * p->width + 2 * x) + k, *below = c + 3 * p->width;
                    p->half->rgb[3 * ((size_t)y * p->half->width + x) + k] =
                        0.25f * (c[0] + c[3] + below[0] + below[3]);
                }
    }
    return true;
}

/* ---- irradiance: R. Ramamoorthi, P. Hanrahan, "An efficient representation for irradiance environment maps" ---- */

static void harmonics(vec3 d, float y[9])
{
    y[0] = 0.282095f;
    y[1] = 0.488603f * d.y;
    y[2] = 0.488603f * d.z;
    y[3] = 0.488603f * d.x;
    y[4] = 1.092548f * d.x * d.y;
    y[5] = 1.092548f * d.y * d.z;
    y[6] = 0.315392f * (3 * d.z * d.z - 1);
    y[7] = 1.092548f * d.x * d.z;
    y[8] = 0.546274f * (d.x * d.x - d.y * d.y);
}

enum { GRID_WIDTH = 128, GRID_HEIGHT = 64 };

/* Radiance without the key light. */
static vec3 rest_radiance(const light *l, vec3 d)
{
    if (l->panorama) {
        vec3 c = panorama_radiance(l, d, PI / GRID_HEIGHT);
        /* Inside the key light, what is just around it. */
        float most = vec_max(panorama_radiance(l, d, 0.8f));
        return vec_dot(d, l->key) > 0.97f ? vec_scale(minf(1, most / maxf(vec_max(c), 1e-20f)), c) : c;
    }
    vec3 c = studio_walls(l, d, 0);
    for (int i = 1; i < STUDIO_BOXES; ++i) c = vec_add(c, vec_grey(studio_box(&l->boxes[i], d, 0)));
    return c;
}

static void project_ambient(light *l)
{
    static const float cosine_lobe[9] = {1, 2.0f / 3, 2.0f / 3, 2.0f / 3, 0.25f, 0.25f, 0.25f, 0.25f, 0.25f};
    for (int k = 0; k < 9; ++k) l->ambient[k] = vec_grey(0);
    for (int j = 0; j < GRID_HEIGHT; ++j) {
        float v = ((float)j + 0.5f) / GRID_HEIGHT, area = sinf(PI * v) * (PI / GRID_HEIGHT) * (2 * PI / GRID_WIDTH);
        for (int i = 0; i < GRID_WIDTH; ++i) {
            vec3 d = panorama_direction(l, ((float)i + 0.5f) / GRID_WIDTH, v);
            vec3 c = rest_radiance(l, d);
            float y[9];
            harmonics(d, y);
            for (int k = 0; k < 9; ++k) l->ambient[k] = vec_madd(l->ambient[k], area * y[k] * cosine_lobe[k], c);
        }
    }
}

/* The studio's floor is level though the camera leans; looking straight down, it leans too. */
static void stand_around(light *l, const view *v)
{
    *l = (light){.up = v->up, .right = v->right, .back = vec_scale(-1, v->forward)};
    vec3 right = vec_cross(v->vertical, l->back);
    if (vec_dot(right, right) > 1e-4f) {
        l->up = v->vertical;
        l->right = vec_unit(right);
        l->back = vec_cross(l->right, l->up);
    }
}

static void set_key(light *l, vec3 direction, vec3 irradiance, float spread)
{
    l->key = direction;
    l->key_irradiance = irradiance;
    l->key_spread = spread;
    vec_frame(direction, &l->key_s, &l->key_t);
}

void light_studio(light *l, const view *v)
{
    stand_around(l, v);
    place_lamps(l);
    vec3 warm = vec(1.02f * key_strength, key_strength, 0.97f * key_strength);
    set_key(l, l->boxes[0].n, warm, key_spread);
    project_ambient(l);
}

/* The brightest spot of the panorama, and what it gives beyond its neighbourhood. */
static void find_key(light *l)
{
    vec3 key = l->up, sum = vec_grey(0);
    float best = -1;
    for (int j = 0; j < GRID_HEIGHT; ++j)
        for (int i = 0; i < GRID_WIDTH; ++i) {
            vec3 d = panorama_direction(l, ((float)i + 0.5f) / GRID_WIDTH, ((float)j + 0.5f) / GRID_HEIGHT);
            float c = vec_max(panorama_radiance(l, d, PI / 32));
            if (c > best) best = c, key = d;
        }
    set_key(l, key, vec_grey(0), key_spread);
    for (int j = 0; j < GRID_HEIGHT; ++j) {
        float y = ((float)j + 0.5f) / GRID_HEIGHT, area = sinf(PI * y) * (PI / GRID_HEIGHT) * (2 * PI / GRID_WIDTH);
        for (int i = 0; i < GRID_WIDTH; ++i) {
            vec3 d = panorama_direction(l, ((float)i + 0.5f) / GRID_WIDTH, y);
            vec3 extra = vec_sub(panorama_radiance(l, d, PI / GRID_HEIGHT), rest_radiance(l, d));
            sum = vec_madd(sum, maxf(0, vec_dot(d, key)) * area / PI, extra);
        }
    }
    l->key_irradiance = sum;
}

bool light_panorama(light *l, const view *v, const char *path)
{
    char why[300];
    stand_around(l, v);
    panorama *p = calloc(1, sizeof *p);
    if (!p) return report_no_memory(path), false;
    p->rgb = image_read(path, &p->width, &p->height, why, sizeof why);
    if (!p->rgb) {
        report_file(path, "%s", why);
        free(p);
        return false;
    }
    l->panorama = p;
    if (!panorama_pyramid(p)) {
        report_no_memory(path);
        light_free(l);
        return false;
    }

    l->exposure = 1;
    find_key(l);
    project_ambient(l);

    float irradiance = vec_max(vec_add(l->key_irradiance, light_ambient(l, l->key)));
    if (irradiance > 0) l->exposure = full_irradiance / irradiance;
    l->key_irradiance = vec_scale(l->exposure, l->key_irradiance);
    for (int k = 0; k < 9; ++k) l->ambient[k] = vec_scale(l->exposure, l->ambient[k]);
    return true;
}

void light_free(light *l)
{
    panorama_free(l->panorama);
    l->panorama = NULL;
}

vec3 light_radiance(const light *l, vec3 d, float blur)
{
    if (l->panorama) return panorama_radiance(l, d, blur);
    vec3 c = studio_walls(l, d, blur);
    for (int i = 0; i < STUDIO_BOXES; ++i) c = vec_add(c, vec_grey(studio_box(&l->boxes[i], d, blur)));
    return c;
}

vec3 light_key_direction(const light *l, float x, float y)
{
    float r = l->key_spread * sqrtf(x), phi = 2 * PI * y;
    return vec_unit(vec_madd(vec_madd(l->key, r * cosf(phi), l->key_s), r * sinf(phi), l->key_t));
}

vec3 light_ambient(const light *l, vec3 n)
{
    float y[9];
    vec3 c = vec_grey(0);
    harmonics(n, y);
    for (int k = 0; k < 9; ++k) c = vec_madd(c, y[k], l->ambient[k]);
    return vec(maxf(c.x, 0), maxf(c.y, 0), maxf(c.z, 0));
}

vec3 light_background(const light *l, vec3 d, float x, float y)
{
    if (l->panorama) return panorama_radiance(l, d, 0.04f);
    float grey = 0.42f + 0.17f * y;                      /* lighter below, as a backdrop lit from above the camera */
    grey *= 1 - 0.20f * minf(1, 0.5f * (x * x + y * y)); /* and darker towards the corners */
    return vec(0.985f * grey, 0.995f * grey, 1.01f * grey);
}
