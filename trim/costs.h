/* costs.h - what testing points costs on this machine [Stürzlinger 1998, section 3.2 and Table 3].
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef EP_TRIM_COSTS_H
#define EP_TRIM_COSTS_H

#include "trim/methods.h"

/* Nanoseconds a point, in packets of 16. */
typedef struct ep_trim_costs {
    double strip;     /* to find that a point is beside the strip of a crossed leaf           */
    double straight;  /* to test a straight piece                                             */
    double curved;    /* to test a curved one: this,                                          */
    double degree;    /* and this for each degree                                             */
    double operation; /* to join two contours */
    double cut;       /* to classify a domain and cut its part, for each piece before the cut */
} ep_trim_costs;

/* Measured once; good enough where only proportions matter, and the same on every machine. */
extern const ep_trim_costs ep_trim_usual_costs;

/* Expected time to test a point somewhere in the domain against the part as ep_trim_keep() stores it. A hierarchy may
 * stop dividing a crossed domain when this is less than passing another level costs. */
double ep_trim_expect(const ep_trim *trim, const ep_trim_part *part, const ep_trim_domain *domain,
                      const ep_trim_costs *c);

/* Measures them; takes about a tenth of a second. */
EPStatus ep_trim_measure(ep_trim_costs *costs, ep_message *m);

/* The same for whole regions, by every method: ns a point of the unit square. */
typedef struct ep_trim_cost_row {
    const char *object;
    double ns[EP_TRIM_METHODS];
    size_t bytes[EP_TRIM_METHODS];
    double paper; /* by the paper's formulas, in its own unit */
} ep_trim_cost_row;
enum { EP_TRIM_COST_ROWS = 12 };
EPStatus ep_trim_measure_rows(ep_trim_cost_row rows[EP_TRIM_COST_ROWS], ep_message *m);

#endif
