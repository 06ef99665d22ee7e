/* shade.c - direct light, sky, reflections.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tools/shade.h"

#include <stdlib.h>
#include <string.h>

#define PI 3.14159265f

/* Reflections of reflections of ... : what lies deeper is taken from the surroundings. */
#define MAX_DEPTH 4
/* Reflections that contribute less than LEAST_WEIGHT are not traced; blurred ones, where a neighbour's image is hard to
 * tell from the surroundings, must contribute more. */
#define LEAST_WEIGHT 0.02f
#define LEAST_WEIGHT_ROUGH 0.25f
/* Of the sky's light, what reaches a point from where another surface hides the sky, times the point's albedo. */
#define BOUNCE 0.55f

/* A hit, made ready to start rays from. */
typedef struct site {
    vec3 p, n;   /* n: unit normal on the viewer's side */
    float leave; /* move so far along a normal before starting a ray */
} site;

static void invert(const double m[12], double r[12])
{
    double det = 0;
    for (int i = 0; i < 3; ++i)
        for (int x = 0; x < 3; ++x) { /* r's columns are the rows of m's cofactors */
            const double *b = m + 3 * ((i + 1) % 3), *c = m + 3 * ((i + 2) % 3);
            int y = (x + 1) % 3, z = (x + 2) % 3;
            r[3 * x + i] = b[y] * c[z] - b[z] * c[y];
        }
    for (int x = 0; x < 3; ++x) det += m[x] * r[3 * x];
    for (int i = 0; i < 9; ++i) r[i] /= det;
    for (int i = 0; i < 3; ++i) r[9 + i] = -(r[i] * m[9] + r[3 + i] * m[10] + r[6 + i] * m[11]);
}

bool shader_new(shader *s, const world *w, const light *l, bool exact, bool ground)
{
    const scene *sc = w->scene;
    *s = (shader){.world = w, .light = l, .exact = exact, .ground = ground, .ground_height = INFINITY};
    s->objects = calloc(sc->object_count + 1, sizeof *s->objects);
    if (!s->objects) return false;
    for (size_t i = 0; i < sc->object_count; ++i) {
        const scene_object *from = &sc->objects[i];
        shade_object *o = &s->objects[i];
        double squares = 0;
        o->geometry = w->geometries[from->geometry];
        o->material = material_named(from->material);
        o->identity = from->identity;
        invert(from->transform, o->to_object);
        for (int k = 0; k < 9; ++k) squares += from->transform[k] * from->transform[k];
        o->scale = sqrt(squares);
    }
    for (int corner = 0; corner < 8; ++corner) {
        const float *b = w->bounds;
        vec3 p = vec(b[corner & 1 ? 3 : 0], b[corner & 2 ? 4 : 1], b[corner & 4 ? 5 : 2]);
        s->ground_height = minf(s->ground_height, vec_dot(p, l->up));
    }
    if (!(s->ground_height > -INFINITY && s->ground_height < INFINITY)) s->ground_height = 0; /* an empty world */
    return true;
}

void shader_free(shader *s)
{
    free(s->objects);
    s->objects = NULL;
}

static void to_object(const shade_object *o, vec3 a, double w, float r[3])
{
    const double *m = o->to_object;
    for (int i = 0; i < 3; ++i)
        r[i] = (float)(m[i] * (double)a.x + m[3 + i] * (double)a.y + m[6 + i] * (double)a.z + m[9 + i] * w);
}

/* How far p may be from the surface that was hit. The geometry knows in its own space; an instance's transform
 * stretches that and rounds the ray once more. */
static float hit_error(const shader *s, vec3 org, vec3 d, const world_hit *h)
{
    const shade_object *o = &s->objects[h->geomID];
    float a[3] = {org.x, org.y, org.z}, b[3] = {d.x, d.y, d.z};
    float reach = fabsf(org.x) + fabsf(org.y) + fabsf(org.z) + h->t;
    /* Embree's triangle test rounds a few dozen times, each at most in proportion to the numbers it began with. */
    if (!s->exact) return 0x1p-18f * reach;
    if (o->identity) return epGetHitError(o->geometry, h->primID, a, b, h->t);
    to_object(o, org, 1, a);
    to_object(o, d, 0, b);
    return (float)o->scale * epGetHitError(o->geometry, h->primID, a, b, h->t) + 0x1p-21f * reach;
}

static site site_of_hit(const shader *s, vec3 org, vec3 d, const world_hit *h)
{
    site at;
    at.p = vec((float)(org.x + (double)h->t * d.x), (float)(org.y + (double)h->t * d.y),
               (float)(org.z + (double)h->t * d.z));
    at.n = vec_unit(vec(h->Ng[0], h->Ng[1], h->Ng[2]));
    float c = vec_dot(at.n, d);
    if (c > 0) at.n = vec_scale(-1, at.n);
    if (!(vec_dot(at.n, at.n) > 0.5f)) at.n = vec_scale(-1, d); /* no normal, at a pole */
    at.leave = hit_error(s, org, d, h);
    return at;
}

static void set_ray(struct RTCRay *r, const site *from, vec3 d)
{
    vec3 o = vec_madd(from->p, from->leave, from->n);
    *r = (struct RTCRay){.org_x = o.x,
                         .org_y = o.y,
                         .org_z = o.z,
                         .dir_x = d.x,
                         .dir_y = d.y,
                         .dir_z = d.z,
                         .tfar = INFINITY,
                         .mask = ~0u};
}

/* d must leave on the side of the site's normal. */
static bool is_occluded(const shader *s, const site *from, vec3 d, shade_sample *at)
{
    struct RTCRay r;
    set_ray(&r, from, d);
    ++at->rays;
    ep_rtc_occluded(s->world->rtc, 1, NULL, &r, false);
    return r.tfar < 0;
}

/* The key light's irradiance over pi, with shadow. */
static vec3 key_light(const shader *s, const site *from, shade_sample *at)
{
    float x, y;
    sampler_2d(&at->sampler, USE_KEY, &x, &y);
    vec3 d = light_key_direction(s->light, x, y);
    float c = vec_dot(d, from->n);
    if (!(c > 0) || is_occluded(s, from, d, at)) return vec_grey(0);
    return vec_scale(c, s->light->key_irradiance);
}

/* How much of the sky is seen, weighted by the cosine: 0 or 1, right on average. */
static float sky_visibility(const shader *s, const site *from, shade_sample *at)
{
    float x, y;
    vec3 u, v;
    sampler_2d(&at->sampler, USE_SKY, &x, &y);
    vec_frame(from->n, &u, &v);
    float r = sqrtf(x), phi = 2 * PI * y;
    vec3 d = vec_madd(vec_madd(vec_scale(sqrtf(1 - x), from->n), r * cosf(phi), u), r * sinf(phi), v);
    return vec_dot(d, from->n) > 0 && !is_occluded(s, from, d, at);
}

/* A shadow catcher: it shows the background, dimmed where light is kept from it. */
static bool meets_ground(const shader *s, vec3 org, vec3 d, site *ground)
{
    if (!s->ground) return false;
    vec3 up = s->light->up;
    float fall = -vec_dot(d, up), height = vec_dot(org, up) - s->ground_height, t = height / fall;
    if (!(fall > 0 && height > 0 && t < INFINITY)) return false;
    ground->p = vec_madd(org, t, d);
    ground->n = up;
    ground->leave = 0x1p-21f * (fabsf(org.x) + fabsf(org.y) + fabsf(org.z) + t);
    return true;
}

static vec3 shade_ground(const shader *s, const site *ground, vec3 shown, shade_sample *at)
{
    vec3 sky = light_ambient(s->light, ground->n);
    vec3 all = vec_madd(sky, maxf(0, vec_dot(s->light->key, ground->n)), s->light->key_irradiance);
    vec3 lit = vec_madd(key_light(s, ground, at), sky_visibility(s, ground, at), sky);
    float scale = vec_max(all);
    return scale > 0 ? vec_scale(minf(1.1f, vec_max(lit) / scale), shown) : shown;
}

static vec3 shade_hit(const shader *s, vec3 org, vec3 d, const world_hit *hit, unsigned depth, float weight,
                      shade_sample *at);

/* What a reflecting surface shows in direction d: another surface, or the surroundings blurred by its roughness. */
static vec3 mirrored(const shader *s, const site *from, vec3 d, float roughness, unsigned depth, float weight,
                     shade_sample *at)
{
    float x, y;
    vec3 u, v, jittered;
    sampler_2d(&at->sampler, USE_GLOSS, &x, &y);
    vec_frame(d, &u, &v);
    float r = roughness * sqrtf(x), phi = 2 * PI * y;
    jittered = vec_unit(vec_madd(vec_madd(d, r * cosf(phi), u), r * sinf(phi), v));
    if (!(vec_dot(jittered, from->n) > 0)) jittered = d;

    struct RTCRayHit rh;
    set_ray(&rh.ray, from, jittered);
    memset(&rh.hit, 0xff, sizeof rh.hit); /* every id: none */
    ++at->rays;
    ep_rtc_intersect(s->world->rtc, 1, NULL, &rh, false);
    world_hit hit = world_read_hit(s->world, &rh, 1, 0);
    vec3 start = vec(rh.ray.org_x, rh.ray.org_y, rh.ray.org_z);

    sampler saved = at->sampler;
    at->sampler.dimension += SAMPLE_USES;
    vec3 c;
    site ground;
    if (hit.geomID != ~0u) c = shade_hit(s, start, jittered, &hit, depth + 1, weight, at);
    else if (meets_ground(s, start, jittered, &ground))
        c = shade_ground(s, &ground, light_background(s->light, jittered, 0, 0), at);
    else c = light_radiance(s->light, d, roughness);
    at->sampler = saved;
    return c;
}

/* C. Schlick's approximation of Fresnel's law (1994); roughness dulls the rim. */
static vec3 reflectance(const material *m, float cosine)
{
    float rim = powf(1 - clampf(cosine, 0, 1), 5) * (1 - m->roughness) * minf(1, 50 * m->reflection.y);
    return vec_mix(m->reflection, vec_grey(1), clampf(rim, 0, 1));
}

static vec3 shade_hit(const shader *s, vec3 org, vec3 d, const world_hit *hit, unsigned depth, float weight,
                      shade_sample *at)
{
    const material *m = &s->objects[hit->geomID].material;
    site here = site_of_hit(s, org, d, hit);
    float cosine = -vec_dot(d, here.n);
    vec3 f = reflectance(m, cosine), c = vec_grey(0), r = vec_unit(vec_madd(d, 2 * cosine, here.n));
    float visible = 1;

    if (vec_max(m->albedo) > 0) {
        visible = sky_visibility(s, &here, at);
        vec3 hidden = vec_scale(BOUNCE * (1 - visible), m->albedo);
        vec3 sky = vec_mul(light_ambient(s->light, here.n), vec_add(vec_grey(visible), hidden));
        vec3 through = vec_mul(m->albedo, vec_sub(vec_grey(1), f));
        c = vec_mul(through, vec_add(key_light(s, &here, at), sky));
    }
    if (!(vec_max(f) > 0)) return c;

    bool metal = !(vec_max(m->albedo) > 0);
    weight *= vec_max(f);
    bool traced = weight > LEAST_WEIGHT + (metal ? 0 : LEAST_WEIGHT_ROUGH * m->roughness) &&
                  depth < (metal ? MAX_DEPTH : 1) && vec_dot(r, here.n) > 0;
    vec3 shown = traced ? mirrored(s, &here, r, m->roughness, depth, weight, at)
                        : vec_scale(visible, light_radiance(s->light, r, m->roughness));
    return vec_add(c, vec_mul(f, shown));
}

vec3 shade(const shader *s, vec3 org, vec3 d, const world_hit *hit, shade_sample *at)
{
    site ground;
    if (hit->geomID != ~0u) return shade_hit(s, org, d, hit, 0, 1, at);
    vec3 behind = light_background(s->light, d, at->x, at->y);
    return meets_ground(s, org, d, &ground) ? shade_ground(s, &ground, behind, at) : behind;
}
