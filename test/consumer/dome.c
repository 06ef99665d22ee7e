#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <embree_patch/embree_patch.h>
#include <math.h>
#include <stdio.h>

int main(void)
{
    /* one biquadratic patch over the unit square, lifted in the middle */
    float p[9][3];
    for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i) p[3 * j + i][0] = i / 2.0f, p[3 * j + i][1] = j / 2.0f, p[3 * j + i][2] = (i == 1) * (j == 1);

    RTCDevice device = rtcNewDevice(NULL);
    RTCScene scene = rtcNewScene(device);
    EPGeometry dome = epNewGeometry();
    if (epAddBezierPatches(dome, 2, 2, 1, EP_FORMAT_FLOAT3, p, sizeof p[0]) || epCommitGeometry(dome))
        return puts(epGetGeometryMessage(dome));
    RTCGeometry geometry = epNewRTCGeometry(dome, device);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);

    struct RTCRayHit q = { .ray = { .org_x = 0.5f, .org_y = 0.5f, .org_z = 2, .dir_z = -1, .tfar = INFINITY, .mask = ~0u },
                           .hit.geomID = RTC_INVALID_GEOMETRY_ID };
#if RTC_VERSION_MAJOR >= 4
    rtcIntersect1(scene, &q, NULL);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, &q);
#endif
    printf("t %g at u %g v %g\n", q.ray.tfar, q.hit.u, q.hit.v); /* t 1.75 at u 0.5 v 0.5 */
    rtcReleaseScene(scene);
    epReleaseGeometry(dome);
    rtcReleaseDevice(device);
}
