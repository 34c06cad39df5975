// Gauss-point kernels of the peening target, called from FreeFEM scripts; built by `make plugin` (ff-c++).
//
// The same numbers come from the pure-script twins in freefem/lib (points_axisym_script.idp,
// points_small_script.idp); tests/target compares them.  One return mapping serves both kernels.
//
// Law (11 reals, stresses in MPa):  E nu | A B n | Q b | X1 g1 X2 g2
//   isotropic part      R(p)   = A + B p^n + Q (1 - exp(-b p))
//   backstress i        da_i   = (2/3) X_i g_i dep - g_i a_i dp      (Armstrong-Frederick, q(a_i) -> X_i)
//   yield               q(s - a1 - a2) = R(p),  q(x) = sqrt(3/2 x:x),  dep = (3/2) n dp,  n = (s - a)/q
//
// Return mapping, direction n constant over the step, so that backstresses integrate exactly:
//   (1) e_i   = exp(-g_i dp),  a_i' = e_i a_i + X_i (1 - e_i) n
//   (2) T(dp) = s_trial - e_1 a_1 - e_2 a_2
//   (3) q(T)  = R(p + dp) + 3 G dp + X_1 (1 - e_1) + X_2 (1 - e_2)      (one bracketed Newton in dp)
//   (4) n = T / q(T),  s' = s_trial - 3 G dp n,  p' = p + dp
//
// Symmetric tensors: axisymmetric (rr, zz, tt, rz), three-dimensional (xx, yy, zz, xy, yz, zx); shear
// entries are tensor components.  State per point: sigma (N), p (1), a1 (N), a2 (N).

#include "ff++.hpp"
#include "AFunction_ext.hpp"
#include <cmath>

namespace {

struct Law {
    double E, nu, A, B, n, Q, b, X[2], g[2], G, K;
    explicit Law(const KN<double> &v)
        : E(v[0]), nu(v[1]), A(v[2]), B(v[3]), n(v[4]), Q(v[5]), b(v[6]), X{v[7], v[9]}, g{v[8], v[10]},
          G(E / (2 * (1 + nu))), K(E / (3 * (1 - 2 * nu))) {}
    double isotropic(double p) const {
        return A + (B != 0 && p > 0 ? B * std::pow(p, n) : 0.) + (Q != 0 ? Q * (1 - std::exp(-b * p)) : 0.);
    }
    double isotropicSlope(double p) const {
        return (B != 0 && p > 0 ? B * n * std::pow(p, n - 1) : 0.) + (Q != 0 ? Q * b * std::exp(-b * p) : 0.);
    }
};

template <int N> double mises(const double *t) {
    double s = t[0] * t[0] + t[1] * t[1] + t[2] * t[2];
    for (int i = 3; i < N; ++i) s += 2 * t[i] * t[i];
    return std::sqrt(1.5 * s);
}

// What the tangent needs of a plastic step.  It leaves out how a backstress turns the direction n: exact without
// backstresses, close with them.
struct Step {
    double dp = 0, slope = 0, q = 0; // slope: d/d(dp) of (3), right side minus left side, without its 3 G; q: q(T)
    double n[6] = {0, 0, 0, 0, 0, 0};
};

const int maxNewton = 60;

// Trial stress in `now[0..N)`, old p and backstresses (already rotated) in `old`; fills `now`. False: no root found.
template <int N> bool returnMap(const Law &law, const double *old, double *now, Step &step) {
    const double pressure = (now[0] + now[1] + now[2]) / 3, p0 = old[N];
    const double *a0 = old + N + 1;
    double s[N], T[N];
    for (int i = 0; i < N; ++i) {
        s[i] = now[i] - (i < 3 ? pressure : 0);
        T[i] = s[i] - a0[i] - a0[N + i];
    }
    now[N] = p0;
    for (int i = 0; i < 2 * N; ++i) now[N + 1 + i] = a0[i];
    step = Step();
    const double q0 = mises<N>(T);
    if (q0 <= law.isotropic(p0) * (1 + 1e-9)) return true; // a state left on the surface is not yielding anew
    double lo = 0, hi = (mises<N>(s) + law.X[0] + law.X[1]) / (3 * law.G), dp = 0, e[2] = {1, 1}, q = q0;
    dp = std::min(hi, (q0 - law.isotropic(p0)) / (3 * law.G + law.isotropicSlope(std::max(p0, 1e-6))
                                                + law.X[0] * law.g[0] + law.X[1] * law.g[1]));
    bool found = false;
    for (int it = 0; it < maxNewton && !found; ++it) {
        double rhs = law.isotropic(p0 + dp) + 3 * law.G * dp, slope = law.isotropicSlope(p0 + dp), Ta = 0;
        for (int i = 0; i < N; ++i) T[i] = s[i];
        double dT[N] = {};
        for (int k = 0; k < 2; ++k) {
            e[k] = law.X[k] != 0 ? std::exp(-law.g[k] * dp) : 0;
            if (law.X[k] == 0) continue;
            rhs += law.X[k] * (1 - e[k]);
            slope += law.X[k] * law.g[k] * e[k];
            for (int i = 0; i < N; ++i) {
                T[i] -= e[k] * a0[k * N + i];
                dT[i] += law.g[k] * e[k] * a0[k * N + i];
            }
        }
        q = mises<N>(T);
        for (int i = 0; i < N; ++i) Ta += (i < 3 ? 1. : 2.) * T[i] * dT[i];
        const double f = q - rhs, df = 1.5 * Ta / q - slope - 3 * law.G;
        step.slope = slope - 1.5 * Ta / q;
        if (f > 0) lo = dp; else hi = dp;
        if (std::fabs(f) <= 1e-12 * (law.A + law.E * 1e-4) || hi - lo <= 1e-16 * (1 + hi)) { found = true; break; }
        double next = dp - f / df;
        if (!(next > lo && next < hi)) next = 0.5 * (lo + hi);
        dp = next;
    }
    if (!found) return false;
    step.dp = dp;
    step.q = q;
    for (int i = 0; i < N; ++i) {
        step.n[i] = T[i] / q;
        now[i] = s[i] - 3 * law.G * dp * step.n[i] + (i < 3 ? pressure : 0);
        for (int k = 0; k < 2; ++k)
            now[N + 1 + k * N + i] = law.X[k] != 0 ? e[k] * a0[k * N + i] + law.X[k] * (1 - e[k]) * step.n[i] : 0;
    }
    now[N] = p0 + dp;
    return true;
}

// Small strain, three dimensions.  strain (nq x 6, tensor shear): increment since stateOld; stateNew is written.
// Returns the number of points whose return mapping found no root (0 = all well).
long peenSmall(KN<double> *const &lawArray, KNM<double> *const &strain, KNM<double> *const &stateOld,
               KNM<double> *const &stateNew) {
    const int N = 6, S = 3 * N + 1;
    const Law law(*lawArray);
    const long nq = strain->N();
    ffassert(strain->M() == N && stateOld->N() == nq && stateOld->M() == S && stateNew->N() == nq && stateNew->M() == S);
    long failed = 0;
    double old[S], now[S];
    Step step;
    for (int k = 0; k < nq; ++k) {
        for (int i = 0; i < S; ++i) old[i] = (*stateOld)(k, i);
        const double trace = (*strain)(k, 0) + (*strain)(k, 1) + (*strain)(k, 2);
        for (int i = 0; i < N; ++i)
            now[i] = old[i] + 2 * law.G * (*strain)(k, i) + (i < 3 ? (law.K - 2 * law.G / 3) * trace : 0);
        if (!returnMap<N>(law, old, now, step)) ++failed;
        for (int i = 0; i < S; ++i) (*stateNew)(k, i) = now[i];
    }
    return failed;
}

// Finite strain, axisymmetric, referred to the undeformed mesh.
//   grad (nq x 10): displacement gradients (rr, rz, zr, zz, tt), old then new
//   out  (nq x 20): first Piola stress P (rr, rz, zr, zz, tt), then the upper triangle of dP/dF in that order
// Midpoint rule (Hughes-Winget): h = grad(du) F_mid^-1, de = sym h, w = skew h, stress and backstresses
// rotated by the exact planar rotation of w; P = det F sigma F^-T.
long peenAxisym(KN<double> *const &lawArray, const double &dt, KNM<double> *const &grad, KNM<double> *const &stateOld,
                KNM<double> *const &stateNew, KNM<double> *const &out) {
    const int N = 4, S = 3 * N + 2;
    const Law law(*lawArray);
    const long nq = grad->N();
    (void)dt;
    ffassert(grad->M() == 10 && stateOld->M() == S && stateNew->M() == S && out->M() == 20 && stateNew->N() == nq);
    long failed = 0;
    double old[S], now[S];
    Step step;
    for (int k = 0; k < nq; ++k) {
        double d[5], Fm[5], F[5];
        for (int i = 0; i < 5; ++i) {
            const double one = (i == 0 || i == 3 || i == 4), a = (*grad)(k, i), b = (*grad)(k, 5 + i);
            d[i] = b - a, Fm[i] = one + 0.5 * (a + b), F[i] = one + b;
        }
        const double jm = Fm[0] * Fm[3] - Fm[1] * Fm[2], j2 = F[0] * F[3] - F[1] * F[2];
        if (!(jm > 0 && j2 > 0 && Fm[4] > 0 && F[4] > 0)) { ++failed; continue; }
        const double hrr = (d[0] * Fm[3] - d[1] * Fm[2]) / jm, hrz = (d[1] * Fm[0] - d[0] * Fm[1]) / jm,
                     hzr = (d[2] * Fm[3] - d[3] * Fm[2]) / jm, hzz = (d[3] * Fm[0] - d[2] * Fm[1]) / jm,
                     htt = d[4] / Fm[4];
        const double de[4] = {hrr, hzz, htt, 0.5 * (hrz + hzr)}, w = 0.25 * (hrz - hzr), // tan of half the angle
                     c = (1 - w * w) / (1 + w * w), s = 2 * w / (1 + w * w);
        for (int i = 0; i < S; ++i) old[i] = (*stateOld)(k, i);
        for (int o : {0, N + 1, 2 * N + 1}) { // t' = R t R^T, R = [[c, s], [-s, c]]
            const double rr = old[o], zz = old[o + 1], rz = old[o + 3];
            old[o] = c * c * rr + s * s * zz + 2 * c * s * rz;
            old[o + 1] = s * s * rr + c * c * zz - 2 * c * s * rz;
            old[o + 3] = (c * c - s * s) * rz + c * s * (zz - rr);
        }
        const double trace = de[0] + de[1] + de[2];
        for (int i = 0; i < N; ++i)
            now[i] = old[i] + 2 * law.G * de[i] + (i < 3 ? (law.K - 2 * law.G / 3) * trace : 0);
        if (!returnMap<N>(law, old, now, step)) ++failed;
        now[S - 1] = old[S - 1];
        for (int i = 0; i < S; ++i) (*stateNew)(k, i) = now[i];

        const double J = j2 * F[4];
        const double G[3][3] = {{F[3] / j2, -F[1] / j2, 0}, {-F[2] / j2, F[0] / j2, 0}, {0, 0, 1 / F[4]}}; // F^-1
        const double sig[3][3] = {{now[0], now[3], 0}, {now[3], now[1], 0}, {0, 0, now[2]}};
        static const int ci[5] = {0, 0, 1, 1, 2}, cj[5] = {0, 1, 0, 1, 2};
        for (int a = 0; a < 5; ++a) {
            double P = 0;
            for (int m = 0; m < 3; ++m) P += sig[ci[a]][m] * G[cj[a]][m];
            (*out)(k, a) = J * P;
        }
        // Spatial moduli: algorithmic D, minus the terms that turn a Jaumann rate of Kirchhoff stress into an
        // Oldroyd rate, plus the initial-stress term; then both second indices pulled back to the reference mesh.
        double beta = 1, plastic = 0;
        if (step.dp > 0) {
            beta = 1 - 3 * law.G * step.dp / step.q;
            plastic = 3 * law.G / (3 * law.G + step.slope) - 3 * law.G * step.dp / step.q;
        }
        static const int voigt[3][3] = {{0, 3, -1}, {3, 1, -1}, {-1, -1, 2}};
        auto delta = [](int a, int b) { return a == b ? 1. : 0.; };
        auto direction = [&](int i, int j) { return voigt[i][j] < 0 ? 0. : step.n[voigt[i][j]]; };
        double spatial[5][5];
        for (int a = 0; a < 5; ++a)
            for (int b = 0; b < 5; ++b) {
                const int i = ci[a], j = cj[a], p = ci[b], l = cj[b];
                double D = (law.K - 2 * law.G * beta / 3) * delta(i, j) * delta(p, l)
                           + law.G * beta * (delta(i, p) * delta(j, l) + delta(i, l) * delta(j, p))
                           - 3 * law.G * plastic * direction(i, j) * direction(p, l);
                D -= 0.5 * (delta(i, p) * sig[j][l] + delta(i, l) * sig[j][p] + delta(j, p) * sig[i][l]
                            + delta(j, l) * sig[i][p]);
                spatial[a][b] = D + delta(i, p) * sig[j][l];
            }
        int column = 5;
        for (int a = 0; a < 5; ++a)
            for (int b = a; b < 5; ++b) {
                double sum = 0;
                for (int m = 0; m < 5; ++m) {
                    if (ci[m] != ci[a] || G[cj[a]][cj[m]] == 0) continue;
                    for (int q = 0; q < 5; ++q)
                        if (ci[q] == ci[b]) sum += G[cj[a]][cj[m]] * spatial[m][q] * G[cj[b]][cj[q]];
                }
                (*out)(k, column++) = J * sum;
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
