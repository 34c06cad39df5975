// Anderson acceleration of a fixed point u = G(u): the twin of freefem/lib/anderson.idp for long vectors.
//   (29) f_k = G(u_k) - u_k;  gamma = argmin |f_k - sum_i gamma_i df_i|,  u_(k+1) = G(u_k) - sum_i gamma_i dG_i
// over the last `depth` differences df, dG; normal equations, of which each step adds one row and column.
#ifndef PEEN_ANDERSON_HPP
#define PEEN_ANDERSON_HPP

#include "contact_set.hpp"

class Anderson {
  public:
    void reset() { count = 0; }

    void step(int depth, long n, double *u, const double *g) {
        if (count == 0 || long(f.size()) != n) {
            count = 0;
            df.assign(depth, std::vector<double>(n));
            dG = df;
            gram.assign(size_t(depth) * depth, 0);
            f.resize(n);
            G.resize(n);
        }
        if (count > 0) {
            const int c = (count - 1) % depth, m = std::min(count, depth);
            for (long i = 0; i < n; ++i) {
                const double now = g[i] - u[i];
                df[c][i] = now - f[i], dG[c][i] = g[i] - G[i];
                f[i] = now, G[i] = g[i];
            }
            for (int i = 0; i < m; ++i) gram[c * depth + i] = gram[i * depth + c] = dot(df[c], df[i]);
            std::vector<double> M(size_t(m) * m), gamma(m);
            double trace = 0;
            for (int i = 0; i < m; ++i) trace += gram[i * depth + i];
            for (int i = 0; i < m; ++i) {
                gamma[i] = dot(df[i], f);
                for (int j = 0; j < m; ++j) M[i * m + j] = gram[i * depth + j] + (i == j ? 1e-13 * trace + 1e-300 : 0);
            }
            const bool solved = choleskySolve(M, m, gamma);
            for (long i = 0; i < n; ++i) u[i] = g[i];
            if (solved)
                for (int k = 0; k < m; ++k)
                    for (long i = 0; i < n; ++i) u[i] -= gamma[k] * dG[k][i];
        } else
            for (long i = 0; i < n; ++i) f[i] = g[i] - u[i], G[i] = u[i] = g[i];
        ++count;
    }

  private:
    int count = 0;
    std::vector<std::vector<double>> df, dG;
    std::vector<double> f, G, gram;

    static double dot(const std::vector<double> &a, const std::vector<double> &b) {
        double s[4] = {0, 0, 0, 0};
        const size_t n = a.size() / 4 * 4;
        for (size_t i = 0; i < n; i += 4)
            for (int k = 0; k < 4; ++k) s[k] += a[i + k] * b[i + k];
        for (size_t i = n; i < a.size(); ++i) s[0] += a[i] * b[i];
        return s[0] + s[1] + s[2] + s[3];
    }
};

#endif
