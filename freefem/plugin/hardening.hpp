// Hardening laws of the target: what an equivalent plastic strain p, its rate and a temperature make of the yield
// stress.  The same equations stand in freefem/lib/law_script.idp under the same numbers.
//
// The law array (stresses in MPa, time in R/(1 m/s), temperatures in K); entries missing at its end are 0:
//    0 E  1 nu | 2 A  3 B  4 n | 5 Q  6 b | 7 X1  8 g1  9 X2  10 g2 | 11 cap | 12 C  13 rate0
//   | 14 m  15 T0  16 Tm  17 heat | 18 k, then p_1 .. p_k, s_1 .. s_k
//
//   (1) Johnson-Cook's curve   H(p) = min(A + B p^n, cap)                      cap = 0: no cap
//   (2) or a table (k > 0)     H(p) = linear through (p_i, s_i), s_1 before the first and s_k beyond the last
//   (3) strain rate            r    = 1 + C ln max(1, (dp/dt) / rate0)         1 in a static step, dt = 0
//   (4) temperature            h    = 1 - (tau / (Tm - T0))^m,  tau = T - T0   between 1 (tau <= 0) and 0 (melt)
//   (5) Voce's part            V(p) = Q (1 - exp(-b p))
//       isotropic flow stress  Y    = H(p) r h + V(p)
//   (6) backstress i (Armstrong-Frederick)   da_i = (2/3) X_i g_i dep - g_i a_i dp,  so that q(a_i) -> X_i
//   (7) adiabatic heating      dtau = heat Y dp,   heat = Taylor-Quinney share / (density specific heat)
//       The work against the backstresses counts as stored; no law of the catalogue has them together with heat.
#ifndef PEEN_HARDENING_HPP
#define PEEN_HARDENING_HPP

#include <algorithm>
#include <cmath>

// Flow stress and its two slopes, of one state.
struct Flow {
    double Y, byStrain, byHeat; // MPa; dY/d(dp) at constant tau; dY/dtau
};

class Law {
  public:
    double E, nu, X[2], g[2], G, K, heat;

    template <class Array> explicit Law(const Array &v) : E(v[0]), nu(v[1]) {
        auto at = [&v](int i) { return i < v.N() ? v[i] : 0.; };
        A = at(2), B = at(3), n = at(4), Q = at(5), b = at(6), cap = at(11), C = at(12), rate0 = at(13);
        X[0] = at(7), g[0] = at(8), X[1] = at(9), g[1] = at(10);
        m = at(14), melt = at(16) - at(15), heat = at(17);
        points = int(at(18));
        strain = points > 0 ? &v[19] : nullptr;
        G = E / (2 * (1 + nu));
        K = E / (3 * (1 - 2 * nu));
    }
    // The array is as long as its table says.
    template <class Array> static bool complete(const Array &v) {
        return v.N() >= 11 && (v.N() < 19 || v.N() >= 19 + 2 * int(v[18]));
    }

    // At the end of a step of length dt that brought the plastic strain to p by dp.
    Flow flow(double p, double dp, double dt, double tau) const {
        double H, dH, r = 1, dr = 0, h = 1, dh = 0;
        curve(p, H, dH);
        if (C != 0 && dp > dt * rate0 && dt > 0) r = 1 + C * std::log(dp / (dt * rate0)), dr = C / dp;
        if (m != 0 && tau > 0) {
            const double x = std::min(1., tau / melt), xm = std::pow(x, m);
            h = 1 - xm;
            dh = x < 1 ? -m * xm / tau : 0;
        }
        const double decay = Q != 0 ? Q * std::exp(-b * p) : 0;
        return {H * r * h + Q - decay, (dH * r + H * dr) * h + b * decay, H * r * dh};
    }

  private:
    double A, B, n, Q, b, cap, C, rate0, m, melt;
    int points;
    const double *strain; // p_1 .. p_k, s_1 .. s_k

    void curve(double p, double &H, double &dH) const {
        dH = 0;
        if (points > 0) {
            const double *s = strain + points;
            const int i = int(std::upper_bound(strain, strain + points, p) - strain); // p_i beyond p
            if (i == 0) { H = s[0]; return; }
            if (i == points) { H = s[points - 1]; return; }
            dH = (s[i] - s[i - 1]) / (strain[i] - strain[i - 1]);
            H = s[i - 1] + dH * (p - strain[i - 1]);
            return;
        }
        const double power = B != 0 && p > 0 ? B * std::pow(p, n) : 0;
        H = A + power;
        if (cap > 0 && H >= cap) H = cap;
        else if (power != 0) dH = n * power / p;
    }
};

#endif
