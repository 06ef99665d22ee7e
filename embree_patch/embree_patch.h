/* embree_patch.h - exact curved surfaces as an Embree geometry.
 *
 * SPDX-License-Identifier: Apache-2.0
 *
 * An EPGeometry holds curved patches: Bézier triangles, tensor-product Bézier patches and NURBS surfaces, polynomial or
 * rational, of any degree up to EP_MAX_DEGREE, mixed freely. Committing it cuts every patch into leaves, small
 * pieces in tight prisms. epNewRTCGeometry makes an RTCGeometry whose user primitives are those leaves; attach it
 * to any RTCScene. No mesh is made: a hit is a root of the ray on the surface itself.
 *
 *     EPGeometry teapot = epNewGeometry();
 *     epAddBezierPatches(teapot, 3, 3, 32, EP_FORMAT_FLOAT3, points, 3 * sizeof(float));
 *     if (epCommitGeometry(teapot) != EP_OK) puts(epGetGeometryMessage(teapot));
 *     RTCGeometry rtc = epNewRTCGeometry(teapot, device);
 *     rtcAttachGeometry(scene, rtc);
 *     rtcReleaseGeometry(rtc);
 *     ... trace ...
 *     rtcReleaseScene(scene);
 *     epReleaseGeometry(teapot);
 *
 * What a hit means
 *   primID    the index of the patch, in the order of the epAdd calls; or of the face that patches were joined to
 *             (epJoinPatches), which counts as one.
 *   u, v      the patch's own parameters (see epAddBezierTriangles and epAddBezierPatches), or the face's.
 *   Ng        dP/du x dP/dv, not normalised, in the space of the geometry. It does not depend on the side the ray
 *             came from. Where the derivatives vanish (a collapsed edge) it is the limit from inside the patch.
 *   tfar      the distance to the hit in units of the ray's direction, which need not be a unit vector. Hits are
 *             between the ray's tnear and tfar, at neither.
 *
 * Embree's features: occlusion queries, packets of 1, 4, 8 and 16 rays, geometry and query filters, ray masks,
 * instances of any depth. The program that queries the scene must leave RTCIntersectArguments::intersect and
 * RTCOccludedArguments::occluded NULL (Embree 4): they would replace ours.
 *
 * Filters are called for every root. One on the border that two pieces of a patch or two patches share may come twice,
 * once from either, with the same place to rounding. Roots of one piece come nearest first; pieces come as Embree finds
 * them. An occlusion query's filter gets a nearly tangent ray's root as float has it, without the digits that double
 * adds.
 *
 * Threads: a committed geometry may be traced and read from any number of threads. Building one geometry belongs
 * to one thread at a time; different geometries are independent.
 *
 * Errors: functions that can fail return an EPStatus and leave a sentence in epGetGeometryMessage. Nothing aborts. */
#ifndef EMBREE_PATCH_H
#define EMBREE_PATCH_H

#include <stddef.h>
#include <stdint.h>

#define EP_VERSION_MAJOR 0
#define EP_VERSION_MINOR 1
#define EP_VERSION_PATCH 0
#define EP_VERSION_STRING "0.1.0"

#if defined(__GNUC__)
#define EP_API __attribute__((visibility("default")))
#else
#define EP_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* Embree's own handles, declared here so that this header needs none of Embree's. */
typedef struct RTCDeviceTy *RTCDevice;
typedef struct RTCGeometryTy *RTCGeometry;

typedef struct EPGeometryTy *EPGeometry;
typedef struct EPRegionTy *EPRegion;

typedef enum EPStatus {
    EP_OK = 0,
    EP_INVALID,     /* an argument is outside its documented range                       */
    EP_NO_MEMORY,   /* an allocation failed; the object is as it was before the call      */
    EP_BAD_DATA,    /* a point or weight has no meaning; the message names patch and point */
    EP_UNSUPPORTED, /* valid, but this build or this machine cannot do it                 */
    EP_FOREIGN      /* Embree failed; the message says what it said                       */
} EPStatus;

/* The highest degree in either direction. */
#define EP_MAX_DEGREE 25

/* How a control point is stored. The weight w of a rational patch is positive and the coordinates are Euclidean,
 * not premultiplied: the homogeneous point is (w x, w y, w z, w). */
typedef enum EPFormat {
    EP_FORMAT_FLOAT3,  /* float x, y, z     */
    EP_FORMAT_FLOAT4,  /* float x, y, z, w  */
    EP_FORMAT_DOUBLE3, /* double x, y, z    */
    EP_FORMAT_DOUBLE4  /* double x, y, z, w */
} EPFormat;

/* A new, empty geometry with one reference, or NULL when there is no memory. */
EP_API EPGeometry epNewGeometry(void);
EP_API void epRetainGeometry(EPGeometry geometry);
/* The last release frees the geometry. NULL is fine. Embree does not tell when an RTCGeometry ends, so the geometry
 * must outlive every scene that traces it: release it after the scene. */
EP_API void epReleaseGeometry(EPGeometry geometry);

/* Appends `count` rational Bézier triangles of degree n:
 *
 *     P(u,v) = sum P_ij w_ij B_ij / sum w_ij B_ij,    B_ij = n!/(i!j!k!) u^i v^j w^k,  w = 1-u-v, k = n-i-j
 *
 * over u, v >= 0, u+v <= 1. Each patch is (n+1)(n+2)/2 consecutive points, for j in 0..n: for i in 0..n-j.
 * `points` holds count * (n+1)(n+2)/2 points, `byteStride` bytes from one to the next; it is copied.
 * Neighbours whose boundary points are equal are traced without a gap.
 * EP_INVALID: degree not in 1..EP_MAX_DEGREE, or a stride shorter than the point. EP_BAD_DATA: a coordinate or
 * weight is not finite, or a weight is not positive. Then nothing is appended. */
EP_API EPStatus epAddBezierTriangles(EPGeometry geometry, unsigned degree, size_t count, EPFormat format,
                                     const void *points, size_t byteStride);

/* Appends `count` rational tensor-product Bézier patches of degree m in u and n in v, over u, v in [0,1].
 * Each patch is (m+1)(n+1) consecutive points, for j in 0..n (v): for i in 0..m (u). Otherwise as above. */
EP_API EPStatus epAddBezierPatches(EPGeometry geometry, unsigned degreeU, unsigned degreeV, size_t count,
                                   EPFormat format, const void *points, size_t byteStride);

/* Appends a NURBS surface, of degree degreeU in u and degreeV in v. It has n = knotCountU - degreeU - 1 times m =
 * knotCountV - degreeV - 1 control points, for j in 0..m-1 (v): for i in 0..n-1 (u). Knots do not decrease; u goes from
 * knotsU[degreeU] to knotsU[n], v from knotsV[degreeV] to knotsV[m]. A knot between these may repeat degree + 1 times,
 * where the surface is torn. It becomes one Bézier patch for each pair of spans, all spans of u for the first of v and
 * so on, joined to one face (epJoinPatches) whose u and v are those of the knots. Otherwise as above; knots are copied,
 * too. EP_BAD_DATA: also where knots are none, or too close together or too large for floats. */
EP_API EPStatus epAddNURBSSurface(EPGeometry geometry, unsigned degreeU, unsigned degreeV, size_t knotCountU,
                                  const double *knotsU, size_t knotCountV, const double *knotsV, EPFormat format,
                                  const void *points, size_t byteStride);

/* Makes one face of the last `count` patches, from `firstPatch` on: a surface with one primID and parameters of its own
 * that is made of pieces, such as the spans of a NURBS surface or the parts of a face of a subdivision surface. Patch k
 * is the part of it where (u, v) is the image of the patch's own (s, t) under transforms[k] = {a, b, c, d, e, f}, which
 * maps (s, t) to (a s + c t + e, b s + d t + f). Hits on it have these u, v and dP/du x dP/dv with respect to them.
 * Without a join, a patch is a face by itself. With no patches at all (count 0), the next number becomes that of a face
 * that no ray hits. EP_INVALID: they are not the last ones, one of them belongs to another face or is trimmed, or a
 * transform is not finite or has no inverse. Then nothing is joined. */
EP_API EPStatus epJoinPatches(EPGeometry geometry, uint32_t firstPatch, size_t count, const double (*transforms)[6]);

/* Replaces the control points of `count` patches that were added, from `firstPatch` on; degrees and trims stay.
 * `points` holds the points of each patch after those of the one before, in the order in which they were added; in any
 * format. Takes effect with the next refit or commit, until which nothing may be traced. EP_INVALID, EP_BAD_DATA: as
 * above, or no such patches. Then nothing is replaced. */
EP_API EPStatus epSetPatchPoints(EPGeometry geometry, uint32_t firstPatch, size_t count, EPFormat format,
                                 const void *points, size_t byteStride);

/* Trims: a region of the parameter plane, of which a patch keeps the part inside. A region is written down from the
 * outside in; this keeps what is in the unit square and not in a disc:
 *
 *     EPRegion hole = epNewRegion();
 *     epBeginRegion(hole, EP_DIFFERENCE, NULL);
 *     epAddRegionSquare(hole, NULL);
 *     epAddRegionCircle(hole, (const double[6]){0.2, 0, 0, 0.2, 0.5, 0.5});
 *     epEndRegion(hole);
 *     epSetPatchTrim(geometry, 0, 32, hole);
 *     epReleaseRegion(hole);
 *
 * With the end of the outermost node the region is complete and constant: any number of patches, geometries and threads
 * may share it. Until then it belongs to one thread at a time. A call that fails changes nothing, but for EP_NO_MEMORY
 * from the one that would have completed the region, which is then of no use. EP_INVALID: the call has no place here,
 * such as a segment outside of a polygon, or a second outermost node. EP_BAD_DATA: a number has no meaning.
 *
 * Contours (square, circle, loops, polygon) are even-odd: a point is inside when a path from far away to it crosses the
 * contour an odd number of times. Segments of a polygon follow one another; where one does not begin at the end of the
 * last, and where the last does not end at the first, a straight segment joins them.
 *
 * A transform {a, b, c, d, e, f} maps (x, y) to (a x + c y + e, b x + d y + f); those of the nodes around it are
 * applied after it. NULL: none. */
typedef enum EPRegionKind {
    EP_UNION,
    EP_INTERSECTION,
    EP_DIFFERENCE, /* of exactly two: in the first and not in the second */
    EP_LOOPS,      /* of polygons: in an odd number of them              */
    EP_POLYGON     /* of segments                                        */
} EPRegionKind;

/* A new, empty region with one reference, or NULL when there is no memory. */
EP_API EPRegion epNewRegion(void);
EP_API void epRetainRegion(EPRegion region);
/* The last release frees the region; geometries that are trimmed by it hold references of their own. NULL is fine. */
EP_API void epReleaseRegion(EPRegion region);
/* The sentence that goes with the last failure on this region; "" when there was none. */
EP_API const char *epGetRegionMessage(EPRegion region);

EP_API EPStatus epBeginRegion(EPRegion region, EPRegionKind kind, const double transform[6]);
EP_API EPStatus epEndRegion(EPRegion region);
/* [0,1]², and the disc of radius 1 about the origin. */
EP_API EPStatus epAddRegionSquare(EPRegion region, const double transform[6]);
EP_API EPStatus epAddRegionCircle(EPRegion region, const double transform[6]);

/* Segments of the polygon that was begun last. Lines have two doubles a point (x, y), curves three (x, y, weight),
 * Euclidean and with positive weights. A line connects 2 points or more. A Bézier curve has degree count-1, at most
 * EP_MAX_DEGREE. A NURBS curve has count+degree+1 knots, which do not decrease and repeat at most `degree` times
 * inside; with weights of 1 it is a B-spline. The points are copied. */
EP_API EPStatus epAddRegionLine(EPRegion region, size_t count, const double *points);
EP_API EPStatus epAddRegionBezier(EPRegion region, size_t count, const double *points);
EP_API EPStatus epAddRegionNURBS(EPRegion region, unsigned degree, size_t knotCount, const double *knots, size_t count,
                                 const double *points);

/* 1 when (u, v) is in the region, which is complete; else 0. */
EP_API int epIsInRegion(EPRegion region, double u, double v);

/* Trims `count` patches that were added, from `firstPatch` on, in place of what trimmed them before; NULL: not at all.
 * The region of a patch that was joined is in the u, v of its face, so that all of a face's patches have the same one.
 * Takes effect with the next commit, until which nothing may be traced. What is outside makes no leaves, and rays pass
 * through it. EP_INVALID: no such patches, or the region is not complete. EP_BAD_DATA: it has points that are too far
 * out for a patch. */
EP_API EPStatus epSetPatchTrim(EPGeometry geometry, uint32_t firstPatch, size_t count, EPRegion region);

/* How the parts of a patch that trim curves cross are divided: only their leaves ever test a hit's u and v. */
typedef enum EPTrimSplit {
    EP_TRIM_SPLIT_CURVES,  /* along the curves, until hardly any ray comes to a leaf that is crossed  */
    EP_TRIM_SPLIT_COST,    /* along the curves, as long as testing a point costs more than a level    */
    EP_TRIM_SPLIT_REGULAR, /* into equal parts, which get as small as those along the curves; slower */
    EP_TRIM_SPLIT_NONE     /* as the surface demands, but for parts outside; slower                  */
} EPTrimSplit;

/* How to cut patches into leaves. Start from epDefaultBuildSettings(). None of these changes which point a ray
 * hits; they trade build time and memory against speed.
 *
 * onDemand is for models of which rays meet few patches. The commit makes no more than a box of each patch; the first
 * ray that enters it has the patch cut into leaves, by the thread that traces the ray, and Embree build a scene of
 * them. No thread ever waits for another: those that come meanwhile do the same work, and all but one drop it. Hits,
 * filters and ids are the same to the bit. A ray that finds no memory for leaves is not lost: the patch is subdivided
 * along it in double precision, which is slow, and its hit may differ in the last bits; the next ray tries again. Where
 * all patches are met, rays take up to 1.4 times as long. Leaves and their scenes stay until the next commit or refit
 * or the end of the geometry, and until then so does the device, which calls its memory monitor and error functions
 * from the threads that trace. EPStatistics tells what is there when it is asked. */
typedef struct EPBuildSettings {
    size_t size;           /* sizeof(EPBuildSettings) in your build; set by epDefaultBuildSettings       */
    float thickness;       /* a leaf's prism is at most this thick, relative to its width. 0.115; in (0,1] */
    unsigned maxDepth;     /* halvings of a patch's domain at most. 20; in 0..40                          */
    unsigned threads;      /* for the build; 0: all. The leaves do not depend on it                       */
    float rayDistance;     /* how far from the geometry rays may start, in scene units; 0: 64 times the
                              geometry's diagonal. Embree's traversal rounds in proportion to this distance,
                              and the leaves' boxes are padded against it                                 */
    const char *isa;       /* "plain", "avx2" or "avx512"; NULL: the best that this machine runs          */
    EPTrimSplit trimSplit; /* EP_TRIM_SPLIT_CURVES                                                           */
    int onDemand;          /* 0; 1: patches are cut when rays meet them                                        */
} EPBuildSettings;

/* Inline on purpose: compiled with the caller's idea of the size. */
static inline EPBuildSettings epDefaultBuildSettings(void)
{
    EPBuildSettings s;
    s.size = sizeof s;
    s.thickness = 0.115f;
    s.maxDepth = 20;
    s.threads = 0;
    s.rayDistance = 0.0f;
    s.isa = NULL;
    s.trimSplit = EP_TRIM_SPLIT_CURVES;
    s.onDemand = 0;
    return s;
}
EP_API EPStatus epSetGeometryBuildSettings(EPGeometry geometry, const EPBuildSettings *settings);

/* Builds the leaves. Commit again after patches were added or trimmed or the settings changed; an RTCGeometry that was
 * made before then must be made anew. Where only points have moved, epRefitGeometry is quicker. A geometry without
 * patches commits to no leaves. */
EP_API EPStatus epCommitGeometry(EPGeometry geometry);

/* Builds the leaves anew where only points have moved since the last commit (epSetPatchPoints): every patch keeps its
 * division into leaves, and each leaf is fitted to the piece of surface that is there now. Every RTCGeometry of this
 * geometry stays valid; Embree has to hear of it, before the next ray:
 *
 *     epSetPatchPoints(teapot, 0, 32, EP_FORMAT_FLOAT3, points, 3 * sizeof(float));
 *     epRefitGeometry(teapot);
 *     rtcCommitGeometry(rtc);
 *     rtcCommitScene(scene);
 *
 * It takes 0.8 (tensor-product patches) to 0.9 (triangles) of the time of a commit, and for a moment the memory of a
 * second set of leaves. Hits are as exact as after a commit, however far the points have moved; only speed suffers
 * where patches bend much more than when they were divided. EPStatistics.averageThickness tells; a commit divides anew.
 * Trims stay where they are in u, v. With onDemand, patches are cut anew when rays meet them. EP_INVALID: patches,
 * trims or settings have changed since the last commit, or there was none. On failure the leaves are as they were. */
EP_API EPStatus epRefitGeometry(EPGeometry geometry);

/* An RTCGeometry of type USER over the leaves of a committed geometry, itself committed and ready to attach, with
 * one reference that the caller releases; NULL on failure. Set filters, masks and build quality on it with Embree's
 * own functions. Its user data belongs to this library. Its mask is 0xFFFFFFFF. */
EP_API RTCGeometry epNewRTCGeometry(EPGeometry geometry, RTCDevice device);

/* The sentence that goes with the last failure on this geometry; "" when there was none. It lives until the
 * next call on the geometry. */
EP_API const char *epGetGeometryMessage(EPGeometry geometry);

/* A point on patch or face `primID` at its parameters u, v, in double precision, straight from the control points as
 * they were given. Any of the outputs may be NULL. First derivatives: dPdu, dPdv; second: d2[0..2] = d²P/du²,
 * d2[3..5] = d²P/dudv, d2[6..8] = d²P/dv². Parameters outside the domain are evaluated, not clamped; of a face, by
 * the patch that is nearest. Needs no commit. Takes time in proportion to the face's patches, unless they are in rows as
 * those of a NURBS surface. EP_INVALID: no such patch. */
EP_API EPStatus epEvaluate(EPGeometry geometry, uint32_t primID, double u, double v, double P[3], double dPdu[3],
                           double dPdv[3], double d2[9]);

/* How far, in scene units, the point org + t dir of a reported hit may be from the exact surface of patch or face
 * primID. org, dir and t are those of the ray in the geometry's space (before any instance transform). A ray that
 * starts at that point, moved by at least this bound along +Ng or -Ng and leaving to the same side, does not hit the
 * same sheet again. */
EP_API float epGetHitError(EPGeometry geometry, uint32_t primID, const float org[3], const float dir[3], float t);

/* The box that holds all patches of a committed geometry (onDemand: their control points): lower x, y, z, upper x, y,
 * z. Empty (lower > upper) without patches. */
EP_API void epGetGeometryBounds(EPGeometry geometry, float bounds[6]);

typedef struct EPStatistics {
    size_t faces, patches, leaves;
    size_t uncertified;  /* leaves where only subdivision can tell (at poles, cusps and folds)  */
    double averageDepth; /* halvings of the domain, mean over leaves                            */
    unsigned maximumDepth;
    double averageThickness; /* thickness of a leaf's prism relative to its width, mean over leaves */
    size_t bytes;            /* allocated for this geometry: points, leaves, boxes, and the regions that trim it,
                                even if they are shared with other geometries                       */
    double buildSeconds;     /* of the last commit or refit                                         */
    const char *isa;         /* the kernels in use                                                  */
} EPStatistics;
EP_API void epGetGeometryStatistics(EPGeometry geometry, EPStatistics *statistics);

/* What tracing has cost since the process started, all geometries together. Take differences. */
typedef struct EPCounters {
    uint64_t visits;      /* a ray entered a leaf                                                */
    uint64_t solves;      /* ... was not culled by its prism, so that iteration began            */
    uint64_t evaluations; /* of a surface, in those iterations                                   */
    uint64_t cells;       /* grazing visits whose way through the leaf was cut into cells        */
    uint64_t slow;        /* visits decided by subdivision                                       */
} EPCounters;
/* Sum over all threads; exact while no query runs. */
EP_API void epGetCounters(EPCounters *counters);
/* Of the calling thread alone: the difference around one rtcIntersect1 is what that ray cost. */
EP_API void epGetThreadCounters(EPCounters *counters);

/* The instruction sets this library can run on this machine, slowest first; NULL-terminated. */
EP_API const char *const *epGetInstructionSets(void);

#ifdef __cplusplus
}
#endif
#endif
