/* judge.c - see judge.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/oracle/judge.h"

#include <math.h>

const char *const judge_names[JUDGE_VERDICTS] = {"right",   "left out",    "missed",      "extra",
                                                 "wrong t", "wrong place", "wrong normal"};

const judge_limits judge_usual = {.t = 2e-5, .distance = 2e-6, .place = 2e-5, .degrees = 0.25};

static double length(const double a[3])
{
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

static double degrees_between(const double a[3], const double b[3])
{
    double c[3];
    for (int k = 0; k < 3; ++k) c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
    const double d = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    return atan2(length(c), d) * 57.29577951308232;
}

/* Distance of the point that u, v say from the one that t says, relative to the patch and the way there. Two units in
 * the last place of u and v are forgiven: where weights squeeze a tenth of the patch into a thousandth of its domain,
 * these are seen. */
static double place_error(const oracle *o, const double org[3], const double dir[3], const judge_answer *a)
{
    double p[3], pu[3], pv[3], apart[3];
    oracle_evaluate(o, a->patch, a->u, a->v, p, pu, pv);
    for (int c = 0; c < 3; ++c) apart[c] = p[c] - (org[c] + a->t * dir[c]);
    const double excess = length(apart) - fmax(a->finest, 0x1p-23) * (length(pu) + length(pv));
    return fmax(excess, 0) / (oracle_radius(o, a->patch) + fabs(a->t) * length(dir));
}

/* Whether the answer is a point of the surface next to a doubtful root: an error of `distance` off a surface that the
 * ray meets at a small angle moves t by so much more along it. */
static bool along_tangent(const oracle *o, const double org[3], const double dir[3], const oracle_root *r,
                          const judge_answer *a, const judge_limits *limits)
{
    const double way = fmax(r->t_low - a->t, a->t - r->t_high) * length(dir);
    return r->doubtful && way * r->cosine <= limits->distance * oracle_radius(o, a->patch) &&
           place_error(o, org, dir, a) <= limits->place;
}

/* The answer, held against one root that is near enough in t. */
static judge_verdict compare(const oracle *o, const double org[3], const double dir[3], const oracle_root *r,
                             const judge_answer *a, const judge_limits *limits, judge_errors *e)
{
    if (r->doubtful) return JUDGE_LEFT_OUT;
    e->t = fabs(a->t - r->t_low) / (fabs(a->t) + oracle_radius(o, a->patch) / length(dir));
    e->place = place_error(o, org, dir, a);
    e->degrees = degrees_between(a->normal, r->normal);
    if (!(e->place <= limits->place)) return JUDGE_WRONG_PLACE;
    if (!(e->degrees <= limits->degrees)) return JUDGE_WRONG_NORMAL;
    return JUDGE_RIGHT;
}

judge_verdict judge(const oracle *o, const double org[3], const double dir[3], const oracle_root *roots, size_t count,
                    const judge_answer *a, const judge_limits *limits, judge_errors *errors)
{
    const oracle_root *sure = NULL;
    for (size_t k = 0; k < count && !sure; ++k)
        if (!roots[k].doubtful) sure = &roots[k];
    if (!(a->t < INFINITY)) return sure ? JUDGE_MISSED : count ? JUDGE_LEFT_OUT : JUDGE_RIGHT;

    const double slack = limits->t * fabs(a->t) + limits->distance * oracle_radius(o, a->patch) / length(dir);
    judge_verdict best = JUDGE_VERDICTS;
    for (size_t k = 0; k < count; ++k) {
        const oracle_root *r = &roots[k];
        judge_errors e = {0, 0, 0};
        if (!(r->t_low - slack <= a->t && a->t <= r->t_high + slack) && !along_tangent(o, org, dir, r, a, limits))
            continue;
        const judge_verdict verdict = sure && sure->t_high < fmax(r->t_low, a->t - slack) - slack
                                          ? JUDGE_MISSED
                                          : compare(o, org, dir, r, a, limits, &e);
        if (verdict >= best) continue;
        best = verdict;
        if (errors) *errors = e;
    }
    if (best < JUDGE_VERDICTS) return best;
    if (!sure) return JUDGE_EXTRA;
    if (fabs(a->t - sure->t_low) < 1e-2 * sure->t_low) return JUDGE_WRONG_T;
    return a->t > sure->t_low ? JUDGE_MISSED : JUDGE_EXTRA;
}
