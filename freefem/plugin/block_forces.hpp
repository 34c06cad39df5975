// Internal forces of a mesh of straight P2 tetrahedra at finite strain: gradients gathered, points updated, forces
// scattered in one pass over the elements; four Gauss points each.
//
// Element nodes: four vertices, then the mid-edge nodes of 01 02 03 12 13 23 (FreeFEM's order).  U, f: 3 node + component.
// Point 4 e + g of element e has the barycentric coordinate .5854 of vertex g; its volume is a quarter of the element's.
//   (25) H = sum_n u_n (x) grad N_n,   f_n = sum_points volume P grad N_n           on the undeformed mesh
//   (26) mean dilatation, a share m of it:  change of the mean stress = K change of [(1 - m) ln(det F) + m ln(theta)],
//        theta the element's mean of det F; for m = 0 it is that of (23), which is the same but for the midpoint rule.
//        By changes, because after a rezoning (block_rezone.hpp) F no longer tells what the material went through.
//   small strain: ln(det F) becomes tr H, P = sigma
// With m = 0 the pressure of four points oscillates inside an element whose plastic flow keeps its volume: P2 has too
// few displacements to keep it in each point.  With m = 1 one pressure an element leaves the surface's vertices, which
// carry no contact, nearly free where all around flows: they sink by a third of the dimple.  m = .9 does neither.
// The elastic stiffness that belongs to it integrates the share m of the volumetric part by one point: the divergence of
// P2 is linear, so its mean is that of the centroid.
#ifndef PEEN_BLOCK_FORCES_HPP
#define PEEN_BLOCK_FORCES_HPP

#include "block_point.hpp"

namespace block {

const int EDGE[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
const double NEAR = 0.58541019662496852, FAR = 0.13819660112501052;

// Gradients of the barycentric coordinates of a tetrahedron x (4 x 3), and its volume.
inline double barycentric(const double (*x)[3], double (*g)[3]) {
    double a[9], c[9];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) a[3 * i + j] = x[i + 1][j] - x[0][j];
    const double det = cofactors(a, c);
    for (int j = 0; j < 3; ++j) {
        g[0][j] = 0;
        for (int i = 0; i < 3; ++i) g[i + 1][j] = c[3 * i + j] / det, g[0][j] -= g[i + 1][j];
    }
    return det / 6;
}

// Gradients of the ten P2 functions at the barycentric coordinates l.
inline void shapeGradients(const double (*g)[3], const double *l, double (*dN)[3]) {
    for (int n = 0; n < 4; ++n)
        for (int j = 0; j < 3; ++j) dN[n][j] = (4 * l[n] - 1) * g[n][j];
    for (int k = 0; k < 6; ++k) {
        const int a = EDGE[k][0], b = EDGE[k][1];
        for (int j = 0; j < 3; ++j) dN[4 + k][j] = 4 * (l[a] * g[b][j] + l[b] * g[a][j]);
    }
}

// The same at Gauss point q.
inline void shapeGradients(const double (*g)[3], int q, double (*dN)[3]) {
    double l[4] = {FAR, FAR, FAR, FAR};
    l[q] = NEAR;
    shapeGradients(g, l, dN);
}

inline void gather(const double (*dN)[3], const double (*u)[3], double *H) {
    for (int i = 0; i < 9; ++i) H[i] = 0;
    for (int n = 0; n < 10; ++n)
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) H[3 * i + j] += u[n][i] * dN[n][j];
}

// The elastic part of a change dH of the gradient, with the share m of its volumetric part from the element's mean `tr`.
inline void hooke(const Law &law, double share, const double *dH, double tr, double *P) {
    const double own = dH[0] + dH[4] + dH[8];
    const double volume = law.K * ((1 - share) * own + share * tr) - 2 * law.G / 3 * own;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) P[3 * i + j] = law.G * (dH[3 * i + j] + dH[3 * j + i]) + (i == j ? volume : 0);
}

// One element: forces f (10 x 3) and the new states of its four points; with q (10 x 3) also what the elastic stiffness
// does not know of the change since the old state:
//   (27) q = f(u) - f(u_old) - K_e (u - u_old)
// Returns the number of points that failed.
inline int element(const Law &law, double share, bool finite, const double (*x)[3], const double (*uOld)[3], const double (*u)[3],
                   const double *old, double *now, double (*f)[3], double (*rest)[3]) {
    double g[4][3], dN[4][10][3], c[4][9], cOld[4][9], H[4][9], Hold[4][9], J[4], Jold[4];
    double theta = 0, thetaOld = 0, trace = 0;
    const double volume = barycentric(x, g);
    int failed = 0;
    for (int q = 0; q < 4; ++q) {
        shapeGradients(g, q, dN[q]);
        gather(dN[q], uOld, Hold[q]);
        gather(dN[q], u, H[q]);
        failed += !updatePoint(law, finite, Hold[q], H[q], old + STATE * q, now + STATE * q);
        double F[9];
        for (int i = 0; i < 9; ++i) F[i] = (finite ? Hold[q][i] : 0) + (i % 4 == 0);
        Jold[q] = cofactors(F, cOld[q]);
        for (int i = 0; i < 9; ++i) F[i] = (finite ? H[q][i] : 0) + (i % 4 == 0);
        J[q] = cofactors(F, c[q]);
        if (!finite) J[q] = 1 + H[q][0] + H[q][4] + H[q][8], Jold[q] = 1 + Hold[q][0] + Hold[q][4] + Hold[q][8];
        failed += !(J[q] > 0 && Jold[q] > 0);
        theta += 0.25 * J[q];
        thetaOld += 0.25 * Jold[q];
        for (int i = 0; i < 9; i += 4) trace += 0.25 * (H[q][i] - Hold[q][i]);
    }
    for (int n = 0; n < 10; ++n)
        for (int i = 0; i < 3; ++i) {
            f[n][i] = 0;
            if (rest) rest[n][i] = 0;
        }
    if (failed) return failed;
    auto scatter = [&](int q, const double *P, double (*to)[3]) {
        for (int n = 0; n < 10; ++n)
            for (int i = 0; i < 3; ++i)
                to[n][i] += 0.25 * volume * (P[3 * i] * dN[q][n][0] + P[3 * i + 1] * dN[q][n][1] + P[3 * i + 2] * dN[q][n][2]);
    };
    for (int q = 0; q < 4; ++q) {
        const double *s0 = old + STATE * q;
        double *s = now + STATE * q, P[9];
        if (share > 0) {
            const double own = finite ? std::log(J[q] / Jold[q]) : J[q] - Jold[q];
            const double mean = finite ? std::log(theta / thetaOld) : theta - thetaOld;
            const double shift = law.K * ((1 - share) * own + share * mean) + (s0[0] + s0[1] + s0[2] - s[0] - s[1] - s[2]) / 3;
            for (int i = 0; i < 3; ++i) s[i] += shift;
        }
        firstPiola(s, c[q], P);
        scatter(q, P, f);
        if (!rest) continue;
        double before[9], linear[9], d[9];
        for (int i = 0; i < 9; ++i) d[i] = H[q][i] - Hold[q][i];
        firstPiola(s0, cOld[q], before);
        hooke(law, share, d, trace, linear);
        for (int i = 0; i < 9; ++i) P[i] -= before[i] + linear[i];
        scatter(q, P, rest);
    }
    return 0;
}

} // namespace block

#endif
