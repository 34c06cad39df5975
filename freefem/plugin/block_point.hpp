// One Gauss point of a three-dimensional solid at finite strain, referred to the undeformed mesh.
//
// H, H_old: displacement gradients (rows xx xy xz yx .. zz) at the end and the start of the step; state: sigma (6: xx yy
// zz xy yz zx), p, a1 (6), a2 (6).  The return mapping, (8)-(11), stands in return_map.hpp.
//   (21) h = (H - H_old) F_mid^-1,  F_mid = 1 + (H + H_old)/2,   de = sym h              midpoint rule
//   (22) psi = half the axial vector of skew h,  Q = 1 + 2 (psi x + psi x psi x) / (1 + |psi|^2)      Cayley: a rotation
//   (23) stress and backstresses turned, t -> Q t Q^T;  trial stress = turned stress + C : de, then (8)-(11)
//   (24) P = sigma cof F,  cof F = det F F^-T                                     first Piola stress: the pull-back
// At small strain h = H - H_old, nothing turns, and P = sigma.
// A rigid rotation in one step turns the state and does no more: h of it is skew, and Q is that very rotation.
#ifndef PEEN_BLOCK_POINT_HPP
#define PEEN_BLOCK_POINT_HPP

#include "return_map.hpp"

namespace block {

const int STATE = 19;

// c = cofactors of a; returns det a.
inline double cofactors(const double *a, double *c) {
    c[0] = a[4] * a[8] - a[5] * a[7], c[1] = a[5] * a[6] - a[3] * a[8], c[2] = a[3] * a[7] - a[4] * a[6];
    c[3] = a[2] * a[7] - a[1] * a[8], c[4] = a[0] * a[8] - a[2] * a[6], c[5] = a[1] * a[6] - a[0] * a[7];
    c[6] = a[1] * a[5] - a[2] * a[4], c[7] = a[2] * a[3] - a[0] * a[5], c[8] = a[0] * a[4] - a[1] * a[3];
    return a[0] * c[0] + a[1] * c[1] + a[2] * c[2];
}

// t (xx yy zz xy yz zx) becomes Q t Q^T.
inline void turn(const double *Q, double *t) {
    const double full[9] = {t[0], t[3], t[5], t[3], t[1], t[4], t[5], t[4], t[2]};
    double m[9];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            m[3 * i + j] = Q[3 * i] * full[j] + Q[3 * i + 1] * full[3 + j] + Q[3 * i + 2] * full[6 + j];
    static const int row[6] = {0, 1, 2, 0, 1, 2}, col[6] = {0, 1, 2, 1, 2, 0};
    for (int k = 0; k < 6; ++k) {
        const double *a = m + 3 * row[k], *b = Q + 3 * col[k];
        t[k] = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    }
}

// (21)-(23): `now` from `old`, both STATE long.  False: the point turned inside out, or the mapping found no root.
inline bool updatePoint(const Law &law, bool finite, const double *Hold, const double *H, const double *old, double *now) {
    double d[9], middle[9], c[9], h[9], from[STATE];
    for (int i = 0; i < 9; ++i) {
        d[i] = H[i] - Hold[i];
        middle[i] = 0.5 * (H[i] + Hold[i]) + (i % 4 == 0);
    }
    for (int i = 0; i < STATE; ++i) from[i] = old[i];
    if (finite) {
        const double det = cofactors(middle, c);
        if (!(det > 0)) return false;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                h[3 * i + j] = (d[3 * i] * c[3 * j] + d[3 * i + 1] * c[3 * j + 1] + d[3 * i + 2] * c[3 * j + 2]) / det;
        const double x = 0.25 * (h[7] - h[5]), y = 0.25 * (h[2] - h[6]), z = 0.25 * (h[3] - h[1]);
        const double f = 2 / (1 + x * x + y * y + z * z);
        const double Q[9] = {1 - f * (y * y + z * z), f * (x * y - z), f * (x * z + y),
                             f * (x * y + z), 1 - f * (x * x + z * z), f * (y * z - x),
                             f * (x * z - y), f * (y * z + x), 1 - f * (x * x + y * y)};
        turn(Q, from);
        for (int k = 0; k < 2; ++k)
            if (law.X[k] != 0) turn(Q, from + 7 + 6 * k);
    } else
        for (int i = 0; i < 9; ++i) h[i] = d[i];
    for (int i = 0; i < STATE; ++i) now[i] = from[i];
    const double volume = (law.K - 2 * law.G / 3) * (h[0] + h[4] + h[8]);
    for (int i = 0; i < 3; ++i) now[i] += 2 * law.G * h[4 * i] + volume;
    now[3] += law.G * (h[1] + h[3]);
    now[4] += law.G * (h[5] + h[7]);
    now[5] += law.G * (h[6] + h[2]);
    ReturnMap<6> map;
    double cold = 0;
    return map.solve(law, 0, from, now, cold);
}

// (24) from the stress s (6) and cof F.
inline void firstPiola(const double *s, const double *c, double *P) {
    const double full[9] = {s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2]};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            P[3 * i + j] = full[3 * i] * c[j] + full[3 * i + 1] * c[3 + j] + full[3 * i + 2] * c[6 + j];
}

} // namespace block

#endif
