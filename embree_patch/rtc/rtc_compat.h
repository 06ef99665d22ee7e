/* rtc_compat.h - the only file that knows which Embree it is built against.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * What differs                                    Embree 3                    Embree 4
 *   type of args->context                         RTCIntersectContext         RTCRayQueryContext
 *   a callback reports hit or miss in `valid`     no                          yes: -1 / 0
 *   filters from a callback                       rtcFilterIntersection       rtcInvokeIntersectFilterFromGeometry
 *   coherence                                     a flag of the context       a flag of the arguments
 *   mask of a new geometry                        0xFFFFFFFF                  1
 *   words of an RTCRayHit                         20                          24 (with instance arrays)
 *
 * EP_EMBREE is 3 or 4, from meson. */
#ifndef EP_RTC_COMPAT_H
#define EP_RTC_COMPAT_H

#include <stdbool.h>

#if EP_EMBREE == 3
#include <embree3/rtcore.h>
typedef struct RTCIntersectContext ep_rtc_context;
#elif EP_EMBREE == 4
#include <embree4/rtcore.h>
typedef struct RTCRayQueryContext ep_rtc_context;
#else
#error "EP_EMBREE must be 3 or 4"
#endif

/* Words a ray that hold an RTCRayHit or, for each of its rays, an RTCRayHit4/8/16 in any version. */
#define EP_RTC_RAYHIT_FIELDS (sizeof(struct RTCRayHit) / sizeof(float))

/* Runs the geometry's filter, and on Embree 3 the query's too, on the candidate hits in `filter`. */
static inline void ep_rtc_filter_intersection(const struct RTCIntersectFunctionNArguments *args,
                                              const struct RTCFilterFunctionNArguments *filter)
{
#if EP_EMBREE == 3
    rtcFilterIntersection(args, filter);
#else
    rtcInvokeIntersectFilterFromGeometry(args, filter);
#endif
}

static inline void ep_rtc_filter_occlusion(const struct RTCOccludedFunctionNArguments *args,
                                           const struct RTCFilterFunctionNArguments *filter)
{
#if EP_EMBREE == 3
    rtcFilterOcclusion(args, filter);
#else
    rtcInvokeOccludedFilterFromGeometry(args, filter);
#endif
}

/* Tells Embree about one lane that came in active; every such lane is reported exactly once. */
static inline void ep_rtc_report(int *valid, unsigned lane, bool hit)
{
#if EP_EMBREE == 3
    (void)valid, (void)lane, (void)hit; /* Embree 3 looks at tfar instead */
#else
    valid[lane] = hit ? -1 : 0;
#endif
}

static inline void ep_rtc_init_context(ep_rtc_context *c)
{
#if EP_EMBREE == 3
    rtcInitIntersectContext(c);
#else
    rtcInitRayQueryContext(c);
#endif
}

/* One query of `width` rays: 1, 4, 8 or 16. `rayhit` is an RTCRayHit or RTCRayHit<width>, `valid` is width ints (-1
 * active, 0 not; ignored for width 1). `c` has been initialised. */
static inline void ep_rtc_intersect_in(ep_rtc_context *c, RTCScene scene, unsigned width, const int *valid,
                                       void *rayhit, bool coherent)
{
#if EP_EMBREE == 3
    c->flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    switch (width) {
    case 1: rtcIntersect1(scene, c, (struct RTCRayHit *)rayhit); break;
    case 4: rtcIntersect4(valid, scene, c, (struct RTCRayHit4 *)rayhit); break;
    case 8: rtcIntersect8(valid, scene, c, (struct RTCRayHit8 *)rayhit); break;
    default: rtcIntersect16(valid, scene, c, (struct RTCRayHit16 *)rayhit); break;
    }
#else
    struct RTCIntersectArguments a;
    rtcInitIntersectArguments(&a);
    a.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    a.context = c;
    switch (width) {
    case 1: rtcIntersect1(scene, (struct RTCRayHit *)rayhit, &a); break;
    case 4: rtcIntersect4(valid, scene, (struct RTCRayHit4 *)rayhit, &a); break;
    case 8: rtcIntersect8(valid, scene, (struct RTCRayHit8 *)rayhit, &a); break;
    default: rtcIntersect16(valid, scene, (struct RTCRayHit16 *)rayhit, &a); break;
    }
#endif
}

/* The same for occlusion: `ray` is an RTCRay or RTCRay<width>; an occluded ray comes back with tfar = -inf. */
static inline void ep_rtc_occluded_in(ep_rtc_context *c, RTCScene scene, unsigned width, const int *valid, void *ray,
                                      bool coherent)
{
#if EP_EMBREE == 3
    c->flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    switch (width) {
    case 1: rtcOccluded1(scene, c, (struct RTCRay *)ray); break;
    case 4: rtcOccluded4(valid, scene, c, (struct RTCRay4 *)ray); break;
    case 8: rtcOccluded8(valid, scene, c, (struct RTCRay8 *)ray); break;
    default: rtcOccluded16(valid, scene, c, (struct RTCRay16 *)ray); break;
    }
#else
    struct RTCOccludedArguments a;
    rtcInitOccludedArguments(&a);
    a.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    a.context = c;
    switch (width) {
    case 1: rtcOccluded1(scene, (struct RTCRay *)ray, &a); break;
    case 4: rtcOccluded4(valid, scene, (struct RTCRay4 *)ray, &a); break;
    case 8: rtcOccluded8(valid, scene, (struct RTCRay8 *)ray, &a); break;
    default: rtcOccluded16(valid, scene, (struct RTCRay16 *)ray, &a); break;
    }
#endif
}

/* In a context of its own. */
static inline void ep_rtc_intersect(RTCScene scene, unsigned width, const int *valid, void *rayhit, bool coherent)
{
    ep_rtc_context c;
    ep_rtc_init_context(&c);
    ep_rtc_intersect_in(&c, scene, width, valid, rayhit, coherent);
}

static inline void ep_rtc_occluded(RTCScene scene, unsigned width, const int *valid, void *ray, bool coherent)
{
    ep_rtc_context c;
    ep_rtc_init_context(&c);
    ep_rtc_occluded_in(&c, scene, width, valid, ray, coherent);
}

#endif
