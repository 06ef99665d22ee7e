/* judge.c - see judge.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "test/oracle/judge.h"

#include <math.h>

const char *const judge_names[JUDGE_VERDICTS] = {"right",   "left out",    "missed",      "extra",
                                                 "wrong t", "wrong place", "wrong normal"};

const judge_limits judge_usual = {.t = 2e-5, .place = 2e-5, .degrees = 0.25};

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

judge_verdict judge(const oracle *o, const double org[3], const double dir[3], const oracle_root *roots, size_t count,
                    const judge_answer *a, const judge_limits *limits, judge_errors *errors)
{
    const oracle_root *sure = NULL, *match = NULL;
    for (size_t k = 0; k < count && !sure; ++k)
        if (!roots[k].doubtful) sure = &roots[k];
    if (!(a->t < INFINITY)) return sure ? JUDGE_MISSED : count ? JUDGE_LEFT_OUT : JUDGE_RIGHT;

    const double slack = limits->t * fabs(a->t);
    double off = INFINITY;
    for (size_t k = 0; k < count; ++k) {
        const oracle_root *r = &roots[k];
        const double away = fmax(fmax(r->t_low - a->t, a->t - r->t_high), 0);
        /* a sure root is preferred to a doubtful one that is as good */
        if (r->patch != a->patch || away > slack || (match && !match->doubtful && r->doubtful) || away >= off) continue;
        match = r;
        off = away;
    }
    if (!match) {
        if (!sure) return JUDGE_EXTRA;
        if (fabs(a->t - sure->t_low) < 1e-2 * sure->t_low) return JUDGE_WRONG_T;
        return a->t > sure->t_low ? JUDGE_MISSED : JUDGE_EXTRA;
    }
    if (sure && sure->t_high < match->t_low - slack) return JUDGE_MISSED;

    double p[3], apart[3];
    oracle_evaluate(o, a->patch, a->u, a->v, p, NULL, NULL);
    for (int c = 0; c < 3; ++c) apart[c] = p[c] - (org[c] + a->t * dir[c]);
    const double place = length(apart) / (oracle_radius(o, a->patch) + fabs(a->t) * length(dir));
    if (!(place <= limits->place)) return JUDGE_WRONG_PLACE;
    if (match->doubtful) return JUDGE_LEFT_OUT;
    const double degrees = degrees_between(a->normal, match->normal);
    if (!(degrees <= limits->degrees)) return JUDGE_WRONG_NORMAL;
    if (errors) {
        errors->t = fabs(a->t - match->t_low) / fabs(a->t);
        errors->place = place;
        errors->degrees = degrees;
    }
    return JUDGE_RIGHT;
}
