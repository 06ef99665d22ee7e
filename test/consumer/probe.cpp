/* probe.cpp - a C++ program that uses what is installed: a quarter of a cone, and how far a hit is from it.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <embree_patch/embree_patch.h> /* needs nothing before it */

#include <cstdio>
#include <memory>

int main()
{
    const double half = 0.70710678118654752; /* the weight that makes a parabola a circle */
    const double cone[6][4] = {{1, 0, 0, 1},   {1, 1, 0, half},     {0, 1, 0, 1},
                               {0.5, 0, 1, 1}, {0.5, 0.5, 1, half}, {0, 0.5, 1, 1}};

    std::unique_ptr<EPGeometryTy, decltype(&epReleaseGeometry)> geometry(epNewGeometry(), epReleaseGeometry);
    EPBuildSettings settings = epDefaultBuildSettings();
    settings.threads = 1;
    if (!geometry || epSetGeometryBuildSettings(geometry.get(), &settings) ||
        epAddBezierPatches(geometry.get(), 2, 1, 1, EP_FORMAT_DOUBLE4, cone, sizeof cone[0]) ||
        epCommitGeometry(geometry.get())) {
        std::puts(epGetGeometryMessage(geometry.get()));
        return 1;
    }
    EPStatistics statistics;
    epGetGeometryStatistics(geometry.get(), &statistics);
    double p[3];
    if (epEvaluate(geometry.get(), 0, 0.3, 0.5, p, nullptr, nullptr, nullptr) || !statistics.leaves) return 1;
    std::printf("version %s radius2 %.6f\n", EP_VERSION_STRING, p[0] * p[0] + p[1] * p[1]);
}
