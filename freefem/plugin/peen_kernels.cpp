// Gauss-point kernels of the peening target, called from FreeFEM scripts; built by `make plugin` (ff-c++).
//
// The laws and their equations (1)-(7) stand in hardening.hpp, the return mapping and its tangent (8)-(15) in
// return_map.hpp.  The same numbers come from the pure-script twins in freefem/lib (points_axisym_script.idp,
// points_small_script.idp); tests/target compares them.

#include "ff++.hpp"
#include "AFunction_ext.hpp"
#include "return_map.hpp"

namespace {

// Small strain, three dimensions, isothermal and without a rate term.  strain (nq x 6, tensor shear): increment since
// stateOld (nq x 19: sigma, p, a1, a2); stateNew is written.
// Returns the number of points whose return mapping found no root (0 = all well).
long peenSmall(KN<double> *const &lawArray, KNM<double> *const &strain, KNM<double> *const &stateOld,
               KNM<double> *const &stateNew) {
    const int N = 6, S = 3 * N + 1;
    ffassert(Law::complete(*lawArray));
    Law law(*lawArray);
    law.heat = 0;
    const long nq = strain->N();
    ffassert(strain->M() == N && stateOld->N() == nq && stateOld->M() == S && stateNew->N() == nq && stateNew->M() == S);
    long failed = 0;
    double old[S], now[S];
    for (int k = 0; k < nq; ++k) {
        for (int i = 0; i < S; ++i) old[i] = (*stateOld)(k, i);
        const double trace = (*strain)(k, 0) + (*strain)(k, 1) + (*strain)(k, 2);
        for (int i = 0; i < N; ++i)
            now[i] = old[i] + 2 * law.G * (*strain)(k, i) + (i < 3 ? (law.K - 2 * law.G / 3) * trace : 0);
        ReturnMap<N> map;
        double cold = 0;
        if (!map.solve(law, 0, old, now, cold)) ++failed;
        for (int i = 0; i < S; ++i) (*stateNew)(k, i) = now[i];
    }
    return failed;
}

// Planar rotation of a symmetric tensor (rr, zz, tt, rz): t' = R t R^T, R = [[c, s], [-s, c]].
void rotate(double *t, double c, double s) {
    const double rr = t[0], zz = t[1], rz = t[3];
    t[0] = c * c * rr + s * s * zz + 2 * c * s * rz;
    t[1] = s * s * rr + c * c * zz - 2 * c * s * rz;
    t[3] = (c * c - s * s) * rz + c * s * (zz - rr);
}

// Finite strain, axisymmetric, referred to the undeformed mesh; dt: length of the step, 0 without a rate term.
//   grad  (nq x 10): displacement gradients (rr, rz, zr, zz, tt), old then new
//   state (nq x 14): sigma (4), p, a1 (4), a2 (4), tau
//   out   (nq x 30): first Piola stress P (rr, rz, zr, zz, tt), then dP_a/dF_b, column 5 + 5 a + b
// Midpoint rule (Hughes-Winget), the rotation exact, so that a rigid one turns stress and backstress and no more:
//   (16) h = grad(du) F_mid^-1,  F_mid = I + (grad old + grad new)/2,   de = sym h
//   (17) tan(angle/2) = (h_rz - h_zr)/4;  stress and backstresses turn by this angle
//   (18) trial stress = turned stress + C : de, return mapping (8)-(11);  P = det F sigma F^-T
// Its exact derivative along each entry E_b of F, A x A the increments of A along it:
//   (19) dh = (I - h/2) E_b F_mid^-1,   dangle = (dh_rz - dh_zr)/(2 (1 + tan^2)),
//        a turned tensor moves by (2 t_rz, -2 t_rz, 0, t_zz - t_rr) dangle
//   (20) dP = det F [ tr(F^-1 E_b) sigma + dsigma - sigma F^-T E_b^T ] F^-T
long peenAxisym(KN<double> *const &lawArray, const double &dt, KNM<double> *const &grad, KNM<double> *const &stateOld,
                KNM<double> *const &stateNew, KNM<double> *const &out) {
    const int N = 4, S = 3 * N + 2;
    ffassert(Law::complete(*lawArray));
    const Law law(*lawArray);
    const long nq = grad->N();
    ffassert(grad->M() == 10 && stateOld->M() == S && stateNew->M() == S && out->M() == 30 && stateNew->N() == nq
             && stateOld->N() == nq && out->N() == nq);
    static const int row[5] = {0, 0, 1, 1, 2}, col[5] = {0, 1, 0, 1, 2}; // rr, rz, zr, zz, tt
    long failed = 0;
    double old[S], now[S];
    for (int k = 0; k < nq; ++k) {
        double d[5], M[5], F[5]; // increment, F_mid, F
        for (int i = 0; i < 5; ++i) {
            const double one = row[i] == col[i], a = (*grad)(k, i), b = (*grad)(k, 5 + i);
            d[i] = b - a, M[i] = one + 0.5 * (a + b), F[i] = one + b;
        }
        const double jm = M[0] * M[3] - M[1] * M[2], j2 = F[0] * F[3] - F[1] * F[2];
        if (!(jm > 0 && j2 > 0 && M[4] > 0 && F[4] > 0)) { ++failed; continue; }
        auto overMid = [&](const double *x, double *h) { // x F_mid^-1
            h[0] = (x[0] * M[3] - x[1] * M[2]) / jm, h[1] = (x[1] * M[0] - x[0] * M[1]) / jm;
            h[2] = (x[2] * M[3] - x[3] * M[2]) / jm, h[3] = (x[3] * M[0] - x[2] * M[1]) / jm;
            h[4] = x[4] / M[4];
        };
        auto hooke = [&](const double *h, double *t) { // t += C : sym h
            const double volume = (law.K - 2 * law.G / 3) * (h[0] + h[3] + h[4]);
            t[0] += 2 * law.G * h[0] + volume, t[1] += 2 * law.G * h[3] + volume;
            t[2] += 2 * law.G * h[4] + volume, t[3] += law.G * (h[1] + h[2]);
        };
        double h[5];
        overMid(d, h);
        const double w = 0.25 * (h[1] - h[2]), c = (1 - w * w) / (1 + w * w), s = 2 * w / (1 + w * w);
        for (int i = 0; i < S; ++i) old[i] = (*stateOld)(k, i);
        for (int o : {0, N + 1, 2 * N + 1}) rotate(old + o, c, s);
        for (int i = 0; i < S; ++i) now[i] = old[i];
        hooke(h, now);
        ReturnMap<N> map;
        if (!map.solve(law, dt, old, now, now[S - 1])) ++failed;
        for (int i = 0; i < S; ++i) (*stateNew)(k, i) = now[i];

        const double J = j2 * F[4], inv[5] = {F[3] / j2, -F[1] / j2, -F[2] / j2, F[0] / j2, 1 / F[4]}; // F^-1
        auto timesInverse = [&](const double *x, double *y) {                                           // x F^-T
            y[0] = x[0] * inv[0] + x[1] * inv[1], y[1] = x[0] * inv[2] + x[1] * inv[3];
            y[2] = x[2] * inv[0] + x[3] * inv[1], y[3] = x[2] * inv[2] + x[3] * inv[3];
            y[4] = x[4] * inv[4];
        };
        const double sigma[5] = {now[0], now[3], now[3], now[1], now[2]};
        double P[5];
        timesInverse(sigma, P);
        for (int a = 0; a < 5; ++a) (*out)(k, a) = J * P[a];

        for (int b = 0; b < 5; ++b) {
            double e[5] = {}, dh[5], ds[N] = {}, da[2 * N], t[5], dP[5];
            for (int i = 0; i < 5; ++i) // (I - h/2) E_b
                if (col[i] == col[b])
                    e[i] = (row[i] == row[b]) - 0.5 * (b == 4 ? h[4] : h[2 * row[i] + row[b]]);
            overMid(e, dh);
            const double turn = (dh[1] - dh[2]) / (2 * (1 + w * w));
            auto turned = [&](const double *x, double *y) {
                y[0] = 2 * x[3] * turn, y[1] = -2 * x[3] * turn, y[2] = 0, y[3] = (x[1] - x[0]) * turn;
            };
            turned(old, ds);
            turned(old + N + 1, da);
            turned(old + 2 * N + 1, da + N);
            hooke(dh, ds);
            const double mean = (ds[0] + ds[1] + ds[2]) / 3;
            for (int i = 0; i < 3; ++i) ds[i] -= mean;
            map.differentiate(law, ds, da);
            for (int i = 0; i < 3; ++i) ds[i] += mean;
            const double expand = inv[b == 1 ? 2 : b == 2 ? 1 : b]; // tr(F^-1 E_b), the entry (col b, row b) of F^-1
            t[0] = ds[0], t[1] = t[2] = ds[3], t[3] = ds[1], t[4] = ds[2];
            for (int i = 0; i < 5; ++i) {
                t[i] += expand * sigma[i]; // and (sigma F^-T) E_b^T has the column col b of the first in its row b
                if (col[i] == row[b]) t[i] -= P[b == 4 ? 4 : 2 * row[i] + col[b]];
            }
            timesInverse(t, dP);
            for (int a = 0; a < 5; ++a) (*out)(k, 5 + 5 * a + b) = J * dP[a];
        }
    }
    return failed;
}

void init() {
    Global.Add("peenSmall", "(",
               new OneOperator4_<long, KN<double> *, KNM<double> *, KNM<double> *, KNM<double> *>(peenSmall));
    Global.Add("peenAxisym", "(",
               new OneOperator6_<long, KN<double> *, double, KNM<double> *, KNM<double> *, KNM<double> *, KNM<double> *>(
                   peenAxisym));
}

} // namespace

LOADFUNC(init)
