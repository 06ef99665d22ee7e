/* judge.h - is an answer to a ray right?
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * The nearest root is the answer, unless it is doubtful: then it may be left out, and the next one is. An answer that
 * rests on a doubtful root is counted apart, but it still has to be one of the roots, at its t. */
#ifndef ORACLE_JUDGE_H
#define ORACLE_JUDGE_H

#include "test/oracle/oracle.h"

typedef struct judge_answer {
    double t; /* infinity: a miss */
    double u, v;
    uint32_t patch;
    double normal[3];
    double finest; /* by how much floats tell u and v apart; 0: 2^-23 */
} judge_answer;

typedef enum judge_verdict {
    JUDGE_RIGHT,
    JUDGE_LEFT_OUT, /* right too, but a doubtful root decided                  */
    JUDGE_MISSED,   /* no hit, or a farther one                                */
    JUDGE_EXTRA,    /* a hit where there is no root                            */
    JUDGE_WRONG_T,
    JUDGE_WRONG_PLACE, /* the u, v are of another point                        */
    JUDGE_WRONG_NORMAL,
    JUDGE_VERDICTS
} judge_verdict;

/* What an answer may be off by. */
typedef struct judge_limits {
    double t, distance; /* t by this, relative, plus this of the patch's radius in space  */
    double place;       /* of u, v in space, relative to the patch's radius and to t |d| */
    double degrees;     /* of the normal                                                  */
} judge_limits;

extern const judge_limits judge_usual; /* 2e-5, 2e-6, 2e-5, 0.25 */

typedef struct judge_errors {
    double t; /* relative to t plus the patch's radius */
    double place, degrees;
} judge_errors;

/* `roots` are those of oracle_intersect for the ray. `errors`, which may be NULL, are set when a root is near. */
judge_verdict judge(const oracle *o, const double org[3], const double dir[3], const oracle_root *roots, size_t count,
                    const judge_answer *answer, const judge_limits *limits, judge_errors *errors);

extern const char *const judge_names[JUDGE_VERDICTS];

#endif
