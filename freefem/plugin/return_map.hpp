// J2 return mapping with any law of hardening.hpp, and how its stress moves with its input: the algorithm's tangent.
//
// Input: deviatoric trial stress s, backstresses a_i (both rotated already), p, tau; q(x) = sqrt(3/2 x:x).  The
// direction n = T/q(T) is constant over the step, so that the backstresses integrate exactly:
//   (8)  e_i = exp(-g_i dp),   a_i' = e_i a_i + X_i (1 - e_i) n,   T(dp) = s - e_1 a_1 - e_2 a_2
//   (9)  Y(dp) = q(T) - 3 G dp - X_1 (1 - e_1) - X_2 (1 - e_2)        the flow stress that equilibrium asks for
//   (10) f(dp) = Y - flow stress(p + dp, dp/dt, tau + heat dp Y) = 0   one bracketed Newton
//   (11) s' = s - 3 G dp n,   p' = p + dp,   tau' = tau + heat dp Y
// Linearised, with D the slope of -Y plus the effective hardening (heat included):
//   (12) D = 3 G + sum g_i e_i (X_i - 3/2 n:a_i) + (dflow/dp + heat Y dflow/dtau) / k,   k = 1 - heat dp dflow/dtau
//   (13) ddp = 3/2 n:(ds - sum e_i da_i) / D
//   (14) dT = ds - sum e_i da_i + sum g_i e_i a_i ddp,   dn = (dT - (3/2 n:dT) n) / q(T)
//   (15) ds' = ds - 3 G (ddp n + dp dn)
// A backstress turns n in (14): with it the tangent is not symmetric.
//
// Symmetric tensors: axisymmetric (rr, zz, tt, rz), three-dimensional (xx, yy, zz, xy, yz, zx); shear entries are
// tensor components.  State of a point: sigma (N), p (1), a1 (N), a2 (N).
#ifndef PEEN_RETURN_MAP_HPP
#define PEEN_RETURN_MAP_HPP

#include "hardening.hpp"

template <int N> double contract(const double *a, const double *b) {
    double sum = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    for (int i = 3; i < N; ++i) sum += 2 * a[i] * b[i];
    return sum;
}
template <int N> double mises(const double *t) { return std::sqrt(1.5 * contract<N>(t, t)); }

template <int N> class ReturnMap {
  public:
    double dp = 0; // 0: the step was elastic

    // Trial stress in now[0..N), rotated old state in `old`; fills `now` and moves tau.  False: no root found.
    bool solve(const Law &law, double dt, const double *old, double *now, double &tau) {
        const double pressure = (now[0] + now[1] + now[2]) / 3, p0 = old[N], tau0 = tau;
        double s[N];
        a = old + N + 1;
        G = law.G;
        for (int i = 0; i < N; ++i) s[i] = now[i] - (i < 3 ? pressure : 0);
        for (int i = N; i < 3 * N + 1; ++i) now[i] = old[i];
        Residual at = residual(law, dt, s, p0, 0, tau0);
        dp = 0;
        const double q0 = q, tolerance = 1e-13 * q0;
        if (at.f <= 1e-9 * at.flow) return true; // a state left on the surface is not yielding anew
        double lo = 0, hi = (mises<N>(s) + law.X[0] + law.X[1]) / (3 * G);
        const Flow start = law.flow(std::max(p0, 1e-6), 0, 0, tau0);
        double x = std::min(hi, at.f / (3 * G + start.byStrain + law.X[0] * law.g[0] + law.X[1] * law.g[1]));
        for (int it = 0;; ++it) {
            if (it == maxNewton) return false;
            at = residual(law, dt, s, p0, x, tau0);
            if (at.f > 0) lo = x; else hi = x;
            if (std::fabs(at.f) <= tolerance || hi - lo <= 1e-16 * (1 + hi)) break;
            const double next = x + at.f / at.slope;
            x = next > lo && next < hi ? next : 0.5 * (lo + hi);
        }
        dp = x;
        D = at.D;
        for (int i = 0; i < N; ++i) {
            n[i] = T[i] / q;
            now[i] = s[i] - 3 * G * dp * n[i] + (i < 3 ? pressure : 0);
            for (int k = 0; k < 2; ++k)
                now[N + 1 + k * N + i] = law.X[k] != 0 ? e[k] * a[k * N + i] + law.X[k] * (1 - e[k]) * n[i] : 0;
        }
        now[N] = p0 + dp;
        tau = tau0 + law.heat * dp * at.Y;
        return true;
    }

    // (13)-(15) after solve(): ds becomes ds'; da: changes of both backstresses.
    void differentiate(const Law &law, double *ds, const double *da) const {
        if (dp == 0) return;
        double dT[N], dn[N];
        for (int i = 0; i < N; ++i) dT[i] = ds[i] - e[0] * da[i] - e[1] * da[N + i];
        const double ddp = 1.5 * contract<N>(n, dT) / D;
        for (int i = 0; i < N; ++i) dT[i] += (law.g[0] * e[0] * a[i] + law.g[1] * e[1] * a[N + i]) * ddp;
        const double dq = 1.5 * contract<N>(n, dT);
        for (int i = 0; i < N; ++i) {
            dn[i] = (dT[i] - dq * n[i]) / q;
            ds[i] -= 3 * G * (ddp * n[i] + dp * dn[i]);
        }
    }

  private:
    static const int maxNewton = 100;
    struct Residual {
        double f, slope, flow, Y, D; // slope: -df/d(dp) = k D
    };
    double G = 0, q = 0, D = 0, e[2] = {0, 0}, T[N], n[N];
    const double *a = nullptr; // the old backstresses

    // (8)-(10) and (12) at dp = x; leaves e, T and q behind.
    Residual residual(const Law &law, double dt, const double *s, double p0, double x, double tau0) {
        double back = 0, Ta = 0;
        for (int i = 0; i < N; ++i) T[i] = s[i];
        for (int k = 0; k < 2; ++k) {
            e[k] = law.X[k] != 0 ? std::exp(-law.g[k] * x) : 0;
            back += law.X[k] * (1 - e[k]);
            for (int i = 0; i < N; ++i) T[i] -= e[k] * a[k * N + i];
        }
        q = mises<N>(T);
        double D = 3 * law.G;
        for (int k = 0; k < 2; ++k)
            if (law.X[k] != 0) D += law.g[k] * e[k] * (law.X[k] - 1.5 * contract<N>(T, a + k * N) / q);
        const double Y = q - 3 * law.G * x - back;
        const Flow flow = law.flow(p0 + x, x, dt, tau0 + law.heat * x * Y);
        const double k = 1 - law.heat * x * flow.byHeat;
        D += (flow.byStrain + law.heat * Y * flow.byHeat) / k;
        return {Y - flow.Y, k * D, flow.Y, Y, D};
    }
};

#endif
